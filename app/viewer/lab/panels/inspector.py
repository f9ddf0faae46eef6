"""The card of the agent that was clicked: a window of its own, which each browser puts beside it.

`card.js` does so, by what the card says of where the agent is drawn.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Collection, Iterable
from typing import Any, Literal

import numpy as np
import viser

from agents.individuals import Distribution
from agents.inspection import UNSEEN, Inspection
from agents.models.declare import describe
from agents.models.model import vector_name
from agents.observables.of_agents import ON_ITS_WAY
from agents.state.agent_rows import CAUSES, Crashes
from app.front.viser_internals import identifier
from app.steering.hand_pilot import ways_of
from app.viewer.lab.steer_requests import steered_kind
from app.viewer.measuring import observable_format
from app.viewer.panels.dials import plain_symbol, set_visible
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
LONGEST_NAME = 40
"""Letters of an individual's name in a file of tracks that are shown."""

Fold = Literal["own", "rest", "zones", "forces", "heard"]


def head(frame: Frame, inspection: Inspection) -> str:
    """Who it is, and the most telling rows."""
    rows = dict(list(facts(frame, inspection).items())[:FIRST])
    kind = " · information agent" if frame.informed[inspection.row] else ""
    kind += kind_text(frame, inspection.row)
    flock = f'<div class="fs-quiet">{html.escape(frame.title)}</div>' if frame.title else ""
    name = f"Agent {inspection.id}"
    if inspection.name:
        name = f"Individual {html.escape(inspection.name[:LONGEST_NAME])}"
    return f'<h2 class="fs-head">{name}{kind}</h2>{flock}{escaped_table(rows)}'


def kind_text(frame: Frame, row: int) -> str:
    """Of which kind an agent is, HTML; nothing where there are no kinds."""
    if frame.kind is None:
        return ""
    number = int(frame.kind[row])
    name = "caught" if number < 0 else f"kind {html.escape(frame.kinds.names[number])}"
    if number in frame.kinds.with_model:
        name += f", {html.escape(frame.kinds.with_model[number].model)}"
    colour = palette.css(palette.colours_by_kind(frame.kind[row : row + 1], frame.kinds)[0])
    return f'<span><i class="fs-dot fs-small" style="background:{colour}"></i>{name}</span>'


def folds(frame: Frame, inspection: Inspection) -> dict[Fold, tuple[str, str]]:
    """The rest, each by what is written on it and the HTML in it; nothing of what there is not."""
    rest = dict(list(facts(frame, inspection).items())[FIRST:])
    texts: dict[Fold, tuple[str, str]] = {}
    if own := own_facts(frame, inspection):
        texts["own"] = own_title(frame, inspection.row), escaped_table(own)
    if rest:
        texts["rest"] = f"{counted(len(rest), 'more row')}", escaped_table(rest)
    if frame.is_down[inspection.row]:
        return texts
    if inspection.shells:
        noticed = int(np.count_nonzero(inspection.zone != UNSEEN))
        texts["zones"] = f"Zones: {noticed} noticed", describe_zones(inspection)
    if inspection.forces:
        texts["forces"] = (
            f"Forces: {max(inspection.forces, key=lambda name: strength(inspection, name))}",
            describe_forces(inspection),
        )
    heard_count = int(np.count_nonzero(np.asarray(inspection.weights) > 0.0))
    if heard_count:
        texts["heard"] = (
            f"Listens to {counted(heard_count, 'agent')}",
            describe_listening(frame, inspection),
        )
    return texts


def escaped_table(rows: dict[str, str]) -> str:
    """A table of words and values."""
    return table({html.escape(name): html.escape(value) for name, value in rows.items()})


def facts(frame: Frame, inspection: Inspection) -> dict[str, str]:
    """An agent's state, words -> value with unit, the most telling first."""
    ux, crashes, model = frame.heading[inspection.row], frame.crashes, inspection.model
    listed: dict[str, str] = {}
    if frame.is_down[inspection.row] and crashes is not None:
        listed["crashed"] = crash_text(crashes, inspection.row)
    length = model.in_units("length") if model else "length"
    listed[f"position ({length})"] = vector(frame.position[inspection.row])
    listed["heading"] = f"{np.degrees(np.arctan2(ux[1], ux[0])) % 360:.0f}°"
    if frame.dim == 3:
        listed["climb"] = f"{np.degrees(np.arcsin(np.clip(ux[2], -1, 1))):+.0f}°"
    pace = model.in_units("length/time") if model else frame.pace_unit
    listed["speed"] = f"{observable_format.format_short(frame.speed[inspection.row])} {pace}"
    listed["neighbours"] = counted(len(inspection.neighbours), "agent")
    own = signal_facts(inspection)
    if "drag saved" in own:
        listed["drag saved"] = own.pop("drag saved")
    if frame.group is not None and inspection.row < len(frame.group):
        listed["group"] = f"number {int(frame.group[inspection.row]) + 1} by size"
    if inspection.known:  # of tracks: nobody knows whom an individual listens to
        listed = dict(inspection.known) | listed
        del listed["neighbours"]
    elif not np.any(np.asarray(inspection.weights) > 0.0) and not frame.is_down[inspection.row]:
        listed["listens to"] = "nobody"
    return listed | own


