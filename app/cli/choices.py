"""What there is to choose from: a row for each thing of each kind, and tables of them.

The rows are made from the declarations, which takes the libraries that models are declared with.
`listed.json` keeps them, so that listing needs none; `docs/make.py` writes it and a test holds it
against the declarations. Whoever declares something more sees it at once: declarations that are
newer than the file are asked themselves.
"""

from __future__ import annotations

import json
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from app.cli.terminal.console import make_console
from worlds.number_text import counted

Rows = list[dict[str, Any]]
WIDE = 80
"""Columns of the overview, and of what is said of one thing."""
LISTED = Path(__file__).with_name("listed.json")
"""The rows of all kinds, of what is built in."""
ROOT = Path(__file__).parents[2]
DECLARED = (
    "agents/**/*.py",
    "worlds/layouts/*.toml",
    "app/viewer/gallery/lessons/*.toml",
    "experiments/*.toml",
)
"""Where things are declared, below `ROOT`."""
TOGETHER = 300.0
"""Seconds within which files count as written together, as by a checkout or an installation."""
PLUG_INS = ("rules", "bodies", "observables", "layouts")
"""What other packages may add to the rows: groups of entry points, after `flockscope.`."""


def models() -> Rows:
    """All models."""
    from agents.catalogue import MODELS

    return [
        {
            "name": model.name,
            "title": model.title,
            "dimensions": list(model.dimensions),
            "informed": model.informed,
            "world": model.world,
            "agents": model.agents,
            "wish": model.rule.wish,
            "body": model.body.name,
            "time_unit": model.body.unit,
            "sees_obstacles": model.sees_obstacles,
            "forces": list(model.rule.forces + model.body.forces),
            "summary": model.summary,
            "source": model.rule.source,
        }
        for model in MODELS.values()
    ]


def parameters() -> Rows:
    """All parameters, each once, with the models that have them."""
    from agents.catalogue import MODELS
    from agents.models.declare import declared

    rows: dict[tuple, dict[str, Any]] = {}
    for model in MODELS.values():
        for parameter in declared(model.parameters):
            row = rows.setdefault(
                (parameter.name, parameter.default, parameter.allowed, parameter.description),
                {
                    "name": parameter.name,
                    "symbol": parameter.symbol,
                    "default": parameter.default,
                    "allowed": parameter.allowed,
                    "unit": parameter.unit,
                    "models": [],
                    "description": parameter.description,
                    "source": parameter.source,
                },
            )
            row["models"].append(model.name)
    return list(rows.values())


def worlds() -> Rows:
    """The built-in worlds."""
    from worlds.layout import layout_names, read_layout

    return [{"name": name, "title": read_layout(name).get("title", "")} for name in layout_names()]


def observables() -> Rows:
    """All observables."""
    from agents.observables.catalogue import OBSERVABLES

    return [
        {
            "name": observable.name,
            "unit": observable.unit,
            "range": str(observable.range),
            "title": observable.title,
        }
        for observable in OBSERVABLES.values()
    ]


def papers() -> Rows:
    """Tables and figures that `flockscope paper` repeats."""
    from app.studies.experiment_reader import experiment_names, read_experiment

    experiments = [read_experiment(name) for name in experiment_names()]
    return [
        {"name": experiment.name, "title": experiment.title, "source": experiment.source}
        for experiment in experiments
    ]


def lessons() -> Rows:
    """Lessons that `flockscope class` opens a class on."""
    from app.viewer.gallery.lessons.lessons import lesson_names
    from app.viewer.gallery.scene_collection import find_lesson

    lessons = [(name, find_lesson(name)) for name in lesson_names()]
    return [
        {
            "name": name,
            "title": scene.title,
            "model": scene.spec.model,
            "agents": scene.spec.agents,
            "watch": scene.watch,
        }
        for name, scene in lessons
    ]


KINDS = {
    "models": models,
    "worlds": worlds,
    "observables": observables,
    "papers": papers,
    "lessons": lessons,
    "parameters": parameters,
}


def list_declarations() -> dict[str, Rows]:
    """The rows of all kinds, made from the declarations."""
    return {kind: list_rows() for kind, list_rows in KINDS.items()}


def is_list_current() -> bool:
    """Whether no declaration is newer than the rows that are kept."""
    newest = max((file.stat().st_mtime for of in DECLARED for file in ROOT.glob(of)), default=0.0)
    return newest <= LISTED.stat().st_mtime + TOGETHER


def rows(has_rule_file: bool = False) -> dict[str, Rows]:
    """The rows of all kinds; from the declarations if they are newer than the rows that are kept,
    or if more is `has_rule_file` than is built in."""
    plugged = any(entry_points(group=f"flockscope.{group}") for group in PLUG_INS)
    if has_rule_file or plugged or not is_list_current():
        return list_declarations()
    stored: dict[str, Rows] = json.loads(LISTED.read_text(encoding="utf-8"))
    return stored


def names(rows: dict[str, Rows]) -> dict[str, list[str]]:
    """The names of each kind of things, each once."""
    return {kind: list(dict.fromkeys(row["name"] for row in of)) for kind, of in rows.items()}


ON_SCREEN = {
    "models": ("name", "what it does"),
    "parameters": ("name", "default", "allowed", "models", "description"),
    "lessons": ("name", "title", "watch"),
}
"""Columns for people; JSON has all of them."""
ARTICLES = {
    "heading": "a heading",
    "acceleration": "an acceleration",
    "velocity": "a velocity",
}


def show_tables(rows_by_kind: dict[str, Rows]) -> None:
    """Print tables for people."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    console = make_console()
    for kind, rows in rows_by_kind.items():
        columns = ON_SCREEN.get(kind) or tuple(rows[0])
        table = Table(*columns, title=kind, title_justify="left", box=SIMPLE_HEAD)
        table.columns[0].no_wrap = True
        for row in rows:
            entry = {**row, "what it does": describe_model(row)} if kind == "models" else row
            table.add_row(*(cell(entry[name]) for name in columns))
        console.print(table)


def describe_model(model: dict[str, Any]) -> str:
    """What a model is and does, and where it is at home."""
    dimensions = ", ".join(f"{dim}-D" for dim in model["dimensions"])
    return (
        f"{model['title']} ({dimensions}; {counted(model['agents'], 'agent')} in "
        f"{model['world']}; wishes {ARTICLES[model['wish']]})\n[dim]{model['summary']}[/dim]"
    )


def cell(value: Any) -> str:
    """A value as a cell shows it."""
    if isinstance(value, list):
        return ", ".join(cell(item) for item in value)
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)
