"""Runs on all cores: compiled first, the longest first, with the time still needed."""
