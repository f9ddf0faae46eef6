"""A page on which many watch a laboratory's run, and nobody can change it."""

from __future__ import annotations

import asyncio
import html
import threading
import time
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import viser

from agents.catalogue import MODELS
from agents.models.declare import DeclaredParameter, declared
from app.front.client_addresses import USUAL, ConnectionLimits
from app.front.message_filter import CAMERA, AllowedMessage
from app.front.origin import local_address
from app.front.page_front import Front
from app.front.server import admit_browsers, close_server, on_browser_message, open_server
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.flock_monitors import BELOW, BLOCKS
from app.viewer.lab.panels.run_panel import describe_scene, status
from app.viewer.measuring.run_conditions import format_setting
from app.viewer.panels.dials import plain_symbol
from app.viewer.panels.kinds import TITLE, describe_kinds
from app.viewer.panels.monitors import Monitors
from app.viewer.panels.parameters import raised_powers
from app.viewer.panels.shell import KEYS, add_hotkeys, block, dock, set_look
from app.viewer.run.frame_builder import WatchPageRequest
from app.viewer.run.simulation_state import SimulationState
from app.viewer.scene.drawing import PANELS, Drawing, Rates
from app.viewer.scene.shown.drawing_style import RIDE, STEP_OFF, DrawingStyle
from app.viewer.scene.shown.frame import Frame
from app.viewer.watching.watcher import (
    ALWAYS,
    AgentSelection,
    CurveCache,
    OwnScene,
    Watcher,
    measured_for_all,
)

# What is told of the run to those who watch it: whose it is, how it stands, and its parameters.

MEND = "Whoever leads it can set it up anew."


def standing(state: SimulationState, whose: str) -> str:
    """Whose run it is and how it stands, HTML; `whose` is text that somebody has typed."""
    run = f"{html.escape(whose)}'s run" if whose else "a run"
    told = f'<div class="fs-quiet">Watching {run}. What you choose here changes your page alone.'
    return block(f"{status(state, MEND)}{told}</div>")


def values(state: SimulationState) -> str:
    """The parameters of the flock, and what only the one beside it has, HTML; what is not at its
    default stands out, with the default."""
    if not state.values:
        return ""
    model, beside = state.models
    told = listed("Parameters", declared(MODELS[model].parameters), state.values)
    if beside is not None and state.beside_values:
        own = declared(MODELS[beside].parameters)
        told += listed(f"Only {beside}", own, state.beside_values)
    if state.kinds.kinds:
        told += f'<h2 class="fs-head">{TITLE}</h2>{describe_kinds(state.kinds, None)}'
    return block(told)


def listed(title: str, own: Iterable[DeclaredParameter], values: Mapping[str, Any]) -> str:
    """A table of parameters under a title."""
    rows = "".join(row(one, values[one.name]) for one in own if one.name in values)
    head = f'<h2 class="fs-head">{html.escape(title)}</h2>'
    return f'{head}<table class="fs-table fs-values">{rows}</table>'


def row(one: DeclaredParameter, value: Any) -> str:
    """A parameter in words, with its symbol, its value and its unit."""
    symbol = f" {plain_symbol(one.symbol)}" if one.kind == "number" else ""
    unit = f" {raised_powers(one.unit)}" if one.kind == "number" and one.unit != "1" else ""
    told = html.escape(f"{format_setting(value)}{unit}")
    if value != one.default:
        usual = html.escape(format_setting(one.default))
        told = f'<b>{told}</b><div class="fs-quiet">usually {usual}</div>'
    return f"<tr><td>{html.escape(one.words + symbol)}</td><td>{told}</td></tr>"


SCRIPTS = ("card.js",)
"""What its page needs beside what every page has: to keep a card beside its agent."""
HEARD = {
    CAMERA: AllowedMessage(80.0, 160.0),
    "GuiUpdateMessage": AllowedMessage(10.0, 40.0),
    "CommandTriggerMessage": AllowedMessage(10.0, 20.0),
    "ScenePointerMessage": AllowedMessage(4.0, 8.0),
}
"""The kinds of messages that it hears, and how often: where a browser's own camera is, its own
controls, the keys of its camera, and clicks on agents."""
BANDWIDTH = 18e6
"""What all who watch may be sent of the picture, bytes/s: 15 pictures a second of 1 000 agents for
forty browsers and a little more, before the front packs them."""
CARDS = 0.5
"""Time between two refreshments of what is told in words, s."""
PLOTS, BROWSERS = 1.0, 20
"""Time between two refreshments of a browser's plots, s, for so many browsers; longer for more."""
LOOKED_AT = 40
"""Agents that are inspected for those who watch; for more browsers than that the latest choices."""
ACTIONS = {"1": "top-down", "2": "perspective", "3": "side", "F": "follow", "B": RIDE}
"""The keys, which turn the camera of the browser where they are pressed."""


