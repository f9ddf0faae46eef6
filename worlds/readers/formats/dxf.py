"""DXF: closed polylines, circles, ellipses, hatches, solids and faces of the model space.

Blocks (INSERT) are opened. Open lines and arcs may be joined or made walls; splines are drawn by
chords if asked. Texts, dimensions, images and points are left out, and counted. Read by ezdxf.

Source: Autodesk, DXF reference, release 2018.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import shapely

from worlds.input_error import InputError
from worlds.plug_ins import demand
from worlds.readers.drawing_contents import DEEPEST, MOST_ITEMS, DrawingContents, Item, demand_file
from worlds.readers.drawn_shapes import (
    ROUNDING,
    DrawnCurve,
    Point,
    Shape,
    StrayPoint,
    area,
    bounds_of,
    circle,
    format_place,
    line,
)

# Closed outlines of DXF entities: bulges become chords, rings of a hatch get their holes.

STEP = 2.0 * math.pi / 128
"""Longest turn of a chord, rad, as the curves of obstacles have it: it leaves its arc by at most
0.0003 of the radius."""
MOST_OUTLINES = 2000
"""Walkable areas of a file, and outlines of a hatch, at most: each is held against each."""
STRAIGHT = 1e-9
"""Bulges up to this are none: the arc leaves its chord by less than a billionth of its length."""


def points_along(vertices: Sequence[tuple[float, float, float]], closed: bool) -> list[Point]:
    """The points of a polyline of (x, y, bulge), its arcs drawn by chords of at most STEP.

    A bulge is the tangent of a quarter of the angle of the arc to the next vertex, positive when it
    turns left. The first point is repeated at the end if the polyline is closed.
    """
    points: list[Point] = []
    count = len(vertices)
    for k, (x, y, bulge) in enumerate(vertices):
        points.append((x, y))
        if abs(bulge) > STRAIGHT and (closed or k < count - 1):
            x1, y1, _ = vertices[(k + 1) % count]
            points += arc((x, y), (x1, y1), bulge)
    if closed and points and points[0] != points[-1]:
        points.append(points[0])
    return points


def arc(start: Point, end: Point, bulge: float) -> list[Point]:
    """The points between the ends of an arc, on it."""
    angle = 4.0 * math.atan(bulge)
    chord_x, chord_y = end[0] - start[0], end[1] - start[1]
    if not math.isfinite(angle) or (chord_x == 0.0 and chord_y == 0.0):
        return []
    offset = (1.0 - bulge * bulge) / (4.0 * bulge)
    centre_x = 0.5 * (start[0] + end[0]) - offset * chord_y
    centre_y = 0.5 * (start[1] + end[1]) + offset * chord_x
    dx, dy = start[0] - centre_x, start[1] - centre_y
    pieces = math.ceil(abs(angle) / STEP)
    turns = [angle * k / pieces for k in range(1, pieces)]
    return [
        (
            centre_x + dx * math.cos(turn) - dy * math.sin(turn),
            centre_y + dx * math.sin(turn) + dy * math.cos(turn),
        )
        for turn in turns
    ]


def nest_rings(rings: Sequence[list[Point]]) -> list[list[list[Point]]]:
    """Rings by the even-odd rule: each outline with the holes that lie directly in it."""
    areas = [shapely.Polygon(ring) for ring in rings]
    containers: list[set[int]] = [set() for _ in areas]
    for inner, outer in within(areas):
        containers[inner].add(outer)
    rings_with_holes = []
    for k, outer_areas in enumerate(containers):
        if len(outer_areas) % 2 == 0:
            holes = [
                j for j, o in enumerate(containers) if k in o and len(o) == len(outer_areas) + 1
            ]
            rings_with_holes.append([rings[k], *(rings[j] for j in holes)])
    return rings_with_holes


def within(areas: Sequence[shapely.Geometry]) -> list[tuple[int, int]]:
    """Pairs of areas of which the first lies in the second, a larger one, by their indices."""
    inner, outer = shapely.STRtree(areas).query(areas, predicate="covered_by")
    size = shapely.area(areas)
    smaller = size[inner] < size[outer]
    return list(zip(inner[smaller].tolist(), outer[smaller].tolist(), strict=True))


DRAWN = ("LWPOLYLINE", "POLYLINE", "CIRCLE", "ELLIPSE", "HATCH", "SOLID", "TRACE", "3DFACE",
         "LINE", "ARC", "SPLINE")  # fmt: skip
LEFT_OUT = ("TEXT", "MTEXT", "ATTRIB", "ATTDEF", "DIMENSION", "ARC_DIMENSION", "LEADER",
            "LARGE_RADIAL_DIMENSION", "MULTILEADER", "MLEADER", "TOLERANCE", "VIEWPORT", "POINT",
            "IMAGE", "PDFUNDERLAY", "DWFUNDERLAY", "DGNUNDERLAY", "WIPEOUT", "OLEFRAME",
            "OLE2FRAME", "ACAD_TABLE", "LIGHT", "SUN", "XLINE", "RAY", "SHAPE")  # fmt: skip
"""What bounds no area and is no line of a plan either."""
METRES = {
    **{1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 8: 2.54e-8},
    **{9: 2.54e-5, 10: 0.9144, 13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0, 21: 1200.0 / 3937.0},
}
"""Metres per unit, by the code of $INSUNITS: inch, foot, mile, mm, cm, m, km, and so on."""
CHORDS = 32
"""Chords of each Bezier curve of a hatch's boundary, which is at most a quarter of a turn."""
FLAT = 1e-9
"""Most difference in height within a face that lies flat, units of the file."""
BLOCKS_LAYER = "0"
"""What a block has on this layer stands on the layer of the INSERT."""


