"""Cars for the tests: frames of three cars on an open area, with an injected car."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from app.viewer.scene.draw.drawn_frame import Picture, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Cars, Frame, MissionProgress
from tests.viewer.test_scene_worlds import Stand
from worlds.mission import Goal, Mission
from worlds.world import World

ROUTE = ((2.0, 0.0), (0.0, 2.0), (-2.0, 0.0), (0.0, -2.0))
AREA = World("area", (6.0, 8.0), ("open", "open"), low=(-3.0, -4.0))
ROUND = replace(AREA, mission=Mission(goal=Goal(route=ROUTE, speed=1.0, closed=True)))


def known(count: int = 3, **changes: Any) -> Cars:
    none = np.zeros(count, bool)
    return replace(Cars(0.22, 0.12, np.zeros(count), none, none), **changes)


def frame(tick: int = 0, **changes: Any) -> Frame:
    """Three cars in a row that look along +x, +y and -x."""
    made = Frame(
        run=1,
        tick=tick,
        world=ROUND,
        reach=20.0,
        speed_scale=1.0,
        position=np.array([[-1.0, 0.5], [0.0, 0.5], [1.0, 0.5]]),
        heading=np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
        speed=np.ones(3),
        informed=np.zeros(3, bool),
        ids=np.arange(1, 4),
        dt=0.01,
        unit="s",
        progress=MissionProgress(np.array([2.0, 0.0])),
        cars=known(),
    )
    return replace(made, **changes)


def shown(one: Frame, look: DrawingStyle | None = None) -> Picture:
    return picture(one, look or DrawingStyle(), Stage.of(one))


def node(scene: Stand, end: str) -> Any:
    (found,) = [each for each in scene.sent if each.name.endswith(end)]
    return found
