"""`flockscope sweep`: many runs, over what one chooses, that survive whatever happens."""
