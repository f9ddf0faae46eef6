"""A flock as one web page that runs by itself: no server, no network."""
