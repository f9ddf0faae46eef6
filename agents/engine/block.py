"""What a rule sees: itself (`Me`), the agents around it (`NeighbourBlock`), and what it answers
(`Decision`).

The world around it, its obstacles and its goal, is `worlds.queries.surroundings.Surroundings`.

All vectors have three components; in a 2-D world the third is 0. Coordinates in a block are
those of the nearest image, so that `near.x[j] - me.x` is the separation whatever the edges.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from worlds.compilation import compiled
from worlds.queries.surroundings import points_within


class Me(NamedTuple):
    """One agent at the start of a tick."""

    x: float
    y: float
    z: float
    ux: float
    """Heading, a unit vector (ux, uy, uz)."""
    uy: float
    uz: float
    speed: float
    signal: np.ndarray
    """What it tells the others, shape (K,): the rule's signals, then the body's."""
    memory: np.ndarray
    """What it keeps to itself, in the order in which the rule names it; `perceive` writes it."""
    informed: bool
    """Whether it is an information agent, which listens to nobody."""
    own_weight: float
    """1.0 where its own heading counts in the mean (6), 0.0 on a mission: b_ii = 0 in (18)."""
    id: int
    tick: int
    key: int
    """Key of this tick's random numbers; see `agents.engine.noise.uniform`."""
    flock_size: int
    kind: float
    """The number of its kind: 0.0 of an ordinary agent, then those that its rule declares from 1.0
    on, then other kinds of the flock."""


class NeighbourBlock(NamedTuple):
    """The block of agents around one agent: all within its range, some beyond it, and itself.

    Arrays hold at least `n` entries. A rule picks its neighbours with `adjacent`.
    """

    n: int
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    ux: np.ndarray
    uy: np.ndarray
    uz: np.ndarray
    speed: np.ndarray
    signal: np.ndarray
    """What the agents tell each other, shape (K, n or more)."""
    heard: np.ndarray
    """1.0 for agents whose heading counts, 0.0 for those that are busy avoiding an obstacle."""
    points: int
    """Boundary points of obstacles within reach; 0 for a rule that does not ask for them."""
    point_x: np.ndarray
    point_y: np.ndarray
    spare: np.ndarray
    """A place for the rule's own working, four rows, each at least as long as n and points."""
    kind: np.ndarray
    """The number of each agent's kind, as `Me.kind`."""


class PointBlock(NamedTuple):
    """The boundary points of obstacles within reach of one agent; arrays hold at least `n`."""

    n: int
    x: np.ndarray
    y: np.ndarray
    spare: np.ndarray
    """A place for the rule's own working, four rows, each at least as long as n."""


class OtherAgent(NamedTuple):
    """Another agent, as seen by one; eight see it at once where a rule's `term` is given lanes."""

    dx: float
    """Separation x_j - x_i to its nearest image (dx, dy, dz), length."""
    dy: float
    dz: float
    d2: float
    """Square of the distance; 0 for the agent itself."""
    ux: float
    """Heading, a unit vector (ux, uy, uz)."""
    uy: float
    uz: float
    speed: float
    heard: bool
    """Whether its heading counts: it does not where it is busy avoiding an obstacle."""
    kind: float
    """The number of its kind, as `Me.kind`."""


class Decision(NamedTuple):
    """What a rule answers, and what a body is handed: a heading, an acceleration or a velocity.

    A wished heading is the weighted mean heading of those listened to. Its length, at most 1, is
    the agreement among them; vectorial noise is weighed against it. (0, 0, 0) means: keep the
    heading. A body is handed the unit vector that noise has made of it.
    """

    x: float
    y: float
    z: float


class BodyMove(NamedTuple):
    """What a body answers: where it is after the tick, before the world's edges act."""

    x: float
    y: float
    z: float
    ux: float
    uy: float
    uz: float
    speed: float


@compiled
def points_of(near):
    """The boundary points of a block, without its agents."""
    return PointBlock(near.points, near.point_x, near.point_y, near.spare)


@compiled
def see_points(surroundings, reach, me, workspace):
    """Copy the boundary points within reach of an agent to a workspace; returns how many."""
    n = points_within(surroundings, me.x, me.y, reach, workspace.found)
    for k in range(n):
        workspace.points[0, k] = surroundings.point_x[workspace.found[k]]
        workspace.points[1, k] = surroundings.point_y[workspace.found[k]]
    return n


@compiled
def neighbour_of(me, near, j):
    """Agent j of the block, as `me` sees it."""
    dx = near.x[j] - me.x
    dy = near.y[j] - me.y
    dz = near.z[j] - me.z
    d2 = dx * dx + dy * dy + dz * dz
    return OtherAgent(
        dx,
        dy,
        dz,
        d2,
        near.ux[j],
        near.uy[j],
        near.uz[j],
        near.speed[j],
        near.heard[j] > 0.0,
        near.kind[j],
    )


@compiled
def is_neighbour(other, r):
    """Whether 0 < |x_i - x_j| <= r: a_ij of Liu et al. 2021 (11)."""
    return (other.d2 > 0.0) & (other.d2 <= r * r)


@compiled
def adjacent(me, near, j, r):
    """a_ij of Liu et al. 2021 (11): 1.0 if 0 < |x_i - x_j| <= r, else 0.0; without a branch."""
    dx = near.x[j] - me.x
    dy = near.y[j] - me.y
    dz = near.z[j] - me.z
    d2 = dx * dx + dy * dy + dz * dz
    return 1.0 if (d2 > 0.0) & (d2 <= r * r) else 0.0
