"""Chen and Kolokolnikov 2014 in small: the law of the ring, and what a few runs say of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import prey_swarm as oracle

from agents import Flock
from agents.kinds import Kind, chase, flee
from agents.spec import Spec
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment import flock_of
from app.studies.experiment_reader import read_experiment, read_file
from app.studies.experiment_runner import fingerprint, run_experiment
from app.studies.figures.predator_ring import RingTheory, growth_of, ring_theory
from papers.flying import flown, values
from worlds.input_error import InputError


@given(a=st.floats(0.2, 5.0), b=st.floats(0.05, 2.0), c=st.floats(0.0, 3.0), p=st.floats(2.1, 3.9))
def test_the_law_is_that_of_the_two_circles_and_the_predator(a, b, c, p):
    """Their shifts s1, s2 and that of the predator, before any is taken from another.

    A circle of prey of the density a / pi that is shifted by s pulls the circle R2 by
    -a (R1 / R2)^2 s1 and R1 by -a s2, and itself by -a s; all prey are drawn to their centre.
    """
    law = RingTheory(100, a, b, c, p)
    r1, r2 = law.inner, law.outer
    centre = a * np.array([-(r1**2), r2**2, 0.0])
    outer = -a * np.array([(r1 / r2) ** 2, 1.0, 0.0]) + a * centre + [0.0, 0.0, b / r2**2]
    inner = -a * np.array([1.0, 1.0, 0.0]) + a * centre + [0.0, 0.0, b / r1**2]
    near, far = r1 ** (2.0 - p), r2 ** (2.0 - p)
    predator = c * a * np.array([-near, far, near - far])
    rates = np.linalg.eigvals(np.array([inner, outer, predator]))
    assert rates.sum().real == pytest.approx(law.trace, abs=1e-9 * (1.0 + a * c * near))
    all_shifted = np.array([inner, outer, predator]) @ np.ones(3)
    np.testing.assert_allclose(all_shifted, 0.0, atol=1e-9 * (1.0 + a * c * near))
    moving = np.delete(rates, np.argmin(np.abs(rates)))
    if np.abs(rates).min() < 1e-9 < np.abs(moving).min():
        assert np.prod(moving).real == pytest.approx(law.determinant, rel=1e-6, abs=1e-9)
        assert moving.real.max() == pytest.approx(law.growth, rel=1e-6, abs=1e-7)


def test_the_bounds_are_where_growth_is_zero():
    law = RingTheory(300, 1.0, 0.2, 0.4, 3.0)
    assert (law.low, law.high) == (pytest.approx(0.2190890), pytest.approx(0.7557453))
    for bound in (law.low, law.high):
        assert replace(law, c=bound).growth == pytest.approx(0.0, abs=1e-15)
    assert law.growth < 0.0
    assert replace(law, c=0.2).growth > 0.0 < replace(law, c=0.8).growth
    assert law.mean_square == oracle.mean_square_at_rest(300, 1.0, 0.2)
    assert growth_of(0.0, -4.0) == 2.0


def test_a_ring_at_rest_and_its_bounds(tmp_path):
    _, made = flown("chen2014-predator", tmp_path, 2, [100])
    numbers = {
        name: np.array(values(made, name)["a 1, b 0.2, p 3", 100], float)
        for name in ("off", "inner", "outer", "even", "low", "high")
    }
    assert (np.abs(numbers["off"]) < 50.0).all()
    assert (np.abs(numbers["inner"] - 0.4) < 0.1).all()
    assert (numbers["even"] > 0.7).all()
    assert (np.abs(numbers["outer"] - 0.4) < 0.1).all()
    assert (np.abs(numbers["low"] - 1.09) < 0.08).all()
    assert (np.abs(numbers["high"] - 1.0) < 0.05).all()


def test_a_weak_predator_is_left_behind_and_a_strong_one_goes_round(tmp_path):
    whole = read_experiment("chen2014-chase").select(["c 0.06", "c 0.45", "c 1.2"], [])
    settings = whole.settings.model_copy(update={"lasts": 60.0, "settle": 20.0})
    experiment = replace(whole, settings=settings)
    done = run_experiment(
        experiment, tmp_path, runs=2, seed=1, workers=2, tell=None, at=lambda *_: None
    )
    made = verdicts(experiment, done.measured)
    away = {label: found for (label, _), found in values(made, "away").items()}
    assert min(away["c 0.06"]) > 1.0 > 0.5 > max(away["c 1.2"]) > 0.2 > 0.03 > max(away["c 0.45"])
    circling = {label: found for (label, _), found in values(made, "circling").items()}
    assert min(circling["c 1.2"]) > 1.0
    assert circling["c 0.45"] == [None, None]
    assert "does not hold" not in {one.word for one in claims(made, experiment.said)}


def test_the_law_is_read_from_relations_and_others_are_refused():
    predator = Kind("predator", 1, to={"flock": chase(0.02, 1000.0, power=1.5)})
    to = {"predator": flee(0.3, 1000.0, power=1.0)}
    base = Spec("prey-swarm", agents=20, seed=1, parameters={"a": 2.0})
    law = ring_theory(Flock(base.but(kinds=[predator], to=to)))
    assert law == RingTheory(20, 2.0, 0.3, pytest.approx(0.4), 2.5)
    linear = Kind("predator", 1, to={"flock": chase(0.02, 1000.0)})
    for words, message in (
        ({}, "not one agent of a kind that is called predator"),
        ({"kinds": [linear], "to": to}, "does not chase flock by a power"),
        ({"kinds": [predator], "to": {"predator": "ignore"}}, "flee predator by the power 1"),
    ):
        with pytest.raises(InputError, match=message):
            ring_theory(Flock(base.but(**words)))


# Kinds in the rows of an experiment.


def test_rows_that_differ_in_a_relation_are_other_cases():
    experiment = read_experiment("chen2014-chase")
    cases = experiment.cases
    assert len({fingerprint(case, experiment.settings) for case in cases[:3]}) == 3
    flock = flock_of(cases[0], 1)
    assert flock.kind_names.tolist().count("predator") == 1
    assert len(flock.rows_of("flock")) == 200
    assert flock.kinds.of("predator", "flock").weight == pytest.approx(0.06 / 200)


@pytest.mark.parametrize(
    ("written", "wrong", "message"),
    [
        ('name = "predator", ', "", "a kind has no name"),
        ("chase = 0.0003", "hunt = 0.0003", "unknown key 'hunt'"),
        ("predator = { flee", "shark = { flee", "unknown kind 'shark'"),
    ],
)
def test_a_kind_that_is_none_is_refused_with_its_file(tmp_path, written, wrong, message):
    text = Path("experiments/chen2014-chase.toml").read_text(encoding="utf-8")
    assert written in text
    path = tmp_path / "own.toml"
    path.write_text(text.replace(written, wrong, 1), encoding="utf-8")
    with pytest.raises(InputError, match=message) as refused:
        read_file(path)
    assert "own.toml" in str(refused.value)
    assert "\n" not in str(refused.value)
