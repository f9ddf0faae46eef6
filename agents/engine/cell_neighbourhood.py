"""Around a cell: the agents of the 3 x 3 (3 x 3 x 3) cells, copied into one contiguous block."""

from __future__ import annotations

import math

import numpy as np

from worlds.compilation import compiled

FEW = 6
"""Agents that are copied faster one by one than column by column."""


@compiled
def axis_cells(grid, space, axis, at):
    """The up to three cells around `at` along an axis, as a first offset and a number of them."""
    if grid.shape[axis] == 1:
        return 0, 1
    if space.images[axis]:
        return -1, 3
    first = -1 if at > 0 else 0
    last = 1 if at < grid.shape[axis] - 1 else 0
    return first, last - first + 1


@compiled
def wrapped(grid, space, axis, at):
    """Cell index along a wrapping axis and the shift (length) to its nearest image."""
    n = grid.shape[axis]
    if at < 0:
        return at + n, -space.size[axis]
    if at >= n:
        return at - n, space.size[axis]
    return at, 0.0


@compiled
def around(grid, space, cell, k):
    """The k-th of the up to 27 cells around a cell, itself among them: (cell or -1, shifts x y z).

    The shifts bring its agents to their nearest image.
    """
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    x = cell % nx + k % 3 - 1
    y = cell // nx % ny + k // 3 % 3 - 1
    z = cell // (nx * ny) + k // 9 - 1
    ax, sx = wrapped(grid, space, 0, x)
    ay, sy = wrapped(grid, space, 1, y)
    az, sz = wrapped(grid, space, 2, z)
    seen = (
        (x == ax or (space.images[0] and nx > 1))
        and (y == ay or (space.images[1] and ny > 1))
        and (z == az or (space.images[2] and nz > 1))
    )
    inside = 0 <= ax < nx and 0 <= ay < ny and 0 <= az < nz
    return (az * ny + ay) * nx + ax if seen and inside else -1, sx, sy, sz


@compiled
def copy_column(target, m, source, first, n, shift):
    """target[m : m + n] = source[first : first + n] + shift; unsigned, to be vector code."""
    to, of = np.uintp(m), np.uintp(first)
    for k in range(np.uintp(n)):
        target[to + k] = source[of + k] + shift


@compiled
def copy_run(slots, block, signals, m, first, last, sx, sy, sz):
    """Copy slots first to last behind the m agents already in the block, shifted."""
    n = last - first
    if n <= FEW:
        for k in range(n):
            block[0, m + k] = slots.x[first + k] + sx
            block[1, m + k] = slots.y[first + k] + sy
            block[3, m + k] = slots.ux[first + k]
            block[4, m + k] = slots.uy[first + k]
            if slots.z.shape[0] > 0:
                block[2, m + k] = slots.z[first + k] + sz
                block[5, m + k] = slots.uz[first + k]
            if slots.speed.shape[0] > 0:
                block[9, m + k] = slots.speed[first + k]
            for q in range(signals.shape[0]):
                signals[q, m + k] = slots.signal[q, first + k]
        return m + n
    copy_column(block[0], m, slots.x, first, n, sx)
    copy_column(block[1], m, slots.y, first, n, sy)
    copy_column(block[3], m, slots.ux, first, n, 0.0)
    copy_column(block[4], m, slots.uy, first, n, 0.0)
    if slots.z.shape[0] > 0:
        copy_column(block[2], m, slots.z, first, n, sz)
        copy_column(block[5], m, slots.uz, first, n, 0.0)
    if slots.speed.shape[0] > 0:
        copy_column(block[9], m, slots.speed, first, n, 0.0)
    for q in range(signals.shape[0]):
        copy_column(signals[q], m, slots.signal[q], first, n, 0.0)
    return m + n


@compiled
def fill_block(grid, space, slots, cell, block, signals):
    """Copy the agents of the cells around `cell` into the block, shifted to the nearest image.

    Returns how many. Neighbouring cells along x are neighbours in memory too, so that away from
    the seam three of them are one run.
    """
    nx, ny = grid.shape[0], grid.shape[1]
    cx, cy, cz = cell % nx, (cell // nx) % ny, cell // (nx * ny)
    fx, mx = axis_cells(grid, space, 0, cx)
    fy, my = axis_cells(grid, space, 1, cy)
    fz, mz = axis_cells(grid, space, 2, cz)
    m = 0
    for kz in range(fz, fz + mz):
        az, sz = wrapped(grid, space, 2, cz + kz)
        for ky in range(fy, fy + my):
            ay, sy = wrapped(grid, space, 1, cy + ky)
            base = (az * ny + ay) * nx
            if cx + fx >= 0 and cx + fx + mx <= nx:
                first = grid.start[base + cx + fx]
                last = grid.start[base + cx + fx + mx]
                m = copy_run(slots, block, signals, m, first, last, 0.0, sy, sz)
            else:
                for kx in range(fx, fx + mx):
                    ax, sx = wrapped(grid, space, 0, cx + kx)
                    first, last = grid.start[base + ax], grid.start[base + ax + 1]
                    m = copy_run(slots, block, signals, m, first, last, sx, sy, sz)
    return m


@compiled
def nearest_images(space, grid, block, m, x, y, z, dim):
    """For axes of a single cell: bring every agent of the block to its image nearest to (x, y, z).

    The images stand in rows 6 to 8 of the block, where `NearClaim` reads positions.
    """
    for axis in range(dim):
        here = x if axis == 0 else (y if axis == 1 else z)
        length = space.size[axis]
        if space.images[axis] and grid.shape[axis] == 1:
            for j in range(m):
                d = block[axis, j] - here
                block[6 + axis, j] = here + (d - length * math.floor(d / length + 0.5))
        else:
            for j in range(m):
                block[6 + axis, j] = block[axis, j]
