"""Sweeps from the page: what is asked for, the process that makes the runs, and their picture."""
