"""The commands `flockscope world ...`."""
