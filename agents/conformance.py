"""Check what every model has to pass, built in or not, with few agents and few ticks.

Each check states a fact about a model in its own world or in empty space. It returns None, raises
`InapplicableCheck` for a model to which it does not apply, or `ConformanceFailure` with what was
seen instead.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from agents.flock import Flock
from agents.kinds import Kind
from agents.models.declare import NumberParameter, declared
from agents.models.model import Model
from agents.models.model_calls import ModelCodeError
from agents.models.slider_range import demand_proposed
from agents.models.tries import LessonStep
from agents.observables.catalogue import OBSERVABLES
from agents.spec import OPTIONS
from worlds.input_error import InputError
from worlds.obstacles import Disc
from worlds.plug_ins import demand_parquet
from worlds.world import World

AGENTS, TICKS = 12, 5
ROUNDING = 1e-9
"""How far numbers may be apart that differ by the order of sums only."""
ANGLE = 2.1
"""By how much a flock is turned, rad: no part of a full turn."""
SEEDS = (1, 2, 3)
"""The starts from which what there is to try is tried."""
FAR = 400.0
"""Where the one obstacle of an empty world stands, for models whose loop is that of solid worlds,
in lengths of their reach."""


class InapplicableCheck(Exception):
    """The check does not apply to this model."""


class ConformanceFailure(Exception):
    """The model does not pass the check."""


def demand(holds: Any, finding: str) -> None:
    """Raise Failed with what was seen, unless it holds."""
    if not holds:
        raise ConformanceFailure(finding)


@dataclass(frozen=True)
class ConformanceResult:
    """The result of one check."""

    check: str
    fact: str
    result: Literal["holds", "fails", "does not apply"]
    reason: str = ""


def known_kinds(model: Model) -> list[Kind]:
    """Some agents of each kind that a model's rule knows, a third of a crowd."""
    known = model.rule.kinds
    return [Kind(name, max(1, AGENTS // 3 // len(known))) for name in known]


def flock_at_home(model: Model, **options: Any) -> Flock:
    """A small flock of a model in the model's own world; with some of each kind that its rule
    knows, if it is of more than one."""
    kinds = known_kinds(model) if options.get("agents") != 1 else []
    return Flock(model.name, kinds=kinds, **{"agents": AGENTS, "rng": 7, **options})


def empty_space(model: Model, dim: int | None = None) -> World:
    """A world with nothing in sight; with a solid far away if the model's own world has solids.

    The loop for worlds with something solid in them is another one than that for worlds without.
    """
    home = flock_at_home(model, agents=1)
    reach = max(home.reach, home.sight)
    side = (40.0 * reach,) * (dim or home.world.dim)
    disc = Disc(centre=(FAR * reach, FAR * reach), radius=0.5 * reach)
    return World(
        "empty space", side, ("open",) * len(side), obstacles=(disc,) if home.world.is_solid else ()
    )


def crowd(model: Model, dim: int | None = None, agents: int = AGENTS) -> dict[str, np.ndarray]:
    """A start in empty space, with every agent near others and no two of them touching."""
    home = flock_at_home(model, agents=1)
    spacing = max(home.reach / 4.0, model.spacing or 0.0, 1.5 * size_of(home))
    rng = np.random.default_rng(11)
    dim = dim or home.world.dim
    side = int(np.ceil(agents ** (1.0 / dim)))
    places = np.stack(np.meshgrid(*[np.arange(side)] * dim), -1).reshape(-1, dim)[:agents]
    position = 3.0 * home.reach + spacing * (places + rng.uniform(-0.15, 0.15, places.shape))
    heading = rng.normal(size=position.shape)
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    informed = np.arange(agents) < model.informed
    return {"position": position, "heading": heading, "informed": informed}


def size_of(flock: Flock) -> float:
    """The diameter of a flock's bodies, length; 0 for points."""
    name = flock.model.body.size
    return float(getattr(flock.parameters, name)) if name else 0.0


def noiseless_settings(model: Model) -> dict[str, float]:
    """Settings without noise."""
    return {
        declaration.name: 0.0 for declaration in declared(model.parameters) if declaration.noise
    }


def flock_in_empty_space(
    model: Model, start: dict[str, np.ndarray] | None = None, **options: Any
) -> Flock:
    """A flock in empty space, by default the crowd, of all kinds that the model's rule knows."""
    start = crowd(model) if start is None else start
    options = {"rng": 7, "kinds": known_kinds(model), **options}
    return Flock(model.name, start=start, world=empty_space(model), **options)


def demand_same(flock: Flock, other: Flock, finding: str) -> None:
    """Raise Failed unless two flocks are the same to the bit."""
    for name in ("position", "heading", "speed"):
        demand(
            np.array_equal(getattr(flock, name), getattr(other, name)), f"{finding}: another {name}"
        )
    same_signals = np.array_equal(flock.signals(), other.signals(), equal_nan=True)
    demand(same_signals, f"{finding}: other signals")


def demand_sound(flock: Flock, finding: str) -> None:
    """Raise Failed unless positions are finite, headings unit vectors and speeds >= 0."""
    for name in ("position", "heading", "speed"):
        demand(np.isfinite(getattr(flock, name)).all(), f"{finding}: a {name} that is no number")
    length = np.linalg.norm(flock.heading, axis=1)
    demand(
        np.allclose(length, 1.0, atol=1e-6),
        f"{finding}: a heading of length {furthest_value(length, 1.0)}",
    )


def furthest_value(values: np.ndarray, target: float) -> float:
    """The value that is furthest from the wanted one."""
    return float(values[np.argmax(np.abs(values - target))]) if len(values) else target


def threads(model: Model) -> None:
    """One thread and two give the same bits."""
    single, double = flock_in_empty_space(model), flock_in_empty_space(model, threads=2)
    double.split_from = 1
    for flock in (single, double):
        flock.run(TICKS)
    demand_same(single, double, "two threads")


def order(model: Model) -> None:
    """All at once, it makes no difference in which order agents act."""
    together, single = flock_in_empty_space(model), flock_in_empty_space(model)
    for _ in range(2):
        together.run(1)
        for row in np.random.default_rng(3).permutation(AGENTS):
            single.step_member(int(row))
    demand_same(together, single, "another order")


def saved(model: Model) -> None:
    """A run that is saved and loaded goes on to the bit."""
    try:
        demand_parquet("a state")
    except InputError as missing:
        raise InapplicableCheck(str(missing)) from None
    flock = flock_at_home(model)
    flock.run(TICKS)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "state.parquet"
        flock.save(path)
        loaded = Flock.load(path)
    for continued in (flock, loaded):
        continued.run(TICKS)
    demand_same(flock, loaded, "the saved run")


def plain(model: Model) -> None:
    """Run as plain Python it gives the same numbers up to rounding."""
    compiled, python = flock_in_empty_space(model), flock_in_empty_space(model, interpret=True)
    for flock in (compiled, python):
        flock.run(2)
    demand_close(python, compiled.position, compiled.heading, "plain Python")


def demand_close(flock: Flock, position: np.ndarray, heading: np.ndarray, finding: str) -> None:
    """Raise Failed unless a flock is where it should be, up to rounding."""
    scale = max(1.0, float(np.abs(position).max()))
    off = float(np.abs(flock.position - position).max()) / scale
    demand(off < ROUNDING, f"{finding}: positions {off:.2g} apart")
    off = float(np.abs(flock.heading - heading).max())
    demand(off < ROUNDING, f"{finding}: headings {off:.2g} apart")


def demand_symmetry(
    model: Model, name: str, move_places: Callable, turn_headings: Callable
) -> None:
    """Raise Failed unless agents that start elsewhere move alike, up to rounding."""
    if name not in model.symmetries:
        raise InapplicableCheck(f"{model.name} declares that a {name} makes a difference")
    start = crowd(model)
    moved_start = {
        **start,
        "position": move_places(start["position"]),
        "heading": turn_headings(start["heading"]),
    }
    original, other = (
        flock_in_empty_space(model, places, **noiseless_settings(model))
        for places in (start, moved_start)
    )
    for flock in (original, other):
        flock.run(TICKS)
    demand_close(other, move_places(original.position), turn_headings(original.heading), name)


def shift(model: Model) -> None:
    """Shifted in empty space, agents do the same."""
    demand_symmetry(model, "shift", lambda x: x + 0.7, lambda u: u)


def rotation(model: Model) -> None:
    """Turned about the vertical, agents do the same, turned."""
    c, s = np.cos(ANGLE), np.sin(ANGLE)

    def turn_vectors(x: np.ndarray) -> np.ndarray:
        return np.column_stack([c * x[:, 0] - s * x[:, 1], s * x[:, 0] + c * x[:, 1], *x[:, 2:].T])

    demand_symmetry(model, "rotation", turn_vectors, turn_vectors)


def mirror(model: Model) -> None:
    """Mirrored, agents do the same, mirrored."""

    def mirror_vectors(x: np.ndarray) -> np.ndarray:
        return x * ([1.0, -1.0] if x.shape[1] == 2 else [1.0, -1.0, 1.0])

    demand_symmetry(model, "mirror", mirror_vectors, mirror_vectors)


def inside(model: Model) -> None:
    """In the model's own world, agents stay in the box and out of what is solid."""
    flock = flock_at_home(model)
    for _ in range(4):
        flock.run(TICKS)
        demand_sound(flock, "at home")
        demand(flock.stray() is None, str(flock.stray()))
    for axis in np.flatnonzero(flock.world.wraps):
        x = flock.position[:, axis]
        demand((x >= 0.0).all() and (x < flock.world.size[axis]).all(), "out of the box")


def alone(model: Model) -> None:
    """A flock of one agent runs, and so does one that all agents have left."""
    flock = flock_at_home(model, agents=1, informed=0)
    flock.run(TICKS)
    demand_sound(flock, "one agent")
    flock.members[0].remove()
    flock.run(TICKS)
    demand(len(flock.ids) == 0, "somebody came into an empty flock")


def one_spot(model: Model) -> None:
    """Agents that all start in one spot have finite positions afterwards."""
    start = crowd(model)
    start["position"] = np.repeat(start["position"][:1], AGENTS, axis=0)
    flock = flock_in_empty_space(model, start)
    flock.run(TICKS)
    demand_sound(flock, "all in one spot")


def other_dimensions(model: Model) -> None:
    """In all dimensions that it is declared for, positions stay finite."""
    for dim in model.dimensions:
        world, start = empty_space(model, dim), crowd(model, dim)
        # A loop for another number of dimensions takes long to compile.
        at_hand = dim == flock_at_home(model, agents=1).world.dim
        kinds = known_kinds(model)
        flock = Flock(
            model.name, start=start, world=world, rng=7, kinds=kinds, interpret=not at_hand
        )
        flock.run(2)
        demand_sound(flock, f"in {dim}-D")


def proposed(model: Model) -> None:
    """The range that a slider proposes is within what is allowed, and the default is in it."""
    for declaration in declared(model.parameters):
        if not isinstance(declaration, NumberParameter):
            demand(declaration.kind != "number", f"{declaration.name}: no range for a slider")
            continue
        try:
            demand_proposed(
                declaration.proposed, declaration.default, declaration.low, declaration.high
            )
        except ValueError as why:
            raise ConformanceFailure(f"{declaration.name}: {why}") from None


def bounds(model: Model) -> None:
    """With any one parameter at an end of its range, positions stay finite."""
    for declaration in declared(model.parameters):
        ends = (
            (False, True)
            if declaration.kind == "switch"
            else declaration.choices or (declaration.low, declaration.high)
        )
        for value in ends:
            flock = flock_in_empty_space(model, None, **{declaration.name: value})
            flock.run(2)
            demand_sound(flock, f"{declaration.name} = {value}")


def late_mean(flock: Flock, lesson: LessonStep) -> float:
    """Run a flock the ticks of a try; the mean of the observable over the last fifth of them."""
    looks = 5
    short = max(1, lesson.proof.ticks // (5 * looks))
    flock.run(lesson.proof.ticks - (looks - 1) * short)
    values = [flock.observe(lesson.proof.observable)]
    for _ in range(looks - 1):
        flock.run(short)
        values.append(flock.observe(lesson.proof.observable))
    return float(np.mean(values))


def run_try(model: Model, lesson: LessonStep, seed: int) -> tuple[float, float]:
    """Make a try with a model at home: the observable without the change, and with it."""
    flock = Flock(model.name, rng=seed)
    before = late_mean(flock, lesson)
    if lesson.anew:
        flock = Flock(model.name, rng=seed, **lesson.set)
    else:
        flock.set(**lesson.set)
    return before, late_mean(flock, lesson)


def tries(model: Model) -> None:
    """What it proposes to try comes true, in its own world from three starts."""
    if not model.to_try:
        raise InapplicableCheck(f"{model.name} declares nothing to try")
    for lesson in model.to_try:
        if lesson.proof.observable not in OBSERVABLES:
            raise ConformanceFailure(
                f"{lesson.changes}: there is no observable {lesson.proof.observable}"
            )
        options = sorted(OPTIONS.keys() & lesson.set.keys())
        demand(
            lesson.anew or not options, f"{lesson.changes}: {', '.join(options)} needs anew=True"
        )
        for seed in SEEDS:
            before, after = run_try(model, lesson, seed)
            demand(
                lesson.proof.holds(before, after),
                f"{lesson.changes}, seed {seed}: not {lesson.proof.in_words}, but {before:.4g} "
                f"without it and {after:.4g} with it",
            )


CHECKS: dict[str, Callable[[Model], None]] = {
    "threads": threads,
    "order": order,
    "saved": saved,
    "plain": plain,
    "shift": shift,
    "rotation": rotation,
    "mirror": mirror,
    "inside": inside,
    "alone": alone,
    "one spot": one_spot,
    "dimensions": other_dimensions,
    "bounds": bounds,
    "proposed": proposed,
    "tries": tries,
}


def outcome(model: Model, name: str) -> ConformanceResult:
    """Run a check. Raises InputError for a model that cannot be run at all."""
    check = CHECKS[name]
    fact = (check.__doc__ or "").splitlines()[0]
    try:
        check(model)
    except InapplicableCheck as reason:
        return ConformanceResult(name, fact, "does not apply", str(reason))
    except (ConformanceFailure, ModelCodeError, ArithmeticError) as reason:
        return ConformanceResult(name, fact, "fails", str(reason))
    return ConformanceResult(name, fact, "holds")
