"""Everything drawn in the three-dimensional view, from a `Frame`, and which agent a click hits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from viser import ClientHandle, FrameHandle, LabelHandle, SceneApi, SceneClickEvent, ViserServer

from app.viewer.scene.cameras.density_views import DensityViews, RecordedDensity
from app.viewer.scene.cameras.flock_in_sight import FlockInSight
from app.viewer.scene.cameras.viewpoints import (
    TITLE,
    Sight,
    Viewpoints,
    aspect_of,
    mission_places,
)
from app.viewer.scene.draw.drawn_frame import Changes, Picture, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.agents import Agents, FlockMotion
from app.viewer.scene.marks.area import CaptureArea, Fence
from app.viewer.scene.marks.car_outlines import LiveOutlines, StuckMarks
from app.viewer.scene.marks.flock_marks import CrashMarks, Halos, HollowMarks, Links
from app.viewer.scene.marks.gizmo import Dragged, Grabbed, LeaderGizmo
from app.viewer.scene.marks.handles import Handles
from app.viewer.scene.marks.inspection_marks import InspectionMarks, ReasonMarks
from app.viewer.scene.marks.labels import Labels, LiveLabels
from app.viewer.scene.marks.mission_marks import MissionMarks
from app.viewer.scene.marks.obstacle_marks import BoundaryPointMarks, Obstacles
from app.viewer.scene.marks.ribbons import Ribbons
from app.viewer.scene.marks.see_through import FollowedAgent, SeeThrough
from app.viewer.scene.marks.trails import Trails, Wake
from app.viewer.scene.marks.world_box import Fog, Walls, WorldBox, set_light
from app.viewer.scene.marks.zone_marks import ZoneMarks
from app.viewer.scene.shown.debounce import Debounce
from app.viewer.scene.shown.drawing_style import DARTS, DrawingStyle
from app.viewer.scene.shown.frame import Frame


class Parts:
    """A flock and the room around it; nodes are called `root`/..."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._room = (
            WorldBox(scene, root),
            Walls(scene, root),
            Obstacles(scene, root),
            CaptureArea(scene, root),
        )
        self._flight = FlockMotion()
        self._flock = (
            Agents(scene, root, self._flight),
            Halos(scene, root),
            HollowMarks(scene, root),
            Labels(scene, root),
            Links(scene, root),
            Trails(scene, root),
            Ribbons(scene, root),
            Wake(scene, root, self._flight),
            MissionMarks(scene, root),
            BoundaryPointMarks(scene, root),
            CrashMarks(scene, root),
            StuckMarks(scene, root),
            Fence(scene, root),
            LiveOutlines(scene, root),
            LiveLabels(scene, root),
            InspectionMarks(scene, root),
            ZoneMarks(scene, root),
            ReasonMarks(scene, root),
        )

    @property
    def is_open(self) -> bool:
        """Whether the flock has left its box."""
        return self._room[0].is_open

    def draw_box(self, picture: Picture) -> Changes:
        """Bring floor, edges and obstacles up to date: nodes come and go."""
        return [change for part in self._room for change in part.draw(picture)]

    def draw_flock(self, picture: Picture) -> Changes:
        """What is to be changed for this frame."""
        if picture.form != DARTS:
            self._flight.follow(picture)
        return [change for part in self._flock for change in part.draw(picture)]


# The second of two flocks: its own room at some distance from the first, and titles over both.

ROOT = "/beside"
GAP = 0.07
"""Least distance between the rooms, as a multiple of the longest side; with a title, TITLED."""
TITLED = 0.16
WIDE = 1.5
"""A world wider than this many times its depth has the second room below it, not on its right,
where no browser's picture says which is better."""
STEADY = 0.02
"""By which share both rooms have to become larger before they are put otherwise."""
SUNK = 0.02
"""How much lower the second floor lies, so that wide floors do not flicker through each other."""
CELL = 0.05
"""The rooms are whole cells of the floor apart, as a multiple of the longest side."""
LIFT = {2: 0.025, 3: 0.13}
"""Height of a title over its room, as a multiple of the longest side, by dimension."""


