"""Agents that learn: a flock as an environment of PettingZoo or Gymnasium, some agents players."""
