"""What is measured, over the run."""
