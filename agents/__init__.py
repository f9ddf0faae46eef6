"""The flock: rules, bodies, the engine that runs them and what is measured of them."""

from agents.flock import Flock
from agents.member import Member

__all__ = ["Flock", "Member"]
