"""Numbers of a room as it runs: cards, a table of its cars, and the key to the colours."""

from __future__ import annotations

import html
import math

import numpy as np
import viser

from app.live.control.injected import Injection
from app.live.control.status import Status
from app.viewer.live.course import Course
from app.viewer.live.panels.plots import colours
from app.viewer.panels.style import block, cards, key
from app.viewer.scene.draw import palette
from app.viewer.scene.shown.frame import Frame

DASH = "–"


class LiveMonitors:
    """The top of the left panel."""

    def __init__(self, gui: viser.GuiApi):
        self.cards = gui.add_html(cards({"loop": DASH}))
        self.cars = gui.add_html("", visible=False)
        self.key = gui.add_html("")

    def refresh(
        self,
        status: Status,
        frame: Frame,
        course: Course,
        plan: Injection,
        browsers: int,
        chosen: int | None,
    ) -> None:
        """Show the latest of everything; `chosen` is the row of the car that was clicked."""
        self.cards.content = cards(numbers(status, course, plan, browsers))
        self.cars.visible = True
        self.cars.content = block(cars(status, frame, course, chosen))

    def colours(self, colour: str, legend: list[tuple[str, str]]) -> None:
        """Say what the colours mean."""
        entries = [(html.escape(words), css) for words, css in legend]
        self.key.content = block(
            f'<div class="fs-head">Colour: {html.escape(colour)}</div>{key(entries)}'
        )


def numbers(status: Status, course: Course, plan: Injection, browsers: int) -> dict[str, str]:
    """The cards, name -> text."""
    told = {
        "loop": milliseconds(status.period.median),
        "worst": milliseconds(status.period.worst),
        "latency": milliseconds(status.latency.median),
        "least distance": length(last(course.least)),
    }
    if plan.path == "circle":
        lags = [value for lag in course.lags.values() if math.isfinite(value := last(lag))]
        told["mean lag"] = degrees(sum(lags) / len(lags)) if lags else DASH
    told["ticks missed"] = str(status.missed)
    if status.dropped:
        told["frames not sent"] = str(status.dropped)
    return told | ({"browsers": str(browsers)} if browsers > 1 else {})


def cars(status: Status, frame: Frame, course: Course, chosen: int | None) -> str:
    """A table of all cars: state, age of the pose, speed, what is sent, lag."""
    live = frame.live
    rows = {} if live is None else {name: row for row, name in enumerate(live.names)}
    ink = colours([*(car.name for car in status.cars), *(one.name for one in status.companions)])

    def line(name: str, state: str, *cells: str) -> str:
        row = rows.get(name)
        marked = ' class="fs-chosen"' if row is not None and row == chosen else ""
        dot = f'<i class="fs-dot fs-small" style="background:{palette.css(palette.STATES[state])}">'
        speed = DASH if row is None else f"{frame.speed[row]:.2f}"
        age, *sent = cells
        told = [age, speed, *sent]
        if course.lags:
            lag = last(course.lags.get(name, np.empty(0)))
            told.append(f'<span style="color:{ink[name]}">{degrees(lag)}</span>')
        tail = "".join(f"<td>{cell}</td>" for cell in told)
        return f'<tr{marked}><td title="{state}">{dot}</i>{html.escape(name)}</td>{tail}</tr>'

    made = [
        line(car.name, car.state, aged(car.age), share(car.sent[0]), share(car.sent[1]))
        for car in status.cars
    ]
    made += [line(one.name, "simulated", DASH, share(one.steer), DASH) for one in status.companions]
    return (
        '<div class="fs-head">Cars</div><table class="fs-cars"><tr><th>car</th><th>age</th>'
        f"<th>m/s</th><th>steer</th><th>thr.</th>{'<th>lag</th>' if course.lags else ''}</tr>"
        f"{''.join(made)}</table>"
    )


def last(values: np.ndarray) -> float:
    """The newest value; NaN if there is none."""
    return float(values[-1]) if len(values) else math.nan


def milliseconds(seconds: float) -> str:
    """A time in ms.

    >>> milliseconds(0.01), milliseconds(math.nan)
    ('10.0 ms', '–')
    """
    return f"{1000.0 * seconds:.1f} ms" if math.isfinite(seconds) else DASH


def aged(seconds: float) -> str:
    """How old a pose is, in steps that do not flicker.

    >>> aged(0.004), aged(0.057), aged(1.27), aged(math.inf)
    ('0 ms', '60 ms', '1.3 s', 'never')
    """
    if math.isinf(seconds):
        return "never"
    return f"{10 * round(100.0 * seconds)} ms" if seconds < 0.2 else f"{seconds:.1f} s"


def length(metres: float) -> str:
    """A distance in m."""
    return f"{metres:.2f} m" if math.isfinite(metres) else DASH


def degrees(angle: float) -> str:
    """An angle in whole degrees."""
    return f"{angle:.0f}°" if math.isfinite(angle) else DASH


def share(value: float) -> str:
    """A command in [-1, 1] with its sign.

    >>> share(0.5), share(-0.25), share(0.0)
    ('+0.50', '−0.25', '0.00')
    """
    if abs(value) < 0.005:
        return "0.00"
    return f"{'+' if value > 0.0 else '−'}{abs(value):.2f}"
