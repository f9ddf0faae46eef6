"""What moves a flock: its loop, its ticks, changes meanwhile, who comes, is caught, is steered."""
