"""What is measured of a flock: pure functions of arrays, with units and ranges."""
