"""Generators: worlds of random obstacles, each repeated by its seed."""

from worlds.generators.generate import GENERATORS, generate

__all__ = ["GENERATORS", "generate"]
