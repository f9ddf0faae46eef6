"""What a bird of an echelon wishes, bird by bird, without noise and in open space.

Source: the docstrings of the model `echelon`; zones after Couzin et al. 2002, (1) to (3).
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Numbers:
    """The model's parameters; angles in degrees, lengths in metres."""

    d_r: float = 1.8
    d_o: float = 12.0
    d_a: float = 20.0
    alpha: float = 240.0
    climb: float = 15.0
    w: float = 1.0
    drop: float = 0.94
    tip: float = -0.137
    step: float = 0.8
    t_c: float = 1.5
    c: float = 1.5
    b: float = 2.5
    v0: float = 3.5


def unit(vector, otherwise):
    """The vector at length 1; `otherwise` if it has none."""
    length = np.linalg.norm(vector)
    return vector / length if length > 1e-12 else otherwise


def angle(one, other):
    """The angle between two vectors, deg."""
    cosine = one @ other / np.linalg.norm(one) / np.linalg.norm(other)
    return math.degrees(math.acos(min(1.0, max(-1.0, cosine))))


def zones(i, position, heading, p):
    """Sums over the zones of repulsion, orientation and attraction."""
    sums = np.zeros((3, 3))
    close = False
    for j in range(len(position)):
        gap = position[j] - position[i]
        d = np.linalg.norm(gap)
        if j == i:
            continue
        if d < p.d_r:
            sums[0] -= gap / d
            close = True
        elif d <= max(p.d_o, p.d_a) and angle(heading[i], gap) <= p.alpha / 2:
            if d < p.d_o:
                sums[1] += heading[j]
            elif d <= p.d_a:
                sums[2] += gap / d
    return sums, close


def slots(i, position, heading, p):
    """Places beside the birds that may be followed, as (distance, bird, place), nearest first."""
    found = []
    for j in range(len(position)):
        gap = position[j] - position[i]
        if j == i or np.linalg.norm(gap) > p.d_a or gap @ heading[j] <= 0.0:
            continue
        if angle(heading[i], heading[j]) > 45.0 or angle(heading[i], gap) > p.alpha / 2:
            continue
        right = np.cross(heading[j], [0.0, 0.0, 1.0])
        right = right / np.linalg.norm(right)
        for side in (-1.0, 1.0):
            place = position[j] - p.step * p.b * heading[j] + side * (1 + p.tip) * p.b * right
            found.append((np.linalg.norm(place - position[i]), j, place))
    return sorted(found, key=lambda one: one[0])


def free(i, slot, position, heading, p):
    """Whether nobody nearer has the slot, and it does not lie in anybody's downwash."""
    distance, ahead, place = slot
    for k in range(len(position)):
        if k in (i, ahead):
            continue
        away = np.linalg.norm(place - position[k])
        if away < 0.6 * p.b and away < distance:
            return False
        behind = (position[k] - place) @ heading[k]
        off = np.linalg.norm(place - position[k] + behind * heading[k])
        if 0.0 < behind < 4.0 * p.b and off < 0.6 * p.b:
            return False
    return True


def wish(i, position, heading, speed, p):
    """The velocity (3,) that bird i wishes for."""
    (away, along, towards), close = zones(i, position, heading, p)
    wanted = p.v0 * unit(away if close else along + towards, heading[i])
    if not close and p.w > 0.0:
        there = slots(i, position, heading, p)
        best = next((one for one in there if free(i, one, position, heading, p)), None)
        if best is not None:
            distance, ahead, place = best
            nearer = min(distance / p.t_c, p.c) * unit(place - position[i], 0.0 * place)
            other = speed[ahead] * heading[ahead] + nearer
        elif there:
            other = p.drop * p.v0 * unit(along + heading[i], heading[i])
        if there:
            wanted = (1.0 - p.w) * wanted + p.w * other
    pace = np.linalg.norm(wanted)
    way = unit(wanted, heading[i])
    steep = math.tan(math.radians(p.climb)) * np.linalg.norm(way[:2])
    way[2] = min(max(way[2], -steep), steep)
    return pace * way
