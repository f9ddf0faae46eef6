"""Random worlds: what their parameters promise, for any seed; and what does not fit."""

import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from worlds.checks import problems
from worlds.generators import GENERATORS, generate
from worlds.input_error import InputError
from worlds.obstacles import Box, Disc, Polygon, Sphere, Wall

SEEDS = st.integers(0, 2**32)


def free(made):
    """The floor that is not solid."""
    solid = shapely.union_all([one.footprint() for one in made.obstacles])
    return shapely.box(0.0, 0.0, *made.size[:2]).difference(solid)


def least_apart(obstacles):
    pairs = itertools.combinations([one.footprint() for one in obstacles], 2)
    return min(one.distance(other) for one, other in pairs)


@pytest.mark.parametrize("kind", sorted(GENERATORS))
def test_a_seed_repeats_the_world_and_another_gives_another(kind):
    one, again, other = (generate(kind, seed, (50, 30)) for seed in (4, 4, 5))
    assert one == again
    assert one.obstacles != other.obstacles
    assert one.edges == ("solid", "solid")
    assert one.size == (50.0, 30.0)
    assert "seed 4" in one.source


@pytest.mark.parametrize("kind", sorted(GENERATORS))
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_every_world_is_sound(kind, seed):
    assert [p for p in problems(generate(kind, seed, (60, 40))) if p.severity == "error"] == []


@given(seed=SEEDS, count=st.integers(1, 25), gap=st.floats(0.0, 1.5))
@settings(max_examples=40, deadline=None)
def test_discs_keep_their_gap_and_radii(seed, count, gap):
    values = {"count": count, "gap": gap, "radius_low": 0.5, "radius_high": 1.5}
    discs = generate("discs", seed, (50, 40), **values).obstacles
    assert len(discs) == count
    for one in discs:
        assert isinstance(one, Disc)
        assert 0.5 <= one.radius <= 1.5
        for at, side in zip(one.centre, (50.0, 40.0), strict=True):
            assert one.radius + gap - 1e-9 <= at <= side - one.radius - gap + 1e-9
    for one, other in itertools.combinations(discs, 2):
        assert math.dist(one.centre, other.centre) >= one.radius + other.radius + gap - 1e-9


@given(seed=SEEDS)
@settings(max_examples=20, deadline=None)
def test_spheres_keep_their_gap(seed):
    balls = generate("discs", seed, (20, 20, 15), count=15, gap=1.0).obstacles
    for one in balls:
        assert isinstance(one, Sphere)
        for at, side in zip(one.centre, (20.0, 20.0, 15.0), strict=True):
            assert one.radius + 1.0 - 1e-9 <= at <= side - one.radius - 1.0 + 1e-9
    for one, other in itertools.combinations(balls, 2):
        assert math.dist(one.centre, other.centre) >= one.radius + other.radius + 1.0 - 1e-9


@given(seed=SEEDS, gap=st.floats(0.0, 2.0))
@settings(max_examples=30, deadline=None)
def test_blocks_are_rectangles_that_keep_their_gap(seed, gap):
    blocks = generate("blocks", seed, (70, 50), count=8, gap=gap).obstacles
    inner = shapely.box(gap, gap, 70 - gap, 50 - gap).buffer(1e-9)
    for one in blocks:
        assert isinstance(one, Polygon)
        a, b, c, d = (np.array(point) for point in one.points)
        sides = sorted((math.dist(a, b), math.dist(b, c)))
        assert sides[0] >= 2.0 - 1e-9
        assert sides[1] <= 8.0 + 1e-9
        assert np.allclose(a + c, b + d)
        assert abs((b - a) @ (c - b)) < 1e-9
        assert inner.covers(one.footprint())
    assert least_apart(blocks) >= gap - 1e-9


@given(seed=SEEDS)
@settings(max_examples=20, deadline=None)
def test_boxes_in_space_keep_their_gap(seed):
    boxes = generate("blocks", seed, (40, 40, 20), count=6, gap=1.5).obstacles
    for one in boxes:
        assert isinstance(one, Box)
        assert min(one.low) >= 1.5 - 1e-9
        assert np.all(np.array(one.high) <= np.array([40.0, 40.0, 20.0]) - 1.5 + 1e-9)
    for one, other in itertools.combinations(boxes, 2):
        between = np.maximum(
            np.subtract(one.low, other.high), np.subtract(other.low, one.high)
        ).clip(0.0)
        assert np.linalg.norm(between) >= 1.5 - 1e-9


@given(seed=SEEDS, density=st.sampled_from([0.005, 0.02, 0.04]))
@settings(max_examples=10, deadline=None)
def test_a_forest_has_its_density_and_gap(seed, density):
    trunks = generate("forest", seed, (50, 40), density=density).obstacles
    assert len(trunks) == round(density * 50 * 40)
    assert least_apart(trunks) >= 1.5
    inner = shapely.box(1.5, 1.5, 48.5, 38.5)
    assert all(inner.covers(one.footprint()) for one in trunks)


@given(seed=SEEDS, walls=st.integers(1, 6), gaps=st.integers(1, 4))
@settings(max_examples=30, deadline=None)
def test_corridors_have_their_walls_and_gaps(seed, walls, gaps):
    made = generate("corridors", seed, (42, 30), walls=walls, gaps=gaps)
    for k in range(1, walls + 1):
        line = shapely.LineString([(42 * k / (walls + 1), 0.0), (42 * k / (walls + 1), 30.0)])
        openings = shapely.get_parts(line.intersection(free(made)))
        openings = [one for one in openings if one.length > 1e-9]
        assert len(openings) == gaps
        assert [one.length for one in openings] == pytest.approx([3.0] * gaps)
    assert free(made).geom_type == "Polygon"


