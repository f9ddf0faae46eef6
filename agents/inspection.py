"""Inspect one agent: its state, whom it listens to and how much, and what moves it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from agents.engine.arrays import Context
from agents.engine.block import Me, NeighbourBlock
from agents.engine.noise import tick_key
from agents.models.model import Model
from agents.models.model_calls import call
from agents.observables.neighbours import nearest_of, separation
from agents.rules.terms.potential_field import obstacle_force
from agents.snapshot import FlockState, Snapshot
from worlds.compilation import plain_python
from worlds.queries.surroundings import Surroundings, points_within, set_goal

NO_POINTS = np.empty((0, 2))
UNSEEN = -1
"""Instead of a zone: a neighbour that is not noticed."""


@dataclass(frozen=True)
class Shell:
    """A zone of a rule (`agents.models.declare.Zone`) with the parameters as they are."""

    name: str
    radius: float
    """Outer radius, length."""
    all_round: bool
    """Whether agents outside of the field of view are noticed there too."""


@dataclass(frozen=True)
class Inspection:
    """What is known of one agent and of those it listens to."""

    id: int
    row: int
    neighbours: np.ndarray
    """Rows of its neighbours, int (M,)."""
    separation: np.ndarray
    """Vectors to their nearest images, (M, dim), length."""
    weights: np.ndarray
    """How much it listens to each, (M,), as its rule weighs them."""
    signals: dict[str, float]
    """What it tells its neighbours beside position and heading, and what it keeps to itself."""
    forces: dict[str, np.ndarray] = field(default_factory=dict)
    """The terms of its wish, then those of its body's velocity, by name, (dim,) each."""
    points: np.ndarray = field(default_factory=lambda: NO_POINTS)
    """Boundary points of obstacles that it perceives, (P, 2), length."""
    zone: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    """Which of `shells` each neighbour is in, (M,) int, UNSEEN where it is not noticed; (0,)
    where the rule has no zones."""
    shells: tuple[Shell, ...] = ()
    """The zones of its rule from the inside out."""
    view: float = 360.0
    """Full angle of its field of view, deg."""
    places: tuple[str, ...] = ()
    """Points among its signals, NAME_x and NAME_y of each; it heads for the last of them."""
    minds: bool = False
    """Whether these points count now."""
    model: Model | None = None
    """What it is of: the words and units of its signals."""
    name: str = ""
    """What it is called in a file; empty: it has its number only."""
    known: Mapping[str, str] = field(default_factory=dict)
    """What else is to be told of it, words -> value."""


def as_me(flock: FlockState, row: int, signals: np.ndarray) -> Me:
    """A row as rules see themselves; `signals` (K,) are its columns."""
    x, y, *z = (float(c) for c in flock.position[row])
    ux, uy, *uz = (float(c) for c in flock.heading[row])
    signal_count = len(flock.model.signals)
    key: Any = np.uint64(tick_key(flock.seed, flock.tick))
    return Me(
        x,
        y,
        z[0] if z else 0.0,
        ux,
        uy,
        uz[0] if uz else 0.0,
        float(flock.speed[row]),
        signals[:signal_count],
        signals[signal_count:],
        bool(flock.informed[row]),
        signals[signal_count - 1] if flock.model.body.deafens else 1.0,
        int(flock.ids[row]),
        flock.tick,
        key,
        len(flock.ids),
        float(flock.kind_numbers[row]),
    )


def as_near(
    flock: FlockState, row: int, rows: np.ndarray, offset: np.ndarray, signals: np.ndarray, points
) -> NeighbourBlock:
    """Rows at an `offset` (M, dim) from a row, and boundary points (P, 2), as rules see them."""
    dim, signal_count = flock.world.dim, len(flock.model.signals)
    x, y, z = np.zeros((3, len(rows)))
    ux, uy, uz = np.zeros((3, len(rows)))
    for axis, (at, heading) in enumerate(((x, ux), (y, uy), (z, uz))):
        if axis < dim:
            at[:] = flock.position[row, axis] + offset[:, axis]
            heading[:] = flock.heading[rows, axis]
    sent = np.ascontiguousarray(signals[:signal_count, rows])
    heard = sent[signal_count - 1] if flock.model.body.deafens else np.ones(len(rows))
    px, py = np.ascontiguousarray(points.T)
    speed, spare = flock.speed[rows], np.zeros((4, max(len(rows), len(points))))
    kind = flock.kind_numbers[rows].astype(float)
    return NeighbourBlock(
        len(rows), x, y, z, ux, uy, uz, speed, sent, heard, len(points), px, py, spare, kind
    )


