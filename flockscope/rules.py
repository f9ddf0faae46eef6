"""For who writes a rule: its declaration, what it is given and what it answers.

docs/new-rule.md is a whole rule in one file.

>>> from flockscope.rules import VEM, Model, CONSTANT_SPEED
>>> Model(VEM, CONSTANT_SPEED).name
'vem'
"""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
import sys

from agents.bodies.car import BODY as CAR
from agents.bodies.car import driving
from agents.bodies.constant_speed import BODY as CONSTANT_SPEED
from agents.bodies.double_integrator import BODY as DOUBLE_INTEGRATOR
from agents.bodies.point_mass import BODY as POINT_MASS
from agents.bodies.steered import BODY as STEERED
from agents.bodies.turning import BODY as TURNING
from agents.bodies.zero_turn import BODY as ZERO_TURN
from agents.engine.block import BodyMove, Decision, adjacent, is_neighbour
from agents.engine.noise import uniform
from agents.engine.vector_lanes import where
from agents.models.declare import Body, Parameters, Rule, Zone, parameter
from agents.models.model import Model
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sums import mean_heading, of_pairs, sum_of
from agents.rules.vicsek import VEM, Vicsek
from flockscope._old_names import old_names as _old_names
from worlds.compilation import compiled
from worlds.input_error import InputError
from worlds.queries.surroundings import nearest_surface, surface_within

__all__ = [
    "CAR",
    "CONSTANT_SPEED",
    "DOUBLE_INTEGRATOR",
    "POINT_MASS",
    "STEERED",
    "TURNING",
    "VEM",
    "ZERO_TURN",
    "Body",
    "BodyMove",
    "Decision",
    "InputError",
    "LessonCheck",
    "LessonStep",
    "Model",
    "Parameters",
    "Rule",
    "Vicsek",
    "Zone",
    "adjacent",
    "compiled",
    "driving",
    "is_neighbour",
    "mean_heading",
    "nearest_surface",
    "of_pairs",
    "parameter",
    "sum_of",
    "surface_within",
    "uniform",
    "where",
]

__getattr__ = _old_names(
    sys.modules[__name__],
    {
        "Moved": "BodyMove",
        "Proof": "LessonCheck",
        "Refusal": "InputError",
        "Try": "LessonStep",
        "Wish": "Decision",
    },
)
