"""One rule per file: what an agent decides. `terms` holds what several of them share."""
