"""The `.part` of a killed run, made by a stranger: a recording of its whole batches or one line."""

from __future__ import annotations

import json
import struct
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from agents.recordings import part_stream
from agents.recordings.recorder import KEY
from app.live.recording.recording_writer import LONGEST, TABLES, RecordingStream
from app.live.recording.recovery import recover as recover_tables
from cli.calling import call, refusal
from worlds.input_error import InputError


def left(folder, table, **more):
    """A `.part` of a table, a batch for each tick."""
    part = folder / "run.parquet.part"
    with part.open("wb") as file, pa.ipc.new_stream(file, table.schema, **more) as stream:
        for batch in table.to_batches(max_chunksize=5):
            stream.write_batch(batch)
    return part


def batches_in(content):
    """Where the messages of a stream begin, each with the bytes of its header."""
    at = 0
    while length := struct.unpack_from("<I", content, at + 4)[0]:
        message = pa.ipc.read_message(pa.BufferReader(content[at:]))
        yield at, length
        body = message.body.size if message.body is not None else 0
        at += 8 + length + body


def test_what_a_stream_holds_is_a_recording(table, tmp_path):
    part = left(tmp_path, table)
    assert json.loads(call("recover", part, "--json").stdout)["rows"] == 15
    assert pq.read_table(tmp_path / "run.parquet").equals(table, check_metadata=True)


@pytest.mark.parametrize("cut", [1, 8, 9, 100, 300])
def test_a_stream_that_is_cut_off_is_read_up_to_its_last_whole_batch(table, tmp_path, cut):
    part = left(tmp_path, table)
    content = part.read_bytes()
    part.write_bytes(content[: len(content) - 8 - cut])
    assert json.loads(call("recover", part, "--json").stdout)["rows"] == 10
    made = pq.read_table(tmp_path / "run.parquet")
    assert made.equals(table.slice(0, 10))


@pytest.mark.parametrize("length", [2**31 - 1, 2**26, 0, 2**32 - 1])
def test_a_forged_length_of_a_header_ends_the_stream(table, tmp_path, length):
    part = left(tmp_path, table)
    content = bytearray(part.read_bytes())
    at, _ = list(batches_in(content))[2]
    struct.pack_into("<I", content, at + 4, length)
    part.write_bytes(content)
    assert json.loads(call("recover", part, "--json").stdout)["rows"] == 5


def forged(content, old, new):
    """The stream with another number in the header of its third message, wherever it stands."""
    content = bytearray(content)
    at, length = list(batches_in(content))[2]
    header = content[at + 8 : at + 8 + length]
    was, will = struct.pack("<q", old), struct.pack("<q", new)
    assert was in header
    content[at + 8 : at + 8 + length] = header.replace(was, will)
    return bytes(content)


@pytest.mark.parametrize("length", [2**62, 2**40, -8, -(2**63)])
def test_a_forged_length_of_a_batch_ends_the_stream(table, tmp_path, length):
    part = left(tmp_path, table)
    content = part.read_bytes()
    at, _ = list(batches_in(content))[2]
    body = pa.ipc.read_message(pa.BufferReader(content[at:])).body.size
    part.write_bytes(forged(content, body, length))
    assert json.loads(call("recover", part, "--json").stdout)["rows"] == 5


def test_a_batch_of_too_many_rows_is_refused(table, tmp_path):
    part = left(tmp_path, table)
    part.write_bytes(forged(part.read_bytes(), 5, 2**60))
    line = refusal("recover", part)
    assert f"holds a batch of {2**60} rows: at most {2**27 // 8} are read at once" in line
    assert list(tmp_path.iterdir()) == [part]


@pytest.mark.parametrize("rows", [4, 6, 100_000])
def test_rows_that_its_columns_do_not_have_end_the_stream(table, tmp_path, rows):
    part = left(tmp_path, table)
    content = bytearray(part.read_bytes())
    at, length = list(batches_in(content))[2]
    message = part_stream.Message(bytes(content[at + 8 : at + 8 + length]))
    batch = message.place(message.unpack("<I", 0), 2)
    place = message.place(batch + message.unpack("<I", batch), 0)
    struct.pack_into("<q", content, at + 8 + place, rows)
    part.write_bytes(content)
    assert json.loads(call("recover", part, "--json").stdout)["rows"] == 5


