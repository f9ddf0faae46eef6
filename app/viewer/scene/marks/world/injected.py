"""The injected car: the goal of cars, drawn as a car of its own colour."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.flock.fleet import CarMeshes
from app.viewer.scene.shown import palette

MOVED, MOVED_LIVE = 1e-4, 1.5e-3
"""A move that shows which way it goes, as a multiple of the longest side; among real cars more than
the noise of their tracking."""
CLEAR = 0.8
"""Distance of its name from its middle, as a multiple of its length."""


class InjectedCar:
    """It has no wheels of its own to steer: it looks to where it goes, or has last gone.

    Beside real cars its name is one of `LiveLabels`.
    """

    def __init__(self, scene: SceneApi, name: str) -> None:
        self._car = CarMeshes(scene, f"{name}/car")
        self._label = scene.add_label(
            f"{name}/name",
            "injected car",
            anchor="bottom-center",
            font_screen_scale=1.0,
            visible=False,
        )
        self._run: int | None = None
        self._at = np.zeros(2)
        self._azimuth = 0.0

    def draw(self, picture: Picture, goal: np.ndarray | None) -> Changes:
        """Draw it at `goal`, (2,) in the world, or not at all."""
        cars = picture.frame.cars
        if goal is None or cars is None:
            self._run = None
            return [*self._car.hide(), (self._label, "visible", False)]
        at = picture.stage.shown(goal)
        self._look_ahead(picture, at[:2])
        length = picture.length
        return [
            *self._car.draw(
                at[None],
                np.array([self._azimuth]),
                np.zeros(1),
                np.array([[length, length * cars.width / cars.length]]),
                palette.GOAL[None],
                picture.look.shadows,
            ),
            (self._label, "position", at + np.array([0.0, CLEAR * length, 0.0])),
            (self._label, "visible", picture.live is None),
        ]

    def _look_ahead(self, picture: Picture, at: np.ndarray) -> None:
        """Turn to where it has moved since the last frame; a new one along its route."""
        if self._run != picture.frame.run:
            self._run, self._at = picture.frame.run, at
            self._azimuth = along_route(picture, at)
        step = at - self._at
        moved = MOVED if picture.live is None else MOVED_LIVE
        if np.hypot(*step) > moved * picture.stage.side:
            self._at, self._azimuth = at, float(np.arctan2(step[1], step[0]))


def along_route(picture: Picture, at: np.ndarray) -> float:
    """Azimuth (rad) of the leg of the goal's route that is nearest to `at` (2,) on the display."""
    mission = picture.frame.world.mission
    if mission is None or mission.goal is None or len(mission.goal.route) < 2:
        return 0.0
    route = picture.stage.shown(np.array(mission.goal.route, float))[:, :2]
    ends = np.roll(route, -1, axis=0) if mission.goal.closed else route[1:]
    starts = route[: len(ends)]
    leg = ends - starts
    square = np.maximum(np.sum(leg * leg, axis=1), 1e-12)
    share = np.clip(np.sum((at - starts) * leg, axis=1) / square, 0.0, 1.0)
    away = np.linalg.norm(starts + share[:, None] * leg - at, axis=1)
    dx, dy = leg[int(np.argmin(away))]
    return float(np.arctan2(dy, dx))
