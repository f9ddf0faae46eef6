"""Reading a drawing: which layers are solid, which one is walkable, how long a unit is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import shapely

from worlds.obstacles import Obstacle
from worlds.readers.contents import WALKABLE, Contents
from worlds.readers.dxf import read_dxf
from worlds.readers.geojson import read_geojson
from worlds.readers.shapes import Line, Shape
from worlds.readers.wkt import read_wkt
from worlds.refusal import Refusal, unknown

READERS = {".geojson": read_geojson, ".json": read_geojson, ".wkt": read_wkt, ".dxf": read_dxf}
"""By the ending of the file's name."""


@dataclass(frozen=True)
class Geometry:
    """What was taken of a drawing, in metres.

    `walkable` is where agents may be, a shapely polygon or several, or None if the drawing does not
    say. `notes` say what was left out, one line each.
    """

    file: str
    obstacles: tuple[Obstacle, ...]
    walkable: shapely.Geometry | None
    notes: tuple[str, ...]


def read_geometry(
    path: str | Path,
    scale: float | None = None,
    obstacles: Sequence[str] | None = None,
    walkable: str | None = None,
    thickness: float | None = None,
) -> Geometry:
    """The obstacles and the walkable area of a GeoJSON, WKT or DXF file.

    `scale` is metres per unit of the file: 1 for GeoJSON and WKT, and what $INSUNITS says for DXF,
    unless given. `obstacles` are the layers taken as solid, all but the walkable one unless given.
    `walkable` is the layer of the walkable area, "walkable" if there is one of that name.
    `thickness` (m) makes walls of open lines, which are refused without. Raises Refusal with file
    and place for what cannot be used; nothing is repaired.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in READERS:
        raise Refusal(f"{str(path)!r} is not a drawing that is read: {', '.join(READERS)} are")
    if thickness is not None and not (thickness > 0.0 and math.isfinite(thickness)):
        raise Refusal(f"thickness = {thickness:g} m is not a length > 0")
    contents = READERS[ending](path)
    scale = scale_of(contents, scale, ending, path)
    free = layer_named(walkable or WALKABLE, contents, path, demanded=walkable is not None)
    if obstacles is None:
        solid = [layer for layer in contents.layers if layer != free]
    else:
        solid = [layer_named(name, contents, path) or "" for name in obstacles]
        if free in solid:
            raise Refusal(f"layer {free!r} cannot be walkable and solid ({path})")
    made = [
        named(shape, item.layer).obstacle(scale, thickness)
        for item in contents.items
        if item.layer in solid
        for shape in item.read()
    ]
    ground = [
        area_of(shape, scale)
        for item in contents.items
        if item.layer == free
        for shape in item.read()
    ]
    if not made and not ground:
        layers = ", ".join(obstacles or contents.layers)
        raise Refusal(f"{path}: there is nothing on its layers ({layers})")
    if walkable is not None and not ground:
        raise Refusal(f"{path}: there is nothing on the walkable layer {free!r}")
    return Geometry(
        path.name, tuple(made), shapely.union_all(ground) if ground else None, contents.notes
    )


def scale_of(contents: Contents, asked: float | None, ending: str, path: Path) -> float:
    """Metres per unit of the file. Raises Refusal."""
    if asked is not None:
        if not (asked > 0.0 and math.isfinite(asked)):
            raise Refusal(f"scale = {asked:g} is not allowed: metres per unit of the file, > 0")
        return asked
    if ending != ".dxf":
        return 1.0
    if contents.unit is None:
        raise Refusal(f"{path} does not say its unit ($INSUNITS): give a scale, metres per unit")
    return contents.unit


def layer_named(name: str, contents: Contents, path: Path, demanded: bool = True) -> str | None:
    """The layer of a name, in upper or lower case; None or Refusal if there is none."""
    if name in contents.layers:
        return name
    found = [layer for layer in contents.layers if layer.casefold() == name.casefold()]
    if found or not demanded:
        return found[0] if found else None
    raise unknown("layer", name, contents.layers, str(path))


def named(shape: Shape, layer: str) -> Shape:
    """The shape with its layer for a name if it has none."""
    from dataclasses import replace

    return shape if shape.name else replace(shape, name=layer)


def area_of(shape: Shape, scale: float) -> shapely.Geometry:
    """The walkable area of a shape. Raises Refusal for a line."""
    if isinstance(shape, Line):
        raise Refusal(f"{shape.origin}: a walkable area is a polygon, and this is a line")
    return shape.obstacle(scale, None).footprint()
