"""What `flockscope` promises of flocks."""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from agents.flock import Flock
from agents.member import Member
from agents.mission import MissionRecord, fly
from agents.series import Series, follow

__all__ = [
    "Flock",
    "Member",
    "MissionRecord",
    "Series",
    "fly",
    "follow",
]
