"""What has been: the last minutes of a live run, recordings and states from files."""
