"""What each layer of a drawing is: asked for, guessed from its name, or not clear.

Source: JuPedSim, scripts/dxf2wkt.py (the names that begin with jps-); National CAD Standard, layer
names with a letter for the discipline before them (A-WALL).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fnmatch import fnmatchcase
from pathlib import Path

from worlds.input_error import InputError, unknown
from worlds.readers.drawing_contents import UNNAMED, DrawingContents, Item
from worlds.readers.drawn_shapes import DrawnArea, DrawnPoint, Shape, Solid

WALKABLE, OBSTACLE, WALL, START, GOAL, PATH, IGNORE = (
    "walkable", "obstacle", "wall", "start", "goal", "path", "ignore"
)  # fmt: skip
ROLES = (WALKABLE, OBSTACLE, WALL, START, GOAL, PATH, IGNORE)
REST = "*"
"""Stands for every layer that has no role otherwise."""
BEGINNINGS = {
    **{"walkable": WALKABLE, "obstacle": OBSTACLE, "start": START, "distribution": START},
    **{"exit": GOAL, "goal": GOAL, "waypoint": PATH, "journey": PATH, "annotation": IGNORE},
    **{"dimension": IGNORE, "defpoints": IGNORE, "viewport": IGNORE},
}
"""Roles by how a word of a layer's name begins."""
WORDS = {
    **dict.fromkeys(("wall", "fence", "barrier"), WALL),
    **dict.fromkeys(("pillar", "column", "kiosk", "tree"), OBSTACLE),
    **dict.fromkeys(("building", "furniture", "cols"), OBSTACLE),
    **{"path": PATH, "ignore": IGNORE, "text": IGNORE, "anno": IGNORE, "dim": IGNORE},
}
"""Roles by a whole word of a layer's name, in the singular or the plural."""
MOST_NAMED = 20
"""Most layers that a line names."""
LONGEST = 80
"""Letters of a name that such a line shows."""
MOST_COMPARED = 2000
"""Most layers among which a near name is looked for."""
NOT = ("not", "non", "no", "un")
"""Words that turn the others round, so that nothing is clear."""
PARAMETERS = "jps-parameters"
"""JuPedSim's layer of settings, as text."""


@dataclass(frozen=True)
class LayerRole:
    """A layer, what is on it, its role and why; a role of None is not clear."""

    layer: str
    entities: str
    role: str | None
    why: str
    named: bool = False
    """Whether the role was asked for, by the layer's name."""


def cast(contents: DrawingContents, asked: Mapping[str, Sequence[str]]) -> tuple[LayerRole, ...]:
    """The role of each layer that holds anything; of an empty one only if it is asked for.

    `asked` are layers by role, upper or lower case; `*` in a name stands for any letters, and alone
    for every layer that has no role otherwise. What is asked goes before what the drawing hides,
    and that before what a name says. Raises InputError for an unknown role or layer, and for a
    layer with two roles.
    """
    demand_known(contents, asked)
    given = {layer: asked_role(layer, asked, contents.path) for layer in contents.layers}
    items: dict[str, list[Item]] = {}
    for item in contents.items:
        items.setdefault(item.layer, []).append(item)
    left: dict[str, list[tuple[str, int]]] = {}
    for (kind, layer), count in contents.left_out.items():
        left.setdefault(layer, []).append((kind, count))
    rest = next((role for role, layers in asked.items() if REST in layers), None)
    rows = []
    for layer in contents.layers:
        held = items.get(layer, [])
        if not held and layer not in left and given[layer] is None:
            continue
        asked_for = given[layer]
        role, why = asked_for or own_role(layer, held, contents)
        if role is None and rest is not None and held:
            role, why = rest, f"--{rest} '{REST}'"
        counts = Counter(item.kind for item in held)
        counts.update(dict(left.get(layer, [])))
        entities = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "nothing"
        rows.append(LayerRole(layer, entities, role, why, asked_for is not None))
    return tuple(
        unnamed(row, items[UNNAMED], rows, items) if is_open(row, items) else row for row in rows
    )


def asked_role(
    layer: str, asked: Mapping[str, Sequence[str]], path: Path
) -> tuple[str, str] | None:
    """The role that is asked for a layer, its own name before a pattern. Raises InputError."""
    folded = layer.casefold()
    found: dict[bool, dict[str, str]] = {True: {}, False: {}}
    for role, names in asked.items():
        for name in names:
            exact = name.casefold() == folded
            if exact or (name != REST and fnmatchcase(folded, name.casefold())):
                found[exact][role] = f"--{role} {shell_layer_name(name)}"
    for roles in found.values():
        if len(roles) > 1:
            both = " and ".join(roles)
            raise InputError(f"layer {layer!r} cannot be {both}: one role each ({path})")
        for role, why in roles.items():
            return role, why
    return None


def demand_known(contents: DrawingContents, asked: Mapping[str, Sequence[str]]) -> None:
    """Refuse a name that is asked for and matches no layer. Raises InputError."""
    for role in asked:
        if role not in ROLES:
            raise unknown("role", role, ROLES)
    folded = [layer.casefold() for layer in contents.layers]
    rests = [role for role, names in asked.items() if REST in names]
    if len(rests) > 1:
        raise InputError(f"'{REST}' cannot be {' and '.join(rests)}: the rest has one role")
    for names in asked.values():
        for name in names:
            if name != REST and not any(
                one == name.casefold() or fnmatchcase(one, name.casefold()) for one in folded
            ):
                raise unknown_layer(name, contents)


