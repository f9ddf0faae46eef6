"""Recordings of a laboratory: written, mended after a kill, replayed."""
