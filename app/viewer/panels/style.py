"""How the HTML in the panels looks: cards, keys, bars and tables."""

from __future__ import annotations

from app.package_files import STATIC

BLUE, ORANGE, GREEN, RED, GREY = "#1c7ed6", "#d97706", "#2f9e44", "#e03131", "#868e96"
VIOLET = "#8b5cf6"
"""Of curves and dots: they stand out from a light and from a dark ground, 3 to 1."""

ROOM = 8
"""Letters that fit a card in its usual type."""

CSS = f"<style>{(STATIC / 'panels.css').read_text('utf-8')}</style>"


def block(content: str) -> str:
    """Content of a panel in the house's type and spacing."""
    return f'<div class="fs">{content}</div>'


def cards(values: dict[str, str]) -> str:
    """A grid of cards, name -> value, as content of a panel."""
    return block(grid(values))


def grid(values: dict[str, str], across: int = 3) -> str:
    """A grid of cards, name -> value, so many in a row."""
    made = "".join(
        f'<div class="fs-card{" fs-long" if len(value) > ROOM else ""}">'
        f"<span>{name}</span><b>{value}</b></div>"
        for name, value in values.items()
    )
    columns = f' style="grid-template-columns:repeat({across},1fr)"' if across != 3 else ""
    return f'<div class="fs-cards"{columns}>{made}</div>'


def key(entries: list[tuple[str, str]], drawn: bool = False, hollow: bool = False) -> str:
    """A key to colours: (label, css colour), of what is `drawn` in the scene or of curves.

    `hollow`: of outlines.
    """
    shown = "border:2px solid" if hollow else "background:"
    made = "".join(
        f'<span><i style="{shown} {colour}"></i>{label}</span>' for label, colour in entries
    )
    return f'<div class="fs-key{" fs-drawn" if drawn else ""}">{made}</div>'


def table(rows: dict[str, str]) -> str:
    """A table of two columns."""
    made = "".join(f"<tr><td>{name}</td><td>{value}</td></tr>" for name, value in rows.items())
    return f'<table class="fs-table">{made}</table>'
