"""The pages: every block of README and docs, run as it is printed."""
