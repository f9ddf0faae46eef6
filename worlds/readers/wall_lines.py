"""Closed lines that may be walls: made walls of a thickness, or asked about.

A closed outline on a layer of walls is either the wall's own footprint, which is solid, or the line
that the wall runs along, in which people live. The one that holds all others is the second.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import shapely

from worlds.readers.drawn_shapes import DrawnArea, DrawnCircle, DrawnLine, Solid, bounds_of
from worlds.readers.plan_question import PlanChoice, PlanQuestion
from worlds.readers.roles import OBSTACLE, WALL, LayerRole, shown

THICKEST = 1.0
"""Mean thickness up to which a closed line may be a wall's own footprint, m."""
THICK = 0.2
"""Thickness of a wall that a question proposes, m."""


def walls_of(shape: Solid, row: LayerRole, thickness: float | None) -> list[Solid]:
    """A shape of a layer of walls: lines that close are walls if there is a thickness.

    Fills and polygons stay areas, unless the layer was named as one of walls.
    """
    if row.role != WALL or thickness is None or not isinstance(shape, DrawnArea | DrawnCircle):
        return [shape]
    return shape.walls() if shape.is_line or row.named else [shape]


def question_of_walls(
    held: Mapping[str, Sequence[Solid]],
    rows: Sequence[LayerRole],
    metres: float,
    has_walkable: bool,
) -> PlanQuestion | None:
    """What to ask where one outline holds all others of its layer, or is the only thing drawn.

    `held` are the solid shapes by layer. It is not asked of a layer that was named as solid.
    """
    everything = sum(len(shapes) for shapes in held.values())
    for row in rows:
        shapes = held.get(row.layer, ())
        if not shapes or (row.named and row.role == OBSTACLE):
            continue
        outer = holder(shapes)
        lone = everything == 1 and not has_walkable and row.role == WALL
        what = "it is all that is drawn" if lone else f"it holds all else on layer {row.layer!r}"
        if outer is None or (len(shapes) == 1 and not (lone and outer.is_line)):
            outer = thick_line(shapes, metres) if row.role == WALL else None
            what = "it is a closed line, too wide for the outline of a wall"
        if outer is None:
            continue
        low_x, low_y, high_x, high_y = outer.bounds()
        size = f"{(high_x - low_x) * metres:.4g} x {(high_y - low_y) * metres:.4g} m"
        layer = shown(row.layer)
        return PlanQuestion(
            f"{outer.origin}: {what}, and would be a solid block of {size}: give --solid {layer} "
            f"if that is so, or --wall {layer} --thickness {THICK:g} for walls along the lines",
            (
                PlanChoice("Solid block", {"roles": {OBSTACLE: [row.layer]}}),
                PlanChoice("Walls", {"roles": {WALL: [row.layer]}}, thickness=True),
            ),
        )
    return None


def thick_line(shapes: Sequence[Solid], metres: float) -> DrawnArea | DrawnCircle | None:
    """A closed line around more than a wall, or None."""
    for shape in shapes:
        if isinstance(shape, DrawnArea) and shape.is_line:
            outline = footprint(shape)
            if 2.0 * outline.area / outline.length * metres > THICKEST:
                return shape
    return None


def holder(shapes: Sequence[Solid]) -> DrawnArea | DrawnCircle | None:
    """The area without holes that covers all other shapes, or None."""
    areas = [
        s
        for s in shapes
        if (isinstance(s, DrawnArea) and len(s.rings) == 1)
        or (isinstance(s, DrawnCircle) and not s.is_wall)
    ]  # fmt: skip
    if not areas:
        return None
    around = bounds_of([corner for shape in shapes for corner in corners(shape)])
    outer = next((one for one in areas if one.bounds() == around), None)
    if outer is None:
        return None
    cover = footprint(outer)
    shapely.prepare(cover)
    others = [footprint(one) for one in shapes if one is not outer]
    return outer if all(cover.covers(one) for one in others) else None


def corners(shape: Solid) -> list[tuple[float, float]]:
    """The lower and the upper corner of a shape."""
    bounds = shape.bounds()
    return [bounds[:2], bounds[2:]]


def footprint(shape: Solid) -> shapely.Geometry:
    """A shape on the plan, a line as one."""
    if isinstance(shape, DrawnArea):
        return shapely.Polygon(shape.rings[0], shape.rings[1:])
    if isinstance(shape, DrawnCircle):
        return shapely.Point(shape.centre).buffer(shape.radius)
    return shapely.LineString(shape.points) if isinstance(shape, DrawnLine) else shapely.Point(
        shape.place
    )  # fmt: skip
