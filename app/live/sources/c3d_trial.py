"""A recorded trial of motion capture, C3D, through `ezc3d`.

A body is either a rotation that the file holds (a matrix per frame, as Visual3D and Theia write) or
two markers that are declared: one on the rear axle, where the body is, and one towards the nose.
A marker that the file has not is NaN, and the body then is not tracked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.live.control.pose import Pose, Sighting, seen, unseen
from app.live.sources.axes import UNITS, Axes
from app.live.sources.pose_source import RecordedFrame
from worlds.input_error import InputError, shorten, unknown
from worlds.plug_ins import demand

if TYPE_CHECKING:
    import numpy as np

LEAST_APART = 0.01
"""Metres between the two markers of a body below which they give no heading."""


@dataclass(frozen=True, slots=True)
class MarkedBody:
    """A body that two markers make."""

    name: str
    rear: str
    """The marker that says where the body is: on the rear axle."""
    front: str
    """The marker that says where its nose points."""


def read_trial(
    path: Path, axes: Axes, bodies: tuple[MarkedBody, ...] = (), unit: str = ""
) -> list[RecordedFrame]:
    """The frames of a C3D file; its own unit of length counts, not that of `axes`.

    `unit` is what is declared for a file that has none, or one that is not known; empty if nothing
    is. Raises InputError if the file cannot be read, has no such marker, or nothing makes a body.
    """
    demand("ezc3d", "a C3D file", "live")
    import ezc3d

    if not path.is_file():
        raise InputError(f"{path} cannot be read: there is no such file")
    try:
        trial = ezc3d.c3d(str(path))
    except (OSError, RuntimeError, ValueError):
        raise InputError(f"{path} is not a C3D file") from None
    axes = replace(axes, unit=_unit(path, trial, unit))
    tracks = _of_markers(path, trial, axes, bodies) if bodies else _of_rotations(path, trial, axes)
    ups = {} if bodies else _ups(trial, axes)
    rate = _rate(path, trial, "POINT" if bodies else "ROTATION")
    length = len(next(iter(tracks.values())))
    return [
        RecordedFrame(
            number / rate,
            number,
            tuple(track[number] for track in tracks.values()),
            {name: up[number] for name, up in ups.items() if math.isfinite(sum(up[number]))},
        )
        for number in range(length)
    ]


def _of_markers(
    path: Path, trial: Any, axes: Axes, bodies: tuple[MarkedBody, ...]
) -> dict[str, list[Sighting]]:
    """The track of every body that is declared by two markers."""
    labels = _labels(trial, "POINT")
    points = trial["data"]["points"]  # (4, markers, frames)
    for body in bodies:
        for marker in (body.rear, body.front):
            if marker not in labels:
                raise unknown("marker", marker, labels, str(path))
    return {
        body.name: [
            _marked(body.name, rear, front, axes)
            for rear, front in zip(
                points[:3, labels.index(body.rear)].T,
                points[:3, labels.index(body.front)].T,
                strict=True,
            )
        ]
        for body in bodies
    }


def _marked(name: str, rear: np.ndarray, front: np.ndarray, axes: Axes) -> Sighting:
    """A body in one frame, from its two markers (3,)."""
    x, y = axes.floor(rear)
    ahead, aside = axes.floor(front)
    apart = math.hypot(ahead - x, aside - y)
    if not LEAST_APART <= apart < math.inf:  # nor where one of them is NaN
        return unseen(name)
    return seen(name, Pose(x, y, math.atan2(aside - y, ahead - x)))


def _of_rotations(path: Path, trial: Any, axes: Axes) -> dict[str, list[Sighting]]:
    """The track of every rotation of the file."""
    matrices = trial["data"]["rotations"]  # (4, 4, bodies, frames)
    if not matrices.size:
        markers = ", ".join(_labels(trial, "POINT")) or "none"
        raise InputError(
            f"{path} has no rotations: say which markers make a body, as body=NAME,REAR,FRONT "
            f"(its markers: {markers})"
        )
    return {
        name: [
            axes.sighting_from_directions(
                name,
                matrix[:3, 3].tolist(),
                _axis(matrix, axes.nose),
                _axis(matrix, axes.body_top) if axes.body_top else None,
            )
            for matrix in matrices[:, :, body].transpose(2, 0, 1)
        ]
        for body, name in enumerate(_labels(trial, "ROTATION"))
    }


def _axis(matrix: np.ndarray, axis: str) -> list[float]:
    """Where a rotation (4, 4) turns an axis of the body."""
    sign = -1.0 if axis.startswith("-") else 1.0
    return [sign * part for part in matrix[:3, "xyz".index(axis[-1])].tolist()]


def _ups(trial: Any, axes: Axes) -> dict[str, list[tuple[float, float, float]]]:
    """The room's up in the axes of every rotation of the file, frame by frame; NaN in gaps."""
    rows = trial["data"]["rotations"]["xyz".index(axes.up), :3]  # (3, bodies, frames)
    return {
        name: [(x, y, z) for x, y, z in rows[:, body].T.tolist()]
        for body, name in enumerate(_labels(trial, "ROTATION"))
    }


def _labels(trial: Any, group: str) -> list[str]:
    """The labels of a group, which goes on in LABELS2, LABELS3 after 255 of them."""
    parameters = trial["parameters"].get(group, {})
    labels: list[str] = []
    for more in ("LABELS", *(f"LABELS{number}" for number in range(2, 100))):
        if more not in parameters:
            break
        labels.extend(label.strip() for label in parameters[more]["value"])
    return labels


def _unit(path: Path, trial: Any, declared: str) -> str:
    """The unit of length of the file, or what is declared where that says none that is known."""
    units = trial["parameters"]["POINT"].get("UNITS", {}).get("value", [])
    unit = units[0].strip().lower() if len(units) else ""
    if unit in UNITS and declared not in ("", unit):
        raise InputError(f"unit = {declared} is declared, but {path} is in {unit} (POINT:UNITS)")
    if unit not in UNITS and not declared:
        says = f"has the unknown unit of length {shorten(unit)}" if unit else "has no unit"
        raise InputError(
            f"{path} {says} (POINT:UNITS): declare that of its numbers, ?unit={', '.join(UNITS)}"
        )
    return unit if unit in UNITS else declared


def _rate(path: Path, trial: Any, group: str) -> float:
    """Frames per second of the points or the rotations."""
    rates = trial["parameters"][group].get("RATE", {}).get("value", [])
    rate = float(rates[0]) if len(rates) else 0.0
    if not 0.0 < rate < math.inf:
        raise InputError(f"{path}, {group}:RATE = {rate:g} is not a number of frames per second")
    return rate
