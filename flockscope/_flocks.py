"""What `flockscope` promises of flocks and models."""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from agents.catalogue import MODELS, from_file, model
from agents.flock import Flock
from agents.member import Member
from agents.mission import MissionRecord, fly
from agents.series import Series, follow
from agents.spec import Spec

__all__ = [
    "MODELS",
    "Flock",
    "Member",
    "MissionRecord",
    "Series",
    "Spec",
    "fly",
    "follow",
    "from_file",
    "model",
]
