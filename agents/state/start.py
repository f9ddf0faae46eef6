"""The start of a flock: positions and headings at tick 0, random from the seed or given."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.engine.noise import AT_ONCE, BEYOND, uniform_numbers
from worlds.checks import demand_free, demand_in_box
from worlds.input_error import InputError, unknown
from worlds.mission import Mission, SourceRegion, StartRegion
from worlds.queries.clearance import clearance
from worlds.world import World

THETA_D = np.pi / 4
"""Heading of the information UAV (rad), theta^d of Liu et al. 2021, section 3.1."""


TRIES = 300
"""How often agents that do not fit are tried elsewhere before a start is refused."""


@dataclass(frozen=True)
class Start:
    """Positions and headings at tick 0, with speeds and information agents; rows are agents."""

    position: np.ndarray
    heading: np.ndarray
    informed: np.ndarray
    speed: np.ndarray
    number: np.ndarray
    """0 to N - 1, each once: the identities that the rows are given, from the first on."""


FIRST = 3 * BEYOND
"""The tick of the headings and speeds at a start; those behind it are of the places, one for each
try (see `agents.engine.noise.BEYOND`)."""
SPEED = 4
"""The first draw of the speeds; before it are those of the headings."""


def start_gap(body: Any) -> Callable[[Any], float] | None:
    """How far from what is solid agents of a `Body` start at least, from its parameters, length;
    None where that is 0."""
    name = body.size
    return body.stride or ((lambda p: 0.5 * getattr(p, name)) if name else None)


def random_headings(seed: int, ids: np.ndarray, dim: int) -> np.ndarray:
    """Unit vectors of agents (N,), uniform on the circle or the sphere, (N, dim)."""
    heading = np.empty((len(ids), dim))
    for begin in range(0, len(ids), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        chance = uniform_numbers(seed, FIRST, ids[some], dim - 1)
        angle = 2.0 * np.pi * chance[:, 0]
        heading[some, 0], heading[some, 1] = np.cos(angle), np.sin(angle)
        if dim == 3:
            z = 2.0 * chance[:, 1] - 1.0
            heading[some, :2] *= np.sqrt(1.0 - z * z)[:, None]
            heading[some, 2] = z
    return heading


def goal_heading(dim: int) -> np.ndarray:
    """The heading that information agents know, a unit vector (dim,)."""
    if dim == 2:
        return np.array([np.cos(THETA_D), np.sin(THETA_D)])
    return np.full(3, 3.0**-0.5)


def random_start(
    world: World,
    agents: int,
    informed: int,
    seeds: Sequence[int],
    spacing: float | None = None,
    gap: float = 0.0,
) -> Start:
    """`agents` ordinary and `informed` information agents, as Liu et al. 2021, section 3.1.

    Positions are uniform in the box and headings uniform; the first information agent is in the
    corner (0, 0), and all of them head for theta^d. What an agent draws follows from the seed and
    its identity alone. Rows follow space, so that agents near each other start near each other in
    memory, while those that act one after another do so all over the box. The information agents
    come first in both. No agent starts inside an obstacle, or nearer than `gap` to one; with
    `spacing`, ordinary agents keep that distance to each other and to what is solid. A world with a
    mission may have a start region of its own, where all are spread alike. `seeds`: of a flock, or
    of several, whose rows come one flock after the other. Raises InputError where there is no room.
    """
    mission, n = world.mission, agents + informed
    region = None if mission is None else mission.start
    ids = np.arange(1, n + 1)
    if region is None:
        low, size = np.array(world.low), np.array(world.size)
    else:
        low, size = start_box(region, n)
        if spacing is None:
            spacing = region.spacing
        else:
            gap = max(gap, spacing)

    def places(seed: int) -> np.ndarray:
        """Where the agents of a flock begin, (n, dim)."""
        if region is not None:
            return spread(world, low, size, ids, spacing or 0.0, seed, gap)
        position = free_positions(world, ids[informed:], seed, spacing or 0.0, gap)
        if informed:
            first = free_positions(world, ids[:informed], seed)
            if not world.is_solid:
                first[:1] = 0.0
            position = np.concatenate([first, position])
        return position

    position = join([places(seed) for seed in seeds])
    order = along_space(position.reshape(len(seeds), n, -1)[:, informed:], low, size)
    if informed:
        first = np.tile(np.arange(informed), (len(seeds), 1))
        order = np.concatenate([first, informed + order], axis=1)
    rows = order if len(seeds) == 1 else order + n * np.arange(len(seeds))[:, None]
    # Headings follow the order, so that a large flock never has both of two sets in memory.
    position = position[rows.reshape(-1)]
    heading = join(
        [random_headings(seed, own + 1, world.dim) for seed, own in zip(seeds, order, strict=True)]
    )
    number, speed = order.reshape(-1), np.zeros(len(position))
    is_informed = number < informed
    if region is not None:
        for k, seed in enumerate(seeds):
            own_rows = slice(n * k, n * k + n)
            region_velocities(region, seed, order[k] + 1, heading[own_rows], speed[own_rows])
    if informed and region is None:
        heading[is_informed] = goal_heading(world.dim)
    elif informed and mission is not None:
        heading[is_informed] = mission_headings(mission, position[is_informed])
    return Start(position, heading, is_informed, speed, number)


def join(parts: list[np.ndarray]) -> np.ndarray:
    """The rows of all parts; those of a single one are not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def region_velocities(
    region: StartRegion | SourceRegion,
    seed: int,
    ids: np.ndarray,
    heading: np.ndarray,
    speed: np.ndarray,
) -> None:
    """Write the headings (N, dim) and speeds (N,) of agents of a region that has velocities."""
    if region.speed_low is None or region.speed_high is None:
        return
    chance = uniform_numbers(seed, FIRST, ids, heading.shape[1], SPEED)
    slow, fast = np.array(region.speed_low), np.array(region.speed_high)
    velocity = chance * (fast - slow) + slow
    speed[:] = np.linalg.norm(velocity, axis=1)
    moves = speed > 0.0
    heading[moves] = velocity[moves] / speed[moves, None]


