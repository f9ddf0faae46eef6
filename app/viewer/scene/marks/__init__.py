"""What is drawn: one thing in each file."""
