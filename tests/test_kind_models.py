"""Check kinds with a model of their own: by which rule each moves, in ticks, files and words."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.individuals import normal, uniform
from agents.kind_models import reason_against
from agents.kinds import Kind, chase, flee, replace_kind
from agents.recordings.recorder import Recorder
from agents.recordings.recording import Recording
from agents.spec import Spec
from agents.web.web_program import demand_possible
from app.cli.main import app
from worlds.input_error import InputError

SIZE = 6.0
MET = {
    "own": {"loner": {"flock": "own"}, "flock": {"loner": "own"}},
    "ignore": {},
    "flee": {"loner": {"flock": flee(1.0, 1.5)}, "flock": {"loner": flee(2.0, 0.8, power=1.0)}},
    "chase": {"loner": {"flock": chase(1.5, 2.0)}},
}
"""What a kind and the ordinary agents do about each other."""


def two_models(model, other, relation="own", agents=40, dim=2, own=None, first=None, **words):
    """The spec of a flock of a model with five agents of another, and two of a kind without one."""
    to = MET[relation]
    kinds = [
        Kind("loner", 5, model=other, parameters=own, to=to.get("loner")),
        Kind("shark", 2, to={"flock": chase(1.0, 1.0)}),
    ]
    return Spec(
        model, agents=agents, seed=3, size=(SIZE,) * dim, world="wrap", kinds=kinds,
        to=to.get("flock", {}), parameters=first or {}, **words,
    )  # fmt: skip


def follow(flock, state):
    """Let a flock be where another one is: same agents, places, headings and speeds."""
    rows = np.argsort(np.argsort(flock.ids))
    order = np.argsort(state.ids)
    for name in ("position", "heading", "speed"):
        getattr(flock, name)[:] = getattr(state, name)[order][rows]


def by_id(flock, kind, name):
    """What the agents of a kind have, by identity."""
    rows = flock.rows_of(kind)
    return getattr(flock, name)[rows][np.argsort(flock.ids[rows])]


def demand_same_moves(spec, ticks=12, threads=1):
    """Each agent of two models moves to the bit as in a flock of its model, where it meets the same
    agents: tick by tick, all three flocks from one state."""
    both = Flock(spec, threads=threads)
    loner, shark = spec.kinds
    without = Flock(spec.but(kinds=[replace_kind(loner, model="", parameters={}), shark]))
    individual = MODELS[loner.model].individual
    own = {name: one for name, one in loner.parameters.items() if name in individual}
    shared = {name: one for name, one in loner.parameters.items() if name not in individual}
    alike = Flock(
        spec.but(
            model=loner.model, parameters=shared, individuals={}, noise="angular",
            kinds=[replace_kind(loner, model="", parameters=own), shark],
        )
    )  # fmt: skip
    if threads > 1:
        both.split_from = 2
    for _ in range(ticks):
        for flock in (without, alike):
            flock.tick = both.tick
            follow(flock, both)
        for flock in (both, without, alike):
            flock.run(1)
        for name in ("position", "heading", "speed"):
            for kind in ("flock", "shark"):
                assert np.array_equal(by_id(both, kind, name), by_id(without, kind, name))
            assert np.array_equal(by_id(both, "loner", name), by_id(alike, "loner", name))
    return both


@pytest.mark.parametrize("relation", MET)
@pytest.mark.parametrize("dim", [2, 3])
def test_each_moves_to_the_bit_as_in_a_flock_of_its_model(relation, dim):
    own = {"v0": uniform(0.02, 0.08), "eta": 0.3}
    demand_same_moves(two_models("vem", "gregoire-chate", relation, dim=dim, own=own))


PAIRS = {
    "vicsek1995 in vem": ("vem", "vicsek1995", {}, {"eta": 0.2}, 2),
    "topological in gregoire-chate": (
        "gregoire-chate", "topological", {}, {"neighbours": "metric", "v0": 0.1}, 3,
    ),
    "dorsogna in cucker-smale": ("cucker-smale", "dorsogna", {}, {"alpha": normal(1.6, 0.1)}, 2),
    "leadership in couzin": ("couzin", "leadership", {}, {"tau": 0.1, "s": uniform(0.5, 2.0)}, 2),
    "couzin in leadership": ("leadership", "couzin", {}, {"tau": 0.2, "s": 2.0}, 2),
    "cucker-smale in vasarhelyi": ("vasarhelyi", "cucker-smale", {}, {"dt": 0.1}, 3),
    "vasarhelyi in olfati-saber": ("olfati-saber", "vasarhelyi", {"dt": 0.1, "n_sub": 1.0}, {}, 2),
}  # fmt: skip
"""A flock's model, that of a kind, parameters of both, and the dimensions."""