def read_dxf(path: Path) -> DrawingContents:
    """The entities of a DXF file. Raises InputError."""
    demand_file(path)
    demand("ezdxf", "reading a drawing (DXF)", "maps")
    import ezdxf

    items: list[Item] = []
    left_out = Counter[tuple[str, str]]()
    with report_damage(f"{path} is not DXF, or damaged"):
        try:
            document = ezdxf.readfile(path)
        except OSError as error:
            reason = error.strerror or "it is not DXF"
            raise InputError(f"{str(path)!r} cannot be read: {reason}") from None
        for entity, layer, place in entities(document.modelspace(), Budget(path)):
            kind = entity.dxftype()
            if kind in LEFT_OUT:
                left_out[kind, layer] += 1
            else:
                origin = f"{path}, layer {layer!r}, {kind} {place}"
                items.append(Item(layer, kind, partial(shapes, entity, origin)))
        hidden = {
            layer_entry.dxf.name: "frozen" if layer_entry.is_frozen() else "off"
            for layer_entry in document.layers
            if layer_entry.is_frozen() or layer_entry.is_off()
        }
        layers = [
            *(table_entry.dxf.name for table_entry in document.layers),
            *(item.layer for item in items),
            *(layer for _, layer in left_out),
        ]
        unit = METRES.get(document.units)
    return DrawingContents(path, tuple(items), tuple(dict.fromkeys(layers)), unit, hidden, left_out)


class Budget:
    """How many entities may still be looked at: blocks within blocks multiply."""

    def __init__(self, path: Path) -> None:
        self.path, self.remaining = path, MOST_ITEMS

    def spend(self, depth: int) -> None:
        """Count an entity. Raises InputError when there are too many, or it lies too deep."""
        self.remaining -= 1
        if self.remaining < 0:
            raise InputError(f"{self.path} draws more than {MOST_ITEMS} entities, those of blocks "
                          "counted as often as they are inserted: too many to read")  # fmt: skip
        if depth > DEEPEST:
            raise InputError(f"{self.path}: its blocks are nested more than {DEEPEST} deep")


STUMBLES = (ArithmeticError, AttributeError, LookupError, RecursionError, StopIteration, TypeError,
            ValueError)  # fmt: skip
"""What ezdxf raises, beside its own errors, over a file that is damaged."""


