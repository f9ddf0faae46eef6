"""Changes to a world by hand."""
