"""Sheep and wolves, and others whom neither knows: agent by agent, in plain loops.

Each takes the mean heading of its own kind within r, itself among them. A sheep adds `fear` times
the unit vector away from each wolf within r, a wolf `hunger` times that towards each sheep. Others
(any kind beyond) meet nobody but their own.
"""

import numpy as np

SHEEP, WOLF = 0, 1


def wish(i, own, told, kind, r, fear, hunger, size):
    """What agent i wants: `own` = (place, heading) of it now, `told` of all as it knows them."""
    place, total = own[0], np.array(own[1])
    count, push = 1, np.zeros(len(place))
    for j, (there, heading) in enumerate(told):
        away = there - place
        away = away - size * np.round(away / size)
        distance = float(np.sqrt((away**2).sum()))
        if j == i or distance == 0.0 or distance > r:
            continue
        if kind[j] == kind[i]:
            total = total + heading
            count += 1
        elif (kind[i], kind[j]) == (SHEEP, WOLF):
            push = push - fear * away / distance
        elif (kind[i], kind[j]) == (WOLF, SHEEP):
            push = push + hunger * away / distance
    return total / count + push


def run(position, heading, kind, v0, r, fear, hunger, size, ticks, turns=None, delay=0):
    """Where all are and head after some ticks, (N, dim) each: at once, by `turns` in an order of
    rows, or knowing of others what was `delay` ticks ago."""
    position, heading = position.copy(), heading.copy()
    past = [(position.copy(), heading.copy())]
    for tick in range(ticks):
        before = past[max(0, tick - delay)]
        next_position, next_heading = position.copy(), heading.copy()
        for i in range(len(position)) if turns is None else turns:
            source = before if turns is None else (next_position, next_heading)
            told = list(zip(*source, strict=True))
            want = wish(i, (position[i], heading[i]), told, kind, r, fear, hunger, size)
            length = np.sqrt((want**2).sum())
            next_heading[i] = want / length if length > 1e-12 else heading[i]
            next_position[i] = (position[i] + v0 * next_heading[i]) % size
        position, heading = next_position, next_heading
        past.append((position.copy(), heading.copy()))
    return position, heading
