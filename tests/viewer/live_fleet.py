"""A room with real cars for the tests: three of them, and two simulated ones beside them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from app.viewer.scene.shown.frame import Frame, Live
from tests.viewer.fleet import AREA, frame, known

STATES = ("tracked", "late", "lost", "simulated", "simulated")


def live(**changes: Any) -> Live:
    made = Live(
        names=("red", "blue", "green", "sim 1", "sim 2"),
        roster=("red", "blue", "green", "sim 1", "sim 2"),
        states=STATES,
        ages=np.array([0.004, 0.064, 1.38, 0.0, 0.0]),
        fence=0.4,
        arm="safe",
    )
    return replace(made, **changes)


def live_frame(tick: int = 0, state: Live | None = None, **changes: Any) -> Frame:
    """Five cars in a row that look along +x."""
    made = frame(
        tick,
        world=AREA,
        position=np.column_stack([np.linspace(-2.0, 2.0, 5), np.full(5, 0.5)]),
        heading=np.tile((1.0, 0.0), (5, 1)),
        speed=np.ones(5),
        informed=np.zeros(5, bool),
        ids=np.array([0, 1, 2, 1000, 1001]),
        cars=known(5),
        live=state or live(),
    )
    return replace(made, **changes)


def nobody(one: Frame) -> Frame:
    """The same room before any car was seen."""
    assert one.live is not None
    none = np.empty(0)
    return replace(
        one,
        position=np.empty((0, 2)),
        heading=np.empty((0, 2)),
        speed=none,
        informed=none.astype(bool),
        ids=none.astype(int),
        cars=known(0),
        live=replace(one.live, names=(), states=(), ages=none),
    )
