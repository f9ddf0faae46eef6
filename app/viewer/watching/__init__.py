"""The page of those who watch a laboratory's run: nothing on it changes the run."""
