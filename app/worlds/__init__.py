"""Worlds as people see them: pictures and words."""
