"""Trajectories of real animals, people and robots: read, checked, measured, fitted."""