@pytest.mark.exhaustive
@pytest.mark.parametrize("relation", MET)
@pytest.mark.parametrize("pair", PAIRS)
def test_each_of_two_models_moves_as_among_its_like(pair, relation):
    model, other, first, own, dim = PAIRS[pair]
    demand_same_moves(two_models(model, other, relation, dim=dim, own=own, first=first))


def test_threads_change_nothing():
    own = {"v0": 0.05}
    demand_same_moves(two_models("vem", "gregoire-chate", agents=300, own=own), 8, threads=2)


def test_agents_that_step_one_by_one_move_as_all_at_once():
    spec = two_models("vem", "gregoire-chate", "chase", own={"v0": 0.05})
    at_once, one_by_one = Flock(spec), Flock(spec)
    for _ in range(3):
        at_once.run(1)
        for agent in one_by_one.agents:
            agent.step()
    assert np.array_equal(at_once.position, one_by_one.position)


def test_plain_python_moves_them_alike():
    spec = two_models("vem", "gregoire-chate", "flee", agents=8, own={"v0": 0.05})
    compiled, plain = Flock(spec), Flock(spec, interpret=True)
    for flock in (compiled, plain):
        flock.run(2)
    assert np.allclose(compiled.position, plain.position, atol=1e-9)


def test_a_tick_is_that_of_the_naive_flock():
    """Without noise both are Vicsek's rule: those of the kind average over all, and go faster."""
    own = {"v0": 0.07, "r": 1.5, "eta": 0.0}
    spec = two_models("vem", "gregoire-chate", own=own, first={"eta": 0.0, "r": 0.8})
    flock = Flock(spec.but(kinds=spec.kinds[:1]))
    away = flock.position[None] - flock.position[:, None]
    distance = np.linalg.norm(away - SIZE * np.floor(away / SIZE + 0.5), axis=2)
    is_loner = np.isin(np.arange(len(distance)), flock.rows_of("loner"))
    near = distance <= np.where(is_loner, 1.5, 0.8)[:, None]
    heading = (near[..., None] * flock.heading[None]).sum(axis=1)
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    position = (flock.position + np.where(is_loner, 0.07, 0.03)[:, None] * heading) % SIZE
    flock.run(1)
    assert np.allclose(flock.heading, heading, atol=1e-9)
    assert np.allclose(flock.position, position, atol=1e-9)
    assert np.allclose(flock.speed, np.where(is_loner, 0.07, 0.03))


def test_who_is_met_is_caught_whatever_its_model():
    hunters = Kind("shark", 3, model="gregoire-chate", v0=0.1, eta=0.0,
                   to={"flock": chase(3.0, 2.0, catch=0.3)})  # fmt: skip
    for caught in ("taken", "frozen", "moved"):
        relation = chase(3.0, 2.0, catch=0.3, caught=caught)
        kind = replace_kind(hunters, to={"flock": relation})
        flock = Flock(Spec("vem", agents=60, seed=2, size=SIZE, kinds=[kind]))
        flock.run(60)
        assert flock.observe("catches") > 0
        assert len(flock.rows_of("shark")) == 3
        frozen = flock.kind_names == "caught"
        assert frozen.sum() == (flock.observe("catches") if caught == "frozen" else 0)
        before = flock.position[frozen].copy()
        flock.run(1)
        assert np.array_equal(before, flock.position[frozen])


