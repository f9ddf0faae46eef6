"""What is to be shown: a frame of the flock, and what a person has chosen about the drawing."""
