"""What a world is asked: how far away surfaces are, what is in sight, where its boundary is."""
