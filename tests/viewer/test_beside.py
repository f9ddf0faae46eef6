"""Two models side by side: one start, one time, one set of controls."""

from __future__ import annotations

import io
import zipfile
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest
import tomlkit

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.individuals import normal, one_of, uniform
from agents.kinds import Kind, chase
from agents.spec import Spec
from app.cli.lab import parameters
from app.viewer.lab.panels.flock_monitors import compare_table
from app.viewer.lab.panels.setup import NOBODY, SetupPanel, describe_differences
from app.viewer.run.flock_run import ComparedFlockError
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.paired_run import (
    PairedRun,
    companion,
    naming_errors,
    pace_note,
    ratio,
    shared_model_parameters,
)
from app.viewer.run.run_preset import preset_spec
from tests.viewer.stub_flock import timed_stub
from tests.viewer.waiting import until
from worlds.input_error import InputError

SAME = ("position", "heading", "informed", "ids")


def pair(model: str = "hwvem", beside: str = "vem-a", **given) -> PairedRun:
    own = given.pop("own", {})
    first = Flock(preset_spec(model, **({"seed": 4, "agents": 12} | given)))
    return PairedRun(first, companion(first, Spec(beside, parameters=own)), 1, FrameRequest())


@pytest.mark.parametrize(
    ("model", "beside", "given"),
    [
        ("hwvem-nav", "vem-a-nav", {}),
        ("boundary-points", "olfati-saber", {}),
        ("vem", "hwvem", {}),
        ("hwvem", "vem", {"informed": 3}),
        ("hwvem", "wvem", {"dim": 3}),
        ("hwvem-nav", "reynolds", {"world": "obstacles"}),
        ("reynolds", "hwvem-nav", {}),
        ("vem-a", "olfati-saber", {"size": 30.0, "activation": "random", "noise": "vectorial"}),
    ],
)
def test_both_begin_alike_to_the_bit(model, beside, given):
    both = pair(model, beside, **given)
    first, second = both.flock, both.second.flock
    assert (first.model.name, second.model.name) == (model, beside)
    assert second.world is first.world
    led = MODELS[beside].rule.led
    for name in SAME:
        if name == "informed" and not led:
            assert not second.informed.any()
        else:
            assert np.array_equal(getattr(first, name), getattr(second, name)), name
    alone = Flock(second.spec) if led else None
    bodies = first.model.body, second.model.body
    if bodies[1].speed is not None:
        assert (second.speed == bodies[1].speed(second.parameters)).all()
        assert (second.speed > 0.0).all()
    elif bodies[0].speed is None:
        assert np.array_equal(first.speed, second.speed)
    elif alone is not None:
        assert np.array_equal(second.speed, alone.speed)
    else:
        assert not second.speed.any(), "as it begins alone in a world that says nothing of speeds"
    assert (second.seed, second.tick) == (first.seed, 0)
    assert second.spec.chosen == first.spec.chosen | ({} if led else {"informed": 0})


def test_the_second_goes_as_it_would_go_alone_and_its_spec_repeats_it():
    both = pair("hwvem", "vem-a", informed=2)
    alone = Flock.from_spec(both.second.flock.spec)
    both.advance(7)
    alone.advance(7)
    assert np.array_equal(alone.position, both.second.flock.position)
    assert not np.array_equal(both.flock.position, both.second.flock.position)


def test_what_knows_no_information_agents_begins_where_they_are():
    both = pair("hwvem-nav", "reynolds", world="obstacles")
    assert both.flock.informed.sum() == 1
    assert len(both.second.flock.ids) == len(both.flock.ids) == 13
    assert both.second.flock.spec.start == "given"


@pytest.mark.parametrize("steps", [(1,) * 60, (60,), (7, 13, 40)])
@pytest.mark.parametrize(("lasts", "ticks"), [(0.1, 12), (0.02, 60), (0.008, 150), (0.03, 40)])
def test_the_second_keeps_up_with_the_time_of_the_first(steps, lasts, ticks):
    both = PairedRun(timed_stub(0.02), timed_stub(lasts), 1, FrameRequest())
    for one in steps:
        both.advance(one)
        behind = both.flock.tick * 0.02 - both.second.flock.tick * lasts
        assert -1e-9 <= behind < lasts
    assert (both.flock.tick, both.second.flock.tick) == (60, ticks)


def test_without_a_common_unit_both_go_tick_by_tick():
    both = PairedRun(timed_stub(1.0, unit="ticks"), timed_stub(0.02), 1, FrameRequest())
    both.advance(9)
    assert both.second.flock.tick == 9
    assert ratio(1.0, "ticks", 0.02, "s") == 1.0
    frames = SimpleNamespace(dt=1.0, unit="ticks"), SimpleNamespace(dt=0.02, unit="s")
    assert "tick by tick" in pace_note(*frames)
    assert pace_note(frames[1], frames[1]) == ""


