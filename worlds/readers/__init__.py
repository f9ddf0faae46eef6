"""Readers of drawings and maps: files of other programs as obstacles and walkable areas."""

from worlds.readers.read import Geometry, geometry_of, open_drawing, read_geometry
from worlds.readers.roles import assign_roles
from worlds.readers.surround import world_and_notes, world_around

__all__ = [
    "Geometry",
    "assign_roles",
    "geometry_of",
    "open_drawing",
    "read_geometry",
    "world_and_notes",
    "world_around",
]
