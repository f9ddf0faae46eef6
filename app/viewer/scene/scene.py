"""Everything drawn in the three-dimensional view, from a `Frame`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from viser import ClientHandle, SceneClickEvent, ViserServer

from app.viewer.scene.cameras.viewpoints import Sight, Viewpoints
from app.viewer.scene.comparison_nodes import ROOT, ComparisonNodes, meant, sights
from app.viewer.scene.draw.drawn_frame import Changes, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.hands.gizmo import Dragged, Grabbed, LeaderGizmo
from app.viewer.scene.marks.hands.handles import Handles
from app.viewer.scene.marks.world.see_through import FollowedAgent, SeeThrough
from app.viewer.scene.marks.world.world_box import Fog, set_light
from app.viewer.scene.parts import Parts
from app.viewer.scene.picking import slack
from app.viewer.scene.shown.debounce import Debounce
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame

Clicked = Callable[[int | None, np.ndarray, np.ndarray, bool], None]
Chosen = Callable[[ClientHandle, int | None, bool], None]


class Scene:
    """The scene of one server, shared by all its browsers; each keeps its own camera."""

    def __init__(self, server: ViserServer, root: str = "") -> None:
        self._server = server
        scene = server.scene
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        set_light(scene)
        self._roots = root, ROOT
        self._parts = Parts(scene, root)
        self._beside = ComparisonNodes(scene)
        self._fog = Fog(scene)
        self._debounce = Debounce()
        self._gizmo = LeaderGizmo(scene, root)
        self.handles = Handles(scene, root)
        self._viewpoints = Viewpoints(server)
        self._see_through = SeeThrough()
        self._sights: tuple[Sight, ...] = ()
        self._clicked: list[Clicked] = []
        self._chosen: list[Chosen] = []
        scene.on_click()(self._click)  # type: ignore[arg-type]

    def show(self, frame: Frame, look: DrawingStyle) -> None:
        """Draw a frame, and the one beside it if there is one.

        Call it from one thread, at most about 30 times a second.
        """
        frame = self._debounce.debounced(frame)
        shown = picture(frame, look, Stage.of(frame))
        second = frame.beside
        other = None if second is None else picture(second, look, Stage.of(second))
        with self._server.atomic():
            changes: Changes = self._gizmo.draw(shown) + self.handles.draw(shown)
            changes += self._parts.draw_box(shown) + self._beside.draw_box(shown, other)
            is_open = self._parts.is_open or self._beside.is_open
            self._fog.draw(shown.stage, is_open, 1 if other is None else 2)
            changes += self._parts.draw_flock(shown) + self._beside.draw_flock(other)
            for handle, name, value in changes:
                setattr(handle, name, value)
        self._sights = sights(shown, other)
        self._viewpoints.update(self._sights)

    def look_through(self) -> None:
        """Let browsers see the agents that they follow through what is in the way.

        Call it from the thread that draws, also while nothing moves: cameras do.
        """
        self._see_through.look(self._watched)

    def _watched(self) -> list[FollowedAgent]:
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

    def where(self, row: int | None, side: int = 0) -> tuple[float, ...]:
        """Where on the display an agent of the flock `side` was drawn last, (3,); () if nowhere."""
        if row is None or side >= len(self._sights):
            return ()
        shown, aside = self._sights[side]
        return tuple((shown.at[row] + aside).tolist()) if row < len(shown.at) else ()

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
        side, row = meant(self._sights, origin, direction, slack(event.client.camera.fov))
        shown, aside = self._sights[side]
        for callback in self._clicked:
            callback(row, shown.stage.unplaced(origin - aside), direction, side == 1)
        for chosen in self._chosen:
            chosen(event.client, row, side == 1)
