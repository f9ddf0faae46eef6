"""WVEM: neighbours weigh by their contact with the information UAV (Liu et al. 2021, 3.1.2)."""

from __future__ import annotations

from agents.engine.block import Decision, adjacent
from agents.engine.neighbour_search import search_layers
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.vicsek import Vicsek
from worlds.compilation import compiled

LAYER = 0


class WeightedVicsek(Vicsek):
    """Parameters of WVEM."""

    k_alpha: float = parameter(
        30.0,
        "Weight of an information UAV",
        words="Weight of the information UAV",
        symbol="k_\\alpha",
        low=0.0,
        high=200.0,
        proposed=(0.0, 100.0),
        step=1.0,
        source="Liu et al. 2021, section 3.1.2",
    )
    k_beta: float = parameter(
        18.0,
        "Weight of a neighbour that is in direct contact with an information UAV",
        words="Weight of its contacts",
        symbol="k_\\beta",
        low=0.0,
        high=200.0,
        proposed=(0.0, 100.0),
        step=1.0,
        source="Liu et al. 2021, section 3.1.2",
    )
    k_gamma: float = parameter(
        1.0,
        "Weight of every other neighbour",
        words="Weight of all others",
        symbol="k_\\gamma",
        low=0.0,
        high=200.0,
        proposed=(0.0, 10.0),
        step=0.5,
        source="Liu et al. 2021, section 3.1.2",
    )


@compiled
def weight(layer, p):
    """k_alpha for an information UAV, k_beta in direct contact with one, else k_gamma."""
    return p.k_alpha if layer == 1.0 else (p.k_beta if layer == 2.0 else p.k_gamma)


@compiled
def decide(me, near, surroundings, p):
    """Weighted mean heading of the neighbours, itself left out."""
    layer = near.signal[LAYER]
    x = y = z = total = 0.0
    for j in range(near.n):
        h = adjacent(me, near, j, p.r) * near.heard[j] * weight(layer[j], p)
        x += h * near.ux[j]
        y += h * near.uy[j]
        z += h * near.uz[j]
        total += h
    if total == 0.0:
        return Decision(0.0, 0.0, 0.0)
    return Decision(x / total, y / total, z / total)


@compiled
def prepare(flock, space, grid, slots, p, tick):
    """Who is in direct contact with an information UAV at this tick: layer 2."""
    search_layers(flock, space, grid, slots, p.r, LAYER, 2)


@compiled
def weigh(me, near, p, out):
    """Weights h_ij of the agents of the block."""
    for j in range(near.n):
        out[j] = adjacent(me, near, j, p.r) * near.heard[j] * weight(near.signal[LAYER, j], p)


WVEM = Rule(
    name="wvem",
    title="Weighting Vicsek model",
    summary="Neighbours count by what they can know: the information UAV most, those in direct "
    "contact with it next, all others least.",
    equation=r"\theta_i(k+1) = \operatorname{atan2}\Big(\sum_{j \in \mathcal{N}_i} k_j "
    r"\sin\theta_j, \sum_{j \in \mathcal{N}_i} k_j \cos\theta_j\Big) + \Delta\theta_i, \qquad "
    r"k_j \in \{k_\alpha, k_\beta, k_\gamma\}",
    source="Liu et al. 2021, section 3.1.2 and reference 16",
    checked="time to align at N = 100 {liu2021-table1/wvem/100/k_con}, at 200 "
    "{liu2021-table1/wvem/200/k_con}: `flockscope paper liu2021-table1`; success on a "
    "mission of 50 UAVs {liu2021-table2/WVEM/50/success}: `flockscope paper "
    "liu2021-table2`",
    tags=("robotics", "UAV", "leader", "consensus", "swarm"),
    parameters=WeightedVicsek,
    decide=decide,
    signals=("layer",),
    words={"layer": "layer (leader: 1)"},
    prepare=prepare,
    weigh=weigh,
    informed=1,
    converges=True,
    tries=(
        LessonStep(
            "Take ten times as many agents, as close together as before.",
            "Those far from the information agent never hear of it: at tick 60 a hundred agree "
            "with it, a thousand are in patches.",
            {"agents": 1000},
            LessonCheck("polarisation", "falls", 0.1, 60),
            anew=True,
        ),
        LessonStep(
            "Let all neighbours weigh the same.",
            "This is the Vicsek model with one agent that does not turn: the flock takes "
            "longer to come to its heading.",
            {"k_alpha": 1.0, "k_beta": 1.0},
            LessonCheck("consistency", "falls", 0.004, 60),
            anew=True,
        ),
        LessonStep(
            "Raise the noise to 5.5 rad, nearly a full turn.",
            "Weights do not help against this: every heading is there, and the polarisation "
            "falls to about 0.1.",
            {"eta": 5.5},
            LessonCheck("polarisation", "below", 0.25, 150),
        ),
    ),
)
