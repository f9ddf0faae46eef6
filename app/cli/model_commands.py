"""What the command line does with models: `check`, `warm` (compile), `list kernels`, `cite`."""

from __future__ import annotations

import json
import time
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.terminal.console import REFUSED
from app.cli.terminal.usage import PrintJson, Rules, first_of, model_name
from worlds.input_error import InputError
from worlds.number_text import counted

if TYPE_CHECKING:
    from agents.models.model import Model


def model_names(models: list[str] | None) -> list[str] | None:
    """The names of models, those of files among them. Raises InputError."""
    return [str(model_name(model)) for model in models] if models else None


def warm(
    models: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="MODEL...",
            help="Models, see `flockscope list`, or files; by default all of them.",
            callback=model_names,
        ),
    ] = None,
    rule: Rules = None,
    json_asked: PrintJson = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress.")] = False,
) -> None:
    """Compile models in advance, with what is measured of them, each in its own world.

    What is compiled is kept on this machine, and is done anew only for another version.
    """
    from agents.catalogue import MODELS, model
    from app.cli.terminal.progress import Progress

    names = [model(name).name for name in models or rule or MODELS]
    results = []
    with Progress("compiling", quiet) as progress:
        for place, name in enumerate(names):
            progress.update(place / len(names), text=name)
            before, seconds = compile_model(name)
            results.append({"model": name, "before": before, "seconds": seconds})
            if not json_asked:
                typer.echo(describe_warming(name, before, seconds))
    if json_asked:
        typer.echo(json.dumps(results))


def compile_model(name: str) -> tuple[bool, float]:
    """Compile a model's loop and observables: whether its loop was compiled before, and seconds."""
    from agents.engine.noise import compile_draws
    from agents.flock import Flock
    from app.studies.workers.kernels import compile_measures
    from app.viewer.run.kernel_compiler import call_all

    started = time.perf_counter()
    flock = Flock(name, agents=3, rng=0)
    before = flock.is_compiled
    call_all(flock)
    flock.warm()
    compile_measures(flock)
    compile_draws()
    return before, round(time.perf_counter() - started, 2)


def describe_warming(model: str, before: bool, seconds: float) -> str:
    """A line for people.

    >>> describe_warming("vem", before=False, seconds=4.2)
    'vem               compiled in 4.2 s'
    """
    return f"{model:16}  {'was compiled' if before else f'compiled in {seconds:.1f} s'}"


def list_differences() -> list[dict[str, Any]]:
    """Of each model whether it can have kinds of agents, whether it can be the model of a kind, and
    what agents cannot differ in."""
    from agents.catalogue import MODELS

    return [
        {
            "model": model.name,
            "kinds": "yes, where all within reach are neighbours"
            if "neighbours" in model.parameters.model_fields
            else "yes",
            "known": list(model.rule.kinds),
            "own_model": describe_own_model(model),
            "individual": list(model.individual),
            "shared": model.shared,
        }
        for model in MODELS.values()
    ]


def describe_own_model(model: Model) -> str:
    """Whether a model can be that of a kind in flocks of other models, and what these share."""
    from agents.kind_models import describe_known_kinds, reason_against

    if reason := reason_against(model) or describe_known_kinds(model):
        return f"no, {reason}"
    tick, length = model.body.lasts(model.parameters()), model.in_units("length")
    ticks = "in ticks" if model.body.unit == "ticks" else f"in ticks of {tick:g} {model.body.unit}"
    lengths = "" if length == "length" else f", lengths in {length}"
    metric = ", with neighbours=metric" if model.nearest(model.parameters()) else ""
    return f"yes, {ticks}{lengths}{metric}"


def describe_differences(models: list[dict[str, Any]]) -> list[str]:
    """What is told of them: a line for each model, one for each reason."""
    lines = []
    for row in models:
        lines.append(f"{row['model']:22} kinds: {row['kinds']}")
        lines.append(f"{'':22} as the model of a kind: {row['own_model']}")
        if row["known"]:
            lines.append(f"{'':22} its rule knows: {', '.join(row['known'])}")
        by_reason: dict[str, list[str]] = {}
        for name, reason in row["shared"].items():
            by_reason.setdefault(reason, []).append(name)
        lines += [
            f"{'':22} cannot differ: {', '.join(names)} ({reason})"
            for reason, names in by_reason.items()
        ]
    return lines