@pytest.mark.parametrize("limit", ["MOST_BYTES", "MOST_HEADER", "MOST_METADATA"])
def test_what_is_read_at_once_is_bounded(table, tmp_path, limit, monkeypatch):
    part = left(tmp_path, table)
    monkeypatch.setattr(part_stream, limit, 100)
    assert "100" in refusal("recover", part)


def test_few_rows_of_long_texts_do_not_wait_for_more_rows(table, tmp_path, monkeypatch):
    part = left(tmp_path, table)
    monkeypatch.setattr(part_stream, "MOST_WAITING", 10)
    with part.open("rb") as file:
        batches = [*part_stream.PartStream(part, file).batches(1000)]
    assert [batch.num_rows for batch in batches] == [5, 5, 5]
    assert pa.Table.from_batches(batches).equals(table)


def test_packed_batches_are_refused_before_they_are_unpacked(table, tmp_path):
    options = pa.ipc.IpcWriteOptions(compression="zstd")
    zeros = pa.table({"tick": np.zeros(1000, np.int64)}, metadata=table.schema.metadata)
    part = left(tmp_path, zeros, options=options)
    assert "has packed batches, and flockscope writes none" in refusal("recover", part)


@pytest.mark.parametrize(
    "column",
    [
        pa.nulls(15),
        pa.array(["a"] * 15).dictionary_encode(),
        pa.array([{"a": 1}] * 15),
        pa.array([[1.0]] * 15),
        pa.array([[[1.0]]] * 15, pa.list_(pa.list_(pa.float64(), 1), 1)),
        pa.array([1] * 15, pa.timestamp("us")),
        pa.array([1] * 15, pa.decimal128(9)),
    ],
    ids=lambda column: str(column.type),
)
def test_columns_of_kinds_that_no_recording_has_are_refused(table, tmp_path, column):
    strange = table.append_column("more", column).replace_schema_metadata(table.schema.metadata)
    line = refusal("recover", left(tmp_path, strange))
    assert "its column 'more' holds neither numbers nor text" in line


def test_a_type_with_a_reader_of_its_own_is_refused(table, tmp_path):
    """Arrow would hand what stands there, however deep, to that reader."""
    deep = "[" * 200_000
    told = {
        "ARROW:extension:name": "arrow.fixed_shape_tensor",
        "ARROW:extension:metadata": f'{{"shape":{deep}',
    }
    field = pa.field("more", pa.list_(pa.float64(), 2), metadata=told)
    strange = pa.table(
        [*table.columns, pa.array([[1.0, 2.0]] * 15, field.type)],
        schema=table.schema.append(field),
    )
    assert "is not a recording that flockscope has begun" in refusal(
        "recover", left(tmp_path, strange)
    )


def test_texts_of_megabytes_are_refused(table, tmp_path):
    texts = pa.array(["a" * 3_000_000, *["b"] * 14])
    strange = table.append_column("more", texts).replace_schema_metadata(table.schema.metadata)
    line = refusal("recover", left(tmp_path, strange))
    assert "a text of it is longer than 10000 bytes" in line


def test_metadata_that_is_deep_is_recovered_and_then_one_line(table, tmp_path):
    deep = b"[" * 200_000 + b"]" * 200_000
    part = left(tmp_path, table.replace_schema_metadata({KEY: deep}))
    assert call("recover", part).exit_code == 0
    assert "is nested too deeply" in refusal("recording", tmp_path / "run.parquet")


@pytest.mark.parametrize("content", [b"", b"PAR1", b"\xff" * 100, b"\xff\xff\xff\xff" + b"\0" * 90])
def test_what_is_no_stream_is_refused(tmp_path, content):
    part = tmp_path / "run.parquet.part"
    part.write_bytes(content)
    assert refusal("recover", part).endswith("is not a recording that flockscope has begun")
    assert list(tmp_path.iterdir()) == [part]