@contextmanager
def report_damage(part: str) -> Iterator[None]:
    """Refuse what ezdxf stumbles over, by name: it reads files before it checks them."""
    from ezdxf import DXFError

    try:
        yield
    except InputError:
        raise
    except (DXFError, *STUMBLES) as error:
        raise InputError(f"{part}: {' '.join(str(error).split())}") from None


def entities(
    drawn: Any, budget: Budget, within: str = "", layer: str = "", blocks: tuple[str, ...] = ()
) -> Iterator[tuple[Any, str, str]]:
    """Each entity with its layer and where it is; blocks are opened.

    A block that is missing, in another file, within itself or inserted too often at once stays an
    INSERT, which is not read. Raises InputError when the budget is spent.
    """
    for entity in drawn:
        budget.spend(len(blocks))
        own = entity.dxf.layer if entity.dxf.is_supported("layer") else BLOCKS_LAYER
        own = layer if layer and own == BLOCKS_LAYER else own
        place = within or f"handle {entity.dxf.handle}"
        if entity.dxftype() == "INSERT" and opens(entity, blocks):
            name = entity.dxf.name
            block = within or f"in block {name!r}, inserted by {place}"
            for single in entity.multi_insert() if entity.mcount > 1 else (entity,):
                budget.spend(len(blocks))
                inner = single.virtual_entities()
                yield from entities(inner, budget, block, own, (*blocks, name))
        else:
            yield entity, own, place


def opens(insert: Any, blocks: tuple[str, ...]) -> bool:
    """Whether the block of an INSERT is in this file and not one of those around it."""
    block = insert.block()
    is_here = block is not None and not block.block.is_xref
    return is_here and insert.dxf.name not in blocks and insert.mcount <= MOST_ITEMS


def shapes(entity: Any, origin: str) -> list[Shape]:
    """The shapes of an entity. Raises InputError."""
    if entity.dxftype() not in DRAWN:
        raise InputError(f"{origin}: this kind is not read (read are: {', '.join(DRAWN)})")
    with report_damage(f"{origin}: it is damaged"):
        demand_flat(entity, origin)
        return shapes_of_entity(entity, origin)


def shapes_of_entity(entity: Any, origin: str) -> list[Shape]:
    """The shapes of an entity of a kind that is read. Raises InputError."""
    kind, name = entity.dxftype(), ""  # the reader names it for its layer
    if kind == "HATCH":
        return [area(name, rings, origin) for rings in hatch_rings(entity, origin)]
    if kind in ("SOLID", "TRACE", "3DFACE"):
        corners = list(entity.wcs_vertices(close=True))
        if max(p.z for p in corners) - min(p.z for p in corners) > FLAT:
            raise InputError(f"{origin}: it does not lie flat, so it is no area of the plan")
        return [area(name, [[(p.x, p.y) for p in corners]], origin)]
    if kind == "SPLINE":
        return [DrawnCurve(name, origin, (None, None), partial(chord_ends, entity))]
    if kind == "CIRCLE":
        centre = entity.ocs().to_wcs(entity.dxf.center)
        return [circle(name, (centre.x, centre.y), entity.dxf.radius, origin, is_line=True)]
    points, closed = curve(entity, kind, origin)
    if points and len(set(points)) == 1:
        return [StrayPoint(name, origin, (None, None), points[0])]
    if closed or (len(points) > 3 and points[0] == points[-1]):
        return [area(name, [points], origin, is_line=True)]
    return [line(name, points, origin)]


def chord_ends(spline: Any, tolerance: float) -> Iterator[Point]:
    """Points of a spline, between which chords stay within a tolerance (units of the file) of it.

    Raises InputError.
    """
    with report_damage(f"SPLINE handle {spline.dxf.handle}: it is damaged"):
        for point in spline.flattening(tolerance):
            yield (point.x, point.y)


