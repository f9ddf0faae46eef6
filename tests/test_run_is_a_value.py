"""A spec begins a run again to the bit; a saved state or a recorded tick goes on with it."""

from __future__ import annotations

import numpy as np
import pytest

from agents import Flock, flock_world
from agents.catalogue import MODELS
from agents.recordings.recorder import Recorder
from agents.spec import CompleteSpec, Options, Spec
from worlds.input_error import InputError
from worlds.obstacles import Disc
from worlds.world import World

RUNS = [
    {"model": "hwvem", "agents": 60, "eta": 0.31, "p1": 0.1, "world": "wrap-plain"},
    {"model": "wvem", "agents": 40, "dim": 3, "eta": 1.0, "noise": "vectorial"},
    {"model": "ivem-a", "agents": 30, "world": "open", "activation": "random", "eta": 0.1},
    {"model": "vem", "agents": 1, "activation": "sequential"},
]


def same(a: Flock, b: Flock) -> bool:
    return (
        a.tick == b.tick
        and np.array_equal(a.position, b.position)
        and np.array_equal(a.heading, b.heading)
        and np.array_equal(a.ids, b.ids)
        and np.array_equal(a.signals(), b.signals())
    )


@pytest.mark.parametrize("settings", RUNS)
def test_a_spec_through_toml_gives_the_same_bits(settings):
    flock = Flock(**settings, rng=9)
    again = Flock.from_spec(Spec.from_toml(flock.spec.to_toml()))
    flock.run(25)
    again.run(25)
    assert same(flock, again)


@pytest.mark.parametrize("settings", RUNS)
def test_a_saved_state_goes_on_to_the_bit(settings, tmp_path):
    flock = Flock(**settings, rng=9)
    flock.run(7)
    flock.set(v0=0.05)
    flock.save(tmp_path / "state.parquet")
    again = Flock.load(tmp_path / "state.parquet")
    assert again.parameters == flock.parameters
    flock.run(20)
    again.run(20)
    assert same(flock, again)


def test_any_tick_of_a_recording_goes_on_to_the_bit(tmp_path):
    flock = Flock("hwvem", agents=50, rng=2, eta=0.2)
    with Recorder(tmp_path / "run.parquet", flock) as recorder:
        for _ in range(10):
            recorder.write()
            flock.run(1)
        recorder.write()
    early = Flock.load(tmp_path / "run.parquet", tick=4)
    assert early.tick == 4
    early.run(6)
    assert same(early, flock)
    assert same(Flock.load(tmp_path / "run.parquet"), flock)


def test_added_and_removed_agents_come_back_from_a_saved_state(tmp_path):
    from agents import Member

    flock = Flock("hwvem", agents=20, rng=2, eta=0.2)
    flock.run(3)
    flock.agents[4].remove()
    Member(flock, position=[0.1, 0.2], heading=[0.0, 2.0])
    flock.save(tmp_path / "state.parquet")
    again = Flock.load(tmp_path / "state.parquet")
    assert again.ids.tolist() == flock.ids.tolist()
    flock.run(5)
    again.run(5)
    assert same(flock, again)
    assert Member(again).unique_id == Member(flock).unique_id


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ("hwvem-nav", {"agents": 12}),
        ("squashing-cars", {}),
        ("vem", {"activation": "random", "eta": 1.0}),
        ("vem", {"delay": 2.0, "jitter": 1.0, "eta": 1.0}),
        ("vem", {"gusts": 0.05, "eta": 1.0}),
    ],
)
def test_compiling_its_tick_leaves_a_flock_as_it_is(model, words):
    plain, compiled = (Flock(model, rng=3, **words) for _ in range(2))
    plain.run(3)
    compiled.run(3)
    compiled.compile_tick()
    assert compiled.is_compiled
    assert compiled.tick == 3
    for _ in range(2):
        for mine, other in zip(plain.arrays, compiled.arrays, strict=True):
            assert np.array_equal(mine, other, equal_nan=True)
        plain.run(10)
        compiled.run(10)


def test_a_run_from_given_arrays_is_not_begun_from_its_spec():
    start = {"position": [[0.0, 0.0]], "heading": [[1.0, 0.0]]}
    spec = Flock("vem", start=start, size=3.0, rng=1).spec
    with pytest.raises(InputError, match="given"):
        Flock.from_spec(spec)


def test_a_part_of_a_spec_is_completed_by_the_model_and_its_world():
    part = Spec.from_toml('model = "vem"\nseed = 4\n[parameters]\neta = 0.5')
    assert (part.agents, part.world, part.size) == (None, None, None)
    flock, words = Flock(part), Flock("vem", rng=4, eta=0.5)
    assert flock.spec == words.spec
    assert np.array_equal(flock.position, words.position)
    assert Flock(part, agents=7, eta=1.0).spec == Flock("vem", agents=7, rng=4, eta=1.0).spec


