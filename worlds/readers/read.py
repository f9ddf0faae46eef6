"""Read a drawing: what each layer is, how long a unit is, and what comes of it in metres."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import shapely

from worlds.input_error import InputError, error_of_lines, unknown
from worlds.obstacles import Obstacle
from worlds.readers.degrees import places_of, projected, question_of_degrees
from worlds.readers.drawing_contents import (
    MOST_CORNERS,
    UNNAMED,
    DrawingContents,
    PlanChoice,
    PlanQuestion,
)
from worlds.readers.drawn_shapes import (
    Bounds,
    DrawnCurve,
    DrawnLine,
    DrawnPoint,
    Shape,
    Solid,
    StrayPoint,
    UnitConversion,
    bounds_of,
    format_place,
)
from worlds.readers.formats.dxf import MOST_OUTLINES, read_dxf, within
from worlds.readers.formats.geojson import read_geojson
from worlds.readers.formats.movingai import read_movingai
from worlds.readers.formats.ros_map import read_ros_map, read_zipped_map
from worlds.readers.formats.svg import read_svg
from worlds.readers.formats.vadere import read_vadere
from worlds.readers.formats.wkt import read_wkt
from worlds.readers.join import chords, join_lines, question_of_walls, walls_of
from worlds.readers.roles import (
    GOAL,
    IGNORE,
    OBSTACLE,
    PATH,
    START,
    WALKABLE,
    WALL,
    LayerRole,
    assign_roles,
    describe_unclear,
)

# The length of a drawing's unit in metres, and whether it is plausible.

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "km": 1000.0, "in": 0.0254, "ft": 0.3048,
         "yd": 0.9144}  # fmt: skip
"""Metres."""
SMALLEST, LARGEST = 1.0, 500.0
"""Longest side of a plan that is not questioned, m: a small room to the ground of a festival."""
SILENT = {".dxf": "$INSUNITS", ".svg": "an SVG file has none"}
"""Formats in which a unit may be anything, by the ending, and where it would stand."""
SUGGESTED = ("m", "cm", "mm", "in", "ft")


def metres_per_unit(contents: DrawingContents, scale: float | None, unit: str | None) -> float:
    """Metres per unit of the file: as asked, or as the file says; 1 for GeoJSON and WKT.

    Raises InputError if both are asked for, and PlanQuestion for a DXF or SVG file that does not
    say.
    """
    if scale is not None and unit is not None:
        raise InputError(
            f"scale = {scale:g} and unit = {unit} say the same thing: give one of them"
        )
    if scale is not None:
        if not (scale > 0.0 and math.isfinite(scale)):
            raise InputError(f"scale = {scale:g} is not allowed: metres per unit of the file, > 0")
        return scale
    if unit is not None:
        if unit not in UNITS:
            raise unknown("unit", unit, UNITS)
        return UNITS[unit]
    reason = SILENT.get(contents.path.suffix.lower())
    if contents.unit is None and reason is not None:
        raise PlanQuestion(
            f"{contents.path} does not say its unit ({reason}): give --unit, one of "
            f"{', '.join(UNITS)}, or a scale, metres per unit (--scale)",
            tuple(PlanChoice(f"1 unit is 1 {name}", {"unit": name}) for name in SUGGESTED),
        )
    return contents.unit or 1.0


def question_of_size(
    contents: DrawingContents, bounds: Bounds, scale: float
) -> PlanQuestion | None:
    """What to ask about a plan whose size is none of a room or a building, or None.

    `bounds` are in units of the file. It is asked only where nobody has said the unit.
    """
    side = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    in_metres = contents.unit is not None and contents.path.suffix.lower() != ".dxf"
    if in_metres or SMALLEST <= side * scale <= LARGEST:
        return None
    says = "$INSUNITS says" if contents.unit is not None else "a unit is 1 m unless said"
    unit = next((name for name, metres in UNITS.items() if math.isclose(metres, scale)), None)
    if contents.unit is not None:
        says = f"{says} {unit}" if unit else f"{says} {scale:g} m per unit"
    choices = [
        f"--unit {name} ({side * UNITS[name]:.4g} m)"
        for name in SUGGESTED
        if SMALLEST <= side * UNITS[name] <= LARGEST and UNITS[name] != scale
    ]
    keep = f"--unit {unit}" if unit else f"--scale {scale:g}"
    other = f", else {' or '.join(choices)}" if choices else ""
    answers = [
        PlanChoice(f"1 unit is 1 {name} ({side * UNITS[name]:.4g} m wide)", {"unit": name})
        for name in dict.fromkeys([*([unit] if unit else []), *SUGGESTED])
        if name == unit or SMALLEST <= side * UNITS[name] <= LARGEST
    ]
    return PlanQuestion(
        f"{contents.path}: the plan would be {side * scale:.4g} m wide ({says}): give {keep} if "
        f"that is so{other}",
        tuple(answers),
    )


READERS: dict[str, Callable[[Path], DrawingContents]] = {
    ".geojson": read_geojson, ".json": read_geojson, ".wkt": read_wkt, ".dxf": read_dxf,
    ".svg": read_svg, ".scenario": read_vadere, ".map": read_movingai, ".yaml": read_ros_map,
    ".yml": read_ros_map, ".zip": read_zipped_map,
}  # fmt: skip
"""By the ending of the file's name."""
FEW = 3
"""Most open lines of a layer that are reported one by one."""
DIGITS = 14
"""Digits of the largest coordinate that are kept: behind them a double holds rounding errors."""
Made = dict[str, list[tuple[str, Solid]]]
"""Shapes with their layers, by role."""