def mission_headings(mission: Mission, position: np.ndarray) -> np.ndarray:
    """Unit vectors in which information agents at places (N, dim) start: for the first waypoint."""
    if mission.path is None:
        return np.tile(goal_heading(position.shape[1]), (len(position), 1))
    direction = np.array(mission.path.waypoints[0]) - position
    return direction / np.linalg.norm(direction, axis=1, keepdims=True)


def free_positions(
    world: World, ids: np.ndarray, seed: int, spacing: float = 0.0, gap: float = 0.0
) -> np.ndarray:
    """Positions of agents (N,), uniform in the box where nothing is solid, (N, dim).

    They keep at least `spacing` to each other and to what is solid, and `gap` to the latter. Raises
    InputError.
    """
    low, size = np.array(world.low), np.array(world.size)
    return spread(world, low, size, ids, spacing, seed, max(gap, spacing))


def spread(
    world: World, low, size, ids: np.ndarray, spacing: float, seed: int, gap: float = 0.0
) -> np.ndarray:
    """Positions of agents uniform in the box [low, low + size), clear of what is solid, (N, dim).

    They keep at least `spacing` to each other and `gap` to what is solid. Raises InputError if they
    do not fit, with the number that does.
    """
    n = len(ids)
    position, fit = try_positions(world, low, size, ids, spacing, seed, gap)
    if fit == n:
        return position
    count = -1
    while fit and count != fit:
        count, fit = fit, try_positions(world, low, size, ids[:fit], spacing, seed, gap)[1]
    distance_text = f", {spacing:g} from each other," if spacing > 0.0 else ""
    off = f", {gap:g} from them" if gap > 0.0 else ""
    fits = f"{fit} fit" if fit > 1 else ("1 fits" if fit else "not even one fits")
    raise InputError(
        f"agents = {n} do not fit into [{low.tolist()}, {(low + size).tolist()}]{distance_text} "
        f"outside the obstacles of {world.name}{off}: {fits}"
    )


def try_positions(
    world: World, low, size, ids: np.ndarray, spacing: float, seed: int, gap: float
) -> tuple[np.ndarray, int]:
    """Positions as `spread` asks for them, (N, dim), and how many of the last ones are good."""
    position = uniform_numbers(seed, FIRST + 1, ids, world.dim)
    position *= size
    position += low
    if not world.is_solid and spacing <= 0.0:
        return position, len(ids)
    for attempt in range(2, TRIES + 3):
        is_bad = np.zeros(len(ids), bool)
        if world.is_solid:
            is_bad |= clearance(world, position) <= gap
        if spacing > 0.0:
            is_bad |= is_too_close(world, position, spacing)
        if not is_bad.any() or attempt == TRIES + 2:
            break
        chance = uniform_numbers(seed, FIRST + attempt, ids[is_bad], world.dim)
        position[is_bad] = chance * size + low
    return position, len(ids) - int(is_bad.sum())


