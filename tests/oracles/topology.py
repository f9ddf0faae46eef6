"""Who is in contact with whom, and how far each agent is from the information agents.

Source: Liu et al., Aerospace 2021, 8, 286, section 2.1. `edges` is what the border of the box
does: "wrap" (positions wrap, distances go to the nearest image), "wrap-plain" (positions wrap,
distances do not: what the paper's tables need) or "open" (no border).
"""

import numpy as np

EDGES = ("wrap", "wrap-plain", "open")


def offsets(position, size, edges):
    """x_j - x_i for every pair as seen by i: (N, N, dim), in the unit of `position` (N, dim)."""
    if edges not in EDGES:
        raise ValueError(f"edges = {edges!r} is none of {EDGES}")
    offset = position[None, :, :] - position[:, None, :]
    if edges == "wrap":
        size = np.asarray(size, dtype=float)
        offset = offset - size * np.round(offset / size)
    return offset


def distances(position, size, edges):
    """|x_i - x_j| for every pair: (N, N)."""
    return np.sqrt((offsets(position, size, edges) ** 2).sum(axis=2))


def contact(position, r, size, edges):
    """a_ij of equation (11), (N, N) bool: 0 < |x_i - x_j| <= r."""
    distance = distances(position, size, edges)
    return (distance > 0) & (distance <= r)


def layers(touch, informed):
    """Layers (2, 3, 4) by breadth-first search, (N,) int.

    Information agents are layer 1, agents no chain of contacts leads to are N + 1 = unknown.
    """
    n = len(informed)
    layer = np.full(n, n + 1)
    front = [i for i in range(n) if informed[i]]
    for i in front:
        layer[i] = 1
    while front:
        reached = []
        for i in front:
            for j in range(n):
                if touch[i, j] and layer[j] == n + 1:
                    layer[j] = layer[i] + 1
                    reached.append(j)
        front = reached
    return layer


def next_layer(i, layer, touch, informed):
    """l_i(k+1) of equation (5) from the layers and the contacts at k, capped at N + 1."""
    n = len(informed)
    if informed[i]:
        return 1
    heard = [layer[j] + 1 for j in range(n) if touch[i, j]]
    return min([*heard, n + 1])


def next_layers(layer, touch, informed):
    """Equation (5) for all agents at once: (N,) int."""
    return np.array([next_layer(i, layer, touch, informed) for i in range(len(informed))])