@dataclass(frozen=True)
class Geometry:
    """What was taken of a drawing, in metres, rounded to `digits` decimals.

    `walkable` is where agents may be, a shapely polygon or several, or None if the drawing does not
    say. `starts`, `goals` and `paths` are what a mission may be made of, with their layers.
    `changes` say what was joined, drawn by chords or left out, one line each.
    """

    file: str
    obstacles: tuple[Obstacle, ...]
    walkable: shapely.Geometry | None
    layers: tuple[LayerRole, ...]
    changes: tuple[str, ...]
    starts: tuple[tuple[str, Solid], ...]
    goals: tuple[tuple[str, Solid], ...]
    paths: tuple[tuple[str, Solid], ...]
    digits: int


def read_geometry(
    path: str | Path,
    roles: Mapping[str, Sequence[str]] | None = None,
    *,
    scale: float | None = None,
    unit: str | None = None,
    thickness: float | None = None,
    join: float | None = None,
    drop_lines: bool = False,
    degrees: bool = False,
) -> Geometry:
    """What a drawing or a map of another program says about a world: see `READERS`.

    `roles` are layers by what they are: "walkable", "obstacle", "wall", "start", "goal", "path",
    "ignore";
    layers that are not named are guessed from their names, see `worlds.readers.roles`. For the
    rest see `geometry_of`. Raises InputError with file and place for all that cannot be used.
    """
    contents = open_drawing(path)
    rows = assign_roles(contents, roles or {})
    return geometry_of(contents, rows, scale, unit, thickness, join, drop_lines, degrees)


def open_drawing(path: str | Path) -> DrawingContents:
    """What a file holds, on its layers. Raises InputError."""
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in READERS:
        raise InputError(f"{str(path)!r} is not a drawing that is read: {', '.join(READERS)} are")
    return READERS[ending](path)


