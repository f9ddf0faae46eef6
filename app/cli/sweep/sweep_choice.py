"""Which sweep is meant: a file, options for the common case, or a folder that was run before."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.options.run_arguments import OF_KINDS, read_kinds
from app.cli.options.run_length import demand_one_length, ticks_asked
from app.results_folder import RESULTS
from app.settings import assignment, check_whole_number, names, numbers, value
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.studies.key_lines import KeyLocations
    from app.studies.sweeps.checked_sweep import Sweep

SPAN = re.compile(r"([^:]+):([^:]+)(?::([^:]+))?(?::(log|linear))?")
Vary = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        help="An axis, NAME=FROM:TO:COUNT, NAME=FROM:TO:COUNT:log or NAME=A,B,C; NAME.mean and "
        "NAME.spread where agents differ in NAME; KIND.agents, KIND.NAME and "
        "KIND.OTHER.weight of kinds; may be repeated.",
    ),
]
Kinds = Annotated[list[str] | None, typer.Option("--kind", help=f"{OF_KINDS['kind']}.")]
Relations = Annotated[list[str] | None, typer.Option("--relation", help=f"{OF_KINDS['relation']}.")]
Fixed = Annotated[
    list[str] | None,
    typer.Option("--set", help="A parameter or option of all runs, NAME=VALUE; may be repeated."),
]
Runs = Annotated[int | None, typer.Option(help="Runs of each cell. \\[default: 10]")]
Ticks = Annotated[int | None, typer.Option(help="Ticks of a run. \\[default: 1000]")]
Seconds = Annotated[
    float | None,
    typer.Option(
        "--seconds", help="Instead of --ticks: time of a run, of a model that counts seconds."
    ),
]
Observes = Annotated[str, typer.Option("--observe", help="Observables with commas.")]
Over = Annotated[int | None, typer.Option(help="Take means over the last OVER ticks of each run.")]
Until = Annotated[
    str, typer.Option("--until", help="End a run where this holds: 'consistency >= 0.9984'.")
]
Hold = Annotated[int, typer.Option(help="Ticks for which --until has to hold.")]
Name = Annotated[str, typer.Argument(help="A sweep in results/, or its folder.")]


@dataclass(frozen=True)
class SweepOptions:
    """What `sweep run` and `sweep check` are given of a sweep that no file says."""

    vary: Vary = None
    fixed: Fixed = None
    kinds: Kinds = None
    relations: Relations = None
    runs: Runs = None
    ticks: Ticks = None
    seconds: Seconds = None
    observe: Observes = ""
    over: Over = None
    until: Until = ""
    hold: Hold = 1

    def read(self, what: str, tell: Any) -> tuple[Sweep, Path]:
        """The sweep and its folder, where no other is asked for. Raises InputError."""
        from app.studies.key_lines import KeyLocations
        from app.studies.sweeps.checked_sweep import sweep_of

        check_whole_number("--runs", self.runs, 1)
        check_whole_number("--over", self.over, 1)
        check_whole_number("--hold", self.hold, 1)
        options = {
            "--vary": self.vary, "--set": self.fixed, "--runs": self.runs, "--ticks": self.ticks,
            "--observe": self.observe, "--over": self.over, "--until": self.until,
            "--seconds": self.seconds, "--kind": self.kinds, "--relation": self.relations,
        }  # fmt: skip
        if is_complete_sweep(what):
            for name, option_value in options.items():
                if option_value:
                    raise InputError(f"{name} cannot be given with {what}, which says it already")
            return read_complete_sweep(what, tell)
        if not self.vary:
            raise InputError(
                f"{what!r} is no FILE.toml and no folder of a sweep; for a model give --vary "
                "NAME=FROM:TO:COUNT"
            )
        demand_one_length(self.ticks, self.seconds, least=1)
        values, places = self.table(what)
        keys = KeyLocations("the command line", options=places)
        sweep = sweep_of(values, keys, Path(), tell)
        return sweep, RESULTS / "-".join([Path(what).stem, *sweep.axes])

    def table(self, model: str) -> tuple[dict[str, Any], dict[str, str]]:
        """What a file would say, and which option each key is from. Raises InputError."""
        from app.studies.sweeps.sweep_file import RunOptions

        ticks = self.ticks
        if self.seconds is not None:
            ticks = ticks_of(model, self.vary or [], self.fixed or [], self.seconds)
        run: dict[str, Any] = {"model": model, "ticks": 1000 if ticks is None else ticks}
        places = {"model": "MODEL", "ticks": "--ticks", "count": "--runs", "when": "--until"}
        for setting in self.fixed or []:
            name, given_value = assignment(setting)
            places[name] = f"--set {setting}"
            if name in RunOptions.model_fields:
                run[name] = given_value
            else:
                run.setdefault("parameters", {})[name] = given_value
        table = read_kinds(self.kinds or [], self.relations or [])
        if table.kinds:
            places |= {"kinds": "--kind", "kind": "--kind", "to": "--relation"}
            run["kinds"] = [kind.to_value() for kind in table.kinds]
            run["to"] = {other: relation.to_value() for other, relation in table.to.items()}
        axes: dict[str, Any] = {}
        for setting in self.vary or []:
            name, axis = axis_of(setting)
            places[name] = f"--vary {setting}"
            axes[name] = axis
        values: dict[str, Any] = {"run": run, "design": [{"kind": "grid", "axes": axes}]}
        if self.runs is not None:
            values["replicates"] = {"count": self.runs}
        if self.until:
            values["stop"] = {"when": self.until, "hold": self.hold}
        observed = names(self.observe)
        places |= {"observe": "--observe", "over": "--over"}
        if observed:
            values["observe"] = [
                {"name": name} if self.over is None else {"name": name, "over": self.over}
                for name in observed
            ]
        elif self.over is not None:
            raise InputError("--over needs --observe: of what is the mean to be taken?")
        return values, places


def ticks_of(model: str, vary: list[str], fixed: list[str], seconds: float) -> int | None:
    """The ticks that so many seconds are in every run. Raises InputError."""
    from agents.catalogue import model as find_model
    from agents.individuals import split_individuals
    from agents.models.declare import checked

    varied = {setting.partition("=")[0].strip() for setting in vary}
    for name in ("dt", "model"):
        if name in varied:
            raise InputError(
                f"--seconds {seconds:g} is not the same ticks in every run with --vary {name}: "
                "give --ticks"
            )
    found_model = find_model(model)
    given_values, _ = split_individuals(dict(assignment(setting) for setting in fixed), "--set")
    own = {
        name: value
        for name, value in given_values.items()
        if name in found_model.parameters.model_fields
    }
    dt = float(found_model.body.lasts(checked(found_model.parameters, own, "--set")))
    return ticks_asked(None, seconds, found_model.name, found_model.body.unit, dt)


def is_complete_sweep(what: str) -> bool:
    """Whether this is a file, or the folder of a sweep that was run before."""
    return Path(what).suffix.lower() == ".toml" or is_sweep(folder_of(what))


def read_complete_sweep(what: str, tell: Any) -> tuple[Sweep, Path]:
    """The sweep of a file or of a folder, and its folder. Raises InputError."""
    from app.studies.sweeps.checked_sweep import read_sweep

    if not is_complete_sweep(what):
        raise InputError(f"{what!r} is no FILE.toml and no folder of a sweep")
    if Path(what).suffix.lower() == ".toml":
        return read_sweep(Path(what), tell), RESULTS / Path(what).stem
    return read_stored_sweep(folder_of(what), tell), folder_of(what)


def read_stored_sweep(folder: Path, tell: Any) -> Sweep:
    """The sweep of a folder that was run before. Raises InputError."""
    from app.studies.sweeps.checked_sweep import sweep_of

    return sweep_of(*read_sweep_folder(folder), tell)


def read_sweep_folder(folder: Path) -> tuple[dict[str, Any], KeyLocations, Path]:
    """What the file in a folder says, where its keys are, where it was begun. Raises InputError."""
    from app.studies.key_lines import KeyLocations
    from app.studies.runs.store_reader import StoreReader
    from app.studies.study_runner import SPEC
    from worlds.text_file import read_text, toml

    path = folder / SPEC
    text = read_text(f"sweep {str(path)!r}", path)
    origin = Path(StoreReader(folder).state.get("from_folder", folder))
    return toml(text, str(path)), KeyLocations(str(path), text), origin


def axis_of(setting: str) -> tuple[str, Any]:
    """Name and values of `--vary`. Raises InputError.

    >>> axis_of("eta=0:6:4"), axis_of("agents=50,100")
    (('eta', {'from': 0.0, 'to': 6.0, 'count': 4}), ('agents', [50, 100]))
    """
    name, equals, text = (part.strip() for part in setting.partition("="))
    if not equals or not name or not text:
        raise InputError(f"--vary {setting} is not of the form NAME=FROM:TO:COUNT or NAME=A,B,C")
    if ":" not in text:
        return name, [value(part) for part in names(text)]
    match = SPAN.fullmatch(text)
    try:
        if match and match[3] is not None:
            low, high = (numbers("--vary", match[k])[0] for k in (1, 2))
            axis: dict[str, Any] = {"from": low, "to": high, "count": int(match[3])}
            return name, axis | ({"scale": match[4]} if match[4] else {})
    except ValueError:
        pass
    raise InputError(f"--vary {setting} is not of the form NAME=FROM:TO:COUNT, with :log if wanted")


def folder_of(name: str) -> Path:
    """The folder of a sweep by its path, or by its name in `results`."""
    return Path(name) if Path(name).is_dir() else RESULTS / name


def is_sweep(folder: Path) -> bool:
    """Whether a folder has a store of runs."""
    from app.studies.runs.database import FILE

    return (folder / FILE).is_file()


def find_sweep_folder(name: str) -> Path:
    """The folder of a sweep that was run, by name or path. Raises InputError."""
    path = Path(name)
    if path.suffix.lower() == ".toml" and not path.is_dir():
        name = path.stem
    folder = folder_of(name)
    if not is_sweep(folder):
        raise InputError(f"there is no sweep {name!r}: `flockscope sweep list` names what there is")
    return folder
