"""The best values of parameters: a search over runs that are kept as those of a sweep are."""
