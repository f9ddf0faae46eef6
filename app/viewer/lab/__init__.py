"""The flock's page."""
