"""States and recordings that anybody may have made: opened, or refused in one line."""

from __future__ import annotations

import io
import json
import sys
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.bodies.constant_speed import BODY as CONSTANT_SPEED
from agents.catalogue import MODELS
from agents.engine.heeding import CAUGHT
from agents.individuals import each, normal
from agents.kinds import Kind, chase
from agents.models.model import Model
from agents.recordings.parquet_table import ParquetTable
from agents.recordings.recorder import KEY, Recorder
from agents.rules.vicsek import VEM
from agents.spec import Spec
from app.sandboxed_reader import read_in_sandbox
from app.viewer.gallery.file_opener import open_file
from app.viewer.gallery.saved_scene import read_run
from app.viewer.run import stored_flock as limits
from app.viewer.run.flock_run_builder import FlockRunBuilder
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.paired_run import companion
from app.viewer.run.stored_flock import REWRITE, StoredFlock, read_stored, under_new_rule
from worlds.input_error import InputError


@pytest.fixture(scope="module")
def state(tmp_path_factory):
    """The table of a saved state of a mission with a path, whose agents can crash."""
    path = tmp_path_factory.mktemp("state") / "state.parquet"
    Flock("hwvem-nav", world="obstacles", agents=10, rng=3).save(path)
    return pq.read_table(path)


def packed(table, **more) -> bytes:
    """A table as the bytes of a Parquet file."""
    out = io.BytesIO()
    pq.write_table(table, out, **more)
    return out.getvalue()


def told(meta: dict, table) -> bytes:
    """A table with other metadata."""
    return packed(table.replace_schema_metadata({KEY: json.dumps(meta).encode()}))


def with_column(table, name: str, values) -> bytes:
    place = table.column_names.index(name)
    made = table.set_column(place, name, values)
    return packed(made.replace_schema_metadata(table.schema.metadata))


def refused(content: bytes) -> str:
    with pytest.raises(InputError) as found:
        read_stored("sent.parquet", content)
    line = str(found.value)
    assert "\n" not in line
    return line


def test_a_state_from_a_browser_goes_on_to_the_bit(state):
    made = open_file("../../state.parquet", packed(state))
    assert isinstance(made, StoredFlock)
    assert (made.name, made.kind) == ("state.parquet", "saved state")
    flock = made.flock(Flock)
    assert np.array_equal(flock.position[:, 0], state["x"].to_numpy())
    again = Flock("hwvem-nav", world="obstacles", agents=10, rng=3)
    again.run(5)
    flock.run(5)
    assert np.array_equal(flock.position, again.position)


@pytest.mark.parametrize(
    ("name", "change", "says"),
    [
        ("x", lambda x: np.where(x == x[4], np.nan, x), "position that is no finite"),
        ("x", lambda x: x + 1e13, "too far away"),
        ("x", lambda x: x - 1e5, "outside"),
        ("ux", lambda x: x + 1.0, "no unit vector"),
        ("speed", lambda x: x * np.inf, "speed that is no finite"),
        ("id", lambda x: x * 0, "two agents of one identity"),
        ("id", lambda x: -x, "an identity that none can be"),
        ("leg", lambda x: x + 99, "a waypoint that is not there"),
        ("leg", lambda x: x - 1, "a waypoint that is not there"),
        ("tick", lambda x: x - 5, "ticks"),
        ("tick", lambda x: x + 2**60, "ticks outside"),
        ("tick", lambda x: np.arange(len(x))[::-1], "its ticks do not rise"),
        ("tick", lambda x: x + 0.5, "no whole numbers"),
        ("speed", lambda x: pa.array([str(one) for one in x]), "holds what is no number"),
        ("speed", lambda x: pa.array([None, *x[1:].tolist()]), "holds what is no number"),
    ],
)
def test_rows_that_are_no_flock_are_refused(state, name, change, says):
    values = change(state[name].to_numpy())
    column = values if isinstance(values, pa.Array) else pa.array(values)
    assert says in refused(with_column(state, name, column))


def test_a_column_that_is_missing_is_named(state):
    assert "has no column 'uy'" in refused(packed(state.drop_columns(["uy"])))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('model = "hwvem-nav"', 'model = "nobody"', "unknown model 'nobody'"),
        ("v0 = 0.1", "v0 = 900.0", "v0 = 900"),
        ("v0 = 0.1", "v9 = 0.1", "v9"),
        ("seed = 3", "seed = -3", "seed = -3"),
        ("agents = 10", "agents = 1e99", "agents"),
        ('start = "random"', "start = 3", "start"),
    ],
)
def test_a_spec_that_is_wrong_is_refused(state, old, new, says):
    meta = json.loads(state.schema.metadata[KEY])
    assert old in meta["spec"]
    meta["spec"] = meta["spec"].replace(old, new)
    assert says in refused(told(meta, state))


