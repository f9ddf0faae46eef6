"""Formation flight: what birds save by each other's upwash, from their positions and headings.

The pair of a bird and another is `agents.bodies.upwash.relief`; here it is for arrays: the share
as a map, the best spacing beside (2.8) of the thesis, and the sum over a flock or over tracks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agents.bodies.upwash import CORE, WITHIN, drag_saving_within, relief
from agents.engine.block import Me, NeighbourBlock
from agents.engine.cache import compile_to_disk
from agents.observables.array_checks import box, drop_bad_rows, numbers, spread, units, vectors
from worlds.input_error import InputError

FAR = 1e9
"""Spans behind a bird at which its wake is as good as infinitely long."""
INDUCED = 0.35
"""Share of a bird's power that is induced, as assumed in the reading of the thesis (2.3)."""
THESIS_SPACING = 0.5 * (math.pi / 4.0 - 1.0)
"""(2.8): the best wing-tip spacing in spans, -0.107; negative where wings overlap."""


class Spacing(NamedTuple):
    """Where beside another a bird saves most."""

    tip: float
    """Wing-tip spacing, spans; negative where wings overlap."""
    saved: float
    """Share of its induced drag saved there."""


@compile_to_disk
def relieve(dx, dy, dz, core, out):
    """`relief` for arrays (M,) of lengths in spans."""
    for i in range(dx.shape[0]):
        out[i] = relief(dx[i], dy[i], dz[i], core)


@compile_to_disk
def sum_drag_savings(position, heading, size, images, b, block, none, out):
    """Each bird's `saved` (N,); `block` (7, N) holds the others' nearest images, `none` nothing."""
    n = position.shape[1]
    x, y, z = position[0], position[1], position[2]
    no, sums = none[0], block[3:]
    ux, uy, uz = heading[0], heading[1], heading[2]
    for i in range(n):
        for axis in range(3):
            for j in range(n):
                offset = position[axis, j] - position[axis, i]
                if images[axis]:
                    offset -= size[axis] * math.floor(offset / size[axis] + 0.5)
                block[axis, j] = position[axis, i] + offset
        me = Me(
            x[i],
            y[i],
            z[i],
            ux[i],
            uy[i],
            uz[i],
            0.0,
            none[0],
            none[0],
            False,
            1.0,
            i,
            0,
            0,
            n,
            0.0,
        )
        near = NeighbourBlock(
            n, block[0], block[1], block[2], ux, uy, uz, no, none, no, 0, no, no, sums, no
        )
        out[i] = drag_saving_within(me, near, b, WITHIN * b)


def upwash_share(dx, dy, dz=0.0, core: float = CORE) -> np.ndarray:
    """Share of its induced drag that a bird saves by another, without the fading of wakes.

    It flies `dx` behind (negative: ahead), `dy` beside and `dz` above the other, in spans, each of
    which may be infinite; arrays that broadcast. `core` >= 0 is the radius of the vortices' cores
    in spans, 0 for line vortices. The share is negative in the downwash, and nan where a place is.
    Raises InputError.

    >>> round(float(upwash_share(math.inf, 1.0 - 0.137)), 3)
    0.692
    """
    if not 0.0 <= core < math.inf:
        raise InputError(f"core = {core!r} span is not allowed: a number >= 0 is needed")
    behind = np.clip(numbers("dx", dx), -FAR, FAR)
    try:
        offsets = np.broadcast_arrays(behind, numbers("dy", dy), numbers("dz", dz))
    except ValueError:
        shapes = ", ".join(str(np.shape(offset)) for offset in (dx, dy, dz))
        raise InputError(f"dx, dy and dz of shapes {shapes} do not match") from None
    out = np.empty(offsets[0].size)
    relieve(*(np.ascontiguousarray(component).ravel() for component in offsets), float(core), out)
    is_endless = np.isinf(offsets[1]) | np.isinf(offsets[2])
    share = np.where(is_endless, 0.0, out.reshape(offsets[0].shape))
    return np.where(np.isnan(offsets).any(axis=0), np.nan, share)


