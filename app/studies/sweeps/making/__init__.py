"""How one run of a sweep is made, and what is measured of it."""
