"""The world, changed by hand."""
