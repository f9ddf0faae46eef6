"""A recorded trial of motion capture, C3D, through `ezc3d`.

A body is either a rotation that the file holds (a matrix per frame, as Visual3D and Theia write) or
two markers that are declared: one on the rear axle, where the body is, and one towards the nose.
A marker that the file has not is NaN, and the body then is not tracked.
"""

from __future__ import annotations

import io
import json
import math
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.live.control.pose import Sighting
from app.live.sources.axes import Axes
from app.live.sources.pose_source import RecordedFrame
from app.live.sources.room_tables import MarkedBody, RoomTrial, marked_sighting, unit_of_trial
from app.sandboxed_reader import read_in_sandbox
from worlds.input_error import InputError, unknown
from worlds.plug_ins import demand


def read_trial(
    path: Path, axes: Axes, bodies: tuple[MarkedBody, ...] = (), unit: str = ""
) -> list[RecordedFrame]:
    """The frames of a C3D file; its own unit of length counts, not that of `axes`.

    `unit` is what is declared for a file that has none, or one that is not known; empty if nothing
    is. Raises InputError if the file cannot be read, has no such marker, or nothing makes a body.
    """
    trial = _opened(path)
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


def _opened(path: Path) -> Any:
    """A C3D file, as `ezc3d` has it, as far as it is used here. Raises InputError."""
    demand("ezc3d", "a C3D file", "live")
    if not path.is_file():
        raise InputError(f"{path} cannot be read: there is no such file")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}") from None
    try:
        packed = read_in_sandbox(f"{__name__}:trial_as_arrays", path.name, content)
    except InputError as refusal:
        if "within" in str(refusal):
            raise
        raise InputError(f"{path} is not a C3D file") from None
    with np.load(io.BytesIO(packed), allow_pickle=False) as arrays:
        told = json.loads(arrays["told"].tobytes())
        data = {name: arrays[name] for name in ("points", "rotations")}
        data["meta_points"] = {"residuals": arrays["residuals"]}
    return told | {"data": data}


def trial_as_arrays(name: str, content: bytes) -> bytes:
    """In a process of its own: what of a C3D file is used here, as arrays and JSON.

    `ezc3d` ends the process that reads some damaged files. Raises InputError.
    """
    import ezc3d

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "trial.c3d"
        path.write_bytes(content)
        try:
            trial = ezc3d.c3d(str(path))
        except (OSError, RuntimeError, ValueError, IndexError, KeyError, TypeError):
            raise InputError(f"{name} is not a C3D file") from None
    parameters = {
        group: {
            key: {"value": np.asarray(held["value"]).tolist()}
            for key, held in trial["parameters"].get(group, {}).items()
            if key in ("UNITS", "RATE") or key.startswith("LABELS")
        }
        for group in ("POINT", "ROTATION")
    }
    first = int(trial["header"]["points"]["first_frame"])
    told = {"parameters": parameters, "header": {"points": {"first_frame": first}}}
    data = trial["data"]
    packed = io.BytesIO()
    np.savez(
        packed,
        told=np.frombuffer(json.dumps(told).encode(), np.uint8),
        points=data["points"],
        rotations=data["rotations"],
        residuals=data["meta_points"]["residuals"],
    )
    return packed.getvalue()


def read_marker_trial(path: Path) -> RoomTrial:
    """The markers of a C3D file, or else its rotations, in its axes. Raises InputError.

    Their unit is empty where the file says none, or none that is known.
    """
    trial = _opened(path)
    units = trial["parameters"]["POINT"].get("UNITS", {}).get("value", [])
    points, group = _points(trial), "POINT"
    names = _labels(trial, "POINT")[: points.shape[1]]
    if not points.size and trial["data"]["rotations"].size:
        group, names = "ROTATION", _labels(trial, "ROTATION")
        points = trial["data"]["rotations"][:3, 3]
    if not points.size or len(names) != points.shape[1]:
        raise InputError(f"{path} has no markers, or not a name for each")
    rate = _rate(path, trial, group)
    first = int(trial["header"]["points"]["first_frame"])
    frame = first + np.arange(points.shape[2])
    return RoomTrial(
        tuple(names),
        points.transpose(2, 1, 0),
        None,
        frame,
        frame / rate,
        units[0].strip().lower() if len(units) else "",
        "C3D",
    )


def _points(trial: Any) -> np.ndarray:
    """The markers (3, M, F), NaN where one is not seen: its residual is below 0 there."""
    points = trial["data"]["points"][:3].astype(float)
    residuals = trial["data"].get("meta_points", {}).get("residuals")
    if residuals is not None and residuals.shape[1:] == points.shape[1:]:
        points[:, residuals[0] < 0.0] = np.nan
    return points


def _of_markers(
    path: Path, trial: Any, axes: Axes, bodies: tuple[MarkedBody, ...]
) -> dict[str, list[Sighting]]:
    """The track of every body that is declared by two markers."""
    labels = _labels(trial, "POINT")
    points = _points(trial)
    for body in bodies:
        for marker in (body.rear, body.front):
            if marker not in labels:
                raise unknown("marker", marker, labels, str(path))
    return {
        body.name: [
            marked_sighting(body.name, rear, front, axes)
            for rear, front in zip(
                points[:, labels.index(body.rear)].T,
                points[:, labels.index(body.front)].T,
                strict=True,
            )
        ]
        for body in bodies
    }


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
    says = units[0].strip().lower() if len(units) else ""
    return unit_of_trial(path, says, declared, "POINT:UNITS")


def _rate(path: Path, trial: Any, group: str) -> float:
    """Frames per second of the points or the rotations."""
    rates = trial["parameters"][group].get("RATE", {}).get("value", [])
    rate = float(rates[0]) if len(rates) else 0.0
    if not 0.0 < rate < math.inf:
        raise InputError(f"{path}, {group}:RATE = {rate:g} is not a number of frames per second")
    return rate
