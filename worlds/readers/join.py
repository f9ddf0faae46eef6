"""Join lines that meet end to end and draw curves by chords; report each change."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.readers.drawing_contents import PlanChoice, PlanQuestion
from worlds.readers.drawn_shapes import (
    DrawnArea,
    DrawnCircle,
    DrawnCurve,
    DrawnLine,
    Point,
    Solid,
    area,
    bounds_of,
    format_place,
    line,
)
from worlds.readers.roles import OBSTACLE, WALL, LayerRole, shell_layer_name

MOST_NEAR = 20
"""Most ends that lie within the tolerance of one another, on average: a wider one joins nothing
that a person would call one line."""
FEW = 4
"""Most lines that a refusal names beside the first."""
MOST_CHORDS = 10_000
"""Most chords of one curve."""


@dataclass(frozen=True)
class JoinedLines:
    """What lines have become, and what has been done to them, one line each."""

    shapes: tuple[Solid, ...]
    changes: tuple[str, ...]


@dataclass(frozen=True)
class Joint:
    """Two ends that meet: the lines (an end of line k is 2 k or 2 k + 1), and how far apart."""

    ends: tuple[int, int]
    gap: float


def chords(curve: DrawnCurve, tolerance: float, metres: float) -> tuple[DrawnArea | DrawnLine, str]:
    """A curve drawn by chords within a tolerance (units of the file), and a word about it.

    `metres` is the tolerance in metres, for the word. It is an area if it ends where it begins.
    Raises InputError.
    """
    points = list(islice(curve.drawn(tolerance), MOST_CHORDS + 2))
    if len(points) > MOST_CHORDS + 1:
        raise InputError(
            f"{curve.origin}: more than {MOST_CHORDS} chords draw it within {metres:g} m:"
            " a wider tolerance is needed"
        )
    change = f"{curve.origin}: drawn by {len(points) - 1} chords, within {metres:g} m"
    ends_meet = len(points) > 3 and point_distance(points[0], points[-1]) <= 1e-9 * tolerance
    if ends_meet:
        ring = [*points[:-1], points[0]]
        return area(curve.name, [ring], curve.origin, curve.span, is_line=True), change
    return line(curve.name, points, curve.origin, None, curve.span), change


def join_lines(
    lines: Sequence[DrawnLine], tolerance: float, scale: float, walls: bool = False
) -> JoinedLines:
    """Lines whose ends meet within a tolerance (units of the file), as one; closed, as an area.

    With `walls` they stay lines, closed or not.
    Where more than two ends meet nothing is joined, for who belongs to whom is not clear. At a
    joint the later line's end moves to the earlier one's. Raises InputError for a tolerance that is
    too wide for the drawing, and for what is closed and unsound.
    """
    joints, crowded = joints_of(lines, tolerance)
    partner = {end: joint for joint in joints for end in joint.ends}
    visited: set[int] = set()
    shapes: list[Solid] = []
    changes: list[str] = list(crowded)
    # Open chains first: from each line with a free end; what is left runs in rings.
    free = [k for k in range(len(lines)) if 2 * k not in partner or 2 * k + 1 not in partner]
    for first in [*free, *range(len(lines))]:
        if first in visited:
            continue
        from_its_end = 2 * first in partner and 2 * first + 1 not in partner
        begin = 2 * first + from_its_end
        shape, notes = chain(lines, begin, partner, visited, scale, walls)
        shapes.append(shape)
        changes += notes
    return JoinedLines(tuple(shapes), tuple(changes))


def chain(
    lines: Sequence[DrawnLine],
    begin: int,
    partner: dict[int, Joint],
    visited: set[int],
    scale: float,
    walls: bool,
) -> tuple[Solid, list[str]]:
    """The lines from an end on, as one; and a word for each joint."""
    first = lines[begin // 2]
    points: list[Point] = []
    changes = []
    end, closed = begin, False
    while True:
        number = end // 2
        visited.add(number)
        run = lines[number].points if end % 2 == 0 else lines[number].points[::-1]
        points += run if not points else run[1:]
        joint = partner.get(end ^ 1)
        if joint is None:
            break
        end = joint.ends[0] if joint.ends[1] == end ^ 1 else joint.ends[1]
        other = lines[end // 2]
        partner_text = (
            "its ends" if other is lines[number] else f"with {other.origin.rpartition(', ')[2]}"
        )
        changes.append(
            f"{lines[number].origin}: joined {partner_text} at {format_place(points[-1])}, over a "
            f"gap of {joint.gap * scale:.3g} m"
        )
        if end == begin:
            closed = True
            break
    if not changes:
        return first, []
    rest_text = f" and {len(changes) - closed} more" if len(changes) > closed else ""
    if closed and not walls:
        ring = [*points[:-1], points[0]]
        try:
            joined_area = area(
                first.name, [ring], first.origin + rest_text, first.span, is_line=True
            )
        except InputError as refusal:
            raise InputError(f"{refusal}, where --join closes it with {pieces(changes)}: give a "
                          "smaller --join, or make walls of its lines (--wall, --thickness)"
                          ) from None  # fmt: skip
        return joined_area, changes
    if closed:
        points[-1] = points[0]
    return replace(first, points=tuple(points), origin=first.origin + rest_text), changes


def pieces(changes: Sequence[str]) -> str:
    """What has been joined to a line, from the words about it, the first FEW of them."""
    origins = [change.partition(": joined with ")[2].partition(" at (")[0] for change in changes]
    origins = [origin for origin in origins if origin][:FEW]
    return ", ".join(origins) or "itself"


def joints_of(lines: Sequence[DrawnLine], tolerance: float) -> tuple[list[Joint], list[str]]:
    """Where exactly two ends meet, and a word where more do. Raises InputError."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not lines:
        return [], []
    ends = np.array([point for line in lines for point in (line.points[0], line.points[-1])])
    tree = cKDTree(ends)
    pairs = (tree.count_neighbors(tree, tolerance) - len(ends)) // 2
    if pairs > MOST_NEAR * len(ends):
        raise InputError(
            f"{lines[0].origin}: the tolerance of --join is too wide: {pairs} pairs of "
            f"ends of {len(lines)} lines lie within it"
        )
    near = tree.query_pairs(tolerance, output_type="ndarray")
    ones_of_pairs = np.ones(len(near))
    graph = coo_array((ones_of_pairs, (near[:, 0], near[:, 1])), shape=(len(ends), len(ends)))
    _, label = connected_components(graph, directed=False)
    groups: dict[int, list[int]] = defaultdict(list)
    for end, group in enumerate(label):
        groups[int(group)].append(end)
    joints, crowded = [], []
    for members in groups.values():
        if len(members) == 2 and joinable(lines, members, tolerance):
            first_end, other_end = members
            joints.append(
                Joint((first_end, other_end), point_distance(ends[first_end], ends[other_end]))
            )
        elif len(members) > 2:
            origin = lines[members[0] // 2].origin
            crowded.append(
                f"{origin}: {len(members)} ends meet at {format_place(ends[members[0]])}: "
                "not joined, for which belong together is not clear"
            )
    return joints, crowded


def joinable(lines: Sequence[DrawnLine], members: Sequence[int], tolerance: float) -> bool:
    """Whether two ends are not those of one line that is shorter than the tolerance itself."""
    first_end, other_end = members
    if first_end // 2 != other_end // 2:
        return True
    points = lines[first_end // 2].points
    reach = max(point_distance(points[0], point) for point in points)
    return len(points) > 2 and reach > tolerance


def point_distance(point: Sequence[float], other: Sequence[float]) -> float:
    """The distance of two points."""
    return float(np.hypot(point[0] - other[0], point[1] - other[1]))


# Closed lines that may be walls: made walls of a thickness, or asked about.
#
# A closed outline on a layer of walls is either the wall's own footprint, which is solid, or the
# line that the wall runs along, in which people live. The one that holds all others is the second.

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
    shapes_by_layer: Mapping[str, Sequence[Solid]],
    rows: Sequence[LayerRole],
    metres: float,
    has_walkable: bool,
) -> PlanQuestion | None:
    """What to ask where one outline holds all others of its layer, or is the only thing drawn.

    `shapes_by_layer` are the solid shapes. It is not asked of a layer that was named as solid.
    """
    total = sum(len(shapes) for shapes in shapes_by_layer.values())
    for row in rows:
        shapes = shapes_by_layer.get(row.layer, ())
        if not shapes or (row.named and row.role == OBSTACLE):
            continue
        outer = enclosing_area(shapes)
        lone = total == 1 and not has_walkable and row.role == WALL
        reason = "it is all that is drawn" if lone else f"it holds all else on layer {row.layer!r}"
        if outer is None or (len(shapes) == 1 and not (lone and outer.is_line)):
            outer = thick_line(shapes, metres) if row.role == WALL else None
            reason = "it is a closed line, too wide for the outline of a wall"
        if outer is None:
            continue
        low_x, low_y, high_x, high_y = outer.bounds()
        size = f"{(high_x - low_x) * metres:.4g} x {(high_y - low_y) * metres:.4g} m"
        layer = shell_layer_name(row.layer)
        return PlanQuestion(
            f"{outer.origin}: {reason}, and would be a solid block of {size}: give --solid {layer} "
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


def enclosing_area(shapes: Sequence[Solid]) -> DrawnArea | DrawnCircle | None:
    """The area without holes that covers all other shapes, or None."""
    areas = [
        s
        for s in shapes
        if (isinstance(s, DrawnArea) and len(s.rings) == 1)
        or (isinstance(s, DrawnCircle) and not s.is_wall)
    ]  # fmt: skip
    if not areas:
        return None
    box = bounds_of([corner for shape in shapes for corner in corners(shape)])
    outer = next((candidate for candidate in areas if candidate.bounds() == box), None)
    if outer is None:
        return None
    cover = footprint(outer)
    shapely.prepare(cover)
    footprints = [footprint(member) for member in shapes if member is not outer]
    return outer if all(cover.covers(one) for one in footprints) else None


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
