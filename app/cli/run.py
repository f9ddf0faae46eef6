"""`flockscope run`: a flock without a window."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from app.cli.options.run_arguments import (
    STATE,
    GivenOptions,
    compared_model,
    demand_alone,
    demand_policies,
    file_argument,
    is_file,
    option_name,
    read_settings,
    requested_run,
    with_options,
)
from app.cli.options.run_length import Seconds, Ticks, demand_one_length, ticks_asked
from app.cli.terminal.console import INTERRUPTED
from app.cli.terminal.outcome_table import (
    StrayAgentCheck,
    as_json,
    outcome,
    print_stderr,
    print_written_files,
    show,
)
from app.cli.terminal.progress import Progress, run_ticks
from app.cli.terminal.usage import (
    Controllers,
    PrintJson,
    Quiet,
    Rules,
    Settings,
    first_of,
    model_name,
)
from app.settings import check_whole_number, names
from app.steering.controller_pilot import open_controllers
from app.studies.workers.kernels import compile_loop
from worlds.file_writer import demand_distinct_files, demand_writable, write_text
from worlds.input_error import InputError
from worlds.number_text import counted
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    from agents import Flock
    from agents.spec import Spec

DEFAULT_TICKS = 100


@with_options
def run(
    model: Annotated[
        str | None,
        typer.Argument(
            help="A model, see `flockscope list`, or a FILE: a rule (FILE.py), a scene or a spec "
            "(TOML), a saved state or a recording (Parquet).",
            callback=model_name,
        ),
    ] = None,
    rule: Rules = None,
    *,
    options: GivenOptions,
    settings: Settings = None,
    steer: Controllers = None,
    ticks: Ticks = None,
    seconds: Seconds = None,
    threads: Annotated[
        int, typer.Option(help="Threads, used from 10 000 agents on, or 20 000.")
    ] = 1,
    ranks: Annotated[
        int, typer.Option(help="Processes that share each tick, for large flocks; same numbers.")
    ] = 1,
    interpret: Annotated[
        bool,
        typer.Option("--interpret", help="Run the model as plain Python, with print and pdb."),
    ] = False,
    spec: Annotated[
        Path | None, typer.Option(help="A scene or a spec (TOML); options change it.")
    ] = None,
    state: Annotated[
        Path | None, typer.Option(help="Saved state or recording to go on from.")
    ] = None,
    save: Annotated[Path | None, typer.Option(help="Save the last state (Parquet).")] = None,
    save_spec: Annotated[Path | None, typer.Option(help="Write the run's spec (TOML).")] = None,
    record: Annotated[
        Path | None, typer.Option(help="Record frames (Parquet, or CSV by its ending).")
    ] = None,
    every: Annotated[
        int,
        typer.Option(
            help="Ticks between recorded frames. The last tick of the run is recorded too, also "
            "where it is no multiple."
        ),
    ] = 1,
    overwrite: Annotated[
        bool,
        typer.Option("--overwrite", help="Let --save, --save-spec and --record replace a file."),
    ] = False,
    observe: Annotated[
        str | None,
        typer.Option(
            help="Observables with commas, or `all`, see `flockscope list`. \\[default: what the "
            "model and its world ask for]"
        ),
    ] = None,
    over: Annotated[
        int | None,
        typer.Option(
            help="Observe each of the last OVER ticks too: means, and what is measured over a run, "
            "such as susceptibility."
        ),
    ] = None,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Run a flock and print what is observed at its end.

    The same spec and seed give the same numbers. The exit code is 4 if an agent was seen inside an
    obstacle or beyond a solid edge.
    """
    demand_one_length(ticks, seconds)
    check_whole_number("--every", every, 1)
    check_whole_number("--over", over, 1)
    if seconds is None:
        demand_long_enough(over, DEFAULT_TICKS if ticks is None else ticks)
    demand_outputs(save, save_spec, record, overwrite)
    from agents.observables.catalogue import OBSERVABLES
    from agents.recordings.recorder import Recorder
    from agents.run_records import Follower

    observed_names = None if observe is None else known_observables(observe, over)
    if is_file(model):
        spec, state, model = split_spec_and_state(model or "", spec, state)
    model = model if spec or state else first_of(model, rule)
    runs_how = {"threads": threads, "ranks": ranks, "interpret": interpret}
    if state:
        flock = load_flock(
            state, spec, {"model": model, **options}, settings or [], runs_how, quiet
        )
    else:
        flock = build_flock(spec, model, options, settings or [], runs_how, quiet)
    flock.pilots = open_controllers(steer, flock.kinds)
    body = flock.model.body
    length = ticks_asked(ticks, seconds, flock.model.name, body.unit, flock.dt)
    length = DEFAULT_TICKS if length is None else length
    demand_long_enough(over, length)
    if flock.warning and not quiet:
        print_stderr(f"flockscope: {flock.warning}")
    compile_loop(flock, None if quiet else print_stderr)
    if save_spec:
        write_text("--save-spec", save_spec, flock.spec.to_toml(), overwrite)
    observed = default_observables(flock, over) if observed_names is None else observed_names
    follower = Follower(flock, [name for name in observed if not OBSERVABLES[name].is_table])
    lookout = StrayAgentCheck(flock)
    first, started = flock.tick, time.perf_counter()
    with Progress(f"{flock.model.name}, {counted(len(flock.ids), 'agent')}", quiet) as progress:
        recorder = Recorder(record, flock, overwrite) if record else None
        is_complete = run_ticks(
            flock, length, progress, recorder, every, follower.note_values, over or 0, lookout.check
        )
    took = time.perf_counter() - started
    flock.end_run()
    lookout.check()
    if save and flock.has_ended:
        print_stderr(f"flockscope: {save} is not written: a saved state holds one agent at least")
        save = None
    elif save:
        flock.save(save)
    if not is_complete:
        exit_stopped(flock, first + length, record, save, every)
    if flock.tick < first + length and not quiet:
        print_stderr(f"flockscope: the run ends at tick {flock.tick}: everybody has left")
    length = flock.tick - first
    result = outcome(flock, observed, length, took, follower.series if over else None)
    if not quiet:
        print_written_files(record, save, save_spec)
        if record and length % every:
            print_stderr(describe_uneven_end(flock.tick, length, every))
    if lookout.found is not None:
        result["astray"] = str(lookout.found)
    if flock.faults:
        result["faults"] = list(flock.faults)
    if json_asked:
        files = {"recording": record, "state": save, "spec_file": save_spec}
        typer.echo(as_json({**result, **{name: str(path) for name, path in files.items() if path}}))
    else:
        show(result, flock)
    lookout.exit_if_found()


