"""Birds, fish and cars in meshes of unit size: x forwards, y to the left.

Hull and cabin of a car are 1 long, 1 wide with the wheels, and stand 1 over the road, which is at
z = 0. A wheel has the diameter 1 and the width 1 along y, its hub at the origin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.viewer.scene.draw.shapes import Mesh
from app.viewer.scene.draw.solids import join_meshes

# A bird in two meshes, one unit long: nose on +x, wings level when they are not beaten.
#
# The wings are one mesh with the height |y|: a scale of (1, cos a, sin a) turns both up by the
# angle a about the shoulders, so a beat takes no more than a scale for each bird.

SIDES = 6
"""Facets round the body."""
STATIONS = (
    (0.43, 0.018, 0.016, -0.010),
    (0.38, 0.048, 0.046, 0.004),
    (0.30, 0.062, 0.060, 0.008),
    (0.20, 0.064, 0.060, 0.000),
    (0.06, 0.090, 0.082, -0.008),
    (-0.10, 0.078, 0.070, -0.004),
    (-0.26, 0.036, 0.032, 0.004),
)
"""Sections of the body from the beak backwards: x, half the width, half the height, middle."""
BEAK, RUMP = (0.52, 0.0, -0.016), (-0.34, 0.0, 0.006)
TAIL = ((-0.24, 0.030), (-0.56, 0.130), (-0.50, 0.0))
"""The tail's left half: root, outer feather, middle; x and y."""
SHOULDER = 0.02
"""Height of the wings over the body's axis."""
TIP = 0.88
"""Distance of a wing tip from the axis, as a multiple of a bird's length."""
WING = (
    (0.15, 0.03, 0.03),
    (0.21, 0.32, 0.31),
    (0.13, 0.56, 0.55),
    (-0.13, TIP, TIP),
    (-0.05, 0.54, 0.60),
    (-0.13, 0.30, 0.34),
    (-0.15, 0.03, 0.05),
)
"""The left wing round its edge from the shoulder outwards: x, y, and y again as the height's."""
PANELS = ((0, 5, 1), (0, 6, 5), (1, 4, 2), (1, 5, 4), (2, 4, 3))


def body() -> Mesh:
    """Beak, trunk and a flat tail."""
    (root, rw), (outer, ow), (middle, _) = TAIL
    tail = np.array(
        [
            [root, rw, 0.012],
            [outer, ow, 0.0],
            [middle, 0.0, 0.012],
            [outer, -ow, 0.0],
            [root, -rw, 0.012],
        ]
    )
    trunk = _trunk(BEAK, STATIONS, RUMP)
    return join_meshes([trunk, (tail, np.array([[0, 1, 2], [0, 2, 4], [4, 2, 3]]))])


Point = tuple[float, float, float]


def _trunk(front: Point, stations: Sequence[tuple[float, ...]], back: Point) -> Mesh:
    """A round solid from a point in front through sections (as `STATIONS`) to one behind."""
    turn = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    rings = [
        np.column_stack(
            [np.full(SIDES, x), wide * np.cos(turn), middle + high * np.sin(turn)],
        )
        for x, wide, high, middle in stations
    ]
    index = np.arange(SIDES)
    after = (index + 1) % SIDES
    faces = [np.column_stack([np.zeros(SIDES, int), 2 + index, 2 + after])]
    for ring in range(len(stations) - 1):
        begin, end = 2 + SIDES * ring, 2 + SIDES * (ring + 1)
        faces.append(np.column_stack([begin + index, end + index, end + after]))
        faces.append(np.column_stack([begin + index, end + after, begin + after]))
    last = 2 + SIDES * (len(stations) - 1)
    faces.append(np.column_stack([np.ones(SIDES, int), last + after, last + index]))
    return np.concatenate([[front, back], *rings]), np.concatenate(faces)


def wings() -> Mesh:
    """Both wings turned up by 45 degrees about their shoulders, sqrt(2) times too long."""
    left = np.array(WING)
    right = left * np.array([1.0, -1.0, 1.0])
    panels = np.array(PANELS)
    return np.concatenate([left, right]), np.concatenate([panels, len(left) + panels[:, ::-1]])


def wing_scales(angle: np.ndarray) -> np.ndarray:
    """Scales (N, 3) of the wings' mesh that turn both wings up by an angle (N,), rad.

    >>> wing_scales(np.array([0.0])).tolist()
    [[1.0, 1.0, 0.0]]
    """
    return np.column_stack([np.ones(len(angle)), np.cos(angle), np.sin(angle)])


# A fish in two meshes: a trunk with fins, and a tail that turns about its hinge to either side. It
# is a little wider than it would be, so that one sees from above where it is headed.

