"""The card of the agent that was clicked: a window of its own, which each browser puts beside it.

`card.js` does so, by what the card says of where the agent is drawn.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable
from typing import Any, Literal

import numpy as np
import viser

from agents.inspection import UNSEEN, Inspection
from agents.models.model import vector_name
from agents.observables.of_agents import ON_ITS_WAY
from agents.state.agent_rows import CAUSES, Crashes
from app.front.viser_internals import identifier
from app.viewer.measuring import observable_format
from app.viewer.panels.dials import sight
from app.viewer.panels.shell import block, table
from app.viewer.run.frame_builder import SAVED
from app.viewer.scene.marks.inspection_marks import force_colours
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.frame import Frame
from worlds.number_text import counted

# What is told of one agent: its state in words and units, and whom and what it goes by.

FIRST = 6
"""Rows that are always there."""
MOST_NEIGHBOURS = 6

Fold = Literal["rest", "zones", "forces", "heard"]


def head(frame: Frame, seen: Inspection) -> str:
    """Who it is, and the most telling rows."""
    rows = dict(list(facts(frame, seen).items())[:FIRST])
    kind = " · information agent" if frame.informed[seen.row] else ""
    flock = f'<div class="fs-quiet">{html.escape(frame.title)}</div>' if frame.title else ""
    return f'<div class="fs-head">Agent {seen.id}{kind}</div>{flock}{escaped(rows)}'


def folds(frame: Frame, seen: Inspection) -> dict[Fold, tuple[str, str]]:
    """The rest, each by what is written on it and the HTML in it; nothing of what there is not."""
    rest = dict(list(facts(frame, seen).items())[FIRST:])
    told: dict[Fold, tuple[str, str]] = {}
    if rest:
        told["rest"] = f"{counted(len(rest), 'more row')}", escaped(rest)
    if frame.down[seen.row]:
        return told
    if seen.shells:
        noticed = int(np.count_nonzero(seen.zone != UNSEEN))
        told["zones"] = f"Zones: {noticed} noticed", zoned(seen)
    if seen.forces:
        told["forces"] = (
            f"Forces: {max(seen.forces, key=lambda one: strength(seen, one))}",
            pushed(seen),
        )
    heard = int(np.count_nonzero(np.asarray(seen.weights) > 0.0))
    if heard:
        told["heard"] = f"Listens to {counted(heard, 'agent')}", listened(frame, seen)
    return told


def escaped(rows: dict[str, str]) -> str:
    """A table of words and values."""
    return table({html.escape(name): html.escape(value) for name, value in rows.items()})


def facts(frame: Frame, seen: Inspection) -> dict[str, str]:
    """An agent's state, words -> value with unit, the most telling first."""
    ux, crashes, model = frame.heading[seen.row], frame.crashes, seen.model
    listed: dict[str, str] = {}
    if frame.down[seen.row] and crashes is not None:
        listed["crashed"] = crash_text(crashes, seen.row)
    length = model.in_units("length") if model else "length"
    listed[f"position ({length})"] = vector(frame.position[seen.row])
    listed["heading"] = f"{np.degrees(np.arctan2(ux[1], ux[0])) % 360:.0f}°"
    if frame.dim == 3:
        listed["climb"] = f"{np.degrees(np.arcsin(np.clip(ux[2], -1, 1))):+.0f}°"
    pace = model.in_units("length/time") if model else frame.pace_unit
    listed["speed"] = f"{observable_format.few(frame.speed[seen.row])} {pace}"
    listed["neighbours"] = counted(len(seen.neighbours), "agent")
    own = signal_facts(seen)
    if "drag saved" in own:
        listed["drag saved"] = own.pop("drag saved")
    if frame.group is not None and seen.row < len(frame.group):
        listed["group"] = f"number {int(frame.group[seen.row]) + 1} by size"
    if not np.any(np.asarray(seen.weights) > 0.0) and not frame.down[seen.row]:
        listed["listens to"] = "nobody"
    return listed | own


def vector(parts: object) -> str:
    """A place or a vector in figures."""
    return "(" + ", ".join(f"{value:.2f}" for value in np.asarray(parts, float)) + ")"


def crash_text(crashes: Crashes, row: int) -> str:
    """When and against what an agent crashed."""
    (place,) = np.flatnonzero(crashes.row == row)
    return f"tick {crashes.tick[place]}, {CAUSES[int(crashes.cause[place])]}"


def signal_facts(seen: Inspection) -> dict[str, str]:
    """What an agent tells and keeps, words -> value with unit; places only while they count."""
    listed: dict[str, str] = {}
    for name, value in seen.signals.items():
        stem = vector_name(name)
        beside = [f"{stem}_{axis}" for axis in "xyz" if f"{stem}_{axis}" in seen.signals]
        if ON_ITS_WAY in name or (name in beside and name != beside[0]):
            continue
        if stem in seen.places and not seen.minds:
            continue
        words = seen.model.words_of(name) if seen.model else stem.replace("_", " ")
        unit = seen.model.unit_of(name) if seen.model else "1"
        unit = "" if unit == "1" else unit
        if len(beside) > 1:
            across = seen.separation.shape[1]
            parts = [seen.signals[one] for one in beside[:across]]
            listed[f"{words} ({unit})" if unit else words] = vector(parts)
        else:
            listed[words.removesuffix("?")] = figure(name, words, value, unit)
    return listed


def figure(name: str, words: str, value: float, unit: str) -> str:
    """One of an agent's numbers; what is called by a question is a yes or a no."""
    if not np.isfinite(value):
        return "unknown"
    if words.endswith("?"):
        return "yes" if value else "no"
    if name == SAVED:
        return f"{100.0 * value:+.1f} %"
    return f"{value:.4g} {unit}".strip()


