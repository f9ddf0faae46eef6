"""The three-dimensional view in the browser: what of a flock is drawn, and how."""
