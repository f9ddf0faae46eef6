"""An experiment: a table or a figure of a paper, as sets of runs to make."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from agents.catalogue import model
from agents.spec import Spec
from app.package_files import EXPERIMENTS
from app.strict_table import Value
from app.studies.experiment_file import (
    ExpectedVerdict,
    ExperimentFile,
    PaperRow,
    PaperSweep,
    PhaseClaim,
    PublishedMeasure,
    Said,
)
from app.studies.figures import kinds, pictures
from app.studies.key_lines import place
from app.studies.measure import Measure, Settings
from worlds.input_error import InputError, needed, unknown
from worlds.text_file import toml

Way = Literal["", "there", "back"]


@dataclass(frozen=True)
class Case:
    """Runs that differ by their seed only, and where in the paper they are from."""

    spec: Spec
    """The run, but for its seed and for what its row overrides of the world."""
    agents: int
    """N as the paper counts it."""
    row: PaperRow | None = None
    sweep: PaperSweep | None = None
    way: Way = ""
    """Which way a run that goes there and back is going here."""
    tick: int | None = None
    """The tick at which a run that is measured several times is measured here."""
    last: bool = True
    """Whether it is the last of them, which is compared with what was published."""

    @property
    def label(self) -> str:
        """Its name in a table."""
        of = self.row or self.sweep
        return (of.label if of else "") or self.spec.model

    @property
    def own_sweep(self) -> PaperSweep:
        """The sweep that it is a point of. Raises ValueError for a row of a table."""
        if self.sweep is None:
            raise ValueError(f"{self.label} is no point of a sweep")
        return self.sweep

    @property
    def value(self) -> Value | None:
        """The value of the swept parameter or option."""
        return self.spec.setting(self.sweep.parameter) if self.sweep else None

    @property
    def at(self) -> Value | None:
        """The value of the second parameter of a sweep that has two."""
        two = self.sweep is not None and self.sweep.against
        return self.spec.setting(two) if two else None

    def published(self, measure: str) -> PublishedMeasure | None:
        """What the paper prints of a measure."""
        return self.row.published.get(measure) if self.row and self.last else None


@dataclass(frozen=True)
class Experiment:
    """A table or a figure as cases to run."""

    name: str
    title: str
    source: str
    picture: str
    runs: int
    settings: Settings
    measures: list[Measure]
    """Those to report, the main one first."""
    expected: dict[str, ExpectedVerdict]
    not_compared: dict[str, str]
    notes: dict[str, str]
    cases: list[Case]
    said: list[Said]
    """What the paper claims."""

    @property
    def paths(self) -> list[list[int]]:
        """The cases, by number, that each run goes through.

        One, or those of a sweep there and back, or a row's at all of its ticks.
        """
        found: list[list[int]] = []
        for k, case in enumerate(self.cases):
            last = self.cases[found[-1][-1]] if found else None
            if last is not None and goes_on(last, case):
                found[-1].append(k)
            else:
                found.append([k])
        return found

    def narrowed(self, models: list[str], agents: list[int]) -> Experiment:
        """Only some models (or labels) and sizes; empty lists keep all.

        Raises InputError for unknown ones.
        """
        named = {name for case in self.cases for name in (case.spec.model, case.label)}
        for kind, asked, known in (
            ("model", models, named),
            ("agents", agents, {case.agents for case in self.cases}),
        ):
            for one in asked:
                if one not in known:
                    names = [str(name) for name in sorted(known)]
                    raise unknown(kind, str(one), names, self.name)
        kept = [
            case
            for case in self.cases
            if (not models or case.spec.model in models or case.label in models)
            and (not agents or case.agents in agents)
        ]
        return replace(self, cases=kept)


def goes_on(last: Case, case: Case) -> bool:
    """Whether a case is the next of the same run."""
    if case.tick is not None:
        return last.row is case.row and last.tick is not None and last.tick < case.tick
    same = last.sweep is case.sweep and (last.agents, last.at) == (case.agents, case.at)
    return case.way != "" and same and (last.way, case.way) != ("back", "there")


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
        for n in rows + [n for one in file.sweeps for n in one.agents]:
            if str(n) not in file.sizes:
                raise InputError(f"agents = {n} has no side in [sizes] ({path})")


def check_measures(file: ExperimentFile, path: Path) -> None:
    """Refuse a file that names a measure which its kind of runs does not have."""
    known = [one.name for one in file.settings.measures]
    named: list[Iterable[str]] = [file.report, file.expected, file.not_compared]
    named += [row.published for row in file.rows]
    named.append(claim.measure for claim in file.claims)
    for names in named:
        for name in names:
            if name not in known:
                raise unknown("measure", name, known, str(path))
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
    parameters: dict[str, Value],
    size: float | None = None,
) -> Spec:
    """The run of a row or a sweep, but for its seed. Raises InputError."""
    settings = file.settings
    informed = model(of.model).informed if of.informed is None else of.informed
    return Spec(
        of.model,
        agents=agents - informed if settings.n_counts_informed else agents,
        size=size or file.sizes.get(str(agents)),
        dim=settings.dim,
        world=settings.world,
        parameters=settings.parameters,
        **of.chosen,
    ).taking(**parameters)


def points_of(sweep: PaperSweep) -> list[tuple[dict[str, Value], Value, Way]]:
    """What a sweep sets beside its parameter, the parameter's value, and the way: in order."""
    others = [{sweep.against: value} for value in sweep.against_values] or [{}]
    steps: list[tuple[Value, Way]] = [(value, "") for value in sweep.values]
    if sweep.there_and_back:
        steps = [(value, "there") for value in sweep.values]
        steps += [(value, "back") for value in sweep.values[::-1]]
    return [(sweep.fixed | other, value, way) for other in others for value, way in steps]
