"""Which word may be said of a set of runs."""