@given(seed=SEEDS, nx=st.integers(2, 9), ny=st.integers(2, 9))
@settings(max_examples=30, deadline=None)
def test_a_maze_without_loops_is_a_tree_of_cells(seed, nx, ny):
    made = generate("maze", seed, (5.0 * nx, 5.0 * ny), cell=5.0, thickness=0.4)
    floor = free(made)
    assert floor.geom_type == "Polygon"
    middles = {(x, y): (5.0 * x + 2.5, 5.0 * y + 2.5) for x in range(nx) for y in range(ny)}
    doors = [
        pair
        for pair in itertools.combinations(middles, 2)
        if math.dist(*pair) == 1.0
        and floor.covers(shapely.LineString([middles[cell] for cell in pair]))
    ]
    assert len(doors) == nx * ny - 1
    reached = {(0, 0)}
    for _ in middles:
        reached |= {b for pair in doors for a, b in (pair, pair[::-1]) if a in reached}
    assert reached == set(middles)


@given(seed=SEEDS, loops=st.sampled_from([0.0, 0.3]))
@settings(max_examples=8, deadline=None)
def test_the_path_of_a_maze_leads_through_it(seed, loops):
    made = generate("maze", seed, (60, 40), loops=loops)
    start = np.array(made.mission.start.low) + 0.5 * np.subtract(
        made.mission.start.high, made.mission.start.low
    )
    way = [tuple(start), *made.mission.path.waypoints]
    assert way[0] == pytest.approx((2.5, 2.5))
    assert way[-1] == pytest.approx((57.5, 37.5))
    assert made.mission.goal.route == (way[-1],)
    for leg in itertools.pairwise(way):
        assert shapely.LineString(leg).distance(free(made).boundary) >= 2.0


def test_loops_take_walls_away():
    def length(loops):
        made = generate("maze", 3, (60, 40), loops=loops).obstacles
        assert all(isinstance(one, Wall) for one in made)
        return sum(math.dist(one.start, one.end) for one in made)

    assert length(0.0) > length(0.3) > length(0.8) > length(1.0) == 0.0


@pytest.mark.parametrize(
    ("kind", "values", "words"),
    [
        ("disks", {}, ["unknown kind of world 'disks'", "did you mean 'discs'?"]),
        ("discs", {"seed": -1}, ["seed = -1", ">= 0"]),
        ("discs", {"size": (10, 0)}, ["size = 0", "(0, 1e9)"]),
        ("maze", {"size": (20, 20, 9)}, ["dim = 3", "maze is made in 2-D"]),
        ("discs", {"raduis_low": 1.0}, ["unknown parameter of discs", "'radius_low'", "(here)"]),
        ("discs", {"count": 0}, ["count = 0", "a whole number >= 1", "(here)"]),
        ("discs", {"count": 2.5}, ["count = 2.5", "a whole number"]),
        ("discs", {"radius_low": -1.0}, ["radius_low = -1.0", "a number > 0"]),
        ("discs", {"gap": float("nan")}, ["gap = nan", "a number >= 0"]),
        ("discs", {"radius_low": 3.0}, ["radius_low = 3 m is above radius_high = 2 m"]),
        ("discs", {"count": 400}, ["count = 400 discs", "do not fit in 60 x 40 m", "5000 tries"]),
        ("discs", {"radius_high": 90.0}, ["do not fit in 60 x 40 m: 0 found a place"]),
        ("blocks", {"side_low": 9.0}, ["side_low = 9 m is above side_high = 8 m"]),
        ("blocks", {"count": 90}, ["count = 90 blocks", "do not fit in 60 x 40 m", "2000 tries"]),
        ("blocks", {"count": 300, "size": (9, 9, 9)}, ["count = 300", "9 x 9 x 9 m"]),
        ("forest", {"radius_low": 1.0}, ["radius_low = 1 m is above radius_high = 0.6 m"]),
        ("forest", {"density": 0.5}, ["density = 0.5 per m²", "of 1200 trunks found a place"]),
        ("forest", {"density": 0.0}, ["density = 0.0", "> 0"]),
        ("corridors", {"walls": 200}, ["walls = 200", "do not fit in 60 m"]),
        ("corridors", {"gaps": 20}, ["gaps = 20 of width = 3 m", "a wall 40 m long"]),
        ("maze", {"cell": 25.0}, ["cell = 25 m makes 2 x 1 cells of 60 x 40 m", "2 x 2"]),
        ("maze", {"cell": 0.1}, ["600 x 400 cells", "at most 40000"]),
        ("maze", {"thickness": 2.5}, ["thickness = 2.5 m is not less than half a cell (2.5 m)"]),
        ("maze", {"loops": 2.0}, ["loops = 2.0", "a number >= 0 and <= 1"]),
    ],
)
def test_what_does_not_fit_is_refused(kind, values, words):
    values = {"seed": 1, "size": (60, 40), **values}
    with pytest.raises(InputError) as refusal:
        generate(kind, origin="here", **values)
    for word in words:
        assert word in str(refusal.value)
