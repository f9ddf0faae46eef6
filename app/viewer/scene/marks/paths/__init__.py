"""Where agents have been."""
