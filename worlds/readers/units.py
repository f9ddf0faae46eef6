"""The length of a drawing's unit in metres, and whether it is plausible."""

from __future__ import annotations

import math

from worlds.input_error import InputError, unknown
from worlds.readers.drawing_contents import DrawingContents
from worlds.readers.drawn_shapes import Bounds
from worlds.readers.plan_question import PlanChoice, PlanQuestion

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
    lacking = SILENT.get(contents.path.suffix.lower())
    if contents.unit is None and lacking is not None:
        raise PlanQuestion(
            f"{contents.path} does not say its unit ({lacking}): give --unit, one of "
            f"{', '.join(UNITS)}, or a scale, metres per unit (--scale)",
            tuple(PlanChoice(f"1 unit is 1 {name}", {"unit": name}) for name in SUGGESTED),
        )
    return contents.unit or 1.0


def doubt(contents: DrawingContents, bounds: Bounds, scale: float) -> PlanQuestion | None:
    """What to ask about a plan whose size is none of a room or a building, or None.

    `bounds` are in units of the file. It is asked only where nobody has said the unit.
    """
    side = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    in_metres = contents.unit is not None and contents.path.suffix.lower() != ".dxf"
    if in_metres or SMALLEST <= side * scale <= LARGEST:
        return None
    says = "$INSUNITS says" if contents.unit is not None else "a unit is 1 m unless said"
    here = next((name for name, metres in UNITS.items() if math.isclose(metres, scale)), None)
    if contents.unit is not None:
        says = f"{says} {here}" if here else f"{says} {scale:g} m per unit"
    choices = [
        f"--unit {name} ({side * UNITS[name]:.4g} m)"
        for name in SUGGESTED
        if SMALLEST <= side * UNITS[name] <= LARGEST and UNITS[name] != scale
    ]
    keep = f"--unit {here}" if here else f"--scale {scale:g}"
    other = f", else {' or '.join(choices)}" if choices else ""
    answers = [
        PlanChoice(f"1 unit is 1 {name} ({side * UNITS[name]:.4g} m wide)", {"unit": name})
        for name in dict.fromkeys([*([here] if here else []), *SUGGESTED])
        if name == here or SMALLEST <= side * UNITS[name] <= LARGEST
    ]
    return PlanQuestion(
        f"{contents.path}: the plan would be {side * scale:.4g} m wide ({says}): give {keep} if "
        f"that is so{other}",
        tuple(answers),
    )
