"""Sweeps: a file, its plan of cells, what is measured of a run, and the runs of it all."""