def unknown_layer(name: str, contents: DrawingContents) -> InputError:
    """A refusal of a name that no layer has; of thousands of layers the nearest are named."""
    known: Sequence[str] = contents.layers
    if len(known) > MOST_NAMED:
        near = get_close_matches(name, known[:MOST_COMPARED], n=5, cutoff=0.4)
        known = [*near, f"{len(known) - len(near)} others"]
    return unknown("layer", name, known, str(contents.path))


def own_role(layer: str, held: Sequence[Item], contents: DrawingContents) -> tuple[str | None, str]:
    """What the drawing says about a layer: that it is hidden, or its name."""
    if layer in contents.hidden:
        return IGNORE, f"it is {contents.hidden[layer]}"
    if not held:
        return IGNORE, "it bounds no area and is no line"
    if layer in contents.roles:
        return contents.roles[layer]
    return guess(layer)


def guess(layer: str) -> tuple[str | None, str]:
    """The role that a layer's name says, and the word that says it; None if no or two roles.

    >>> guess("jps-walkablearea-2")[0], guess("A-WALL-TEXT")[0], guess("not walkable")[0]
    ('walkable', None, None)
    """
    if layer.casefold() == PARAMETERS:
        return IGNORE, "JuPedSim's settings"
    found: dict[str, str] = {}
    words = [word for word in re.split(r"[\W_]+", layer.casefold()) if word]
    for word in words:
        plain = word.rstrip("0123456789")
        role = WORDS.get(plain) or WORDS.get(plain.removesuffix("s"))
        role = role or next((r for key, r in BEGINNINGS.items() if word.startswith(key)), None)
        if role is not None:
            found.setdefault(role, word)
    if any(word in NOT for word in words) or not found:
        return None, "its name does not say"
    if len(found) > 1:
        return None, f"its name says {' and '.join(repr(word) for word in found.values())}"
    ((role, word),) = found.items()
    return role, f"its name says {word!r}"


def is_open(row: LayerRole, items: Mapping[str, list[Item]]) -> bool:
    """Whether a row is of what names no layer, and its role still open."""
    return row.layer == UNNAMED and row.role is None and UNNAMED in items


def unnamed(
    row: LayerRole, held: Sequence[Item], rows: Sequence[LayerRole], items: Mapping[str, list[Item]]
) -> LayerRole:
    """What names no layer: solid beside a walkable area; alone, a lone polygon is walkable.

    Lines, discs and what has heights can only be solid. Several polygons may be rooms or blocks,
    and so may one beside solids that it does not surround: that stays open.
    """
    if any(other.role == WALKABLE for other in rows):
        return LayerRole(
            row.layer, row.entities, OBSTACLE, "it has no name, beside a walkable area"
        )
    try:
        shapes = [shape for item in held for shape in item.read()]
        solid = [
            shape
            for other in rows
            if other.role in (OBSTACLE, WALL)
            for item in items.get(other.layer, ())
            for shape in item.read()
        ]
    except InputError as refusal:
        return LayerRole(row.layer, row.entities, None, str(refusal))
    areas = [
        shape for shape in shapes if isinstance(shape, DrawnArea) and shape.span == (None, None)
    ]
    if not areas:
        if all(isinstance(shape, DrawnPoint) for shape in shapes):
            return LayerRole(row.layer, row.entities, OBSTACLE, "it has no name")
        return LayerRole(
            row.layer, row.entities, OBSTACLE, "lines, discs and heights are of solids"
        )
    if len(areas) == len(shapes) == 1 and surrounds(areas[0], solid):
        return LayerRole(row.layer, row.entities, WALKABLE, "a lone polygon: its holes are solid")
    if len(areas) < len(shapes):
        return LayerRole(
            row.layer, row.entities, None, "polygons beside solids may be rooms or blocks"
        )
    return LayerRole(row.layer, row.entities, None, f"{len(areas)} polygons may be rooms or blocks")


def surrounds(area: DrawnArea, solid: Sequence[Shape]) -> bool:
    """Whether solids lie inside the bounds of an area."""
    low_x, low_y, high_x, high_y = area.bounds()
    return all(
        low_x <= one[0] and low_y <= one[1] and high_x >= one[2] and high_y >= one[3]
        for one in (shape.bounds() for shape in solid if isinstance(shape, Solid))
    )


def shell_layer_name(name: str) -> str:
    """A layer's name as a shell takes it."""
    return name if re.fullmatch(r"[\w.-]+", name) else repr(name[:LONGEST])


def unclear(contents: DrawingContents, rows: Sequence[LayerRole]) -> list[str]:
    """A line for each layer whose role is not clear, but those that names leave open in a line."""
    found, names = [], []
    for row in rows:
        if row.role is not None:
            continue
        if row.why.startswith(str(contents.path)):  # it cannot be read, and says so itself
            found.append(row.why)
        elif row.layer == UNNAMED:
            found.append(
                f"{contents.path}: no clear role ({row.why}): give --walkable {UNNAMED} or --solid "
                f"{UNNAMED}, or each a name"
            )
        else:
            names.append(row)
    if len(names) == 1:
        (row,) = names
        found.append(
            f"{contents.path}, layer {row.layer!r}: no clear role ({row.why}): give --walkable, "
            f"--obstacle, --wall, --start, --goal, --path or --ignore {shell_layer_name(row.layer)}"
        )
    elif names:
        listed = ", ".join(repr(row.layer[:LONGEST]) for row in names[:MOST_NAMED])
        more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
        found.append(
            f"{contents.path}: {len(names)} layers have no clear role: {listed}{more}: give each "
            "--walkable, --obstacle, --wall, --start, --goal, --path or --ignore, and the rest "
            "--ignore '*'"
        )
    return found
