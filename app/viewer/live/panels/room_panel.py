"""Where the poses come from, how commands reach the cars, and who else is in the room."""

from __future__ import annotations

import html
import time
from dataclasses import replace
from typing import Any

import viser

from app.front.controls import set_value
from app.live.control.injected_target import Injection
from app.live.control.loop_status import Status
from app.live.control.safety_limits import CarLimits
from app.live.device_kinds import SIMULATED
from app.live.laboratory.lab_file import Lab
from app.live.operating.lab_choices import Choices
from app.viewer.live.panels.state_panel import describe_client
from app.viewer.live.session import Session
from app.viewer.live.session_requests import SessionState
from app.viewer.panels.shell import block, table
from app.viewer.scene.shown.colouring import COLOURINGS, OWN
from app.viewer.scene.shown.control import controls_of
from app.viewer.scene.shown.drawing_style import (
    AGENTS,
    RIBBON,
    DrawingDefaults,
    DrawingStyle,
    trail_turns,
)

# What the picture of a live room shows.

CARS = "Cars"
"""What agents are here."""
OF_CARS = [name for name, colouring in COLOURINGS.items() if colouring.of_cars]
FOR_CARS: dict[str, dict[str, Any]] = {
    "colour": {
        "hint": "What a car's colour means; its state is the outline around it",
        "choices": (
            OWN,
            *(name for name, colouring in COLOURINGS.items() if colouring.of_cars and name != OWN),
        ),
        "only": {},
    },
    "trails": {
        "hint": "Where each car has been; rising in time: its way through space and time, time "
        "upwards"
    },
    "trail_length": {"hint": "How far back, ticks of the loop", "low": 50, "step": 50},
    "agent_size": {"label": "Car size", "low": 1.0},
    "shadows": {},
    "fence": {"hint": "Where the cars are stopped"},
    "mission": {"label": "Injected car", "hint": "The car that they follow"},
}
"""Those controls that mean something for real cars, and what is otherwise about each."""
CONTROLS = {
    name: replace(
        control, **FOR_CARS[name], group=CARS if control.group == AGENTS else control.group
    )
    for name, control in ((name, controls_of(DrawingStyle)[name]) for name in FOR_CARS)
}


def room_defaults(rate: float) -> DrawingDefaults:
    """How a room is drawn at first whose loop runs so often (Hz)."""
    return DrawingDefaults(
        DrawingStyle(colour=OWN, trails=RIBBON, trail_length=400), trail_turns(1.0 / rate)
    )


EMULATED = '<div class="fs-quiet">Emulated cars have a link of their own.</div>'
OBEYED = 1.0
"""Seconds within which as many simulated cars are there as were asked for, if they are let in."""
CHANGED = '<div class="fs-note">Chosen, but not open yet: press Open.</div>'


