"""The command line: one file for each command, a folder for each command that has commands."""
