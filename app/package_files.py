"""Folders of files beside this package: in a checkout and installed they lie alike."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

FOLDER = Path(str(files(__package__))).parent
STATIC = FOLDER / "static"
"""What the browser is served."""
EXPERIMENTS = FOLDER / "experiments"
"""One TOML file per table or figure of a paper."""
