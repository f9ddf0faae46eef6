"""Recordings and states from strangers: a flock or one line, in little memory."""

from __future__ import annotations

import base64
import io
import json
import re
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.recordings import parquet_footer, snapshot_reader
from agents.recordings import parquet_table as parquet
from agents.recordings.recorder import KEY
from agents.recordings.recording import Recording
from cli import thrift_tree
from cli.calling import refusal
from cli.thrift_tree import at, put
from worlds.input_error import InputError


def told(table, **changes):
    """The table with other metadata."""
    meta = json.loads(table.schema.metadata[KEY]) | changes
    return table.replace_schema_metadata({KEY: json.dumps(meta)})


def with_column(table, name, values):
    """The table with a column of other values."""
    made = table.set_column(table.column_names.index(name), name, values)
    return made.replace_schema_metadata(table.schema.metadata)


def written(table, path, **more):
    pq.write_table(table, path, **more)
    return path


TICKS = np.repeat([0, 1, 2], 5)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"format": 99}, "format 99: it is newer than this version of flockscope reads"),
        ({"format": "2"}, "format '2': it is none"),
        ({"format": None}, "format None"),
        ({"next_id": float("inf")}, "next_id = inf is outside"),
        ({"next_id": -1}, "next_id = -1 is outside"),
        ({"next_id": True}, "next_id = True is outside"),
        ({"time_per_tick": -1.0}, "a tick stands for a time of -1"),
        ({"time_per_tick": 0.0}, "a tick stands for a time of 0"),
        ({"time_per_tick": float("nan")}, "a tick stands for a time of nan"),
        ({"time_per_tick": []}, "metadata"),
        ({"world": {}}, "has no size of its own"),
        ({"world": {"size": [1.0, 1.0, 1.0]}}, "3 dimensions, its run 2"),
        ({"world": {"size": [1.0, 1.0], "low": 3}}, "the world of"),
        ({"world": [1, 2]}, "metadata"),
        ({"title": ["a"]}, "['a'] stands where a text is needed"),
        ({"columns": 3}, "metadata"),
        ({"spec": {}}, "{} stands where a text is needed"),
    ],
)
def test_metadata_that_cannot_be_is_one_line(table, tmp_path, change, says):
    path = written(told(table, **change), tmp_path / "strange.parquet")
    line = refusal("recording", path)
    assert says in line
    assert "strange.parquet" in line


@pytest.mark.parametrize("value", [b"1e400", b"9" * 5000])
def test_a_number_of_any_length_in_the_metadata_is_one_line(table, tmp_path, value):
    meta = re.sub(rb'"next_id": \d+', b'"next_id": ' + value, table.schema.metadata[KEY])
    assert value in meta
    pq.write_table(table.replace_schema_metadata({KEY: meta}), tmp_path / "long.parquet")
    assert "long.parquet" in refusal("recording", tmp_path / "long.parquet")


@pytest.mark.parametrize("depth", [900, 200_000])
def test_metadata_that_is_deep_is_one_line(table, tmp_path, depth):
    deep = b"[" * depth + b"]" * depth
    meta = table.schema.metadata[KEY]
    edges = b'"edges": ["wrap", "wrap"]'
    assert edges in meta
    for text in (deep, meta.replace(edges, b'"edges": ' + deep)):
        path = written(table.replace_schema_metadata({KEY: text}), tmp_path / "deep.parquet")
        assert "deep.parquet" in refusal("recording", path)


@pytest.mark.parametrize(
    ("name", "values", "says"),
    [
        ("tick", pa.array([None, *TICKS[1:].tolist()]), "ticks are no whole numbers"),
        ("tick", pa.array(TICKS + 0.5), "'tick' holds no whole numbers"),
        ("tick", pa.array(TICKS - 5), "ticks outside [0, 2^53)"),
        ("tick", pa.array(TICKS[::-1]), "its ticks do not rise"),
        ("id", pa.array(np.zeros(15, np.int64)), "two agents of one identity at one tick (0)"),
        ("id", pa.array([0, 1, 2, 3, 4] * 2 + [3, 4, 0, 1, 4]), "of one identity at one tick (2)"),
        ("x", pa.array([[1.0]] * 15), "'x' holds what is no number"),
        ("x", pa.array(["1.0"] * 15), "'x' holds what is no number"),
        ("informed", pa.array([{"a": 1}] * 15), "'informed' holds what is no number"),
    ],
)
@pytest.mark.parametrize("command", ["recording", "load"])
def test_rows_that_cannot_be_are_one_line(table, tmp_path, name, values, says, command):
    path = written(with_column(table, name, values), tmp_path / "strange.parquet", row_group_size=7)
    if command == "recording":
        assert says in refusal("recording", path, "--csv", tmp_path / "out.csv")
        assert not (tmp_path / "out.csv").exists()
    else:
        with pytest.raises(InputError) as found:
            Flock.load(path)
        assert says in str(found.value)


