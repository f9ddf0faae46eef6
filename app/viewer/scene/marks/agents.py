"""The agents: darts, birds, fish, cars, or points when there are very many."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from viser import BatchedMeshHandle, SceneApi

from app.viewer.scene.draw.agent_meshes import wing_scales
from app.viewer.scene.draw.agent_shapes import (
    ANIMALS,
    MOTION,
    MOTIONS,
    AgentShape,
    AnimalMotion,
)
from app.viewer.scene.draw.attitude import (
    attitude,
    hinge_offsets,
    quantise_attitudes,
    roll_attitudes,
    rounded_places,
    yaw_attitudes,
)
from app.viewer.scene.draw.drawn_frame import FEW_LEADERS, POINTS_BEYOND, Changes, Picture, rows_of
from app.viewer.scene.draw.shapes import Mesh, dart
from app.viewer.scene.marks.fleet import Fleet, Ghosts
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import DARTS, SHADOWS_UP_TO
from app.viewer.scene.shown.frame import Frame

# How each animal holds itself: a bird banks into its turns and beats its wings, a fish its tail.

GOLDEN = 0.6180339887498949


class Poses(NamedTuple):
    """Of all animals of a frame."""

    wxyz: np.ndarray
    """Attitudes, (N, 4)."""
    beat: np.ndarray
    """Angle of the wings above level, or of the tail, anticlockwise from above, (N,), rad."""


class FlockMotion:
    """Follows one flock from frame to frame; animals keep what they had through changes of rows."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._forget()

    def _forget(self) -> None:
        self._run: tuple[int, int, str] | None = None
        self._motion = MOTION
        self._tick = 0
        self._seen = self._clock()
        self._beats = 0.0
        """Time that they have been beating for, s."""
        self._ids = np.empty(0, dtype=int)
        self._heading = np.empty((0, 3))
        self._lean = np.empty(0)
        """Smoothed tangent of the bank, above 0 to the left."""
        self._effort = np.empty(0)
        """Share of the full swing."""
        self.poses = Poses(np.empty((0, 4)), np.empty(0))
        """Of the frame that was followed last."""

    def follow(self, picture: Picture) -> Poses:
        """The animals of the next frame of a flock."""
        frame = picture.frame
        motion = self._motion = MOTIONS[picture.form]
        run = (frame.run, frame.dim, picture.form)
        if self._run != run or frame.tick < self._tick:
            self._forget()
            self._run, self._tick = run, frame.tick
        heading = np.zeros((len(frame.ids), 3))
        heading[:, : frame.dim] = frame.heading
        self._carry_over(frame.ids, heading)
        now = self._clock()
        passed, ticks = min(now - self._seen, motion.longest), frame.tick - self._tick
        self._seen, self._tick = now, frame.tick
        if ticks > 0:
            self._beats += min(passed, motion.longest_beat)
            turn = left_turns(self._heading, heading) / (ticks * frame.dt)
            lean = bank_tangents(frame, turn, motion)
            self._lean += (1.0 - np.exp(-passed / motion.lean)) * (lean - self._lean)
            effort = efforts(heading, motion)
            self._effort += (1.0 - np.exp(-passed / motion.ease)) * (effort - self._effort)
        self._heading = heading.copy()
        wxyz = roll_attitudes(picture.wxyz, -np.arctan(self._lean))
        beats = self._beats * beat_frequencies(frame.ids, motion)
        phase = 2.0 * np.pi * (beats + frame.ids * GOLDEN)
        beat = motion.dihedral + motion.amplitude * self._effort * np.sin(phase)
        self.poses = self._lay_down(picture, Poses(wxyz, beat))
        return self.poses

    def _carry_over(self, ids: np.ndarray, heading: np.ndarray) -> None:
        """Carry what is known over to the rows of these identities; newcomers are level."""
        if np.array_equal(ids, self._ids):
            return
        rows, known_rows = rows_of(self._ids, ids)
        before, lean, effort = self._heading, self._lean, self._effort
        self._heading, self._lean = heading.copy(), np.zeros(len(ids))
        self._effort = efforts(heading, self._motion)
        self._heading[known_rows] = before[rows]
        self._lean[known_rows], self._effort[known_rows] = lean[rows], effort[rows]
        self._ids = ids.copy()

    def _lay_down(self, picture: Picture, poses: Poses) -> Poses:
        """Those that have crashed: nose down while they fall, then flat."""
        frame = picture.frame
        down = frame.is_down
        if not down.any():
            return poses
        falling = down & (frame.speed > 0.0)
        azimuth = np.arctan2(frame.heading[:, 1], frame.heading[:, 0])
        motion = self._motion
        azimuth = azimuth + np.where(falling, motion.spin * self._beats, 0.0) + frame.ids * GOLDEN
        nose = np.where(falling, motion.dive, 0.0)
        heading = np.column_stack(
            [np.cos(azimuth) * np.cos(nose), np.sin(azimuth) * np.cos(nose), np.sin(nose)]
        )
        wxyz, beat = poses.wxyz.copy(), poses.beat.copy()
        wxyz[down] = attitude(heading[down])
        beat[down] = np.where(falling[down], motion.folded, motion.flat)
        return Poses(wxyz, beat)


