"""The panels around the flock: one file for each."""
