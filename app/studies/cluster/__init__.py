"""Runs on other machines, through Dask: this process plans and keeps, those make runs."""