def own_title(frame: Frame, row: int) -> str:
    """An agent's own number of a parameter, or how many it has."""
    numbers = own_numbers(frame, row)
    if len(numbers) > 1:
        return f"{len(numbers)} numbers of its own"
    ((name, number),) = numbers.items()
    return f"Its own {name}: {number:.4g}"


def own_numbers(frame: Frame, row: int) -> dict[str, float]:
    """An agent's own numbers by name, without those of parameters that its model has not."""
    numbers = {name: float(column[row]) for name, column in frame.own.items()}
    return {name: number for name, number in numbers.items() if not np.isnan(number)}


def own_facts(frame: Frame, inspection: Inspection) -> dict[str, str]:
    """An agent's own parameters beside what those of all are drawn from, words -> value."""
    listed: dict[str, str] = {}
    for name, number in own_numbers(frame, inspection.row).items():
        words, unit = name, ""
        if inspection.model is not None and name in inspection.model.parameters.model_fields:
            one = describe(name, inspection.model.parameters.model_fields[name])
            words = f"{one.words} {plain_symbol(one.symbol)}"
            unit = "" if one.unit == "1" else f" {one.unit}"
        drawn_from = source_of(frame, name, inspection.row)
        among = "" if drawn_from is None else f" of {drawn_from}"
        listed[words] = f"{number:.4g}{unit}{among}"
    return listed


def source_of(frame: Frame, name: str, row: int) -> Distribution | None:
    """What an agent's own number of a parameter was drawn from; None: it has that of its kind."""
    number = 0 if frame.kind is None else int(frame.kind[row])
    if number > 0 and name in frame.kinds.kinds[number - 1].parameters:
        value = frame.kinds.kinds[number - 1].parameters[name]
        return value if isinstance(value, Distribution) and not value.is_by_hand else None
    return None if number in frame.kinds.with_model else frame.individuals.get(name)


def vector(parts: object) -> str:
    """A place or a vector in figures."""
    return "(" + ", ".join(f"{value:.2f}" for value in np.asarray(parts, float)) + ")"


def crash_text(crashes: Crashes, row: int) -> str:
    """When and against what an agent crashed."""
    (place,) = np.flatnonzero(crashes.row == row)
    return f"tick {crashes.tick[place]}, {CAUSES[int(crashes.cause[place])]}"


def signal_facts(inspection: Inspection) -> dict[str, str]:
    """What an agent tells and keeps, words -> value with unit; places only while they count."""
    listed: dict[str, str] = {}
    for name, value in inspection.signals.items():
        stem = vector_name(name)
        components = [f"{stem}_{axis}" for axis in "xyz" if f"{stem}_{axis}" in inspection.signals]
        if ON_ITS_WAY in name or (name in components and name != components[0]):
            continue
        if stem in inspection.places and not inspection.minds:
            continue
        words = inspection.model.words_of(name) if inspection.model else stem.replace("_", " ")
        unit = inspection.model.unit_of(name) if inspection.model else "1"
        unit = "" if unit == "1" else unit
        if len(components) > 1:
            across = inspection.separation.shape[1]
            parts = [inspection.signals[name] for name in components[:across]]
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


def describe_zones(inspection: Inspection) -> str:
    """How many neighbours are in each zone of its rule, and how many it does not see."""
    inner, rows = 0.0, ""
    length = inspection.model.in_units("length") if inspection.model else "length"
    for index, shell in enumerate(inspection.shells):
        count = int(np.count_nonzero(inspection.zone == index))
        extent = f"{min(inner, shell.radius):g} – {shell.radius:g} {length}"
        rows += entry(palette.ZONES[index % len(palette.ZONES)], shell.name, extent, count)
        inner = max(inner, shell.radius)
    unseen = int(np.count_nonzero(inspection.zone == UNSEEN))
    rows += entry(palette.BLIND, "not noticed", "", unseen)
    view = (
        f'<div class="fs-quiet">sees {inspection.view:g}°</div>' if inspection.view < 360.0 else ""
    )
    return f'<table class="fs-table">{rows}</table>{view}'


def entry(colour: np.ndarray, name: str, extent: str, count: int) -> str:
    """A row of the table of zones."""
    return (
        f'<tr><td><i class="fs-dot fs-small" style="background:{palette.css(colour)}"></i>'
        f"{html.escape(name)}</td><td>{extent}</td><td>{count}</td></tr>"
    )


def strength(inspection: Inspection, name: str) -> float:
    """How strong a force is."""
    return float(np.linalg.norm(inspection.forces[name]))


