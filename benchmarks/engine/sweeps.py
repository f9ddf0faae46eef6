"""What grows in `scaling.py`, and whose cost is measured while it grows."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from contestants import DENSITY, ETA, PEERS, V0, R, mesa_boids
from turns import Contestant, Flight, flight_of, take_turns, with_progress

from agents import Flock
from worlds.obstacles import Box
from worlds.world import World

MANY = 10_000
"""Agents, where it is not they that grow."""
AMONG = 1_000
"""Agents among obstacles."""
YARD, PILLAR = 200.0, 1.0
"""Sides of the yard that fills with pillars, and of these."""
AGENT_STEP = 1e-6
"""Seconds, about; for the time left."""


@dataclass(frozen=True)
class Home:
    """A model at its density, in a box whose edges wrap."""

    density: float
    """Agents per unit of area or volume."""
    dim: int = 2
    words: Mapping[str, float] = field(default_factory=dict)

    def flock(self, model: str, agents: int, density: float = 1.0) -> Flock:
        """So many agents at so many times its density."""
        size = (agents / (density * self.density)) ** (1.0 / self.dim)
        return self.boxed(model, size, agents=agents)

    def boxed(self, model: str, size: float, **start: Any) -> Flock:
        """Agents in a box of this side."""
        return Flock(model, world="wrap", dim=self.dim, size=size, rng=1, **start, **self.words)


HOMES = {
    "vem": Home(DENSITY, words={"r": R, "v0": V0, "eta": ETA}),
    "couzin": Home(100 / 40.0**3, 3),
    "hwvem": Home(DENSITY),
    "boundary-points": Home(0.1),
    "reynolds": Home(0.2),
    "guarded": Home(50 / 24.0**3, 3),
}
SHARED = ("vem", "hwvem", "boundary-points")
"""Models whose ticks threads share: two sums over pairs, and one that is given blocks."""
GATHERS = "couzin"
"""A model whose agents gather: they come to have more and more neighbours."""
SEEING = ("couzin", "hwvem-nav", "reynolds", "boundary-points", "guarded")
"""Models that see, or run into, obstacles in the plane."""


@dataclass(frozen=True)
class Made:
    """What is measured at a point: so many agents that run."""

    agents: int
    flight: Flight
    neighbours: float | None = None
    """Of an agent, on average."""


type Maker = Callable[[float], Made | None]


@dataclass(frozen=True)
class Sweep:
    """Something that grows, and the makers of those who meet it, by name."""

    title: str
    axis: str
    values: Sequence[float]
    makers: Mapping[str, Maker]
    agents: Callable[[float], float]
    """How many agents there are at a value, to say beforehand how long it lasts."""
    clock: str = "cpu"
    """What its costs are of: CPU time, or `wall`, which threads are to shorten."""


@dataclass
class Point:
    """What an agent-step costs at a point of a sweep."""

    name: str
    value: float
    agents: int
    least: float
    """Nanoseconds by the clock of the sweep."""
    median: float
    neighbours: float | None


def growing_flocks(model: str) -> Maker:
    """More and more agents at its density."""

    def make(agents: float) -> Made:
        return Made(int(agents), flight_of(HOMES[model].flock(model, int(agents))))

    return make


def crowded_flocks(model: str, agents: int) -> Maker:
    """As many agents in a smaller box."""

    def make(density: float) -> Made:
        flock = HOMES[model].flock(model, agents, density)
        return Made(agents, flight_of(flock), flock.observe("mean-neighbours"))

    return make


def shared_flocks(model: str, threads: int) -> Maker:
    """More and more agents, whatever their number on so many threads."""

    def make(agents: float) -> Made:
        flock = HOMES[model].flock(model, int(agents))
        flock.threads, flock.split_from = threads, 1
        return Made(int(agents), flight_of(flock))

    return make


def gathered_flock(model: str, agents: int) -> Maker:
    """As many agents, after more and more ticks in which they gather."""

    def make(ticks: float) -> Made:
        flock = HOMES[model].flock(model, agents)
        flock.run(int(ticks))
        return Made(agents, flight_of(flock), flock.observe("mean-neighbours"))

    return make


def yard(pillars: int) -> World:
    """An open square with so many square pillars in rows."""
    rows = math.isqrt(pillars - 1) + 1
    places = [divmod(k, rows) for k in range(pillars)]
    corners = [((x + 0.5) * YARD / rows, (y + 0.5) * YARD / rows) for x, y in places]
    boxes = tuple(Box(low=(x, y), high=(x + PILLAR, y + PILLAR)) for x, y in corners)
    return World("yard", (YARD, YARD), ("open", "open"), obstacles=boxes)


def obstructed(model: str, agents: int) -> Maker:
    """As many agents among more pillars, which are too small to leave them much less room."""

    def make(pillars: float) -> Made:
        world = yard(int(pillars))
        return Made(agents, flight_of(Flock(model, agents=agents, world=world, dim=2, rng=1)))

    return make


def peer(name: str, agents: int | None = None) -> Maker:
    """Another package: more and more agents; or so many, at more and more times the density."""

    def make(value: float) -> Made | None:
        n = int(value) if agents is None else agents
        flight = PEERS[name](n, DENSITY if agents is None else DENSITY * value)
        return None if flight is None else Made(n, flight)

    return make


def all_sweeps(agents: Sequence[int], many: int, among: int) -> dict[str, Sweep]:
    """The sweeps by name, that over the number of agents with these."""
    shared, most = (1_000, 3_000, 10_000, 20_000, 30_000, 100_000), max(agents)
    quick = [name for name, make in PEERS.items() if make is not mesa_boids]
    return {
        "agents": Sweep(
            "agents, at constant density", "agents", agents,
            {name: growing_flocks(name) for name in HOMES} | {name: peer(name) for name in PEERS},
            lambda value: value,
        ),
        "density": Sweep(
            f"density, {many:,} agents", "times the density", (0.125, 0.25, 0.5, 1, 2, 4, 8),
            {name: crowded_flocks(name, many) for name in HOMES}
            | {name: peer(name, many) for name in quick},
            lambda _: many,
        ),
        "obstacles": Sweep(
            f"obstacles, {among:,} agents", "pillars", (1, 10, 30, 100, 300, 1000),
            {name: obstructed(name, among) for name in SEEING},
            lambda _: among,
        ),
        "gathering": Sweep(
            f"ticks in which {among:,} agents gather", "ticks", (0, 500, 1_000, 1_500),
            {GATHERS: gathered_flock(GATHERS, among)},
            lambda _: among,
        ),
        "threads": Sweep(
            "agents, on one thread and on two, wall time", "agents",
            [n for n in shared if n <= most] or [most],
            {
                f"{name}, {threads} thread{'s'[: threads - 1]}": shared_flocks(name, threads)
                for name in SHARED for threads in (1, 2)
            },
            lambda value: value,
            "wall",
        ),
    }  # fmt: skip


def make_contestant(name: str, built: Made, turn: float) -> Contestant:
    """A contestant whose turn lasts so many seconds, or a tick; what it compiles is compiled."""
    built.flight(1)
    ticks = int(max(1.0, turn / max(built.flight(1).cpu, AGENT_STEP)))
    return Contestant(name, built.agents, ticks, built.flight)


def run(
    sweep: Sweep, rounds: int, turn: float, longest: float, doing: str
) -> tuple[list[Point], list[str]]:
    """All points, and who is left out where: a turn lasts about, a tick at most so many seconds.

    Those who meet the same value take turns.
    """
    points: list[Point] = []
    left_out: dict[str, str] = {}
    cost: dict[str, float] = {}
    for value in with_progress(
        sweep.values, doing, lambda x: max(turn, AGENT_STEP * sweep.agents(x))
    ):
        homes: dict[str, Made] = {}
        for name, make in sweep.makers.items():
            lasts = 1e-9 * cost.get(name, 0.0) * sweep.agents(value)
            if name not in left_out and lasts > longest:
                left_out[name] = f"{name} from {value:,} on: a tick would last {lasts:.1f} s"
            home = None if name in left_out else make(value)
            if home is not None:
                homes[name] = home
        turns = [make_contestant(name, item, turn) for name, item in homes.items()]
        take_turns(turns, rounds)
        for home in turns:
            cost[home.name] = home.least()
            near = homes[home.name].neighbours
            least, median = home.least(sweep.clock), home.median(sweep.clock)
            points.append(Point(home.name, value, home.agents, least, median, near))
    return points, [*left_out.values()]
