"""Generators: worlds of random obstacles, each repeated by its seed."""

from worlds.generators.generate import GENERATORS, generate
from worlds.generators.random_obstacles import drawn

__all__ = ["GENERATORS", "drawn", "generate"]
