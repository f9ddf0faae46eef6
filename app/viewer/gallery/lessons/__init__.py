"""Lessons: scenes with steps."""