# Their parameters.


def differing_flock(**words):
    """Five agents of a model with other names, whose speeds differ."""
    own = {"eta": 0.2, "v0": normal(0.06, 0.01)}
    return Flock(two_models("vicsek1995", "gregoire-chate", "own", own=own, **words))


def by_own(flock, name):
    """The numbers of the agents of the kind with a model of its own."""
    return flock.own[name][flock.rows_of("loner")]


def test_each_has_the_parameters_of_its_model():
    flock = Flock(two_models("leadership", "couzin", own={"tau": 0.2, "r_r": uniform(0.5, 1.5)}))
    loners, prey = flock.rows_of("loner"), flock.rows_of("flock")
    assert np.ptp(flock.own["r_r"][loners]) > 0.0
    assert np.isnan(flock.own["r_r"][prey]).all()
    couzin = MODELS["couzin"].parameters()
    assert (flock.own["alpha"][loners] == couzin.alpha).all()
    agent = next(one for one in flock.agents if one.kind == "loner")
    other = next(one for one in flock.agents if one.kind == "flock")
    assert agent.r_r == flock.own["r_r"][agent.row]
    assert other.omega == flock.parameters.omega
    with pytest.raises(AttributeError, match="r_r"):
        _ = other.r_r
    assert flock.reaches[agent.row] == couzin.dr_o + couzin.dr_a + agent.r_r
    assert flock.reach >= flock.reaches.max()


def test_numbers_are_drawn_by_identity_and_set_by_hand_and_kept(tmp_path):
    flock, few = differing_flock(), differing_flock()
    assert np.ptp(flock.own["v0"][flock.rows_of("loner")]) > 0.0
    few.set(v0=normal(0.03, 0.005))
    assert np.array_equal(by_own(few, "v0"), by_own(flock, "v0"))
    flock.run(5)
    loners = flock.agents.select(lambda agent: agent.kind == "loner")
    loners.set("v0", 0.09)
    assert (flock.own["v0"][flock.rows_of("loner")] == 0.09).all()
    flock.set(v0=0.02)
    assert (flock.own["v0"][flock.rows_of("loner")] == 0.09).all()
    flock.set_kind("loner", eta=0.4)
    assert (flock.own["v0"][flock.rows_of("loner")] == 0.09).all()
    assert (flock.own["eta"][flock.rows_of("loner")] == 0.4).all()
    flock.save(tmp_path / "state.parquet")
    loaded = Flock.load(tmp_path / "state.parquet")
    assert np.array_equal(loaded.own["v0"], flock.own["v0"])
    for one in (flock, loaded):
        one.run(10)
    assert np.array_equal(loaded.position, flock.position)
    assert Flock(Spec.from_toml(flock.spec.to_toml())).own["v0"].max() == 0.09


def test_one_begun_again_moves_as_before():
    flock = differing_flock()
    flock.run(10)
    before = flock.position.copy()
    flock.set_kind("loner", v0=0.2)
    flock.run(3)
    flock.restart(3)
    flock.run(10)
    assert np.array_equal(flock.position, before)


def test_a_spec_keeps_the_model_and_a_copy_and_a_state_go_on(tmp_path):
    flock = differing_flock()
    assert Spec.from_toml(flock.spec.to_toml()).kinds == flock.spec.kinds
    assert flock.spec.models == ("vicsek1995", "gregoire-chate")
    flock.run(7)
    copied = pickle.loads(pickle.dumps(flock))
    flock.save(tmp_path / "two.parquet")
    loaded = Flock.load(tmp_path / "two.parquet")
    past = flock.snapshot()
    for one in (flock, copied, loaded):
        one.run(9)
    assert np.array_equal(flock.position, copied.position)
    assert np.array_equal(flock.position, loaded.position)
    flock.return_to(past)
    flock.run(9)
    assert np.array_equal(flock.position, copied.position)