GILLS = (
    (0.45, 0.040, 0.045, -0.005),
    (0.33, 0.085, 0.100, 0.000),
    (0.14, 0.105, 0.135, 0.004),
    (-0.06, 0.085, 0.110, 0.004),
    (-0.20, 0.048, 0.064, 0.000),
)
"""Sections of the trunk, as those of a bird."""
MOUTH, VENT = (0.50, 0.0, -0.012), (-0.24, 0.0, 0.0)
FINS = (
    ((0.16, 0.0, 0.12), (-0.10, 0.0, 0.23), (-0.13, 0.0, 0.08)),
    ((0.22, 0.085, -0.03), (0.03, 0.20, -0.06), (0.08, 0.085, -0.04)),
    ((0.22, -0.085, -0.03), (0.08, -0.085, -0.04), (0.03, -0.20, -0.06)),
)
"""Dorsal fin, left and right pectoral fin, a triangle each."""
HINGE = (-0.18, 0.0, 0.0)
"""Where the tail is hinged to the trunk, the origin of its mesh."""
STALK = ((0.0, 0.052, 0.068, 0.0), (-0.20, 0.026, 0.030, 0.0))
"""Sections of the tail before its fin."""
LOBE, NOTCH, SPREAD = -0.44, -0.33, 0.17
"""Of the fin of the tail: where its tips and the notch between them are, x; half its height."""
BLADE = 0.026
"""Half the width of that fin, which is no sheet: from above one sees it swing."""


def fish_trunk() -> Mesh:
    """Head, trunk and three fins."""
    fins = np.array(FINS).reshape(-1, 3)
    return join_meshes([_trunk(MOUTH, GILLS, VENT), (fins, np.arange(9).reshape(3, 3))])


def fish_tail() -> Mesh:
    """The tail, straight behind its hinge."""
    begin = STALK[-1][0] + 0.05
    left = np.array(
        [(begin, BLADE, 0.0), (NOTCH, BLADE, 0.0), (LOBE, BLADE, SPREAD), (LOBE, BLADE, -SPREAD)]
    )
    fin = np.concatenate([left, left * [1.0, -1.0, 1.0]])
    sides = [(0, 2, 1), (0, 1, 3), (4, 5, 6), (4, 7, 5)]
    edges = [(0, 4, 6), (0, 6, 2), (0, 7, 4), (0, 3, 7)]
    stalk = _trunk((0.03, 0.0, 0.0), STALK, (-0.21, 0.0, 0.0))
    return join_meshes([stalk, (fin, np.array([*sides, *edges]))])


FISH_LEFT = ((0.50, 0.0), (0.45, 0.045), (0.33, 0.090), (0.22, 0.100), (0.03, 0.20), (0.07, 0.105),
             (-0.06, 0.090), (-0.18, 0.055), (-0.38, 0.025), (-0.60, 0.035))  # fmt: skip
"""Outline of a fish from above: its left half from the mouth backwards, x and y."""


PLAIN_FISH = (
    np.array(
        [
            [0.50, 0.00, 0.00],  # 0 mouth
            [0.14, 0.11, 0.00],  # 1 left side
            [0.14, -0.11, 0.00],  # 2 right side
            [0.10, 0.00, 0.16],  # 3 back
            [0.10, 0.00, -0.14],  # 4 belly
            [-0.32, 0.00, 0.00],  # 5 where the fin of the tail begins
            [-0.62, 0.00, 0.17],  # 6 its tips
            [-0.62, 0.00, -0.17],  # 7
            [-0.51, 0.00, 0.00],  # 8 the notch between them
        ]
    ),
    np.array(
        [[0, 1, 3], [0, 3, 2], [0, 4, 1], [0, 2, 4], [5, 3, 1], [5, 2, 3], [5, 1, 4], [5, 4, 2],
         [5, 6, 8], [5, 8, 6], [5, 8, 7], [5, 7, 8]]
    ),
)  # fmt: skip
"""A fish of few faces, the fin of both sides, for pictures that sort them all."""
PLAIN_OUTLINE = (0, 1, 5, 8, 5, 2)
"""Its edge from above."""


