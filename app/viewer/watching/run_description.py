"""What is told of the run to those who watch it: whose it is, how it stands, and its parameters."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from typing import Any

from agents.catalogue import MODELS
from agents.models.declare import DeclaredParameter, declared
from app.viewer.lab.panels.run_panel import status
from app.viewer.measuring.run_conditions import worded
from app.viewer.panels.notation import plain
from app.viewer.panels.parameters import raised_powers
from app.viewer.panels.style import block
from app.viewer.run.simulation_state import SimulationState

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
    return block(told)


def listed(title: str, own: Iterable[DeclaredParameter], values: Mapping[str, Any]) -> str:
    """A table of parameters under a title."""
    rows = "".join(row(one, values[one.name]) for one in own if one.name in values)
    head = f'<div class="fs-head">{html.escape(title)}</div>'
    return f'{head}<table class="fs-table fs-values">{rows}</table>'


def row(one: DeclaredParameter, value: Any) -> str:
    """A parameter in words, with its symbol, its value and its unit."""
    symbol = f" {plain(one.symbol)}" if one.kind == "number" else ""
    unit = f" {raised_powers(one.unit)}" if one.kind == "number" and one.unit != "1" else ""
    told = html.escape(f"{worded(value)}{unit}")
    if value != one.default:
        usual = html.escape(worded(one.default))
        told = f'<b>{told}</b><div class="fs-quiet">usually {usual}</div>'
    return f"<tr><td>{html.escape(one.words + symbol)}</td><td>{told}</td></tr>"
