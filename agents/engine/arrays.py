"""Define what the compiled loop works on: arrays, context, place and workspace of a flock."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from agents.engine.cells import CellGrid, Slots, Space
from agents.engine.heeding import MOST_KINDS
from worlds.queries.surroundings import Surroundings

PLAN, COUNT, SHARE, PLACE, FILL, PREPARE, SWEEP = 1, 2, 4, 8, 16, 32, 64
"""The phases of a tick as bits: a loop runs one of them or several in a call."""
ALL_PHASES = PLAN | COUNT | SHARE | PLACE | FILL | PREPARE | SWEEP
BEFORE_SWEEP = ALL_PHASES & ~SWEEP
"""Everything before the first decision."""


WIDE_FROM = 2**31
"""Rows, slots and cells are numbered by int32 below so many agents, by int64 from there on."""


def index_type(n: int) -> type[np.signedinteger[Any]]:
    """What the rows of n agents are numbered by: narrow where it can be, which is less to read."""
    return np.int32 if n < WIDE_FROM else np.int64


class Arrays(NamedTuple):
    """The flock: one row per agent."""

    position: np.ndarray
    heading: np.ndarray
    speed: np.ndarray
    informed: np.ndarray
    ids: np.ndarray
    leg: np.ndarray
    """The waypoint of the mission's path that an information agent heads for, int32."""
    memory: np.ndarray
    """Signals of the rule, signals of the body, what the rule keeps to itself, what is measured;
    shape (K, N)."""
    crash_record: np.ndarray
    """Of agents that can crash the tick at which they did, or -1, what they touched, and where;
    (N, 2 + dim), or no rows at all. See `agents.state.agent_rows`."""
    past: np.ndarray
    """The flock as it stood at the last ticks, where messages take time, else no ticks: position,
    heading, speed and signals; (N, ticks, 2 dim + 1 + K), that of tick k at k modulo ticks."""
    kind: np.ndarray = np.empty(0)
    """Where there are kinds, the number of each agent's, or `heeding.CAUGHT`; float64 (N,), else
    (0,)."""
    wish: np.ndarray = np.empty((0, 3))
    """Where agents of a kind are steered from outside, what each is told to wish, nan where it
    follows its rule; (N, 3), else (0, 3)."""
    own: np.ndarray = np.empty((0, 0))
    """Where agents differ, each one's parameters, `Model.individual` by name; (N, Q), else
    (N, 0)."""


def empty_slots(n: int, dim: int, signals: int, speeds: bool, kinds: bool = False) -> Slots:
    """Empty arrays for a sorted copy of n agents, with their speeds and kinds or without."""
    n3, index = n if dim == 3 else 0, index_type(n)
    return Slots(
        np.zeros(n, index),
        np.zeros(n, index),
        np.empty(n),
        np.empty(n),
        np.empty(n3),
        np.empty(n),
        np.empty(n),
        np.empty(n3),
        np.empty(n if speeds else 0),
        np.empty((signals, n)),
        np.zeros(n if signals else 0, index),
        np.empty(n if kinds else 0),
        no_heeds(kinds),
    )


def no_heeds(kinds: bool) -> np.ndarray:
    """`Slots.heeds` for as many kinds as there may be, or for none."""
    size = MOST_KINDS + 1 if kinds else 0
    return np.zeros((size, size))


class Context(NamedTuple):
    """Parameters and constants that every agent goes by in a tick."""

    parameters: Any
    """The rule's and the body's parameters as floats: the loop's `P`."""
    noise: int
    """Kind of noise: `agents.engine.noise.ANGULAR` or `VECTORIAL`."""
    reach: float
    """The largest distance at which agents notice each other, length."""
    lasts: float
    """How much time a tick stands for."""
    wind: np.ndarray
    """How far the wind carries agents in each tick from `since` on, length, (ticks, 3)."""
    since: int
    unbounded: Any
    """The parameters as they are for a rule that is shown the nearest agents only: without the
    radius beyond which it hears nobody; the loop's `P`."""
    nearest: int
    """How many nearest agents a rule is shown; 0 where it is shown all within reach."""
    relations: np.ndarray
    """Of each kind to each, (K, K, heeding.COLUMNS); none where there are no kinds."""


class Workspace(NamedTuple):
    """One thread's scratch buffers."""

    block: np.ndarray
    """A neighbourhood block: positions, headings, positions of nearest images, speeds, kinds; (11,
    capacity)."""
    signals: np.ndarray
    """The block's signals, (K, capacity)."""
    close: np.ndarray
    """Those of the block within reach of one agent: positions, headings, speeds, kinds; (8,
    capacity)."""
    close_signals: np.ndarray
    """Their signals, (K, capacity)."""
    apart: np.ndarray
    """Squares of the distances of the block's agents, (capacity,)."""
    chosen: np.ndarray
    """Which of the block are within reach, `index_type` (capacity,)."""
    mine: np.ndarray
    """One agent's signals as it reads them, (K,), and as it writes them."""
    out: np.ndarray
    own: np.ndarray
    """What one agent keeps to itself."""
    measured: np.ndarray
    """What is measured of one agent."""
    found: np.ndarray
    """Boundary points around one agent: indices, int32."""
    points: np.ndarray
    """Their coordinates, (2, points)."""
    spare: np.ndarray
    """For the rule's own working, (4, the larger of capacity and points)."""


def empty_workspace(
    capacity: int, signals: int, private: int, measures: int, points: int
) -> Workspace:
    """Buffers for blocks of at most `capacity` agents and `points` boundary points around one.

    A block has a row more than is used: eight at once read beyond the last agent of the one before.
    """
    return Workspace(
        np.zeros((11 + 1, capacity)),
        np.zeros((signals + 1, capacity)),
        np.zeros((8 + 1, capacity)),
        np.zeros((signals + 1, capacity)),
        np.zeros(capacity),
        np.zeros(capacity, index_type(capacity)),
        np.zeros(signals),
        np.zeros(signals),
        np.zeros(private),
        np.zeros(measures),
        np.zeros(points, np.int32),
        np.zeros((2, points)),
        np.zeros((4, max(capacity, points))),
    )


def empty_grid(n: int, parts: int) -> CellGrid:
    """An empty grid with as many cells as are worth having for n agents."""
    capacity, index = max(64, n) + 2, index_type(n)
    return CellGrid(
        np.zeros(3),
        np.zeros(3),
        np.zeros(3),
        np.ones(3, np.int64),
        np.zeros(capacity, index),
        np.zeros((parts, capacity), index),
        np.array([[np.inf] * 3, [-np.inf] * 3]),
    )


class EngineStopCondition(NamedTuple):
    """When a run ends: once something has held of the flock for some ticks.

    What has to hold is the part `holds` of a loop, see `agents.engine.template`.
    """

    numbers: np.ndarray
    """What `holds` is asked with, float64; none where the run is to go on whatever holds."""
    hold: int
    """Ticks for which it has to hold."""
    last_off: int
    """Last tick at which it did not, -1 for none so far."""


NEVER = EngineStopCondition(np.empty(0), 0, -1)


class WorldContext(NamedTuple):
    """The world as compiled code sees it: its edges, and what stands in it."""

    space: Space
    surroundings: Surroundings