def list_kernels() -> dict[str, Any]:
    """Which kernels are on this machine, for which CPUs, and which models run without a wait."""
    from agents.catalogue import MODELS
    from agents.engine import cache
    from agents.flock import Flock

    own, shipped = cache.cache_base(), cache.SHIPPED
    places = {
        str(base / cache.FOLDER): {
            target: {"kernels": number, "bytes": size}
            for target, (number, size) in cache.count_kernels(base).items()
        }
        for base in (own, shipped)
    }
    loops = {name: Flock(name, agents=3, rng=0).loop.advance._cache for name in MODELS}
    compiled = {
        name: ("wheel" if loop.shipped_files() else "here") if loop.is_intact() else None
        for name, loop in loops.items()
    }
    return {
        "target": cache.target_name().rpartition("-")[0],
        "places": places,
        "models": [{"model": name, "compiled": place} for name, place in compiled.items()],
    }


def describe_kernels(listed: dict[str, Any]) -> list[str]:
    """The same for people."""
    lines = [f"compiled for {listed['target']} on this machine"]
    for place, targets in listed["places"].items():
        lines += [
            f"{place}: {counted(of['kernels'], 'kernel')} for {target}, {of['bytes'] / 1e6:.1f} MB"
            for target, of in targets.items()
        ]
    models = listed["models"]
    for compiled, words in (
        ("here", "compiled here"),
        ("wheel", "compiled in the wheel"),
        (None, "compiled at the first tick"),
    ):
        names = [row["model"] for row in models if row["compiled"] == compiled]
        if names:
            lines.append(f"{words} ({len(names)}): {', '.join(names)}")
    return lines


def check(
    model: Annotated[
        str | None,
        typer.Argument(help="A model, see `flockscope list`, or a FILE.py.", callback=model_name),
    ] = None,
    rule: Rules = None,
    json_asked: PrintJson = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Only what fails.")] = False,
) -> None:
    """Check a model as the built-in ones are: threads, order, symmetries, edges, odd starts.

    The exit code is 2 if a check fails.
    """
    from agents.catalogue import model as find_model
    from agents.conformance import CHECKS, outcome
    from agents.flock import Flock
    from app.studies.workers.kernels import compile_loop

    name = first_of(model, rule)
    if name is None:
        raise InputError("which MODEL? `flockscope list models` names them; or give --rule FILE.py")
    checked_model = find_model(name)
    tell = None if quiet else lambda line: typer.echo(line, err=True)
    compile_loop(Flock(name, agents=1, rng=0), tell)
    results = []
    for check_name in CHECKS:
        came = outcome(checked_model, check_name)
        results.append(came)
        if not json_asked and (not quiet or came.result == "fails"):
            reason = f" ({came.reason})" if came.reason else ""
            typer.echo(f"{came.result:14}  {check_name:10}  {came.fact}{reason}")
    if json_asked:
        typer.echo(json.dumps({"model": name, "checks": [asdict(came) for came in results]}))
    if any(came.result == "fails" for came in results):
        raise typer.Exit(REFUSED)


def cite(
    model: Annotated[str, typer.Argument(help="Name of a model, see `flockscope list models`.")],
    as_json: PrintJson = False,
) -> None:
    """Print the sources of a model as BibTeX."""
    from agents.catalogue import model as by_name
    from agents.models import sources

    cited = by_name(model)
    entries = sources.cite(cited)
    if as_json:
        value = {"model": cited.name, "source": cited.rule.source, "bibtex": entries}
        typer.echo(json.dumps(value))
    elif entries:
        typer.echo("\n\n".join(entries))
    else:
        typer.echo(f"{cited.name} names no paper known here; its source: {cited.rule.source}")
