"""Queries: distances to surfaces, lines of sight, crossings and boundary points."""
