"""The gamma agent on its route, and the path of information agents."""

import numpy as np
import pytest
from asking import goal_at
from hypothesis import given, settings
from hypothesis import strategies as st

from worlds.mission import Goal, Mission, Path, along_route
from worlds.queries.survey import survey_world
from worlds.world import World


def surroundings_of(**parts):
    return survey_world(World("test", (9.0, 9.0), ("open", "open"), mission=Mission(**parts)), 1.0)


def test_a_goal_at_rest():
    surroundings = surroundings_of(goal=Goal(route=((3.0, 4.0),), speed=2.0))
    assert surroundings.goal.tolist() == [[3, 4, 0], [0, 0, 0]]
    assert goal_at(surroundings, 7.0).tolist() == [[3, 4, 0], [0, 0, 0]]


def test_an_open_route_ends():
    surroundings = surroundings_of(goal=Goal(route=((0, 0), (3, 4), (3, 9)), speed=2.0))
    assert goal_at(surroundings, 0.0) == pytest.approx(np.array([[0, 0, 0], [1.2, 1.6, 0]]))
    assert goal_at(surroundings, 2.0) == pytest.approx(np.array([[2.4, 3.2, 0], [1.2, 1.6, 0]]))
    assert goal_at(surroundings, 3.0) == pytest.approx(np.array([[3, 5, 0], [0, 2, 0]]))
    assert goal_at(surroundings, 5.0).tolist() == [[3, 9, 0], [0, 0, 0]]
    assert goal_at(surroundings, 99.0).tolist() == [[3, 9, 0], [0, 0, 0]]


def test_a_closed_route_goes_round():
    surroundings = surroundings_of(
        goal=Goal(route=((0, 0), (4, 0), (4, 3)), speed=1.0, closed=True)
    )
    assert goal_at(surroundings, 9.5) == pytest.approx(np.array([[2, 1.5, 0], [-0.8, -0.6, 0]]))
    assert goal_at(surroundings, 12.0 * 5 + 1.0) == pytest.approx(np.array([[1, 0, 0], [1, 0, 0]]))


coordinate = st.integers(-5, 5).map(float)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=5),
    st.sampled_from([0.0, 0.3, 2.0]),
    st.booleans(),
    st.floats(0.0, 60.0),
)
def test_it_is_where_the_route_says(route, speed, closed, time):
    goal = Goal(route=tuple(route), speed=speed, closed=closed)
    found = goal_at(surroundings_of(goal=goal), time)
    assert found[0, :2] == pytest.approx(along_route(goal, [time])[0], abs=1e-9)
    assert np.linalg.norm(found[1]) == pytest.approx(speed) or (found[1] == 0.0).all()


def test_the_path_of_information_agents():
    surroundings = surroundings_of(path=Path(waypoints=((1, 2), (3, 4)), switch=0.3, closed=True))
    assert surroundings.path.tolist() == [[1, 2, 0], [3, 4, 0]]
    assert (surroundings.switch, surroundings.closed) == (0.3, True)
    assert len(surroundings.route) == len(surroundings.route_length) == 0
