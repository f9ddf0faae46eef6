"""Every rule, tick by tick, against the naive versions in `tests/oracles`."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import vicsek_family as family
from oracles.flocks import angles_of, at_rest, build, parameters
from oracles.following import follow
from oracles.scenes import scene, scenes

AVERAGING = ("vem", "vem-a", "wvem", "hwvem")
PLANAR = ("ivem", "ivem-a")
THOROUGH = settings(max_examples=120, deadline=None, derandomize=True)
BRIEF = settings(max_examples=25, deadline=None, derandomize=True)


# --- one rule after another -------------------------------------------------------------------


@pytest.mark.parametrize("model", AVERAGING)
@THOROUGH
@given(where=scenes())
def test_averaging_rules_in_the_plane_and_in_space(model, where):
    follow(build(model, where, eta=0.0), model, where, parameters(where), ticks=3)


@pytest.mark.parametrize("model", PLANAR)
@THOROUGH
@given(where=scenes(dims=(2,)))
def test_middle_rules_in_the_plane(model, where):
    follow(build(model, where, eta=0.0), model, where, parameters(where), ticks=3)


@THOROUGH
@given(
    where=scenes(),
    p1=st.sampled_from((0.0, 0.1, 2.0)),
    p2=st.sampled_from((1.0, 5.0, 100.0)),
    layers=st.sampled_from(("delayed", "instant")),
    status=st.booleans(),
)
def test_hwvem_with_all_its_parameters(where, p1, p2, layers, status):
    given_ = {"p1": p1, "p2": p2, "layers": layers, "neighbourhood_weight": status}
    flock = build("hwvem", where, eta=0.0, **given_)
    follow(flock, "hwvem", where, parameters(where, **given_), ticks=4)


@THOROUGH
@given(
    where=scenes(),
    weights=st.tuples(*[st.sampled_from((0.0, 1.0, 18.0, 30.0, 200.0))] * 3),
)
def test_wvem_with_all_its_parameters(where, weights):
    """Weights of 0 too: where nobody counts, headings are kept."""
    given_ = dict(zip(("k_alpha", "k_beta", "k_gamma"), weights, strict=True))
    follow(build("wvem", where, eta=0.0, **given_), "wvem", where, parameters(where, **given_), 3)


@BRIEF
@given(where=scenes(dims=(2,)), k_iu=st.sampled_from((0.0, 1.0, 1000.0)))
def test_ivem_a_with_its_weight(where, k_iu):
    flock = build("ivem-a", where, eta=0.0, k_iu=k_iu)
    follow(flock, "ivem-a", where, parameters(where, k_iu=k_iu), ticks=3)


@pytest.mark.parametrize("model", family.MODELS)
@BRIEF
@given(where=scenes(dims=(2,)), eta=st.sampled_from((0.1, 1.0, math.tau)))
def test_angular_noise_is_the_hash(model, where, eta):
    follow(build(model, where, eta=eta), model, where, parameters(where, eta=eta), ticks=2)


@pytest.mark.parametrize("model", family.MODELS)
@BRIEF
@given(where=scenes(dims=(2,)), eta=st.sampled_from((0.0, 0.1, 1.0, math.tau)))
def test_vectorial_noise_is_the_hash(model, where, eta):
    flock = build(model, where, noise="vectorial", eta=eta)
    follow(flock, model, where, parameters(where, eta=eta), ticks=2, noise="vectorial")


def lone_agents(noise, eta, n=2000):
    """n agents in space, out of each other's reach: headings before and after one tick."""
    where = scene(np.random.default_rng(1), n, 3, "open", "far apart", box=5.5, informed=0, r=0.05)
    where.position[:] *= 1000
    flock = build("vem", where, noise=noise, eta=eta)
    before = flock.heading.copy()
    flock.step()
    return before, flock.heading


def is_uniform(sample, low, high):
    """Whether numbers are uniform in [low, high] by Kolmogorov and Smirnov, at 1 in 1000."""
    from scipy.stats import kstest

    return kstest(sample, "uniform", (low, high - low)).pvalue > 1e-3


@pytest.mark.parametrize("eta", [0.3, 2.0, math.tau])
def test_angular_noise_in_space_is_uniform_on_a_cap(eta):
    """Half-angle eta / 2: equal areas of the cap are equal steps of the cosine."""
    before, after = lone_agents("angular", eta)
    cosine = (before * after).sum(axis=1)
    assert is_uniform(cosine, math.cos(min(eta / 2, math.pi)), 1.0)
    sideways = after - cosine[:, None] * before
    east = np.cross(before, [0.0, 0.0, 1.0])
    north = np.cross(before, east)
    around = np.arctan2((sideways * north).sum(axis=1), (sideways * east).sum(axis=1))
    # the size of `north` and `east` is the same: sin of the angle to the pole
    assert is_uniform(around, -math.pi, math.pi)