def perceived_points(flock: FlockState, surroundings: Surroundings, row: int) -> np.ndarray:
    """The boundary points that an agent's rule sees, (P, 2), length."""
    if not flock.model.rule.sees_points:
        return NO_POINTS
    rows = np.zeros(surroundings.most_points, np.int32)
    x, y = (float(c) for c in flock.position[row, :2])
    n = points_within(surroundings, x, y, flock.reach, rows)
    return np.column_stack([surroundings.point_x[rows[:n]], surroundings.point_y[rows[:n]]])


def forces_on(
    flock: FlockState,
    surroundings: Surroundings,
    context: Context,
    me: Me,
    near: NeighbourBlock,
    interpret: bool,
) -> dict[str, np.ndarray]:
    """The terms of the rule's next wish and of its body's velocity, by name, (dim,) each."""
    p, rule, body = context.parameters, flock.model.rule, flock.model.body
    if rule.perceive is not None and (rule.explain or body.explain):
        call(flock.model, interpret, rule.perceive, me, near, surroundings, p)
    forces: dict[str, np.ndarray] = {}
    for part in (rule, body):
        if part.explain is not None:
            out = np.zeros((len(part.forces), 3))
            call(flock.model, interpret, part.explain, me, near, surroundings, p, out)
            forces |= dict(zip(part.forces, out[:, : flock.world.dim], strict=True))
    return forces


def obstacle_push(
    flock: FlockState,
    surroundings: Surroundings,
    context: Context,
    row: int,
    interpret: bool = False,
) -> np.ndarray:
    """The force (dim,) of the obstacles ahead on an agent whose rule has the thesis's field (4.1).

    In mass length/s^2; its parameters must have `gain`, `Q` and `body`.
    """
    me = as_me(flock, row, flock.arrays.memory[:, row].copy())
    force = call(flock.model, interpret, obstacle_force, me, surroundings, context.parameters)
    return np.array(force[: flock.world.dim])


def shells(flock: FlockState, row: int | None = None) -> tuple[Shell, ...]:
    """The zones of a flock's rule, with its parameters as they are; none where it has none.

    `row`: with those of the agent of a row, where agents differ.
    """
    parameters = flock.parameters if row is None else flock.parameters_of(row)
    return tuple(
        Shell(zone.name, float(zone.radius(parameters)), zone.all_round)
        for zone in flock.model.rule.zones
    )


def field_of_view(flock: FlockState, row: int | None = None) -> float:
    """The full angle (deg) of a flock's field of view, or of that of the agent of a row; 360 where
    its rule has none."""
    name = flock.model.rule.view
    parameters = flock.parameters if row is None else flock.parameters_of(row)
    return float(getattr(parameters, name)) if name else 360.0


def zones_of(
    offset: np.ndarray, heading: np.ndarray, shells: tuple[Shell, ...], view: float
) -> np.ndarray:
    """Which of `shells` the places at an `offset` (M, dim) from an agent are in, (M,) int.

    A place at a zone's outer radius is in the next one, but at that of the last one within. UNSEEN
    is what lies beyond all, or outside of the field of view (deg) about the `heading` (dim,) in a
    zone that is not all round.
    """
    distance = np.linalg.norm(offset, axis=1)
    is_in_view = offset @ heading >= np.cos(np.deg2rad(0.5 * view)) * distance
    zones = np.full(len(offset), UNSEEN)
    inner = 0.0
    for index, shell in enumerate(shells):
        last = index == len(shells) - 1
        within = (distance <= shell.radius) if last else (distance < shell.radius)
        zones[(distance >= inner) & within & (is_in_view | shell.all_round)] = index
        inner = max(inner, shell.radius)
    return zones


