"""Where the experiments' TOML files are: in a checkout or in an installed package."""

from __future__ import annotations

from pathlib import Path

APP = Path(__file__).parents[1]
PLACES = (APP / "_data" / "experiments", APP.parent / "experiments")


def experiments_folder() -> Path:
    """The folder of the TOML files."""
    return next((place for place in PLACES if place.is_dir()), PLACES[-1])
