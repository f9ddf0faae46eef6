"""Parameters of a model from tracks, with what the tracks can and cannot tell of them."""
