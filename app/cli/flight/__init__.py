"""The commands `flockscope flight ...`."""
