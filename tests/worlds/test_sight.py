"""Lines of sight on the plan, against shapely."""

import numpy as np
import shapely
from asking import sights
from fine import demand_round, united
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import crowds

from worlds.obstacles import Disc, Wall
from worlds.queries.survey import survey_world
from worlds.world import World


def flat(*obstacles, edges=("open", "open")):
    return World("test", (20.0, 20.0), edges, obstacles=tuple(obstacles))


@settings(max_examples=60, deadline=None)
@given(crowds, st.integers(0, 1000), st.sampled_from([0.3, 5.0, 60.0]))
def test_a_line_is_blocked_where_it_meets_an_outline(obstacles, seed, reach):
    ends = np.random.default_rng(seed).uniform(-10.0, 32.0, (200, 2, 2))
    ends[::4, 1] = ends[::4, 0] + 0.02 * (ends[::4, 1] - ends[::4, 0])
    ends[::7, 1, 0] = ends[::7, 0, 0]
    demand_round(flat(*obstacles), reach)
    outline, slack = united(obstacles, 2**11)
    lines = shapely.linestrings(ends)
    found = sights(survey_world(flat(*obstacles), reach), ends[:, 0], ends[:, 1])
    assert not found[shapely.intersects(outline, lines)].any()
    clear = shapely.distance(outline, lines) > slack
    assert found[clear].all()
    assert (clear | shapely.intersects(outline, lines)).mean() > 0.99


def test_a_line_that_just_passes_a_disc_sees_and_one_that_cuts_it_does_not():
    surroundings = survey_world(flat(Disc(centre=(10, 10), radius=4)), 1.0)
    angle = np.linspace(0.0, 6.28, 40)
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    along = 6.0 * np.column_stack([-out[:, 1], out[:, 0]])
    for share, free in ((1.0 + 1e-9, True), (1.0 - 1e-9, False)):
        middle = 10.0 + 4.0 * share * out
        assert (sights(surroundings, middle - along, middle + along) == free).all()


def test_a_place_sees_itself_unless_it_is_inside():
    surroundings = survey_world(flat(Disc(centre=(5, 5), radius=2)), 1.0)
    here = [(5.0, 5.0), (8.0, 5.0)]
    assert sights(surroundings, here, here).tolist() == [False, True]


def test_solid_edges_of_the_box_hide_nothing():
    surroundings = survey_world(flat(edges=("solid", "solid")), 1.0)
    assert sights(surroundings, [(1.0, 1.0)], [(19.0, 3.0)]).all()


def test_the_far_side_of_a_wall_is_hidden():
    surroundings = survey_world(flat(Wall(start=(10, 2), end=(10, 18), thickness=0.2)), 0.5)
    start, end = [(2, 10), (2, 10), (2, 19)], [(18, 10), (9, 3), (18, 19)]
    assert sights(surroundings, start, end).tolist() == [False, True, True]
