"""HWVEM: neighbours weigh by their layer below the information UAV (Liu et al. 2021, 2.1, 2.2).

Printed with the index i, the weights (14) and (15) are those of the neighbour j, as the text around
them says and as the results of table 1 need. A neighbour of unknown layer weighs 0.
"""

from __future__ import annotations

import math
from typing import Literal

from agents.engine.block import Decision, adjacent, is_neighbour, neighbour_of
from agents.engine.eight_others import across, eight_from, is_there, least, no_lanes, width
from agents.engine.neighbour_search import UNKNOWN, next_layer, search_layers
from agents.engine.vector_lanes import where
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.vicsek import Vicsek
from worlds.compilation import compiled

LAYER = 0
INSTANT = 1.0
"""Index of `instant` among the choices of `layers`."""


class HierarchicalWeighting(Vicsek):
    """Parameters of HWVEM."""

    p1: float = parameter(
        0.1,
        "Evens out the absolute layer weight 1/l + p1: the larger, the less the layer counts",
        words="Evening out of the layers",
        symbol="p_1",
        low=0.0,
        high=2.0,
        step=0.05,
        source="Liu et al. 2021, (14)",
    )
    p2: float = parameter(
        5.0,
        "How many times more a neighbour weighs than one a layer further from the information UAV",
        words="Weight from layer to layer",
        symbol="p_2",
        low=1.0,
        high=100.0,
        step=0.5,
        source="Liu et al. 2021, (15)",
    )
    neighbourhood_weight: bool = parameter(
        True,
        "Whether a neighbour counts more when few of the neighbours share its layer",
        words="Neighbourhood weight",
        symbol="w^{nei}",
        source="Liu et al. 2021, (16), (17); figure 6",
    )
    layers: Literal["delayed", "instant"] = parameter(
        "delayed",
        "Whether word of the layers spreads one hop per tick (5), or is known at once (4)",
        words="Layers",
        symbol="l",
        source="Liu et al. 2021, (4), (5)",
    )


@compiled
def contribution(layer, nearest, neighbours, alike, p):
    """c_ij (13) of a neighbour: absolute (14), relative (15) and neighbourhood (16), (17) weight.

    `nearest` is the least layer among the neighbours: dividing by p2**-nearest leaves the mean as
    it is and keeps large p2 from underflowing. `alike` of the `neighbours` share the layer.
    """
    status = neighbours / alike
    nei = math.log(status) if p.neighbourhood_weight > 0.0 and status > math.e else 1.0
    return (1.0 / layer + p.p1) * p.p2 ** (nearest - layer) * nei


@compiled
def survey_neighbours(me, near, r):
    """Over the neighbours: the least layer, UNKNOWN without any, and how many they are."""
    count, lowest_layer = no_lanes(), no_lanes() + UNKNOWN
    for first in range(0, near.n, width()):
        j = eight_from(first, near.n)
        is_near = is_there(j) & is_neighbour(neighbour_of(me, near, j), r)
        count += where(is_near, 1.0, 0.0)
        lowest_layer = min(lowest_layer, where(is_near, near.signal[LAYER, j], UNKNOWN))
    return least(lowest_layer), across(count)


@compiled
def sum_layer(me, near, current, r):
    """Over the neighbours of the layer `current`: the sum of the headings (x, y, z) of those that
    are heard, how many these are, and how many all; and the next layer that there is, or UNKNOWN.
    """
    x, y, z, heard, alike = no_lanes(), no_lanes(), no_lanes(), no_lanes(), no_lanes()
    following = no_lanes() + UNKNOWN
    for first in range(0, near.n, width()):
        j = eight_from(first, near.n)
        other, layer = neighbour_of(me, near, j), near.signal[LAYER, j]
        is_near = is_there(j) & is_neighbour(other, r)
        following = min(following, where(is_near & (layer > current), layer, UNKNOWN))
        is_alike = is_near & (layer == current)
        counts = where(is_alike & other.heard, 1.0, 0.0)
        x += counts * other.ux
        y += counts * other.uy
        z += counts * other.uz
        heard += counts
        alike += where(is_alike, 1.0, 0.0)
    sums = across(x), across(y), across(z), across(heard), across(alike)
    return sums, least(following)


