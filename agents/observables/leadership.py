"""Who leads whom: the delays after which individuals take up each other's headings."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agents.engine.cache import compile_to_disk
from agents.observables.array_checks import integers, numbers
from worlds.compilation import compiled
from worlds.input_error import InputError

LEAST_PEAK = 0.5
"""The correlation from which a delay counts (Nagy et al. 2010)."""
BLOCKS = 8
"""Parts of the time over which leads are repeated, at most, to tell how sure they are."""
FEWEST_BLOCKS = 3
CHUNK = 1024
"""Frames of a pair that are gone through at once."""
NULL_PAIRS = 400
"""Pairs shifted in time that the null is made of."""
NULL_SHARE = 0.99
"""Of the null's peaks, those that a pair's peak must be above: with 0.95 so many pairs of tracks
that keep one heading are left that one of five such flocks has a leader."""
SURE = 0.05
"""How likely one lead at least of those called resolved would be chance."""


class PairDelays(NamedTuple):
    """After how long individuals take up the headings of others."""

    delay: np.ndarray
    """(N, N) frames: positive in `[i, j]` if j follows i; NaN without a peak within reach, and on
    the diagonal."""
    peak: np.ndarray
    """(N, N), the largest mean scalar product of headings so far apart, in [-1, 1]."""


class Leadership(NamedTuple):
    """How far each individual is ahead of the others, and whether that is more than chance."""

    lead: np.ndarray
    """(N,) frames: the mean delay after which others follow, less that after which it follows; NaN
    for one with no pair that counts."""
    error: np.ndarray
    """(N,) frames, the standard error of `lead` over parts of the time; NaN if time is too
    short."""
    resolved: np.ndarray
    """(N,) bool: whether a lead differs from none by more than chance, with all N of them tried."""
    delay: np.ndarray
    """(N, N) frames, those of pairs that count; NaN for others."""
    peak: np.ndarray
    """(N, N), as in `PairDelays`."""
    null_peak: float
    """What NULL_SHARE of the peaks of tracks shifted in time stay below; a pair counts if its peak
    is above this and LEAST_PEAK."""
    blocks: int
    """Parts of the time that `error` is from."""


@compiled
def add_four(a, b, first, second, many, sums):
    """Add to four sums the products of `many` numbers of a from `first` on with those of b from
    `second`, `second` + 1, `second` + 2 and `second` + 3 on: each number is fetched once."""
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    for t in range(np.uintp(many)):
        value = a[first + t]
        s0 += value * b[second + t]
        s1 += value * b[second + t + np.uintp(1)]
        s2 += value * b[second + t + np.uintp(2)]
        s3 += value * b[second + t + np.uintp(3)]
    sums[0] += s0
    sums[1] += s1
    sums[2] += s2
    sums[3] += s3


@compiled
def peak_of(product, many, longest, least):
    """Where `product` / `many` (2 longest + 1,), a mean by lag, is largest: delay and peak, NaN
    without one. Between lags by a parabola; `least` is the fewest frames that a mean is of."""
    best, top = -1, -2.0
    for at in range(2 * longest + 1):
        if many[at] >= least and product[at] > top * many[at]:
            best, top = at, product[at] / many[at]
    if best < 0:
        return math.nan, math.nan
    if best == 0 or best == 2 * longest or min(many[best - 1], many[best + 1]) < least:
        return math.nan, top
    before, after = product[best - 1] / many[best - 1], product[best + 1] / many[best + 1]
    bend = before - 2.0 * top + after
    return best - longest + (0.5 * (before - after) / bend if bend < 0.0 else 0.0), top


@compile_to_disk
def find_peaks(heading, seen, first, second, shift, longest, least, sums, delay, peak):
    """The delay and peak of pairs of tracks: of each the mean scalar product by lag.

    `heading` is (N, dim, P) and `seen` (N, P), 0 where there is none: a track, and on either side
    of it `longest` + 3 zeros. Pair k is of rows `first[k]` and `second[k]`, the second `shift[k]`
    frames later, and so on round the end. `least` frames is a mean of. `delay` and `peak` (K, B +
    1) are written: of all the time in column 0, then of B parts of it. `sums` (B + 1, 2, 2 longest
    + 5) is room.
    """
    dim, padded = heading.shape[1], heading.shape[2]
    edge, blocks = longest + 3, sums.shape[0] - 1
    frames = padded - 2 * edge
    for k in range(first.shape[0]):
        i, j, turned = first[k], second[k], shift[k]
        sums[:] = 0.0
        for part in range(blocks):
            begin, end = part * frames // blocks, (part + 1) * frames // blocks
            while begin < end:  # pieces that stay in the processor's nearest memory
                many = min(CHUNK, end - begin)
                moved = begin + turned
                if moved < frames:
                    many = min(many, frames - moved)
                else:
                    moved -= frames
                for at in range(0, 2 * longest + 1, 4):
                    b_first = np.uintp(edge + moved + at - longest)
                    for axis in range(dim):
                        to = sums[part + 1, 0, at : at + 4]
                        a, b = heading[i, axis], heading[j, axis]
                        add_four(a, b, np.uintp(edge + begin), b_first, many, to)
                    to = sums[part + 1, 1, at : at + 4]
                    add_four(seen[i], seen[j], np.uintp(edge + begin), b_first, many, to)
                begin += many
            for at in range(2 * longest + 1):
                sums[0, 0, at] += sums[part + 1, 0, at]
                sums[0, 1, at] += sums[part + 1, 1, at]
        for part in range(blocks + 1):
            delay[k, part], peak[k, part] = peak_of(sums[part, 0], sums[part, 1], longest, least)


def pair_delays(heading: np.ndarray, longest: int) -> PairDelays:
    """After how many frames j takes up the heading of i: `C_ij(tau) = <u_i(t) . u_j(t + tau)>`.

    The delay is where C is largest for tau from -longest to longest, between frames by a parabola
    (Nagy et al. 2010). A peak at either end is none, nor is a mean over fewer than 2 longest + 1
    frames.

    Parameters
    ----------
    heading: (T, N, dim) unit vectors, NaN is a gap: nobody is told.
    longest: frames, >= 1 and below T / 2.

    Raises InputError.

    >>> angle = np.cumsum(np.random.default_rng(1).normal(0.0, 0.2, 400))
    >>> angles = np.column_stack([angle[5:], angle[:-5]])
    >>> delays = pair_delays(np.stack([np.cos(angles), np.sin(angles)], axis=2), 12)
    >>> round(float(delays.delay[0, 1]), 1), round(float(delays.delay[1, 0]), 1)
    (5.0, -5.0)
    """
    rows, seen = _rows(heading, longest)
    n = len(rows)
    i, j = np.triu_indices(n, 1)
    delay, peak = _peaks(rows, seen, i, j, np.zeros(len(i), np.int64), longest, 1)
    return _pair_matrix(n, i, j, delay[:, 0], peak[:, 0])


def _rows(heading: np.ndarray, longest: int) -> tuple[np.ndarray, np.ndarray]:
    heading = numbers("heading", heading, axes=3)
    if heading.shape[2] not in (2, 3):
        raise InputError(f"heading has shape {heading.shape}: (T, N, 2) or (T, N, 3) is needed")
    longest = int(integers("longest", longest, 1))
    if 2 * longest >= len(heading):
        raise InputError(
            f"longest = {longest} frames is not allowed for {len(heading)} frames: below half of "
            "them is needed"
        )
    seen = np.isfinite(heading).all(axis=2)
    edge = (longest + 3, longest + 3)
    rows = np.where(seen[..., None], heading, 0.0).transpose(1, 2, 0)
    return np.pad(rows, ((0, 0), (0, 0), edge)), np.pad(seen.T.astype(float), ((0, 0), edge))


def _peaks(rows, seen, i, j, shift, longest, blocks) -> tuple[np.ndarray, np.ndarray]:
    delay, peak = np.empty((len(i), blocks + 1)), np.empty((len(i), blocks + 1))
    sums = np.empty((blocks + 1, 2, 2 * longest + 5))
    find_peaks(rows, seen, i, j, shift, longest, 2 * longest + 1, sums, delay, peak)
    return delay, peak


def _pair_matrix(n, i, j, delay, peak) -> PairDelays:
    delays, peaks = np.full((n, n), np.nan), np.full((n, n), np.nan)
    delays[i, j], delays[j, i] = delay, -delay
    peaks[i, j] = peaks[j, i] = peak
    return PairDelays(delays, peaks)


def leadership(heading: np.ndarray, longest: int, seed: int = 0) -> Leadership:
    """How far each individual leads, beside what chance makes (Nagy et al. 2010).

    A pair counts if the correlation at its delay is above LEAST_PEAK, and above what tracks shifted
    in time against each other reach: individuals that all keep one heading agree however they are
    shifted, and no delay can be seen. A lead is resolved if it differs from 0 by more than its
    error over parts of the time, which is from pairs that count in all of it.

    Parameters
    ----------
    heading: (T, N, dim) unit vectors, NaN is a gap. longest: frames, >= 1 and below T / 2.
    seed: of the shifts.

    Raises InputError.
    """
    from scipy.special import stdtrit

    rows, seen = _rows(heading, longest)
    n, frames = len(rows), len(heading)
    blocks = max(1, min(BLOCKS, frames // (4 * longest + 2)))
    i, j = np.triu_indices(n, 1)
    rng = np.random.default_rng(seed)
    null = math.nan
    if n > 1 and frames > 4 * longest + 2:
        of = rng.integers(0, len(i), NULL_PAIRS)
        shift = rng.integers(2 * longest + 1, frames - 2 * longest, NULL_PAIRS)
        peaks = _peaks(rows, seen, i[of], j[of], shift, longest, 1)[1][:, 0]
        if np.isfinite(peaks).any():
            null = float(np.nanquantile(peaks, NULL_SHARE))
    delays, peaks = _peaks(rows, seen, i, j, np.zeros(len(i), np.int64), longest, blocks)
    delay, peak = delays[:, 0], peaks[:, 0]
    counts = (peak >= LEAST_PEAK) & (peak > null) & np.isfinite(delay)  # False where null is NaN
    delays[~counts] = np.nan
    leads = np.stack([_means(_pair_matrix(n, i, j, d, d).delay) for d in delays.T])
    many = np.isfinite(leads[1:]).sum(axis=0)
    enough = (many >= FEWEST_BLOCKS) & np.isfinite(leads[0])
    centre = np.nansum(leads[1:], axis=0) / np.maximum(many, 1)
    square = np.nansum((leads[1:] - centre) ** 2, axis=0) / np.maximum(many - 1, 1)
    error = np.where(enough, np.sqrt(square / np.maximum(many, 1)), np.nan)
    bound = stdtrit(np.maximum(many - 1, 1), 1.0 - SURE / (2.0 * n))
    resolved = enough & (np.abs(leads[0]) > bound * error)
    whole = _pair_matrix(n, i, j, delays[:, 0], peak)
    return Leadership(leads[0], error, resolved, whole.delay, whole.peak, null, blocks)


def _means(delay: np.ndarray) -> np.ndarray:
    many = np.isfinite(delay).sum(axis=1)
    return np.where(many > 0, np.nansum(delay, axis=1) / np.maximum(many, 1), np.nan)
