"""Flapping flight: one aircraft in its plane of symmetry, its trim, its power and its stability."""
