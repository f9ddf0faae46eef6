"""Reading the experiments of papers: from this package, or a TOML file of one's own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from agents.catalogue import model
from agents.spec import Spec
from app.package_files import EXPERIMENTS
from app.strict_table import ParameterValue, Value
from app.studies.experiment import Case, Experiment, Way
from app.studies.experiment_file import (
    ExperimentFile,
    PaperRow,
    PaperSweep,
    PhaseClaim,
)
from app.studies.figures import kinds, pictures
from app.studies.key_lines import place
from app.studies.run_axes import spec_with
from worlds.input_error import InputError, needed, unknown
from worlds.text_file import toml


def experiment_names() -> list[str]:
    """Names of all experiments."""
    return sorted(path.stem for path in EXPERIMENTS.glob("*.toml"))


def read_experiment(name: str) -> Experiment:
    """The experiment of that name. Raises InputError."""
    if name not in experiment_names():
        raise unknown("paper", name, experiment_names())
    return read_file(EXPERIMENTS / f"{name}.toml")


def find_experiment(name: str) -> Experiment:
    """The experiment of that name, or of a file of one's own that ends in .toml. Raises
    InputError."""
    return read_file(Path(name)) if name.lower().endswith(".toml") else read_experiment(name)


def read_file(path: Path) -> Experiment:
    """The experiment of a TOML file. Raises InputError naming file and line."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not TOML: {error}") from None
    values = toml(text, str(path))
    kind = values.get("kind", "convergence")
    if kind not in kinds():
        raise unknown("kind of experiment", str(kind), kinds(), place(path, text, "kind"))
    try:
        of_kind: Any = ExperimentFile.__class_getitem__(kinds()[kind])
        file: ExperimentFile = of_kind(**values)
    except ValidationError as error:
        first = error.errors()[0]
        keys = [str(part) for part in first["loc"] if not isinstance(part, int)]
        where = place(path, text, keys[-1], ".".join(keys[:-1]))
        raise InputError(f"{'.'.join(keys)}: {needed(first)} ({where})") from None
    if file.picture not in pictures():
        raise unknown("picture", file.picture, pictures(), place(path, text, "picture"))
    check_sizes(file, path)
    check_measures(file, path)
    try:
        cases = cases_of(file)
    except InputError as refusal:
        raise InputError(f"{refusal} ({path})") from None
    main = file.settings.measures[0].name
    return Experiment(
        path.stem,
        file.title,
        file.source,
        file.picture,
        file.runs,
        file.settings,
        [file.settings.measure(name) for name in file.report or [main]],
        file.expected,
        file.not_compared,
        file.notes,
        cases,
        list(file.claims),
    )


def check_sizes(file: ExperimentFile, path: Path) -> None:
    """Refuse a file that gives sizes, but not for all rows."""
    if file.sizes or file.settings.kind == "convergence":
        rows = [row.agents for row in file.rows if row.size is None]
        for n in rows + [n for sweep in file.sweeps for n in sweep.agents]:
            if str(n) not in file.sizes:
                raise InputError(f"agents = {n} has no side in [sizes] ({path})")


def check_measures(file: ExperimentFile, path: Path) -> None:
    """Refuse a file that names a measure which its kind of runs does not have."""
    measure_names = [measure.name for measure in file.settings.measures]
    named: list[Iterable[str]] = [file.report, file.expected, file.not_compared]
    named += [row.published for row in file.rows]
    named.append(claim.measure for claim in file.claims)
    for names in named:
        for name in names:
            if name not in measure_names:
                raise unknown("measure", name, measure_names, str(path))
    for claim in file.claims:
        if isinstance(claim, PhaseClaim):
            words = file.settings.measure(claim.measure).words
            if claim.word not in words:
                raise unknown(claim.measure, claim.word, words, str(path))


def cases_of(file: ExperimentFile) -> list[Case]:
    """The rows and the sweeps' points, in the order of the file."""
    stops = file.settings.stops or [None]
    cases = [
        Case(
            spec_of(file, row, row.agents, row.parameters, row.size),
            row.agents,
            row,
            tick=tick,
            last=tick == stops[-1],
        )
        for row in file.rows
        for tick in stops
    ]
    for sweep in file.sweeps:
        for n in sweep.agents:
            for fixed, value, way in points_of(sweep):
                spec = spec_of(file, sweep, n, fixed | {sweep.parameter: value})
                cases.append(Case(spec, n, sweep=sweep, way=way))
    return cases


def spec_of(
    file: ExperimentFile,
    of: PaperRow | PaperSweep,
    agents: int,
    parameters: Mapping[str, ParameterValue],
    size: float | None = None,
) -> Spec:
    """The run of a row or a sweep, but for its seed. Raises InputError."""
    settings = file.settings
    informed = model(of.model).informed if of.informed is None else of.informed
    others = informed + sum(kind.agents for kind in of.kinds)
    if settings.n_counts_informed and others >= agents:
        raise InputError(
            f"agents = {agents}, but {others} of them are information agents or of a kind: N "
            "counts all, and one ordinary agent is needed"
        )
    base = Spec(
        of.model,
        agents=agents - others if settings.n_counts_informed else agents,
        size=size or file.sizes.get(str(agents)),
        dim=settings.dim,
        world=settings.world,
        parameters=settings.parameters,
        **of.chosen,
    )
    return spec_with(base.but(kinds=of.kinds, to=of.to), parameters)


def points_of(sweep: PaperSweep) -> list[tuple[dict[str, ParameterValue], Value, Way]]:
    """What a sweep sets beside its parameter, the parameter's value, and the way: in order."""
    others: list[dict[str, ParameterValue]]
    others = [{sweep.against: value} for value in sweep.against_values] or [{}]
    steps: list[tuple[Value, Way]] = [(value, "") for value in sweep.values]
    if sweep.there_and_back:
        steps = [(value, "there") for value in sweep.values]
        steps += [(value, "back") for value in sweep.values[::-1]]
    return [(sweep.fixed | other, value, way) for other in others for value, way in steps]
