"""Measured beside published: statistics, verdicts, and claims in words."""