def test_real_models_with_ticks_of_different_length_keep_one_time():
    both = pair("olfati-saber", "vasarhelyi-tenth", world="wu2023-independent", agents=6)
    both.second.flock.set(dt=0.1)
    assert (both.flock.dt, both.second.flock.dt) == (pytest.approx(0.02), 0.1)
    both.advance(12)
    assert (both.flock.tick, both.second.flock.tick) == (12, 2)
    both.advance(3)
    assert both.second.flock.tick == 3
    assert both.flock.elapsed == pytest.approx(both.second.flock.elapsed)


def test_what_two_models_declare_alike_is_shared():
    nearest = {"neighbours", "k"}  # which hwvem does not have
    whole = set(MODELS["vem-a-nav"].parameters.model_fields)
    assert shared_model_parameters("hwvem-nav", "vem-a-nav") == whole - nearest
    lone = set(MODELS["olfati-saber"].parameters.model_fields)
    lone -= shared_model_parameters("boundary-points", "olfati-saber")
    assert lone == {"beta", "d_beta"}
    # Of one name, but of another unit, or published at another value: each its own.
    assert shared_model_parameters("vem", "olfati-saber") == set()
    assert shared_model_parameters("hwvem-nav", "hwvem") & {"eta", "v0"} == set()
    for one in MODELS:
        for other in MODELS:
            assert shared_model_parameters(one, other) == shared_model_parameters(other, one)


def test_a_shared_parameter_is_set_in_both_and_the_others_in_one():
    both = pair("boundary-points", "olfati-saber", parameters={"c1a": 2.0})
    first, second = both.flock, both.second.flock
    assert first.parameters.c1a == second.parameters.c1a == 2.0
    assert set(both.beside_values) == {"beta", "d_beta"}
    both.set("c1a", 3.0)
    both.set("tau_a", 5.0)
    both.set("d_beta", 2.0, beside=True)
    assert first.parameters.c1a == second.parameters.c1a == 3.0
    assert first.parameters.tau_a == 5.0
    assert second.parameters.d_beta == both.beside_values["d_beta"] == 2.0


def test_a_parameter_that_only_has_its_name_in_common_is_set_in_one():
    both = pair("hwvem-nav", "hwvem")
    both.set("eta", 1.0)
    assert (both.flock.parameters.eta, both.second.flock.parameters.eta) == (1.0, 0.0)
    both.set("eta", 2.0, beside=True)
    assert (both.flock.parameters.eta, both.second.flock.parameters.eta) == (1.0, 2.0)


def test_what_one_refuses_is_refused_for_both():
    both = PairedRun(timed_stub(), timed_stub(strict=True), 1, FrameRequest())
    both.set("eta", 1.0)
    with pytest.raises(InputError, match=r"Stub: eta = 3\.0 is too much"):
        both.set("eta", 3.0)
    with pytest.raises(InputError, match="eta = 99"):
        both.set("eta", 99.0)
    assert both.values["eta"] == both.second.values["eta"] == 1.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"beside": "hwvem"}, "beside = 'hwvem' is the model itself"),
        ({"beside": "hwven-nav"}, "did you mean"),
        ({"beside": "ivem-a", "dim": 3}, "Improved Vicsek model with an information UAV: dim = 3"),
        ({"beside": "vem", "own": {"et": 1.0}}, "Vicsek model: unknown parameter"),
    ],
)
def test_a_second_model_that_cannot_be_is_refused_by_name(given, words):
    with pytest.raises(InputError, match=words):
        pair(**given)


def test_an_agent_is_looked_at_in_the_flock_it_is_in():
    both = pair("vem-a", "vem")
    frame = both.look(closely=True)
    assert (frame.title, frame.beside.title) == (MODELS["vem-a"].title, "Vicsek model")
    assert frame.beside.speed_scale == frame.speed_scale
    both.set_request(FrameRequest(row=5, beside=True))
    until(lambda: both.look(closely=False).beside.inspected, 60)
    frame = both.look(closely=False)
    assert frame.inspected is None
    assert frame.beside.inspected.row == 5
    both.set_request(FrameRequest(row=5))
    until(lambda: both.look(closely=False).inspected, 60)
    assert both.look(closely=False).beside.inspected is None


def test_the_information_agent_is_put_in_both_if_it_is_one_in_both():
    here, east = np.array([1.0, 2.0]), np.array([1.0, 0.0])
    both = pair("hwvem", "vem-a")
    both.place(0, here, east)
    assert both.second.flock.position[0].tolist() == both.flock.position[0].tolist() == [1.0, 2.0]
    both = pair("hwvem-nav", "reynolds", world="obstacles")
    before = both.second.flock.position[0].copy()
    both.place(0, here, east)
    assert both.flock.position[0].tolist() == [1.0, 2.0]
    assert np.array_equal(both.second.flock.position[0], before)


