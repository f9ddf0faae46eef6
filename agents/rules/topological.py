"""The Vicsek model with a topological range: the k nearest count, whatever their distance.

Ballerini et al. 2008 measured in flocks of starlings that a bird interacts with six to seven
nearest neighbours, and that this number, not a distance, is the same in sparse flocks and dense.
The rule is that of `agents.rules.vicsek`; `agents.engine.nearest` says who is near.
"""

from __future__ import annotations

from agents.models.declare import Rule
from agents.rules.vicsek import OF_PAIRS, VicsekAmong

RULE = Rule(
    name="topological",
    title="Vicsek model of the nearest neighbours",
    summary="Each agent takes the mean heading of its k nearest neighbours and itself, however far "
    "they are: density makes no difference.",
    equation=r"\theta_i(t+1) = \arg \sum_{j \in \mathcal{N}_i \cup \{i\}} e^{i\theta_j(t)} + "
    r"\Delta\theta_i, \qquad \mathcal{N}_i = \text{the } n_c \text{ nearest of } i",
    source="Ballerini et al. 2008; Vicsek et al. 1995",
    parameters=VicsekAmong,
    checked="density makes no difference to those who heed the nearest, and much to others: "
    "{ballerini2008#1}; {ballerini2008#2} (eta = 2, densities 0.25 and 16; `uv run flockscope "
    "paper ballerini2008`)",
    **OF_PAIRS,
)
