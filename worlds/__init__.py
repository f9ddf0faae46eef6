"""Where a flock lives: boxes, edges, layouts."""
