"""Solid surfaces stop agents: no step crosses one, however long the step or thin the wall.

A step is followed from where it begins. Where it enters something solid the agent is put before the
surface and does what its body does there: it bounces off as light does off a mirror, slides along,
or stops. What is left of the step then goes on from there, to the next surface. A step that enters
nothing is left as it is, to the bit.
"""

from __future__ import annotations

import math

from agents.engine.block import BodyMove
from worlds.compilation import compiled, shared
from worlds.queries.crossing import first_crossing, is_far, skin
from worlds.queries.surroundings import signed_distance

PASSES, BOUNCES, SLIDES, STOPS = range(4)
"""What an agent does where its step enters something solid."""
MEETINGS = 32
"""Surfaces that an agent meets, and seams that it goes across, within one tick at most."""


@compiled
def keep_out_of_solids(surroundings, space, me, move, meets):
    """The move, with what leads through solids taken out of it."""
    dx, dy, dz = move.x - me.x, move.y - me.y, move.z - me.z
    if is_far(surroundings, me.x, me.y, me.z, math.sqrt(dx * dx + dy * dy + dz * dz)):
        return move
    return follow_surfaces(surroundings, space, me.x, me.y, me.z, move, meets)


@compiled
def to_seam(space, axis, x, d):
    """The share of a step d along an axis from x at which it goes across the seam, or 1."""
    if space.wraps[axis] == 0:
        return 1.0
    if d > 0.0 and x + d > space.size[axis]:
        return max((space.size[axis] - x) / d, 0.0)
    return max(-x / d, 0.0) if d < 0.0 and x + d < 0.0 else 1.0


@compiled
def across(space, axis, x, d, crosses):
    """The place along an axis, on the other side of the box if it `crosses` the seam there."""
    if not crosses:
        return x
    return 0.0 if d > 0.0 else space.size[axis]


@shared
def follow_surfaces(surroundings, space, ax, ay, az, move, meets):
    """The move from a, followed from surface to surface and from seam to seam.

    In what an agent cannot get out of in one tick it stays, and where even that would be inside,
    it is back where it was and has turned round.
    """
    x, y, z = ax, ay, az
    dx, dy, dz = move.x - ax, move.y - ay, move.z - az
    ux, uy, uz, speed = move.ux, move.uy, move.uz, move.speed
    hits, is_done = 0, False
    for _ in range(MEETINGS):
        px, py, pz = to_seam(space, 0, x, dx), to_seam(space, 1, y, dy), to_seam(space, 2, z, dz)
        part = min(px, min(py, pz))
        at = first_crossing(surroundings, x, y, z, part * dx, part * dy, part * dz)
        if at.share <= 1.0:
            hits += 1
            done_share = part * at.share
            x, y, z = x + done_share * dx, y + done_share * dy, z + done_share * dz
            off = skin(x, y, z)
            x, y, z = x + off * at.nx, y + off * at.ny, z + off * at.nz
            if meets == STOPS:
                speed = 0.0
                break
            gain = 2.0 if meets == BOUNCES else 1.0
            remaining_share = 1.0 - done_share
            dx, dy, dz = remaining_share * dx, remaining_share * dy, remaining_share * dz
            inward = gain * (dx * at.nx + dy * at.ny + dz * at.nz)
            dx, dy, dz = dx - inward * at.nx, dy - inward * at.ny, dz - inward * at.nz
            inward_step = min(off, max(0.0, dx * at.nx + dy * at.ny + dz * at.nz))
            dx, dy, dz = (
                dx - inward_step * at.nx,
                dy - inward_step * at.ny,
                dz - inward_step * at.nz,
            )
            inward = gain * min(0.0, ux * at.nx + uy * at.ny + uz * at.nz)
            ux, uy, uz = ux - inward * at.nx, uy - inward * at.ny, uz - inward * at.nz
            continue
        x, y, z = x + part * dx, y + part * dy, z + part * dz
        if not (part < 1.0):
            is_done = True
            break
        x = across(space, 0, x, dx, px == part)
        y = across(space, 1, y, dy, py == part)
        z = across(space, 2, z, dz, pz == part)
        remaining_share = 1.0 - part
        dx, dy, dz = remaining_share * dx, remaining_share * dy, remaining_share * dz
    if hits == 0 and is_done:
        return move
    if not (signed_distance(surroundings, x, y, z) >= 0.0):
        return BodyMove(ax, ay, az, -move.ux, -move.uy, -move.uz, 0.0)
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    if length < 1e-9:
        return BodyMove(x, y, z, move.ux, move.uy, move.uz, 0.0)
    if meets == SLIDES:
        speed *= length
    return BodyMove(x, y, z, ux / length, uy / length, uz / length, speed)


# Crashes: an agent that touches something falls, and lies where it comes to rest.

GRAVITY = 9.81
"""Acceleration of free fall, length/s^2."""


@compiled
def crash(flock, i, tick, cause):
    """Note when, by touching what and where the agent of row i crashed; it stops there."""
    flock.crash_record[i, 0] = tick
    flock.crash_record[i, 1] = cause
    for axis in range(flock.position.shape[1]):
        flock.crash_record[i, 2 + axis] = flock.position[i, axis]
    flock.speed[i] = 0.0


@compiled
def fall(flock, space, surroundings, i, lasts):
    """Free fall for a tick, to the floor or to what is solid below; nothing in two dimensions.

    `flock.speed` is the speed of the fall, and 0 for one that lies.
    """
    if flock.position.shape[1] == 2:
        return
    x, y, z = flock.position[i, 0], flock.position[i, 1], flock.position[i, 2]
    speed = flock.speed[i] + GRAVITY * lasts
    lowest = max(z - speed * lasts, min(z, space.floor))
    is_on_floor = lowest <= space.floor
    if surroundings.solids > 0 and signed_distance(surroundings, x, y, lowest) < 0.0:
        # It sinks into a block at most as far as a crash has brought it there.
        is_free = signed_distance(surroundings, x, y, z) >= 0.0
        lowest = resting_height(surroundings, x, y, z, lowest) if is_free else lowest
        is_on_floor = is_on_floor or is_free
    flock.position[i, 2] = lowest
    flock.speed[i] = 0.0 if is_on_floor else speed


@compiled
def resting_height(surroundings, x, y, high, low):
    """The least height, from `high` down to `low`, at which nothing solid is entered yet."""
    while high - low > 1e-3 * (1.0 + math.fabs(high)):
        middle = 0.5 * (high + low)
        if signed_distance(surroundings, x, y, middle) < 0.0:
            low = middle
        else:
            high = middle
    return high
