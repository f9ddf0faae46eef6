"""Real cars in the laboratory: the room, its picture, its panels and its page."""
