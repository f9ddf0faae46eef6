"""Handles by which a person drags and turns the information agent."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from viser import SceneApi, TransformControlsEvent

from app.viewer.scene.draw.attitude import nose
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.stage import Stage

SETTLE = 0.25
"""Seconds after a release before the gizmo follows the agent again: frames on their way are old."""

Dragged = Callable[[np.ndarray, np.ndarray], None]
Grabbed = Callable[[bool], None]


class LeaderGizmo:
    """Arrows and arcs on the first information agent."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._name = f"{root}/leader_gizmo"
        self._wanted = False
        self._held = False
        self._released = 0.0
        self._picture: Picture | None = None
        self._dragged: list[Dragged] = []
        self._grabbed: list[Grabbed] = []
        self._build(dim=2)

    def on_dragged(self, callback: Dragged) -> None:
        self._dragged.append(callback)

    def on_grabbed(self, callback: Grabbed) -> None:
        self._grabbed.append(callback)

    def show(self, visible: bool) -> None:
        self._wanted = visible
        for handle, name, value in self.draw(self._picture) if self._picture is not None else ():
            setattr(handle, name, value)

    def draw(self, picture: Picture) -> Changes:
        if self._picture is None or self._picture.stage.dim != picture.stage.dim:
            self._build(picture.stage.dim)
        self._picture = picture
        leader = picture.leader
        if not self._wanted or leader is None:
            return [(self._handle, "visible", False)]
        if self._held or time.monotonic() - self._released < SETTLE:
            return []
        return [
            (self._handle, "position", picture.at[leader]),
            (self._handle, "wxyz", picture.wxyz[leader].astype(float)),
            (self._handle, "visible", True),
        ]

    def _build(self, dim: int) -> None:
        self._held = False
        self._handle = self._scene.add_transform_controls(
            self._name,
            scale=95.0,
            fixed=True,
            line_width=3.5,
            active_axes=(True, True, dim == 3),
            disable_sliders=dim == 3,
            depth_test=False,
            opacity=0.9,
            visible=False,
        )
        self._handle.on_update(self._handle_drag)

    async def _handle_drag(self, event: TransformControlsEvent) -> None:
        """On the event loop, so that start, updates and end arrive in order."""
        if event.phase == "start":
            self._held = True
            for grabbed in self._grabbed:
                grabbed(True)
        if self._picture is not None:
            pose = check_pose(self._picture.stage, event.target.position, event.target.wxyz)
            if pose is not None:
                for dragged in self._dragged:
                    dragged(*pose)
        if event.phase == "end":
            self._held = False
            self._released = time.monotonic()
            for grabbed in self._grabbed:
                grabbed(False)


def check_pose(
    stage: Stage, display_position: np.ndarray, wxyz: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """A pose from a browser as position (dim,) and unit heading (dim,), or None if it is none.

    Positions are wrapped or, along axes that do not wrap, kept within four display sides.
    """
    display_position, wxyz = (
        np.asarray(display_position, dtype=float),
        np.asarray(wxyz, dtype=float),
    )
    size = float(np.linalg.norm(wxyz))
    if not (np.isfinite(display_position).all() and np.isfinite(size) and size > 1e-6):
        return None
    position = stage.world(np.clip(display_position, -4.0 * stage.side, 4.0 * stage.side))
    sides, wraps = np.array(stage.size), np.array(stage.wraps)
    position = np.where(wraps, np.mod(position, sides), position)
    heading = nose(wxyz / size)[: stage.dim]
    length = float(np.linalg.norm(heading))
    if length < 1e-6:
        return None
    return position, heading / length
