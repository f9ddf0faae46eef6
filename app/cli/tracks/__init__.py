"""The commands `flockscope tracks ...`, a file for each that is more than a few lines."""
