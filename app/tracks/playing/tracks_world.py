"""The world of tracks: a box around all places, and walls around what one can walk on."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from app.tracks.tracks import Tracks
from worlds.input_error import InputError
from worlds.world import World

MARGIN = 0.05
"""Room around all places, as a share of their longest side."""
LEAST_SIDE = 1e-3
"""Side of a box at least, where everybody stands on one line, as a share of the longest."""
DIGITS = 6
"""Digits that corners of walls keep, of lengths of about 1."""
MOST_LETTERS = 1_000_000
"""Letters of a boundary at most."""
MOST_CORNERS = 20_000
"""Corners of a boundary at most: every agent of a model is kept clear of all of them."""


def world_of_tracks(tracks: Tracks, scale: float = 1.0) -> World:
    """The world that tracks are played in: with open edges, or edges that wrap where they do.

    What is outside the boundary, if the file says one, is solid. `scale`: the tracks' unit in the
    world's lengths. Raises InputError for a boundary that is none.
    """
    low, high = (corner * scale for corner in tracks.extent)
    walkable = None if not tracks.boundary else boundary_area(tracks, scale)
    obstacles: tuple[Any, ...] = ()
    if walkable is not None and tracks.dim == 2:
        from worlds.readers.surround import outside

        low = np.minimum(low, walkable.bounds[:2])
        high = np.maximum(high, walkable.bounds[2:])
        obstacles = tuple(outside(walkable, DIGITS))
    longest = float((high - low).max()) or 1.0
    room = MARGIN * longest if not obstacles else 0.0
    low, high = low - room, high + room
    size = np.maximum(high - low, LEAST_SIDE * longest)
    edges = ["open"] * tracks.dim
    for axis, side in enumerate(tracks.period):
        if side > 0.0:
            low[axis], size[axis], edges[axis] = 0.0, side * scale, "wrap"
    return World(
        name="tracks",
        size=tuple(size.tolist()),
        edges=tuple(edges),
        low=tuple(low.tolist()),
        title=f"Where {tracks.name} was seen",
        obstacles=obstacles,
        source=tracks.name,
    )


def boundary_area(tracks: Tracks, scale: float):
    """What one can walk on, a shapely Polygon or MultiPolygon. Raises InputError."""
    import shapely

    text = tracks.boundary
    if len(text) > MOST_LETTERS:
        raise InputError(
            f"the boundary of {tracks.name} has {len(text)} letters: {MOST_LETTERS} at most"
        )
    try:
        area = shapely.from_wkt(text)
    except shapely.errors.ShapelyError as error:
        why = re.sub(r"\s+", " ", str(error))[:100]
        raise InputError(f"the boundary of {tracks.name} is no WKT: {why}") from None
    if area.geom_type == "GeometryCollection":
        area = shapely.union_all([part for part in area.geoms if part.area > 0.0])
    sound = area.geom_type in ("Polygon", "MultiPolygon") and area.is_valid and area.area > 0.0
    if not sound:
        raise InputError(
            f"the boundary of {tracks.name} is a {area.geom_type} that nobody can walk on: "
            "a valid polygon is needed"
        )
    if shapely.get_num_coordinates(area) > MOST_CORNERS:
        raise InputError(
            f"the boundary of {tracks.name} has {shapely.get_num_coordinates(area)} corners: "
            f"{MOST_CORNERS} at most"
        )
    return shapely.transform(area, lambda places: places * scale)
