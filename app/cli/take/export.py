"""`flockscope export`: a flock as one HTML file that runs it, without a server."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.options.run_arguments import GivenOptions, with_options
from app.cli.take.source import is_recording
from app.cli.terminal.outcome_table import as_json, print_stderr, print_written_files
from app.cli.terminal.usage import (
    Overwrite,
    PrintJson,
    Quiet,
    Rules,
    Settings,
    first_of,
    model_name,
)
from worlds.file_writer import demand_writable, write_text
from worlds.input_error import InputError

ENDINGS = (".html", ".htm")


@with_options
def export(
    model: Annotated[
        str | None,
        typer.Argument(help="A model, a spec (TOML), or a rule (FILE.py)."),
    ] = None,
    rule: Rules = None,
    *,
    options: GivenOptions,
    settings: Settings = None,
    title: Annotated[str, typer.Option(help="Title of the page. \\[default: the model's]")] = "",
    out: Annotated[Path, typer.Option(help="HTML file.")] = Path("flock.html"),
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Write a flock as one web page that runs by itself: offline, on a phone, from a file.

    The page runs the same compiled rule as here, with a slider for each parameter. It begins at
    the start that the seed gives. What a page cannot do yet, as a random order of turns or wind, is
    refused. What `flockscope run` takes to say which run it is, this takes too.
    """
    demand_writable("--out", out, overwrite, ENDINGS)
    if is_recording(model):
        raise InputError(f"{model} is a recording: a page runs a flock from its start")
    spec = Path(model) if model is not None and Path(model).suffix.lower() == ".toml" else None
    from app.cli.run import build_flock
    from app.web.flock_page import flock_page

    name = None if spec else first_of(model_name(model), rule)
    flock = build_flock(spec, name, options, settings or [], 1, False, quiet)
    if not quiet:
        print_stderr(f"flockscope: compiling {flock.model.name} for the page takes some seconds")
    page = flock_page(flock, title)
    write_text("--out", out, page, overwrite, ENDINGS)
    if json_asked:
        typer.echo(as_json({"page": str(out), "model": flock.model.name, "bytes": len(page)}))
    if not quiet:
        print_written_files(out)
