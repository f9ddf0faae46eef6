"""What a person takes hold of."""
