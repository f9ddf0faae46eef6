"""Random obstacles for hypothesis."""

import math

from hypothesis import strategies as st

from worlds.obstacles import Box, CShape, Disc, Polygon, Prism, Ring, Sphere, Union, Wall

at = st.floats(0.0, 20.0).map(lambda x: round(x, 3))
place = st.tuples(at, at)
short = st.floats(0.3, 4.0).map(lambda x: round(x, 3))


@st.composite
def stars(draw):
    """A polygon around a centre, convex or not, that never crosses itself."""
    x, y = draw(place)
    radii = draw(st.lists(short, min_size=3, max_size=9))
    turn = 2.0 * math.pi / len(radii)
    return tuple(
        (x + r * math.cos(k * turn), y + r * math.sin(k * turn)) for k, r in enumerate(radii)
    )


discs = st.builds(Disc, centre=place, radius=short)
polygons = st.builds(Polygon, points=stars())
walls = st.builds(
    lambda start, angle, long, thick: Wall(
        start=start,
        end=(start[0] + long * math.cos(angle), start[1] + long * math.sin(angle)),
        thickness=thick,
    ),
    place,
    st.floats(0.0, 6.0),
    st.floats(1.0, 9.0),
    short,
)
rings = st.builds(
    lambda centre, inner, width: Ring(centre=centre, radius=inner + width, width=width),
    place,
    short,
    short,
)
pockets = st.builds(
    lambda centre, w, h, t, turn: CShape(
        centre=centre, size=(w + t, h + 2 * t), thickness=t, opening=turn
    ),
    place,
    short,
    short,
    st.floats(0.2, 1.0),
    st.floats(-360.0, 720.0),
)
boxes = st.builds(
    lambda low, w, h: Box(low=low, high=(low[0] + w, low[1] + h)), place, short, short
)
flat = st.one_of(discs, polygons, walls, rings, pockets, boxes)
unions = st.builds(lambda parts: Union(parts=tuple(parts)), st.lists(flat, min_size=1, max_size=3))
crowds = st.lists(st.one_of(flat, unions), min_size=1, max_size=6).map(tuple)

spheres = st.builds(Sphere, centre=st.tuples(at, at, at), radius=short)
prisms = st.builds(
    lambda points, bottom, tall: Prism(points=points, bottom=bottom, top=bottom + tall),
    stars(),
    at,
    short,
)
blocks = st.builds(
    lambda low, size: Box(low=low, high=tuple(a + b for a, b in zip(low, size, strict=True))),
    st.tuples(at, at, at),
    st.tuples(short, short, short),
)
solids = st.lists(st.one_of(spheres, prisms, blocks), min_size=1, max_size=5).map(tuple)
