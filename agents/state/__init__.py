"""The arrays of a flock: how they start, are joined and chosen, who crashed, who is astray."""
