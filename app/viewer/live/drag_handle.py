"""The handle by which the injected car is dragged, where it is in a person's hand."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from viser import SceneApi, TransformControlsEvent

from app.live.control.tracking_area import TrackingArea
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown.frame import Frame

SETTLE = 0.35
"""Seconds after a release before the handle goes to the car again: frames on their way are old."""

Placed = Callable[[float, float], None]


class DragHandle:
    """Two arrows and a plate on the injected car; what is dragged out of the fence stays at it."""

    def __init__(self, scene: SceneApi, area: TrackingArea, placed: Placed):
        self.area = area
        self.placed = placed
        self.stage: Stage | None = None
        self.holder: int | None = None
        """The browser that holds it."""
        self.released = 0.0
        self.handle = scene.add_transform_controls(
            "/injected_hand",
            scale=85.0,
            fixed=True,
            line_width=3.5,
            active_axes=(True, True, False),
            disable_rotations=True,
            depth_test=False,
            opacity=0.9,
            visible=False,
        )
        self.handle.on_update(self.moved)

    def draw(self, frame: Frame) -> None:
        """Bring the handle to the injected car, unless somebody drags it."""
        self.stage = Stage.of(frame)
        goal = frame.progress.goal
        if goal is None:
            self.handle.visible = False
        elif self.holder is None and time.monotonic() - self.released > SETTLE:
            self.handle.position = self.stage.shown(goal)
            self.handle.visible = True

    async def moved(self, event: TransformControlsEvent) -> None:
        """On the event loop, so that start, updates and end arrive in order."""
        if event.phase == "start":
            self.holder = event.client_id
        if event.client_id != self.holder or self.stage is None:
            return
        place = np.asarray(event.target.position, float)
        if place.shape == (3,) and np.isfinite(place).all():
            x, y = self.stage.world(place)
            self.placed(*self.area.clamp(float(x), float(y)))
        if event.phase == "end":
            self.let_go()

    def let_go(self) -> None:
        """The handle is free again."""
        self.holder, self.released = None, time.monotonic()