def test_a_column_that_is_there_twice_is_named(table, tmp_path):
    twice = table.append_column("x", table["x"])
    path = written(twice.replace_schema_metadata(table.schema.metadata), tmp_path / "two.parquet")
    assert "has the column 'x' twice" in refusal("recording", path)


def test_rows_in_any_order_within_a_tick_are_a_recording(table, tmp_path):
    order = np.concatenate([[3, 0, 4, 1, 2], [5, 9, 8, 7, 6], [12, 10, 11, 14, 13]])
    path = written(table.take(order), tmp_path / "mixed.parquet", row_group_size=4)
    found = Recording(path)
    assert (found.ticks.tolist(), found.agents) == ([0, 1, 2], 5)
    assert found.at(1).ids.tolist() == table["id"].take(order[5:10]).to_pylist()
    kept = np.concatenate([order[:5], order[10:]])
    assert found.table(["id"], ticks=[2, 0])["id"].to_pylist() == table["id"].take(kept).to_pylist()


LIMITED = """
import resource, sys
from app.cli.main import app
resource.setrlimit(resource.RLIMIT_AS, ({most}, {most}))
sys.argv = ["flockscope", *sys.argv[1:]]
app()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="it limits its address space")
def test_millions_of_equal_rows_in_a_small_file_take_little_memory(table, tmp_path):
    path, rows = tmp_path / "large.parquet", 2**20
    group = table.slice(0, 1).take(pa.array(np.zeros(rows, np.int64)))
    with pq.ParquetWriter(path, table.schema, compression="zstd") as writer:
        for _ in range(40):
            writer.write_table(group)
    assert path.stat().st_size < 2_000_000
    done = subprocess.run(
        [sys.executable, "-c", LIMITED.format(most=3 * 2**30), "picture", str(path),
         "--out", str(tmp_path / "a.png")],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert "two agents of one identity at one tick (0)" in done.stderr
    assert not (tmp_path / "a.png").exists()


def test_a_row_group_of_too_many_numbers_is_refused_before_it_is_decoded(
    table, tmp_path, monkeypatch
):
    path = written(table, tmp_path / "run.parquet")
    monkeypatch.setattr(parquet, "MOST_NUMBERS", 40)
    with pytest.raises(InputError, match="120 numbers in a row group: at most 40 numbers are read"):
        Recording(path).at(0)
    monkeypatch.undo()
    monkeypatch.setattr(parquet, "MOST_BYTES", 40)
    with pytest.raises(InputError, match="its pages unpack to too much"):
        _ = Recording(path).ticks
    monkeypatch.undo()
    monkeypatch.setattr(snapshot_reader, "MOST", 2)
    with pytest.raises(InputError, match="looked up together"):
        _ = Recording(path).ticks


def test_a_text_that_stands_in_every_row_is_not_unpacked(tmp_path):
    words = pa.DictionaryArray.from_arrays(pa.array([0] * 1000), pa.array(["a" * 20_000]))
    path = written(pa.table({"words": words.dictionary_decode()}), tmp_path / "words.parquet")
    made = parquet.ParquetTable(path, None, "a table")
    with pytest.raises(InputError, match="a text of it is longer than 10000 bytes"):
        made.read()


CHANGED = """
import random, sys
import numpy as np
from agents.recordings.recording import Recording
from cli import thrift_tree
from worlds.input_error import InputError
sound, what, draw = open(sys.argv[1], "rb").read(), sys.argv[2], random.Random(1)
body, footer = thrift_tree.split(sound)

def bytes_of(content, first):
    content = bytearray(content)
    for _ in range(draw.randint(1, 4)):
        place = draw.randrange(first, len(content))
        content[place] = draw.choice([0, 127, 128, 255, draw.randrange(256)])
    return bytes(content)

def fields_of(tree):
    for _ in range(draw.choice([1, 1, 2, 4])):
        thrift_tree.change(tree, draw)

