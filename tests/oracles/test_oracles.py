"""The oracles of contact, layers and rules against cases small enough to work out by hand."""

import math

import numpy as np
import pytest

from oracles import topology
from oracles import vicsek_family as family
from oracles.vicsek_family import Parameters, State

BOX = np.array([10.0, 10.0])


def headings(*angles):
    """Unit vectors (N, 2) at the given angles (rad)."""
    return np.array([family.unit(a) for a in angles])


def flock(position, angles, informed=(), **parameters):
    """A start and its parameters in an open plane; `informed` lists rows."""
    position = np.array(position, dtype=float)
    mask = np.isin(np.arange(len(position)), informed)
    p = Parameters(**{"v0": 0.0} | parameters)
    return family.begin(position, headings(*angles), mask, p, BOX, "open"), p


def angles_after(model, start, p, **noise_of):
    """Angles (N,) in [0, 2 pi) after one synchronous step in an open plane."""
    after = family.step(model, start, p, BOX, "open", **noise_of)
    return [family.angle(u) for u in after.heading]


# --- contact and layers -----------------------------------------------------------------------


def test_contact_includes_r_and_leaves_out_distance_zero():
    x = np.array([[0, 0], [3, 4], [3, 4], [6, 8.000001]])
    touch = topology.contact(x, 5.0, BOX, "open")
    assert np.argwhere(touch).tolist() == [[0, 1], [0, 2], [1, 0], [2, 0]]


def test_contact_is_lost_just_beyond_r():
    x = np.array([[0.0, 0.0], [1.0 + 1e-12, 0.0]])
    assert not topology.contact(x, 1.0, BOX, "open").any()


@pytest.mark.parametrize(
    ("edges", "touches"), [("wrap", True), ("wrap-plain", False), ("open", False)]
)
@pytest.mark.parametrize("dim", [2, 3])
def test_only_wrap_sees_across_the_seam(edges, touches, dim):
    x = np.full((2, dim), 5.0)
    x[:, -1] = 0.1, 9.9
    size = np.full(dim, 10.0)
    assert topology.contact(x, 0.5, size, edges)[0, 1] == touches
    apart = 0.2 if touches else 9.8
    assert topology.distances(x, size, edges)[0, 1] == pytest.approx(apart)


def test_three_in_a_line_are_layers_one_two_three():
    start, _ = flock([[0, 0], [1, 0], [2, 0]], [0, 0, 0], informed=[0])
    assert start.layer.tolist() == [1, 2, 3]


def test_agents_no_chain_leads_to_are_unknown():
    start, _ = flock([[0, 0], [1, 0], [5, 0], [6, 0]], [0] * 4, informed=[0])
    assert start.layer.tolist() == [1, 2, 5, 5]


