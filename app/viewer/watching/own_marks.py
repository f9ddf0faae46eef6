"""What one browser sees of the agent that it has chosen, and no other browser does.

All of it hangs on one node that goes with the agent from picture to picture; what is drawn is made
anew only a few times a second, since every browser has its own.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from viser import ClientHandle, ViserServer

from agents.inspection import Inspection
from app.viewer.scene.comparison_nodes import ROOT
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.marks.inspected.inspection_marks import InspectionMarks
from app.viewer.scene.marks.inspected.reasons import ReasonMarks
from app.viewer.scene.marks.inspected.zone_marks import ZoneMarks
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame

REDRAWN = 80.0
"""How often a second the marks of all browsers together are made anew."""


@dataclass(frozen=True)
class AgentSelection:
    """The agent that somebody has chosen."""

    row: int
    beside: bool = False
    """Whether it is one of the flock beside."""
    run: int = 0
    """The run that it is of."""

    def side(self, frame: Frame) -> Frame | None:
        """The frame of its flock; None where that is there no more."""
        if frame.run != self.run:
            return None
        flock = frame.beside if self.beside else frame
        return flock if flock is not None and self.row < len(flock.ids) else None


class OwnMarks:
    """The marks in one browser; what all browsers see of the laboratory's own choice is hidden."""

    def __init__(self, client: ClientHandle, choice: AgentSelection):
        self.client, self.choice = client, choice
        root = ROOT if choice.beside else ""
        scene, goes, still = client.scene, f"{root}/own", f"{root}/own_places"
        with client.atomic():
            self.hidden = scene.add_frame(f"{root}/inspected", show_axes=False, visible=False)
            self.goes = scene.add_frame(goes, show_axes=False)
            self.still = scene.add_frame(still, show_axes=False)
            self.marks = (
                InspectionMarks(scene, goes),
                ZoneMarks(scene, goes),
                ReasonMarks(scene, goes, still),
            )
        self.drawn: tuple[Picture, Inspection] | None = None
        self.since = -np.inf
        """When they were made anew, s."""

    def show(self, picture: Picture, now: float, period: float) -> None:
        """Go with the agent; make all anew where there is anything new and it is `period` s ago."""
        seen = picture.frame.others.get(self.choice.row)
        if seen is None:
            return
        with self.client.atomic():
            if self.drawn is None or (
                now >= self.since + period
                and not (picture is self.drawn[0] and seen is self.drawn[1])
            ):
                self.draw(picture, seen)
                self.since = now
            assert self.drawn is not None
            row = self.choice.row
            self.goes.position = picture.at[row] - self.drawn[0].at[row]

    def draw(self, picture: Picture, seen: Inspection) -> None:
        """Make all anew."""
        own = replace(picture, frame=replace(picture.frame, inspected=seen))
        for handle, name, value in [one for part in self.marks for one in part.draw(own)]:
            setattr(handle, name, value)
        self.drawn = picture, seen

    def end(self) -> None:
        """Draw nothing any more; what all browsers see is there again."""
        with self.client.atomic():
            for node in (self.goes, self.still, self.hidden):
                node.remove()


class OwnScene(Scene):
    """The scene of a page on which every browser has marks of its own; for one thread."""

    def __init__(self, server: ViserServer):
        super().__init__(server)
        self.own: dict[int, OwnMarks] = {}
        """By browser."""

    def choose(self, chosen: Iterable[tuple[ClientHandle, AgentSelection]]) -> None:
        """These browsers have chosen these agents; all others have none."""
        wanted = {client.client_id: (client, choice) for client, choice in chosen}
        there = self._server.get_clients()
        for number, marks in list(self.own.items()):
            if number not in wanted or wanted[number][1] != marks.choice:
                del self.own[number]
                if number in there:
                    marks.end()
        for number, (client, choice) in wanted.items():
            if number not in self.own and number in there:
                self.own[number] = OwnMarks(client, choice)

    def show(self, frame: Frame, look: DrawingStyle) -> None:
        super().show(frame, look)
        self.show_own()

    def show_own(self) -> None:
        """Bring the browsers' own marks up to date."""
        now, period = time.monotonic(), len(self.own) / REDRAWN
        there = self._server.get_clients()
        for number, marks in self.own.items():
            side = int(marks.choice.beside)
            if number not in there or side >= len(self._sights):
                continue
            picture = self._sights[side].picture
            if marks.choice.side(self._sights[0].picture.frame) is not None:
                marks.show(picture, now, period)
