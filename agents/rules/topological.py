"""The Vicsek model with a topological range: the k nearest count, whatever their distance.

Ballerini et al. 2008 measured in flocks of starlings that a bird interacts with six to seven
nearest neighbours, and that this number, not a distance, is the same in sparse flocks and dense.
The rule is that of `agents.rules.vicsek`; `agents.engine.neighbour_search` says who is near.
"""

from __future__ import annotations

from agents.models.declare import Rule
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.vicsek import OF_PAIRS, VicsekAmong

RULE = Rule(
    name="topological",
    title="Vicsek model of the nearest neighbours",
    summary="Each agent takes the mean heading of its k nearest neighbours and itself, however far "
    "they are: density makes no difference.",
    equation=r"\theta_i(t+1) = \arg \sum_{j \in \mathcal{N}_i \cup \{i\}} e^{i\theta_j(t)} + "
    r"\Delta\theta_i, \qquad \mathcal{N}_i = \text{the } n_c \text{ nearest of } i",
    source="Ballerini et al. 2008; Vicsek et al. 1995",
    tags=("biology", "starling", "birds", "swarm"),
    parameters=VicsekAmong,
    checked="density makes no difference to those who heed the nearest, and much to others: "
    "{ballerini2008#1}; {ballerini2008#2} (eta = 2, densities 0.25 and 16; `flockscope "
    "paper ballerini2008`)",
    **OF_PAIRS,
    tries=(
        LessonStep(
            "Let everybody heed the twenty nearest instead of seven.",
            "Word gets further at each tick: by tick 100 nearly all go one way, where with "
            "seven the flock still bends and turns.",
            {"k": 20},
            LessonCheck("polarisation", "above", 0.75, 100),
            anew=True,
        ),
        LessonStep(
            "Let everybody heed one other only, the nearest.",
            "Pairs and short chains agree, and no more than these: the flock never takes a "
            "heading.",
            {"k": 1},
            LessonCheck("polarisation", "below", 0.35, 200),
            anew=True,
        ),
        LessonStep(
            "Take sixty agents, as close together as before.",
            "By tick 100 they all go one way: seven of sixty are a large part of the flock, "
            "seven of four hundred are not.",
            {"agents": 60},
            LessonCheck("polarisation", "above", 0.95, 100),
            anew=True,
        ),
    ),
)