def test_a_recording_holds_the_parameters_of_a_kind(tmp_path):
    flock = Flock(two_models("leadership", "couzin", own={"tau": 0.2, "r_r": uniform(0.5, 1.5)}))
    path = tmp_path / "two.parquet"
    with Recorder(path, flock) as recorder:
        for _ in range(3):
            recorder.write()
            flock.run(1)
    recording = Recording(path)
    kind, r_r = recording.columns["kind"], recording.columns["own_r_r"]
    assert "loner goes by couzin" in kind["meaning"]
    assert r_r["unit"] == "length"
    played = recording.state(2)
    assert np.array_equal(played.own["r_r"], flock.own["r_r"], equal_nan=True)
    assert played.by_model_of(int(played.rows_of("loner")[0])).model.name == "couzin"
    table = pq.read_table(path)
    row = int(np.flatnonzero(table["kind"].to_numpy() == 1)[0])
    for value, other in ((99.0, row), (1.0, int(np.flatnonzero(table["kind"].to_numpy() == 0)[0]))):
        column = table["own_r_r"].to_numpy().copy()
        column[other] = value
        changed = table.set_column(
            table.column_names.index("own_r_r"), "own_r_r", pa.array(column)
        ).replace_schema_metadata(table.schema.metadata)
        pq.write_table(changed, tmp_path / "bad.parquet")
        with pytest.raises(InputError, match=r"a r_r outside of .*\(row"):
            Recording(tmp_path / "bad.parquet").state(0)


# What asks for a model or for a parameter asks the agent's own.


def test_an_agent_is_inspected_with_its_own_model():
    flock = Flock(two_models("leadership", "couzin", own={"tau": 0.2, "r_r": 1.5, "alpha": 200.0}))
    loner, prey = (int(flock.rows_of(name)[0]) for name in ("loner", "flock"))
    couzin, leaders = flock.inspect(loner), flock.inspect(prey)
    assert couzin.model is MODELS["couzin"]
    assert couzin.view == 200.0
    assert couzin.shells[0].radius == 1.5
    assert leaders.model is MODELS["leadership"]
    assert leaders.shells != couzin.shells
    flock.warm()


def test_links_and_reaches_go_by_the_agents_own_models():
    own = {"r": 2.0, "eta": 0.1}
    flock = Flock(two_models("vem", "gregoire-chate", own=own, first={"r": 0.5}))
    loners = set(flock.rows_of("loner").tolist())
    assert {float(flock.reaches[row]) for row in loners} == {2.0}
    away = flock.position[None] - flock.position[:, None]
    distance = np.linalg.norm(away - SIZE * np.floor(away / SIZE + 0.5), axis=2)
    heeds = flock.heeds(*np.indices(distance.shape).reshape(2, -1)).reshape(distance.shape)
    near = distance <= np.maximum(flock.reaches[:, None], flock.reaches[None])
    pairs = np.argwhere(np.triu(near & (heeds | heeds.T), 1))
    assert flock.links().tolist() == pairs.tolist()
    alone = flock.snapshot().of_kind("loner")
    assert (alone.model.name, alone.reach, len(alone.ids)) == ("gregoire-chate", 2.0, 5)
    measured = flock.observe("mean-neighbours", kind="loner")
    within = (distance <= 2.0)[np.ix_(sorted(loners), sorted(loners))].sum(axis=1) - 1
    assert measured == within.mean()


# What is refused.