def geometry_of(
    contents: DrawingContents,
    rows: Sequence[LayerRole],
    scale: float | None = None,
    unit: str | None = None,
    thickness: float | None = None,
    join: float | None = None,
    drop_lines: bool = False,
    degrees: bool = False,
) -> Geometry:
    """What the layers of a drawing say, each in its role, in metres.

    `scale` is metres per unit of the file, or `unit` its name ("mm"): 1 for GeoJSON and WKT, and
    what $INSUNITS says for DXF, unless given; a plan that would be smaller than a room or larger
    than a building is then questioned. `thickness` (m) makes walls of open lines. `join` (m) joins
    lines that meet end to end within it, and draws splines by chords within it. `drop_lines` leaves
    out the lines that are still open then and have no thickness. `degrees` projects longitudes and
    latitudes to metres around the middle of the plan. Raises PlanQuestion, an InputError
    with the choices that answer it, for a drawing that may mean two things, and InputError with
    file and place for all that cannot be used; nothing is repaired without being asked.
    """
    for name, value in (("thickness", thickness), ("join", join)):
        if value is not None and not (value > 0.0 and math.isfinite(value)):
            raise InputError(f"{name} = {value:g} m is not a length > 0")
    problems = describe_unclear(contents, rows)
    question: PlanQuestion | None = None
    projection = None
    if degrees:
        if scale is not None or unit is not None:
            raise InputError(
                "--degrees makes metres of a plan: --unit and --scale cannot be given too"
            )
        contents, projection = projected(contents, rows)
    try:
        metres = metres_per_unit(contents, scale, unit)
    except PlanQuestion as open_unit:
        question, metres = open_unit, 1.0
    layer_shapes = LayerShapes(contents, rows, metres, join, thickness)
    if projection is not None:
        layer_shapes.changes.insert(0, projection)
    if drop_lines:
        layer_shapes.drop_lines(thickness)
    problems += layer_shapes.problems
    plan = [shape for role in (WALKABLE, OBSTACLE) for _, shape in layer_shapes.by_role[role]]
    if problems:
        questions = [str(question)] if question else []
        raise error_of_lines([*problems, *questions, *layer_shapes.describe_unusable(thickness)])
    if not plan:
        layers = ", ".join(row.layer for row in rows if row.role != IGNORE)
        raise InputError(f"{contents.path}: there is nothing on its layers ({layers or 'none'})")
    walkable_layer = next((row.layer for row in rows if row.role == WALKABLE), None)
    if walkable_layer is not None and not layer_shapes.by_role[WALKABLE]:
        raise InputError(
            f"{contents.path}: there is nothing on the walkable layer {walkable_layer!r}"
        )
    if scale is None and unit is None and not degrees and question is None:
        shapes = [shape for shape_list in layer_shapes.by_role.values() for _, shape in shape_list]
        bounds = bounds_of([p for shape in plan for p in corners_of(shape.bounds())])
        question = question_of_degrees(contents, places_of(shapes))
        question = question or question_of_size(contents, bounds, metres)
    problems = layer_shapes.describe_unusable(thickness)
    if problems:
        raise error_of_lines(problems + ([str(question)] if question else []))
    solids: dict[str, list[Solid]] = {}
    for layer, shape in layer_shapes.by_role[OBSTACLE]:
        solids.setdefault(layer, []).append(shape)
    question = question or question_of_walls(
        solids, rows, metres, bool(layer_shapes.by_role[WALKABLE])
    )
    if question is not None:
        raise question
    return convert_to_metres(contents, rows, layer_shapes, metres, thickness)


