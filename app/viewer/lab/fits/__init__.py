"""Fits of models to tracks, begun and looked at in the page."""
