"""What agents look like: the meshes of birds, fish and cars, and how animals hold themselves.

The laboratory's scene and the pages that run by themselves draw agents by what stands here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from app.viewer.scene.draw.agent_meshes import (
    HEIGHT,
    HINGE,
    SHOULDER,
    TREAD,
    WHEEL,
    body,
    cabin,
    fish_tail,
    fish_trunk,
    hubs,
    hull,
    wheel,
    wings,
)
from app.viewer.scene.draw.shapes import Mesh
from app.viewer.scene.draw.solids import join_meshes
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import ANIMALS_UP_TO, BIRDS, FISH


@dataclass(frozen=True)
class AnimalMotion:
    """How a bird beats its wings and banks into its turns, or how a fish beats its tail.

    Nothing of this is computed by the flock, and nothing of the flock by this: it is for the eye,
    and moves only when the flock does.
    """

    beat: float = 2.5
    """Beats per second on the screen."""
    variety: float = 0.24
    """How much their beats differ, from the slowest to the quickest, as a share of `beat`."""
    longest_beat: float = 0.07
    """The most that a beat moves on from frame to frame, s; a slow flock beats slowly."""
    amplitude: float = 0.52
    """Swing of the wings, or of the tail, to each side, rad."""
    dihedral: float = 0.10
    """The angle about which they swing, rad."""
    glide: float = -0.30
    """A bird whose heading points lower than this (its vertical part) glides."""
    gliding: float = 0.12
    """The share of its beat that is left then."""
    ease: float = 0.45
    """Time constant with which it begins and ends to glide, s."""
    lean: float = 0.30
    """Time constant with which it leans into a turn, s."""
    longest: float = 0.25
    """The most that counts as time between two frames, s: after a pause nobody jerks."""
    steepest: float = float(np.tan(np.deg2rad(62.0)))
    """Tangent of the largest bank."""
    nimble: float = 0.25
    """A bird at full speed banks by 45 degrees in a turn whose radius is this share of its
    reach."""
    dive: float = -1.1
    """How far the nose of a bird that falls is down, rad."""
    spin: float = 5.0
    """How fast it turns, rad/s."""
    folded: float = 0.75
    """Angle of the wings or the tail of one that falls, rad."""
    flat: float = 0.02
    """The same of one that lies."""


Swing = Literal["", "wings", "tail"]
SWINGS: tuple[Swing, ...] = get_args(Swing)


@dataclass(frozen=True)
class MeshPart:
    """A mesh that each agent has one of, in units of the agent's size."""

    name: str
    mesh: Mesh
    shade: float = 1.0
    """Brightness as a multiple of the agent's colour."""
    paint: np.ndarray | None = None
    """Its own colour, sRGB (3,); None: the agent's."""
    hinge: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the origin of its mesh is from the agent's middle: ahead, left, up."""
    beats: Swing = ""
    """A pair of wings, which `wing_scales` turns up about the shoulders, or a tail, which turns
    sideways about its hinge; else it does not move."""


@dataclass(frozen=True)
class AgentShape:
    """The meshes of an agent, nose on +x, its left on +y."""

    name: str
    parts: tuple[MeshPart, ...]
    scale: float
    """Its size as a multiple of a dart's length, where it is not true to scale."""
    height: float = 1.0
    """Of what is true to scale, its height as a share of its width."""
    most: int | None = None
    """More agents than this are drawn as darts."""
    motion: AnimalMotion | None = None


MOTION = AnimalMotion()
SWIMMING = AnimalMotion(beat=2.2, amplitude=0.46, dihedral=0.0, glide=-2.0, steepest=0.0)
"""A fish is level through its turns, and swims downwards as it swims upwards."""
BIRD = AgentShape(
    name=BIRDS,
    parts=(
        MeshPart("bodies", body(), shade=0.72),
        MeshPart("wings", wings(), hinge=(0.0, 0.0, SHOULDER), beats="wings"),
    ),
    scale=1.15,  # a dart is stouter
    most=ANIMALS_UP_TO,
    motion=MOTION,
)
SWIMMER = AgentShape(
    name=FISH,
    parts=(
        MeshPart("trunks", fish_trunk()),
        MeshPart("tails", fish_tail(), shade=0.86, hinge=HINGE, beats="tail"),
    ),
    scale=1.4,  # a dart is stouter by far
    most=ANIMALS_UP_TO,
    motion=SWIMMING,
)
ANIMALS = {shape.name: shape for shape in (BIRD, SWIMMER)}
MOTIONS = {BIRDS: MOTION, FISH: SWIMMING}


def car_wheels() -> Mesh:
    """The four wheels, straight, of a car that is twice as long as wide."""
    vertices, faces = wheel()
    size = np.array([WHEEL, TREAD, 2.0 * WHEEL / HEIGHT])
    return join_meshes(
        [(vertices * size + np.array([x, y, 0.5 * size[2]]), faces) for x, y in hubs()]
    )


CAR = AgentShape(
    name="cars",
    parts=(
        MeshPart("wheels", car_wheels(), paint=palette.TYRE),
        MeshPart("hulls", hull()),
        MeshPart("cabins", cabin(), paint=palette.GLASS),
    ),
    scale=1.0,
    height=HEIGHT,
)


def shape_of(dim: int, are_cars: bool, form: str) -> AgentShape | None:
    """What agents are drawn as in a world of so many dimensions, by their form; None: darts."""
    if dim == 2 and are_cars:
        return CAR
    if form == FISH:
        return SWIMMER
    return BIRD if form == BIRDS and dim == 3 else None
