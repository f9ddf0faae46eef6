"""Assign a role to each layer of a drawing: asked for, read from its name, or not clear.

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


def assign_roles(
    contents: DrawingContents, wanted_roles: Mapping[str, Sequence[str]]
) -> tuple[LayerRole, ...]:
    """The role of each layer that holds anything; of an empty one only if it is asked for.

    `wanted_roles` are layers by role, upper or lower case; `*` in a name stands for any letters,
    and alone for every layer that has no role otherwise. What is asked goes before what the drawing
    hides, and that before what a name says. Raises InputError for an unknown role or layer, and for
    a layer with two roles.
    """
    demand_known(contents, wanted_roles)
    roles_by_layer = {
        layer: wanted_role_of(layer, wanted_roles, contents.path) for layer in contents.layers
    }
    items: dict[str, list[Item]] = {}
    for item in contents.items:
        items.setdefault(item.layer, []).append(item)
    open_layers: dict[str, list[tuple[str, int]]] = {}
    for (kind, layer), count in contents.left_out.items():
        open_layers.setdefault(layer, []).append((kind, count))
    rest_role = next((role for role, layers in wanted_roles.items() if REST in layers), None)
    rows = []
    for layer in contents.layers:
        layer_items = items.get(layer, [])
        if not layer_items and layer not in open_layers and roles_by_layer[layer] is None:
            continue
        wanted_role = roles_by_layer[layer]
        role, reason = wanted_role or own_role(layer, layer_items, contents)
        if role is None and rest_role is not None and layer_items:
            role, reason = rest_role, f"--{rest_role} '{REST}'"
        counts = Counter(item.kind for item in layer_items)
        counts.update(dict(open_layers.get(layer, [])))
        entities = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "nothing"
        rows.append(LayerRole(layer, entities, role, reason, wanted_role is not None))
    return tuple(
        role_from_contents(row, items[UNNAMED], rows, items) if is_open(row, items) else row
        for row in rows
    )


def wanted_role_of(
    layer: str, wanted_roles: Mapping[str, Sequence[str]], path: Path
) -> tuple[str, str] | None:
    """The role that is asked for a layer, its own name before a pattern. Raises InputError."""
    layer_key = layer.casefold()
    matches: dict[bool, dict[str, str]] = {True: {}, False: {}}
    for role, names in wanted_roles.items():
        for name in names:
            exact = name.casefold() == layer_key
            if exact or (name != REST and fnmatchcase(layer_key, name.casefold())):
                matches[exact][role] = f"--{role} {shell_layer_name(name)}"
    for roles in matches.values():
        if len(roles) > 1:
            role_text = " and ".join(roles)
            raise InputError(f"layer {layer!r} cannot be {role_text}: one role each ({path})")
        for role, reason in roles.items():
            return role, reason
    return None


def demand_known(contents: DrawingContents, wanted_roles: Mapping[str, Sequence[str]]) -> None:
    """Refuse a name that is asked for and matches no layer. Raises InputError."""
    for role in wanted_roles:
        if role not in ROLES:
            raise unknown("role", role, ROLES)
    layer_keys = [layer.casefold() for layer in contents.layers]
    rest_roles = [role for role, names in wanted_roles.items() if REST in names]
    if len(rest_roles) > 1:
        raise InputError(f"'{REST}' cannot be {' and '.join(rest_roles)}: the rest has one role")
    for names in wanted_roles.values():
        for name in names:
            if name != REST and not any(
                layer_key == name.casefold() or fnmatchcase(layer_key, name.casefold())
                for layer_key in layer_keys
            ):
                raise unknown_layer(name, contents)


def unknown_layer(name: str, contents: DrawingContents) -> InputError:
    """A refusal of a name that no layer has; of thousands of layers the nearest are named."""
    known: Sequence[str] = contents.layers
    if len(known) > MOST_NAMED:
        near = get_close_matches(name, known[:MOST_COMPARED], n=5, cutoff=0.4)
        known = [*near, f"{len(known) - len(near)} others"]
    return unknown("layer", name, known, str(contents.path))


def own_role(
    layer: str, layer_items: Sequence[Item], contents: DrawingContents
) -> tuple[str | None, str]:
    """What the drawing says about a layer: that it is hidden, or its name."""
    if layer in contents.hidden:
        return IGNORE, f"it is {contents.hidden[layer]}"
    if not layer_items:
        return IGNORE, "it bounds no area and is no line"
    if layer in contents.roles:
        return contents.roles[layer]
    return role_from_name(layer)


def role_from_name(layer: str) -> tuple[str | None, str]:
    """The role that a layer's name says, and the word that says it; None if no or two roles.

    >>> [role_from_name(name)[0] for name in ("jps-walkablearea-2", "A-WALL-TEXT", "not walkable")]
    ['walkable', None, None]
    """
    if layer.casefold() == PARAMETERS:
        return IGNORE, "JuPedSim's settings"
    roles: dict[str, str] = {}
    parts = [part for part in re.split(r"[\W_]+", layer.casefold()) if part]
    for word in parts:
        plain = word.rstrip("0123456789")
        role = WORDS.get(plain) or WORDS.get(plain.removesuffix("s"))
        role = role or next((r for key, r in BEGINNINGS.items() if word.startswith(key)), None)
        if role is not None:
            roles.setdefault(role, word)
    if any(word in NOT for word in parts) or not roles:
        return None, "its name does not say"
    if len(roles) > 1:
        return None, f"its name says {' and '.join(repr(word) for word in roles.values())}"
    ((role, word),) = roles.items()
    return role, f"its name says {word!r}"


def is_open(row: LayerRole, items: Mapping[str, list[Item]]) -> bool:
    """Whether a row is of what names no layer, and its role still open."""
    return row.layer == UNNAMED and row.role is None and UNNAMED in items


def role_from_contents(
    row: LayerRole,
    layer_items: Sequence[Item],
    rows: Sequence[LayerRole],
    items: Mapping[str, list[Item]],
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
        shapes = [shape for item in layer_items for shape in item.read()]
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
        low_x <= bounds[0] and low_y <= bounds[1] and high_x >= bounds[2] and high_y >= bounds[3]
        for bounds in (shape.bounds() for shape in solid if isinstance(shape, Solid))
    )


def shell_layer_name(name: str) -> str:
    """A layer's name as a shell takes it."""
    return name if re.fullmatch(r"[\w.-]+", name) else repr(name[:LONGEST])


