"""Upwash between birds: exact cases of the vortex pair, the best spacing, the V, a naive oracle."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import formation as oracle

from agents.observables import formation
from worlds.input_error import InputError

far = math.inf
spans = st.floats(-5.0, 5.0)


def test_with_line_vortices_the_best_spacing_is_that_of_the_thesis():
    """(2.8): the tip is in the vortex."""
    best = formation.best_spacing(core=0.0)
    assert best.tip == pytest.approx((math.pi / 4.0 - 1.0) / 2.0, abs=2e-9)
    assert best.tip == pytest.approx(formation.THESIS_SPACING, abs=2e-9)
    tip = 1.0 + formation.THESIS_SPACING
    around = formation.upwash_share(far, tip + np.array([-0.01, -1e-4, 1e-4, 0.01]), core=0.0)
    assert (around < formation.upwash_share(far, tip, core=0.0)).all()


def test_what_line_vortices_save_at_best_is_known_in_closed_form():
    x = math.pi / 2.0 + 1.0  # twice the distance of the far vortex, in spans
    exact = 4.0 / math.pi * (1.0 - x + math.sqrt(x * x - 1.0))
    assert float(formation.upwash_share(far, 0.5 + math.pi / 8.0, core=0.0)) == pytest.approx(exact)


def test_with_a_core_wings_overlap_more_and_save_less():
    best = formation.best_spacing()
    assert best.tip == pytest.approx(-0.137, abs=0.0005)
    assert best.saved == pytest.approx(0.692, abs=0.0005)
    tips = np.linspace(-0.5, 1.0, 3001)
    shares = formation.upwash_share(far, 1.0 + tips)
    assert tips[shares.argmax()] == pytest.approx(best.tip, abs=0.0005)
    assert shares.max() <= best.saved < shares.max() + 1e-5


def test_straight_behind_a_bird_its_own_downwash_comes_twice_on_top():
    """Both line vortices lie under the span, where their mean is linear: -4 pi/8 2/pi each."""
    assert float(formation.upwash_share(far, 0.0, core=0.0)) == pytest.approx(-2.0, abs=1e-7)


def test_abreast_each_has_half_of_what_the_one_far_behind_has():
    abreast = formation.upwash_share(0.0, 0.9, 0.1)
    assert abreast == pytest.approx(0.5 * formation.upwash_share(far, 0.9, 0.1), abs=1e-12)


@given(dx=spans, dy=spans, dz=spans, core=st.floats(0.0, 0.2))
def test_what_two_birds_save_together_does_not_hang_on_who_is_how_far_ahead(dx, dy, dz, core):
    """Munk's stagger theorem, 1923."""
    two = formation.upwash_share(dx, dy, dz, core) + formation.upwash_share(-dx, dy, dz, core)
    assert two == pytest.approx(float(formation.upwash_share(far, dy, dz, core)), abs=1e-9)


@given(dx=spans, dy=spans, dz=spans)
def test_left_and_right_and_above_and_below_are_the_same(dx, dy, dz):
    mirrored = formation.upwash_share(dx, [-dy, dy, -dy], [dz, -dz, -dz])
    np.testing.assert_allclose(mirrored, formation.upwash_share(dx, dy, dz), atol=1e-12)


def test_in_a_plane_across_the_wake_upwash_and_downwash_cancel():
    """A vortex pair moves no air up on the whole; far aside the share falls as 1/(4 dy^2)."""
    dy = np.linspace(-400.0, 400.0, 800_001)
    share = formation.upwash_share(far, dy)
    beyond = 2.0 / (4.0 * 400.0)
    assert share.sum() * 1e-3 == pytest.approx(-beyond, rel=1e-3)
    assert share.max() > 0.6


@settings(max_examples=80, deadline=None)
@given(dx=spans, dy=spans, dz=spans, core=st.floats(0.02, 0.2))
def test_the_share_is_the_loaded_mean_of_the_upwash_over_the_span(dx, dy, dz, core):
    found = float(formation.upwash_share(dx, dy, dz, core))
    assert found == pytest.approx(oracle.share(dx, dy, dz, core), abs=1e-6)


def test_from_a_span_behind_the_wakes_beginning_may_be_taken_at_the_middle_of_the_span():
    for dx in (1.0, 1.5, 3.0):
        for dy in np.linspace(0.0, 3.0, 31):
            for dz in (0.0, 0.2, 0.5):
                found = float(formation.upwash_share(dx, dy, dz))
                assert found == pytest.approx(oracle.share(dx, dy, dz, 0.04, True), abs=0.02)


@st.composite
def flocks(draw):
    dim = draw(st.sampled_from((2, 3)))
    n = draw(st.integers(1, 8))
    chance = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    way = np.eye(dim)[0] * draw(st.sampled_from((2.0, 6.0))) + chance.normal(size=(n, dim))
    heading = way / np.linalg.norm(way, axis=1, keepdims=True)
    position = chance.uniform(0.0, draw(st.sampled_from((3.0, 12.0))), (n, dim))
    return position, heading, draw(st.sampled_from((0.5, 1.0, 2.5)))


