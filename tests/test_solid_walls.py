"""What is solid holds for every model: who starts inside stays inside, and out of obstacles.

Worlds, parameters and starts are drawn at random, from thin walls to steps that are far longer
than any wall is thick. Seen before: agents that crossed a wall in their first tick and flew off.
"""

import math
import re

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.catalogue import MODELS
from agents.models.declare import declared
from worlds.input_error import InputError
from worlds.obstacles import Box, Disc, Polygon, Prism, Sphere, Wall
from worlds.queries.clearance import clearance
from worlds.queries.outlines import outlines
from worlds.world import World

TICKS, OF_CARS = 500, 200
"""How long they fly, and cars, which look ahead at every tick."""
AGENTS = 6
HOLDS = {"guard": True, "contact": "always"}
"""Settings without which agents go through what is solid, by the literal text of their papers."""
NO_MATTER = {"neighbours"}
"""Settings that make no difference to walls, but other kernels, each of which is to be compiled."""
IN_SPACE = {"couzin", "thesis", "safe", "guarded", "echelon"}
NAMES = [*MODELS, "vem-cars"]


def drawn_parameters(name, draw):
    """Random parameters of a model within their ranges, some at an end of them."""
    found = {}
    for one in declared(Flock(name, agents=1, rng=0).model.parameters):
        if one.name in HOLDS:
            value = HOLDS[one.name]
            found[one.name] = value if one.kind == "switch" or value in one.choices else "stops"
        elif one.kind == "switch":
            found[one.name] = draw(st.booleans())
        elif one.name in NO_MATTER:
            continue
        elif one.kind == "choice":
            found[one.name] = draw(st.sampled_from(one.choices))
        elif draw(st.booleans()):
            ends = st.sampled_from((one.low, one.high))
            found[one.name] = draw(st.one_of(ends, st.floats(one.low, one.high)))
    return found


def obstacles(draw, dim, side):
    """A few obstacles, which may overlap, lie across an edge and be thinner than any step."""
    place = st.floats(0.0, side)
    length = st.one_of(st.floats(0.02, 0.3), st.floats(0.3, 0.4 * side))
    thin = st.sampled_from((1e-3, 0.05, 0.3))
    kinds = ["wall", "divide", "disc", "box", "polygon"] + ["sphere", "slab"] * (dim == 3)
    made = []
    for kind in draw(st.lists(st.sampled_from(kinds), min_size=0, max_size=4)):
        x, y, u, v = (draw(place) for _ in range(4))
        r = draw(length)
        if kind == "wall" and math.dist((x, y), (u, v)) > 0.01:
            made.append(Wall(start=(x, y), end=(u, v), thickness=draw(thin)))
        elif kind == "divide":
            made.append(Wall(start=(x, -1.0), end=(x, side + 1.0), thickness=draw(thin)))
        elif kind == "disc":
            made.append(Disc(centre=(x, y), radius=r))
        elif kind == "box":
            made.append(Box(low=(x, y), high=(x + r, y + draw(length))))
        elif kind == "polygon":
            angles = sorted({round(draw(st.floats(0.0, 6.28)), 2) for _ in range(5)})
            corners = [(x + r * math.cos(a), y + r * math.sin(a)) for a in angles]
            if len(corners) > 2 and shapely.Polygon(corners).area > 1e-4:
                made.append(Polygon(points=corners))
        elif kind == "sphere":
            made.append(Sphere(centre=(x, y, u), radius=r))
        elif kind == "slab":
            corners = [(x, y), (x + r, y), (x + 0.5 * r, y + r)]
            made.append(Prism(points=corners, bottom=v, top=v + draw(thin)))
    return tuple(made)


def drawn_world(dim, draw):
    """A random world in which something is solid."""
    side = draw(st.sampled_from((3.0, 9.0, 30.0)))
    edges = tuple(draw(st.sampled_from(("solid", "solid", "wrap", "open"))) for _ in range(dim))
    if edges.count("solid") == 0 and draw(st.booleans()):
        edges = ("solid",) * dim
    return World("drawn", (side,) * dim, edges, obstacles=obstacles(draw, dim, side))


def free_parts(world):
    """The connected parts of the plan that are free, in a world whose edges do not wrap."""
    (x, y), (u, v) = world.low, np.array(world.low) + world.size
    far = 1e4
    box = [
        end if edge == "solid" else end + sign * far
        for end, edge, sign in zip((x, y, u, v), world.edges * 2, (-1, -1, 1, 1), strict=True)
    ]
    solid = shapely.union_all(list(outlines(world, math.inf).values()))
    return shapely.get_parts(shapely.box(*box).difference(solid))


def flock_that_fits(name, world, seed, parameters):
    """The flock, or None if it is refused with the number that fits."""
    try:
        return Flock(name, agents=AGENTS, world=world, rng=seed, **parameters)
    except InputError as refusal:
        if not re.search(r"do not fit .*: (\d+ fit|1 fits|not even one fits)$", str(refusal)):
            raise
        return None