@dataclass
class ComparisonNodes:
    """Nodes that are there only while there are two flocks."""

    scene: SceneApi
    parts: Parts | None = None
    frame: FrameHandle | None = None
    titles: tuple[LabelHandle, ...] = ()
    is_over: bool = False
    """Whether the second flock is drawn over the first, in its room."""

    @property
    def is_open(self) -> bool:
        """Whether the second flock is there and has left its box."""
        return self.parts is not None and self.parts.is_open

    def draw_box(self, first: Picture, second: Picture | None, is_below: bool) -> Changes:
        """Make the second room, right of the first or below it, or take it away, and bring it up to
        date. A flock that is drawn over the first has no room of its own."""
        if second is None or self.is_over != first.frame.is_over:
            if self.frame is not None:
                for node in (self.frame, *self.titles):  # With all that is below it.
                    node.remove()
                self.parts, self.frame, self.titles = None, None, ()
            self.is_over = first.frame.is_over
        if second is None:
            return []
        if self.parts is None or self.frame is None:
            self.frame = self.scene.add_frame(ROOT, show_axes=False)
            self.parts = Parts(self.scene, ROOT)
            self.titles = tuple(self._title(name) for name in ("first", "second"))
        aside = offset(first, is_below)
        title, other = self.titles
        name = first.frame.title
        if self.is_over:
            name = f"{name}, hollow · {second.frame.title}"
        changes: Changes = [
            (self.frame, "position", aside),
            (title, "text", name),
            (title, "position", title_place(first)),
            (other, "text", second.frame.title),
            (other, "position", title_place(second) + aside),
            (other, "visible", not self.is_over),
        ]
        changes = [
            change
            for change in changes
            if not np.array_equal(getattr(change[0], change[1]), change[2])
        ]
        return changes if self.is_over else changes + self.parts.draw_box(second)

    def draw_flock(self, second: Picture | None) -> Changes:
        """What is to be changed for this frame."""
        return [] if second is None or self.parts is None else self.parts.draw_flock(second)

    def _title(self, name: str) -> LabelHandle:
        """Not below the room: a browser leaves a label where it is when only its parent moves."""
        return self.scene.add_label(
            f"/titles/{name}", "", anchor="bottom-center", font_screen_scale=1.25
        )


def sights(
    first: Picture, second: Picture | None, is_below: bool | None = None
) -> tuple[Sight, ...]:
    """The pictures and where they stand."""
    here = Sight(first, np.zeros(3))
    return (here,) if second is None else (here, Sight(second, offset(first, is_below)))


def find_clicked(
    sights: tuple[Sight, ...], origin: np.ndarray, direction: np.ndarray, near: float
) -> tuple[int, int | None]:
    """Which flock a click is for, 0 or 1, and the row of the agent that it hits, if any.

    Origin and direction (3,) are of the ray on the display, `near` is the half-width of the cone
    about it (rad). Where it hits nobody it is for the room whose middle it passes more closely.
    """
    for side, (flock_picture, aside) in enumerate(sights):
        radius = 0.5 * flock_picture.length * flock_picture.size
        at = np.where(flock_picture.is_there[:, None], flock_picture.at, np.nan)
        row = pick_agent(origin - aside, direction, at, radius, near)
        if row is not None:
            return side, row
    away = [
        distance_from_middle(origin - aside, direction, flock_picture.stage.floor)
        for flock_picture, aside in sights
    ]
    return int(np.argmin(away)), None


def distance_from_middle(origin: np.ndarray, direction: np.ndarray, floor: float) -> float:
    """How far from the middle a ray meets the floor of a room; infinite if it does not."""
    if direction[2] == 0.0:
        return float("inf")
    share = (floor - origin[2]) / direction[2]
    away = float(np.hypot(*(origin + share * direction)[:2]))
    return away if share > 0.0 and np.isfinite(away) else float("inf")


def room(picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3,) of the world's box and its mission on the display; they do not move."""
    low, high = -picture.stage.half, picture.stage.half.copy()
    for place in mission_places(picture):
        low, high = np.minimum(low, place), np.maximum(high, place)
    return low, high


def stands_below(picture: Picture, aspects: Sequence[float] = (), now: bool = False) -> bool:
    """Whether the second room is to stand below the first, where both are seen larger so.

    `aspects`: width over height of the pictures of all browsers; `now`: whether it stands there.
    """
    if picture.stage.dim != 2:
        return False
    low, high = room(picture)
    side, (width, depth) = picture.stage.side, (high - low)[:2]
    if not aspects:
        return bool(width > WIDE * depth)

    def size(wide: float, deep: float) -> np.ndarray:
        """Of what is so large, as seen in each browser."""
        return np.minimum(np.array(aspects) / wide, 1.0 / (deep + TITLE[2] * side))

    below = size(width, 2.0 * depth + TITLED * side)
    gain = float(np.mean(np.log(below / size(2.0 * width + GAP * side, depth))))
    return gain > (-STEADY if now else STEADY)