class LayerShapes:
    """The shapes of the layers that have a role, in units of the file; lines joined if asked.

    `problems` is everything that cannot be used so far, `changes` what has been done to it.
    """

    def __init__(
        self,
        contents: DrawingContents,
        rows: Sequence[LayerRole],
        metres: float,
        join: float | None,
        thickness: float | None,
    ) -> None:
        self.path, self.metres, self.join = contents.path, metres, join
        self.thickness = thickness
        self.problems: list[str] = []
        self.closed_counts = Counter[str]()
        """How many closed lines of a layer have become walls."""
        self.changes: list[str] = [
            f"{count} {kind} on layer {layer!r} left out"
            for (kind, layer), count in contents.left_out.items()
        ]
        self.by_role: Made = {role: [] for role in (WALKABLE, OBSTACLE, START, GOAL, PATH)}
        row_of = {row.layer: row for row in rows if row.role not in (None, IGNORE)}
        lines: dict[str, list[DrawnLine]] = {}
        corners = 0
        for item in contents.items:
            row = row_of.get(item.layer)
            if row is None:
                continue
            try:
                read = [self.straighten(shape) for shape in item.read()]
            except InputError as refusal:
                self.problems.append(str(refusal))
                continue
            for shape in read:
                if shape is None:
                    continue
                corners += len(shape.corners())
                if corners > MOST_CORNERS:
                    raise InputError(f"{self.path}: what it draws has more than {MOST_CORNERS} "
                                  "corners, too many to read")  # fmt: skip
                if join is not None and isinstance(shape, DrawnLine) and shape.thickness is None:
                    lines.setdefault(item.layer, []).append(shape)
                else:
                    self.add_shape(row, shape)
        if join is not None:
            for layer, layer_lines in lines.items():
                self.add_joined_lines(row_of[layer], layer_lines, join)
        self.note_walls()

    def add_shape(self, row: LayerRole, shape: Solid) -> None:
        """Put a shape to those of its role; a closed line of a layer of walls as walls."""
        walls = walls_of(shape, row, self.thickness)
        if walls != [shape]:
            self.closed_counts[row.layer] += 1
        role = OBSTACLE if row.role == WALL else row.role or IGNORE
        self.by_role[role] += [(row.layer, wall) for wall in walls]

    def note_walls(self) -> None:
        """Tell which closed lines have become walls."""
        for layer, count in self.closed_counts.items():
            text = "1 closed line is a wall" if count == 1 else f"{count} closed lines are walls"
            self.changes.append(
                f"layer {layer!r}: {text} {self.thickness:g} m thick, and not solid"
            )

    def straighten(self, shape: Shape) -> Solid | None:
        """A shape of straight lines and circles, or None for a stray point. Raises InputError."""
        if isinstance(shape, StrayPoint):
            self.changed(f"{shape.origin}: left out, a single point at {format_place(shape.place)}")
            return None
        if not isinstance(shape, DrawnCurve):
            return shape
        if self.join is None:
            raise InputError(
                f"{shape.origin}: no straight lines draw a curve of this kind: give the distance "
                "within which chords may draw it (--join 0.01, in m)"
            )
        straight, change = chords(shape, self.join / self.metres, self.join)
        self.changed(change)
        return straight

    def add_joined_lines(self, row: LayerRole, lines: list[DrawnLine], join: float) -> None:
        """Take the lines of a layer, joined where their ends are nearer than `join`, m."""
        walls = row.role == WALL and self.thickness is not None
        try:
            joined_lines = join_lines(lines, join / self.metres, self.metres, walls)
        except InputError as refusal:
            self.problems.append(str(refusal))
            return
        for change in joined_lines.changes:
            self.changed(change)
        for shape in joined_lines.shapes:
            is_closed = isinstance(shape, DrawnLine) and shape.points[0] == shape.points[-1]
            self.closed_counts.update([row.layer] if walls and is_closed else [])
            self.add_shape(row, shape)

    def changed(self, change: str) -> None:
        """Note what has been done, without the name of the file."""
        self.changes.append(change.removeprefix(f"{self.path}, "))

    def drop_lines(self, thickness: float | None) -> None:
        """Leave out the open lines of the plan that no thickness makes walls."""
        for role, thick in ((WALKABLE, None), (OBSTACLE, thickness)):
            remaining = []
            for layer, shape in self.by_role[role]:
                if isinstance(shape, DrawnLine) and shape.thickness is None and thick is None:
                    self.changed(f"{shape.origin}: left out, {shape.describe_gap()}")
                else:
                    remaining.append((layer, shape))
            self.by_role[role] = remaining

    def describe_unusable(self, thickness: float | None) -> list[str]:
        """What of the plan bounds no area, one line each; many lines of a layer in one."""
        messages = []
        lines: dict[tuple[str, str], list[DrawnLine]] = {}
        for role, thick in ((WALKABLE, None), (OBSTACLE, thickness)):
            for layer, shape in self.by_role[role]:
                if isinstance(shape, DrawnPoint):
                    messages.append(f"{shape.origin}: {shape.need}")
                elif isinstance(shape, DrawnLine) and (
                    role == WALKABLE or (thick is None and shape.thickness is None)
                ):
                    lines.setdefault((role, layer), []).append(shape)
        for (role, layer), layer_lines in lines.items():
            ask = "join lines whose ends meet (--join), or --drop-lines"
            ask = f"close it, {ask}" if role == WALKABLE else f"close it, give a thickness, {ask}"
            descriptions = [f"{line.origin}: {line.describe_gap()}" for line in layer_lines]
            if role == WALKABLE:
                descriptions = [
                    f"{description}, and a walkable area is a polygon"
                    for description in descriptions
                ]
            if len(layer_lines) > FEW:
                messages.append(
                    f"{self.path}, layer {layer!r}: {len(layer_lines)} open lines bound no "
                    f"area, the first {descriptions[0].rpartition(', layer ')[2]}: {ask}"
                )
            else:
                messages += [f"{one}: {ask}" for one in descriptions]
        return messages + nested_areas([shape for _, shape in self.by_role[WALKABLE]])