class WatchPage:
    """Serves the run of a laboratory, in its process, to those who only watch.

    They see what the laboratory's own page shows, as it shows it; each browser has its own camera,
    its own plots and its own inspected agent. `whose`: who leads the run, as text; empty: not told.
    `secret`: the first part of every path, if any. `limits`: how many connections there may be. A
    laboratory has one such page. Nothing is drawn while nobody watches. Raises InputError if the
    port is busy.
    """

    def __init__(
        self,
        laboratory: Laboratory,
        whose: str = "",
        host: str = "127.0.0.1",
        port: int = 0,
        secret: str = "",
        limits: ConnectionLimits = USUAL,
    ):
        self.laboratory, self.whose, self.host = laboratory, whose, host
        self.server = open_server(host, port, Front(SCRIPTS, secret=secret), HEARD, limits)
        self.scene = OwnScene(self.server)
        self.watchers: dict[int, Watcher] = {}
        """By browser."""
        self.drawing: Drawing | None = None
        """There while somebody watches."""
        self.switching = asyncio.Lock()
        """Held on viser's loop while drawing begins or ends."""
        self.closed = False
        self.told_due = 0.0
        self.turn = 0
        """Counts the refreshments: in each it is the turn of some browsers."""
        self.furnish()
        self.scene.on_chosen(self.chosen)
        self.news = threading.Event()
        """Set when there may be something new to draw."""
        laboratory.simulation.news.tell(self.news)
        on_browser_message(self.server, self.news.set)
        self.server.on_client_connect(self.welcome)
        self.server.on_client_disconnect(self.farewell)
        admit_browsers(self.server)  # last: browsers find all of the above

    @property
    def port(self) -> int:
        """The port that it serves on."""
        return self.server.get_port()

    @property
    def address(self) -> str:
        """Where a browser on this machine finds it."""
        return local_address(self.host, self.port)

    def browsers(self) -> int:
        """Number of browsers that watch."""
        return len(self.server.get_clients())

    def close(self) -> None:
        """Stop drawing and serving; the laboratory goes on."""
        self.closed = True
        self.laboratory.elsewhere = WatchPageRequest()
        self.laboratory.simulation.news.forget(self.news)
        if self.drawing is not None:
            self.drawing.close()
        close_server(self.server)

    def furnish(self) -> None:
        """Build what all browsers see alike: it holds no control but the keys of the camera."""
        gui = self.server.gui
        set_look(gui, "flockscope")
        self.status = gui.add_html("")
        self.story = gui.add_html("")
        self.right = gui.add_folder(None)
        self.values = gui.add_html("")
        left = gui.add_panel()
        with left.add_tab("Monitors", viser.Icon.CHART_LINE) as self.left:
            self.monitors = Monitors(gui, (*BLOCKS, *BELOW), "tick")
        self.sight_lines = self.monitors.sight_lines(self.server, self.left)
        dock(gui, left)
        add_hotkeys(
            gui,
            {key: lambda client, to=to: self.point(client, to) for key, to in ACTIONS.items()}
            | {"escape": lambda client: self.point(client, STEP_OFF)},
            KEYS | {"escape": "Camera: the ride ends"},
        )

    # What browsers ask for, on viser's loop.

    async def welcome(self, client: viser.ClientHandle) -> None:
        """A browser has come: it gets what it has alone, and the first begins the drawing, and the
        flock if that waited for somebody."""
        self.laboratory.begin()
        self.watchers[client.client_id] = Watcher(client, self.left, self.right, self.point)
        async with self.switching:
            if self.drawing is None and self.watchers and not self.closed:
                self.drawing = Drawing(
                    self.scene,
                    self.laboratory.latest,
                    self.browsers,
                    self.choose,
                    self.refresh,
                    self.news,
                    lambda: self.laboratory.between.moves,
                    Rates(bandwidth=BANDWIDTH),
                )
                self.tell_laboratory(WatchPageRequest(browsers=1))
                self.drawing.start()
            elif self.drawing is not None:
                self.drawing.show_to_newcomer()

    async def farewell(self, client: viser.ClientHandle) -> None:
        """A browser has gone; the last ends the drawing."""
        self.watchers.pop(client.client_id, None)
        async with self.switching:
            if self.watchers or self.closed or self.drawing is None:
                return
            drawing, self.drawing = self.drawing, None
            await asyncio.to_thread(drawing.close)
            self.laboratory.elsewhere = WatchPageRequest()

    def tell_laboratory(self, asked: WatchPageRequest) -> None:
        """Say what those who watch want to know; where nobody is on the laboratory's own page it
        is to do at once what it would do for somebody."""
        self.laboratory.elsewhere = asked
        if not self.laboratory.browsers():
            self.laboratory.drawing.show_to_newcomer()

    def chosen(self, client: viser.ClientHandle, row: int | None, beside: bool) -> None:
        """A click into one browser's picture, on an agent or on none."""
        watcher, drawing = self.watchers.get(client.client_id), self.drawing
        if watcher is None or drawing is None or drawing.drawn is None:
            return
        frame = drawing.drawn[0]
        flock = frame.beside if beside else frame
        if row is None or flock is None or row >= len(flock.ids):
            watcher.choose(None)
            return
        identity = int(flock.ids[row]) if flock.has_turnover else None
        watcher.choose(AgentSelection(row, beside, frame.run, identity))

    def point(self, client: viser.ClientHandle, camera: str) -> None:
        """Point one browser's camera."""
        watcher = self.watchers.get(client.client_id)
        self.scene.camera(client, camera, None if watcher is None else watcher.whom)

    # What the drawing thread does.

    @property
    def now(self) -> list[Watcher]:
        """Those who are there, by when they chose an agent last, the latest first."""
        there = list(self.watchers.values())  # a copy: browsers come and go meanwhile
        return sorted(there, key=lambda one: -one.since)

    def choose(self) -> None:
        """Draw what each browser has chosen."""
        self.scene.choose([(one.client, one.choice) for one in self.now if one.choice is not None])

    def refresh(self) -> None:
        """Bring the panels up to date, and say what is to be measured and looked at."""
        if self.drawing is None or self.drawing.drawn is None:
            return
        frame, look = self.drawing.drawn
        self.scene.show_own()
        if (now := time.monotonic()) >= self.told_due:
            self.told_due = now + CARDS
            self.tell(frame, look)
        watchers = self.now
        for one in self.those(watchers, CARDS):
            self.attempt(one, partial(one.tell, frame, self.scene))
            in_sight = self.scene.in_sight(one.client)
            self.attempt(one, partial(self.sight_lines.show, one.client, in_sight))
        self.plot(self.those(watchers, PLOTS * max(1.0, len(watchers) / BROWSERS)))
        self.turn += 1
        for one in watchers:
            one.is_new = False

    def those(self, watchers: list[Watcher], every: float) -> list[Watcher]:
        """Whose turn it is now of what each has `every` so many seconds, and who is new: all at
        once would hold up the picture."""
        turns = max(1, round(every / PANELS))
        number = self.turn % turns
        return [one for one in watchers if one.is_new or one.client.client_id % turns == number]

    def tell(self, frame: Frame, look: DrawingStyle) -> None:
        """What all see alike, and what the laboratory is to do for them."""
        lab = self.laboratory
        state, scene = lab.simulation.state, lab.shown_scene
        self.scene.open_on("" if scene is None else scene.camera)
        self.status.content = standing(state, self.whose)
        self.story.content = "" if scene is None else describe_scene(replace(scene, tries=""))
        self.values.content = values(state)
        self.monitors.show(lab.contents)
        self.monitors.colours(look, frame)
        asked = self.asked(self.now)
        self.tell_laboratory(asked)
        if missing(frame.others, asked.rows) or (
            frame.beside is not None and missing(frame.beside.others, asked.rows_beside)
        ):
            lab.simulation.look_again()

    def asked(self, watchers: list[Watcher]) -> WatchPageRequest:
        """What these want to know of the run: so many observables, so many agents, and no more."""
        chosen = (one.choice for one in watchers)
        rows = list(dict.fromkeys((one.row, one.beside) for one in chosen if one is not None))
        rows = rows[:LOOKED_AT]
        return WatchPageRequest(
            len(watchers),
            measured_for_all(one.plots.names for one in watchers),
            frozenset(row for row, beside in rows if not beside),
            frozenset(row for row, beside in rows if beside),
        )

    def plot(self, watchers: list[Watcher]) -> None:
        """Draw the plots of some browsers."""
        lab = self.laboratory
        runs = tuple(
            one
            for one in (lab.simulation.readings, lab.simulation.readings_beside)
            if one is not None
        )
        if not watchers or not runs or not lab.plots.offered:
            return
        measured = lab.watched | lab.elsewhere.names | ALWAYS
        curves = CurveCache(runs, lab.plots.runs, lab.plots.offered, measured)
        for one in watchers:
            self.attempt(one, partial(one.plots.refresh, curves))

    def attempt(self, watcher: Watcher, change: Callable[[], None]) -> None:
        """Change something on a page that may go meanwhile: viser raises RuntimeError then."""
        try:
            change()
        except RuntimeError:
            if watcher.client.client_id in self.server.get_clients():
                raise


def missing(found: Container[int], rows: frozenset[int]) -> bool:
    """Whether some agents have not been looked at yet."""
    return any(row not in found for row in rows)
