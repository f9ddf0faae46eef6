"""`flockscope warm`: compile models before a class, so that none of them is waited for."""

from __future__ import annotations

import json
import time
from typing import Annotated

import typer

from app.cli.usage import Rules, model_name


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
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress.")] = False,
) -> None:
    """Compile models in advance, with what is measured of them, each in its own world.

    What is compiled is kept on this machine, and is done anew only for another version.
    """
    from agents.catalogue import MODELS, model
    from app.cli.progress import Progress

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
    from agents.flock import Flock
    from app.studies.workers.kernels import compile_measures
    from app.viewer.run.kernel_compiler import call_all

    started = time.perf_counter()
    flock = Flock(name, agents=3, rng=0)
    before = flock.is_compiled
    call_all(flock)
    flock.warm()
    compile_measures(flock)
    return before, round(time.perf_counter() - started, 2)


def describe_warming(model: str, before: bool, seconds: float) -> str:
    """A line for people.

    >>> describe_warming("vem", before=False, seconds=4.2)
    'vem               compiled in 4.2 s'
    """
    return f"{model:16}  {'was compiled' if before else f'compiled in {seconds:.1f} s'}"
