"""A flock in space: faces put through a camera, the farthest first, shaded and paling away."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from app.viewer.pictures import key
from app.viewer.pictures.picture_camera import Camera
from app.viewer.pictures.plane import ring, tail_angles
from app.viewer.pictures.shot import Shot
from app.viewer.scene.cameras.camera import UP, CameraView
from app.viewer.scene.draw.agent_meshes import PLAIN_FISH, PLAIN_OUTLINE, turn_tails
from app.viewer.scene.draw.agent_shapes import SWIMMER
from app.viewer.scene.draw.projected_density import Lens, count_by_depth, projected_density
from app.viewer.scene.draw.shapes import Mesh, ball, dart
from app.viewer.scene.draw.solids import join_meshes, prism
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.agents import dart_rows
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import FISH
from app.worlds.world_picture import GOAL, INK, PALE, PATH
from worlds.mission import Mission
from worlds.world import World

LIGHT = np.array([-0.35, -0.45, 0.82])
"""Where light comes from."""
DARKEST, FADES = 0.62, 0.42
"""Of a face away from the light; how far what is farthest has the colour of the air."""
SHADOW = "#9aa7b8"
LINES = 8
"""Lines of the floor along its longest side."""
ZOOM = 0.93
"""Of what the page's camera shows, how much is shown: there is no panel beside it."""
DART = (0, 1, 3, 2)
"""The edge of a dart from above, by its corners."""
PIECE = 0.12
"""Longest side of a face of what is solid, as a share of the world's."""