def force_unit(inspection: Inspection, name: str) -> str:
    """The unit of a term of what the rule wishes, or of the body's velocity."""
    if inspection.model is None:
        return ""
    pace = inspection.model.in_units("length/time")
    if name in inspection.model.rule.forces and inspection.model.rule.wish == "acceleration":
        return f"{pace}²"
    return pace


def describe_forces(inspection: Inspection) -> str:
    """The forces on it, by the colours of their arrows, and how strong they are."""
    colours = [palette.css(colour) for colour in force_colours(len(inspection.forces))]
    length = {name: strength(inspection, name) for name in inspection.forces}
    most = max([*length.values(), 1e-300])
    rows = "".join(
        f'<tr><td><i class="fs-dot fs-small" style="background:{colour}"></i>'
        f"{html.escape(name)}</td>"
        f'<td style="width:25%"><div class="fs-weight" '
        f'style="width:{100 * value / most:.1f}%;background:{colour}"></div></td>'
        f'<td style="white-space:nowrap">{observable_format.format_short(value)} '
        f"{force_unit(inspection, name)}</td></tr>"
        for (name, value), colour in zip(length.items(), colours, strict=True)
    )
    return f'<table class="fs-table">{rows}</table>'


def describe_listening(frame: Frame, inspection: Inspection) -> str:
    """Whom it listens to, and how much."""
    weights = np.asarray(inspection.weights, float)
    total, rows = weights.sum(), ""
    heard_count = int(np.count_nonzero(weights > 0.0))
    for place in np.argsort(-weights)[: min(heard_count, MOST_NEIGHBOURS)]:
        share = 100 * weights[place] / total
        width = 100 * weights[place] / weights.max()
        rows += (
            f"<tr><td>agent {frame.ids[inspection.neighbours[place]]}</td>"
            f'<td style="width:50%"><div class="fs-weight" style="width:{width:.1f}%"></div></td>'
            f"<td>{share:.0f} %</td></tr>"
        )
    more = heard_count - MOST_NEIGHBOURS
    rest = f'<tr><td colspan="3">and {more} more</td></tr>' if more > 0 else ""
    return f'<table class="fs-table">{rows}{rest}</table>'


LOOKING = (
    '<div class="fs-quiet">Looking closer … a model is compiled for this the first time.</div>'
)
FOLDS: tuple[Fold, ...] = ("own", "rest", "zones", "forces", "heard")
"""What is folded up at first, from the top down; each browser unfolds for itself."""
WIDTH = 248
STEER = "Steer this agent"
"""Of the button that `steer.js` heeds."""
BY_HAND = "Steered by hand"


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
            self.steer = gui.add_button(
                STEER,
                icon=viser.Icon.STEERING_WHEEL,
                color="gray",
                visible=False,
                hint="By arrow keys, by W, A, S and D, or by a stick on the picture",
            )
            button = gui.add_button("Close", icon=viser.Icon.X, color="gray")
        self.panel.float(x=WIDTH // 4, y=-12, width=WIDTH)

        async def closed(_event: viser.GuiEvent) -> None:
            close()

        button.on_click(closed)

    def refresh(
        self,
        frame: Frame,
        row: int | None,
        at: Iterable[float] = (),
        by_hand: Collection[int] = (),
        played: str = "",
    ) -> None:
        """Show the agent of a row as it is now; nothing for None or a row that is not there.

        `at` (3,) is where it is drawn; `by_hand`, the identities of those whom people steer;
        `played`, the kind whose agents alone can be steered here; empty: all.
        """
        exists = row is not None and row < len(frame.ids)
        if exists and not self.panel.visible:
            self.panel.expand()  # on a phone, and where somebody has made it small
        set_visible(self.panel, exists)
        if not exists or row is None:
            return
        inspection, texts = frame.inspected, {}
        words = LOOKING
        if inspection is not None:
            words, texts = head(frame, inspection), folds(frame, inspection)
            if inspection.id in by_hand:
                words += f'<div class="fs-quiet">{BY_HAND}</div>'
        place = " ".join(f"{value:.4f}" for value in np.asarray(at, float))
        mark = f'data-agent="{html.escape(frame.title)} {frame.ids[row]}" data-at="{place}"'
        kind = steered_kind(frame, row)
        set_visible(self.steer, bool(kind) and played in ("", kind))
        if self.steer.visible and inspection is not None and inspection.model is not None:
            ways = " ".join(ways_of(inspection.model.rule.wish, frame.dim))
            mark += f' data-steer="{frame.ids[row]}" data-run="{frame.run}" data-ways="{ways}"'
        self.head.content = block(
            f'<div class="fs-agent" data-panel="{identifier(self.panel)}" {mark}>{words}</div>'
        )
        for name, (folder, content) in self.folds.items():
            set_visible(folder, name in texts)
            if name in texts:
                folder.label, content.content = texts[name][0], block(texts[name][1])
