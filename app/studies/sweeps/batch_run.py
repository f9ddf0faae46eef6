"""`mesa.batch_run` for flocks: the same call and the same rows, made as the runs of a sweep are."""

from __future__ import annotations

import itertools
import secrets
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from agents.catalogue import is_built_in
from agents.flock import Flock, seed_from
from agents.flock_world import LARGEST_DRAWN
from agents.individuals import Distribution
from agents.kinds import as_kinds
from agents.observables.catalogue import BUILT_IN
from agents.option import whole_number
from agents.spec import DEFAULT, Spec
from app.studies.runs.database import Outcome
from app.studies.workers.flock_pool import FlockPool, run_ticks
from app.studies.workers.kernels import compile_loop
from app.studies.workers.process_executor import ProcessExecutor, cores
from app.studies.workers.run_executors import RunExecutor, Task
from app.studies.workers.thread_executor import ThreadExecutor
from worlds.input_error import InputError, shorten

NOT_TAKEN = ("model_reporters", "agent_reporters", "start")
"""What `Flock` takes and no batch: functions are called at every step, and arrays are no values."""
type Words = Mapping[str, Any]


@dataclass
class BatchJob:
    """How the runs of a batch are made; one is asked for by the words of its flock."""

    model: str | Spec | None
    max_steps: int
    period: int
    flocks: FlockPool = field(default_factory=FlockPool)

    def prepare(self) -> None:
        """There is nothing to prepare."""

    def new_flock(self, words: Words, seed: Any) -> Flock:
        """A flock at tick 0. Raises InputError."""
        own: dict[str, Any] = {} if self.model is None else {"model": self.model}
        return Flock(**own, **words, rng=seed)

    def run(self, words: Words, seed: Any) -> Outcome:
        """Make a run; `rest` has an outcome for each step that is collected."""
        with self.flocks.begin(words, seed, lambda: self.new_flock(words, seed)) as flock:
            return Outcome("ok", rest=tuple(self.collect(flock)))

    def collect(self, flock: Flock) -> Iterator[Outcome]:
        """What is collected of a run, step by step."""
        steps = range(1, self.max_steps + 1)
        for step in steps[:: self.period] if self.period > 0 else steps[-1:]:
            run_ticks(flock, step - flock.tick)
            names = flock.datacollector.model_reporters
            yield Outcome("ok", {name: flock.observe(name) for name in names}, ticks=step)

    def is_own_code(self, words: Words) -> bool:
        """Whether a run calls code that is not flockscope's. Raises InputError."""
        model = words.get("model", self.model) or DEFAULT
        names = [*model.models] if isinstance(model, Spec) else [str(model)]
        names += [one.model for one in as_kinds(words.get("kinds", ())) if one.model]
        return not (
            all(map(is_built_in, names)) and BUILT_IN.keys() >= set(words.get("collect", ()))
        )


