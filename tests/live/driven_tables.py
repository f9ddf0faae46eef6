"""Tables of poses of cars that drive round, with the faults that a recording can have."""

import math

from tests.live.recordings import csv_of


def circling(k, phase):
    """(x, y, yaw) of a car at frame k, at 100 Hz and 1 m/s on a circle of 2 m, nose ahead."""
    angle = 0.005 * k + phase
    return 2.0 * math.cos(angle), 2.0 * math.sin(angle), angle + math.pi / 2


def straight(k, phase):
    """(x, y, yaw) of a car that drives along -x at 1 m/s."""
    return 3.0 - 0.01 * k, phase, math.pi


def table(folder, w_first=False, where=circling, frames=400, change=None):
    """A table of two cars, red and blue; `change` alters the rows {name: [x, y, z, q...]}."""
    lines = []
    for k in range(frames):
        rows = {}
        for name, phase in (("red", 0.0), ("blue", 1.5)):
            x, y, yaw = where(k, phase)
            z, w = math.sin(yaw / 2), math.cos(yaw / 2)
            rows[name] = [x, y, 0.05, *((w, 0.0, 0.0, z) if w_first else (0.0, 0.0, z, w))]
        lines += [
            ",".join([f"{0.01 * k:.2f}", str(k), name, *(repr(value) for value in row), "1"])
            for name, row in (change(k, rows) if change else rows).items()
        ]
    return csv_of(folder, lines)


def swapped(begin, end):
    """A change: from frame `begin` to before `end` each car has the other's name."""
    return lambda k, rows: {"red": rows["blue"], "blue": rows["red"]} if begin <= k < end else rows


def leaping(at, x=9.0):
    """A change: in one frame red is seen elsewhere."""
    return lambda k, rows: rows | ({"red": [x, *rows["red"][1:]]} if k == at else {})