class CameraAxes(NamedTuple):
    """A camera, as three axes."""

    view: CameraView
    right: np.ndarray
    over: np.ndarray
    back: np.ndarray

    @staticmethod
    def of(view: CameraView) -> CameraAxes:
        """The axes of a point of view."""
        back = view.position - view.target
        back = back / np.linalg.norm(back)
        right = np.cross(UP, back)
        right = right / np.linalg.norm(right)
        return CameraAxes(view, right, np.cross(back, right), back)

    def seen(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (..., 3) as they are seen (..., 2), upwards from -1 to 1; how far away (...)."""
        apart = points - self.view.position
        away = np.maximum(-(apart @ self.back), 1e-6)
        across = np.stack([apart @ self.right, apart @ self.over], axis=-1)
        return across / (away * np.tan(0.5 * self.view.fov))[..., None], away

    def ahead(self, points: np.ndarray) -> np.ndarray:
        """How far points (..., 3) are before the nearest that is drawn, (...)."""
        return -((points - self.view.position) @ self.back) - self.view.near

    def lines(self, segments: np.ndarray) -> np.ndarray:
        """Segments (K, 2, 3) as they are seen (M, 2, 2), cut off where the camera is."""
        ahead = self.ahead(segments)
        segments, ahead = segments[(ahead > 0.0).any(axis=1)], ahead[(ahead > 0.0).any(axis=1)]
        cut = segments.copy()
        for end, other in ((0, 1), (1, 0)):
            behind = ahead[:, end] < 0.0
            share = ahead[behind, other] / (ahead[behind, other] - ahead[behind, end])
            begin = segments[behind, other]
            cut[behind, end] = begin + share[:, None] * (segments[behind, end] - begin)
        return self.seen(cut)[0]


class SpacePicture:
    """The scene on its axes. `signs` explain what of the world is drawn."""

    def __init__(self, axes: Any, world: World, aspect: float, camera: Camera):
        from matplotlib.collections import LineCollection, PolyCollection

        self.axes, self.world, self.camera, self.aspect = axes, world, camera, aspect
        self.stage = Stage(3, world.size, tuple(map(bool, world.wraps)), tuple(world.low))
        self.solid = solids(world, self.stage)
        self.signs: list[Any] = key.signs_of(world, bool(len(self.solid[1])))
        self.floor: Any = PolyCollection([], facecolors="#fbfcfe", edgecolors="none", zorder=1)
        self.lines: Any = LineCollection([], colors="#dfe5ee", linewidths=0.7, zorder=2)
        self.shadows: Any = PolyCollection([], facecolors=SHADOW, edgecolors="none", alpha=0.35,
                                      zorder=3)  # fmt: skip
        self.behind: Any = LineCollection([], colors=PALE, linewidths=1.0, zorder=4)
        self.way: Any = LineCollection([], colors=PATH, linewidths=1.4, linestyles=(0, (6, 2.5)),
                                  zorder=5)  # fmt: skip
        self.faces: Any = PolyCollection([], zorder=8, closed=True)
        (self.goal,) = axes.plot([], [], "*", color=GOAL, markersize=14, markeredgecolor="white",
                                 markeredgewidth=0.8, zorder=9)  # fmt: skip
        self.ring = ring(axes)
        self.density: Any = None
        """The image of a flock of which no agent can be told apart."""
        self.before: Any = LineCollection([], colors="#64748b", linewidths=1.1, zorder=10)
        for one in (self.floor, self.lines, self.shadows, self.behind, self.way, self.faces,
                    self.before):  # fmt: skip
            axes.add_collection(one, autolim=False)
        self.moving: list[Any] = [self.shadows, self.behind, self.way, self.faces, self.goal,
                                  self.ring, self.before]  # fmt: skip
        """What changes from tick to tick; with a camera that follows, all does."""
        axes.set(xlim=(-ZOOM * aspect, ZOOM * aspect), ylim=(-ZOOM, ZOOM), aspect="equal")
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        axes.set_facecolor("none")

    def begin(self, shot: Shot) -> None:
        """Look at the world, and say what is drawn of its flock."""
        if shot.made.shows_density:
            self.signs.append(key.faint_sign("steep"))
        self.look(shot)

    def look(self, shot: Shot) -> None:
        """Look at the world from where the camera is at a shot."""
        self.eye = CameraAxes.of(self.camera.view(shot, self.aspect))
        self.draw_box()

    def draw_box(self) -> None:
        """Floor, its lines, the edges of the box, and the path, as the camera sees them now."""
        half, eye = self.stage.half, self.eye
        corners = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]]) * half
        whole = bool((eye.ahead(corners) > 0.0).all())
        self.floor.set_verts([eye.seen(corners)[0]] if whole else [])
        step = 2.0 * max(half[:2]) / LINES
        rows = []
        for axis, other in ((0, 1), (1, 0)):
            for at in np.arange(-half[axis], half[axis] + 0.5 * step, step):
                ends = np.full((2, 3), -half[2])
                ends[:, axis] = min(at, half[axis])
                ends[:, other] = -half[other], half[other]
                rows.append(ends)
        self.lines.set_segments(eye.lines(np.array(rows)))
        near, far = box_edges_by_depth(half, eye)
        self.before.set_segments(eye.lines(near))
        self.behind.set_segments(eye.lines(far))
        mission = self.world.mission or Mission()
        if mission.path:
            points = np.array(mission.path.waypoints, float)
            shown = self.stage.to_display(points[:, :3]) if points.shape[1] == 3 else None
            if shown is not None:
                self.way.set_segments(eye.lines(np.stack([shown[:-1], shown[1:]], axis=1)))

    def rule(self, _figure: Any, shot: Shot, _y: float) -> None:
        """A bar along the nearest edge of the floor, with words; where the camera stands still."""
        if self.camera.moves:
            return
        length, words = key.ruler(shot, 0.3 * max(self.world.size[:2]))
        half, eye = self.stage.half, self.eye
        away = 0.045 * self.stage.side
        begin = np.array([-half[0], -half[1] - away, -half[2]])
        end = begin + np.array([length * self.stage.scale, 0.0, 0.0])
        tick = np.array([0.0, 0.25 * away, 0.0])
        x, y = eye.seen(np.array([begin, end]))[0].T
        self.axes.plot(x, y, color=INK, linewidth=1.6, solid_capstyle="butt", clip_on=False)
        for at in (begin, end):
            ends = eye.seen(np.array([at - tick, at + tick]))[0]
            self.axes.plot(*ends.T, color=INK, linewidth=1.6, clip_on=False)
        middle = eye.seen(0.5 * (begin + end) - [0.0, 1.5 * away, 0.0])[0]
        self.axes.text(*middle, words, ha="center", va="top", fontsize=10, color=INK)

    def show(self, shot: Shot) -> None:
        """Move the agents to where they are."""
        if self.camera.moves:
            self.look(shot)
        made, at, follow = shot.made, shot.made.at, self.camera.follow
        rows: Any = slice(None)
        if made.shows_density:
            self.draw_density(shot)
            rows = dart_rows(made)
        faces, outline = (PLAIN_FISH[1], PLAIN_OUTLINE) if made.form == FISH else (dart()[1], DART)
        corners = agent_corners(shot, rows)
        triangles = corners[:, faces].reshape(-1, 3, 3)
        colour = np.repeat(made.colour[rows], len(faces), axis=0)
        if len(self.solid[1]):
            vertices, faces = self.solid
            triangles = np.concatenate([triangles, vertices[faces]])
            colour = np.concatenate([colour, np.tile(palette.SOLID, (len(faces), 1))])
        flat, lit = self.lit(triangles, colour)
        self.faces.set_verts(flat)
        self.faces.set_facecolor(lit)
        self.faces.set_edgecolor(lit)
        self.faces.set_linewidth(0.25)
        under = corners[:, outline].copy()
        under[..., 2] = -self.stage.half[2]
        under = under[(self.eye.ahead(under) > 0.0).all(axis=1)]
        self.shadows.set_verts(self.eye.seen(under)[0])
        if follow is not None:
            self.ring.set_data(*self.eye.seen(at[[shot.row_of(follow)]])[0].T)
        goal = made.frame.progress.goal
        seen: Any = (
            ([], []) if goal is None else self.eye.seen(self.stage.to_display(goal)[None])[0].T
        )
        self.goal.set_data(*seen)

    def draw_density(self, shot: Shot) -> None:
        """Draw where agents are dense, and where they head, under what is solid."""
        frame, view = shot.made.frame, self.eye.view
        there = ~frame.is_down
        position, heading = shot.position[there], shot.now.heading[there]
        fov = 2.0 * np.arctan(ZOOM * np.tan(0.5 * view.fov))
        lens = Lens.of(view.position, view.target, UP, fov, self.aspect, shot.made.stage)
        counts = np.zeros(1, np.int64)
        count_by_depth(position, lens.axes, view.near, np.inf, counts)
        made = projected_density([(position, heading, lens, view.near)], self.aspect, counts[0])
        drawn = np.where(np.isfinite(made.depth), 255, 0).astype(np.uint8)
        pixels = np.dstack([made.pixels, drawn])
        if self.density is None:
            limits = self.axes.get_xlim(), self.axes.get_ylim()
            self.density = self.axes.imshow(
                pixels, extent=(*limits[0], *limits[1]), interpolation="bilinear", zorder=7
            )
            self.axes.set(xlim=limits[0], ylim=limits[1])
            self.moving.append(self.density)
        self.density.set_data(pixels)

    def lit(self, triangles: np.ndarray, colour: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles (T, 3, 3) that face the camera, the farthest first, and their colours."""
        there = (self.eye.ahead(triangles) > 0.0).all(axis=1)
        triangles, colour = triangles[there], colour[there]
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        length = np.linalg.norm(normal, axis=1)
        normal /= np.where(length > 0.0, length, 1.0)[:, None]
        middle = triangles.mean(axis=1)
        outward = np.einsum("ij,ij->i", normal, self.eye.view.position - middle) > 0.0
        triangles, colour, normal = triangles[outward], colour[outward], normal[outward]
        flat, away = self.eye.seen(triangles)
        depth = away.mean(axis=1)
        order = np.argsort(-depth)
        bright = DARKEST + (1.0 - DARKEST) * np.clip(
            0.5 + 0.5 * normal @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1
        )
        near, far = self.span()
        pale = FADES * np.clip((depth - near) / (far - near), 0.0, 1.0)[:, None]
        lit = colour * bright[:, None]
        return flat[order], (lit + pale * (palette.FOG - lit))[order]

    def span(self) -> tuple[float, float]:
        """How far the nearest and the farthest corner of the box are."""
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        away = self.eye.seen(corners * self.stage.half)[1]
        return float(away.min()), float(away.max()) + 1e-9


def agent_corners(shot: Shot, rows: Any) -> np.ndarray:
    """The corners (N, K, 3) of the agents of some rows, as darts or as fish."""
    made, now = shot.made, shot.now
    at, heading = made.at[rows], now.heading[rows]
    length = made.length * made.size[rows]
    if made.form != FISH:
        return placed_corners(dart()[0], at, heading, length)
    fish = turn_tails(PLAIN_FISH[0], tail_angles(now.ids[rows], now.tick))
    return placed_corners(fish, at, heading, SWIMMER.scale * length)


def placed_corners(
    corners: np.ndarray, at: np.ndarray, heading: np.ndarray, length: np.ndarray
) -> np.ndarray:
    """Corners (K, 3), or of each (N, K, 3), at places (N, 3), along headings (N, 3), level, of each
    length: (N, K, 3)."""
    left = np.cross(UP, heading)
    size = np.linalg.norm(left, axis=1, keepdims=True)
    left = np.where(size > 1e-9, left / np.maximum(size, 1e-9), [0.0, 1.0, 0.0])
    axes = np.stack([heading, left, np.cross(heading, left)], axis=1)
    each = np.broadcast_to(corners, (len(at), *corners.shape[-2:]))
    return at[:, None] + length[:, None, None] * np.einsum("nkj,njd->nkd", each, axes)


def box_edges_by_depth(half: np.ndarray, eye: CameraAxes) -> tuple[np.ndarray, np.ndarray]:
    """The edges of the box, (K, 2, 3): those before all that is in it, and all others."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    away = eye.seen(corners)[1]
    nearest = corners[np.argmin(away)]
    near: list[np.ndarray] = []
    far: list[np.ndarray] = []
    for a in range(8):
        for b in range(a + 1, 8):
            if np.count_nonzero(corners[a] != corners[b]) == 1:
                ends = np.array([corners[a], corners[b]])
                is_near = (ends == nearest).all(axis=1).any()
                (near if is_near else far).append(ends)
    return np.array(near), np.array(far)


def solids(world: World, stage: Stage) -> Mesh:
    """What stands in a world as one mesh on the display, of faces small enough to be sorted."""
    meshes = []
    for one in world.obstacles:
        for outline, bottom, top in one.spans():
            low = world.low[2] if bottom is None else bottom
            high = world.low[2] + world.size[2] if top is None else top
            meshes.append(prism(outline, low, high))
        for centre, radius in one.spheres():
            vertices, faces = ball()
            meshes.append((np.asarray(centre) + radius * vertices, faces))
    vertices, faces = join_meshes(meshes)
    if not len(faces):
        return vertices, faces
    shown = split(stage.to_display(vertices)[faces], PIECE * stage.side)
    return shown.reshape(-1, 3), np.arange(3 * len(shown)).reshape(-1, 3)


def split(triangles: np.ndarray, longest: float) -> np.ndarray:
    """Triangles (T, 3, 3) halved across their longest side until none is longer."""
    done = []
    while len(triangles):
        sides = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        which = np.argmax(sides, axis=1)
        long = sides.max(axis=1) > longest
        done.append(triangles[~long])
        cut, first = triangles[long], which[long]
        rows = np.arange(len(cut))
        a, b, c = (cut[rows, (first + k) % 3] for k in range(3))
        middle = 0.5 * (a + b)
        triangles = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
    return np.concatenate(done)