@compiled
def decide(me, near, surroundings, p):
    """Weighted mean heading of the neighbours (9), (18), summed layer by layer."""
    nearest, neighbours = survey_neighbours(me, near, p.r)
    x = y = z = total = 0.0
    current = nearest
    while current < UNKNOWN:
        (sx, sy, sz, heard, alike), following = sum_layer(me, near, current, p.r)
        c = contribution(current, nearest, neighbours, alike, p)
        x += c * sx
        y += c * sy
        z += c * sz
        total += c * heard
        current = following
    if total == 0.0:
        return Decision(0.0, 0.0, 0.0)
    return Decision(x / total, y / total, z / total)


@compiled
def prepare(flock, space, grid, slots, p, tick):
    """Layers by search: at the first tick, and at every tick if they are known at once."""
    if tick == 0 or p.layers == INSTANT:
        search_layers(flock, space, grid, slots, p.r, LAYER, slots.row.shape[0] + 1)


@compiled
def remember(me, near, p, out):
    """Layers spread by one hop per tick: (5)."""
    if p.layers != INSTANT:
        out[LAYER] = next_layer(me, near, p.r, LAYER)


@compiled
def weigh(me, near, p, out):
    """Weights h_ij (10) of the agents of the block."""
    layer = near.signal[LAYER]
    nearest, neighbours = survey_neighbours(me, near, p.r)
    for j in range(near.n):
        alike = 0.0
        for n in range(near.n):
            alike += adjacent(me, near, n, p.r) if layer[n] == layer[j] else 0.0
        out[j] = 0.0
        if adjacent(me, near, j, p.r) > 0.0 and layer[j] < UNKNOWN:
            out[j] = near.heard[j] * contribution(layer[j], nearest, neighbours, alike, p)


HWVEM = Rule(
    name="hwvem",
    title="Hierarchical weighting Vicsek model",
    summary="Neighbours count by how few hops they are from the information UAV, so that its "
    "heading runs through the flock layer by layer.",
    equation=r"\theta_i(k+1) = \operatorname{atan2}\Big(\sum_{j \in \mathcal{N}_i} h_{ij}"
    r"\sin\theta_j, \sum_{j \in \mathcal{N}_i} h_{ij}\cos\theta_j\Big) + \Delta\theta_i, \qquad "
    r"h_{ij} = \Big(\frac{1}{l_j} + p_1\Big)\, p_2^{-l_j}\, \max(1, \ln d_{ij})",
    source="Liu et al. 2021, (5), (9) to (17)",
    checked="time to align at N = 100 {liu2021-table1/hwvem/100/k_con}, at 200 "
    "{liu2021-table1/hwvem/200/k_con}: `flockscope paper liu2021-table1`; success on a "
    "mission of 50 UAVs {liu2021-table2/HWVEM-II/50/success}: `flockscope paper "
    "liu2021-table2`",
    tags=("robotics", "classroom", "UAV", "leader", "hierarchy", "information", "swarm"),
    parameters=HierarchicalWeighting,
    decide=decide,
    sifts=True,
    signals=("layer",),
    words={"layer": "layer (leader: 1)"},
    prepare=prepare,
    remember=remember,
    weigh=weigh,
    informed=1,
    converges=True,
    tries=(
        LessonStep(
            "Take a thousand agents that do not heed layers: p2 = 1.",
            "The heading of the information agent no longer runs through the flock: at tick 30 "
            "there are patches of every heading, where with p2 = 5 all thousand would agree.",
            {"agents": 1000, "p2": 1.0},
            LessonCheck("polarisation", "below", 0.9, 30),
            anew=True,
        ),
        LessonStep(
            "Take the information agent away.",
            "Nobody turns: without anybody who knows the heading there are no layers, and "
            "without layers nobody is listened to.",
            {"informed": 0},
            LessonCheck("polarisation", "below", 0.4, 15),
            anew=True,
        ),
        LessonStep(
            "Raise the noise to 5.5 rad, nearly a full turn.",
            "The flock becomes a crowd within a few ticks. Take it back, and the layers put it "
            "right again just as fast.",
            {"eta": 5.5},
            LessonCheck("polarisation", "below", 0.2, 100),
        ),
    ),
)
