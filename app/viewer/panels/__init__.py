"""The panels around the picture: one file for each."""
