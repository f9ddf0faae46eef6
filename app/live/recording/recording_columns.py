"""The columns of the tables of a laboratory's recording: what each holds, and in which unit."""

from __future__ import annotations

from typing import Any

from app.live.laboratory.lab_file import Lab

OF_TICK = ("1", "tick at which it was")
WHERE = {
    "x": ("m", "position along x"),
    "y": ("m", "position along y"),
    "yaw": ("rad", "heading, from +x anticlockwise"),
}
COLUMNS: dict[str, dict[str, tuple[str, str]]] = {
    "frames": {
        "tick": ("1", "tick that took the frame"),
        "number": ("1", "the frame's number"),
        "received": ("s", "when it came, on the loop's clock"),
        "sent": ("s", "when it was sent, on the source's own clock, where it tells"),
    },
    "poses": {
        "tick": ("1", "tick that took the frame"),
        "number": ("1", "the frame's number"),
        "received": ("s", "when the frame came, on the loop's clock"),
        "name": ("1", "the body's name"),
        **WHERE,
        "valid": ("1", "whether the tracking saw it"),
    },
    "commands": {
        "tick": OF_TICK,
        "now": ("s", "when the tick began, on the loop's clock"),
        "name": ("1", "the car's name"),
        "wanted_steer": ("1", "steering that the rule wanted, in [-1, 1], left is positive"),
        "wanted_throttle": ("1", "throttle that the rule wanted, in [-1, 1], forwards is positive"),
        "steer": ("1", "steering that was sent, in [-1, 1], left is positive"),
        "throttle": ("1", "throttle that was sent, in [-1, 1], forwards is positive"),
    },
    "companions": {
        "tick": OF_TICK,
        "name": ("1", "the simulated car's name"),
        **WHERE,
        "steer": ("1", "steering, in [-1, 1], left is positive"),
    },
    "events": {
        "tick": OF_TICK,
        "time": ("s", "when it was, on the loop's clock"),
        "kind": ("1", "what kind of event it is"),
        "words": ("1", "what happened"),
        "car": ("1", "the car that it is about"),
        "cause": ("1", "who or what caused it"),
        "asked": ("1", "the request that it answers"),
        "note": ("1", "what more the request said"),
    },
    "ticks": {
        "tick": ("1", "number of the tick"),
        "now": ("s", "when it began, on the loop's clock"),
        "mode": ("1", "what the cars were told: 0 stop, 1 run, 2 emergency stop"),
        "arm": ("1", "what the laboratory might do: safe, armed, emergency"),
        "injected_x": ("m", "the injected car's position along x"),
        "injected_y": ("m", "the injected car's position along y"),
        "injected_yaw": ("rad", "its heading, from +x anticlockwise"),
        "latency": ("s", "from when the newest frame came until its command was sent"),
    },
}
"""The columns of each table: unit, 1 for what has none, and meaning."""


def columns_of(table: str) -> dict[str, dict[str, str]]:
    """Units and meanings of a table's columns, as recordings of simulations have them."""
    return {name: {"unit": unit, "meaning": said} for name, (unit, said) in COLUMNS[table].items()}


def units_of(table: str) -> dict[str, str]:
    """Units of a table's columns, of those that have any."""
    return {name: unit for name, (unit, _) in COLUMNS[table].items() if unit != "1"}


def described(lab: Lab) -> dict[str, Any]:
    """What a table's metadata says of the room beside the text of its laboratory."""
    area = lab.area
    return {
        "time_per_tick": 1.0 / lab.rate,
        "time_unit": "s",
        "length_unit": "m",
        "world_name": "laboratory",
        "world": {
            "title": lab.title,
            "edges": ["open", "open"],
            "dim": 2,
            "low": list(area.low),
            "size": [high - low for low, high in zip(area.low, area.high, strict=True)],
        },
    }
