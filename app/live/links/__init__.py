"""How commands reach the cars: one file per kind of link; see docs/car-link.md."""
