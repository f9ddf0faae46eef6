"""Where in a group agents are, agent by agent, and rank correlations by counting.

Couzin et al. 2002 look for a correlation of what agents differ in with where they are; the rank
correlation is Spearman's (1904).
"""

import math


def largest_group(position, reach):
    """The rows of the largest set of agents (N, dim) linked by steps of up to `reach`."""
    left, best = set(range(len(position))), []
    while left:
        group, frontier = [], [min(left)]
        left.discard(frontier[0])
        while frontier:
            i = frontier.pop()
            group.append(i)
            near = [j for j in left if math.dist(position[i], position[j]) <= reach]
            left.difference_update(near)
            frontier.extend(near)
        if len(group) > len(best):
            best = sorted(group)
    return best


def mean_places(looks, reach):
    """Mean distance to the centre and mean place along the heading, of agents in half of the looks.

    `looks` are pairs (position, heading), each (N, dim); a dictionary row -> (distance, place).
    """
    found = {}
    for position, heading in looks:
        group = largest_group(position, reach)
        centre = sum(position[i] for i in group) / len(group)
        total = sum(heading[i] for i in group)
        ahead = total / math.sqrt(total @ total)
        for i in group:
            offset = position[i] - centre
            found.setdefault(i, []).append((math.sqrt(offset @ offset), offset @ ahead))
    return {
        i: tuple(sum(values) / len(values) for values in zip(*seen, strict=True))
        for i, seen in found.items()
        if len(seen) >= 0.5 * len(looks)
    }


def ranks(values):
    """The rank of each value, from 1 on; equal ones share the mean of theirs."""
    return [
        sum(other < value for other in values) + 0.5 * (1 + sum(other == value for other in values))
        for value in values
    ]


def rank_correlation(first, second):
    """Spearman's: Pearson's correlation of the ranks."""
    a, b = ranks(first), ranks(second)
    a = [x - sum(a) / len(a) for x in a]
    b = [x - sum(b) / len(b) for x in b]
    products = [sum(x * y for x, y in zip(*pair, strict=True)) for pair in ((a, b), (a, a), (b, b))]
    return products[0] / math.sqrt(products[1] * products[2])