def bank_tangents(frame: Frame, rate: np.ndarray, motion: AnimalMotion) -> np.ndarray:
    """v omega / g', the tangents (N,) of the banks that suit turns to the left at a rate (N,).

    The rate is in rad per unit of the flock's time; g' is chosen for the flock's own scale.
    """
    reach = frame.reach if np.isfinite(frame.reach) else float(np.max(frame.size))
    pull = frame.speed_scale**2 / (motion.nimble * max(reach, 1e-9))
    most = motion.steepest
    return np.clip(frame.speed * rate / max(pull, 1e-12), -most, most)


def left_turns(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """How far headings (N, 3) have turned to their left, (N,), rad, at most a right angle."""
    level = np.hypot(before[:, 0], before[:, 1])
    level = np.where(level > 1e-9, level, np.inf)
    left = (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) / level
    return np.arcsin(np.clip(left, -1.0, 1.0))


def efforts(heading: np.ndarray, motion: AnimalMotion) -> np.ndarray:
    """The share of the full swing that animals with headings (N, 3) beat with, (N,)."""
    return np.where(heading[:, 2] < motion.glide, motion.gliding, 1.0)


def beat_frequencies(ids: np.ndarray, motion: AnimalMotion) -> np.ndarray:
    """Beats per second of each, (N,); by its identity, so that no two beat together."""
    return motion.beat * (1.0 + motion.variety * ((ids * GOLDEN * GOLDEN) % 1.0 - 0.5))


# The agents as animals: a body and a pair of wings each, or a trunk and a tail; both are meshes
# with an instance for each agent.


class Animals:
    """What flies or swims."""

    def __init__(self, scene: SceneApi, root: str, flight: FlockMotion, shape: AgentShape) -> None:
        self._flight = flight
        self._scale = shape.scale
        folder = f"{root}/flock/{shape.name}"
        self._nodes = [
            (_add(scene, f"{folder}/{part.name}", part.mesh), part) for part in shape.parts
        ]

    def draw(self, picture: Picture, rows: np.ndarray | slice) -> Changes:
        """Draw the agents of some rows."""
        at = picture.at[rows]
        if not len(at):
            return self.hide()
        poses = self._flight.poses
        wxyz, beat = poses.wxyz[rows], poses.beat[rows]
        size = (self._scale * picture.length * picture.size[rows]).astype(np.float32)
        shadows = picture.look.shadows and len(at) <= SHADOWS_UP_TO
        colour = picture.colour[rows]
        changes: Changes = []
        for node, part in self._nodes:
            place = at + size[:, None] * hinge_offsets(wxyz, part.hinge)
            scale = size[:, None] * (wing_scales(beat) if part.beats == "wings" else np.ones(3))
            turned = yaw_attitudes(wxyz, beat) if part.beats == "tail" else wxyz
            changes += [
                (node, "batched_positions", rounded_places(place, picture.length)),
                (node, "batched_wxyzs", quantise_attitudes(turned)),
                (node, "batched_scales", scale.astype(np.float32)),
                (node, "batched_colors", palette.lit_bytes(part.shade * colour)),
                (node, "cast_shadow", shadows),
                (node, "visible", True),
            ]
        return changes

    def hide(self) -> Changes:
        """Draw nobody."""
        return [(node, "visible", False) for node, _ in self._nodes]


def _add(scene: SceneApi, name: str, mesh: Mesh) -> BatchedMeshHandle:
    return scene.add_batched_meshes_simple(
        name,
        *mesh,
        batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
        batched_positions=np.zeros((1, 3)),
        batched_scales=np.ones((1, 3)),
        batched_colors=np.zeros((1, 3), dtype=np.uint8),
        flat_shading=True,
        side="double",
        lod="off",
        receive_shadow=False,
        visible=False,
    )


POINT_SIZE = {2: 0.6, 3: 0.28}
"""Size of a point as a multiple of the length of a dart, by dimension."""


class Agents:
    """The flock's own nodes in the scene."""

    def __init__(self, scene: SceneApi, root: str, flight: FlockMotion) -> None:
        self._animals = {
            form: Animals(scene, root, flight, shape) for form, shape in ANIMALS.items()
        }
        self._fleet = Fleet(scene, root)
        self._ghosts = Ghosts(scene, root)
        nowhere, level = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
        self._darts = scene.add_batched_meshes_simple(
            f"{root}/flock/darts",
            *dart(),
            batched_wxyzs=level,
            batched_positions=nowhere,
            batched_scales=np.ones(1),
            batched_colors=np.zeros((1, 3), dtype=np.uint8),
            flat_shading=True,
            lod="off",
            receive_shadow=False,
            visible=False,
        )
        self._points = scene.add_point_cloud(
            f"{root}/flock/points",
            nowhere,
            np.zeros((1, 3), dtype=np.uint8),
            point_shape="circle",
            point_shading="flat",
            visible=False,
        )

    def draw(self, picture: Picture) -> Changes:
        if picture.shows_density:
            picture = picture.of_rows(np.asarray(dart_rows(picture)))
        as_points = picture.count > POINTS_BEYOND
        rows, nobody = dart_rows(picture), slice(0, 0)
        form = "cars" if picture.as_cars else picture.form
        return [
            *self._draw_darts(picture, rows if form == DARTS else nobody),
            *(
                change
                for name, animals in self._animals.items()
                for change in animals.draw(picture, rows if form == name else nobody)
            ),
            *self._fleet.draw(picture, rows if picture.as_cars else nobody),
            *self._ghosts.draw(picture),
            *(self._draw_points(picture) if as_points else []),
            (self._points, "visible", as_points),
        ]

    def _draw_darts(self, picture: Picture, rows: np.ndarray | slice) -> Changes:
        at = picture.at[rows]
        if not len(at):
            return [(self._darts, "visible", False)]
        shadows = picture.look.shadows and len(at) <= SHADOWS_UP_TO
        return [
            (self._darts, "batched_positions", rounded_places(at, picture.length)),
            (self._darts, "batched_wxyzs", quantise_attitudes(picture.wxyz[rows])),
            (self._darts, "batched_scales", picture.size[rows] * np.float32(picture.length)),
            (self._darts, "batched_colors", palette.lit_bytes(picture.colour[rows])),
            (self._darts, "cast_shadow", shadows),
            (self._darts, "visible", True),
        ]

    def _draw_points(self, picture: Picture) -> Changes:
        at, colour = picture.at, picture.colour
        if picture.frame.seen is not None:
            at, colour = at[picture.is_there], colour[picture.is_there]
        return [
            (self._points, "points", rounded_places(at, picture.length)),
            (self._points, "colors", (255.0 * colour + 0.5).astype(np.uint8)),
            (self._points, "point_size", POINT_SIZE[picture.stage.dim] * picture.length),
        ]


def dart_rows(picture: Picture) -> np.ndarray | slice:
    """Rows drawn as darts: all, or of very many the few agents that matter; of tracks those that
    are seen, unless a model is drawn over them."""
    if picture.count <= POINTS_BEYOND and not picture.shows_density:
        is_drawn = picture.frame.is_drawn
        return slice(None) if is_drawn is None else np.flatnonzero(is_drawn)
    informed = np.flatnonzero(picture.frame.informed)
    inspected = picture.inspected
    return np.union1d(informed[:FEW_LEADERS], [] if inspected is None else [inspected]).astype(int)
