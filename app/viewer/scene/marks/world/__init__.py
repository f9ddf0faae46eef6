"""What does not move: the world, its mission, and the area of real cars."""
