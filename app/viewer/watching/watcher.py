"""One browser that watches: its plots, the agent that it has chosen, and its camera."""

from __future__ import annotations

import html
import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np
import viser
from viser import ClientHandle, ViserServer

from agents.inspection import Inspection
from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES, default_charts
from app.front.controls import set_value
from app.viewer.lab.panels.inspector import Inspector
from app.viewer.lab.panels.laboratory_plots import WINDOWS, Overlay
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.kept_runs import KeptRuns
from app.viewer.measuring.observable_curves import chart_title, choices
from app.viewer.measuring.observable_format import COUNTED, QUICK, STEADY
from app.viewer.panels.chart import Chart, ChartContents
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.marks.inspection_marks import InspectionMarks, ReasonMarks
from app.viewer.scene.marks.zone_marks import ZoneMarks
from app.viewer.scene.scene import ROOT, Scene
from app.viewer.scene.shown.drawing_style import CAMERA, CAMERAS, RIDE, DrawingStyle
from app.viewer.scene.shown.frame import Frame

# What one browser sees of the agent that it has chosen, and no other browser does.
#
# All of it hangs on one node that goes with the agent from picture to picture; what is drawn is
# made anew only a few times a second, since every browser has its own.

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
    identity: int | None = None
    """Who it is, where agents come and go: once another one is in that row nobody is chosen."""

    def side(self, frame: Frame) -> Frame | None:
        """The frame of its flock; None where that is there no more."""
        if frame.run != self.run:
            return None
        flock = frame.beside if self.beside else frame
        if flock is None or self.row >= len(flock.ids):
            return None
        is_same = self.identity is None or flock.ids[self.row] == self.identity
        return flock if is_same else None


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
            drawn = self.drawn
            if drawn is None or (
                now >= self.since + period and not (picture is drawn[0] and seen is drawn[1])
            ):
                self.draw(picture, seen)
                drawn = self.drawn = picture, seen
                self.since = now
            row = self.choice.row
            self.goes.position = picture.at[row] - drawn[0].at[row]

    def draw(self, picture: Picture, seen: Inspection) -> None:
        """Make all anew."""
        own = replace(picture, frame=replace(picture.frame, inspected=seen))
        for handle, name, value in [one for part in self.marks for one in part.draw(own)]:
            setattr(handle, name, value)

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


# What one browser plots of the run: each chooses for itself, and what it needs is worked out once
# for all who have chosen the same.

CHARTS = 2
POINTS = 200
"""Points of a curve, about: every browser is sent its own."""
MOST = 6
"""Observables that are measured for those who watch, beside those that always are."""
ALWAYS = frozenset((*QUICK, *STEADY, *COUNTED))


@dataclass
class CurveCache:
    """The curves of a run as they are now; worked out when first asked for."""

    runs: tuple[FlockReadings, ...]
    kept: KeptRuns
    """Runs before, of which some are shown."""
    offered: tuple[str, ...]
    """What can be plotted."""
    measured: frozenset[str]
    """What is measured of it."""
    overlays: dict[float, Overlay] = field(default_factory=dict)
    made: dict[tuple[float, tuple[str, ...]], ChartContents] = field(default_factory=dict)

    @property
    def model(self) -> Model:
        """That of the first flock."""
        return self.runs[0].flock.model

    def of(self, names: tuple[str, ...], last: float) -> ChartContents:
        """What a chart of observables shows over the `last` ticks."""
        if (last, names) not in self.made:
            if last not in self.overlays:
                self.overlays[last] = Overlay(self.runs, self.kept, last)
            shown = self.overlays[last].chart_contents(names, keyed=True)
            missing = [name for name in names if name not in self.measured]
            if missing:
                words = html.escape(chart_title(tuple(missing)))
                more = f"{words}: not measured, since the class plots {MOST} others"
                shown = shown._replace(head=f'{shown.head}<div class="fs-quiet">{more}</div>')
            self.made[last, names] = shown
        return self.made[last, names]


