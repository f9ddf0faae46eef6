"""A small class: thirty agents for forty ticks."""

from __future__ import annotations

from datetime import UTC, datetime

from app.classroom.collect.hand_in import Point, hand_in
from app.classroom.collect.question import question_of
from app.viewer.run.run_preset import preset_spec

SCENE = preset_spec("vem", agents=30, size=3.0, parameters={"eta": 0.4})
VALUES = {
    "title": "Order against noise",
    "parameter": "eta",
    "measure": {"observe": "polarisation", "over": 10},
    "ticks": 40,
    "values": [0.0, 1.5, 3.0, 4.5, 6.0],
}
ORDER = question_of(VALUES, SCENE)
LED = preset_spec("hwvem", agents=30, size=3.0, world="wrap-plain", parameters={"eta": 0.0})
AGREE = question_of(
    {
        "title": "Until all agree",
        "parameter": "p2",
        "measure": {"until": "consistency >= 0.9984", "hold": 5},
        "ticks": 300,
        "values": [1.0, 5.0, 50.0],
    },
    LED,
)
WHEN = datetime(2026, 3, 2, 10, 15, tzinfo=UTC)


def made(value: float, seed: int = 1, student: str = "Ada", **changes) -> Point:
    """A result of a student who changed more than the noise."""
    spec = SCENE.but(seed=seed, parameters={"eta": value} | changes)
    return hand_in(ORDER, student, spec, SCENE, WHEN)


def told(value: float, result: float | None, student: str = "Ada", seed: int = 1, **more) -> Point:
    """A result that nobody ran."""
    status = "ok" if result is not None else "gave-up"
    spec = f"seed = {seed}\nvalue = {value!r}\n"
    known = {"status": status, "reason": "" if result is not None else "it did not happen"}
    return Point(student, value, result, **(known | {"seed": seed, "ticks": 40, "spec": spec,
                                                     "when": WHEN} | more))  # fmt: skip
