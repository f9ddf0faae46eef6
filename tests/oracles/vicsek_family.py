"""One step of VEM, VEM-A, IVEM, IVEM-A, WVEM and HWVEM, agent by agent.

Source: Liu et al., Aerospace 2021, 8, 286, sections 2.2 and 3.1.2, with the choices that
reproduce its table 1: atan2; VEM and VEM-A average over the neighbours and the agent itself, the
others leave it out; no neighbours, or none that counts, keeps the heading. Information agents obey
neither rule nor noise: they keep their heading, and move and wrap like the others.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from .topology import contact, layers, next_layer, next_layers

MODELS = ("vem", "vem-a", "ivem", "ivem-a", "wvem", "hwvem")
VANISHING = 1e-12  # a mean heading shorter than this has no direction: the agent keeps its own


@dataclass(frozen=True)
class State:
    """A flock at one instant."""

    position: np.ndarray  # (N, dim)
    heading: np.ndarray  # (N, dim), unit vectors
    layer: np.ndarray  # (N,) int: l_i(k); N + 1 = unknown
    informed: np.ndarray  # (N,) bool


@dataclass(frozen=True)
class Parameters:
    """The papers' symbols and values."""

    r: float = 1.0
    v0: float = 0.03
    eta: float = 0.0  # only read by the vectorial noise; the angular noise comes in as `turn`
    p1: float = 0.1
    p2: float = 5.0
    k_alpha: float = 30.0
    k_beta: float = 18.0
    k_gamma: float = 1.0
    k_iu: float = 100.0
    layers: str = "delayed"  # or "instant"
    neighbourhood_weight: bool = True


def begin(position, heading, informed, parameters, size, edges):
    """The state at k = 0, its layers searched breadth first."""
    touch = contact(position, parameters.r, size, edges)
    return State(position, heading, layers(touch, informed), informed)


def hwvem_weights(i, layer, touch, p):
    """c_ij of equations (13) to (17) for all j, (N,): layer j's weight, not layer i's.

    The factor p2 ** l_min is common to all and only keeps large p2 from underflowing.
    """
    n = len(layer)
    weight = np.zeros(n)
    neighbours = [j for j in range(n) if touch[i, j]]
    known = [j for j in neighbours if layer[j] <= n]
    if not known:
        return weight
    l_min = min(layer[j] for j in known)
    for j in known:
        w_abs = 1 / layer[j] + p.p1  # (14)
        w_rel = p.p2 ** float(l_min - layer[j])  # (15)
        d = len(neighbours) / sum(layer[m] == layer[j] for m in neighbours)  # (16)
        w_nei = math.log(d) if p.neighbourhood_weight and d > math.e else 1.0  # (17)
        weight[j] = w_abs * w_rel * w_nei
    return weight


def wvem_weights(i, layer, touch, p):
    """30 for an information agent (layer 1), 18 in direct contact with one (layer 2), else 1."""
    k = {1: p.k_alpha, 2: p.k_beta}
    return np.array([k.get(layer[j], p.k_gamma) if touch[i, j] else 0.0 for j in range(len(layer))])


def weights(model, i, layer, touch, informed, p):
    """h_ij of equation (10) for all j, (N,), of the models that average."""
    if model in ("vem", "vem-a"):
        weight = touch[i].astype(float)
        weight[i] = 1.0
        return weight
    if model == "ivem-a":
        return np.where(touch[i], np.where(informed, p.k_iu, 1.0), 0.0)
    if model == "wvem":
        return wvem_weights(i, layer, touch, p)
    if model == "hwvem":
        return hwvem_weights(i, layer, touch, p)
    raise ValueError(f"model = {model!r} does not average")


def angle(heading):
    """Angle of a planar heading in [0, 2 pi), rad."""
    theta = math.atan2(heading[1], heading[0]) % math.tau
    return 0.0 if theta >= math.tau else theta


def unit(theta):
    """The planar heading at angle theta (rad)."""
    return np.array([math.cos(theta), math.sin(theta)])


