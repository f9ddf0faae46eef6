"""Experiments: the tables and figures of papers, as sets of runs to make and to judge."""
