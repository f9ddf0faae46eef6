"""Who keeps up with the information agents, and how close things came, over a run's positions."""

from __future__ import annotations

import math

import numpy as np

from agents.engine.cache import compile_to_disk
from agents.observables.array_checks import column, length, numbers, warn_of_omitted
from worlds.input_error import InputError
from worlds.queries.surroundings import nearest_surface


@compile_to_disk
def fill_nearest_pairs(trace, least2):
    """`nearest_pairs` of arrays that are checked."""
    ticks, dim, n = trace.shape
    for t in range(ticks):
        for i in range(n):
            for j in range(i + 1, n):
                dx = trace[t, 0, j] - trace[t, 0, i]
                dy = trace[t, 1, j] - trace[t, 1, i]
                d2 = dx * dx + dy * dy
                if dim == 3:
                    dz = trace[t, 2, j] - trace[t, 2, i]
                    d2 += dz * dz
                least2[i, j] = min(least2[i, j], d2)


@compile_to_disk
def fill_clearances(trace, surroundings, clearances):
    """`least_clearances` of arrays that are checked."""
    ticks, dim, n = trace.shape
    if surroundings.solids == 0:
        return
    for t in range(ticks):
        for i in range(n):
            z = trace[t, 2, i] if dim == 3 else 0.0
            if math.isfinite(trace[t, 0, i]) and math.isfinite(trace[t, 1, i]) and math.isfinite(z):
                at = nearest_surface(surroundings, trace[t, 0, i], trace[t, 1, i], z)
                clearances[i] = min(clearances[i], at.distance)


@compile_to_disk
def fill_following(trace, is_present, informed, r, follows, reached, queue):
    """`keep_following` of arrays that are checked; `is_present` (T, N) bool tells who is where."""
    ticks, dim, n = trace.shape
    for t in range(ticks):
        tail = 0
        is_lost = False
        for i in range(n):
            reached[i] = informed[i] and is_present[t, i]
            is_lost = is_lost or (informed[i] and not is_present[t, i])
            if reached[i]:
                queue[tail] = i
                tail += 1
        if tail == 0 and is_lost:
            continue
        at = 0
        while at < tail:
            i = queue[at]
            at += 1
            for j in range(n):
                if not reached[j]:
                    d2 = 0.0
                    for axis in range(dim):
                        d = trace[t, axis, j] - trace[t, axis, i]
                        d2 += d * d
                    if d2 <= r * r:
                        reached[j] = True
                        queue[tail] = j
                        tail += 1
        for i in range(n):
            follows[i] = follows[i] and (reached[i] or not is_present[t, i])


KERNELS = (fill_nearest_pairs, fill_clearances, fill_following)


def places(trace: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A trace (T, dim, N) as the kernels take it, and whether an agent is anywhere then, (T, N).

    What is infinite is made nan, from which nothing is near. Raises InputError, and warns of the
    rows of all ticks that are left out.
    """
    trace = numbers("trace", trace, axes=3)
    ticks, dim, n = trace.shape
    if dim not in (2, 3):
        raise InputError(f"trace has shape {trace.shape}: (T, 2, N) or (T, 3, N) is needed")
    is_present = np.isfinite(trace).all(axis=1)
    if not is_present.all():
        warn_of_omitted(int((~is_present).sum()), ticks * n, "trace")
        trace = np.where(is_present[:, None], trace, np.nan)
    return np.ascontiguousarray(trace), is_present


def demand_output(name: str, array: np.ndarray, shape: tuple[int, ...], kind: type) -> np.ndarray:
    """An array that is written to, of just this shape and kind. Raises InputError."""
    if not isinstance(array, np.ndarray) or array.shape != shape or array.dtype != kind:
        description = (
            f"{array.dtype} {array.shape}" if isinstance(array, np.ndarray) else repr(array)
        )
        raise InputError(f"{name} is {description}: an array {kind.__name__} {shape} is needed")
    return array


def nearest_pairs(trace: np.ndarray, least2: np.ndarray) -> None:
    """Bring `least2` (N, N), the least squared distance of each pair so far, up to date.

    `trace` is (T, dim, N), positions of T ticks, length. Only least2[i, j] with i < j is used. At a
    tick at which an agent's position is no number it is left out, with a warning. Raises
    InputError.
    """
    trace, _ = places(trace)
    n = trace.shape[2]
    fill_nearest_pairs(trace, demand_output("least2", least2, (n, n), float))


def least_clearances(trace: np.ndarray, surroundings, least: np.ndarray) -> None:
    """Bring `least` (N,), each agent's least signed distance to a surface, up to date.

    `trace` is (T, dim, N), positions of T ticks, length; `surroundings` a flock's
    `engine.surroundings`. Left out and refused as for `nearest_pairs`.
    """
    trace, _ = places(trace)
    fill_clearances(trace, surroundings, demand_output("least", least, trace.shape[2:], float))


def keep_following(trace, informed, r: float, follows, reached, queue) -> None:
    """Clear `follows` (N,) for agents that at some tick are cut off from the information agents.

    An agent follows while it is in the component of an information agent in the graph of all pairs
    within r (length). `trace` is (T, dim, N), `informed` (N,) bool; `reached` (N,) bool and
    `queue` (N,) int are working space. Liu et al. 2021, section 3.2. Left out and refused as for
    `nearest_pairs`: where an agent is not known nothing is said of it, nor of anybody at a tick at
    which that is so of all information agents.
    """
    trace, is_present = places(trace)
    shape = trace.shape[2:]
    fill_following(
        trace,
        is_present,
        demand_output("informed", informed, shape, bool),
        length("r", r),
        demand_output("follows", follows, shape, bool),
        demand_output("reached", reached, shape, bool),
        demand_output("queue", queue, shape, np.int64),
    )


def spread_bound(n: int, d: float) -> float:
    """How far from its goal the outermost of n agents may be that stand around it at distance d.

    1.35 times the radius of a hexagonal lattice of spacing d (length, >= 0) with n >= 0 places.
    Raises InputError.

    >>> round(spread_bound(30, 4.0), 2)
    15.53
    """
    count, d = length("n", n), length("d", d)
    return 1.35 * d * math.sqrt(count * math.sqrt(3.0) / (2.0 * math.pi))


def settling_tick(distance: np.ndarray, within: float) -> int | None:
    """The first index from which `distance` (T,) stays <= `within`, both length; None if never.

    A tick at which the distance is nan is not known to be near, and so is not. Raises InputError.

    >>> settling_tick(np.array([5.0, 1.0, 3.0, 1.5, 1.0]), 2.0)
    3
    """
    distance = column("distance", distance)
    away = np.flatnonzero(~(distance <= within))
    if len(away) == 0:
        return 0
    return int(away[-1]) + 1 if away[-1] + 1 < len(distance) else None
