"""A class in one file: saved whole or not at all, opened like a stranger's."""
