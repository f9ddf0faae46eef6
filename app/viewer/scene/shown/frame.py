"""What passes from the simulation to the drawing: one frozen picture of the flock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.individuals import Distribution
from agents.inspection import Inspection
from agents.kinds import NO_KINDS, KindTable
from agents.state.agent_rows import Crashes
from worlds.world import World

# What the picture has to know of agents that are cars, beside places and headings.

HELD = 0.5
"""A car that has not got on for so long is stuck, s."""


@dataclass(frozen=True)
class Cars:
    """Cars at one tick. Arrays are copies that nobody writes to any more."""

    length: float
    """Of the body, length."""
    width: float
    """Of the body, length."""
    steering: np.ndarray
    """(N,) angle of the front wheels, rad, to the left positive; 0 for cars without."""
    stuck: np.ndarray
    """(N,) bool: something has kept them from getting on, or they are backing out of it."""
    predator: np.ndarray
    """(N,) bool: cars that hunt the others."""


def cars(flock: Flock) -> Cars | None:
    """What is to be known of a flock of cars; None for a flock of anything else.

    What a body tells of itself counts from its first move on.
    """
    model, count, parameters = flock.model, len(flock.ids), flock.parameters
    vehicle = model.body.vehicle
    if vehicle is None:
        return None

    def signal(name: str) -> np.ndarray:
        return np.array(flock.signal(name)) if name in model.columns else np.zeros(count)

    ready = signal(vehicle.fresh) == 0.0
    stuck = np.where(ready, signal(vehicle.stuck), 0.0)
    return Cars(
        length=float(getattr(parameters, "length", vehicle.length)),
        width=float(getattr(parameters, "width", vehicle.width)),
        steering=np.where(ready, signal(vehicle.steering), 0.0),
        stuck=(stuck > HELD) | (stuck < 0.0),
        predator=signal(model.rule.hunters) == 1.0,
    )


# What the picture has to know of a room with real cars, beside places and headings.

STATES = TRACKED, LATE, LOST, STOPPED, SIMULATED = (
    "tracked",
    "late",
    "lost",
    "stopped",
    "simulated",
)
"""What a car in the picture may be."""


@dataclass(frozen=True)
class Live:
    """A room at one tick. The real cars come first, then the simulated ones."""

    names: tuple[str, ...]
    """Of all N cars in the picture; one that was never seen is not in it."""
    roster: tuple[str, ...]
    """Of all cars of the room, seen or not, in an order that stays."""
    states: tuple[str, ...]
    """One of `STATES` each."""
    ages: np.ndarray
    """(N,) seconds since each was last seen; 0 for simulated ones."""
    fence: float
    """How far inside the area the cars are stopped, m."""
    arm: str
    """safe, armed or emergency."""

    def is_in_state(self, *states: str) -> np.ndarray:
        """Which of the cars are in one of these states, (N,) bool."""
        return np.array([state in states for state in self.states], dtype=bool)


@dataclass(frozen=True)
class MissionProgress:
    """How a mission stands at one tick."""

    goal: np.ndarray | None = None
    """Where the gamma agent is, (dim,), if there is one."""
    done: int = 0
    """Waypoints of the path that the information agents have left behind; the last agent counts."""


OF_AGENTS = ("position", "heading", "speed", "informed", "ids", "layer", "group", "measured",
             "active", "saved", "seen", "hollow", "reaches", "kind")  # fmt: skip
"""What a frame has of each agent, a row each, or None."""


@dataclass(frozen=True)
class Frame:
    """The flock at one tick. Arrays are copies that nobody writes to any more."""

    run: int
    """Counts the set-ups; a new number means a new flock, not a moved one."""
    tick: int
    world: World
    """What does not move; the same object from frame to frame until something in it is changed."""
    reach: float
    """Interaction radius, length; the largest of all agents where they differ in it."""
    speed_scale: float
    """Speed that counts as full colour, length per unit of time."""
    position: np.ndarray
    """(N, dim)."""
    heading: np.ndarray
    """(N, dim), unit vectors."""
    speed: np.ndarray
    """(N,), length per unit of time."""
    informed: np.ndarray
    """(N,) bool: information agents."""
    ids: np.ndarray
    """(N,) int: identity of each row."""
    kept: float = float("inf")
    """Distance that agents keep from each other, length; infinite where their rule has no zones."""
    dt: float = 1.0
    """Time that a tick stands for."""
    unit: str = "ticks"
    """Unit of time: ticks, or s."""
    room: tuple[np.ndarray, np.ndarray] | None = None
    """Corners (dim,) of the region in which the mission starts."""
    progress: MissionProgress = MissionProgress()
    sees_points: bool = False
    """Whether boundary points are all that agents perceive of what is solid."""
    points: np.ndarray | None = None
    """Boundary points of what is solid, (M, 2), if asked for; one object while they stay."""
    layer: np.ndarray | None = None
    """(N,) int: 1 information agent, 2 in contact with one, ...; N + 1 unknown. If asked for."""
    group: np.ndarray | None = None
    """(N,) int: label of the connected group, 0 the largest. If asked for."""
    measured: np.ndarray | None = None
    """(N,) the number of each agent that was asked for, NaN where it has none."""
    own: Mapping[str, np.ndarray] = MappingProxyType({})
    """(N,) each: the agents' own numbers of the parameters that differ, by name."""
    individuals: Mapping[str, Distribution] = MappingProxyType({})
    """What these were drawn from."""
    kind: np.ndarray | None = None
    """(N,) int: the number of each agent's kind, 0 of the ordinary ones, -1 of who was caught and
    stands still; None: there are no kinds."""
    kinds: KindTable = NO_KINDS
    """What these are called and coloured."""
    has_turnover: bool = False
    """Whether agents may come or go while it runs."""
    reaches: np.ndarray | None = None
    """(N,): how far each notices others, length, where that differs; None: `reach` is of all."""
    links: np.ndarray | None = None
    """(M, 2) int: rows of neighbouring pairs, if asked for."""
    inspected: Inspection | None = None
    others: Mapping[int, Inspection] = MappingProxyType({})
    """Agents that other pages inspect, by row, as they were looked at last."""
    active: np.ndarray | None = None
    """(N,) bool: agents that have not crashed; None where nobody can."""
    crashes: Crashes | None = None
    """Who has crashed, where they can."""
    saved: np.ndarray | None = None
    """(N,) share of its induced drag that each saves, NaN unknown; None: it is not measured."""
    seen: np.ndarray | None = None
    """(N,) bool: of tracks, who is seen; None: everybody is."""
    hollow: np.ndarray | None = None
    """(N,) bool: of tracks, who is drawn at its last place, hollow; nobody else who is not seen."""
    usual: int = 0
    """Of tracks, how many are seen at a time as a rule; 0: everybody always is. As `apart`, it says
    how large they are drawn, and the agents of a model beside them."""
    apart: float = float("inf")
    """Of tracks, the median distance to the nearest other, length."""
    length_unit: str = "m"
    """Unit of lengths, where time is in s: of tracks perhaps px."""
    names: tuple[str, ...] = ()
    """(N,): of tracks, what individuals are called in their file; empty: by their numbers."""
    is_over: bool = False
    """Whether the flock beside it is drawn over it, in the same room, and this one hollow."""
    form: str = "birds"
    """What its rule's source is about: birds or fish."""
    cars: Cars | None = None
    """Of agents that are cars; None for any others."""
    live: Live | None = None
    """Of a room with real cars; None for a simulation."""
    title: str = ""
    """What its model is called, if there is another flock beside it."""
    beside: Frame | None = None
    """The same of the flock beside it."""

    def of_rows(self, rows: np.ndarray) -> Frame:
        """The same of some agents alone, without what is of pairs, of one of them, or beside."""
        taken: dict[str, Any] = {
            name: None if getattr(self, name) is None else getattr(self, name)[rows]
            for name in OF_AGENTS
        }
        taken["own"] = {name: column[rows] for name, column in self.own.items()}
        return replace(self, **taken, links=None, inspected=None, others={}, beside=None)

    @property
    def dim(self) -> int:
        """2 or 3."""
        return self.world.dim

    @property
    def is_drawn(self) -> np.ndarray | None:
        """Whose bodies are drawn, (N,) bool; None for everybody."""
        if self.is_over:
            return np.zeros(len(self.ids), bool)
        return self.seen

    @property
    def outlined(self) -> np.ndarray | None:
        """Who is drawn hollow, (N,) bool; None for nobody."""
        if self.is_over and self.seen is not None:
            return self.seen if self.hollow is None else self.seen | self.hollow
        return self.hollow

    @property
    def is_down(self) -> np.ndarray:
        """Agents that have crashed, (N,) bool."""
        return np.zeros(len(self.ids), bool) if self.active is None else ~self.active

    @property
    def is_caught(self) -> np.ndarray:
        """Agents that were caught and stand still, (N,) bool."""
        return np.zeros(len(self.ids), bool) if self.kind is None else self.kind < 0

    @property
    def low(self) -> np.ndarray:
        """Lower corner of the world's box, (dim,), length."""
        return np.array(self.world.low, float)

    @property
    def size(self) -> np.ndarray:
        """Sides of the world's box, (dim,), length; of an open world those it was set up with."""
        return np.array(self.world.size, float)

    @property
    def wraps(self) -> np.ndarray:
        """Whether each axis wraps, (dim,) bool."""
        return np.array(self.world.wraps, bool)

    @property
    def pace_unit(self) -> str:
        """Unit of speeds, in words."""
        return "per tick" if self.unit == "ticks" else f"{self.length_unit}/{self.unit}"