def test_a_flock_has_a_complete_spec_which_is_equal_to_what_was_asked_for():
    flock = Flock("vem", agents=7, rng=4)
    asked = Spec.from_toml(flock.spec.to_toml())
    assert type(asked) is Spec
    assert type(flock.spec) is type(flock.options) is CompleteSpec
    assert asked == flock.spec
    assert flock.spec == asked
    assert asked != flock.spec.but(seed=5)
    assert asked.to_toml() == flock.spec.to_toml()


def test_a_complete_spec_stays_so_unless_something_is_opened():
    spec = Flock("vem", agents=7, rng=4).spec
    assert type(spec.but(seed=5, size=None)) is CompleteSpec
    opened = spec.but(agents=None)
    assert type(opened) is Spec
    assert opened.agents is None
    assert Flock(opened).spec.agents == MODELS["vem"].agents
    with pytest.raises(InputError, match="seed = None is not allowed"):
        spec.with_values(seed=None)


def test_a_flock_that_was_pickled_with_a_plain_spec_has_a_complete_one():
    flock = Flock("vem", agents=7, rng=4)
    state = flock.__getstate__() | {"options": Spec(**dict(flock.options))}
    again = Flock.__new__(Flock)
    again.__setstate__(state)
    assert type(again.options) is CompleteSpec
    assert again.spec == flock.spec


def test_a_seed_is_drawn_once():
    spec = flock_world.complete_spec(Spec("vem"), MODELS["vem"])
    assert 0 <= spec.seed < 2**31
    assert Flock(spec).seed == spec.seed
    assert Flock(Spec("vem")).datacollector.model_reporters.keys() == {"polarisation", "seed"}
    assert Flock(spec).datacollector.model_reporters.keys() == {"polarisation"}


def test_sides_say_the_dimensions():
    assert Flock("hwvem", size=(4.0, 5.0, 6.0), rng=1).world.size == (4.0, 5.0, 6.0)
    assert Spec(size=(4.0, 5.0)).dim == 2


def test_a_spec_may_hold_a_world_and_writes_it_with_its_layout():
    yard = World("yard", (9.0, 9.0), ("open", "open"), obstacles=(Disc(centre=(4, 4), radius=1),))
    spec = Spec("reynolds", agents=5, seed=2, world=yard)
    again = Spec.from_toml(spec.to_toml())
    assert (again.world, again.layout) == ("yard", yard.to_layout())
    assert Flock(again).world == Flock(spec).world == yard


def test_a_state_whose_spec_leaves_something_open_is_refused(tmp_path):
    import pyarrow.parquet as pq

    Flock("vem", agents=5, rng=1).save(tmp_path / "state.parquet")
    table = pq.read_table(tmp_path / "state.parquet")
    meta = table.schema.metadata[b"flockscope"].replace(b"seed = 1\\n", b"")
    pq.write_table(table.replace_schema_metadata({b"flockscope": meta}), tmp_path / "open.parquet")
    with pytest.raises(InputError, match=r"seed is missing \(.*open\.parquet\)"):
        Flock.load(tmp_path / "open.parquet")


def test_a_file_that_is_no_state_is_refused(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    (tmp_path / "text.parquet").write_text("hello")
    pq.write_table(pa.table({"tick": [1]}), tmp_path / "other.parquet")
    for name in ("text.parquet", "other.parquet", "missing.parquet"):
        with pytest.raises(InputError, match=name):
            Flock.load(tmp_path / name)


def test_a_state_with_a_number_that_is_none_is_refused(tmp_path):
    flock = Flock("vem", agents=5, rng=1)
    flock.save(tmp_path / "state.parquet")
    import pyarrow.parquet as pq

    table = pq.read_table(tmp_path / "state.parquet")
    broken = table.set_column(2, "x", [[float("nan")] * 5])
    pq.write_table(broken.replace_schema_metadata(table.schema.metadata), tmp_path / "nan.parquet")
    with pytest.raises(InputError, match="finite"):
        Flock.load(tmp_path / "nan.parquet")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("model = 3\nagents", "not TOML"),
        ('modle = "vem"', "did you mean 'model'"),
        ("agents = 3", "model is missing"),
        ('model = "vem"\nagents = 0', "agents = 0 is not allowed: a whole number >= 1"),
        ('model = "vem"\nactivation = "rand"', "unknown activation 'rand'"),
    ],
)
def test_a_spec_that_is_wrong_is_named(text, says):
    with pytest.raises(InputError, match=says):
        Spec.from_toml(text, "file.toml")


def test_an_option_that_no_model_knows_of_stays_open(monkeypatch):
    """A new option of a run needs no line in any other file."""

    class MoreOptions(Options):
        extra_option: int | None = None

    monkeypatch.setattr(flock_world, "Options", MoreOptions)
    monkeypatch.setattr(Spec, "extra_option", None, raising=False)
    spec = flock_world.complete_spec(Spec("vem"), MODELS["vem"])
    assert (spec.agents, spec.extra_option) == (MODELS["vem"].agents, None)