class RoomPanel:
    """Choices that take effect with a button, while the cars are not armed, and facts."""

    def __init__(self, gui: viser.GuiApi, session: Session, choices: Choices):
        self.session = session
        self.choices = choices
        self.shown_run = -1
        self.asked = 0.0
        """When simulated cars were last asked for, s."""
        self.source = gui.add_dropdown(
            "Source",
            tuple(choices.sources),
            initial_value=session.state.source,
            hint="Where the poses come from",
        )
        self.link = gui.add_dropdown(
            "Link",
            tuple(choices.links),
            initial_value=session.state.link,
            hint="How commands reach the cars. Dry run: nothing is sent. Emulated cars have a link "
            "of their own, whatever is chosen here",
        )
        self.emulated = gui.add_html(block(EMULATED), visible=False)
        self.changed = gui.add_html(block(CHANGED), visible=False)
        self.open = gui.add_button(
            "Open",
            icon=viser.Icon.DOOR_ENTER,
            color="blue",
            hint="Closes the room and opens it with this source and this link",
        )
        most = choices.lab.simulated.most
        self.companions = gui.add_slider(
            "Simulated cars",
            0,
            max(1, most),
            1,
            choices.lab.simulated.cars,
            hint="Simulated cars beside the real ones, in the same world: they hear each other",
            visible=most > 0,
        )
        self.facts = gui.add_html("")
        self.limits = gui.add_html(block(describe_limits(choices.lab)))
        self.open.on_click(self.open_choice)
        self.companions.on_update(self.set_companions)

    async def open_choice(self, event: viser.GuiEvent) -> None:
        self.session.choose(
            source=self.source.value, link=self.link.value, cause=describe_client(event)
        )

    async def set_companions(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.asked = time.monotonic()
            self.session.set_companions(self.companions.value, describe_client(event))

    def refresh(self, state: SessionState, status: Status | None, armed: bool) -> None:
        """Show what is open."""
        if state.run != self.shown_run and state.phase != "opening":
            self.shown_run = state.run
            set_value(self.source, state.source)
            set_value(self.link, state.link)
        if status is not None and time.monotonic() > self.asked + OBEYED:
            set_value(self.companions, len(status.companions))
        for control in (self.source, self.link, self.open):
            control.disabled = armed
        self.companions.disabled = state.phase == "replay"
        self.emulated.visible = self.choices.sources[self.source.value] == SIMULATED
        chosen = (self.source.value, self.link.value) != (state.source, state.link)
        self.changed.visible = chosen and not armed
        self.open.label = "Open" if chosen else "Open again"
        self.facts.content = block(facts(state, status, self.choices.lab.injected))


def facts(state: SessionState, status: Status | None, plan: Injection) -> str:
    """What the injected car does, and what is recorded where."""
    replay = state.phase == "replay"
    rows = {} if replay else {"injected car": describe_injected(plan)}
    if status is not None and status.injected is not None:
        place = f"({status.injected.x:.2f}, {status.injected.y:.2f}) m"
        rows["injected car was at" if replay else "it is at"] = place
    if not replay:
        rows["recorded in"] = state.recording or "nothing is recorded"
    escaped = {name: html.escape(words) for name, words in rows.items()}
    head = "In the recording, at this moment of it" if replay else "In the room"
    return f'<h2 class="fs-head">{head}</h2>{table(escaped)}'


def describe_injected(plan: Injection) -> str:
    """What the injected car does, in words.

    >>> describe_injected(Injection())
    'circle of 2 m, 1.1 m/s'
    """
    match plan.path:
        case "circle":
            return f"circle of {plan.radius:g} m, {plan.speed:g} m/s"
        case "eight":
            return f"eight of {plan.radius:g} m, {plan.speed:g} m/s"
        case "route":
            return f"route of {len(plan.route)} points, {plan.speed:g} m/s"
        case "hand":
            return "by hand: drag its handle"
        case "body":
            return f"tracked: {plan.body}"
    return "none"


def describe_limits(lab: Lab) -> str:
    """The laboratory's limits, which nothing in a browser can change."""
    low, high = lab.area.low, lab.area.high
    rows = {
        "area": f"{high[0] - low[0]:.2f} × {high[1] - low[1]:.2f} m",
        "fence": f"{lab.area.fence:g} m inside it",
        "rate": f"{lab.rate:g} Hz",
        "stop if unseen for": f"{1000 * lab.limits.stale:g} ms",
        "disarm if unseen for": f"{lab.limits.long_gap:g} s",
        "disarm if frozen for": f"{lab.limits.frozen:g} s",
    }
    head = "<tr><th>car</th><th>address</th><th>m/s</th><th>throttle</th><th>steer</th></tr>"
    cars = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{car.address}</td><td>{car.speed:g}</td>"
        f"<td>{bounds(car)}</td><td>± {car.steer:g}</td></tr>"
        for name, car in lab.cars.items()
    )
    return (
        f'<h2 class="fs-head">Limits of the laboratory</h2>{table(rows)}'
        f'<table class="fs-cars">{head}{cars}</table>'
        '<div class="fs-quiet">Of the file; nothing in a browser can change them.</div>'
    )


def bounds(car: CarLimits) -> str:
    """The throttle that a car may be told.

    >>> bounds(CarLimits()), bounds(CarLimits(reverse=0.5))
    ('0 – 1', '−0.5 – 1')
    """
    low = f"−{car.reverse:g}" if car.reverse else "0"
    return f"{low} – {car.throttle:g}"