def offset(picture: Picture, is_below: bool | None = None) -> np.ndarray:
    """Where the second room's centre is, (3,): right of the first or below it, by default below if
    the first is wide. Where it is drawn over the first, it stands there."""
    if picture.frame.is_over:
        return np.zeros(3)
    low, high = room(picture)
    side, flat = picture.stage.side, picture.stage.dim == 2
    width, depth = (high - low)[:2]
    below = stands_below(picture) if is_below is None else is_below
    away = depth + TITLED * side if below else width + GAP * side
    away = CELL * side * np.ceil(away / (CELL * side))
    return np.array([0.0 if below else away, -away if below else 0.0, -SUNK if flat else 0.0])


def title_place(picture: Picture) -> np.ndarray:
    """Where a room's title stands, (3,)."""
    low, high = room(picture)
    middle, lift = 0.5 * (low + high), LIFT[picture.stage.dim] * picture.stage.side
    if picture.stage.dim == 2:
        return np.array([middle[0], high[1] + lift, 0.0])
    return np.array([middle[0], middle[1], high[2] + lift])


Clicked = Callable[[int | None, np.ndarray, np.ndarray, bool], None]
Chosen = Callable[[ClientHandle, int | None, bool], None]


class Scene:
    """The scene of one server, shared by all its browsers; each keeps its own camera.

    One that is recorded is the same for whoever watches the recording.
    """

    def __init__(self, server: ViserServer, root: str = "", is_recorded: bool = False) -> None:
        self._server = server
        scene = server.scene
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        set_light(scene)
        self._roots = root, ROOT
        self._parts = Parts(scene, root)
        self._beside = ComparisonNodes(scene)
        self._is_below = False
        """Whether the second flock's room stands below the first."""
        self._fog = Fog(scene)
        self._debounce = Debounce()
        self._gizmo = LeaderGizmo(scene, root)
        self.handles = Handles(scene, root)
        self._viewpoints = Viewpoints(server)
        self._see_through = SeeThrough()
        self._density = RecordedDensity(server) if is_recorded else DensityViews(server)
        self._sights: tuple[Sight, ...] = ()
        self._clicked: list[Clicked] = []
        self._chosen: list[Chosen] = []
        scene.on_click()(self._click)  # type: ignore[arg-type]

    def show(self, frame: Frame, look: DrawingStyle) -> None:
        """Draw a frame, and the one beside it if there is one.

        Call it from one thread, at most about 30 times a second.
        """
        frame = self._debounce.debounced(frame)
        drawn_picture = picture(frame, look, Stage.of(frame))
        second = frame.beside
        other = None if second is None else picture(second, look, Stage.of(second))
        if other is not None:
            aspects = [aspect_of(client) for client in self._server.get_clients().values()]
            self._is_below = stands_below(drawn_picture, aspects, self._is_below)
        with self._server.atomic():
            changes: Changes = self._gizmo.draw(drawn_picture) + self.handles.draw(drawn_picture)
            changes += self._parts.draw_box(drawn_picture) + self._beside.draw_box(
                drawn_picture, other, self._is_below
            )
            is_open = self._parts.is_open or self._beside.is_open
            rooms = 1 if other is None or frame.is_over else 2
            self._fog.draw(drawn_picture.stage, is_open, rooms)
            changes += self._parts.draw_flock(drawn_picture) + self._beside.draw_flock(other)
            for handle, name, value in changes:
                setattr(handle, name, value)
        self._sights = sights(drawn_picture, other, self._is_below)
        self._viewpoints.update(self._sights)
        self._density.show(self._sights)

    def follow_cameras(self) -> None:
        """Let browsers see the agents that they follow through what is in the way, and of a flock
        that is a picture of density what their cameras have in sight.

        Call it from the thread that draws, also while nothing moves: cameras do.
        """
        self._see_through.look(self._followed_agents)
        self._density.follow()

    def in_sight(self, client: ClientHandle) -> tuple[FlockInSight, ...]:
        """What one browser sees of flocks that are pictures of density; empty for others."""
        return self._density.in_sight(client)

    def _followed_agents(self) -> list[FollowedAgent]:
        sights = self._sights
        return [
            FollowedAgent(
                client,
                sights[side].picture,
                row,
                client.camera.position - sights[side].aside,
                self._roots[side],
            )
            for client, side, row in self._viewpoints.followed()
        ]

    def display_place(self, row: int | None, side: int = 0) -> tuple[float, ...]:
        """Where on the display an agent of the flock `side` was drawn last, (3,); () if nowhere."""
        if row is None or side >= len(self._sights):
            return ()
        picture, aside = self._sights[side]
        return tuple((picture.at[row] + aside).tolist()) if row < len(picture.at) else ()

    def on_clicked(self, callback: Clicked) -> None:
        """Call `callback(row, origin, direction, beside)` when there is a click into the picture.

        `row` is that of the agent that is hit, None for none; origin and direction (3,) are of the
        ray in the world; `beside` says whether all this is in the second of two flocks. Callbacks
        are called on viser's event loop, click by click.
        """
        self._clicked.append(callback)

    def on_chosen(self, callback: Chosen) -> None:
        """Call `callback(client, row, beside)` when there is a click into one browser's picture.

        Otherwise as `on_clicked`.
        """
        self._chosen.append(callback)

    def on_leader_dragged(self, callback: Dragged) -> None:
        """Call `callback(position, heading)`, world units, while the gizmo is dragged or turned."""
        self._gizmo.on_dragged(callback)

    def on_leader_grabbed(self, callback: Grabbed) -> None:
        """Call `callback(True)` when the gizmo is grabbed and `callback(False)` when let go."""
        self._gizmo.on_grabbed(callback)

    def show_leader_gizmo(self, visible: bool) -> None:
        """Offer, or withdraw, the handles on the information agent."""
        self._gizmo.show(visible)

    def camera(
        self, client: ClientHandle, name: str, whom: tuple[int | None, int] | None = None
    ) -> None:
        """Give one browser a preset point of view, one of `CAMERAS`, or `RIDE` or `STEP_OFF`.

        `RIDE` while riding steps off too; `STEP_OFF` while not riding changes nothing. `whom`: row
        and flock of the agent to follow or to ride on, instead of the inspected one.
        """
        self._viewpoints.place(client, name, whom)

    def open_on(self, camera: str) -> None:
        """Have worlds open on a preset, one of `CAMERAS`; empty: on the usual one."""
        self._viewpoints.first = camera

    def follow(self, client: ClientHandle, row: int | None, side: int = 0) -> None:
        """Let one browser's camera follow the agent in `row` of the flock `side`, or nobody."""
        self._viewpoints.follow(client, row, side)

    def ride(self, client: ClientHandle, row: int | None) -> None:
        """Let one browser's camera ride on the agent in `row`; None changes nothing."""
        self._viewpoints.ride(client, row)

    async def _click(self, event: SceneClickEvent) -> None:
        origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
        if not self._sights:
            return
        side, row = find_clicked(
            self._sights, origin, direction, cone_half_width(event.client.camera.fov)
        )
        picture, aside = self._sights[side]
        for callback in self._clicked:
            callback(row, picture.stage.place_in_world(origin - aside), direction, side == 1)
        for chosen in self._chosen:
            chosen(event.client, row, side == 1)


