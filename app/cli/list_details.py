"""`flockscope list NAME`: one model, world, paper, lesson, observable or parameter, in full."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from app.cli.choices import (
    ARTICLES,
    KINDS,
    WIDE,
    Rows,
    cell,
    lessons,
    models,
    names,
    observables,
)
from app.cli.world import worlds
from worlds.input_error import InputError, shorten, suggestion
from worlds.number_text import counted

Thing = dict[str, Any]


def things_called(name: str, rows: dict[str, Rows]) -> dict[str, Any]:
    """What has that name, by kind: most names are of one kind only.

    What is none of the rows may be a model of a file, or of a rule that drives cars.

    Under `parameter` stands a list: models may have different ones under one name. Raises
    InputError.
    """
    known = names(rows)
    found = {kind: look(name) for kind, look in ONE.items() if name in known[f"{kind}s"]}
    if name in known["parameters"]:
        found["parameter"] = [row for row in rows["parameters"] if row["name"] == name]
    if not found and (name.endswith("-cars") or is_model(name)):
        found = {"model": model(name)}
    if not found:
        every = [one for kind in known.values() for one in kind]
        hint = suggestion(name, [*KINDS, *every])
        raise InputError(f"unknown name {shorten(name)}{hint} (`flockscope list` shows all)")
    return found


OF_PARAMETERS = (
    *("name", "symbol", "unit", "default", "allowed", "low", "high", "proposed"),
    *("description", "source"),
)
"""What is said of a parameter."""


def is_model(name: str) -> bool:
    """Whether there is a model of that name by now."""
    from agents.catalogue import MODELS

    return name in MODELS


def model(name: str) -> Thing:
    """A model with its parameters. Raises InputError."""
    from agents.catalogue import model as find_model
    from agents.models.declare import declared

    found = find_model(name)
    row = next(row for row in models() if row["name"] == name)
    row["parameters"] = [
        {key: getattr(one, key) for key in OF_PARAMETERS} for one in declared(found.parameters)
    ]
    row["tries"] = [
        {**asdict(one), "set": dict(one.set), "changes": one.changes, "found": one.proof.in_words}
        for one in found.to_try
    ]
    return row


def world(name: str) -> Thing:
    """A built-in world as its layout has it."""
    from worlds.layout import read_layout

    row = next(row for row in worlds() if row["name"] == name)
    return {**row, "source": read_layout(name).get("source", "")}


def observable(name: str) -> Thing:
    """An observable."""
    from agents.observables.catalogue import OBSERVABLES

    row = next(row for row in observables() if row["name"] == name)
    one = OBSERVABLES[name]
    return {**row, "over_a_run": one.over is not None, "table": one.is_table}


def paper(name: str) -> Thing:
    """A table or a figure of a paper."""
    from app.studies.experiment_reader import read_experiment

    one = read_experiment(name)
    return {
        "name": one.name,
        "title": one.title,
        "source": one.source,
        "kind": one.settings.kind,
        "models": sorted({row.spec.model for row in one.cases}),
        "agents": sorted({row.agents for row in one.cases}),
        "rows": len(one.cases),
        "runs": one.runs,
        "measures": [measure.name for measure in one.measures],
        "claims": len(one.said),
        "notes": one.notes,
    }


def lesson(name: str) -> Thing:
    """A lesson and the question that is ready for it."""
    from app.classroom.collect.question_choices import ready_for
    from app.classroom.lessons.lessons import find_lesson

    one = find_lesson(name)
    first = ready_for(one.spec, name)[0]
    row = next(row for row in lessons() if row["name"] == name)
    return {
        **row,
        "try": one.tries,
        "question": first.question.title,
        "asks": first.lesson,
        "measured": first.question.result_words,
        "values": first.question.values,
    }


ONE: dict[str, Callable[[str], Any]] = {
    "model": model,
    "world": world,
    "observable": observable,
    "paper": paper,
    "lesson": lesson,
}


def format_details(found: dict[str, Any]) -> list[str]:
    """Things for people, within WIDE columns."""
    lines: list[str] = []
    for kind, thing in found.items():
        lines += [""] if lines else []
        lines += WORDS[kind](thing)
    return lines


def about_model(one: Thing) -> list[str]:
    """A model and its parameters."""
    dimensions = " and ".join(f"{dim}-D" for dim in one["dimensions"])
    home = f"{counted(one['agents'], 'agent')} in {one['world']}"
    if one["informed"]:
        home += f", {counted(one['informed'], 'information agent')} on top"
    made = wrapped(f"{one['name']}: {one['title']} ({dimensions}; at home: {home})")
    made += wrapped(one["summary"], 2)
    made += wrapped(f"It wishes {ARTICLES[one['wish']]}. Source: {one['source']}", 2)
    made.append("parameters (--set NAME=VALUE):")
    for row in one["parameters"]:
        made += about_value(row)
    made += ["try this:"] if one["tries"] else []
    for row in one["tries"]:
        made += wrapped(f"{row['words']} ({row['changes']})", 2)
        made += wrapped(row["see"], 6)
    return [
        *made,
        f"Run it: flockscope run {one['name']}; look at it: flockscope lab {one['name']}",
    ]


def about_value(row: Thing) -> list[str]:
    """A parameter: symbol, default and range, and below it what it means."""
    symbol = f" ({row['symbol']})" if row["symbol"] != row["name"] else ""
    made = wrapped(f"{row['name']}{symbol} = {cell(row['default'])} in {row['allowed']}", 2)
    return made + wrapped(f"{row['description']} ({row['source']})", 6)


def about_world(one: Thing) -> list[str]:
    """A world."""
    made = wrapped(f"{one['name']}: {one['title']}")
    size = one["size"]
    sides = "as large as asked for" if size is None else cell(size).replace(", ", " x ") + " m"
    solid = counted(one["obstacles"], "obstacle")
    drawn = ", more drawn from the seed" if one["random"] else ""
    made += wrapped(f"size: {sides}; edges: {cell(one['edges'])}; {solid}{drawn}", 2)
    made += wrapped(f"mission: {cell(one['mission'])}", 2) if one["mission"] else []
    made += wrapped(f"source: {one['source']}", 2) if one["source"] else []
    return [*made, f"Draw it: flockscope world show {one['name']}"]


def about_observable(one: Thing) -> list[str]:
    """An observable."""
    unit = "" if one["unit"] == "1" else f" {one['unit']}"
    kind = "a table" if one["table"] else f"in {one['range']}{unit}"
    made = wrapped(f"{one['name']}: {one['title']} ({kind})")
    over = " --over 100" if one["over_a_run"] else ""
    return [*made, f"Measure it: flockscope run MODEL --observe {one['name']}{over}"]


def about_paper(one: Thing) -> list[str]:
    """A table or a figure of a paper."""
    made = wrapped(f"{one['name']}: {one['title']} ({one['source']})")
    made += wrapped(f"models: {cell(one['models'])}; agents: {cell(one['agents'])}", 2)
    rows, runs = counted(one["rows"], "row"), counted(one["runs"], "run")
    claims = f", {counted(one['claims'], 'claim')} to check" if one["claims"] else ""
    made += wrapped(f"{rows} of {runs} each{claims}", 2)
    made += wrapped(f"measures: {cell(one['measures'])}", 2)
    for note in one["notes"].values():
        made += wrapped(f"note: {note}", 2)
    return [*made, f"Repeat it: flockscope paper {one['name']}"]


def about_lesson(one: Thing) -> list[str]:
    """A lesson."""
    made = wrapped(f"{one['name']}: {one['title']} ({one['model']}, {one['agents']} agents)")
    made += wrapped(one["watch"], 2)
    made += wrapped(f"to try: {one['try']}", 2)
    made += wrapped(f"question: {one['question']}. {one['asks']}", 2)
    values = f", values {cell(one['values'])} in turn" if one["values"] else ", students choose"
    made += wrapped(f"measured: {one['measured']}{values}", 2)
    return [*made, f"Open a class on it: flockscope class {one['name']}"]


def about_parameter(rows: list[Thing]) -> list[str]:
    """The parameters of one name."""
    made = []
    for row in rows:
        made += about_value(row)
        made += wrapped(f"of {cell(row['models'])}", 6)
    return made


WORDS: dict[str, Callable[[Any], list[str]]] = {
    "model": about_model,
    "world": about_world,
    "observable": about_observable,
    "paper": about_paper,
    "lesson": about_lesson,
    "parameter": about_parameter,
}


def wrapped(text: str, indent: int = 0) -> list[str]:
    """A text in lines of WIDE columns."""
    first, rest = " " * indent, " " * (indent + 2)
    return textwrap.wrap(
        text, WIDE, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False
    )
