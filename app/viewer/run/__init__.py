"""The simulation's thread: what it is told, how fast it goes, and what it leaves to be drawn."""
