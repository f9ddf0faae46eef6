"""Axes over numbers of kinds: in files, on the command line, in searches; what cannot be varied."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from cli.calling import call, refusal

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.individuals import normal, uniform
from agents.kinds import Kind, chase, flee, kind_table
from agents.spec import Spec
from app.studies.optimisation.study import read_study
from app.studies.run_axes import (
    AxisModels,
    allowed_span,
    axis_unit,
    flatten_axes,
    numeric_axes,
    read_axis,
    spec_with,
    value_of,
)
from app.studies.sweeps.checked_sweep import read_sweep
from app.studies.sweeps.sweep_api import sweep
from app.studies.sweeps.sweep_file import Condition
from worlds.input_error import InputError

SHARK = Kind(
    "shark", 2, parameters={"v0": 0.05, "eta": uniform(0.0, 1.0)}, to={"prey": chase(2.0, 1.5)}
)
HUNT = Spec("vem", agents=12, size=3.0, kinds=[SHARK], parameters={"v0": 0.03})
FILE = """
[run]
model = "vem"
agents = 12
size = 3.0
ticks = 5

[[run.kinds]]
name = "shark"
agents = 2
parameters = { v0 = 0.05 }
to = { flock = { chase = 2.0, radius = 1.5 } }

[[design]]
kind = "grid"
where = "shark.agents * shark.flock.weight <= 4"

[design.axes]
shark.agents = { from = 0, to = 2, count = 3 }
shark.v0 = [0.04, 0.06]
"shark.flock.weight" = [1.0, 4.0]

[replicates]
count = 1
"""


def shark(values: dict[str, object], spec: Spec = HUNT) -> Kind:
    return kind_table(spec_with(spec, values).kinds, {}).kind("shark")


@pytest.mark.parametrize(
    ("values", "meant"),
    [
        ({"shark.agents": 0}, {"agents": 0}),
        ({"shark.agents": 5.0, "shark.v0": 0.07}, {"agents": 5, "v0": 0.07}),
        ({"shark.v0": "normal(0.05, 0.01)"}, {"v0": normal(0.05, 0.01)}),
        ({"shark.v0.spread": 0.01}, {"v0": normal(0.05, 0.01)}),
        ({"shark.v0.spread": 0.01, "shark.v0.mean": 0.06}, {"v0": normal(0.06, 0.01)}),
        ({"shark.v0.mean": 0.06}, {"v0": 0.06}),
        ({"shark.eta.mean": 2.0}, {"eta": uniform(1.5, 2.5)}),
        ({"shark.eta.spread": 0.25}, {"eta": uniform(0.25, 0.75)}),
        ({"shark.r.spread": 0.1}, {"r": normal(1.0, 0.1)}),
        ({"shark.flock.weight": 3}, {"to": {"flock": chase(3, 1.5)}}),
        ({"shark.prey.catch": 0.1}, {"to": {"flock": chase(2.0, 1.5, catch=0.1)}}),
        (
            {"shark.flock.power": 2.0, "shark.flock.radius": 1.0},
            {"to": {"flock": chase(2, 1, power=2.0)}},
        ),
    ],
)  # fmt: skip
def test_an_axis_gives_a_kind_a_number_and_changes_nothing_else(values, meant):
    one = shark(values)
    assert one.agents == meant.get("agents", 2)
    own = {name: value for name, value in meant.items() if name not in ("agents", "to")}
    assert one.parameters == {**SHARK.parameters, **own}
    table = kind_table(spec_with(HUNT, values).kinds, {})
    assert table.of("shark", "flock") == meant.get("to", {}).get("flock", chase(2.0, 1.5))
    assert spec_with(HUNT, values).but(kinds=HUNT.kinds) == HUNT


def test_who_is_chased_flees_by_its_own_axis_whatever_comes_first():
    """Without an axis of its own it flees as it is chased, with one by that."""
    names = ("shark.flock.radius", "flock.shark.weight")
    for order in (names, names[::-1]):
        spec = spec_with(HUNT, {name: {"weight": 5.0, "radius": 0.5}[name[12:]] for name in order})
        table = kind_table(spec.kinds, spec.to)
        assert table.of("flock", "shark") == flee(5.0, 0.5)
        assert table.of("shark", "flock") == chase(2.0, 0.5)
    alone = spec_with(HUNT, {"shark.flock.weight": 4.0})
    assert kind_table(alone.kinds, alone.to).of("flock", "shark") == flee(4.0, 1.5)


def test_what_a_run_has_is_what_its_axes_give_back():
    """Of every axis that a run has: its value, given again, changes nothing but what was left
    open."""
    names = [axis.name for axis in numeric_axes(HUNT)]
    assert names[:6] == ["r", "eta", "k", "v0", "agents", "shark.agents"]
    assert {"shark.eta.mean", "shark.eta.spread", "shark.flock.radius", "flock.shark.weight"} < {
        *names
    }
    assert not {"shark.k", "shark.flock.power"} & {*names}
    for name in names[4:]:
        value = value_of(HUNT, name)
        assert value_of(spec_with(HUNT, {name: value}), name) == value
    assert value_of(HUNT, "shark.eta.spread") == 0.5
    assert value_of(HUNT, "shark.r") == 1.0
    assert value_of(HUNT, "shark.eta") == "uniform(0, 1)"


def test_a_kind_by_a_model_of_its_own_has_that_models_numbers():
    """Its defaults and ranges; what the flock's model has alone is none of its parameters."""
    loner = Kind("loner", 5, model="gregoire-chate", eta=0.3)
    spec = Spec("vem", agents=12, size=3.0, kinds=[loner], parameters={"v0": 0.09})
    made = spec_with(spec, {"loner.v0": 0.04, "loner.eta.spread": 0.1, "loner.agents": 2})
    assert made.kinds == (Kind("loner", 2, model="gregoire-chate", eta=normal(0.3, 0.1), v0=0.04),)
    fields = MODELS["gregoire-chate"].parameters.model_fields
    assert value_of(spec, "loner.v0") == fields["v0"].default != 0.09
    Flock(made.but(seed=1))
    only = next(name for name in MODELS["gregoire-chate"].individual if name not in {"v0", "eta"})
    assert value_of(spec, f"loner.{only}") == fields[only].default
    with pytest.raises(InputError, match=r"loner.p2: unknown parameter 'p2'"):
        spec_with(spec, {"loner.p2": 3.0})
    names = [axis.name for axis in numeric_axes(spec)]
    individual = MODELS["gregoire-chate"].individual
    assert names[names.index("loner.agents") + 1 :] == [f"loner.{name}" for name in individual]
    for name in names[names.index("loner.agents") :]:
        value = value_of(spec, name)
        assert value_of(spec_with(spec, {name: value}), name) == value
    drawn = [axis.name for axis in numeric_axes(made)]
    assert {"loner.eta.mean", "loner.eta.spread"} < {*drawn}
    assert value_of(made, "loner.eta.spread") == 0.1