@pytest.mark.parametrize(
    ("model", "kind", "words", "message"),
    [
        ("vem", {"model": "hwvem"}, {}, r"model = hwvem is not allowed: its agents tell signals"),
        ("vem", {"model": "inertial-spin"}, {}, "not allowed: its agents remember"),
        ("vem", {"model": "thesis"}, {}, "not allowed: its agents can crash"),
        ("vem", {"model": "couzin"}, {}, "its unit of time is s, and that of vem ticks"),
        ("couzin", {"model": "vasarhelyi"}, {}, "its unit of length is m, and that of couzin leng"),
        ("cucker-smale", {"model": "vasarhelyi"}, {}, "is 0.1 s and the flock's 0.02 s: set dt"),
        ("couzin", {"model": "leadership"}, {}, "is defined in 2-D, and this world is 3-D"),
        ("vem", {"model": "topological"}, {}, "are the nearest.*: set neighbours=metric"),
        ("vem", {"model": "gregoir"}, {}, "unknown model 'gregoir'.*gregoire-chate"),
        ("vem", {"model": "tracks"}, {}, "it is played and not run"),
        ("vem", {"model": 3}, {}, "kind loner: model = 3 is not the name of a model"),
        ("vem", {"model": "vem-a", "steered": True}, {}, "vem-a.*: it cannot be steered"),
        ("vem", {"model": "vem-a", "omega": 1.0}, {}, "unknown parameter 'omega'.*model vem-a"),
        ("vem", {"model": "vem-a", "v0": 99.0}, {}, "kind loner: v0 = 99.0.* is outside"),
        ("vem", {"model": "vem-a", "k": normal(7, 1)}, {}, "kind loner: k cannot differ"),
        ("hwvem", {"model": "vem"}, {}, "not allowed in a flock of hwvem: its agents tell sign"),
        ("vem", {"model": "vem-a"}, {"activation": "random"}, "with activation = random: agents"),
        ("vem", {"model": "vem-a"}, {"delay": 2.0}, "where messages take time or are inexact"),
    ],
)  # fmt: skip
def test_a_model_that_does_not_fit_is_refused_in_one_line(model, kind, words, message):
    with pytest.raises(InputError, match=message) as refusal:
        Flock(Spec(model, agents=5, seed=1, kinds=[{"name": "loner", **table_of(kind)}], **words))
    assert "\n" not in str(refusal.value)


def table_of(kind):
    """A kind as a spec has it: what is no key of one is a parameter."""
    keys = ("model", "steered")
    own = {name: value for name, value in kind.items() if name not in keys}
    return {name: kind[name] for name in keys if name in kind} | {"parameters": own}


def test_a_running_flock_keeps_its_models_and_its_tick():
    flock = Flock(two_models("cucker-smale", "dorsogna"))
    with pytest.raises(InputError, match=r"its tick is 0.02 s and the flock's 0.05 s: set dt"):
        flock.set(dt=0.05)
    changed = flock.kinds.with_kind(replace_kind(flock.kinds.kind("loner"), model="vasarhelyi"))
    with pytest.raises(InputError, match="a running flock keeps its models, here dorsogna"):
        flock.change_kinds(changed)
    with pytest.raises(InputError, match="kind loner has a model of its own, dorsogna: in a page"):
        demand_possible(flock)
    assert flock.dt == 0.02


def test_every_model_that_is_said_to_can_be_that_of_a_kind():
    """`list kinds` says so; a flock of each model takes it where both agree."""
    listed = json.loads(CliRunner().invoke(app, ["list", "kinds", "--json"]).stdout)
    said = {row["model"]: row["own_model"] for row in listed}
    for name, model in MODELS.items():
        assert said[name].startswith("no, " if reason_against(model) else "yes, ")
        metric = {"neighbours": "metric"} if model.nearest(model.parameters()) else {}
        kind = Kind("loner", 1, model=name, parameters=metric)
        spec = Spec(name, agents=3, seed=1, kinds=[kind], parameters=metric)
        if reason_against(model):
            with pytest.raises(InputError, match="not allowed in a flock of"):
                Flock(spec)
        else:
            assert Flock(spec).kind_models[0].model is model


def test_the_command_line_takes_the_model_of_a_kind():
    words = ["run", "vem", "--agents", "20", "--seed", "1", "--ticks", "3", "--json"]
    done = CliRunner().invoke(app, [*words, "--kind", "loner=2,model=gregoire-chate,v0=0.05"])
    assert done.exit_code == 0, done.output
    refused = CliRunner().invoke(app, [*words, "--kind", "loner=2,model=couzin"])
    assert refused.exit_code == 2
    assert "its unit of time is s" in refused.output
