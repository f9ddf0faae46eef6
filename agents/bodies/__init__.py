"""How agents move: one body per file, and what several of them share."""