def curve(entity: Any, kind: str, origin: str) -> tuple[list[Point], bool]:
    """The points of a line, an arc or a polyline, and whether it is closed. Raises InputError."""
    if kind == "LINE":
        return [(p.x, p.y) for p in (entity.dxf.start, entity.dxf.end)], False
    if kind in ("ARC", "ELLIPSE"):
        return arc_points(entity, kind)
    if kind == "LWPOLYLINE":
        closed = entity.closed
        vertices = [(float(x), float(y), float(b)) for x, y, b in entity.get_points("xyb")]
    else:
        if entity.is_polygon_mesh or entity.is_poly_face_mesh:
            raise InputError(f"{origin}: a mesh is not an outline in the plane")
        closed = entity.is_closed
        vertices = [(v.dxf.location.x, v.dxf.location.y, v.dxf.bulge) for v in entity.vertices]
    points = points_along(vertices, closed)
    if kind == "POLYLINE" and entity.is_3d_polyline:
        return points, closed
    ocs = entity.ocs()
    places = [ocs.to_wcs((x, y, 0.0)) for x, y in points]
    return [(p.x, p.y) for p in places], closed


def arc_points(entity: Any, kind: str) -> tuple[list[Point], bool]:
    """Points of an arc or an ellipse, at most STEP apart, and whether it is a full turn."""
    dxf = entity.dxf
    start, end = (
        (math.radians(dxf.start_angle), math.radians(dxf.end_angle))
        if kind == "ARC"
        else (dxf.start_param, dxf.end_param)
    )
    turn = (end - start) % (2.0 * math.pi)
    closed = kind == "ELLIPSE" and math.isclose(turn % (2.0 * math.pi), 0.0, abs_tol=1e-9)
    turn = 2.0 * math.pi if closed else turn
    pieces = max(1, math.ceil(turn / STEP - 1e-9))
    at_angles = [start + turn * k / pieces for k in range(pieces + 1)]
    if kind == "ARC":
        vertices = entity.vertices([math.degrees(angle) for angle in at_angles])
    else:
        vertices = entity.vertices(at_angles)
    points = [(p.x, p.y) for p in vertices]
    return ([*points[:-1], points[0]] if closed else points), closed


def hatch_rings(hatch: Any, origin: str) -> list[list[list[Point]]]:
    """The outlines of a hatch, each with its holes. Raises InputError."""
    from ezdxf import path as paths

    rings = []
    if len(hatch.paths) > MOST_OUTLINES:
        raise InputError(f"{origin}: it has more than {MOST_OUTLINES} boundaries, too many to read")
    for boundary in hatch.paths:
        if hasattr(boundary, "vertices"):
            ocs = hatch.ocs()
            ring = [
                (p.x, p.y)
                for x, y in points_along(boundary.vertices, True)
                for p in [ocs.to_wcs((x, y, 0))]
            ]
        else:
            (outline, *holes) = paths.from_hatch_boundary_path(boundary, hatch.ocs()).sub_paths()
            if holes:
                raise InputError(f"{origin}: a boundary of several pieces is not closed")
            ring = [(p.x, p.y) for p in outline.approximate(CHORDS)]
        ring = remove_spike(ring)
        area("", [ring], origin)
        rings.append(ring)
    if not rings:
        raise InputError(f"{origin}: it has no boundary")
    return nest_rings(rings)


def remove_spike(ring: list[Point]) -> list[Point]:
    """A boundary without the way back that ezdxf adds where its ends differ by rounding."""
    if len(ring) < 5 or ring[0] != ring[-1]:
        return ring
    low_x, low_y, high_x, high_y = bounds_of(ring)
    near = ROUNDING * math.hypot(high_x - low_x, high_y - low_y)
    return [*ring[:-2], ring[0]] if math.dist(ring[-2], ring[0]) <= near else ring


def demand_flat(entity: Any, origin: str) -> None:
    """Refuse what does not lie in a plane parallel to the floor. Raises InputError."""
    tilts = entity.dxf.is_supported("extrusion")
    extrusion = entity.dxf.get("extrusion") if tilts else None
    if extrusion is not None and (abs(extrusion.x) > 1e-9 or abs(extrusion.y) > 1e-9):
        raise InputError(
            f"{origin}: it lies in a tilted plane, extruded along {format_place(tuple(extrusion))}"
        )
