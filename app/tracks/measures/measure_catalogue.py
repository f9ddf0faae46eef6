"""Find the measures: each file of this folder that declares MEASURES brings some."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

import app.tracks.measures as package
from app.tracks.measures.track_measure import TrackMeasure
from worlds.input_error import unknown


@cache
def track_measures() -> dict[str, TrackMeasure]:
    """All measures by name, in the order of their files' names. Raises TypeError for two of one
    name."""
    found: dict[str, TrackMeasure] = {}
    for module in sorted(one.name for one in iter_modules(package.__path__)):
        for measure in getattr(import_module(f"{package.__name__}.{module}"), "MEASURES", ()):
            if measure.name in found:
                raise TypeError(f"there are two measures called {measure.name!r}")
            found[measure.name] = measure
    return found


def choose_measures(names: list[str] | None, origin: str = "--only") -> list[TrackMeasure]:
    """The measures of these names, in this order, each once; all for None. Raises InputError.

    >>> [measure.name for measure in choose_measures(["speed", "speed"])]
    ['speed']
    """
    known = track_measures()
    for name in names or ():
        if name not in known:
            raise unknown("measure", name, known, origin)
    return [known[name] for name in dict.fromkeys(names)] if names else list(known.values())