def zoned(seen: Inspection) -> str:
    """How many neighbours are in each zone of its rule, and how many it does not see."""
    inner, rows = 0.0, ""
    length = seen.model.in_units("length") if seen.model else "length"
    for index, shell in enumerate(seen.shells):
        count = int(np.count_nonzero(seen.zone == index))
        extent = f"{min(inner, shell.radius):g} – {shell.radius:g} {length}"
        rows += entry(palette.ZONES[index % len(palette.ZONES)], shell.name, extent, count)
        inner = max(inner, shell.radius)
    unseen = int(np.count_nonzero(seen.zone == UNSEEN))
    rows += entry(palette.BLIND, "not noticed", "", unseen)
    view = f'<div class="fs-quiet">sees {seen.view:g}°</div>' if seen.view < 360.0 else ""
    return f'<table class="fs-table">{rows}</table>{view}'


def entry(colour: np.ndarray, name: str, extent: str, count: int) -> str:
    """A row of the table of zones."""
    return (
        f'<tr><td><i class="fs-dot fs-small" style="background:{palette.css(colour)}"></i>'
        f"{html.escape(name)}</td><td>{extent}</td><td>{count}</td></tr>"
    )


def strength(seen: Inspection, name: str) -> float:
    """How strong a force is."""
    return float(np.linalg.norm(seen.forces[name]))


def force_unit(seen: Inspection, name: str) -> str:
    """The unit of a term of what the rule wishes, or of the body's velocity."""
    if seen.model is None:
        return ""
    pace = seen.model.in_units("length/time")
    if name in seen.model.rule.forces and seen.model.rule.wish == "acceleration":
        return f"{pace}²"
    return pace


def pushed(seen: Inspection) -> str:
    """The forces on it, by the colours of their arrows, and how strong they are."""
    colours = [palette.css(colour) for colour in force_colours(len(seen.forces))]
    length = {name: strength(seen, name) for name in seen.forces}
    most = max([*length.values(), 1e-300])
    rows = "".join(
        f'<tr><td><i class="fs-dot fs-small" style="background:{colour}"></i>'
        f"{html.escape(name)}</td>"
        f'<td style="width:25%"><div class="fs-weight" '
        f'style="width:{100 * value / most:.1f}%;background:{colour}"></div></td>'
        f'<td style="white-space:nowrap">{observable_format.few(value)} '
        f"{force_unit(seen, name)}</td></tr>"
        for (name, value), colour in zip(length.items(), colours, strict=True)
    )
    return f'<table class="fs-table">{rows}</table>'


def listened(frame: Frame, seen: Inspection) -> str:
    """Whom it listens to, and how much."""
    weights = np.asarray(seen.weights, float)
    total, rows = weights.sum(), ""
    heard = int(np.count_nonzero(weights > 0.0))
    for place in np.argsort(-weights)[: min(heard, MOST_NEIGHBOURS)]:
        share = 100 * weights[place] / total
        width = 100 * weights[place] / weights.max()
        rows += (
            f"<tr><td>agent {frame.ids[seen.neighbours[place]]}</td>"
            f'<td style="width:50%"><div class="fs-weight" style="width:{width:.1f}%"></div></td>'
            f"<td>{share:.0f} %</td></tr>"
        )
    more = heard - MOST_NEIGHBOURS
    rest = f'<tr><td colspan="3">and {more} more</td></tr>' if more > 0 else ""
    return f'<table class="fs-table">{rows}{rest}</table>'


LOOKING = (
    '<div class="fs-quiet">Looking closer … a model is compiled for this the first time.</div>'
)
FOLDS: tuple[Fold, ...] = ("rest", "zones", "forces", "heard")
"""What is folded up at first, from the top down; each browser unfolds for itself."""
WIDTH = 248


class Inspector:
    """There only while an agent is inspected."""

    def __init__(self, gui: viser.GuiApi, close: Callable[[], None]):
        self.panel = gui.add_panel(visible=False)
        self.folds: dict[Fold, tuple[Any, Any]] = {}
        with self.panel.add_tab("Agent", viser.Icon.ZOOM_IN):
            self.head = gui.add_html("")
            for name in FOLDS:
                with gui.add_folder("", expand_by_default=False, visible=False) as folder:
                    self.folds[name] = folder, gui.add_html("")
            button = gui.add_button("Close", icon=viser.Icon.X, color="gray")
        self.panel.float(x=WIDTH // 4, y=-12, width=WIDTH)

        async def closed(_event: viser.GuiEvent) -> None:
            close()

        button.on_click(closed)

    def refresh(self, frame: Frame, row: int | None, at: Iterable[float] = ()) -> None:
        """Show the agent of a row as it is now; nothing for None or a row that is not there.

        `at` (3,) is where it is drawn.
        """
        wanted = row is not None and row < len(frame.ids)
        if wanted and not self.panel.visible:
            self.panel.expand()  # on a phone, and where somebody has made it small
        sight(self.panel, wanted)
        if not wanted or row is None:
            return
        seen, told = frame.inspected, {}
        words = LOOKING
        if seen is not None:
            words, told = head(frame, seen), folds(frame, seen)
        place = " ".join(f"{one:.4f}" for one in np.asarray(at, float))
        mark = f'data-agent="{html.escape(frame.title)} {frame.ids[row]}" data-at="{place}"'
        self.head.content = block(
            f'<div class="fs-agent" data-panel="{identifier(self.panel)}" {mark}>{words}</div>'
        )
        for name, (folder, content) in self.folds.items():
            sight(folder, name in told)
            if name in told:
                folder.label, content.content = told[name][0], block(told[name][1])
