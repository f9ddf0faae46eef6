"""The mission on the display: start region, path with numbered waypoints, goal and its route."""

from __future__ import annotations

from typing import Any

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import ball, box_edges, circle, dashes, great_circles, ring
from app.viewer.scene.marks.area import fence
from app.viewer.scene.marks.fleet import CarMeshes
from app.viewer.scene.shown import palette
from worlds.mission import Mission
from worlds.world import World

# The injected car: the goal of cars, drawn as a car of its own colour.

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
        at = picture.stage.to_display(goal)
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
            self._azimuth = route_azimuth(picture, at)
        step = at - self._at
        moved = MOVED if picture.live is None else MOVED_LIVE
        if np.hypot(*step) > moved * picture.stage.side:
            self._at, self._azimuth = at, float(np.arctan2(step[1], step[0]))


def route_azimuth(picture: Picture, at: np.ndarray) -> float:
    """Azimuth (rad) of the leg of the goal's route that is nearest to `at` (2,) on the display."""
    mission = picture.frame.world.mission
    if mission is None or mission.goal is None or len(mission.goal.route) < 2:
        return 0.0
    route = picture.stage.to_display(np.array(mission.goal.route, float))[:, :2]
    ends = np.roll(route, -1, axis=0) if mission.goal.closed else route[1:]
    starts = route[: len(ends)]
    leg = ends - starts
    square = np.maximum(np.sum(leg * leg, axis=1), 1e-12)
    share = np.clip(np.sum((at - starts) * leg, axis=1) / square, 0.0, 1.0)
    away = np.linalg.norm(starts + share[:, None] * leg - at, axis=1)
    dx, dy = leg[int(np.argmin(away))]
    return float(np.arctan2(dy, dx))


ABOVE = 0.015
"""Height above a flat floor at which lines lie."""
DASH = 0.005
"""Of the path, as a multiple of the longest side; gaps are as long."""
DIM = 0.68
"""Share of the backdrop in the colour of what lies behind the information agents."""
NUMBERED = 24
"""Most waypoints that are numbered."""
LEAST_GOAL = 0.022
"""Radius of the goal's ring as a multiple of the longest side, at least."""
RINGS = ((0.0, 1.0, 0.16), (0.833, 1.2, 0.10), (0.857, 1.4, 0.05))
"""The soft ring of the goal: rings by their hole as a share of them, their radius as a multiple of
the distance at which it is reached, and their opacity."""
SPOT = 0.0065
"""Radius of a waypoint as a multiple of the longest side."""


