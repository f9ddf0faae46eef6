"""A rule that is a sum over its neighbours, written once: what is listened to follows from it.

`mean_heading` makes a rule of how much each neighbour weighs, `sum_of` one of the forces between
two. What they return goes into a `Rule`: `Rule(..., **mean_heading(weight))`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from agents.engine.block import Decision, neighbour_of, points_of
from agents.engine.pairs.term_sums import add_terms, no_sums
from worlds.compilation import compiled


def of_pairs(
    number: int,
    term: Callable,
    answer: Callable,
    by_lanes: bool = False,
    sees_points: bool = False,
) -> dict[str, Any]:
    """A rule that answers to sums over pairs: `term`, `answer`, and the `decide` that they make.

    `term(me, other, p)`, compiled, has `number` numbers, all 0 for agents that are out of reach;
    `answer(me, sums, surroundings, p)` makes a Wish of their sums, and may write `me.memory`. The
    engine takes the terms of eight agents at once, so there is no `if` in a term; `by_lanes` says
    that there is none in `answer` either. With `sees_points` it is
    `answer(me, sums, points, surroundings, p)`, one agent at a time: `points` are the boundary
    points within reach, a `PointBlock`. Raises TypeError for both.
    """
    if by_lanes and sees_points:
        raise TypeError("of_pairs: boundary points are not seen by lanes, but by one agent each")
    around = sums_around(number, term)

    @compiled
    def decide(me, near, surroundings, p):
        return answer(me, around(me, near, p), surroundings, p)

    @compiled
    def decide_by_points(me, near, surroundings, p):
        return answer(me, around(me, near, p), points_of(near), surroundings, p)

    made = {"term": term, "answer": answer, "sums": number, "by_lanes": by_lanes}
    if sees_points:
        return made | {"decide": decide_by_points, "sees_points": True}
    return made | {"decide": decide}


def sums_around(number: int, term: Callable) -> Callable:
    """Compiled: (me, near, p). The `number` sums of a `term` over those around."""

    @compiled
    def around(me, near, p):
        sums = no_sums(number, 0.0)
        for j in range(near.n):
            sums = add_terms(sums, term(me, neighbour_of(me, near, j), p))
        return sums

    return around


def mean_heading(weight: Callable) -> dict[str, Any]:
    """`decide` and `weigh` of a rule that takes a weighted mean of headings, its own weighing 1.

    `weight(me, near, j, p)`, compiled, is how much agent j counts, 0 for those that are no
    neighbours; agents that are not heard count nothing.
    """

    @compiled
    def decide(me, near, surroundings, p):
        n = me.own_weight
        x, y, z = n * me.ux, n * me.uy, n * me.uz
        for j in range(near.n):
            a = weight(me, near, j, p) * near.heard[j]
            x += a * near.ux[j]
            y += a * near.uy[j]
            z += a * near.uz[j]
            n += a
        if n == 0.0:
            return Decision(0.0, 0.0, 0.0)
        return Decision(x / n, y / n, z / n)

    @compiled
    def weigh(me, near, p, out):
        for j in range(near.n):
            out[j] = weight(me, near, j, p) * near.heard[j]

    return {"decide": decide, "weigh": weigh}


def sum_of(**terms: Callable) -> dict[str, Any]:
    """`decide`, `forces` and `explain` of a rule that adds up forces between two agents, by name.

    Each of `terms`, at least one, is compiled: `term(me, near, j, p) -> Wish`, the force of agent j
    on itself, (0, 0, 0) for those that are no neighbours.
    """
    decide = explain = None
    for row, term in enumerate(terms.values()):
        decide = add_force_term(decide, term)
        explain = explain_force_terms(explain, term, row)
    forces = tuple(name.replace("_", " ") for name in terms)
    return {"decide": decide, "explain": explain, "forces": forces, "wish": "acceleration"}


@compiled
def no_force(me, near, surroundings, p):
    """No force."""
    return Decision(0.0, 0.0, 0.0)


@compiled
def explain_no_force(me, near, surroundings, p, out):
    """No force to explain."""


def add_force_term(previous: Callable | None, term: Callable) -> Callable:
    """The force of the `previous` terms and of one more."""
    first = no_force if previous is None else previous

    @compiled
    def decide(me, near, surroundings, p):
        previous_force = first(me, near, surroundings, p)
        x, y, z = previous_force.x, previous_force.y, previous_force.z
        for j in range(near.n):
            force = term(me, near, j, p)
            x += force.x
            y += force.y
            z += force.z
        return Decision(x, y, z)

    return decide


def explain_force_terms(previous: Callable | None, term: Callable, row: int) -> Callable:
    """The forces of the `previous` terms, and of one more in a row of `out` (forces, 3)."""
    first = explain_no_force if previous is None else previous

    @compiled
    def explain(me, near, surroundings, p, out):
        first(me, near, surroundings, p, out)
        for j in range(near.n):
            force = term(me, near, j, p)
            out[row, 0] += force.x
            out[row, 1] += force.y
            out[row, 2] += force.z

    return explain