def demand_long_enough(over: int | None, ticks: int) -> None:
    """Raise InputError if there are fewer ticks than are to be observed."""
    if over is not None and over > ticks:
        raise InputError(f"--over {over} is more than --ticks {ticks}, the ticks that are run")


def describe_uneven_end(last: int, ticks: int, every: int) -> str:
    """What is told of a recording whose last frames are closer to each other than the others."""
    return (
        f"flockscope: frames are {counted(every, 'tick')} apart, but the last, of tick {last}, "
        f"{ticks % every}: the end of a run is always recorded"
    )


def split_spec_and_state(
    name: str, spec: Path | None, state: Path | None
) -> tuple[Path | None, Path | None, str | None]:
    """What --spec, --state and MODEL are where a file says which run it is. Raises InputError."""
    demand_alone(name, {"--spec": spec, "--state": state})
    file = file_argument(name)
    return (None, file.path, None) if file.kind == STATE else (file.path, None, None)


def known_observables(text: str, over: int | None) -> list[str]:
    """The observables of a list with commas; `over` as --over has it. Raises InputError."""
    from agents.flock import known_observable
    from agents.observables.catalogue import OBSERVABLES

    if text == "all":
        return [
            observable.name for observable in OBSERVABLES.values() if over or not observable.over
        ]
    observable_names = [known_observable(name) for name in names(text)]
    for name in observable_names:
        if OBSERVABLES[name].over and not over:
            raise InputError(f"--observe {name} is measured over a run: give --over TICKS too")
    return observable_names


def default_observables(flock: Flock, over: int | None) -> list[str]:
    """What is observed where nothing is asked for."""
    from agents.observables.catalogue import OBSERVABLES, telling_observables

    measured = (
        [observable.name for observable in OBSERVABLES.values() if observable.over] if over else []
    )
    return telling_observables(flock) + measured


