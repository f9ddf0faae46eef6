"""Where the files served to the browser lie."""

from __future__ import annotations

from pathlib import Path


def static_folder() -> Path:
    """The folder `static/` of a checkout, or `app/_data/static` of an installed wheel.

    Raises FileNotFoundError, naming both, if neither is there.
    """
    app = Path(__file__).resolve().parents[2]
    places = (app / "_data" / "static", app.parent / "static")
    for place in places:
        if place.is_dir():
            return place
    raise FileNotFoundError(f"no folder of static files at {places[0]} nor at {places[1]}")