def test_what_the_flock_draws_is_no_number_of_a_kind_by_a_model_of_its_own():
    loner = Kind("loner", 5, model="gregoire-chate")
    spec = Spec("vem", agents=12, kinds=[loner], individuals={"v0": normal(0.03, 0.01)})
    names = {axis.name for axis in numeric_axes(spec)}
    assert {"v0.mean", "v0.spread", "loner.v0"} < names
    assert "loner.v0.spread" not in names
    assert isinstance(value_of(spec, "loner.v0"), float)


def test_an_axis_goes_by_the_model_of_its_agents():
    """Its range, its unit, and whether `spread` is a parameter of it."""
    models = AxisModels("vem", {"loner": "gregoire-chate", "slow": "pedestrian"})
    assert models.of_axis("eta") == models.of_axis("agents") == models.of_axis("shark.eta") == "vem"
    assert models.of_axis("loner.eta.spread") == models.of_axis("loner.agents") == "gregoire-chate"
    assert models.of_axis("slow.spread") == models.of_axis("slow.spread.mean") == "pedestrian"
    for name, high, unit in (("eta", 6.2832, "rad"), ("loner.eta", 1.0, "1")):
        model = models.of_axis(name)
        assert allowed_span(model, name, 10) == (0.0, pytest.approx(high, abs=1e-4))
        assert axis_unit(model, name) == unit


