"""Rooms."""

READERS = ()
