"""What the panels of both pages share."""
