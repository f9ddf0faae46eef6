"""Pictures and films of a flock in its world, with legend, scale and caption."""
