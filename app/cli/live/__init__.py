"""The commands `flockscope live ...`."""
