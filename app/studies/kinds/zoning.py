"""Who is in which zone, who is seen, and what follows: the thesis, figures 3.1 to 3.4 and 4.3."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from agents.inspection import NO_POINTS, as_me, as_near, field_of_view
from agents.inspection import shells as shells_of
from agents.models.model_calls import call
from agents.observables.neighbours import separation
from app.studies.kinds.kind_settings import PERCENT, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

NOBODY, REPELLED, ALIGNED, ATTRACTED, BOTH = range(5)
"""What an agent goes by: nobody is seen, (3.9), (3.10), (3.11), (3.12)."""
BRANCHES = ("nobody", "repelled", "aligned", "attracted", "both")
SURE = 1e-6
"""Places so near to the edge of a zone (length) or of the view (cosine) are not asked about."""


class AgentNeighbours(NamedTuple):
    """The others as one agent has them."""

    apart: np.ndarray
    """Vectors to their nearest images, (M, dim), length."""
    heading: np.ndarray
    """Their headings, (M, dim)."""
    zone: np.ndarray
    """0, 1, 2: repulsion, orientation, attraction; -1: none, or out of view; (M,) int."""


class ZoningSettings(Settings):
    """How often the zones are looked at."""

    kind: ClassVar[str] = "zoning"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("wrong", "wrong", "Places that the rule has in another zone", "places", whole=True),
        Measure("seen", "seen", "Places within the zones that are noticed", "%", bounds=PERCENT),
        Measure("nobody", "nobody", "Agents that notice nobody", "%", bounds=PERCENT),
        Measure("repelled", "(3.9)", "Agents that are repelled", "%", bounds=PERCENT),
        Measure("aligned", "(3.10)", "Agents that align only", "%", bounds=PERCENT),
        Measure("attracted", "(3.11)", "Agents that are attracted only", "%", bounds=PERCENT),
        Measure("both", "(3.12)", "Agents that do both", "%", bounds=PERCENT),
        Measure("off", "off", "Largest angle of a wish from (3.9) to (3.12)", "deg"),
        Measure("turned", "turned", "Largest turn in a tick", "deg"),
    )

    looks: int = Field(400, ge=1)
    """Places around an agent that its rule is asked about, at random within 1.2 of its reach."""
    sight: float | None = Field(None, gt=0.0)
    """A distance of sight that the source names and the rule does not use: drawn, length."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Ask the rule about places around an agent, and about all agents as they are."""
        between()
        rng = np.random.default_rng(flock.seed)
        places = 1.2 * flock.reach * rng.uniform(-1.0, 1.0, (self.looks, flock.world.dim))
        sure = is_sure(flock, places)
        zone, expected = zones_by_rule(flock, 0, places), zones_by_hand(flock, 0, places)
        inside = np.linalg.norm(places, axis=1) <= flock.reach
        around = [around_of(flock, row) for row in range(len(flock.ids))]
        branch = np.array([branch_of(one.zone) for one in around])
        wishes = [wish_of(flock, row) for row in range(len(flock.ids))]
        off = max(
            angle_between(wish, expected_wish(one, flock.heading[row]))
            for row, (wish, one) in enumerate(zip(wishes, around, strict=True))
        )
        before = flock.heading.copy()
        flock.run(1)
        shares: dict[str, Number | None] = {
            name: 100.0 * float((branch == k).mean()) for k, name in enumerate(BRANCHES)
        }
        return shares | {
            "wrong": int((zone != expected)[sure].sum()),
            "seen": 100.0 * float((expected[inside] >= 0).mean()),
            "off": off,
            "turned": max(map(angle_between, before, flock.heading)),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One; asking about a place counts as one more."""
        return 1.0 + self.looks


def zones_by_rule(flock: Flock, row: int, places: np.ndarray) -> np.ndarray:
    """The zone of places (M, dim) from an agent, (M,) int: the rule is asked of each by itself.

    What it weighs another agent with that stands there says whether it is noticed; the zone is by
    the distance. -1 where it is not.
    """
    radii = np.array([shell.radius for shell in shells_of(flock)])
    signals = flock.arrays.memory
    me = as_me(flock, row, signals[:, row].copy())
    other = np.array([row])
    found = np.full(len(places), -1)
    weigh, parameters = flock.model.rule.weigh, flock.context.parameters
    assert weigh is not None
    for k, apart in enumerate(places):
        near = as_near(flock, row, other, apart[None], signals, NO_POINTS)
        weight = np.zeros(1)
        call(flock.model, flock.interpret, weigh, me, near, parameters, weight)
        if weight[0] > 0.0:
            zone = int(np.searchsorted(radii, np.linalg.norm(apart), side="right"))
            found[k] = min(zone, len(radii) - 1)
    return found


def zones_by_hand(flock: Flock, row: int, places: np.ndarray) -> np.ndarray:
    """The same by distance and angle alone: the definition of the zones and of the view."""
    shells, view = shells_of(flock), field_of_view(flock)
    d = np.linalg.norm(places, axis=1)
    cosine = np.clip(places @ flock.heading[row] / np.where(d > 0.0, d, 1.0), -1.0, 1.0)
    seen = np.degrees(np.arccos(cosine)) <= 0.5 * view
    found = np.full(len(places), -1)
    for k in reversed(range(len(shells))):
        found[(d <= shells[k].radius) & (seen | shells[k].all_round)] = k
        if not shells[k].all_round:  # who is too near to be seen there is not in the next either
            found[(d <= shells[k].radius) & ~seen] = -1
    return found


def is_sure(flock: Flock, places: np.ndarray) -> np.ndarray:
    """Which of places (M, dim) from row 0 lie on no edge, (M,) bool."""
    d = np.linalg.norm(places, axis=1)
    gap = np.min([np.abs(d - shell.radius) for shell in shells_of(flock)], axis=0)
    cosine = places @ flock.heading[0] / d
    return (gap > SURE) & (np.abs(cosine - np.cos(np.radians(0.5 * field_of_view(flock)))) > SURE)


def around_of(flock: Flock, row: int) -> AgentNeighbours:
    """The others within reach of an agent, and their zones by definition."""
    others = np.array([k for k in np.flatnonzero(flock.active) if k != row], int)
    apart = separation(
        flock.position[row], flock.position[others], flock.world.size, flock.world.images
    )
    near = np.linalg.norm(apart, axis=1) <= flock.reach
    apart, others = apart[near], others[near]
    return AgentNeighbours(apart, flock.heading[others], zones_by_hand(flock, row, apart))


def branch_of(zone: np.ndarray) -> int:
    """Which of (3.9) to (3.12) an agent goes by that has others in these zones."""
    if (zone == 0).any():
        return REPELLED
    aligns, follows = (zone == 1).any(), (zone == 2).any()
    if aligns and follows:
        return BOTH
    return ALIGNED if aligns else ATTRACTED if follows else NOBODY


def expected_wish(around: AgentNeighbours, heading: np.ndarray) -> np.ndarray:
    """The direction of (3.6) to (3.12), (dim,); the heading where there is none."""
    to = around.apart / np.linalg.norm(around.apart, axis=1, keepdims=True)
    zone = around.zone
    if (zone == 0).any():
        wish = -to[zone == 0].sum(axis=0)
    else:
        wish = around.heading[zone == 1].sum(axis=0) + to[zone == 2].sum(axis=0)
    length = float(np.linalg.norm(wish))
    return wish / length if length > 1e-9 else heading


def wish_of(flock: Flock, row: int) -> np.ndarray:
    """The direction that the rule itself wishes for, (dim,); the heading where it has no wish."""
    signals = flock.arrays.memory
    one = flock.inspect(row)
    me = as_me(flock, row, signals[:, row].copy())
    near = as_near(flock, row, one.neighbours, one.separation, signals, NO_POINTS)
    decide = flock.model.rule.decide
    assert decide is not None
    surroundings, parameters = flock.engine.surroundings, flock.context.parameters
    wish = call(flock.model, flock.interpret, decide, me, near, surroundings, parameters)
    found = np.array([wish.x, wish.y, wish.z][: flock.world.dim])
    length = float(np.linalg.norm(found))
    return found / length if length > 1e-9 else flock.heading[row].copy()


def angle_between(a: np.ndarray, b: np.ndarray) -> float:
    """Angle of two unit vectors (dim,), deg."""
    return float(np.degrees(2.0 * np.arctan2(np.linalg.norm(a - b), np.linalg.norm(a + b))))
