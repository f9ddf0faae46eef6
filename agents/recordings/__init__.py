"""Recordings and saved states of flocks: written, judged, and read again."""