def test_vectorial_noise_in_space_is_uniform_on_the_sphere():
    """after * s = before + eta xi for the one s > 0 that makes |xi| = 1 (eta > 1)."""
    eta = 2.0
    before, after = lone_agents("vectorial", eta)
    along = (before * after).sum(axis=1)
    s = along + np.sqrt(along**2 - 1 + eta**2)
    xi = (s[:, None] * after - before) / eta
    assert np.allclose(np.linalg.norm(xi, axis=1), 1)
    for axis in range(3):
        assert is_uniform(xi[:, axis], -1, 1)
    assert is_uniform(np.arctan2(xi[:, 1], xi[:, 0]), -math.pi, math.pi)


@pytest.mark.parametrize("model", family.MODELS)
def test_most_agents_are_compared(model):
    """The comparisons above leave out unclear cases; here is how few those are."""
    where = scene(np.random.default_rng(5), 60, 2, "wrap", informed=1)
    flock = build(model, where, eta=0.0)
    assert follow(flock, model, where, parameters(where), ticks=10) > 0.9


@pytest.mark.parametrize("model", PLANAR)
def test_middle_rules_refuse_space(model):
    where = scene(np.random.default_rng(0), 5, 3, "wrap")
    with pytest.raises(ValueError, match=r"2|plan"):
        build(model, where, eta=0.0)


# --- exact cases ------------------------------------------------------------------------------


def test_opposite_neighbours_cancel_and_the_heading_is_kept():
    flock = at_rest("wvem", [[0, 0], [1, 0], [0.5, 0.5]], [0, math.pi, 0.7], eta=0.0)
    flock.step()
    assert angles_of(flock)[2] == pytest.approx(0.7)


def test_wvem_thirty_eighteen_one():
    x = [[0, 0], [0.5, 0.5], [1.7, 0], [0.9, 0]]
    flock = at_rest("wvem", x, [0, 1, 2, 3], informed=[0], eta=0.0)
    flock.step()
    expected = 30 * family.unit(0) + 18 * family.unit(1) + family.unit(2)
    assert angles_of(flock)[3] == pytest.approx(family.angle(expected))


def test_hwvem_weighs_layer_one_seventy_five_times_layer_three():
    x = [[0, 0], [1, 0], [2, 0]]
    flock = at_rest("hwvem", x, [0, 1, 2], informed=[0], p1=0.0, p2=5.0, eta=0.0)
    assert flock.signal("layer").tolist() == [1, 2, 3]
    flock.step()
    expected = family.unit(0) + family.unit(2) / 75
    assert angles_of(flock) == pytest.approx([0.0, family.angle(expected), 1.0])


@pytest.mark.parametrize(
    ("own", "after"), [(0.1, 0.3), (0.3, 0.5), (0.5, 0.5), (0.7, 0.5), (1.0, 0.8)]
)
def test_ivem_moves_towards_the_middle_of_the_extremes(own, after):
    flock = at_rest("ivem", [[0, 0], [0.5, 0], [0, 0.5]], [own, 0.3, 0.7], eta=0.0)
    flock.step()
    assert angles_of(flock)[0] == pytest.approx(after)


def test_ivem_does_not_wrap_its_differences():
    flock = at_rest("ivem", [[0, 0], [0.5, 0], [0, 0.5]], [0.1, 0.2, 6.2], eta=0.0)
    flock.step()
    assert angles_of(flock)[0] == pytest.approx(3.1)


def test_layers_are_delayed_by_one_tick_per_contact():
    """The information agent flies up to a resting chain; the news then takes a tick per link."""
    x = [[-1.2, 0], [0, 0], [0.9, 0], [1.8, 0]]
    headings = [0, math.pi / 2, math.pi / 2, math.pi / 2]
    for layers, expected in (
        ("delayed", [[1, 5, 5, 5], [1, 5, 5, 5], [1, 2, 5, 5], [1, 2, 3, 5], [1, 2, 3, 4]]),
        ("instant", [[1, 5, 5, 5], [1, 2, 3, 4], [1, 2, 3, 4], [1, 2, 3, 4], [1, 2, 3, 4]]),
    ):
        flock = at_rest("hwvem", x, headings, informed=[0], v0=0.25, layers=layers, eta=0.0)
        seen = [flock.signal("layer").tolist()]
        for _ in range(4):
            flock.step()
            seen.append(flock.signal("layer").tolist())
        assert seen == expected, layers
