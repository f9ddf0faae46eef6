"""What agents know of each other when messages take time, from a list of all states so far.

Each tick every agent sends its state to every other. A message takes `delay` ticks and on top an
exponentially distributed time of mean `jitter` ticks, rounded; a share `loss` gets lost. The newest
one, by sending, that has come is what is known. Before tick 0 all stood where they began.
"""

import math
from dataclasses import replace

import numpy as np

from . import noise as hashing
from . import vicsek_family as family
from .topology import contact

LATE = 0x6C61746500000000
ASIDE = 0x6173696465000000


def drawn(seed, sent, receiver, sender, draw):
    """A float in [0, 1) for the message of a pair that was sent at a tick."""
    key = hashing.mix((hashing.key(seed, sent) ^ LATE) + sender * hashing.G)
    return (hashing.mix(key + (receiver * 2 + draw) * hashing.G) >> 11) * 2.0**-53


def comes_after(seed, sent, receiver, sender, delay, jitter, loss):
    """Ticks that a message takes; infinite if it gets lost."""
    if loss and drawn(seed, sent, receiver, sender, 0) < loss:
        return math.inf
    more = -jitter * math.log(1 - drawn(seed, sent, receiver, sender, 1)) if jitter else 0.0
    return math.floor(delay + more + 0.5)


def known_at(now, seed, receiver, sender, delay, jitter, loss):
    """The tick at which the sender was as the receiver knows it."""
    for sent in range(now - delay, 0, -1):
        if sent + comes_after(seed, sent, receiver, sender, delay, jitter, loss) <= now:
            return sent
    return 0


def off_place(seed, now, receiver, sender, axis):
    """How far off a receiver takes a sender to be, in standard deviations (Box and Muller)."""
    key = hashing.mix((hashing.key(seed, now) ^ ASIDE) + sender * hashing.G)
    first, second = (
        (hashing.mix(key + (receiver * 6 + 2 * axis + k) * hashing.G) >> 11) * 2.0**-53
        for k in (0, 1)
    )
    normal = math.sqrt(-2 * math.log(1 - first)) * math.cos(2 * math.pi * second)
    return max(-4.0, min(4.0, normal))


def taken_places(told, i, ids, seed, tick, error):
    """Where agent i takes all to be, (N, dim): as told, off by the error; itself where it is."""
    places = np.array([told[j].position[j] for j in range(len(ids))])
    for j in range(len(ids)):
        if j != i:
            for axis in range(places.shape[1]):
                places[j, axis] += error * off_place(seed, tick, int(ids[i]), int(ids[j]), axis)
    return places


def step(model, states, ids, seed, late, parameters, size, edges, turn=None, error=0.0):
    """The state after the last of `states`; `late` = (delay, jitter, loss), in ticks.

    `error`: standard deviation of the places of others, along each axis.
    """
    p, now = parameters, states[-1]
    n, tick = len(now.informed), len(states) - 1
    headings, layer = [], []
    for i in range(n):
        told = [states[known_at(tick, seed, int(ids[i]), int(j), *late)] for j in ids]
        told[i] = now
        sight = replace(
            now,
            position=taken_places(told, i, ids, seed, tick, error),
            heading=np.array([told[j].heading[j] for j in range(n)]),
            layer=np.array([told[j].layer[j] for j in range(n)]),
        )
        touch = contact(sight.position, p.r, size, edges)
        headings.append(family.next_heading(model, i, sight, sight.layer, touch, p, turn))
        layer.append(family.next_layer(i, sight.layer, touch, now.informed))
    position = family.moved(
        now.position, np.array(headings), p.v0, np.asarray(size, dtype=float), edges
    )
    return family.State(position, np.array(headings), np.array(layer), now.informed)