def test_a_world_is_in_the_file_or_built_in(state):
    meta = json.loads(state.schema.metadata[KEY])
    meta["spec"] = meta["spec"].replace('world = "obstacles"', 'world = "/etc/hostname"')
    assert "unknown world '/etc/hostname'" in refused(told(meta, state))


@pytest.mark.parametrize(
    "change",
    [
        {"size": [1e300, 1e300]},
        {"size": [-1.0, 5.0]},
        {"size": "large"},
        {"size": [5.0, 5.0, 5.0]},
        {"edges": ["open"] * 9},
        {"obstacle": [{"kind": "disc", "centre": [1, 1], "radius": 1}] * 5000},
        {"boundary_spacing": 1e-9},
        {"mission": 7},
    ],
)
def test_a_world_that_is_unsound_is_refused(state, change):
    meta = json.loads(state.schema.metadata[KEY])
    meta["world"] |= change
    refused(told(meta, state))


@pytest.mark.parametrize("meta", [b"{", b"[]", b"3", b'{"spec": 4}', b"\xff\xfe", b"{}" * 10])
def test_metadata_of_anything_is_refused(state, meta):
    refused(packed(state.replace_schema_metadata({KEY: meta})))


def test_what_unpacks_to_too_much_is_refused_before_it_is_unpacked(state, monkeypatch):
    rows = limits.MOST_NUMBERS
    zeros = pa.DictionaryArray.from_arrays(pa.array(np.zeros(rows, np.int8)), pa.array([7]))
    names = state.column_names[:2]
    bomb = pa.table(dict.fromkeys(names, zeros)).replace_schema_metadata(state.schema.metadata)
    content = packed(bomb, compression="zstd")
    assert len(content) < limits.LARGEST
    monkeypatch.setattr(pq.ParquetFile, "read", lambda *_, **__: pytest.fail("it was unpacked"))
    assert f"holds {rows} rows" in refused(content)


def test_pages_say_themselves_what_they_unpack_to(state, monkeypatch):
    content = packed(state, compression="zstd", data_page_size=64, write_statistics=True)
    meta = pq.ParquetFile(io.BytesIO(content)).metadata
    columns = [meta.row_group(0).column(k) for k in range(meta.num_columns)]
    with_headers = sum(one.total_uncompressed_size for one in columns)
    table = ParquetTable("sent.parquet", content, "a table")
    assert 0.4 * with_headers < table.unpacked_size(0, table.names) < with_headers
    monkeypatch.setattr(limits, "MOST_BYTES", 500)
    monkeypatch.setattr(pq.ParquetFile, "read", lambda *_, **__: pytest.fail("it was unpacked"))
    assert "more than the laboratory takes" in refused(content)


def test_a_file_from_a_browser_is_bounded(monkeypatch, state):
    monkeypatch.setattr(limits, "LARGEST", 100)
    assert "`flockscope lab FILE` opens larger ones" in refused(packed(state))


@settings(max_examples=8, deadline=None)
@given(data=st.data())
def test_bytes_that_are_changed_are_refused_or_make_a_flock(state, data):
    content = bytearray(packed(state))
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(4, len(content) - 1))] = data.draw(st.integers(0, 255))
    try:
        made = open_file("sent.parquet", bytes(content))
    except InputError as error:
        line = str(error)
    else:
        line = made.kind
        assert np.isfinite(made.flock(Flock, interpret=True).position).all()
    assert "\n" not in line


def test_a_file_that_ends_the_process_that_reads_it_is_refused(state, monkeypatch, tmp_path):
    aborts = tmp_path / "aborts"
    aborts.write_text("#!/bin/sh\nkill -ABRT $$\n")
    aborts.chmod(0o700)
    monkeypatch.setattr(sys, "executable", str(aborts))
    with pytest.raises(InputError, match=r"^sent\.parquet cannot be read: it is broken, or"):
        open_file("sent.parquet", packed(state))


def test_the_library_sees_no_footer_of_a_stranger_as_it_is_written_anew(state, monkeypatch):
    content = packed(state)

    def seen(*_, **__):
        raise AssertionError("it reads the footer as it came")

    monkeypatch.setattr(pq, "read_table", seen)
    made = ParquetTable("made", limits.rewrite("sent.parquet", content), "a state").read()
    assert made.equals(ParquetTable("sent", content, "a state").read(), check_metadata=True)


def test_what_is_opened_was_written_by_ours(state):
    content = packed(state, compression="gzip", row_group_size=3)
    anew = pq.ParquetFile(io.BytesIO(read_in_sandbox(REWRITE, "sent.parquet", content)))
    assert anew.metadata.num_row_groups == 1
    assert anew.metadata.row_group(0).column(0).compression == "ZSTD"
    assert anew.read().equals(pq.read_table(io.BytesIO(content)), check_metadata=True)


