"""The guide to the running model, and what there is to try."""