def ivem_angle(i, heading, touch):
    """Equations (30, 31) on raw angles in [0, 2 pi); the agent itself is left out."""
    theta = [angle(u) for u in heading]
    around = [theta[j] for j in range(len(theta)) if touch[i, j]]
    if not around:
        return theta[i]
    low, high = min(around), max(around)
    if theta[i] <= low:
        return theta[i] + (high - low) / 2
    if theta[i] >= high:
        return theta[i] - (high - low) / 2
    return theta[i]


def wish(model, i, state, layer, touch, p):
    """What the rule wants of agent i before noise, (dim,).

    The weighted mean of the headings it sees (length 0 to 1), its own heading if none counts;
    for IVEM, and IVEM-A away from the information agents, the unit vector at its new angle.
    """
    meets_informed = (touch[i] & state.informed).any()
    if model == "ivem" or (model == "ivem-a" and not meets_informed):
        return unit(ivem_angle(i, state.heading, touch))
    weight = weights(model, i, layer, touch, state.informed, p)
    if weight.sum() == 0:
        return state.heading[i]
    return (weight[:, None] * state.heading).sum(axis=0) / weight.sum()


def next_heading(model, i, state, layer, touch, p, turn=None, xi=None):
    """Equations (6), (9): the heading of agent i at k + 1, (dim,).

    `turn` (N,) is the angular noise in rad (2-D), added after the rule's decision; `xi` (N, dim)
    are the unit vectors of the vectorial noise (Gregoire & Chate, PRL 92, 025702, 2004), of
    which eta is added to the mean.
    """
    if state.informed[i]:
        return state.heading[i]
    direction = wish(model, i, state, layer, touch, p)
    if xi is not None:
        direction = direction + p.eta * xi[i]
    length = math.sqrt((direction**2).sum())
    direction = state.heading[i] if length < VANISHING else direction / length
    if turn is not None:
        direction = unit(math.atan2(direction[1], direction[0]) + turn[i])
    return direction


def moved(position, heading, v0, size, edges):
    """Equations (7, 8): x(k+1) = x(k) + v0 heading(k+1), put back into [0, size) if it wraps."""
    position = position + v0 * heading
    if edges == "open":
        return position
    position = np.mod(position, size)
    return np.where(position >= size, 0.0, position)


def searches(model, p):
    """Whether layers are those of the positions at k, found anew each tick, and not carried."""
    return model == "wvem" or p.layers == "instant"


def step(model, state, parameters, size, edges, turn=None, xi=None):
    """All agents at once: everything at k + 1 from the state at k.

    `delayed` layers are those the state carries; the new state carries l(k+1) by equation (5), or
    by a search on the new positions for models that search.
    """
    p = parameters
    touch = contact(state.position, p.r, size, edges)
    layer = layers(touch, state.informed) if searches(model, p) else state.layer
    heading = np.array(
        [
            next_heading(model, i, state, layer, touch, p, turn, xi)
            for i in range(len(state.informed))
        ]
    )
    position = moved(state.position, heading, p.v0, np.asarray(size, dtype=float), edges)
    if searches(model, p):
        layer = layers(contact(position, p.r, size, edges), state.informed)
    else:
        layer = next_layers(layer, touch, state.informed)
    return State(position, heading, layer, state.informed)


def step_sequentially(model, state, order, parameters, size, edges, turn=None, xi=None):
    """One agent after another in `order`, each seeing where those before it are by now.

    What takes a search through the whole flock is found once, before the first agent acts.
    """
    p = parameters
    size = np.asarray(size, dtype=float)
    state = replace(
        state,
        position=state.position.copy(),
        heading=state.heading.copy(),
        layer=state.layer.copy(),
    )
    if searches(model, p):
        state.layer[:] = layers(contact(state.position, p.r, size, edges), state.informed)
    for i in order:
        touch = contact(state.position, p.r, size, edges)
        heading = next_heading(model, i, state, state.layer, touch, p, turn, xi)
        if not searches(model, p):
            state.layer[i] = next_layer(i, state.layer, touch, state.informed)
        state.heading[i] = heading
        state.position[i] = moved(state.position[i], heading, p.v0, size, edges)
    if searches(model, p):
        state.layer[:] = layers(contact(state.position, p.r, size, edges), state.informed)
    return state
