"""All that is drawn of one flock, under one name."""

from __future__ import annotations

from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.flock.agents import Agents
from app.viewer.scene.marks.flock.crash_marks import CrashMarks
from app.viewer.scene.marks.flock.flock_motion import FlockMotion
from app.viewer.scene.marks.flock.halos import Halos
from app.viewer.scene.marks.flock.labels import Labels
from app.viewer.scene.marks.flock.links import Links
from app.viewer.scene.marks.flock.live_labels import LiveLabels
from app.viewer.scene.marks.flock.live_outlines import LiveOutlines
from app.viewer.scene.marks.flock.stuck import StuckMarks
from app.viewer.scene.marks.inspected.inspection_marks import InspectionMarks
from app.viewer.scene.marks.inspected.reasons import ReasonMarks
from app.viewer.scene.marks.inspected.zone_marks import ZoneMarks
from app.viewer.scene.marks.paths.ribbons import Ribbons
from app.viewer.scene.marks.paths.trails import Trails
from app.viewer.scene.marks.paths.wake import Wake
from app.viewer.scene.marks.world.area import CaptureArea
from app.viewer.scene.marks.world.boundary_point_marks import BoundaryPointMarks
from app.viewer.scene.marks.world.fence import Fence
from app.viewer.scene.marks.world.mission_marks import MissionMarks
from app.viewer.scene.marks.world.obstacle_marks import Obstacles
from app.viewer.scene.marks.world.walls import Walls
from app.viewer.scene.marks.world.world_box import WorldBox


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
        if picture.as_birds:
            self._flight.follow(picture)
        return [change for part in self._flock for change in part.draw(picture)]