def build_flock(
    file: Path | None,
    model: str | None,
    options: GivenOptions,
    settings: list[str],
    runs_how: dict[str, Any],
    quiet: bool,
) -> Flock:
    """The flock of a spec and options. Raises InputError."""
    from agents import Flock

    spec, origins = requested_run(model, options, settings, file)
    beside = None if file is None else compared_model(file)
    if beside and not quiet:
        print_stderr(f"flockscope: {beside}, which {file} shows beside it, is not run")
    with origins.naming_origins():
        demand_policies(spec.kinds)
        flock = Flock(spec, **runs_how)
    flock.tell = tell_fault
    if not quiet:
        tell_versions("the spec was written", spec, flock)
    return flock


def tell_fault(line: str) -> None:
    """Tell on stderr what has gone wrong with who flies agents, however quiet it is to be."""
    print_stderr(f"flockscope: {line}")


def tell_versions(what: str, spec: Spec, flock: Flock) -> None:
    """Tell on stderr what a flock's numbers depend on that is not as it was for a spec."""
    from agents.spec import changed_versions

    changed = changed_versions(spec.versions, flock.spec.versions)
    other = [f"{name} {before}, here {now}" for name, before, now in changed]
    if other:
        print_stderr(f"flockscope: {what} with {'; '.join(other)}")


def load_flock(
    state: Path,
    spec: Path | None,
    options: GivenOptions,
    settings: list[str],
    runs_how: dict[str, Any],
    quiet: bool,
) -> Flock:
    """The flock of a saved state, with `--set` changing its parameters. Raises InputError."""
    from agents import Flock

    for name, value in {**options, "spec": spec}.items():
        if value is not None:
            raise InputError(
                f"{option_name(name)} {value} cannot be given with {state}, which says it already"
            )
    parameters, origins = read_settings(settings)
    flock = Flock.load(state, **runs_how)
    if not quiet:
        tell_versions("the state was saved", flock.options, flock)
    with origins.naming_origins():
        flock.set(**parameters)
        demand_policies(flock.kinds.kinds)
    flock.tell = tell_fault
    return flock


def demand_outputs(
    save: Path | None, save_spec: Path | None, record: Path | None, overwrite: bool
) -> None:
    """Refuse what cannot be written before anything is run. Raises InputError."""
    from agents.recordings.recorder import RECORDINGS, STATES

    demand_distinct_files({"--record": record, "--save": save, "--save-spec": save_spec})
    for option, path in (("--record", record), ("--save", save)):
        if path is not None:
            demand_parquet(option)
    for option, path, endings in (
        ("--record", record, RECORDINGS),
        ("--save", save, STATES),
        ("--save-spec", save_spec, (".toml",)),
    ):
        if path is not None:
            demand_writable(option, path, overwrite, endings)


def exit_stopped(
    flock: Flock, last: int, record: Path | None, save: Path | None, every: int
) -> NoReturn:
    """Tell how to go on from a run that was asked to stop."""
    from agents.recordings.recorder import SHEET

    line = f"flockscope: stopped at tick {flock.tick} of {last}; "
    files = [str(path) for path in (record, save) if path]
    if files:
        line += f"written: {', '.join(files)}; "
    again = ["flockscope", "run", "--ticks", str(last - flock.tick)]
    again += ["--threads", str(flock.threads)] if flock.threads > 1 else []
    again += ["--ranks", str(flock.ranks)] if flock.ranks > 1 else []
    if record and record.suffix.lower() != SHEET:
        again += ["--every", str(every)] if every > 1 else []
        part = record.with_name(f"{record.stem}-from-{flock.tick}{record.suffix}")
        line += f"go on with: {shlex.join([*again, '--state', str(record), '--record', str(part)])}"
    elif save:
        line += f"go on with: {shlex.join([*again, '--state', str(save)])}"
    elif record:
        line += "no run goes on from a CSV (--save FILE keeps the state)"
    else:
        line += "nothing was kept (--save FILE keeps the state)"
    print_stderr(line)
    raise typer.Exit(INTERRUPTED)