def test_a_flock_whose_agents_differ_goes_on_and_is_set_up_with_their_numbers(tmp_path):
    flock = Flock("vem", agents=6, rng=3, eta=normal(0.5, 0.1))
    flock.run(2)
    flock.members[2].eta = 0.9
    flock.save(tmp_path / "state.parquet")
    stored = read_stored("state.parquet", (tmp_path / "state.parquet").read_bytes())
    building = FlockRunBuilder(Flock, companion)
    again = building.flock(stored.spec, stored)
    assert np.array_equal(again.own["eta"], flock.own["eta"])
    assert stored.spec.individuals["eta"] == each(flock.own["eta"])
    changed = stored.spec.with_parameters(stored.spec.all_parameters | {"v0": 0.04})
    again = building.flock(changed, stored)
    assert again.v0 == 0.04
    assert np.array_equal(again.own["eta"], flock.own["eta"])
    assert building.flock(stored.spec.with_parameters({"eta": 0.3}), stored).own == {}


def test_a_rule_that_is_edited_keeps_what_differs():
    flock = Flock("vem", agents=6, rng=3, eta=normal(0.5, 0.1))
    flock.run(2)
    flock.members[2].eta = 0.9
    stored = under_new_rule(flock.spec, flock.snapshot(), Flock)
    assert np.array_equal(stored.flock(Flock).own["eta"], flock.own["eta"])


@pytest.mark.parametrize("caught", ["taken", "frozen"])
def test_a_hunt_goes_on_from_its_state_is_played_and_keeps_its_kinds(tmp_path, caught):
    prey = Kind("minnow", 40)
    shark = Kind("shark", 2, v0=0.1, to={"minnow": chase(2.0, 2.0, catch=0.5, caught=caught)})
    flock = Flock(Spec("vem", agents=2, seed=3, size=5.0, kinds=[prey, shark]))
    path = tmp_path / "hunt.parquet"
    with Recorder(path, flock) as recorder:
        for _ in range(30):
            flock.run(1)
            recorder.write()
    flock.save(tmp_path / "state.parquet")
    assert len(flock.catches.id) > 5
    stored = read_stored("state.parquet", (tmp_path / "state.parquet").read_bytes())
    building = FlockRunBuilder(Flock, companion)
    again = building.flock(stored.spec, stored)
    assert again.kind_names.tolist() == flock.kind_names.tolist()
    changed = stored.spec.relating("shark", "minnow", chase(1.0, 1.0))
    assert building.flock(changed, stored).kinds.of("shark", "minnow").weight == 1.0
    again.run(5)
    flock.run(5)
    assert np.array_equal(again.position, flock.position)
    played = read_stored("hunt.parquet", path.read_bytes())
    run = building.run(building.flock(played.spec, played), None, played, 1, FrameRequest(),
                       frozenset())  # fmt: skip
    counts = []
    for tick in (1, 10, 30):
        run.show(tick)
        frame = run.look(closely=True)
        counts.append(run.readings.values["catches"])
        assert ((frame.kind == 1) | frame.is_caught).sum() == 40 - (caught == "taken") * counts[-1]
    assert counts == sorted(counts)
    assert counts[-1] > counts[0]


def test_a_rule_that_is_edited_to_know_a_kind_has_it_first_and_the_others_as_they_were(monkeypatch):
    before = Model(replace(VEM, name="herd"), CONSTANT_SPEED)
    monkeypatch.setitem(MODELS, "herd", before)
    flock = Flock(Spec("herd", agents=8, seed=1, kinds=[Kind("shark", 2, v0=0.05)]))
    flock.arrays.kind[flock.rows_of("shark")[0]] = CAUGHT
    sharks = flock.kind_names == "shark"
    monkeypatch.setitem(
        MODELS, "herd", Model(replace(before.rule, kinds=("wolf",)), CONSTANT_SPEED)
    )
    stored = under_new_rule(flock.spec, flock.snapshot(), Flock)
    now = stored.flock(Flock)
    assert now.kinds.names == ("flock", "wolf", "shark")
    assert np.array_equal(now.kind_names, flock.kind_names)
    assert (now.own["v0"][sharks] == 0.05).all()
    scene = read_run({"model": "herd", "agents": 5, "kinds": [{"name": "shark"}]}, "a scene")
    assert Flock(scene).kinds.names == ("flock", "wolf", "shark")


@pytest.mark.parametrize("model", ["", "gregoire-chate"])
def test_a_rule_that_is_edited_keeps_kinds(model):
    shark = Kind("shark", 2, v0=0.05, to={"flock": chase(2.0, 2.0)}, model=model)
    flock = Flock(Spec("vem", agents=6, seed=3, kinds=[shark]))
    flock.run(2)
    stored = under_new_rule(flock.spec, flock.snapshot(), Flock)
    again = stored.flock(Flock)
    assert stored.run.kinds == flock.spec.kinds
    assert np.array_equal(again.own["v0"], flock.own["v0"])
    assert again.kind_names.tolist() == flock.kind_names.tolist()
    flock.run(5)
    again.run(5)
    assert np.array_equal(again.position, flock.position)
