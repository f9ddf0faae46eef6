"""Keep the flock's past, from which messages tell: how old they are, and how exact.

Every tick each agent tells all others where it is, where it heads, how fast it is, and its signals.
A message takes the delay and, on top, a time that is exponentially distributed; some get lost. What
an agent knows of another is the newest message, by when it was sent, that has come by now. Draws
are hashes of (seed, tick of sending, receiver, sender). Where it takes the other to be may be off
from what the message says: by a draw of its own for each tick and each pair.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agents.engine.noise import GOLDEN, S11, cos_sin, log, mix, tick_key
from agents.engine.vector_lanes import as_float, as_unsigned
from worlds.compilation import compiled

BEGINS = math.nan
"""In the past of an agent that has none yet."""
LATE = np.uint64(0x6C61746500000000)
ASIDE = np.uint64(0x6173696465000000)
"""Tells the draws of places from those of messages."""
FURTHEST = 4.0
"""Standard deviations that a place is off at most, along each axis: cells must be wide enough."""


class MessageDelays(NamedTuple):
    """How old messages get, in ticks."""

    delay: int
    """The least age."""
    jitter: float
    """Mean of what comes on top."""
    loss: float
    """Share that gets lost."""
    error: float
    """Standard deviation of a place that is told, along each axis, length."""


@compiled
def place_error(seed, tick, receiver, sender, axis):
    """How far a receiver takes a sender to be off at a tick along an axis: a normal number, cut."""
    key = mix((tick_key(seed, tick) ^ ASIDE) + as_unsigned(sender) * GOLDEN)
    counter = as_unsigned(receiver) * np.uint64(6) + np.uint64(2 * axis)
    first = as_float(mix(key + counter * GOLDEN) >> S11) * 2.0**-53
    second = as_float(mix(key + (counter + np.uint64(1)) * GOLDEN) >> S11) * 2.0**-53
    c, _ = cos_sin(2.0 * math.pi * second)
    return max(-FURTHEST, min(FURTHEST, math.sqrt(-2.0 * log(1.0 - first)) * c))


@compiled
def message_draw(seed, sent, receiver, sender, draw):
    """A number uniform in [0, 1) for the message of a pair of agents that was sent at a tick."""
    key = mix((tick_key(seed, sent) ^ LATE) + as_unsigned(sender) * GOLDEN)
    counter = as_unsigned(receiver) * np.uint64(2) + np.uint64(draw)
    return as_float(mix(key + counter * GOLDEN) >> S11) * 2.0**-53


@compiled
def age_of(messages, seed, tick, receiver, sender, ages):
    """Ticks since the newest message that has come from a sender; `ages` if none has.

    Before tick 0 agents stood where they began, and everybody knew.
    """
    if messages.jitter == 0.0 and messages.loss == 0.0:
        return min(messages.delay, ages - 1)
    for age in range(messages.delay, ages):
        sent = tick - age
        if sent <= 0:
            return age
        if messages.loss > 0.0 and message_draw(seed, sent, receiver, sender, 0) < messages.loss:
            continue
        if messages.jitter == 0.0:
            return age
        jitter_delay = -messages.jitter * log(1.0 - message_draw(seed, sent, receiver, sender, 1))
        if math.floor(messages.delay + jitter_delay + 0.5) <= age:
            return age
    return ages


@compiled
def note_present(flock, tick):
    """Write the flock as it stands into its past; one that has none has always stood there."""
    past = flock.past
    n, ages, size = past.shape
    dim = flock.position.shape[1]
    at = tick % ages
    for i in range(n):
        new = math.isnan(past[i, (tick + ages - 1) % ages, 0])
        for axis in range(dim):
            past[i, at, axis] = flock.position[i, axis]
            past[i, at, dim + axis] = flock.heading[i, axis]
        past[i, at, 2 * dim] = flock.speed[i]
        for k in range(size - 2 * dim - 1):
            past[i, at, 2 * dim + 1 + k] = flock.memory[k, i]
        if new:
            for age in range(ages):
                for c in range(size):
                    past[i, age, c] = past[i, at, c]