def test_a_kind_and_a_parameter_of_one_name_are_told_apart():
    """`slow.spread` is a number of the kind where the model has a parameter `spread`."""
    assert read_axis("eta.spread", "vem")[1:4] == ("eta", "spread", "")
    assert read_axis("slow.spread", "pedestrian")[1:4] == ("spread", "", "slow")
    assert read_axis("slow.spread.spread", "pedestrian")[1:4] == ("spread", "spread", "slow")
    table = {"shark": {"agents": {"from": 0, "to": 2, "step": 1}, "flock": {"radius": [1, 2]}}}
    assert list(flatten_axes(table)) == ["shark.agents", "shark.flock.radius"]


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"sherk.v0": 0.1}, r"sherk.v0: unknown kind 'sherk': did you mean 'shark'\?"),
        ({"shark.v9": 0.1}, r"shark.v9: unknown parameter 'v9'.*known: r, eta"),
        ({"shark.k": 3}, "shark.k: k cannot differ from agent to agent"),
        ({"shark.v0": 9.0}, r"^shark.v0 = 9 length/tick is outside \[0, 1\]"),
        ({"shark.v0": True}, "shark.v0 = True is not allowed: a number is needed"),
        ({"shark.agents": -1}, r"shark.agents: kind shark: agents = -1 .* >= 0"),
        ({"shark.agents": 1.5}, r"shark.agents: kind shark: agents = 1.5 .* whole number"),
        ({"shark.flock.weight": -1.0}, "shark.flock.weight: weight = -1.0 of chase"),
        ({"shark.flock.radius": 0.0}, "shark.flock.radius: radius = 0 of chase"),
        ({"flock.shark.catch": 0.1}, "flock.shark.catch: catch = 0.1 of flee: only who chases"),
        ({"shark.shark.weight": 1.0}, "shark.shark.weight: shark has the relation own to shark"),
        ({"shark.whale.weight": 1.0}, r"shark.whale.weight: unknown kind 'whale'"),
        ({"flock.v0": 0.1}, "flock.v0 is not allowed: write v0"),
        ({"shark.v0": 0.1, "shark.v0.spread": 0.0}, "v0.spread is not allowed beside shark.v0"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_by_the_name_of_its_axis(values, said):
    with pytest.raises(InputError, match=said):
        spec_with(HUNT, values)
    with pytest.raises(InputError, match="this run has no kinds of agents"):
        spec_with(HUNT.but(kinds=[]), {"shark.v0": 0.1})


def test_a_file_sweeps_a_kind(tmp_path):
    """Dotted keys or quoted ones; a condition has them; how many there are is a whole number."""
    (tmp_path / "s.toml").write_text(FILE)
    made = read_sweep(tmp_path / "s.toml")
    assert made.axes == ["shark.agents", "shark.v0", "shark.flock.weight"]
    points = [tuple(cell.axes.values()) for cell in made.cells]
    assert points == [
        (n, v, w) for n in (0, 1, 2) for v in (0.04, 0.06) for w in (1.0, 4.0) if n * w <= 4
    ]
    assert [sum(kind.agents for kind in cell.spec.kinds) for cell in made.cells] == [
        n for n, _, _ in points
    ]
    assert len({cell.hash for cell in made.cells}) == len(made.cells)


def test_a_condition_has_kinds_with_a_dash_in_their_names_and_takes_differences():
    axes = ["big-fish.agents", "big-fish.v0", "eta", "big"]
    values = {"big-fish.agents": 3, "big-fish.v0": 0.1, "eta": 2.0, "big": 1.0}
    assert Condition("big-fish.agents - eta == big and big-fish.v0 < 1", axes).holds(values)
    assert not Condition("eta - big > 1", axes).holds(values)
    with pytest.raises(InputError, match=r"unknown axis 'fish.v9' .*big-fish.v0"):
        Condition("big-fish.v9 > 0", axes)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("shark.v0 = [", "shark.v9 = [", "shark.v9: unknown parameter.*line 20;"),
        ("[0.04, 0.06]", "[7.0]", "shark.v0 = 7 length/tick is outside.*line 20;"),
        ("count = 3 }", "count = 3, by = 1 }", "axes"),
        ("shark.agents * ", "shark.v1 * ", "unknown axis 'shark.v1'"),
    ],
)
def test_a_fault_in_a_file_is_told_with_its_line(tmp_path, before, after, said):
    (tmp_path / "s.toml").write_text(FILE.replace(before, after))
    with pytest.raises(InputError, match=said):
        read_sweep(tmp_path / "s.toml")