def best_spacing(core: float = CORE, behind: float = math.inf, above: float = 0.0) -> Spacing:
    """The wing-tip spacing that saves most, `behind` and `above` the other in spans.

    With line vortices (`core` 0) and no difference in height it is that of (2.8), (pi/4 - 1)/2 =
    -0.107 exactly: the wing tip is in the vortex. The share has a kink there, which is looked for
    by golden section between wing tips one span apart and wings that overlap by half. Raises
    InputError.

    >>> tuple(round(one, 3) for one in best_spacing())
    (-0.137, 0.692)
    """
    from scipy.optimize import minimize_scalar

    optimum = minimize_scalar(
        lambda tip: -float(upwash_share(behind, 1.0 + tip, above, core)),
        bounds=(-0.5, 1.0),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return Spacing(float(optimum.x), -float(optimum.fun))


def saved_shares(
    position: np.ndarray,
    heading: np.ndarray,
    span: float,
    size: np.ndarray | None = None,
    images: np.ndarray | None = None,
) -> np.ndarray:
    """Share (N,) of its own induced drag that each bird saves; as a flock's `saved` has it.

    `position` (N, dim) and `heading` (N, dim, unit vectors) with dim 2 or 3: a bird of which a
    number is missing is left out and has nan, and a warning tells of it. `span` > 0 is the wing
    span in the unit of the positions. `size` (dim,) and `images` (dim,) bool: the sides of a box
    and along which of its axes the nearest image counts; None: open space. See
    `agents.bodies.upwash.drag_saving` for what is summed; of N birds it costs N^2. Raises
    InputError.
    """
    position, heading = vectors("position", position), vectors("heading", heading)
    if not 0.0 < span < math.inf:
        raise InputError(f"span = {span!r} is not allowed: a length > 0 is needed")
    finite, position, heading = drop_bad_rows(position=position, heading=heading)
    units(heading)
    n, dim = position.shape
    places, ways = np.zeros((3, n)), np.zeros((3, n))
    places[:dim], ways[:dim] = position.T, heading.T
    sides, wraps = np.ones(3), np.zeros(3, bool)
    if size is not None and images is not None:
        sides[:dim], wraps[:dim] = box(size, images, dim)
    out = np.zeros(n)
    sum_drag_savings(
        places, ways, sides, wraps, float(span), np.empty((7, n)), np.zeros((1, 1)), out
    )
    return spread(finite, out, np.nan)


def vee(birds: int, step: float = 0.5, tip: float | None = None) -> np.ndarray:
    """Places (N, 3) of a V of birds in spans, that head for +x: one in front, the rest on two arms.

    Each is `step` spans further back than the one before it on its arm and at the wing-tip spacing
    `tip` (None: the best far behind). Raises InputError.
    """
    if not isinstance(birds, int | np.integer) or birds < 1:
        raise InputError(f"birds = {birds!r} is not allowed: a whole number >= 1 is needed")
    if not (math.isfinite(step) and (tip is None or math.isfinite(tip))):
        raise InputError(
            f"step = {step!r} and tip = {tip!r} are not allowed: finite spans are needed"
        )
    beside = 1.0 + (best_spacing().tip if tip is None else tip)
    i = np.arange(birds)
    rank = (i + 1) // 2
    side = np.where(i % 2 == 1, 1.0, -1.0)
    return np.column_stack([-step * rank, beside * side * rank, np.zeros(birds)])


def vee_saved(
    birds: int,
    jitter: float = 0.0,
    draws: int = 1,
    step: float = 0.5,
    tip: float | None = None,
    rng: int = 0,
) -> np.ndarray:
    """Shares (draws, N) of induced drag saved by the birds of a `vee`, displaced anew each draw.

    Every coordinate of every bird is displaced by a normal error of deviation `jitter` >= 0 spans,
    drawn from the seed `rng`. Headings stay parallel. Raises InputError.
    """
    if not 0.0 <= jitter < math.inf:
        raise InputError(f"jitter = {jitter!r} span is not allowed: a number >= 0 is needed")
    if not isinstance(draws, int | np.integer) or draws < 1:
        raise InputError(f"draws = {draws!r} is not allowed: a whole number >= 1 is needed")
    places = vee(birds, step, tip)
    headings = np.tile([1.0, 0.0, 0.0], (birds, 1))
    chance = np.random.default_rng(rng)
    disturbed = [places + jitter * chance.standard_normal(places.shape) for _ in range(draws)]
    return np.array([saved_shares(position, headings, 1.0) for position in disturbed])