def turn_tails(points: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Points (K, 2 or 3) of a fish with what is behind its hinge turned by `angle` (N,), rad,
    anticlockwise from above: (N, K, 2 or 3).

    >>> turn_tails(np.array([[0.5, 0.0], [-0.68, 0.0]]), np.array([np.pi / 2])).round(2).tolist()
    [[[0.5, 0.0], [-0.18, -0.5]]]
    """
    hinge = np.array(HINGE[: points.shape[1]])
    turned = np.repeat((points - hinge)[None], len(angle), axis=0)
    behind = points[:, 0] < hinge[0]
    x, y = turned[0, behind, :2].T
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    turned[:, behind, 0], turned[:, behind, 1] = cos * x - sin * y, sin * x + cos * y
    return turned + hinge


def fish_outlines(angle: np.ndarray) -> np.ndarray:
    """Outlines (N, K, 2) of fish from above, their tails turned as by `turn_tails`.

    >>> fish_outlines(np.zeros(2)).shape
    (2, 19, 2)
    """
    left = np.array(FISH_LEFT)
    return turn_tails(np.concatenate([left, left[:0:-1] * [1.0, -1.0]]), angle)


HULL = ((-0.5, 0.40, 0.16), (-0.47, 0.56, 0.16), (0.28, 0.52, 0.16), (0.5, 0.36, 0.16))
"""Outline of the hull from behind: x, height of the upper edge, height of the lower one."""
BELLY = 0.40
"""Half the width of the hull's lower edge: the wheels stand out beyond it."""
SLIMMER = 0.86
"""Width of the hull's upper edge as a share of the lower one's."""
HEIGHT = 0.85
"""Of a car, as a share of its width."""
CABIN = ((-0.38, -0.27), (0.20, 0.04))
"""Rear and front end of the windows: x at their foot, x at the roof."""
FOOT, ROOF = (0.50, 0.34), (0.92, 0.27)
"""Of the windows: height, and half the width."""
THICK = 0.08
"""Height of the roof over the windows."""
AXLES = (-0.29, 0.31)
"""Where the rear and the front axle are, x."""
TRACK = 0.41
"""Half the distance of the wheels of an axle, as a share of the width."""
WHEEL, TREAD = 0.22, 0.18
"""Diameter of a wheel as a share of the length, and its width as a share of the car's."""
FACETS = 10


def hull() -> Mesh:
    """Bonnet, sides, boot and the roof, which the windows carry."""
    x, high, low = np.array(HULL).T
    lower, upper = np.full(len(x), BELLY), np.full(len(x), SLIMMER * BELLY)
    rings = [
        np.column_stack([x, -lower, low]),
        np.column_stack([x, lower, low]),
        np.column_stack([x, upper, high]),
        np.column_stack([x, -upper, high]),
    ]
    (_, back), (_, front) = CABIN
    low, half = ROOF
    top = low + THICK
    roof = [
        [(x, -half, low), (x, half, low), (x, half, top), (x, -half, top)] for x in (back, front)
    ]
    return join_meshes([_tube(np.stack(rings, axis=1)), _tube(np.array(roof))])


def cabin() -> Mesh:
    """The windows."""
    (back_foot, back_roof), (front_foot, front_roof) = CABIN
    (low, wide), (high, narrow) = FOOT, ROOF
    rings = [
        [
            (foot, -wide, low),
            (foot, wide, low),
            (roof, narrow, high),
            (roof, -narrow, high),
        ]
        for foot, roof in ((back_foot, back_roof), (front_foot, front_roof))
    ]
    return _tube(np.array(rings))


def outline() -> np.ndarray:
    """The edges of the hull and of the roof as line segments (K, 2, 3)."""
    vertices, _ = hull()
    rings = vertices.reshape(-1, 4, 3)
    body, roof = rings[: len(HULL)], rings[len(HULL) :, 2:].reshape(4, 3)
    along = np.stack([body[:-1], body[1:]], axis=2).reshape(-1, 2, 3)
    ends = body[[0, -1]]
    across = np.stack([ends, np.roll(ends, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return np.concatenate([along, across, np.stack([roof, roof[[1, 3, 0, 2]]], axis=1)])


def wheel() -> Mesh:
    """A drum that rolls along x."""
    turn = 2.0 * np.pi * np.arange(FACETS) / FACETS
    face = np.column_stack([0.5 * np.sin(turn), np.zeros(FACETS), 0.5 * np.cos(turn)])
    side = np.array([0.0, 0.5, 0.0])
    centres = np.array([-side, side])
    index = np.arange(FACETS)
    after = (index + 1) % FACETS
    right, left = index, index + FACETS
    faces = np.concatenate(
        [
            np.column_stack([right, left[after], left]),
            np.column_stack([right, right[after], left[after]]),
            np.column_stack([np.full(FACETS, 2 * FACETS), right[after], right]),
            np.column_stack([np.full(FACETS, 2 * FACETS + 1), left, left[after]]),
        ]
    )
    return np.concatenate([face - side, face + side, centres]), faces


def hubs() -> np.ndarray:
    """Where the wheels are, (4, 2): x as a share of the length, y as one of the width.

    The front wheels, which are steered, come last.
    """
    return np.array([(x, side * TRACK) for x in AXLES for side in (-1.0, 1.0)])


def _tube(rings: np.ndarray) -> Mesh:
    """A closed solid through rings (R, 4, 3), anticlockwise seen from the front, from behind on."""
    count = len(rings)
    faces = []
    for ring in range(count - 1):
        for corner in range(4):
            a, b = 4 * ring + corner, 4 * ring + (corner + 1) % 4
            faces += [(a, b + 4, a + 4), (a, b, b + 4)]
    last = 4 * (count - 1)
    faces += [(0, 2, 1), (0, 3, 2), (last, last + 1, last + 2), (last, last + 2, last + 3)]
    return rings.reshape(-1, 3), np.array(faces)
