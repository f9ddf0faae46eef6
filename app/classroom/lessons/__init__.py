"""Scenes of lessons: each has a question that is ready to be asked."""
