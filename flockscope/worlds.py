"""Worlds: a box, what is solid in it, and a mission; where they come from, and what is checked.

>>> from flockscope.worlds import Disc, World, demand_sound
>>> pond = World(name="pond", size=(20.0, 10.0), edges=("open", "open"),
...              obstacles=(Disc(centre=(8.0, 5.0), radius=2.0),))
>>> demand_sound(pond)
>>> pond.dim, len(pond.obstacles)
(2, 1)
"""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
import sys

from flockscope._old_names import old_names as _old_names
from worlds.checks import Problem, demand_sound, problems
from worlds.generators import generate
from worlds.input_error import InputError
from worlds.layout import layout_names, read_layout, world, world_from_layout
from worlds.mission import Goal, Mission, Path, StartRegion
from worlds.obstacles import Box, CShape, Disc, Polygon, Prism, Ring, Sphere, Union, Wall
from worlds.queries.clearance import clearance
from worlds.readers import Geometry, read_geometry, world_around
from worlds.world import World

__all__ = [
    "Box",
    "CShape",
    "Disc",
    "Geometry",
    "Goal",
    "InputError",
    "Mission",
    "Path",
    "Polygon",
    "Prism",
    "Problem",
    "Ring",
    "Sphere",
    "StartRegion",
    "Union",
    "Wall",
    "World",
    "clearance",
    "demand_sound",
    "generate",
    "layout_names",
    "problems",
    "read_geometry",
    "read_layout",
    "world",
    "world_around",
    "world_from_layout",
]

__getattr__ = _old_names(sys.modules[__name__], {"Refusal": "InputError"})
