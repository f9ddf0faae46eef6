"""A laboratory in a cell of a notebook."""
