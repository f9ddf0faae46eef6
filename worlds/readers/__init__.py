"""Readers of drawings: GeoJSON, WKT and DXF files as obstacles and walkable areas."""

from worlds.readers.read import Geometry, read_geometry
from worlds.readers.surround import world_around

__all__ = ["Geometry", "read_geometry", "world_around"]