def test_layers_take_the_shortest_of_two_ways():
    ring = [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert flock(ring, [0] * 4, informed=[0])[0].layer.tolist() == [1, 2, 3, 2]
    assert flock(ring, [0] * 4, informed=[0, 2])[0].layer.tolist() == [1, 2, 1, 2]


def test_delayed_layers_spread_one_agent_per_tick():
    start, p = flock([[x, 0] for x in range(5)], [0] * 5, informed=[0])
    state = State(start.position, start.heading, np.array([1, 6, 6, 6, 6]), start.informed)
    seen = []
    for _ in range(4):
        state = family.step("hwvem", state, p, BOX, "open")
        seen.append(state.layer.tolist())
    assert seen == [[1, 2, 6, 6, 6], [1, 2, 3, 6, 6], [1, 2, 3, 4, 6], [1, 2, 3, 4, 5]]


def test_a_cut_off_pair_counts_up_and_stops_at_unknown():
    start, p = flock([[0, 0], [5, 0], [6, 0]], [0] * 3, informed=[0])
    state = State(start.position, start.heading, np.array([1, 2, 3]), start.informed)
    seen = []
    for _ in range(3):
        state = family.step("hwvem", state, p, BOX, "open")
        seen.append(state.layer.tolist())
    assert seen == [[1, 4, 3], [1, 4, 4], [1, 4, 4]]


def test_an_agent_that_loses_all_neighbours_loses_its_layer():
    alone = topology.next_layers([1, 2], np.zeros((2, 2), bool), np.array([True, False]))
    assert alone.tolist() == [1, 3]


def test_instant_layers_are_those_of_the_positions_now():
    start, p = flock([[x, 0] for x in range(3)], [0, 1, 2], informed=[0], layers="instant")
    stale = State(start.position, start.heading, np.array([1, 4, 4]), start.informed)
    assert angles_after("hwvem", stale, p)[1] != pytest.approx(1)
    delayed = Parameters(v0=0.0)
    assert angles_after("hwvem", stale, delayed)[2] == pytest.approx(2), "nobody known: keep"


# --- rules ------------------------------------------------------------------------------------


def test_vem_counts_itself_and_the_others_do_not():
    start, p = flock([[0, 0], [1, 0]], [0.2, 1.0])
    for model in ("vem", "vem-a"):
        assert angles_after(model, start, p) == pytest.approx([0.6, 0.6])
    for model in ("ivem", "ivem-a"):  # one neighbour: no deviation to halve
        assert angles_after(model, start, p) == pytest.approx([0.2, 1.0])
    assert angles_after("wvem", start, p) == pytest.approx([1.0, 0.2])
    assert angles_after("hwvem", start, p) == pytest.approx([0.2, 1.0]), "no layer known"


@pytest.mark.parametrize("model", family.MODELS)
def test_an_isolated_agent_flies_straight_on(model):
    start, p = flock([[0, 0], [3, 0]], [0.2, 4.0], v0=0.5)
    after = family.step(model, start, p, BOX, "open")
    assert np.allclose(after.heading, start.heading, atol=1e-15)
    assert np.allclose(after.position, start.position + 0.5 * start.heading, atol=1e-15)


@pytest.mark.parametrize("model", family.MODELS)
def test_the_information_agent_keeps_its_heading_moves_and_wraps(model):
    x = np.array([[9.9, 5.0], [9.5, 5.0]])
    mask = np.array([True, False])
    p = Parameters(v0=0.2)
    start = family.begin(x, headings(0, 2), mask, p, BOX, "wrap")
    after = family.step(model, start, p, BOX, "wrap", turn=np.array([1.0, 0.0]))
    assert after.heading[0].tolist() == [1.0, 0.0]
    assert after.position[0] == pytest.approx([0.1, 5.0])


def test_opposite_headings_cancel_and_are_kept():
    start, p = flock([[0, 0], [1, 0], [0.5, 0.5]], [0, math.pi, 0.7])
    assert angles_after("wvem", start, p)[2] == pytest.approx(0.7)


def test_wvem_weights_thirty_eighteen_one():
    # rows: information agent, in contact with it, not in contact with it, the one who listens
    x = [[0, 0], [0.5, 0.5], [1.7, 0], [0.9, 0]]
    start, p = flock(x, [0, 1, 2, 3], informed=[0])
    touch = topology.contact(start.position, 1.0, BOX, "open")
    assert family.wvem_weights(3, start.layer, touch, p).tolist() == [30, 18, 1, 0]
    assert family.wvem_weights(2, start.layer, touch, p).tolist() == [0, 0, 0, 18]
    expected = 30 * family.unit(0) + 18 * family.unit(1) + family.unit(2)
    assert angles_after("wvem", start, p)[3] == pytest.approx(family.angle(expected))


def test_hwvem_weights_by_hand():
    layer = np.array([3, 1, 2, 2, 3, 3, 8])  # N = 7: 8 is unknown
    touch = np.zeros((7, 7), bool)
    touch[0, 1:] = True
    with_status = family.hwvem_weights(0, layer, touch, Parameters(p1=0.1, p2=5.0))
    ln3, ln6 = 1.0986122886681098, 1.791759469228055
    one, two, three = 1.1 * ln6, 0.6 / 5 * ln3, (1 / 3 + 0.1) / 25 * ln3
    assert with_status == pytest.approx([0, one, two, two, three, three, 0], rel=1e-14)
    plain = Parameters(p1=0.1, p2=5.0, neighbourhood_weight=False)
    expected = [0, 1.1, 0.12, 0.12, 13 / 750, 13 / 750, 0]
    assert family.hwvem_weights(0, layer, touch, plain) == pytest.approx(expected, rel=1e-14)


def test_hwvem_status_is_one_up_to_e():
    touch = np.zeros((8, 8), bool)
    touch[0, 1:] = True
    p = Parameters(p1=0.0, p2=1.0)
    crowd = np.array([2, 1, 1, 1, 2, 2, 2, 2])  # d = 7/3 and 7/4, both below e
    assert family.hwvem_weights(0, crowd, touch, p).tolist() == [0, 1, 1, 1, 0.5, 0.5, 0.5, 0.5]
    few = np.array([2, 1, 1, 2, 2, 2, 2, 2])  # d = 7/2 above e
    assert family.hwvem_weights(0, few, touch, p)[1] == pytest.approx(math.log(3.5))


def test_hwvem_relative_weight_does_not_underflow():
    layer = np.array([200, 199] + [500] * 498)
    touch = np.zeros((500, 500), bool)
    touch[0, 1] = True
    assert family.hwvem_weights(0, layer, touch, Parameters(p2=100.0))[1] == 1 / 199 + 0.1


def test_hwvem_follows_the_higher_layer():
    start, p = flock([[0, 0], [1, 0], [2, 0]], [0, 1, 2], informed=[0], p1=0.0, p2=5.0)
    # the middle agent hears layer 1 with weight 1 and layer 3 with weight (1/3) / 5**2
    expected = family.unit(0) + family.unit(2) / 75
    assert angles_after("hwvem", start, p)[1] == pytest.approx(family.angle(expected))
    assert angles_after("hwvem", start, p)[2] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("own", "after"), [(0.1, 0.3), (0.3, 0.5), (0.5, 0.5), (0.7, 0.5), (1.0, 0.8)]
)
def test_ivem_moves_towards_the_middle_of_the_extremes(own, after):
    start, p = flock([[0, 0], [0.5, 0], [0, 0.5]], [own, 0.3, 0.7])
    assert angles_after("ivem", start, p)[0] == pytest.approx(after)