META = {"format": 4, "laboratory": "", "began": 1.0, "began_on_the_clock": 0.0}


def live_tables(folder, **columns):
    """The `.part` files of a live recording of one tick, some columns of `events` changed."""
    folder.mkdir()
    of_kind = {"int64": 3, "int8": 0, "float64": 1.5, "string": "red", "bool": True}
    for name, kinds in TABLES.items():
        values = [of_kind[kind] for kind in kinds.values()]
        if name == "events":
            values = [columns.get(column, of_kind[kind]) for column, kind in kinds.items()]
        stream = RecordingStream(folder / f"{name}.parquet", kinds, META)
        stream.write([tuple(values)])
        stream.close()
    return folder


def test_tables_of_a_live_recording_have_the_same_bounds(tmp_path):
    assert recover_tables(live_tables(tmp_path / "sound", words="a" * LONGEST))["events"] == 1
    folder = live_tables(tmp_path / "long", words="a" * (LONGEST + 1))
    with pytest.raises(InputError, match=f"a text of it is longer than {LONGEST} bytes"):
        recover_tables(folder)
    assert (folder / "events.parquet.part").exists()


@pytest.mark.parametrize("column", ["now", "tick"])
def test_a_live_table_whose_columns_are_of_other_kinds_is_one_line(tmp_path, column):
    folder = live_tables(tmp_path / "run")
    kinds = TABLES["ticks"] | {column: "string"}
    values = {"int64": 3, "int8": 0, "float64": 1.5, "string": "red"}
    stream = RecordingStream(folder / "ticks.parquet", kinds, META)
    stream.write([tuple(values[kind] for kind in kinds.values())])
    stream.close()
    line = refusal("recover", folder)
    assert f"its column {column!r} is string, {TABLES['ticks'][column]} is needed" in line


def ticks_of(folder, meta=META, **columns):
    """Another stream of ticks for a live recording, of one row."""
    of_kind = {"int64": 3, "int8": 0, "float64": 1.5, "string": "red"}
    row = {name: of_kind[kind] for name, kind in TABLES["ticks"].items()} | columns
    stream = RecordingStream(folder / "ticks.parquet", TABLES["ticks"], meta)
    stream.write([tuple(row.values())])
    stream.close()
    return folder


@pytest.mark.parametrize("column", ["tick", "now", "mode"])
def test_a_live_table_with_rows_without_a_value_is_one_line(tmp_path, column):
    folder = ticks_of(live_tables(tmp_path / "run"), **{column: None})
    assert f"its column {column!r} has rows without a value" in refusal("recover", folder)


@pytest.mark.parametrize("key", META)
def test_a_live_table_whose_metadata_are_of_other_kinds_is_one_line(tmp_path, key):
    folder = ticks_of(live_tables(tmp_path / "run"), META | {key: ["a"]})
    assert f"is damaged: {key} is ['a']" in refusal("recover", folder)


CHANGED = """
import random, sys, pathlib
from agents.recordings.recorder import recover
from worlds.input_error import InputError
part, draw = pathlib.Path(sys.argv[1]), random.Random(1)
sound = part.read_bytes()
for _ in range(400):
    content = bytearray(sound)
    for _ in range(draw.randint(1, 4)):
        place = draw.randrange(len(content))
        content[place] = draw.choice([0, 1, 127, 128, 255, draw.randrange(256)])
    part.write_bytes(content)
    try:
        path, rows = recover(part)
        path.unlink()
    except InputError as refusal:
        assert "\\n" not in str(refusal)
"""


def test_a_stream_whose_bytes_are_changed_is_recovered_or_one_line(table, tmp_path):
    """In a process of its own, which must not end by a signal either."""
    words = pa.array(["red", None, "green"] * 5)
    past = pa.array([[1.0, 2.0]] * 15, pa.list_(pa.float64(), 2))
    whole = table.append_column("words", words).append_column("past", past)
    part = left(tmp_path, whole.replace_schema_metadata({KEY: b"{}"}))
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}\n{CHANGED}", part],
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
