"""A flock in strips along x, each run by a process of its own: the same bits as in one process."""
