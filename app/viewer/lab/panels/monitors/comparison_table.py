"""The monitors of two flocks side by side: one table, a column for each model."""

from __future__ import annotations

import html

from agents.catalogue import MODELS
from app.viewer.run.paired_run import pace_note
from app.viewer.scene.shown.frame import Frame

NOTHING = "–"


def titled_columns(first: str, second: str) -> str:
    """The titles of two models (their names), each with the line by which plots show it."""
    lines = "".join(
        f'<div><i class="fs-line fs-{kind}"></i>{html.escape(MODELS[name].title)}</div>'
        for name, kind in ((first, "solid"), (second, "dashed"))
    )
    return f'<div class="fs-pair-titles">{lines}</div>'


def compared(
    title: str, models: tuple[str, str], first: dict[str, str], second: dict[str, str]
) -> str:
    """A table of what two flocks have, name -> text; what one lacks is left open."""
    if not first and not second:
        return ""
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{first.get(name, NOTHING)}</td>"
        f"<td>{second.get(name, NOTHING)}</td></tr>"
        for name in dict.fromkeys([*first, *second])
    )
    head = "".join(
        f'<th><i class="fs-line fs-{kind}"></i>{html.escape(name)}</th>'
        for name, kind in zip(models, ("solid", "dashed"), strict=True)
    )
    return f'<table class="fs-pair"><tr><th>{html.escape(title)}</th>{head}</tr>{rows}</table>'


def keeping_up(frame: Frame, beside: Frame) -> str:
    """How the two keep the same time, in small print; nothing if tick by tick."""
    note = pace_note(frame, beside)
    return f'<div class="fs-quiet">{html.escape(note)}</div>' if note else ""
