"""Real cars in the laboratory: the session, its picture, its panels and its page."""
