"""Generators: worlds of random obstacles, each repeated by its seed."""

from worlds.generators.generate import GENERATORS, drawn, generate

__all__ = ["GENERATORS", "drawn", "generate"]