def decided(position, heading, span):
    """Whether no bird is counted or not by the last bits of a number."""
    apart = np.linalg.norm(position[None] - position[:, None], axis=2) / span
    angle = np.degrees(np.arccos(np.clip(heading @ heading.T, -1.0, 1.0)))
    return (abs(apart - 6.0) > 1e-9).all() and (abs(angle - 30.0) > 1e-6).all()


@settings(max_examples=60, deadline=None)
@given(flock=flocks())
def test_a_flock_is_the_sum_over_pairs(flock):
    assume(decided(*flock))
    np.testing.assert_allclose(formation.saved_shares(*flock), oracle.saved(*flock), atol=2e-6)


def turned(vectors, angle):
    """Vectors (N, 3) turned about the vertical."""
    c, s = math.cos(angle), math.sin(angle)
    return vectors @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


@settings(max_examples=30, deadline=None)
@given(angle=st.floats(-math.pi, math.pi), climb=st.floats(-1.2, 1.2), scale=st.floats(0.1, 20.0))
def test_a_v_saves_the_same_wherever_it_heads_and_however_large_it_is(angle, climb, scale):
    places = formation.vee(8, 0.7)
    level = formation.saved_shares(places, np.tile([1.0, 0.0, 0.0], (8, 1)), 1.0)
    c, s = math.cos(climb), math.sin(climb)
    pitch = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    heading = turned(np.tile([1.0, 0.0, 0.0], (8, 1)) @ pitch, angle)
    moved = scale * turned(places @ pitch, angle) + 3.0
    np.testing.assert_allclose(formation.saved_shares(moved, heading, scale), level, atol=1e-6)


def test_one_bird_saves_nothing_and_none_are_none():
    assert formation.saved_shares(np.zeros((1, 3)), np.eye(3)[:1], 1.0).tolist() == [0.0]
    assert formation.saved_shares(np.zeros((0, 2)), np.zeros((0, 2)), 1.0).shape == (0,)


@pytest.mark.parametrize(
    ("gap", "heading"),
    [
        ([-6.001, 0.8, 0.0], [1.0, 0.0, 0.0]),
        ([-1.0, 0.86, 0.0], [math.cos(math.radians(31)), math.sin(math.radians(31)), 0.0]),
        ([0.86, 0.0, -1.0], [0.0, 0.0, 1.0]),
    ],
    ids=["too far", "not aligned", "straight up"],
)
def test_a_bird_that_does_not_count(gap, heading):
    other = heading if heading[2] else [1.0, 0.0, 0.0]
    both = formation.saved_shares(np.array([[0.0, 0.0, 0.0], gap]), np.array([other, heading]), 1.0)
    assert both.tolist() == [0.0, 0.0]


def test_the_wake_fades_by_its_age():
    ahead = np.tile([1.0, 0.0, 0.0], (2, 1))
    places = np.array([[0.0, 0.0, 0.0], [-4.0, 0.9, 0.0]])
    found = formation.saved_shares(places, ahead, 1.0)
    assert found[1] == pytest.approx(
        float(formation.upwash_share(4.0, 0.9)) * math.exp(-0.4), rel=1e-9
    )
    assert found[0] == pytest.approx(float(formation.upwash_share(-4.0, 0.9)), rel=1e-9)


def test_across_an_edge_that_wraps_the_nearest_image_counts():
    ahead = np.tile([1.0, 0.0], (2, 1))
    size, images = np.array([20.0, 20.0]), np.ones(2, bool)
    inside = formation.saved_shares(np.array([[5.0, 5.0], [4.0, 5.9]]), ahead, 1.0)
    across = np.array([[0.5, 19.5], [19.5, 0.4]])
    np.testing.assert_allclose(
        formation.saved_shares(across, ahead, 1.0, size, images), inside, atol=1e-9
    )
    assert not formation.saved_shares(across, ahead, 1.0).any()


def test_the_v_of_eight_saves_what_the_sum_over_its_pairs_says_and_jitter_costs_it():
    """35 % of the power induced: the reading's 24 % exact; 16, 8 and 2 % were its jitter."""
    exact = formation.vee_saved(8)[0]
    ahead = np.tile([1.0, 0.0, 0.0], (8, 1))
    np.testing.assert_allclose(exact, oracle.saved(formation.vee(8), ahead, 1.0), atol=2e-6)
    percent = [
        100.0 * formation.INDUCED * formation.vee_saved(8, jitter, 400).mean()
        for jitter in (0.0, 0.1, 0.2, 0.3)
    ]
    assert percent == pytest.approx([23.9, 14.0, 7.6, 3.6], abs=0.6)
    assert percent[0] > percent[1] > percent[2] > percent[3] > 0.0


def test_a_v_has_two_arms_at_the_best_spacing():
    places = formation.vee(5, 0.5, -0.1)
    np.testing.assert_allclose(
        places,
        [[0, 0, 0], [-0.5, 0.9, 0], [-0.5, -0.9, 0], [-1, 1.8, 0], [-1, -1.8, 0]],
        atol=1e-12,
    )


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: formation.upwash_share(1.0, 1.0, core=-0.1), "core = -0.1 span"),
        (lambda: formation.saved_shares(np.zeros((2, 2)), np.zeros((2, 2)), 0.0), "span = 0.0"),
        (lambda: formation.vee(0), "birds = 0"),
        (lambda: formation.vee_saved(3, -1.0), "jitter = -1.0 span"),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()
