"""The world of a flock: a box with edges, obstacles and a mission, and where worlds come from."""
