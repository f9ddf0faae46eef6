"""Models: rules and bodies that fit or do not, defaults, and how far obstacles are noticed."""

from dataclasses import replace

import numpy as np
import pytest

from agents import Flock
from agents.bodies import constant_speed, double_integrator
from agents.catalogue import MODELS
from agents.models.declare import declared
from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES, main_observables, telling_observables
from agents.rules import hwvem, olfati_saber
from worlds.input_error import InputError
from worlds.layout import world


def test_a_body_that_cannot_take_what_the_rule_wishes_is_an_error():
    words = "rule olfati-saber wishes acceleration, but the body constant-speed takes heading"
    with pytest.raises(TypeError, match=words):
        Model(olfati_saber.RULE, constant_speed.BODY)
    with pytest.raises(TypeError, match=r"wishes heading, .* takes acceleration"):
        Model(hwvem.HWVEM, double_integrator.BODY)


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_every_model_begins_in_the_world_that_it_is_at_home_in(model):
    flock = Flock(model.name, agents=5, rng=1)
    assert flock.world.name == model.world
    assert flock.dt > 0.0
    assert flock.signals().shape == (len(model.columns), len(flock.ids))
    assert all(hasattr(flock.parameters, one.name) for one in declared(model.parameters))


def test_a_model_may_have_defaults_of_its_own_within_the_ranges_of_its_rule():
    plain = {one.name: one for one in declared(MODELS["hwvem"].parameters)}
    on_mission = {one.name: one for one in declared(MODELS["hwvem-nav"].parameters)}
    assert (plain["eta"].default, on_mission["eta"].default) == (0.0, 0.1)
    assert plain["eta"].allowed == on_mission["eta"].allowed
    assert Flock("hwvem-nav", rng=1).parameters.eta == 0.1
    with pytest.raises(InputError, match="eta = 9 rad is outside"):
        Flock("hwvem-nav", rng=1, eta=9)


def test_a_goal_follower_has_no_information_agents():
    with pytest.raises(
        InputError, match="informed = 2 is not allowed: olfati-saber has no informa"
    ):
        Flock("olfati-saber", agents=5, informed=2, rng=1)


def test_obstacles_are_surveyed_again_when_they_are_noticed_from_further_away():
    flock = Flock("hwvem-nav", agents=5, rng=1)
    assert flock.engine.surroundings.reach == flock.sight == 0.5
    flock.set(r_avoid=0.3)
    assert flock.engine.surroundings.reach == 0.5
    flock.set(r_avoid=1.5)
    assert flock.engine.surroundings.reach == 1.5
    fresh = Flock("hwvem-nav", agents=5, rng=1, r_avoid=1.5)
    flock.run(50)
    fresh.run(50)
    assert np.array_equal(flock.position, fresh.position)


def test_a_world_may_be_given_as_a_value():
    yard = world("obstacles")
    flock = Flock("reynolds", agents=5, world=yard, rng=1)
    assert flock.world is yard
    with pytest.raises(
        InputError, match="dim = 3 is not allowed: boundary-points is defined in 2-D"
    ):
        Flock("boundary-points", agents=5, world="rooms-3d", rng=1)


def test_what_is_told_unasked_is_what_the_model_declares_and_its_world_gives_occasion_for():
    def told(name, **given):
        return telling_observables(Flock(name, agents=6, rng=1, **given))

    assert told("hwvem", informed=1) == ["polarisation", "consistency", "mean-neighbours"]
    assert told("hwvem", informed=0) == ["polarisation", "mean-neighbours"]
    assert told("couzin") == ["polarisation", "angular-momentum", "groups"]
    assert told("vasarhelyi")[:3] == ["polarisation", "nearest-neighbour", "groups"]
    goal = told("boundary-points")
    assert goal[:2] == ["nearest-neighbour", "groups"]
    assert {"goal-distance", "obstacle-distance"} < set(goal)
    assert not {"polarisation", "consistency"} & set(goal)
    assert "crashes" in told("safe")
    assert "energy-saved" in told("echelon")


@pytest.mark.parametrize("name", MODELS)
def test_every_parameter_is_called_by_words_and_no_two_by_the_same(name):
    words = [(one.words, one.symbol) for one in declared(MODELS[name].parameters)]
    assert all(one[:1].isupper() and len(one) <= 32 for one, _ in words)
    assert len(set(words)) == len(words)


def test_units_are_the_model_s_own():
    for name, own in (("dorsogna", "m/s"), ("couzin", "length/s"), ("vem", "length/tick")):
        assert MODELS[name].in_units("length/time") == own
    assert MODELS["dorsogna"].in_units("times") == "times"


@pytest.mark.parametrize("name", MODELS)
def test_every_model_tells_numbers_that_its_flocks_have(name):
    flock = Flock(name, agents=5, rng=1)
    found = telling_observables(flock)
    assert found
    assert len(set(found)) == len(found)
    assert all(OBSERVABLES[one].applies(flock) and not OBSERVABLES[one].over for one in found)


def test_a_model_that_declares_what_cannot_be_measured_is_refused():
    odd = replace(MODELS["vem"], tells=("polarization",))
    with pytest.raises(InputError, match=r"unknown observable 'polarization'.*model vem"):
        main_observables(odd)


@pytest.mark.parametrize("name", ["vem", "vicsek1995", "hwvem", "couzin", "hwvem-nav"])
def test_a_body_of_one_speed_has_it_from_tick_0_on(name):
    flock = Flock(name, agents=20, rng=5)
    before = flock.speed.copy()
    assert (before == flock.model.body.speed(flock.parameters)).all()
    assert (before > 0.0).all()
    flock.run(1)
    assert np.median(flock.speed) == pytest.approx(before[0]), "solids hold some UAVs back"


def test_a_body_of_one_speed_has_that_whatever_it_is_handed_and_others_have_what_they_are():
    start = {"position": np.ones((3, 2)), "heading": np.eye(2)[[0, 1, 0]], "speed": np.full(3, 0.7)}
    assert (Flock("vem", start=start, size=4.0, rng=1, v0=0.05).speed == 0.05).all()
    assert (Flock("vem", agents=3, world="wu2023-multi", rng=1).speed == 0.03).all()
    assert (Flock("reynolds", start=start, world="open", size=4.0, rng=1).speed == 0.7).all()
    assert Flock("boundary-points", agents=9, rng=1).speed.std() > 0.1


@pytest.mark.parametrize("name", MODELS)
def test_every_column_is_called_by_words_and_words_name_only_columns(name):
    model = MODELS[name]
    called = [model.words_of(column) for column in model.columns]
    assert all(words and "_" not in words for words in called)
    for part in (model.rule, model.body):
        assert all({one, f"{one}_x"} & set(model.columns) for one in part.words)
