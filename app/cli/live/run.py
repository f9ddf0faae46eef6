"""`flockscope live run`: drive the cars of a laboratory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.live.live_options import LinkName, Seconds, SourceName, Ticks
from app.cli.options.run_length import demand_one_length
from app.cli.terminal.outcome_table import as_json
from app.cli.terminal.usage import Rules
from worlds.input_error import InputError
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    from app.live.laboratory.lab_file import Lab
    from app.live.operating.loop_process import Opener


def run(
    file: Annotated[Path, typer.Argument(help="The laboratory's file, LAB.toml.")],
    arm: Annotated[
        bool, typer.Option("--arm", help="Arm once every car is seen and nothing is amiss.")
    ] = False,
    record: Annotated[
        Path | None, typer.Option(help="Record poses, commands and events in this new folder.")
    ] = None,
    source: SourceName = None,
    link: LinkName = None,
    dry: Annotated[bool, typer.Option("--dry", help="Send nothing: the link is `dry`.")] = False,
    seconds: Seconds = None,
    ticks: Ticks = None,
    json_asked: Annotated[
        bool, typer.Option("--json", help="Print events and summary as lines of JSON.")
    ] = False,
    rule: Rules = None,  # noqa: ARG001 - taken into the catalogue before this is called
    quiet: Annotated[bool, typer.Option("--quiet", help="Only the summary.")] = False,
) -> None:
    """Drive the cars of a laboratory. Nothing moves before it is armed.

    Keys: a arms, space or any other key is the emergency stop, r resets it, d disarms, q leaves.
    """
    from app.live.operating.lab_choices import laboratory, open_driven

    if dry and link:
        raise InputError(f"--dry and --link {link!r} exclude each other")
    lab = laboratory(file, source, link).lab
    if dry:
        lab = lab.with_values("--dry", link="dry")
    run_laboratory(
        lab, open_driven, arm, record, driving_seconds(lab, seconds, ticks), json_asked, quiet
    )


def driving_seconds(lab: Lab, seconds: float | None, ticks: int | None) -> float:
    """For how long a laboratory is driven, s; 0: until it is left. Raises InputError."""
    demand_one_length(ticks, seconds)
    return ticks / lab.rate if ticks else seconds or 0.0


def run_laboratory(
    lab: Lab,
    opener: Opener,
    arm: bool,
    record: Path | None,
    seconds: float,
    json_asked: bool,
    quiet: bool,
) -> None:
    """Run a laboratory from the terminal. Raises InputError."""
    if record is not None:
        demand_parquet("--record")

    def report(words: str) -> None:
        if not quiet:
            typer.echo(words, err=True)

    report(f"{lab.title or 'laboratory'}: {lab.rule} over {lab.link} ...")
    from app.cli.live.operate import OperatorConsole, format_summary
    from app.cli.terminal.progress import StopSignals
    from app.live.operating.flock_driver import FlockDriver
    from app.live.operating.operator import Operator

    with StopSignals() as stopping:
        FlockDriver(lab, report)  # compiled here, so that the loop need not wait for it
        operator = Operator(lab, opener, record)
        terminal = OperatorConsole(operator, stopping, seconds, arm, json_asked, not quiet)
        try:
            terminal.operate()
        finally:
            operator.close()
    summary = terminal.summary()
    if record is not None:
        summary["recording"] = str(record)
    typer.echo(as_json(summary) if json_asked else format_summary(summary))
