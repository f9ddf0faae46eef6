"""Who steers agents from outside while a flock runs: a person, a controller in another process."""
