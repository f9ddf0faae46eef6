"""The pictures of experiments, one kind per file."""