def test_a_kind_of_which_there_is_none_leaves_the_others_as_they_are():
    """The ordinary agents have the bits of a flock without kinds, and nobody is missed."""
    none = Flock("vem", agents=30, rng=3, size=3.0, kinds=[replace_agents(0)])
    plain = Flock("vem", agents=30, rng=3, size=3.0)
    none.run(20)
    plain.run(20)
    np.testing.assert_array_equal(none.position, plain.position)
    assert (none.warning, len(none.rows_of("shark")), none.observe("catches")) == ("", 0, 0)
    assert np.isnan(none.observe("kind-distance"))


def replace_agents(count: int) -> Kind:
    return Kind("shark", count, v0=0.05, to={"flock": chase(2.0, 1.0, catch=0.1)})


def test_runs_of_a_script_are_those_of_flocks_with_these_kinds(tmp_path):
    """The table has a column for each axis; each row is the run of a flock made by hand."""
    made = sweep(
        HUNT.but(kinds=[replace(SHARK, parameters={"v0": 0.05})]),
        vary={"shark.agents": [0, 3], "shark.flock.weight": [0.0, 4.0]},
        runs=1, ticks=8, observe=["polarisation"], folder=tmp_path, workers=1,
    ).columns  # fmt: skip
    assert made["shark.agents"] == [0, 0, 3, 3]
    for row in (
        dict(zip(made, values, strict=True)) for values in zip(*made.values(), strict=True)
    ):
        to = {"flock": chase(row["shark.flock.weight"], 1.5)}
        kind = Kind("shark", row["shark.agents"], v0=0.05, to=to)
        flock = Flock("vem", agents=12, size=3.0, rng=row["seed"], v0=0.03, kinds=[kind])
        flock.run(8)
        assert row["polarisation"] == flock.observe("polarisation")


KINDS = (
    *("--kind", "shark=1,v0=0.05,chase=flock,radius=1,weight=2"),
    *("--relation", "flock:shark=ignore"),
)


def test_a_command_line_has_kinds_and_varies_their_numbers(tmp_path):
    words = ("sweep", "check", "vem", "--set", "agents=9", "--ticks", "5", *KINDS)
    made = call(*words, "--json", "--vary", "shark.agents=0:2:3")
    assert json.loads(made.stdout)["cells"] == 3
    for more, said in (
        (("--vary", "shark.x=0,1"), "shark.x: unknown parameter 'x'"),
        (("--vary", "flock.shark.weight=0,1"), "flock has the relation ignore to shark"),
        (("--vary", "eta=0,1", "--kind", "a=b"), "NAME=NUMBER of agents comes first (--kind)"),
        (("--vary", "eta=0,1", "--relation", "flock:whale=flee"), "unknown kind 'whale'"),
    ):
        assert said in refusal(*words, *more)
    (tmp_path / "s.toml").write_text(FILE)
    assert "--kind cannot be given with" in refusal("sweep", "check", tmp_path / "s.toml", *KINDS)


def test_a_search_moves_numbers_of_a_kind(tmp_path):
    """The default is what the run has; what it has no number of is refused."""
    text = (
        FILE[: FILE.index("[[design]]")]
        + """
[search]
algorithm = "ga"
evaluations = 4
axes = { "shark.agents" = { from = 0, to = 4 }, "shark.flock.weight" = { from = 0.0, to = 5.0 } }

[[objective]]
observable = "polarisation"
aim = "most"
"""
    )
    path = tmp_path / "o.toml"
    path.write_text(text)
    study = read_study(path)
    assert study.default == {"shark.agents": 2, "shark.flock.weight": 2.0}
    assert study.point(np.array([0.3, 0.5])) == {"shark.agents": 1, "shark.flock.weight": 2.5}
    for before, after, said in (
        ("shark.flock.weight", "shark.flock.power", "shark.flock.power has no number in this run"),
        ("shark.flock.weight", "shark.eta.speed", "shark.eta.speed: unknown parameter 'eta.speed'"),
        ("v0 = 0.05", "v0 = { normal = [0.05, 0.01] }", "agents differ in it"),
    ):
        path.write_text(text.replace(before, after).replace("shark.agents", "shark.v0"))
        with pytest.raises(InputError, match=said):
            read_study(path)