def unpacked(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as pack:
        return {name: pack.read(name) for name in pack.namelist()}


def test_both_are_saved_in_one_file():
    both = pair("hwvem", "vem-a")
    both.advance(3)
    specs = unpacked(both.spec())
    assert list(specs) == ["1-hwvem.toml", "2-vem-a.toml"]
    models = [tomlkit.parse(text.decode())["model"] for text in specs.values()]
    assert models == ["hwvem", "vem-a"]
    states = unpacked(both.save())
    assert list(states) == ["1-hwvem.parquet", "2-vem-a.parquet"]
    assert all(pq.read_table(io.BytesIO(one)).num_rows == 13 for one in states.values())


def test_a_position_that_is_no_number_is_named_too():
    both = PairedRun(timed_stub(), timed_stub(), 1, FrameRequest())
    both.second.flock.position[2] = np.nan
    with pytest.raises(ArithmeticError, match="Stub: agent 2 has position"):
        both.look(closely=False)
    with pytest.raises(ComparedFlockError, match="Stub: KeyError"), naming_errors(both.flock):
        raise KeyError("x")


# Panels.


def test_the_command_gives_each_model_its_own():
    assert parameters("boundary-points", ["d_beta=2", "c1a=3"], "olfati-saber") == (
        {"c1a": 3.0},
        {"d_beta": 2.0},
    )
    assert parameters("hwvem-nav", [], "hwvem") == ({}, {"eta": 0.3})
    assert parameters("vem", ["eta=1"], "hwvem") == ({"eta": 1.0}, {})
    with pytest.raises(InputError, match="unknown parameter 'd_bet'"):
        parameters("boundary-points", ["d_bet=2"], "olfati-saber")


def test_beside_are_offered_the_models_that_fit_the_dimension():
    flat, space = (SetupPanel.companions("hwvem", dim) for dim in (2, 3))
    assert flat[0] == space[0] == NOBODY
    assert len(flat) == len(MODELS)
    assert MODELS["hwvem"].title not in flat
    assert set(flat) - set(space) == {
        one.title for one in MODELS.values() if one.dimensions == (2,)
    }


def test_a_difference_beside_is_one_that_setup_makes():
    assert describe_differences((preset_spec(), None), (preset_spec(), Spec("vem"))) == ["beside"]


def test_a_table_leaves_open_what_one_of_them_lacks():
    table = compare_table("Flock", ("a", "b"), {"x": "1", "y": "2"}, {"x": "3"})
    assert "<td>x</td><td>1</td><td>3</td>" in table
    assert "<td>y</td><td>2</td><td>–</td>" in table
    assert compare_table("Mission", ("a", "b"), {}, {}) == ""


def test_agents_that_differ_have_the_same_numbers_in_both_flocks():
    both = pair(
        "vem", "ivem-a", parameters={"eta": one_of(0.5, 1.0)}, own={"k_iu": normal(0.5, 0.1)}
    )
    first, second = both.flock, both.second.flock
    assert np.array_equal(first.own["eta"], second.own["eta"])
    assert set(first.own) == {"eta"}
    assert set(second.own) == {"eta", "k_iu"}
    assert both.beside_values["k_iu"] == normal(0.5, 0.1)
    both.set("eta", uniform(0.5, 0.8))
    assert np.array_equal(first.own["eta"], second.own["eta"])
    both.set("k_iu", 0.4, beside=True)
    assert set(second.own) == {"eta"}


def test_what_a_second_model_cannot_differ_in_is_refused_by_name():
    both = pair("vem", "hwvem")
    shared = [name for name in both.shared if name in MODELS["hwvem"].shared]
    shared = [name for name in shared if name in MODELS["vem"].individual]
    assert "r" in shared
    with pytest.raises(InputError, match=r"^.*: r cannot differ from agent to agent in hwvem"):
        both.set("r", uniform(0.5, 0.8))
    assert both.flock.own == {}
    with pytest.raises(InputError, match="r cannot differ from agent to agent in hwvem"):
        pair("vem", "hwvem", parameters={"r": uniform(0.5, 0.8)})


def test_the_command_line_gives_distributions_to_the_laboratory():
    own, _ = parameters("couzin", ["s=normal:3:0.5", "r_r=2"])
    assert own == {"s": normal(3.0, 0.5), "r_r": 2.0}
    with pytest.raises(InputError, match="tau cannot differ"):
        parameters("couzin", ["tau=normal(0.1, .01)"])


@pytest.mark.parametrize(("model", "beside"), [("vem", "vem-a"), ("hwvem", "vem")])
def test_kinds_are_in_the_first_flock_alone_and_the_others_begin_alike(model, beside):
    kinds = [Kind("shark", 2, to={"flock": chase(1.0, 1.0, catch=0.5)})]
    both = pair(model, beside, kinds=kinds)
    first, second = both.flock, both.second.flock
    rows = first.rows_of("flock")
    assert second.kinds.names == ("flock",)
    order, other = rows[np.argsort(first.ids[rows])], np.argsort(second.ids)
    assert np.array_equal(first.ids[order], second.ids[other])
    assert np.array_equal(first.position[order], second.position[other])
    both.advance(5)
    frame = both.look(closely=True)
    assert frame.kind is not None
    assert frame.beside.kind is None
