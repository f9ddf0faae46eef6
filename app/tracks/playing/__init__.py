"""Tracks as snapshots of a flock: what the laboratory, films and pictures play."""