def batch_run(
    model_cls: str | Spec | type[Flock],
    parameters: Mapping[str, Any],
    number_processes: int | None = None,
    iterations: int | None = None,
    data_collection_period: int = -1,
    max_steps: int = 1000,
    display_progress: bool = True,
    rng: Any = None,
) -> list[dict[str, Any]]:
    """Make runs of flocks over all values of their parameters, as `mesa.batch_run` does.

    Each run has the numbers of the flock made alone, to the bit. Unlike Mesa's it collects only
    what it returns, uses all cores unless told otherwise, and returns rows in the order of `RunId`.

    Parameters
    ----------
    model_cls: `Flock`, or the name of a model, or a `Spec`.
    parameters: words of `Flock` by name, `collect` among them; each is a value or an iterable of
        values, and every value is run with every value of the others. Where agents are to differ,
        a value is a distribution, as in `"s": [normal(3, 0.1), normal(3, 0.5)]`: rows have its
        text. A list is always one of values: the numbers of each agent are `[each([...])]`.
    number_processes: runs made at a time, 1 or more; None: as many as there are cores. They are
        made on threads of this process, and in processes where so many runs are worth these.
    rng: a seed, or an iterable of seeds, for each combination; None draws one, which is then in the
        column `seed`. `iterations` instead: so many runs with drawn seeds.
    data_collection_period: -1 for the last step only, or k >= 1 for steps 1, 1 + k, 1 + 2 k, ...
    max_steps: ticks of a run.
    display_progress: whether to show a bar on stderr.

    Returns a dictionary for each step that is collected: `RunId`, `iteration`, `Step`, the
    parameters, `rng`, and each observable of `collect`, by default the polarisation.

    Raises InputError for what cannot be run; the first run that raises ends the batch.

    >>> from flockscope import batch_run
    >>> rows = batch_run("vem", {"agents": 30, "eta": [0.0, 6.0]}, rng=[1, 2], max_steps=50,
    ...     display_progress=False)
    >>> [(row["RunId"], row["eta"], row["rng"], row["Step"]) for row in rows[:2]]
    [(0, 0.0, 1, 50), (1, 6.0, 1, 50)]
    """
    if iterations is not None and rng is not None:
        raise InputError("iterations and rng both say how many runs there are: give one")
    if not isinstance(model_cls, str | Spec) and not runs_as_flock(model_cls):
        raise InputError(
            f"model_cls = {shorten(model_cls)} is not allowed: Flock, a Spec or the name of a "
            "model is needed; mesa.batch_run takes any Mesa model"
        )
    for name in NOT_TAKEN:
        if name in parameters:
            raise InputError(
                f"{name} is not taken by flockscope.batch_run: give collect = [[...]] with "
                "observables, or call mesa.batch_run"
            )
    job = BatchJob(
        model_cls if isinstance(model_cls, str | Spec) else None,
        whole_number("max_steps", max_steps, 0),
        data_collection_period
        if data_collection_period == -1
        else whole_number("data_collection_period", data_collection_period, 1),
    )
    workers = cores()
    if number_processes is not None:
        workers = whole_number("number_processes", number_processes, 1)
    if iterations is not None:
        rng = [None] * whole_number("iterations", iterations, 1)
    combinations = list(combine(parameters))
    generators = list(rng) if isinstance(rng, Iterable) else [rng]
    runs = [
        (iteration, words, generator)
        for iteration, generator in enumerate(generators)
        for words in combinations
    ]
    tasks = [
        Task(number, draw_seed(words, generator), words)
        for number, (_, words, generator) in enumerate(runs)
    ]
    outcomes = make_runs(job, tasks, workers, display_progress)
    rows: list[dict[str, Any]] = []
    for task, (iteration, words, generator) in zip(tasks, runs, strict=True):
        shared = {name: row_value(value) for name, value in words.items()} | {"rng": generator}
        drawn = {"seed": task.seed} if generator is None and "seed" not in words else {}
        rows += [
            {"RunId": task.cell, "iteration": iteration, "Step": step.ticks}
            | {**shared, **step.values, **drawn}
            for step in outcomes[task.cell].rest
        ]
    return rows


def runs_as_flock(model_cls: Any) -> bool:
    """Whether it is `Flock`, or a subclass whose runs are the same."""
    is_flock = isinstance(model_cls, type) and issubclass(model_cls, Flock)
    steps = ("__init__", "step", "run", "advance", "observe")
    return is_flock and all(getattr(model_cls, name) is getattr(Flock, name) for name in steps)


def combine(parameters: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Every value of each parameter with every value of the others, as Mesa takes them apart.

    Raises InputError for a parameter without values.
    """
    axes: list[list[tuple[str, Any]]] = []
    for name, values in parameters.items():
        choices = [values]
        if not isinstance(values, str):
            with suppress(TypeError):
                choices = list(values)
        if not choices:
            raise InputError(f"{name} has no values: give one at least")
        axes.append([(name, value) for value in choices])
    return map(dict, itertools.product(*axes))


def row_value(value: Any) -> Any:
    """A value of a parameter as rows have it: a distribution as text."""
    return str(value) if isinstance(value, Distribution) else value


def draw_seed(words: Words, generator: Any) -> Any:
    """The seed of a run, which is drawn where none is given."""
    if generator is None:
        return words.get("seed", secrets.randbelow(LARGEST_DRAWN))
    return seed_from(generator)


def make_runs(
    job: BatchJob, tasks: Sequence[Task], workers: int, display_progress: bool
) -> dict[int, Outcome]:
    """How each run ended, by its number. Raises InputError for the first that failed."""
    from tqdm.auto import tqdm  # type: ignore[import-untyped]  # 0.1 s, for who makes a batch

    outcomes: dict[int, Outcome] = {}
    if not tasks:
        return outcomes
    compile_loop(job.new_flock(tasks[0].payload, tasks[0].seed), None)

    def begin_processes() -> ProcessExecutor:
        return ProcessExecutor(job, workers)

    executor: RunExecutor = ThreadExecutor(job, workers, begin_processes)
    if any(map(job.is_own_code, {id(task.payload): task.payload for task in tasks}.values())):
        executor = begin_processes()
    with tqdm(total=len(tasks), disable=not display_progress) as bar, executor:

        def keep(task: Task, outcome: Outcome) -> None:
            if outcome.status != "ok":
                reason = outcome.reason.removeprefix("InputError: ")
                raise InputError(f"{reason} (RunId {task.cell})")
            outcomes[task.cell] = outcome
            bar.update()

        executor.run(tasks, keep, lambda: False)
    return outcomes
