"""Templates of the loops over agents: all at once, in turn, and by messages that are late."""
