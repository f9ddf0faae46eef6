"""Lines of sight on the plan, against shapely."""

import numpy as np
import shapely
from asking import sights
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import crowds

from worlds.obstacles import Disc, Wall
from worlds.queries.survey import survey
from worlds.world import World


def flat(*obstacles, edges=("open", "open")):
    return World("test", (20.0, 20.0), edges, obstacles=tuple(obstacles))


@settings(max_examples=60, deadline=None)
@given(crowds, st.integers(0, 1000), st.sampled_from([0.3, 5.0, 60.0]))
def test_a_line_is_blocked_where_it_meets_an_outline(obstacles, seed, reach):
    ends = np.random.default_rng(seed).uniform(-10.0, 32.0, (200, 2, 2))
    ends[::4, 1] = ends[::4, 0] + 0.02 * (ends[::4, 1] - ends[::4, 0])
    ends[::7, 1, 0] = ends[::7, 0, 0]
    outline = shapely.union_all([o.footprint() for o in obstacles])
    blocked = shapely.intersects(outline, shapely.linestrings(ends))
    found = sights(survey(flat(*obstacles), reach), ends[:, 0], ends[:, 1])
    assert (found == ~blocked).all()


def test_a_place_sees_itself_unless_it_is_inside():
    surroundings = survey(flat(Disc(centre=(5, 5), radius=2)), 1.0)
    here = [(5.0, 5.0), (8.0, 5.0)]
    assert sights(surroundings, here, here).tolist() == [False, True]


def test_solid_edges_of_the_box_hide_nothing():
    surroundings = survey(flat(edges=("solid", "solid")), 1.0)
    assert sights(surroundings, [(1.0, 1.0)], [(19.0, 3.0)]).all()


def test_the_far_side_of_a_wall_is_hidden():
    surroundings = survey(flat(Wall(start=(10, 2), end=(10, 18), thickness=0.2)), 0.5)
    start, end = [(2, 10), (2, 10), (2, 19)], [(18, 10), (9, 3), (18, 19)]
    assert sights(surroundings, start, end).tolist() == [False, True, True]
