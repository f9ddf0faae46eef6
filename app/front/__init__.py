"""Serves pages to browsers: what they may ask, send and see, and how fast."""