def describe_unclear(contents: DrawingContents, rows: Sequence[LayerRole]) -> list[str]:
    """A line for each layer whose role is not clear, but those that names leave open in a line."""
    messages, names = [], []
    for row in rows:
        if row.role is not None:
            continue
        if row.why.startswith(str(contents.path)):  # it cannot be read, and says so itself
            messages.append(row.why)
        elif row.layer == UNNAMED:
            messages.append(
                f"{contents.path}: no clear role ({row.why}): give --walkable {UNNAMED} or --solid "
                f"{UNNAMED}, or each a name"
            )
        else:
            names.append(row)
    if len(names) == 1:
        (row,) = names
        messages.append(
            f"{contents.path}, layer {row.layer!r}: no clear role ({row.why}): give --walkable, "
            f"--obstacle, --wall, --start, --goal, --path or --ignore {shell_layer_name(row.layer)}"
        )
    elif names:
        listed = ", ".join(repr(row.layer[:LONGEST]) for row in names[:MOST_NAMED])
        rest_text = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
        messages.append(
            f"{contents.path}: {len(names)} layers have no clear role: {listed}{rest_text}: give "
            "each --walkable, --obstacle, --wall, --start, --goal, --path or --ignore, and the "
            "rest --ignore '*'"
        )
    return messages