def compile_inspection(
    flock: Snapshot, surroundings: Surroundings, context: Context, interpret: bool = False
) -> None:
    """Compile what `inspect` calls, which takes seconds; the flock may run on meanwhile."""
    rule, body = flock.model.rule, flock.model.body
    if not len(flock.ids) or not (rule.weigh or rule.explain or body.explain):
        return
    surroundings = surroundings._replace(goal=surroundings.goal.copy())
    columns = len(flock.model.columns)
    rows, offset = np.empty(0, int), np.empty((0, flock.world.dim))
    me = as_me(flock, 0, np.zeros(columns))
    near = as_near(flock, 0, rows, offset, np.zeros((columns, 1)), NO_POINTS)
    set_goal(surroundings, 0.0)
    if rule.sees_points:
        points_within(surroundings, me.x, me.y, 0.0, np.zeros(surroundings.most_points, np.int32))
    if rule.weigh is not None:
        call(flock.model, interpret, rule.weigh, me, near, context.parameters, np.empty(0))
    forces_on(flock, surroundings, context, me, near, interpret)


def inspect(
    flock: Snapshot, surroundings: Surroundings, context: Context, row: int, interpret: bool = False
) -> Inspection:
    """Inspect the agent of a row (0 to N - 1): what it decides on in the tick to come.

    The snapshot is one with signals; `surroundings` and `context` are what the flock's agents go
    by, and `interpret` says whether as plain Python. One that has crashed has no neighbours, and
    is nobody's. Raises Fault.
    """
    with plain_python(interpret):
        return inspect_row(flock, surroundings, context, row, interpret)


def inspect_row(
    flock: Snapshot, surroundings: Surroundings, context: Context, row: int, interpret: bool
) -> Inspection:
    """The agent of a row as `inspect` tells it."""
    world, rule = flock.world, flock.model.rule
    offset = separation(flock.position[row], flock.position, world.size, world.images)
    d2 = (offset**2).sum(axis=1)
    active = flock.active
    reach = float(getattr(flock.parameters_of(row), rule.reach))
    heeded = flock.heeds(np.full(len(d2), row), np.arange(len(d2)))
    rows = np.flatnonzero((d2 > 0.0) & (d2 <= reach**2) & active & active[row] & heeded)
    parameters = context.parameters
    if flock.nearest:
        other_rows = np.flatnonzero(active & active[row])
        rows = np.sort(other_rows[nearest_of(offset[other_rows], flock.nearest)])
        parameters = context.unbounded
    offset = offset[rows]
    signals = flock.arrays.memory
    own = signals[:, row].copy()
    values = dict(zip(flock.model.columns, own.tolist(), strict=True))
    points = perceived_points(flock, surroundings, row)
    weights = np.ones(len(rows))
    forces: dict[str, np.ndarray] = {}
    own_shells, view = shells(flock, row) if active[row] else (), field_of_view(flock, row)
    if flock.informed[row] or not active[row]:
        weights[:] = 0.0
    else:
        surroundings = surroundings._replace(goal=surroundings.goal.copy())
        set_goal(surroundings, flock.elapsed)
        me = as_me(flock, row, own.copy())
        near = as_near(flock, row, rows, offset, signals, points)
        if rule.weigh is not None and len(rows):
            call(flock.model, interpret, rule.weigh, me, near, parameters, weights)
        forces = forces_on(flock, surroundings, context, me, near, interpret)
    return Inspection(
        int(flock.ids[row]),
        row,
        rows,
        offset,
        weights,
        values,
        forces,
        points,
        zones_of(offset, flock.heading[row], own_shells, view) if own_shells else np.empty(0, int),
        own_shells,
        view,
        rule.places,
        values.get(rule.places_while) == 1.0,
        flock.model,
    )
