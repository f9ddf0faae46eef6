"""The file of a laboratory of cars: its values and their checks."""
