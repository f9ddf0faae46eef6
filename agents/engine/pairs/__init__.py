"""Rules that are sums over pairs of agents: eight agents at once, in the order of their cells."""
