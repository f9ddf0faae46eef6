"""The compiled loop that runs a flock: cells, neighbourhood blocks, noise, threads."""
