"""Generators: worlds of random obstacles, each repeated by its seed."""

from worlds.generators.generate import GENERATORS, draw_obstacles, generate

__all__ = ["GENERATORS", "draw_obstacles", "generate"]
