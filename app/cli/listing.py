"""`flockscope list`: what there is to choose from, and all about one of it."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable
from dataclasses import asdict
from typing import Annotated, Any

import typer

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
    rows,
    show_tables,
)
from app.cli.model_commands import (
    describe_differences,
    describe_kernels,
    list_differences,
    list_kernels,
)
from app.cli.terminal.usage import PrintJson, Rules, model_name
from app.cli.world import worlds
from worlds.input_error import InputError, shorten, suggestion
from worlds.number_text import counted


def listing(
    what: Annotated[
        str | None,
        typer.Argument(
            help=f"{', '.join(KINDS)}, kinds, kernels, or one name: a model, a world ...",
            callback=model_name,
        ),
    ] = None,
    rule: Rules = None,
    as_json: PrintJson = False,
) -> None:
    """List all names, one kind of things, or one thing in full.

    `kinds` lists which models can have kinds of agents, or be the model of a kind, and what agents
    cannot differ in.
    `kernels` lists what is compiled on this machine, and for which CPUs.
    """
    if what == "kinds":
        differences = list_differences()
        text = "\n".join(describe_differences(differences))
        typer.echo(json.dumps(differences) if as_json else text)
        return
    if what == "kernels":
        kernels = list_kernels()
        typer.echo(json.dumps(kernels) if as_json else "\n".join(describe_kernels(kernels)))
        return
    rows_by_kind = rows(has_rule_file=bool(rule))
    if what is None:
        typer.echo(json.dumps(rows_by_kind) if as_json else "\n".join(overview(rows_by_kind)))
    elif what in KINDS:
        if as_json:
            typer.echo(json.dumps(rows_by_kind[what]))
        else:
            show_tables({what: rows_by_kind[what]})
    else:
        matches = find_by_name(what, rows_by_kind)
        if as_json:
            typer.echo(json.dumps(matches))
        else:
            typer.echo("\n".join(format_details(matches)))


def overview(rows_by_kind: dict[str, Rows]) -> list[str]:
    """All names on one screen, and how to see more of them."""
    lines = [
        "One thing:  flockscope list NAME, as in `flockscope list hwvem`",
        "One kind:   flockscope list KIND, as in `flockscope list models`",
    ]
    for kind, kind_names in names(rows_by_kind).items():
        if kind == "parameters":
            how = "flockscope list MODEL shows those of a model"
            lines.append(f"{kind} ({len(kind_names)}): {how}")
            continue
        lines.append(f"{kind} ({len(kind_names)})")
        lines += textwrap.wrap(
            ", ".join(kind_names), WIDE - 2, initial_indent="  ", subsequent_indent="  ",
            break_on_hyphens=False,
        )  # fmt: skip
    return lines


# `flockscope list NAME`: one model, world, paper, lesson, observable or parameter, in full.


Thing = dict[str, Any]


def find_by_name(name: str, rows: dict[str, Rows]) -> dict[str, Any]:
    """What has that name, by kind: most names are of one kind only.

    What is none of the rows may be a model of a file, or of a rule that drives cars.

    Under `parameter` stands a list: models may have different ones under one name. Raises
    InputError.
    """
    known_names = names(rows)
    matches = {kind: look(name) for kind, look in ONE.items() if name in known_names[f"{kind}s"]}
    if name in known_names["parameters"]:
        matches["parameter"] = [row for row in rows["parameters"] if row["name"] == name]
    if not matches and (name.endswith("-cars") or is_model(name)):
        matches = {"model": model(name)}
    if not matches:
        every = [item_name for kind in known_names.values() for item_name in kind]
        hint = suggestion(name, [*KINDS, "kinds", "kernels", *every])
        raise InputError(f"unknown name {shorten(name)}{hint} (`flockscope list` shows all)")
    return matches


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
    from agents.catalogue import MODELS
    from agents.catalogue import model as find_model
    from agents.models.declare import declared
    from agents.models.related import related_models

    model = find_model(name)
    row = next(row for row in models() if row["name"] == name)
    row["parameters"] = [
        {key: getattr(parameter, key) for key in OF_PARAMETERS}
        for parameter in declared(model.parameters)
    ]
    row["kinds"] = list(model.rule.kinds)
    row["related"] = [other.name for other in related_models(model, list(MODELS.values()))]
    row["tries"] = [
        {
            **asdict(step),
            "set": dict(step.set),
            "changes": step.changes,
            "found": step.proof.in_words,
        }
        for step in model.to_try
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
    observable = OBSERVABLES[name]
    return {**row, "over_a_run": observable.over is not None, "table": observable.is_table}


def paper(name: str) -> Thing:
    """A table or a figure of a paper."""
    from app.studies.experiment_reader import read_experiment

    experiment = read_experiment(name)
    return {
        "name": experiment.name,
        "title": experiment.title,
        "source": experiment.source,
        "kind": experiment.settings.kind,
        "models": sorted({row.spec.model for row in experiment.cases}),
        "agents": sorted({row.agents for row in experiment.cases}),
        "rows": len(experiment.cases),
        "runs": experiment.runs,
        "measures": [measure.name for measure in experiment.measures],
        "claims": len(experiment.said),
        "notes": experiment.notes,
    }


def lesson(name: str) -> Thing:
    """A lesson and the question that is ready for it."""
    from app.classroom.collect.question_choices import ready_for
    from app.viewer.gallery.scene_collection import find_lesson

    scene = find_lesson(name)
    first = ready_for(scene.spec, name, scene.steps)[0]
    row = next(row for row in lessons() if row["name"] == name)
    return {
        **row,
        "try": scene.tries,
        "question": first.question.title,
        "asks": first.lesson,
        "measured": first.question.result_words,
        "values": first.question.values,
        "steps": [step.values() for step in scene.steps],
    }


ONE: dict[str, Callable[[str], Any]] = {
    "model": model,
    "world": world,
    "observable": observable,
    "paper": paper,
    "lesson": lesson,
}


def format_details(matches: dict[str, Any]) -> list[str]:
    """Things for people, within WIDE columns."""
    lines: list[str] = []
    for kind, thing in matches.items():
        lines += [""] if lines else []
        lines += WORDS[kind](thing)
    return lines


def describe_model(thing: Thing) -> list[str]:
    """A model and its parameters."""
    dimensions = " and ".join(f"{dim}-D" for dim in thing["dimensions"])
    home = f"{counted(thing['agents'], 'agent')} in {thing['world']}"
    if thing["informed"]:
        home += f", {counted(thing['informed'], 'information agent')} on top"
    lines = wrap_text(f"{thing['name']}: {thing['title']} ({dimensions}; at home: {home})")
    lines += wrap_text(thing["summary"], 2)
    lines += wrap_text(f"It wishes {ARTICLES[thing['wish']]}. Source: {thing['source']}", 2)
    if thing["kinds"]:
        knows = ", ".join(thing["kinds"])
        lines += wrap_text(f"It knows kinds of agents (--kind NAME=NUMBER): {knows}", 2)
    lines.append("parameters (--set NAME=VALUE):")
    for row in thing["parameters"]:
        lines += describe_value(row)
    lines += ["try this:"] if thing["tries"] else []
    for row in thing["tries"]:
        lines += wrap_text(f"{row['words']} ({row['changes']})", 2)
        lines += wrap_text(row["see"], 6)
    lines += wrap_text(f"see also: {cell(thing['related'])}") if thing["related"] else []
    return [
        *lines,
        f"Run it: flockscope run {thing['name']}; look at it: flockscope lab {thing['name']}",
    ]


def describe_value(row: Thing) -> list[str]:
    """A parameter: symbol, default and range, and below it what it means."""
    symbol = f" ({row['symbol']})" if row["symbol"] != row["name"] else ""
    lines = wrap_text(f"{row['name']}{symbol} = {cell(row['default'])} in {row['allowed']}", 2)
    return lines + wrap_text(f"{row['description']} ({row['source']})", 6)


def describe_world(thing: Thing) -> list[str]:
    """A world."""
    lines = wrap_text(f"{thing['name']}: {thing['title']}")
    size = thing["size"]
    sides = "as large as asked for" if size is None else cell(size).replace(", ", " x ") + " m"
    solid = counted(thing["obstacles"], "obstacle")
    random_note = ", more drawn from the seed" if thing["random"] else ""
    lines += wrap_text(f"size: {sides}; edges: {cell(thing['edges'])}; {solid}{random_note}", 2)
    lines += wrap_text(f"mission: {cell(thing['mission'])}", 2) if thing["mission"] else []
    lines += wrap_text(f"source: {thing['source']}", 2) if thing["source"] else []
    return [*lines, f"Draw it: flockscope world show {thing['name']}"]


def describe_observable(thing: Thing) -> list[str]:
    """An observable."""
    unit = "" if thing["unit"] == "1" else f" {thing['unit']}"
    kind = "a table" if thing["table"] else f"in {thing['range']}{unit}"
    lines = wrap_text(f"{thing['name']}: {thing['title']} ({kind})")
    over = " --over 100" if thing["over_a_run"] else ""
    return [*lines, f"Measure it: flockscope run MODEL --observe {thing['name']}{over}"]


def describe_paper(thing: Thing) -> list[str]:
    """A table or a figure of a paper."""
    lines = wrap_text(f"{thing['name']}: {thing['title']} ({thing['source']})")
    lines += wrap_text(f"models: {cell(thing['models'])}; agents: {cell(thing['agents'])}", 2)
    rows, runs = counted(thing["rows"], "row"), counted(thing["runs"], "run")
    claims = f", {counted(thing['claims'], 'claim')} to check" if thing["claims"] else ""
    lines += wrap_text(f"{rows} of {runs} each{claims}", 2)
    lines += wrap_text(f"measures: {cell(thing['measures'])}", 2)
    for note in thing["notes"].values():
        lines += wrap_text(f"note: {note}", 2)
    return [*lines, f"Repeat it: flockscope paper {thing['name']}"]


def describe_lesson(thing: Thing) -> list[str]:
    """A lesson."""
    from app.viewer.gallery.scene_steps import SceneStep

    lines = wrap_text(
        f"{thing['name']}: {thing['title']} ({thing['model']}, {thing['agents']} agents)"
    )
    lines += wrap_text(thing["watch"], 2)
    lines += wrap_text(f"to try: {thing['try']}", 2)
    lines += wrap_text(f"question: {thing['question']}. {thing['asks']}", 2)
    values = f", values {cell(thing['values'])} in turn" if thing["values"] else ", students choose"
    lines += wrap_text(f"measured: {thing['measured']}{values}", 2)
    for number, step in enumerate(thing["steps"], 1):
        lines += wrap_text(f"step {number}: {SceneStep.model_validate(step).describe()}", 2)
    lines.append(f"Write a page of its steps: flockscope export --lesson {thing['name']}")
    return [*lines, f"Open a class on it: flockscope class {thing['name']}"]


def describe_parameter(rows: list[Thing]) -> list[str]:
    """The parameters of one name."""
    lines = []
    for row in rows:
        lines += describe_value(row)
        lines += wrap_text(f"of {cell(row['models'])}", 6)
    return lines


WORDS: dict[str, Callable[[Any], list[str]]] = {
    "model": describe_model,
    "world": describe_world,
    "observable": describe_observable,
    "paper": describe_paper,
    "lesson": describe_lesson,
    "parameter": describe_parameter,
}


def wrap_text(text: str, indent: int = 0) -> list[str]:
    """A text in lines of WIDE columns."""
    first, rest = " " * indent, " " * (indent + 2)
    return textwrap.wrap(
        text, WIDE, initial_indent=first, subsequent_indent=rest, break_on_hyphens=False
    )