class MissionMarks:
    """Rebuilt when the world changes; from frame to frame only the goal moves."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._name = f"{root}/mission"
        self._drawn: tuple[Any, ...] | None = None
        self._done: int | None = None
        self._labels: list[Any] = []
        self._ahead = add_lines(scene, f"{self._name}/path/ahead", thickness=2.2)
        self._behind = add_lines(scene, f"{self._name}/path/behind", thickness=2.0)
        self._route = add_lines(scene, f"{self._name}/route", thickness=1.6)
        self._start = add_lines(scene, f"{self._name}/start", thickness=1.6)
        self._sources = add_lines(scene, f"{self._name}/sources", thickness=1.6)
        self._exits = add_lines(scene, f"{self._name}/exits", thickness=1.6)
        self._goal = GoalMark(scene, f"{self._name}/goal")
        self._injected = InjectedCar(scene, f"{self._name}/goal")
        self._spots = scene.add_batched_meshes_simple(
            f"{self._name}/path/waypoints",
            *ball(),
            batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
            batched_positions=np.zeros((1, 3)),
            batched_scales=np.ones(1),
            batched_colors=np.zeros((1, 3), dtype=np.uint8),
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )

    def draw(self, picture: Picture) -> Changes:
        """Draw what the look asks for."""
        world, look = picture.frame.world, picture.look
        mission = world.mission or Mission()
        key = (world, picture.stage, look.mission, look.start, look.fence, picture.frame.run)
        changes: Changes = []
        if key != self._drawn:
            self._drawn, self._done = key, None
            changes += self._draw_start(picture) + self._draw_route(picture, mission)
            changes += self._draw_gates(picture, mission)
            self._write(picture, world)
        done = picture.frame.progress.done
        if done != self._done:
            self._done = done
            changes += self._draw_path(picture, mission, done)
        goal = picture.frame.progress.goal if look.mission else None
        injected, target = (goal, None) if picture.as_cars else (None, goal)
        changes += self._injected.draw(picture, injected)
        return changes + self._goal.draw(picture, target, mission.settle)

    def _draw_start(self, picture: Picture) -> Changes:
        """The box in which the agents start, dashed; the fence of cars may stand for it."""
        room, fenced = picture.frame.room, fence(picture)
        hidden = fenced is not None and room is not None and np.allclose(room, fenced)
        if room is None or hidden or not picture.look.start:
            return [(self._start, "visible", False)]
        lines = dashed_box(picture, *room)
        colour = picture.mix_with_backdrop(palette.START, 0.35)
        return segments(self._start, lines, palette.node_colour(colour))

    def _draw_gates(self, picture: Picture, mission: Mission) -> Changes:
        """The outlines of sources and exits, dashed."""
        world, changes = picture.frame.world, []
        low, high = world.low, tuple(np.add(world.low, world.size))
        boxes = [dashed_box(picture, source.low, source.high) for source in mission.sources]
        outlines = [
            dashed_box(picture, *region.corners(low, high))
            if region.points is None or world.dim == 3
            else dashes(
                floor_places(picture, closed_way(region.points, True)),
                DASH * picture.stage.side,
                DASH * picture.stage.side,
            )[0]
            for region in mission.exits
        ]
        marks = (self._sources, boxes, palette.START), (self._exits, outlines, palette.GOAL)
        for node, lines, colour in marks:
            if not lines or not picture.look.mission:
                changes.append((node, "visible", False))
                continue
            tint = palette.node_colour(picture.mix_with_backdrop(colour, 0.35))
            changes += segments(node, np.concatenate(lines), tint)
        return changes

    def _draw_route(self, picture: Picture, mission: Mission) -> Changes:
        """The way of the goal, if it moves."""
        if mission.goal is None or len(mission.goal.route) < 2 or not picture.look.mission:
            return [(self._route, "visible", False)]
        way = floor_places(picture, closed_way(mission.goal.route, mission.goal.closed))
        dash = DASH * picture.stage.side
        lines, _ = dashes(way, 0.5 * dash, dash)
        return segments(
            self._route, lines, palette.node_colour(picture.mix_with_backdrop(palette.GOAL, 0.45))
        )

    def _draw_path(self, picture: Picture, mission: Mission, done: int) -> Changes:
        """The legs between waypoints and a spot on each; those that are done are dim."""
        nodes = (self._ahead, self._behind, self._spots)
        if mission.path is None or not picture.look.mission:
            return [(node, "visible", False) for node in nodes]
        path, stage = mission.path, picture.stage
        lines, leg = dashes(
            floor_places(picture, closed_way(path.waypoints, path.closed)),
            DASH * stage.side,
            DASH * stage.side,
        )
        behind = (leg < done - 1) & (not path.closed)
        dim = picture.mix_with_backdrop(palette.LEADER, DIM)
        at = floor_places(picture, np.array(path.waypoints, float))
        passed = (np.arange(len(at)) < done) & (not path.closed)
        colour = np.where(passed[:, None], dim, palette.LEADER)
        return [
            *segments(self._ahead, lines[~behind], palette.node_colour(palette.LEADER)),
            *segments(self._behind, lines[behind], palette.node_colour(dim)),
            (self._spots, "batched_positions", at.astype(np.float32)),
            (self._spots, "batched_wxyzs", np.tile([1.0, 0.0, 0.0, 0.0], (len(at), 1))),
            (self._spots, "batched_scales", np.full(len(at), SPOT * stage.side, np.float32)),
            (self._spots, "batched_colors", palette.lit_bytes(colour)),
            (self._spots, "visible", True),
        ]

    def _write(self, picture: Picture, world: World) -> None:
        """Number the waypoints."""
        for label in self._labels:
            label.remove()
        self._labels = []
        mission = world.mission
        if mission is None or mission.path is None or not picture.look.mission:
            return
        at = floor_places(picture, np.array(mission.path.waypoints, float))
        every = -(-len(at) // NUMBERED)
        up = np.array([0.0, 0.0, 1.0]) if picture.stage.dim == 3 else np.array([0.0, 1.0, 0.0])
        for number, place in list(enumerate(at, start=1))[::every]:
            self._labels.append(
                self._scene.add_label(
                    f"{self._name}/path/number/{number}",
                    str(number),
                    position=place + 1.7 * SPOT * picture.stage.side * up,
                    anchor="bottom-center",
                    font_screen_scale=0.8,
                )
            )


class GoalMark:
    """The gamma agent: a bead, a line as far around it as it counts as reached, and a soft ring."""

    def __init__(self, scene: SceneApi, name: str) -> None:
        self._bead = scene.add_mesh_simple(
            f"{name}/bead",
            *ball(),
            color=palette.node_colour(palette.GOAL, palette.LIGHT),
            visible=False,
        )
        self._soft = [
            scene.add_mesh_simple(
                f"{name}/soft/{k}",
                *ring(within),
                color=palette.node_colour(palette.GOAL),
                opacity=opacity,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
                visible=False,
            )
            for k, (within, _, opacity) in enumerate(RINGS)
        ]
        self._bubble = scene.add_mesh_simple(
            f"{name}/bubble",
            *ball(),
            color=palette.node_colour(palette.GOAL),
            opacity=0.13,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._rim = add_lines(scene, f"{name}/rim", thickness=1.6)
        self._label = scene.add_label(
            f"{name}/label", "goal", anchor="bottom-center", font_screen_scale=1.0, visible=False
        )

    def draw(self, picture: Picture, goal: np.ndarray | None, settle: float) -> Changes:
        """Draw it at `goal`, (dim,), or not at all."""
        nodes = (self._bead, *self._soft, self._bubble, self._rim, self._label)
        if goal is None:
            return [(node, "visible", False) for node in nodes]
        stage = picture.stage
        at = floor_places(picture, goal[None])[0]
        radius = max(settle * stage.scale, LEAST_GOAL * stage.side)
        flat = stage.dim == 2
        up = radius * (np.array([0.0, 1.15, 0.0]) if flat else np.array([0.0, 0.0, 1.15]))
        colour = palette.node_colour(picture.mix_with_backdrop(palette.GOAL, 0.0 if flat else 0.35))
        changes = segments(self._rim, circle() if flat else great_circles(), colour)
        changes += [(node, "position", at) for node in nodes]
        changes += [(self._rim, "scale", radius), (self._bubble, "scale", radius)]
        changes += [(self._bead, "scale", min(0.4 * radius, 0.012 * stage.side))]
        changes += [
            (soft, "scale", radius * share)
            for soft, (_, share, _) in zip(self._soft, RINGS, strict=True)
        ]
        changes += [(soft, "visible", flat) for soft in self._soft]
        changes += [(self._bubble, "visible", not flat), (self._bead, "visible", True)]
        return [*changes, (self._label, "position", at + up), (self._label, "visible", True)]


def dashed_box(picture: Picture, low: Any, high: Any) -> np.ndarray:
    """The edges of a box with these corners (dim,), dashed, on the display; pieces (K, 2, 3)."""
    begin, end = (picture.stage.to_display(np.array(corner, float)) for corner in (low, high))
    edges = box_edges(0.5 * (end - begin)) + 0.5 * (begin + end)
    if picture.stage.dim == 2:
        edges[..., 2] = ABOVE
    dash = DASH * picture.stage.side
    return np.concatenate([dashes(edge, dash, dash)[0] for edge in edges])


def closed_way(points: Any, closed: bool) -> np.ndarray:
    """Points (K, dim), the first once more at the end if the way is closed."""
    way = np.array(points, float)
    return np.concatenate([way, way[:1]]) if closed else way


def floor_places(picture: Picture, points: np.ndarray) -> np.ndarray:
    """Places (K, dim) on the display, (K, 3); in a flat world just above its floor."""
    placed = picture.stage.to_display(points)
    if picture.stage.dim == 2:
        placed[:, 2] = ABOVE
    return placed
