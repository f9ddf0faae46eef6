"""`flockscope check`: whether a model keeps to what every model keeps to."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Annotated

import typer

from app.cli.terminal import REFUSED
from app.cli.usage import Rules, first_of, model_name
from worlds.input_error import InputError


def check(
    model: Annotated[
        str | None,
        typer.Argument(help="A model, see `flockscope list`, or a FILE.py.", callback=model_name),
    ] = None,
    rule: Rules = None,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
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
