"""From where each browser looks."""