def test_ivem_does_not_wrap_its_differences():
    start, p = flock([[0, 0], [0.5, 0], [0, 0.5]], [0.1, 0.2, 6.2])
    assert angles_after("ivem", start, p)[0] == pytest.approx(3.1)


def test_ivem_a_listens_to_the_information_agent_with_weight_100():
    start, p = flock([[0, 0], [0.5, 0], [0, 0.5]], [0.1, 0.3, 5.5], informed=[1])
    expected = 100 * family.unit(0.3) + family.unit(5.5)
    assert angles_after("ivem-a", start, p)[0] == pytest.approx(family.angle(expected))
    assert angles_after("ivem", start, p)[0] == pytest.approx(0.1 + (5.5 - 0.3) / 2)


def test_averaging_in_three_dimensions():
    x = np.array([[0, 0, 0], [0, 0, 0.5], [0, 0.5, 0.0]])
    u = np.eye(3)
    p = Parameters(v0=0.1)
    start = family.begin(x, u, np.zeros(3, bool), p, np.ones(3), "open")
    after = family.step("vem", start, p, np.ones(3), "open")
    assert after.heading == pytest.approx(np.full((3, 3), 1 / math.sqrt(3)))
    assert after.position == pytest.approx(x + 0.1 / math.sqrt(3))


def test_angular_noise_turns_after_the_decision():
    start, p = flock([[0, 0], [1, 0]], [0.2, 1.0])
    assert angles_after("vem", start, p, turn=np.array([0.1, 0.3])) == pytest.approx([0.7, 0.9])


def test_vectorial_noise_is_added_to_the_mean():
    start, p = flock([[0, 0], [1, 0], [5, 5]], [0.5, -0.5, 0.0], eta=1.0)
    xi = np.array([[0.0, 1.0], [0.0, -1.0], [0.0, 1.0]])
    mean = math.cos(0.5)  # of the two in contact, along x
    expected = [math.atan2(1, mean), math.tau - math.atan2(1, mean), math.pi / 4]
    assert angles_after("vem", start, p, xi=xi) == pytest.approx(expected)


def test_sequential_agents_see_those_before_them():
    start, p = flock([[0, 0], [1, 0]], [0.0, 1.0])
    after = family.step_sequentially("vem", start, [0, 1], p, BOX, "open")
    assert [family.angle(u) for u in after.heading] == pytest.approx([0.5, 0.75])
    after = family.step_sequentially("vem", start, [1, 0], p, BOX, "open")
    assert [family.angle(u) for u in after.heading] == pytest.approx([0.25, 0.5])
    assert [family.angle(u) for u in start.heading] == pytest.approx([0.0, 1.0]), "not written"


def test_sequential_agents_see_moves_and_layers():
    # the information agent steps into reach of 1 before 1 acts; 2 then hears of 1's new layer
    start, p = flock([[0, 0], [1.5, 0], [2.5, 0]], [0, 1, 2], informed=[0], v0=0.6)
    after = family.step_sequentially("hwvem", start, [0, 1, 2], p, BOX, "open")
    assert start.layer.tolist() == [1, 4, 4]
    assert after.layer.tolist()[:2] == [1, 2]
    assert family.angle(after.heading[1]) == pytest.approx(0.0)
    late = family.step_sequentially("hwvem", start, [2, 1, 0], p, BOX, "open")
    assert late.layer.tolist() == [1, 4, 4]


@pytest.mark.parametrize("edges", ["wrap", "wrap-plain"])
def test_positions_wrap_into_the_box(edges):
    x = np.array([[9.9, 0.1], [0.0, 0.0]])
    u = np.array([[0.6, -0.8], [-1.0, 0.0]])
    moved = family.moved(x, u, 0.5, BOX, edges)
    assert moved == pytest.approx(np.array([[0.2, 9.7], [9.5, 0.0]]))
    tiny = family.moved(np.zeros((1, 2)), np.array([[-1.0, 0.0]]), 1e-18, BOX, edges)
    assert tiny.tolist() == [[0.0, 0.0]], "the upper border is not in the box"
