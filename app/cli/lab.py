"""`flockscope` and `flockscope lab`: the laboratory in a browser."""

from __future__ import annotations

import time
import webbrowser
from typing import Annotated, Any

import typer

from agents.catalogue import MODELS
from agents.catalogue import model as find_model
from agents.declare import checked
from app.cli.settings import assignment
from app.cli.stopping import Stopping
from app.viewer.start import at_home
from worlds.layout import layout_names

NOISE = 0.3
"""Noise that keeps the picture alive, rad, for models that would have none, unless told otherwise."""


def lab(
    model: Annotated[str, typer.Argument(help=f"Model: {', '.join(MODELS)}.")] = "hwvem",
    agents: Annotated[
        int | None, typer.Option(min=1, help="Number of agents; by default the model's own.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the run.")] = 1,
    dim: Annotated[
        int | None,
        typer.Option(min=2, max=3, help="2 or 3 dimensions; by default the world's own."),
    ] = None,
    world: Annotated[
        str | None,
        typer.Option(
            help=f"{', '.join(layout_names())}, or a TOML file; by default the model's own."
        ),
    ] = None,
    set: Annotated[
        list[str] | None, typer.Option("--set", help="A parameter, NAME=VALUE; may be repeated.")
    ] = None,
    speed: Annotated[float | None, typer.Option(min=0.1, help="Ticks per second at first.")] = None,
    threads: Annotated[int, typer.Option(min=1, help="Threads for a large flock.")] = 1,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port to serve on.")] = 8080,
    host: Annotated[
        str, typer.Option(help="Address to serve on; 0.0.0.0 lets the whole network in.")
    ] = "127.0.0.1",
    open_browser: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the browser.")
    ] = True,
) -> None:
    """Open the laboratory: watch a flock in the browser, steer it and measure it."""
    from app.viewer.laboratory import Laboratory

    start = at_home(
        find_model(model).name,
        agents=agents,
        seed=seed,
        dim=dim,
        world=world,
        threads=threads,
        parameters=parameters(model, set or []),
    )
    start.build()
    serve(Laboratory(start, host, port, speed), open_browser)


def parameters(model: str, settings: list[str]) -> dict[str, Any]:
    """The parameters that `--set` gives, and a little noise. Raises Refusal."""
    declared = MODELS[model].parameters
    noise = declared.model_fields.get("eta")
    given = dict(assignment(setting) for setting in settings)
    lively = {"eta": NOISE} if noise is not None and noise.default == 0.0 else {}
    made = checked(declared, lively | given, "--set").model_dump()
    return {name: made[name] for name in lively | given}


def serve(laboratory: Any, open_browser: bool) -> None:
    """Tell the address and serve until Ctrl-C."""
    try:
        with Stopping(at_once=True):
            typer.echo(f"flockscope is at {laboratory.address} (Ctrl-C stops it)")
            if not laboratory.simulation.ready.wait(0.8):
                typer.echo(
                    "compiling: only the first start of a model takes this long ...", err=True
                )
            if open_browser:
                webbrowser.open(laboratory.address)
            while True:
                time.sleep(3600)
    except KeyboardInterrupt:
        typer.echo("", err=True)
    finally:
        laboratory.close()
