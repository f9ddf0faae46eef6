"""One step of the models of Vicsek et al. 1995 and of Gregoire and Chate 2004, agent by agent.

Vicsek, Czirok, Ben-Jacob, Cohen and Shochet, PRL 75, 1226: (1) x(t+1) = x(t) + v(t), with the old
velocity; (2) the angle of the sum of the headings within r, the agent's own among them, and a
uniform angle of [-eta/2, eta/2]. Gregoire and Chate, PRL 92, 025702: to the sum over the n agents
within r a vector of length eta n is added, and the step goes along the new heading. Two agents in
one spot do not count each other, as everywhere in this house.
"""

import numpy as np

from .topology import contact

LOST = 1e-12  # a sum shorter than this share of n has no direction: the heading is kept


def summed(heading, touch, i):
    """Sum of the headings (dim,) of agent i and those that it touches, and how many they are."""
    rows = [i, *np.flatnonzero(touch[i])]
    return sum(heading[j] for j in rows), len(rows)


def new_headings(position, heading, informed, r, size, edges, turn=None, push=None):
    """Headings (N, dim) after the turn by `turn` (N,), rad, or with the vectors `push` (N, dim).

    Each of `push` is eta times a unit vector; it is added once for each agent of the sum.
    Information agents keep theirs.
    """
    touch = contact(position, r, size, edges)
    found = heading.copy()
    for i in range(len(heading)):
        if informed[i]:
            continue
        total, n = summed(heading, touch, i)
        if push is not None:
            total = total + n * push[i]
        length = np.linalg.norm(total)
        direction = heading[i] if length < LOST * n else total / length
        if turn is not None:
            c, s = np.cos(turn[i]), np.sin(turn[i])
            direction = np.array([[c, -s], [s, c]]) @ direction
        found[i] = direction
    return found


def into_box(position, size, edges):
    """Positions put back into the box, if it wraps."""
    return position if edges == "open" else np.mod(position, size)


def step_1995(position, heading, informed, r, v, size, edges, turn=None):
    """Positions and headings at t + 1: everyone goes on as it was heading, and turns."""
    found = new_headings(position, heading, informed, r, size, edges, turn)
    return into_box(position + v * heading, size, edges), found


def step_2004(position, heading, informed, r, v, size, edges, push):
    """Positions and headings at t + 1: everyone turns, and goes that way."""
    found = new_headings(position, heading, informed, r, size, edges, push=push)
    return into_box(position + v * found, size, edges), found