for _ in range(200):
    if what == "pages":
        content = thrift_tree.joined(bytes_of(body, 4), footer)
    elif what == "bytes of the footer":
        content = thrift_tree.joined(body, bytes_of(footer, 0))
    else:
        content = thrift_tree.forged(sound, fields_of)
    try:
        found = Recording("changed.parquet", content)
        found.described()
        for tick in found.ticks.tolist():
            assert np.isfinite(found.at(tick).position).all()
        found.table()
    except InputError as refusal:
        assert "\\n" not in str(refusal)
"""


@pytest.mark.parametrize(
    "form", [{"row_group_size": 2}, {"compression": "none", "use_dictionary": False},
             {"compression": "gzip", "data_page_version": "2.0"}],
)  # fmt: skip
@pytest.mark.parametrize("what", ["pages", "bytes of the footer", "fields of the footer"])
def test_what_is_changed_in_a_file_makes_a_flock_or_one_line(table, tmp_path, what, form):
    """In a process of its own, which must not end by a signal either."""
    path = written(table, tmp_path / "sound.parquet", **form)
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}\n{CHANGED}", path, what],
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


CHUNK = (4, 0, 1, 0)
"""Where the first column chunk of the first row group stands in a footer."""


@pytest.mark.parametrize(
    "changed",
    [
        lambda tree: thrift_tree.without(tree, *CHUNK, 3),  # ended the process
        lambda tree: at(tree, 4, 0, 1)[1].pop(),
        lambda tree: at(tree, 2)[1].pop(),
        lambda tree: put(tree, 3, value=2**40),
        lambda tree: put(tree, *CHUNK, 3, 9, value=2**40),
        lambda tree: put(tree, *CHUNK, 3, 7, value=-1),
        lambda tree: put(tree, *CHUNK, 3, 1, value=6),
        lambda tree: put(tree, *CHUNK, 3, 4, value=99),
        lambda tree: put(tree, *CHUNK, 3, 5, value=2**62),
        lambda tree: put(tree, 2, 0, 5, value=2**31 - 1),
        lambda tree: at(tree, *CHUNK).append([1, thrift_tree.BINARY, b"/etc/passwd"]),
        lambda tree: at(tree, *CHUNK).append([8, thrift_tree.STRUCT, []]),
        lambda tree: tree.append([8, thrift_tree.STRUCT, []]),
        lambda tree: put(tree, 4, value=[thrift_tree.STRUCT, [[]] * 1000]),
        lambda tree: tree.append(list(tree[0])),
    ],
)
def test_a_footer_that_cannot_be_is_one_line(table, tmp_path, changed):
    path = written(table, tmp_path / "forged.parquet")
    path.write_bytes(thrift_tree.forged(path.read_bytes(), changed))
    line = refusal("recording", path)
    assert line.endswith("forged.parquet' is damaged: its footer cannot be read")


def test_a_footer_of_more_structs_than_are_kept_is_refused(table, tmp_path, monkeypatch):
    path = written(table, tmp_path / "run.parquet", row_group_size=1)
    monkeypatch.setattr(parquet_footer, "MOST_STRUCTS", 200)
    with pytest.raises(InputError, match="its footer cannot be read"):
        Recording(path)
    monkeypatch.undo()
    monkeypatch.setattr(parquet_footer, "LONGEST_FOOTER", 300)
    with pytest.raises(InputError, match="its footer cannot be read"):
        Recording(path)
    monkeypatch.undo()
    assert Recording(path).rows == 15


@pytest.mark.parametrize(
    "form", [{}, {"row_group_size": 2}, {"compression": "none", "use_dictionary": False},
             {"compression": "gzip", "data_page_version": "2.0"}, {"write_page_index": True},
             {"write_statistics": False, "store_schema": False}, {"version": "1.0"}],
)  # fmt: skip
def test_a_footer_that_is_written_anew_says_the_same_of_a_file(tmp_path, form):
    numbers = pa.array([1.5, None, -2.0, 3.0, 4.0])
    made = pa.table(
        {
            "tick": [0, 0, 1, 1, 2], "x": numbers, "name": ["a", "b", None, "a", "c"],
            "informed": [True, False, True, None, False], "mode": pa.array([1, 2, 3, 4, 5], "int8"),
            "when": pa.array([1, 2, 3, 4, 5], pa.timestamp("us", "UTC")),
            "price": pa.array([1, 2, 3, 4, 5], pa.decimal128(10, 2)),
            "past": pa.array([[1.0, 2.0]] * 5, pa.list_(pa.float64(), 2)),
            "notes": [["a"], [], None, ["b", "c"], []], "deep": [{"a": 1, "b": {"c": [1]}}] * 5,
        },
        metadata={KEY: b"{}"},
    )  # fmt: skip
    path = written(made, tmp_path / "table.parquet", **form)
    assert parquet.ParquetTable(path, None, "a table").read().equals(pq.read_table(path))


def test_a_type_with_a_reader_of_its_own_is_read_as_its_numbers(tmp_path):
    kind = pa.fixed_shape_tensor(pa.float64(), [2])
    column = pa.ExtensionArray.from_storage(kind, pa.array([[1.0, 2.0]], kind.storage_type))
    path = written(pa.table({"past": column}), tmp_path / "table.parquet")
    assert b"ARROW:extension" in base64.b64decode(pq.read_metadata(path).metadata[b"ARROW:schema"])
    found = parquet.ParquetTable(path, None, "a table").read()
    assert found["past"].type == pa.list_(pa.float64())
    assert found["past"].to_pylist() == [[1.0, 2.0]]


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_metadata_whose_bytes_are_changed_make_a_flock_or_one_line(table, data):
    text = bytearray(table.schema.metadata[KEY])
    for _ in range(data.draw(st.integers(1, 4))):
        text[data.draw(st.integers(0, len(text) - 1))] = data.draw(st.integers(0, 255))
    out = io.BytesIO()
    pq.write_table(table.replace_schema_metadata({KEY: bytes(text)}), out)
    try:
        found = Recording("changed.parquet", out.getvalue())
        found.described()
        line = str(np.isfinite(found.at(1).position).all())
    except InputError as refusal:
        line = str(refusal)
    assert "\n" not in line


def test_a_title_reaches_no_terminal_as_it_is(table, tmp_path):
    title = "\x1b]0;owned\x07\x1b[2J\u202eflock\nroot#\x9b31m"
    path = written(told(table, title=title), tmp_path / "title.parquet")
    said = refusal("recording", path)
    assert "one line of plain text is needed" in said
    assert said.isprintable()


def parquet_table(columns, path):
    """A Parquet file of columns, opened with bounds."""
    pq.write_table(pa.table(columns), path)
    return parquet.ParquetTable(path, None, "a table")


@pytest.mark.parametrize("name", ["x", "x.y", ".", "x.y.z"])
def test_lists_are_bounded_whatever_their_column_is_called(tmp_path, monkeypatch, name):
    """A path joins names by points, which names may have themselves."""
    monkeypatch.setattr(parquet, "MOST_NUMBERS", 1000)
    lists = pa.array([[0.0] * 500] * 3)
    made = parquet_table({name: lists}, tmp_path / "lists.parquet")
    assert made.numbers(0, [name]) == 1500
    assert made.unpacked_size(0, [name]) > 0
    for read in (made.read, lambda: list(made.batches()), lambda: made.group(0)):
        with pytest.raises(
            InputError, match=r"1500 numbers.*: at most 1000 numbers are read at once"
        ):
            read()


def test_the_numbers_in_lists_of_all_row_groups_are_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "MOST_NUMBERS", 1000)
    path = tmp_path / "groups.parquet"
    pq.write_table(pa.table({"x": pa.array([[0.0] * 400] * 3)}), path, row_group_size=1)
    made = parquet.ParquetTable(path, None, "a table")
    assert sum(batch.num_rows for batch in made.batches()) == 3
    with pytest.raises(InputError, match="1200 numbers"):
        made.read()


def test_a_word_that_stands_in_every_row_is_bounded(tmp_path, monkeypatch):
    """Some kilobytes stand for a gigabyte: it is counted before it is written out."""
    word = {"word": pa.array(["w" * 9000] * 2000).dictionary_encode()}
    made = parquet_table(word, tmp_path / "words.parquet")
    assert made.unpacked_size(0, ["word"]) < 20_000
    assert made.read().num_rows == 2000
    monkeypatch.setattr(parquet, "MOST_TEXT", 10**6)
    with pytest.raises(InputError, match="its texts unpack to more than 1000000 bytes"):
        made.read()
    assert sum(batch.num_rows for batch in made.batches(rows=100)) == 2000
    monkeypatch.setattr(parquet, "MOST_BYTES", 10**6)
    with pytest.raises(InputError, match="its rows unpack to more than 1000000 bytes"):
        made.table(made.batches(rows=100))
