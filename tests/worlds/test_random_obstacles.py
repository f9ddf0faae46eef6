"""Random obstacles of a layout: the same for a seed, sound, and written down once drawn."""

import itertools
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worlds.generators import draw_obstacles
from worlds.input_error import InputError
from worlds.layout import world, world_from_layout
from worlds.obstacles import Box, Polygon
from worlds.queries.clearance import clearance
from worlds.queries.survey import survey_world

BLOCKS = {"kind": "blocks", "count": 5, "side_low": 1.0, "side_high": 2.0, "gap": 0.5}
ROOM = {"edges": "solid", "size": [20.0, 20.0, 20.0], "random": BLOCKS}


@given(seed=st.integers(0, 2**32))
@settings(max_examples=25, deadline=None)
def test_the_blocks_of_the_thesis_are_cubes_of_3_in_the_box_that_do_not_overlap(seed):
    made = draw_obstacles(world("thesis-blocks"), seed)
    low, high = (np.array([getattr(b, at) for b in made.obstacles]) for at in ("low", "high"))
    assert len(made.obstacles) == 20
    assert np.allclose(high - low, 3.0, atol=1e-12)
    assert low.min() >= 0.0
    assert high.max() <= 24.0
    for one, other in itertools.combinations(range(20), 2):
        assert ((low[one] >= high[other]) | (low[other] >= high[one])).any()


def test_a_seed_repeats_its_world_and_another_gives_another():
    bare = world("thesis-blocks")
    one, again, other = (draw_obstacles(bare, seed) for seed in (4, 4, 5))
    assert one == again
    assert one.obstacles != other.obstacles
    assert one.name == bare.name == "thesis-blocks"
    assert one.random is None
    assert draw_obstacles(one, 9) is one
    assert one.source.endswith(
        "drawn from seed 4: blocks: count = 20, side_low = 3, side_high = 3, gap = 0"
    )


def test_the_blocks_are_not_the_numbers_that_the_run_starts_with():
    corners = {at for b in draw_obstacles(world("thesis-blocks"), 3).obstacles for at in b.low}
    rng = np.random.default_rng(3)
    numbers = {21.0 * number for number in rng.random(5000)}
    assert not corners & numbers


def test_a_drawn_world_lists_what_it_drew_and_a_bare_one_what_it_will_draw():
    bare = world_from_layout(ROOM, "room")
    assert bare.is_solid
    assert world_from_layout(tomllib.loads(bare.to_toml()), "room") == bare
    made = draw_obstacles(bare, 2)
    layout = tomllib.loads(made.to_toml())
    assert len(layout["obstacle"]) == 5
    assert "random" not in layout
    assert world_from_layout(layout, "room") == made


def test_obstacles_of_its_own_come_first_and_stay():
    own = {"shape": "box", "low": [1.0, 1.0, 1.0], "high": [3.0, 3.0, 3.0]}
    made = draw_obstacles(world_from_layout({**ROOM, "obstacle": [own]}, "room"), 1)
    assert made.obstacles[0] == Box(low=(1.0, 1.0, 1.0), high=(3.0, 3.0, 3.0))
    assert len(made.obstacles) == 6


def test_a_lower_corner_moves_the_obstacles_with_the_box():
    moved = draw_obstacles(world_from_layout({**ROOM, "low": [5.0, -40.0, 100.0]}, "room"), 1)
    for one, other in zip(
        moved.obstacles, draw_obstacles(world_from_layout(ROOM, "room"), 1).obstacles, strict=True
    ):
        assert np.allclose(np.array(one.low) - other.low, [5.0, -40.0, 100.0], atol=1e-9)


def test_obstacles_are_flat_in_the_plane_and_in_a_flat_layout_that_stands_up():
    flat = {"edges": "solid", "size": [30.0, 20.0], "random": BLOCKS}
    plan = draw_obstacles(world_from_layout(flat, "yard"), 6)
    tall = draw_obstacles(world_from_layout({**flat, "height": 4.0}, "yard", 3), 6)
    assert all(isinstance(one, Polygon) for one in plan.obstacles)
    assert tall.obstacles == plan.obstacles
    inside = np.array([[*plan.obstacles[0].footprint().centroid.coords[0], z] for z in (2.0, 5.0)])
    assert np.array_equal(clearance(tall, inside) < 0.0, [True, True])
    flat3 = draw_obstacles(world_from_layout({**ROOM, "random": {**BLOCKS, "dim": 2}}, "room"), 6)
    assert all(isinstance(one, Polygon) for one in flat3.obstacles)
    trees = {"kind": "forest", "density": 0.02}
    forest = world_from_layout({**ROOM, "random": trees}, "wood")
    assert forest.random.dim == 2
    assert len(draw_obstacles(forest, 0).obstacles) == 8


def test_a_maze_brings_its_mission_where_there_is_none():
    layout = {"edges": "solid", "size": [30.0, 30.0], "random": {"kind": "maze"}}
    made = draw_obstacles(world_from_layout(layout, "maze"), 3)
    assert made.mission.goal.route[0] == made.mission.path.waypoints[-1]
    tall = draw_obstacles(world_from_layout({**layout, "height": 6.0}, "maze", 3), 3)
    assert tall.mission.goal.route[0][2] == 3.0
    own = {**layout, "mission": {"success": "connected"}}
    assert draw_obstacles(world_from_layout(own, "maze"), 3).mission.path is None


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("blocks", "random = 'blocks' is not a table: write [random] (w.toml)"),
        ({"count": 3}, "[random] has no kind (known: discs, blocks"),
        ({"kind": "block"}, "unknown kind of random obstacles 'block': did you mean 'blocks'?"),
        ({"kind": "blocks", "cuont": 3}, "unknown parameter of blocks 'cuont': did you mean"),
        ({"kind": "blocks", "count": 0}, "count = 0 is not allowed: a whole number >= 1"),
        ({"kind": "blocks", "dim": 4}, "random.dim = 4 is not allowed: blocks in a world of 3"),
        ({"kind": "forest", "dim": 3}, "are drawn in 2 (w.toml)"),
    ],
)
def test_refusals(table, says):
    with pytest.raises(InputError) as refused:
        world_from_layout({**ROOM, "random": table}, "w.toml")
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_what_does_not_fit_or_hides_a_goal_is_refused_when_it_is_drawn():
    full = {**ROOM, "random": {**BLOCKS, "count": 60, "side_low": 6.0, "side_high": 6.0}}
    bare = world_from_layout(full, "full")
    with pytest.raises(InputError, match=r"count = 60 blocks .* do not fit"):
        draw_obstacles(bare, 1)
    crowded = {"kind": "blocks", "count": 1, "side_low": 19.0, "side_high": 19.0, "gap": 0.0}
    goal = {"goal": {"route": [[10.0, 10.0, 10.0]]}}
    hidden = world_from_layout({**ROOM, "random": crowded, "mission": goal}, "hidden")
    with pytest.raises(InputError, match="inside an obstacle"):
        draw_obstacles(hidden, 1)


@pytest.mark.parametrize("seed", [-1, 1.5, True, "one"])
def test_a_seed_is_a_whole_number(seed):
    with pytest.raises(InputError, match=r"seed = .* is not allowed: a whole number >= 0"):
        draw_obstacles(world("thesis-blocks"), seed)


def test_a_world_that_is_not_drawn_is_not_surveyed():
    bare = world("thesis-blocks")
    with pytest.raises(InputError, match="random obstacles of thesis-blocks are not drawn"):
        survey_world(bare, 5.0)
    assert survey_world(draw_obstacles(bare, 0), 5.0).solids == 20 * 4 + 6