def measured_for_all(chosen: Iterable[Iterable[str]]) -> frozenset[str]:
    """What is to be measured for all who watch: of too much, what most of them have chosen."""
    votes = Counter(name for names in chosen for name in set(names) - ALWAYS)
    order = list(OBSERVABLES)
    place = {name: number for number, name in enumerate(order)}
    first = sorted(votes, key=lambda name: (-votes[name], place.get(name, len(place)), name))
    return frozenset(first[:MOST])


class OwnPlots:
    """The charts of one browser, each with the choice of what it shows as its title."""

    def __init__(self, gui: viser.GuiApi):
        self.model: Model | None = None
        self.offered: tuple[str, ...] = ()
        self.choices = choices(())
        self.charts = []
        for number in range(1, CHARTS + 1):
            choice = gui.add_dropdown(
                f"Plot {number}", (chart_title(()),), hint="What to plot, in this browser"
            )
            self.charts.append((choice, Chart(gui, points=POINTS)))
        self.window = gui.add_dropdown(
            "Plots of", tuple(WINDOWS), hint="How much of the run is plotted, in this browser"
        )

    @property
    def names(self) -> frozenset[str]:
        """The observables that are plotted."""
        chosen = (self.choices.get(choice.value, ()) for choice, _ in self.charts)
        return frozenset(name for names in chosen for name in names)

    def refresh(self, curves: CurveCache) -> None:
        """Draw the run as far as it has come."""
        self.offer(curves)
        last = WINDOWS[self.window.value]
        for choice, chart in self.charts:
            chart.show(curves.of(self.choices.get(choice.value, ()), last))

    def offer(self, curves: CurveCache) -> None:
        """Let what these flocks have be chosen; of another model, choose the usual."""
        if curves.offered != self.offered:
            self.offered, self.choices = curves.offered, choices(curves.offered)
            for choice, _ in self.charts:
                choice.options = tuple(self.choices)
        if curves.model is not self.model:
            self.model = curves.model
            usual = default_charts(curves.model, curves.offered)
            for (choice, _), names in zip(self.charts, usual, strict=False):
                set_value(choice, chart_title(names))


class Watcher:
    """What there is on one browser's page alone; made on viser's loop.

    `point` turns its camera. Only `choice` is set by the browser; the thread that draws does the
    rest.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        left: viser.GuiTabHandle,
        right: viser.GuiFolderHandle,
        point: Callable[[viser.ClientHandle, str], None],
    ):
        self.client, self.point = client, point
        self.choice: AgentSelection | None = None
        self.is_new = True
        """Whether nothing on its page has been brought up to date yet."""
        self.since = time.monotonic()
        """When it chose an agent last, or came, s."""
        gui = client.gui
        with left:
            self.plots = OwnPlots(gui)
        with right, gui.add_folder(CAMERA):
            presets = gui.add_button_group(
                "From", CAMERAS, hint="In this browser; follow goes after the clicked agent"
            )
            ride = gui.add_button(
                "Ride along",
                icon=viser.Icon.FEATHER,
                color="gray",
                hint="A camera on the clicked agent, in this browser; again, or Esc, to get off",
            )
        presets.on_click(self.pointed)
        ride.on_click(self.ridden)
        self.inspector = Inspector(gui, lambda: self.choose(None))

    async def pointed(self, event: viser.GuiEvent) -> None:
        self.point(self.client, event.target.value)

    async def ridden(self, _event: viser.GuiEvent) -> None:
        self.point(self.client, RIDE)

    def choose(self, choice: AgentSelection | None) -> None:
        """Inspect an agent, or none."""
        self.choice, self.since = choice, time.monotonic()

    @property
    def whom(self) -> tuple[int | None, int] | None:
        """Row and flock of its agent; None if it has none."""
        choice = self.choice
        return None if choice is None else (choice.row, int(choice.beside))

    def tell(self, frame: Frame, scene: Scene) -> None:
        """Bring the card of its agent up to date, of which `frame` is a picture of all."""
        choice = self.choice
        flock = None if choice is None else choice.side(frame)
        if choice is None or flock is None:
            if self.choice is choice:  # else a click has come meanwhile
                self.choice = None
            self.inspector.refresh(frame, None)
            return
        seen = flock.others.get(choice.row)
        at = scene.display_place(choice.row, int(choice.beside))
        self.inspector.refresh(replace(flock, inspected=seen), choice.row, at)
