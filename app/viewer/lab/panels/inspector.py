"""The card of the agent that was clicked."""

from __future__ import annotations

import html
from collections.abc import Callable

import numpy as np
import viser

from agents.inspection import UNSEEN, Inspection
from agents.state.crashes import CAUSES, Crashes
from app.viewer.measuring import measured
from app.viewer.panels.style import block, table
from app.viewer.run.picture import SAVED
from app.viewer.scene.draw import palette
from app.viewer.scene.marks.inspected.reasons import force_colours
from app.viewer.scene.shown.frame import Frame

ON_ITS_WAY = " sent "
"""In the names of a car's commands that have not arrived yet."""

MOST_NEIGHBOURS = 6
LOOKING = (
    '<div class="fs-quiet">Looking closer … a model is compiled for this the first time.</div>'
)


class Inspector:
    """A window of its own, there only while an agent is inspected."""

    def __init__(self, gui: viser.GuiApi, close: Callable[[], None]):
        self.panel = gui.add_panel(visible=False)
        with self.panel.add_tab("Agent", viser.Icon.ZOOM_IN):
            self.card = gui.add_html("")
            button = gui.add_button("Close", icon=viser.Icon.X, color="gray")
        self.panel.float(x=12, y=-12, width=250)

        async def closed(_event: viser.GuiEvent) -> None:
            close()

        button.on_click(closed)

    def refresh(self, frame: Frame, row: int | None) -> None:
        """Show the agent of a row as it is now; nothing for None or a row that is not there."""
        seen = frame.inspected
        wanted = row is not None and row < len(frame.ids)
        if self.panel.visible != wanted:
            self.panel.visible = wanted
        if wanted and seen is not None:
            self.card.content = block(card(frame, seen))
        elif wanted:
            self.card.content = block(LOOKING)


def card(frame: Frame, seen: Inspection) -> str:
    """What is known of the agent and of those it listens to."""
    rows = {html.escape(name): html.escape(value) for name, value in facts(frame, seen).items()}
    if frame.group is not None and seen.row < len(frame.group):
        rows["group"] = str(int(frame.group[seen.row]) + 1)
    rows["neighbours"] = str(len(seen.neighbours))
    kind = " · information agent" if frame.informed[seen.row] else ""
    crashed = frame.down[seen.row]
    if crashed and frame.crashes is not None:
        rows["crashed"] = html.escape(crash_text(frame.crashes, seen.row))
    heard = "" if crashed else zoned(seen) + pushed(seen) + listened(frame, seen)
    flock = f'<div class="fs-quiet">{html.escape(frame.title)}</div>' if frame.title else ""
    return f'<div class="fs-head">Agent {seen.id}{kind}</div>{flock}{table(rows)}{heard}'


def crash_text(crashes: Crashes, row: int) -> str:
    """When and against what an agent crashed."""
    (place,) = np.flatnonzero(crashes.row == row)
    return f"tick {crashes.tick[place]}, {CAUSES[int(crashes.cause[place])]}"


def zoned(seen: Inspection) -> str:
    """How many neighbours are in each zone of its rule, and how many it does not see."""
    if not seen.shells:
        return ""
    inner, rows = 0.0, ""
    for index, shell in enumerate(seen.shells):
        count = int(np.count_nonzero(seen.zone == index))
        extent = f"{min(inner, shell.radius):g} – {shell.radius:g}"
        rows += entry(palette.ZONES[index % len(palette.ZONES)], shell.name, extent, count)
        inner = max(inner, shell.radius)
    unseen = int(np.count_nonzero(seen.zone == UNSEEN))
    rows += entry(palette.BLIND, "not noticed", "", unseen)
    view = f'<span class="fs-quiet">sees {seen.view:g}°</span>' if seen.view < 360.0 else ""
    return (
        f'<div class="fs-head"><span>Zones</span>{view}</div><table class="fs-table">{rows}</table>'
    )


def entry(colour: np.ndarray, name: str, extent: str, count: int) -> str:
    """A row of the table of zones."""
    return (
        f'<tr><td><i class="fs-dot fs-small" style="background:{palette.css(colour)}"></i>'
        f"{html.escape(name)}</td><td>{extent}</td><td>{count}</td></tr>"
    )


def facts(frame: Frame, seen: Inspection) -> dict[str, str]:
    """An agent's state in words, name -> value with unit."""
    ux = frame.heading[seen.row]
    listed = {
        "position": "(" + ", ".join(f"{value:.2f}" for value in frame.position[seen.row]) + ")",
        "heading": f"{np.degrees(np.arctan2(ux[1], ux[0])) % 360:.0f}°",
    }
    if frame.dim == 3:
        listed["climb"] = f"{np.degrees(np.arcsin(np.clip(ux[2], -1, 1))):+.0f}°"
    listed["speed"] = f"{measured.few(frame.speed[seen.row])} {frame.pace_unit}"
    return listed | signal_facts(seen)


def signal_facts(seen: Inspection) -> dict[str, str]:
    """What an agent tells and keeps; places, which are pairs of columns, as points."""
    listed, signals = {}, seen.signals
    for name, value in signals.items():
        stem = name[:-2]
        if (name.endswith("_y") and f"{stem}_x" in signals) or ON_ITS_WAY in name:
            continue
        if name == SAVED:
            known = np.isfinite(value)
            listed["drag saved"] = f"{100.0 * value:+.1f} %" if known else "unknown"
        elif name.endswith("_x") and f"{stem}_y" in signals:
            listed[stem] = f"({value:.2f}, {signals[f'{stem}_y']:.2f})"
        else:
            listed[name] = f"{value:.4g}" if np.isfinite(value) else "unknown"
    return {name: words for name, words in listed.items() if seen.minds or name not in seen.places}


def pushed(seen: Inspection) -> str:
    """The forces on it, by the colours of their arrows, and how strong they are."""
    if not seen.forces:
        return ""
    colours = [palette.css(colour) for colour in force_colours(len(seen.forces))]
    length = {name: float(np.linalg.norm(force)) for name, force in seen.forces.items()}
    most = max([*length.values(), 1e-300])
    rows = "".join(
        f'<tr><td><i class="fs-dot fs-small" style="background:{colour}"></i>'
        f"{html.escape(name)}</td>"
        f'<td style="width:35%"><div class="fs-weight" '
        f'style="width:{100 * value / most:.1f}%;background:{colour}"></div></td>'
        f"<td>{measured.few(value)}</td></tr>"
        for (name, value), colour in zip(length.items(), colours, strict=True)
    )
    return f'<div class="fs-head">Forces</div><table class="fs-table">{rows}</table>'


def listened(frame: Frame, seen: Inspection) -> str:
    """Whom it listens to, and how much."""
    weights = np.asarray(seen.weights, float)
    total = weights.sum()
    if not len(weights) or not total > 0:
        return '<div class="fs-quiet">It listens to nobody.</div>'
    rows = ""
    heard = int(np.count_nonzero(weights > 0.0))
    for place in np.argsort(-weights)[: min(heard, MOST_NEIGHBOURS)]:
        share = 100 * weights[place] / total
        width = 100 * weights[place] / weights.max()
        rows += (
            f"<tr><td>{frame.ids[seen.neighbours[place]]}</td>"
            f'<td style="width:60%"><div class="fs-weight" style="width:{width:.1f}%"></div></td>'
            f"<td>{share:.0f} %</td></tr>"
        )
    more = heard - MOST_NEIGHBOURS
    rest = f'<tr><td colspan="3">and {more} more</td></tr>' if more > 0 else ""
    return f'<div class="fs-head">Listens to</div><table class="fs-table">{rows}{rest}</table>'
