"""The model of Grégoire and Chaté 2004: a Vicsek model with vectorial noise.

Noise is an error in what an agent hears of each neighbour, not in how it carries out its turn: to
the sum of n headings a vector of length eta n is added, in a direction by chance. The mean of the
headings and a vector of length eta have the same direction, and that is how the engine adds it.
The rule is that of `agents.rules.vicsek`; agents move along the new heading.
"""

from __future__ import annotations

from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.neighbour_choice import Nearest
from agents.rules.vicsek import OF_PAIRS


class GregoireChate(Parameters):
    """Parameters of Grégoire and Chaté 2004, without cohesion."""

    r: float = parameter(
        1.0,
        "Interaction radius: agents within it are neighbours; the paper's unit of length",
        words="Vision radius",
        symbol="r_0",
        unit="length",
        low=0.05,
        high=5.0,
        step=0.05,
        source="Grégoire and Chaté 2004",
    )
    eta: float = parameter(
        0.5,
        "Noise: length of the random vector, for each heading of the sum to which it is added",
        words="Noise",
        symbol="\\eta",
        low=0.0,
        high=1.0,
        step=0.01,
        source="Grégoire and Chaté 2004",
        noise=True,
    )


class GregoireChateAmong(Nearest, GregoireChate):
    """The same, and who the neighbours are."""


RULE = Rule(
    name="gregoire-chate",
    title="Vicsek model with vectorial noise",
    summary="Each agent takes the mean heading of all agents within r, itself among them, and "
    "mishears each by a vector of length eta: large flocks fall into order all at once.",
    equation=r"\theta_i(t+1) = \arg\Big[\sum_{j \in \mathcal{N}_i \cup \{i\}} e^{i\theta_j(t)} + "
    r"\eta\, n_i\, e^{i\xi_i(t)}\Big], \qquad x_i(t+1) = x_i(t) + v_0\, u(\theta_i(t+1))",
    source="Grégoire and Chaté 2004",
    tags=("physics", "phase transition", "bands", "swarm"),
    parameters=GregoireChateAmong,
    noise="vectorial",
    checked="the transition is discontinuous, and with angular noise it is not: "
    "{gregoire-chate2004#3}; {gregoire-chate2004#4} (G: Binder's cumulant; `flockscope "
    "paper gregoire-chate2004`)",
    **OF_PAIRS,
    tries=(
        LessonStep(
            "Raise the noise from 0.5 to 0.8.",
            "The order is gone in some ticks: everybody mishears so much that the headings of "
            "all add up to nothing.",
            {"eta": 0.8},
            LessonCheck("polarisation", "below", 0.2, 150),
        ),
        LessonStep(
            "Lower the noise to 0.2.",
            "Nearly everybody goes the same way, and the flock draws together into denser clouds.",
            {"eta": 0.2},
            LessonCheck("polarisation", "above", 0.94, 150),
        ),
        LessonStep(
            "Let agents notice each other only within 0.4.",
            "The links of the flock break into many small groups; most of the order stays, "
            "since agents move far in a tick and keep meeting others.",
            {"r": 0.4},
            LessonCheck("largest-group", "below", 200, 150),
        ),
    ),
)