@pytest.mark.parametrize("name", NAMES)
@settings(
    max_examples=8,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
@given(data=st.data())
def test_nobody_is_ever_where_nobody_can_be(name, data):
    dim = 3 if name in IN_SPACE else 2
    world = drawn_world(dim, data.draw)
    given = drawn_parameters(name, data.draw)
    seed = data.draw(st.integers(0, 1000))
    flock = flock_that_fits(name, world, seed, given)
    if flock is None:
        return
    assert not flock.passing
    begin = flock.position.copy()
    assert clearance(world, begin).min() > 0.0
    trace = flock.trace(OF_CARS if flock.model.body.vehicle else TICKS)
    assert np.isfinite(trace).all()
    depth = clearance(world, trace.reshape(-1, dim)) if world.is_solid else np.zeros(1)
    assert depth.min() >= -1e-9 * (1.0 + np.abs(trace).max())
    assert flock.stray() is None
    if dim == 2 and "wrap" not in world.edges:
        parts = free_parts(world)
        near = shapely.STRtree(parts)
        first, last = (near.nearest(shapely.points(at)) for at in (begin, trace[-1]))
        assert (first == last).all(), "nobody goes through a wall into another room"


OFFICE = World(
    "office",
    (20.0, 11.0),
    ("solid", "solid"),
    obstacles=(
        Wall(start=(7.0, 0.0), end=(7.0, 8.0), thickness=0.1),
        Wall(start=(13.0, 3.0), end=(13.0, 11.0), thickness=0.1),
        Wall(start=(13.0, 5.0), end=(17.0, 5.0), thickness=0.1),
    ),
)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_boundary_points_in_an_office_stay_in_it(seed):
    flock = Flock("boundary-points", agents=30, world=OFFICE, rng=seed)
    assert clearance(OFFICE, flock.position).min() > 5.0 * 0.02, "as far as the first tick goes"
    trace = flock.trace(TICKS)
    assert clearance(OFFICE, trace.reshape(-1, 2)).min() >= 0.0


def test_agents_put_a_millimetre_from_a_wall_do_not_cross_it():
    place = [(0.001, 5.0), (19.999, 5.0), (6.949, 3.0), (7.051, 3.0), (10.0, 0.001)]
    start = {"position": place, "heading": [(1.0, 0.0)] * 5}
    flock = Flock("boundary-points", start=start, world=OFFICE, rng=1)
    trace = flock.trace(TICKS)
    assert clearance(OFFICE, trace.reshape(-1, 2)).min() >= 0.0


@pytest.mark.parametrize("thickness", [1e-6, 1e-3, 0.2])
def test_a_wall_thinner_than_a_step_is_a_mirror(thickness):
    wall = Wall(start=(5.0, -1.0), end=(5.0, 11.0), thickness=thickness)
    world = World("halves", (10.0, 10.0), ("solid", "solid"), obstacles=(wall,))
    start = {"position": [(4.6, 5.0)], "heading": [(1.0, 0.0)]}
    flock = Flock("vem", start=start, world=world, rng=1, v0=1.0)
    flock.run(1)
    face = 5.0 - 0.5 * thickness
    np.testing.assert_allclose(flock.position[0], [2.0 * face - 5.6, 5.0], atol=1e-7)
    np.testing.assert_allclose(flock.heading[0], [-1.0, 0.0], atol=1e-9)


def test_several_surfaces_are_met_within_one_tick():
    world = World("shaft", (10.0, 0.1), ("open", "solid"))
    start = {"position": [(5.0, 0.05)], "heading": [(0.6, 0.8)]}
    flock = Flock("vem", start=start, world=world, rng=1, v0=1.0)
    flock.run(1)
    # 0.8 up in a shaft of 0.1: eight times to and fro, back where it began, 0.6 farther on.
    np.testing.assert_allclose(flock.position[0], [5.6, 0.05], atol=1e-6)
    np.testing.assert_allclose(flock.heading[0], [0.6, 0.8], atol=1e-9)


def test_an_obstacle_beyond_the_seam_is_met():
    disc = Disc(centre=(0.5, 5.0), radius=0.1)
    world = World("ring road", (10.0, 10.0), ("wrap", "wrap"), obstacles=(disc,))
    start = {"position": [(9.9, 5.0)], "heading": [(1.0, 0.0)]}
    flock = Flock("vem", start=start, world=world, rng=1, v0=1.0, r=0.05)
    flock.run(1)
    assert flock.heading[0, 0] < -0.99
    assert flock.position[0, 0] == pytest.approx(9.9, abs=1e-3)


def test_where_nothing_is_crossed_no_bit_changes():
    near = World("open", (40.0, 40.0), ("open", "open"))
    far = World(
        "far", (40.0, 40.0), ("open", "open"), obstacles=(Box(low=(90, 90), high=(91, 91)),)
    )
    for name in ("vem", "boundary-points"):
        one, other = (Flock(name, agents=20, world=world, rng=3) for world in (near, far))
        one.run(200)
        other.run(200)
        assert np.array_equal(one.position, other.position)
        assert np.array_equal(one.heading, other.heading)


@pytest.mark.parametrize("activation", ["synchronous", "sequential"])
def test_one_by_one_it_is_the_same_tick(activation):
    whole, single = (
        Flock("vem", agents=20, world=OFFICE, rng=5, activation=activation, v0=1.0, eta=0.5)
        for _ in range(2)
    )
    for _ in range(20):
        whole.run(1)
        for member in single.agents:
            member.step()
        assert np.array_equal(whole.position, single.position)
        assert np.array_equal(whole.heading, single.heading)
    assert clearance(OFFICE, whole.position).min() >= 0.0


def test_any_number_of_threads_gives_the_same_bits():
    runs = [
        Flock("vem", agents=12_000, world=OFFICE, rng=2, v0=0.7, r=0.1, eta=1.0, threads=threads)
        for threads in (1, 2)
    ]
    for flock in runs:
        flock.run(3)
    assert np.array_equal(runs[0].position, runs[1].position)
    assert clearance(OFFICE, runs[0].position).min() >= 0.0


def test_a_flock_that_does_not_fit_is_refused_with_the_number_that_does():
    closet = World("closet", (1.0, 1.0), ("solid", "solid"))
    with pytest.raises(InputError, match=r"agents = 50 do not fit .*: \d+ fit") as refused:
        Flock("boundary-points", agents=50, world=closet, rng=1, spacing=0.2)
    number = int(str(refused.value).split(": ")[-1].split()[0])
    assert number > 5
    assert (
        len(Flock("boundary-points", agents=number, world=closet, rng=1, spacing=0.2).ids) == number
    )
    with pytest.raises(InputError, match=r"0\.5 from them: not even one fits"):
        Flock("boundary-points", agents=3, world=closet, rng=1, p_max=25.0)


def test_an_agent_that_is_put_into_an_obstacle_is_told_of():
    flock = Flock("vem", agents=5, world=OFFICE, rng=1)
    assert flock.stray() is None
    flock.position[2] = (7.01, 4.0)
    flock.position[4] = (25.0, 4.0)
    found = flock.stray()
    assert (found.row, found.id, found.number) == (2, int(flock.ids[2]), 2)
    assert str(found) == (
        f"agent {flock.ids[2]}, and 1 more where it cannot be: 0.04 inside what is solid at "
        "(7.01, 4), tick 0"
    )


def test_settings_that_let_agents_through_are_said():
    for name, setting, words in (
        ("thesis", {}, "contact = start"),
        ("reynolds", {"guard": False}, "guard = false"),
        ("reynolds", {}, ""),
        ("thesis", {"contact": "always"}, ""),
    ):
        world = "thesis-blocks" if name == "thesis" else "obstacles"
        assert Flock(name, agents=3, world=world, rng=1, **setting).passing == words
    assert Flock("thesis", agents=3, rng=1).passing == "", "where nothing is solid there is nothing"


@pytest.mark.parametrize(
    ("world", "place", "words"),
    [
        (OFFICE, (7.0, 4.0), r"row 1 is \[7.0, 4.0\]: that is inside the obstacle wall of office"),
        (OFFICE, (20.5, 4.0), r"x = 20.5 is outside \[0, 20\], the box of office, .* solid"),
        ("wrap", (640.0, 4.0), r"x = 640 is outside \[0, 10\), the box of wrap, .* wrapping"),
        ("wrap", (3.0, 10.0), r"y = 10 is outside \[0, 10\)"),
    ],
)
def test_a_given_place_where_no_agent_can_be_is_refused(world, place, words):
    start = {"position": [(1.0, 1.0), place], "heading": [(1.0, 0.0)] * 2}
    size = None if world is OFFICE else 10.0
    with pytest.raises(InputError, match=words):
        Flock("vem", start=start, world=world, size=size, rng=1)


def test_beyond_an_open_edge_agents_may_begin():
    start = {"position": [(-30.0, 640.0)], "heading": [(1.0, 0.0)]}
    flock = Flock("vem", start=start, world="open", size=10.0, rng=1)
    assert flock.position.tolist() == [[-30.0, 640.0]]


def test_a_start_without_speeds_sets_off_as_a_random_one_does():
    start = {"position": [(5.0, 5.0, 5.0), (15.0, 5.0, 5.0)], "heading": [(1.0, 0.0, 0.0)] * 2}
    flock = Flock("echelon", start=start, rng=1)
    assert (flock.speed >= flock.parameters.v_min).all()
    still = Flock("echelon", start={**start, "speed": [0.0, 0.0]}, rng=1)
    assert (still.speed == 0.0).all()