# Which agent a click means.


SLACK = 0.006
"""Half-width of the cone about the ray in which an agent counts as hit, rad."""
NEAR = 0.013
"""The same as a share of half the height of what a camera sees: some six pixels."""


def cone_half_width(fov: float) -> float:
    """Half-width of the cone for a camera that sees so much from top to bottom (rad), rad."""
    return NEAR * float(np.tan(0.5 * np.clip(fov, 0.01, 2.5)))


def pick_agent(
    origin: np.ndarray,
    direction: np.ndarray,
    at: np.ndarray,
    radius: np.ndarray,
    slack: float = SLACK,
) -> int | None:
    """Row of the agent that a ray hits, or None.

    `at` (N, 3) and `radius` (N,) are in the ray's units, `slack` is the half-width of the cone
    about the ray in which an agent counts as hit, rad. Of several, the nearest to the ray
    relative to its size is meant, a little in favour of those in front; NaN is nowhere.
    """
    if not len(at) or not (np.isfinite(origin).all() and np.isfinite(direction).all()):
        return None
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return None
    away = at - origin
    along = away @ (direction / length)
    aside = np.sqrt(np.maximum(np.einsum("ij,ij->i", away, away) - along**2, 0.0))
    miss = aside / (radius + slack * np.maximum(along, 0.0))
    miss[~((along > 0.0) & (miss <= 1.0))] = np.inf  # nan, of who is not there, too
    best = int(np.argmin(miss + 0.02 * np.nan_to_num(along)))
    return best if np.isfinite(miss[best]) else None
