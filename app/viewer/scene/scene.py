"""Everything drawn in the three-dimensional view, from a `Frame`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from viser import ClientHandle, SceneClickEvent, ViserServer

from app.viewer.frame import Frame
from app.viewer.scene.agents import Agents
from app.viewer.scene.colouring import legend
from app.viewer.scene.gizmo import Dragged, Grabbed, LeaderGizmo
from app.viewer.scene.halos import Halos
from app.viewer.scene.inspection import InspectionMarks
from app.viewer.scene.labels import Labels
from app.viewer.scene.links import Links
from app.viewer.scene.look import Look
from app.viewer.scene.picking import picked
from app.viewer.scene.picture import Changes, Picture, picture
from app.viewer.scene.stage import Stage
from app.viewer.scene.surroundings import Surroundings, set_light
from app.viewer.scene.trails import Trails
from app.viewer.scene.viewpoints import Viewpoints

Clicked = Callable[[int | None], None]


class Scene:
    """The scene of one server, shared by all its browsers; each keeps its own camera."""

    def __init__(self, server: ViserServer) -> None:
        self._server = server
        scene = server.scene
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        set_light(scene)
        self._surroundings = Surroundings(scene)
        self._parts = (
            Agents(scene),
            Halos(scene),
            Labels(scene),
            Links(scene),
            Trails(scene),
            InspectionMarks(scene),
        )
        self._gizmo = LeaderGizmo(scene)
        self._viewpoints = Viewpoints(server)
        self._picture: Picture | None = None
        self._clicked: list[Clicked] = []
        scene.on_click()(self._click)

    def show(self, frame: Frame, look: Look) -> None:
        """Draw a frame. Call it from one thread, at most about 30 times a second."""
        shown = picture(frame, look, Stage.of(frame))
        with self._server.atomic():
            changes: Changes = self._surroundings.draw(shown)
            changes += self._gizmo.draw(shown)
        for part in self._parts:
            changes += part.draw(shown)
        with self._server.atomic():
            for handle, name, value in changes:
                setattr(handle, name, value)
        self._picture = shown
        self._viewpoints.update(shown)

    def legend(self, look: Look, frame: Frame) -> list[tuple[str, str]]:
        """What the colours mean: (words, CSS colour), in reading order."""
        return legend(look, frame)

    def on_agent_clicked(self, callback: Clicked) -> None:
        """Call `callback(row)` when an agent is clicked, `callback(None)` when none is hit."""
        self._clicked.append(callback)

    def on_leader_dragged(self, callback: Dragged) -> None:
        """Call `callback(position, heading)`, world units, while the gizmo is dragged or turned."""
        self._gizmo.on_dragged(callback)

    def on_leader_grabbed(self, callback: Grabbed) -> None:
        """Call `callback(True)` when the gizmo is grabbed and `callback(False)` when let go."""
        self._gizmo.on_grabbed(callback)

    def show_leader_gizmo(self, visible: bool) -> None:
        """Offer, or withdraw, the handles on the information agent."""
        self._gizmo.show(visible)

    def camera(self, client: ClientHandle, name: str) -> None:
        """Give one browser a preset point of view, one of `CAMERAS`."""
        self._viewpoints.place(client, name)

    def follow(self, client: ClientHandle, row: int | None) -> None:
        """Let one browser's camera follow the agent in `row`, or nobody."""
        self._viewpoints.follow(client, row)

    def _click(self, event: SceneClickEvent) -> None:
        shown = self._picture
        if shown is None:
            return
        origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
        row = picked(origin, direction, shown.at, 0.5 * shown.length * shown.size)
        for callback in self._clicked:
            callback(row)
