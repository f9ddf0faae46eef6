"""What the laboratory measures of a run: numbers, curves, and who does the costly work."""
