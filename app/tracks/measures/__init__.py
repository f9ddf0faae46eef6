"""What is measured of tracks; a file that declares MEASURES is a new one, and nothing else is."""
