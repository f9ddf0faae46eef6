"""The kinds of files that tracks come in, a file for each family, found by what they hold."""