def is_too_close(world: World, position: np.ndarray, spacing: float) -> np.ndarray:
    """Rows that are nearer than `spacing` to a row before them, (N,) bool."""
    from scipy.spatial import cKDTree

    if world.images.any():
        # A side of 0 is one without images.
        round_ = np.where(world.images, world.size, 0.0)
        tree = cKDTree(np.where(world.images, position % world.size, position), boxsize=round_)
    else:
        tree = cKDTree(position)
    pairs = tree.query_pairs(spacing, output_type="ndarray")
    is_close = np.zeros(len(position), bool)
    is_close[pairs.max(axis=1)] = True
    return is_close


def start_box(region: StartRegion, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Lower corner and sides of a start region for n agents, (dim,) each, length."""
    low = np.array(region.low)
    if region.density is None:
        return low, np.array(region.high) - low
    return low, np.full(len(low), (n / region.density) ** (1.0 / len(low)))


def along_space(position: np.ndarray, low: np.ndarray, size: np.ndarray) -> np.ndarray:
    """An order of the rows (..., N, dim) in which near agents are near each other, (..., N): by
    strips of the box at `low`."""
    n, dim = position.shape[-2:]
    strips = max(1.0, (n / 4.0) ** (1.0 / dim))
    cells = [
        np.floor((position[..., axis] - low[axis]) / size[axis] * strips).astype(np.int32)
        for axis in range(dim)
    ]
    return np.lexsort(cells)


def given_start(world: World, arrays: Mapping[str, Any], passing: bool = False) -> Start:
    """A start from arrays: `position` and `heading` (N, dim), `speed` and `informed` (N,) or none.

    Positions are in the box along axes that wrap or are solid, and outside of obstacles unless
    agents go through these (`passing`). Headings are brought to length 1; speeds are >= 0, and 0 if
    none are given. Identities follow the rows. Raises InputError naming the array, the row and the
    value where something is no finite number, has no direction, is where no agent can be, or does
    not fit.
    """
    for name in arrays:
        if name not in ("position", "heading", "speed", "informed"):
            raise unknown("start array", name, ("position", "heading", "speed", "informed"))
    for name in ("position", "heading"):
        if name not in arrays:
            raise InputError(
                f"start has no {name!r}: position and heading, both (N, dim), are needed"
            )
    position = rows("position", arrays["position"], world.dim)
    demand_in_box(world, position, passing)
    if not passing:
        demand_free(world, position)
    heading = rows("heading", arrays["heading"], world.dim)
    if len(position) != len(heading):
        raise InputError(f"start has {len(position)} positions but {len(heading)} headings")
    if len(position) < 1:
        raise InputError("start has 0 agents: at least 1 is needed")
    informed = np.asarray(arrays.get("informed", np.zeros(len(position), bool)))
    if informed.shape != (len(position),):
        raise InputError(
            f"start array 'informed' has shape {informed.shape}, not ({len(position)},)"
        )
    length = np.linalg.norm(heading, axis=1, keepdims=True)
    if (length == 0.0).any():
        row = int(np.flatnonzero(length == 0.0)[0])
        raise InputError(f"heading of row {row} is a zero vector: a heading needs a direction")
    speed = np.asarray(arrays.get("speed", np.zeros(len(position))), float)
    if speed.shape != (len(position),) or not (np.isfinite(speed) & (speed >= 0.0)).all():
        raise InputError(f"start array 'speed' must be {len(position)} finite numbers >= 0")
    number = np.arange(len(position))
    return Start(position, heading / length, informed.astype(bool), speed, number)


def rows(name: str, values: object, dim: int) -> np.ndarray:
    """`values` as a float array (N, dim) of finite numbers. Raises InputError."""
    try:
        array = np.array(values, float)
    except (TypeError, ValueError):
        raise InputError(f"start array {name!r} is not an array of numbers") from None
    if array.ndim != 2 or array.shape[1] != dim:
        raise InputError(f"start array {name!r} has shape {array.shape}, not (N, {dim})")
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        value = array[row].tolist()
        raise InputError(f"{name} of row {row} is {value}: every component must be a finite number")
    return array