def convert_to_metres(
    contents: DrawingContents,
    rows: Sequence[LayerRole],
    layer_shapes: LayerShapes,
    metres: float,
    thickness: float | None,
) -> Geometry:
    """What was taken, in metres and rounded. Raises InputError."""
    largest = max(
        abs(x) * metres
        for shape_list in layer_shapes.by_role.values()
        for _, shape in shape_list
        for point in corners_of(shape.bounds())
        for x in point
    )
    digits = DIGITS - math.ceil(math.log10(largest)) if largest > 0.0 else DIGITS
    conversion = UnitConversion(metres, digits)
    by_role: Made = {}
    problems = []
    for role, held in layer_shapes.by_role.items():
        by_role[role] = []
        for layer, shape in held:
            try:
                by_role[role].append((layer, shape.measured(conversion)))
            except InputError as refusal:
                problems.append(f"{refusal} (in m, rounded to {digits} decimals)")
    if problems:
        raise error_of_lines(problems)
    walkable = [shape.obstacle(None, digits).footprint() for _, shape in by_role[WALKABLE]]
    return Geometry(
        file=contents.path.name,
        obstacles=tuple(
            name_after_layer(shape, layer).obstacle(thickness, digits)
            for layer, shape in by_role[OBSTACLE]
        ),
        walkable=shapely.union_all(walkable) if walkable else None,
        layers=tuple(rows),
        changes=tuple(layer_shapes.changes),
        starts=tuple(by_role[START]),
        goals=tuple(by_role[GOAL]),
        paths=tuple(by_role[PATH]),
        digits=digits,
    )


def nested_areas(shapes: Sequence[Solid]) -> list[str]:
    """Walkable areas that lie inside others, and would be lost in them, one line each."""
    areas = [s for s in shapes if not isinstance(s, DrawnLine | DrawnPoint)]
    if len(areas) < 2:
        return []
    if len(areas) > MOST_OUTLINES:
        return [f"{areas[0].origin.partition(', ')[0]}: {len(areas)} walkable areas are too many, "
                f"at most {MOST_OUTLINES}"]  # fmt: skip
    outlines = [shape.obstacle(None, 0).footprint() for shape in areas]
    return [
        f"{areas[inner].origin}: its outline at {format_place(outlines[inner].exterior.coords[0])} "
        f"lies inside another walkable one ({areas[other].origin.rpartition(', ')[2]}): a hole or "
        "an obstacle there is drawn as such, or on a layer of obstacles"
        for inner, other in dict(within(outlines)).items()
    ]


def corners_of(bounds: tuple[float, float, float, float]) -> list[tuple[float, float]]:
    """The lower and the upper corner."""
    return [bounds[:2], bounds[2:]]


def name_after_layer(shape: Solid, layer: str) -> Solid:
    """The shape with its layer for a name if it has none."""
    own = OBSTACLE if layer == UNNAMED else layer
    return shape if shape.name else replace(shape, name=own)
