"""What can be opened: scenes, models in groups, worlds; each a run with the view that shows it."""
