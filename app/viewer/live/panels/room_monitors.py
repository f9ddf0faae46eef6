"""What the monitors tell of a room as it runs: cards, and a table of its cars."""

from __future__ import annotations

import html
import math

from app.live.control.loop_status import Status
from app.viewer.live.panels.live_plots import colours
from app.viewer.live.room_frame import RoomReadings, roster
from app.viewer.panels.monitors import CARDS, KEY
from app.viewer.panels.shell import grid, key
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import outlines
from app.viewer.scene.shown.frame import Frame

DASH = "–"


BLOCKS = (CARDS, "cars", KEY, "outlines")
"""From the top down."""


def contents(
    status: Status,
    frame: Frame,
    readings: RoomReadings,
    browsers: int,
    chosen: int | None,
    when: str = "",
) -> dict[str, str]:
    """The latest of everything by its block, HTML; `chosen` is the row of the clicked car.

    `when`: of what moment of a recording it is; empty: it is now.
    """
    then = f'<div class="fs-note">{html.escape(when)}</div>' if when else ""
    return {
        CARDS: then + grid(numbers(status, readings, 0 if when else browsers)),
        "cars": cars(status, frame, readings, chosen),
        "outlines": describe_outlines(frame),
    }


def numbers(status: Status, readings: RoomReadings, browsers: int) -> dict[str, str]:
    """The cards, name -> text."""
    texts = {
        "loop": milliseconds(status.period.median),
        "worst": milliseconds(status.period.worst),
        "latency": milliseconds(status.latency.median),
        "least distance": length(readings.least.newest),
    }
    if readings.plan.path == "circle":
        lags = [lag.newest for lag in readings.lags.values()]
        lags = [lag for lag in lags if math.isfinite(lag)]
        texts["mean lag"] = degrees(sum(lags) / len(lags)) if lags else DASH
    texts["ticks missed"] = str(status.missed)
    if status.dropped:
        texts["frames not sent"] = str(status.dropped)
    return texts | ({"browsers": str(browsers)} if browsers > 1 else {})


def cars(status: Status, frame: Frame, readings: RoomReadings, chosen: int | None) -> str:
    """A table of all cars: own colour and state, age of the pose, speed, what is sent, lag."""
    live = frame.live
    rows = {} if live is None else {name: row for row, name in enumerate(live.names)}
    ink = colours(roster(status))

    def line(name: str, state: str, *cells: str) -> str:
        row = rows.get(name)
        marked = ' class="fs-chosen"' if row is not None and row == chosen else ""
        outline = palette.css(palette.STATES[state])
        dot = f'<i class="fs-dot fs-small fs-car" style="background:{ink[name]};color:{outline}">'
        speed = DASH if row is None else f"{frame.speed[row]:.2f}"
        age, *sent = cells
        texts = [age, speed, *sent]
        if readings.lags:
            lag = readings.lags[name].newest if name in readings.lags else math.nan
            texts.append(f'<u style="border-color:{ink[name]}">{degrees(lag)}</u>')
        tail = "".join(f"<td>{cell}</td>" for cell in texts)
        return f'<tr{marked}><td title="{state}">{dot}</i>{html.escape(name)}</td>{tail}</tr>'

    html_rows = [
        line(car.name, car.state, format_age(car.age), share(car.sent[0]), share(car.sent[1]))
        for car in status.cars
    ]
    html_rows += [
        line(companion.name, "simulated", DASH, share(companion.steer), DASH)
        for companion in status.companions
    ]
    return (
        '<h2 class="fs-head">Cars</h2><table class="fs-cars"><tr><th>car</th><th>age</th>'
        f"<th>m/s</th><th>steer</th><th>thr.</th>{'<th>lag</th>' if readings.lags else ''}</tr>"
        f"{''.join(html_rows)}</table>"
    )


def describe_outlines(frame: Frame) -> str:
    """What the outlines around the cars mean."""
    entries = outlines(frame)
    return '<h2 class="fs-head">Outline: state</h2>' + key(entries, drawn=True, hollow=True)


def milliseconds(seconds: float) -> str:
    """A time in ms.

    >>> milliseconds(0.01), milliseconds(math.nan)
    ('10.0 ms', '–')
    """
    return f"{1000.0 * seconds:.1f} ms" if math.isfinite(seconds) else DASH


def format_age(seconds: float) -> str:
    """How old a pose is, in steps that do not flicker.

    >>> format_age(0.004), format_age(0.057), format_age(1.27), format_age(math.inf)
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
