"""Layouts: what they come to, and that a world writes the layout it is made of."""

import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import crowds, solids

from worlds.input_error import InputError
from worlds.layout import layout_names, read_layout, world, world_from_layout
from worlds.mission import Goal, Mission, Path, StartRegion
from worlds.world import World

OBSTACLE = {"shape": "disc", "centre": [5.0, 5.0], "radius": 1.0}


@pytest.mark.parametrize("name", layout_names())
def test_every_built_in_layout_is_sound_and_survives_a_round_trip(name):
    found = world(name, unsized=lambda dim: 5.0 + dim)
    assert found.title
    assert world_from_layout(tomllib.loads(found.to_toml()), name) == found


number = st.floats(-1e6, 1e6, allow_subnormal=False)
place = st.tuples(number, number)
missions = st.builds(
    Mission,
    start=st.one_of(
        st.none(),
        st.builds(
            lambda low, side, speed: StartRegion(
                low=low,
                high=(low[0] + side, low[1] + 2 * side),
                speed_low=(0.0, 0.0),
                speed_high=(speed, speed),
            ),
            place,
            st.floats(0.1, 50.0),
            st.floats(0.0, 3.0),
        ),
        st.builds(lambda low, d: StartRegion(low=low, density=d), place, st.floats(0.01, 9.0)),
    ),
    path=st.one_of(
        st.none(),
        st.builds(lambda w: Path(waypoints=(w, w), switch=0.1), place),
    ),
    goal=st.one_of(st.none(), st.builds(lambda w: Goal(route=(w,), closed=True), place)),
    success=st.sampled_from([None, "connected", "arrived"]),
)


@settings(max_examples=60, deadline=None)
@given(
    st.one_of(crowds, solids),
    missions,
    st.tuples(st.floats(0.1, 1e3), st.floats(0.1, 1e3)),
    st.sampled_from([2, 3]),
)
def test_a_round_trip_keeps_every_bit(obstacles, mission, sides, dim):
    low = (-0.1, 1.0 / 3.0, 2.0 / 3.0)[:dim]
    size, edges = (*sides, 9.7)[:dim], ("open", "solid", "open")[:dim]
    mission = mission.standing(3.3) if dim == 3 else mission
    made = World("w", size, edges, "plain", 'a "title"', low, obstacles, mission, 2.2, 0.3, "me")
    assert world_from_layout(tomllib.loads(made.to_toml()), "w") == made


def test_a_flat_layout_stands_up():
    layout = {
        "edges": ["open", "solid"],
        "low": [-2, 1],
        "size": [10, 20],
        "obstacle": [OBSTACLE],
        "mission": {
            "start": {"low": [0, 0], "high": [1, 1]},
            "path": {"waypoints": [[1, 1]], "switch": 1},
            "goal": {"route": [[2, 2]]},
        },
    }
    flat = world_from_layout(layout, "w")
    assert (flat.dim, flat.size, flat.low, flat.height) == (2, (10, 20), (-2, 1), 2.0)
    tall = world_from_layout(layout, "w", 3)
    assert (tall.size, tall.low, tall.height) == ((10, 20, 2), (-2, 1, 0), 2.0)
    assert tall.edges == ("open", "solid", "solid")
    assert tall.mission.start.high == (1, 1, 2)
    assert tall.mission.path.waypoints == ((1, 1, 1),)
    assert tall.mission.goal.route == ((2, 2, 1),)
    assert world_from_layout({**layout, "height": 6, "edges": "open"}, "w", 3).size == (10, 20, 6)


def test_size_is_the_layouts_own_unless_another_is_given():
    assert world_from_layout({"size": 4.0}, "w", 3).size == (4, 4, 4)
    assert world_from_layout({"size": 4.0}, "w", 2, 9.0).size == (9, 9)
    assert world("wrap", 2, unsized=lambda dim: 3.0 * dim).size == (6, 6)
    assert world("wrap", None, [3, 4, 5][:2]).size == (3, 4)
    kept = {"size": [4.0, 4.0], "obstacle": [OBSTACLE]}
    assert world_from_layout(kept, "w", 2, 4.0).size == (4, 4)


def test_what_is_solid():
    assert not world("wrap", 2, 5.0).is_solid
    assert world_from_layout({"edges": "solid", "size": 3.0}, "w").is_solid
    assert world("wu2023-multi").is_solid


@pytest.mark.parametrize(
    ("layout", "dim", "size", "says"),
    [
        ({"walls": 3}, 2, 1.0, "unknown key 'walls'"),
        ({"edges": "wall"}, 2, 1.0, "unknown edge 'wall'"),
        ({"edges": ["open"] * 3}, 2, 1.0, "names 3 axes, the world has 2"),
        ({}, 2, None, "w.toml has no size of its own"),
        ({"dim": 4}, None, 1.0, "dim = 4 is not allowed"),
        ({}, 5, 1.0, "dim = 5 is not allowed"),
        ({"dim": 3}, 2, 1.0, "dim = 2 is not allowed: the world w.toml has 3 dimensions"),
        ({"dim": 3, "size": [1, 2]}, None, None, "size = [1, 2] has 2 numbers, not 3"),
        ({"size": [1, -2]}, 2, None, "size = -2 is not allowed"),
        ({"size": 2, "height": 0}, 2, None, "height = 0 is not allowed: a length in"),
        ({"size": 2, "boundary_spacing": "x"}, 2, None, "boundary_spacing = 'x' is not allowed"),
        ({"size": 2, "low": [0, "x"], "edges": "open"}, 2, None, "low = [0, 'x'] is not allowed"),
        ({"size": 2, "low": [1, 0]}, 2, None, "low = [1.0, 0.0] is not allowed: axis x wraps"),
        ({"obstacle": [OBSTACLE]}, 2, 3.0, "w.toml has obstacles but no size"),
        ({"size": 9, "obstacle": [OBSTACLE]}, 2, 3.0, "has obstacles, its size is [9.0, 9.0]"),
        ({"size": 9, "obstacle": OBSTACLE}, 2, None, "write [[obstacle]]"),
        ({"size": 9, "obstacle": [{**OBSTACLE, "radius": 0}]}, 2, None, "radius = 0"),
        ({"size": 9, "mission": {"paths": 1}}, 2, None, "did you mean 'mission.path'?"),
        ({"size": 9, "mission": {"start": {"low": [0, 0]}}}, 2, None, "either high or density"),
        (
            {"size": 9, "mission": {"start": {"low": [0, 0], "high": [0, 1]}}},
            2,
            None,
            "high = [0.0, 1.0] is not above low = [0.0, 0.0]",
        ),
        (
            {"size": 9, "mission": {"path": {"waypoints": [[0, 0], [1, 1, 1]], "switch": 1}}},
            2,
            None,
            "differ in dimension",
        ),
        ({"size": 9, "mission": {"success": "won"}}, 2, None, "success = 'won' is not allowed"),
    ],
)
def test_refusals(layout, dim, size, says):
    with pytest.raises(InputError) as refused:
        world_from_layout(layout, "w.toml", dim, size)
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_multi_layout_is_that_of_the_reading():
    found = world("wu2023-multi")
    assert found.mission.goal.route == ((75.0, 25.0),)
    assert found.mission.start.spacing == 2.0
    assert sum(o.footprint().area for o in found.obstacles) == pytest.approx(
        32 + 28.25 + 28, abs=0.1
    )
    assert read_layout("wu2023-multi")["edges"] == "open"
