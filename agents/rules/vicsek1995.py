"""The model of Vicsek et al. 1995: the mean heading of all within r, itself among them, and noise.

The rule is that of `agents.rules.vicsek`; the order of moving and turning is the paper's. An agent
moves along its old heading, (1), and takes the new one, (2), which shows in its way a tick later.
"""

from __future__ import annotations

import math

from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.neighbour_choice import Nearest
from agents.rules.vicsek import OF_PAIRS


class Vicsek1995(Parameters):
    """Parameters of Vicsek et al. 1995."""

    r: float = parameter(
        1.0,
        "Interaction radius: agents within it are neighbours; the paper's unit of length",
        words="Vision radius",
        symbol="r",
        unit="length",
        low=0.05,
        high=5.0,
        step=0.05,
        source="Vicsek et al. 1995",
    )
    eta: float = parameter(
        0.0,
        "Noise intensity: full width of the interval [-eta/2, eta/2] of the angle added to the "
        "mean heading (angular noise, rad), or length of the random vector added to it (vectorial "
        "noise)",
        words="Noise",
        symbol="\\eta",
        unit="rad",
        low=0.0,
        high=round(2 * math.pi, 4),
        proposed=(0.0, 6.2832),
        step=0.05,
        source="Vicsek et al. 1995, (2); vectorial: Grégoire and Chaté 2004",
        noise=True,
    )


class Vicsek1995Among(Nearest, Vicsek1995):
    """The same, and who the neighbours are."""


RULE = Rule(
    name="vicsek1995",
    title="Vicsek model of 1995",
    summary="Each agent moves along its old heading, then takes the mean heading of all agents "
    "within r, itself among them.",
    equation=r"x_i(t+1) = x_i(t) + v\,u(\theta_i(t)), \qquad "
    r"\theta_i(t+1) = \langle\theta(t)\rangle_r + \Delta\theta, \quad "
    r"\Delta\theta \in [-\tfrac{\eta}{2}, \tfrac{\eta}{2}]",
    source="Vicsek et al. 1995, (1), (2)",
    tags=("physics", "phase transition", "self-propelled particles", "swarm"),
    parameters=Vicsek1995Among,
    checked="figure 2: order falls with noise and with size, and rises with density: "
    "{vicsek1995-fig2#5}; {vicsek1995-fig2#6} (`flockscope paper vicsek1995-fig2`); "
    "`vem`, which moves along the new heading, is less ordered near the transition, at eta = 4 "
    "and density 4: {vicsek1995-headings#1} (`flockscope paper vicsek1995-headings`)",
    **OF_PAIRS,
    tries=(
        LessonStep(
            "Raise the noise to 5.5 rad, nearly a full turn.",
            "The order melts: before long every heading is there, and together they come to "
            "next to nothing.",
            {"eta": 5.5},
            LessonCheck("polarisation", "below", 0.2, 150),
        ),
        LessonStep(
            "Raise the noise to 2 rad only.",
            "Everybody wavers, by up to 1 rad to either side, and yet the flock goes on in one "
            "direction: a little noise is averaged away.",
            {"eta": 2.0},
            LessonCheck("polarisation", "above", 0.6, 150),
        ),
        LessonStep(
            "Let agents stand still, and notice each other only within 0.3.",
            "Patches of one heading each, frozen for good: who does not move meets nobody new, "
            "and the whole never agrees.",
            {"v0": 0.0, "r": 0.3},
            LessonCheck("polarisation", "below", 0.3, 60),
            anew=True,
        ),
    ),
)
