"""The kinds of files that plans come in, a file for each."""
