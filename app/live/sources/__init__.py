"""Where poses come from: one file per kind of source, one line for it in `opening.py`."""
