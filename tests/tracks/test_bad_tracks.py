"""Files that are damaged, foreign or hostile are refused in one line, and no code of theirs runs."""

from __future__ import annotations

import io
import json
import os
import pickle
import sqlite3
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.tracks.read_tracks import read
from app.tracks.readers import stored_arrays
from app.tracks.tracks import Tracks
from tests.tracks.written_formats import FORMATS, hostile_pickle, lines, write_npy
from worlds.input_error import InputError

IDS = [f"{form.name}-{form.file}" for form in FORMATS]
KNOWN = {"rate": 25.0, "unit": "m", "origin": "bottom-left"}


def refused(path, **options):
    """The line that refuses a file."""
    with pytest.raises(InputError) as error:
        read(path, **options)
    text = str(error.value)
    assert "\n" not in text
    assert len(text) < 1500
    return text


def table(tmp_path, *rows, header="frame,id,x,y"):
    lines(tmp_path / "t.csv", header, *rows)
    return tmp_path / "t.csv"


def test_what_is_no_file_is_refused(tmp_path):
    assert "No such file" in refused(tmp_path / "none.csv")
    (tmp_path / "empty.csv").touch()
    assert "is empty" in refused(tmp_path / "empty.csv")
    assert "no file of tracks" in refused(tmp_path)
    assert "is a folder" in refused([tmp_path, tmp_path / "empty.csv"])
    with pytest.raises(InputError, match="no file of tracks is given"):
        read([])
    os.mkfifo(tmp_path / "pipe") if hasattr(os, "mkfifo") else None
    (tmp_path / "noise.bin").write_bytes(bytes(range(256)) * 9)
    assert "no format of tracks that is known" in refused(tmp_path / "noise.bin")
    lines(tmp_path / "prose.txt", "Dear reader,", "this is a letter.")
    assert "begins with 'Dear reader,'" in refused(tmp_path / "prose.txt")


def test_an_individual_twice_in_a_frame_is_refused(tmp_path):
    path = table(tmp_path, "0,a,1,1", "1,a,1,2", "1,a,1,3")
    assert "'a' is twice in frame 1" in refused(path, **KNOWN)


def test_what_is_no_number_is_told_with_its_line(tmp_path):
    path = table(tmp_path, "0,a,1,1", "1,a,one,2")
    assert "line 3, column x: 'one' is not a number" in refused(path, **KNOWN)
    path = table(tmp_path, "0,a,1,1", "0.5,a,1,2")
    assert "column frame: 0.5 is not a whole number" in refused(path, **KNOWN)
    path = table(tmp_path, "0,a,1,1", "1,a,1,2,3,4,5")
    assert "t.csv is no table" in refused(path, **KNOWN)


def test_no_number_and_infinity_are_gaps_and_counted(tmp_path):
    path = table(tmp_path, "0,a,1,1", "1,a,nan,2", "2,a,inf,2", "3,a,,2", "4,a,3,3")
    tracks = read(path, **KNOWN)
    assert tracks.seen[:, 0].tolist() == [True, False, False, False, True]
    assert [str(one) for one in tracks.dropped] == ["1 rows dropped: the place is infinite"]
    path = table(tmp_path, "0,a,nan,nan")
    assert "no individual that is seen" in refused(path, **KNOWN)


def test_one_animal_and_one_frame_are_tracks(tmp_path):
    tracks = read(table(tmp_path, "0,a,1,2"), **KNOWN)
    assert tracks.position.tolist() == [[[1.0, 2.0]]]
    lines(tmp_path / "alone.csv", "frame,x,y", "5,1,2", "3,1,1", "4,2,2")
    tracks = read(tmp_path / "alone.csv", **KNOWN)
    assert (tracks.frame.tolist(), tracks.ids) == ([3, 4, 5], ("alone",))


def test_several_individuals_without_a_name_are_asked_about(tmp_path):
    lines(tmp_path / "two.csv", "frame,x,y", "1,1,2", "1,3,3")
    assert "has no column for id" in refused(tmp_path / "two.csv", **KNOWN)


def test_wrong_options_are_told(tmp_path):
    path = table(tmp_path, "0,a,1,1", "1,a,1,2")
    for options, says in (
        ({"unit": "parsec"}, "unknown unit 'parsec'"),
        ({"origin": "middle"}, "unknown origin 'middle'"),
        ({"rate": 0.0}, "--rate 0 is not allowed"),
        ({"rate": float("nan")}, "--rate nan is not allowed"),
        ({"scale": 0.01}, "--scale is metres in a pixel, but t.csv is in m"),
        ({"format": "trecks"}, "unknown format 'trecks': did you mean 'trex'?"),
        ({"format": "sleap"}, "t.csv is damaged: it cannot be read as HDF5"),
        ({"columns": {"x": "px"}}, "unknown column 'px'"),
        ({"columns": {"colour": "x"}}, "unknown content of a column 'colour'"),
        ({"every": 0}, "--every 0 is not allowed"),
        ({"fill": -1}, "--fill -1 is not allowed"),
        ({"frames": (4, 4)}, "--frames 4:4 is not allowed"),
        ({"frames": (90, 99)}, "has none of the frames that are asked for"),
        ({"least_confidence": 0.5}, "does not say how sure it is"),
    ):
        assert says in refused(path, **{**KNOWN, **options})


def test_several_formats_in_a_folder_are_not_mixed(tmp_path):
    lines(tmp_path / "a.csv", "ID,Frame,x,y", "1,1,1,1")
    lines(tmp_path / "b.csv", "time,pedID,posX,posY", "1,1,1,1")
    assert "are of several formats (pedpy, crowdit)" in refused(tmp_path, **KNOWN)
    (tmp_path / "b.csv").rename(tmp_path / "b.bin")
    lines(tmp_path / "b.bin", "ID,Frame,x,y", "1,1,1,1")
    assert "2 files of PedPy, table are not one set" in refused(tmp_path, **KNOWN)


# Pickles.


class Bomb:
    """What runs code where a pickle is read carelessly."""

    def __reduce__(self):
        return os.mkdir, ("/tmp/flockscope-a-pickle-ran",)


@pytest.mark.parametrize(
    "value",
    [
        Bomb(),
        {"trajectories": Bomb()},
        {"trajectories": np.zeros((2, 2, 2)), "frames_per_second": print},
        {"trajectories": {1, 2}},
        {"trajectories": 10 ** 200},
    ],
    ids=["code", "code within", "function", "set", "long number"],
)  # fmt: skip
def test_a_pickle_that_is_more_than_values_is_refused(tmp_path, value):
    (tmp_path / "bomb.npy").write_bytes(hostile_pickle(value))
    assert "bomb.npy" in refused(tmp_path / "bomb.npy")
    assert not os.path.exists("/tmp/flockscope-a-pickle-ran")


@pytest.mark.parametrize(
    "body",
    [
        b"\x80\x02r\xff\xff\xff\x7f.",  # room for two billion memories
        b"\x80\x04\x96\xff\xff\xff\xff\xff\xff\xff\x0f.",  # and for many bytes
        b"\x80\x02cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(J\xff\xff\xff\x7ftU\x01dtR.",
        b"\x80\x02cbuiltins\neval\n(U\x041+1tR.",
        b"\x80\x02cnumpy.core.multiarray\n_reconstruct\n}b.",
        b"cos\nsystem\n(S'true'\ntR.",
        b"(" * 100_000 + b".",
        b"",
    ],
)
def test_a_pickle_made_by_hand_does_no_harm(tmp_path, body):
    whole = hostile_pickle(None)
    start = len(whole) - len(pickle.dumps(None, protocol=2))
    (tmp_path / "hand.npy").write_bytes(whole[:start] + body)
    assert "hand.npy" in refused(tmp_path / "hand.npy", **KNOWN)


def test_a_pickle_that_holds_itself_many_times_is_bounded():
    inner: list = [0.0] * 10
    for _ in range(8):
        inner = [inner] * 10
    values = stored_arrays.plain_values(pickle.dumps({"trajectories": inner}), "laughs.npy")
    assert set(values) == {"trajectories"}


def test_old_and_new_numpy_pickles_are_read():
    held = {"trajectories": np.arange(12.0).reshape(2, 3, 2), "n": np.float64(2.5), "name": "x"}
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        values = stored_arrays.plain_values(pickle.dumps(held, protocol=protocol), "p")
        assert np.array_equal(values["trajectories"], held["trajectories"]), protocol
        assert (values["n"], values["name"]) == (2.5, "x")


# Declared sizes.


def test_a_header_that_declares_more_than_there_is(tmp_path):
    header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000, 100000, 2), }"
    text = header.ljust(117) + "\n"
    content = b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode() + b"\0" * 64
    (tmp_path / "big.npy").write_bytes(content)
    assert "declares 1600000000000 bytes" in refused(tmp_path / "big.npy", **KNOWN)
    with zipfile.ZipFile(tmp_path / "big.npz", "w") as packed:
        for name in ("frame", "X#wcentroid", "Y#wcentroid"):
            packed.writestr(f"{name}.npy", content)
    assert "declares 1600000000000 bytes" in refused(tmp_path / "big.npz", **KNOWN)


def test_a_zip_bomb_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(stored_arrays, "MOST_BYTES", 1 << 16)
    arrays = {name: np.zeros(100_000) for name in ("frame", "X#wcentroid", "Y#wcentroid")}
    np.savez_compressed(tmp_path / "bomb_fish0.npz", **arrays)
    assert "unpacks to 800128 bytes" in refused(tmp_path / "bomb_fish0.npz")


def test_an_hdf5_bomb_is_refused(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "bomb.h5", "w") as file:  # a terabyte in a few bytes
        file.create_dataset(
            "trajectories", shape=(10**6, 10**5, 2), chunks=(1000, 100, 2), compression="gzip"
        )
        file.attrs["frames_per_second"] = 25
    assert "is too large" in refused(tmp_path / "bomb.h5")


def test_what_lies_in_other_files_is_not_opened(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["places"] = np.ones((3, 2, 2))
    with h5py.File(tmp_path / "linked.h5", "w") as file:
        file["trajectories"] = h5py.ExternalLink("secret.h5", "places")
        file.attrs["frames_per_second"] = 25
    assert "has no trajectories" in refused(tmp_path / "linked.h5")
    with h5py.File(tmp_path / "outside.h5", "w") as file:
        (tmp_path / "raw.bin").write_bytes(np.ones((3, 2, 2)).tobytes())
        file.create_dataset(
            "trajectories", (3, 2, 2), "f8", external=[(str(tmp_path / "raw.bin"), 0, 96)]
        )
        file.attrs["frames_per_second"] = 25
    assert "lies in other files" in refused(tmp_path / "outside.h5")


def test_a_view_that_never_ends_is_no_table(tmp_path):
    database = sqlite3.connect(tmp_path / "view.sqlite")
    database.execute(
        "CREATE VIEW trajectory_data AS WITH RECURSIVE c(n) AS (SELECT 1 UNION ALL SELECT n + 1 "
        "FROM c) SELECT n AS frame, 1 AS id, 0.0 AS pos_x, 0.0 AS pos_y, 0.0 AS ori_x, 0.0 AS "
        "ori_y FROM c"
    )
    database.execute("CREATE TABLE metadata (key TEXT, value TEXT)")
    database.commit()
    database.close()
    assert "a database of something else" in refused(tmp_path / "view.sqlite")


def test_other_versions_of_a_database_are_refused(tmp_path):
    form = next(one for one in FORMATS if one.name == "jupedsim")
    path = form.written(tmp_path)
    with sqlite3.connect(path) as database:
        database.execute("UPDATE metadata SET value = '3' WHERE key = 'version'")
    database.close()
    before = path.read_bytes()
    assert "has version '3' of JuPedSim's format" in refused(path)
    assert path.read_bytes() == before
    assert not [one for one in tmp_path.iterdir() if one != path]  # no journal beside it


def test_a_table_of_many_rows_is_refused_before_room_is_made(tmp_path, monkeypatch):
    from app.tracks import tracks as table_of_tracks
    from app.tracks.readers import text_columns

    rows = [f"{k},{k},1,1" for k in range(2000)]
    path = table(tmp_path, *rows)
    monkeypatch.setattr(table_of_tracks, "MOST_PLACES", 10_000)
    assert "too many" in refused(path, **KNOWN)
    monkeypatch.setattr(text_columns, "MOST_ROWS", 1000)
    assert "has too many rows" in refused(path, **KNOWN)
    monkeypatch.setattr(text_columns, "MOST_COLUMNS", 3)
    assert "has 4 columns" in refused(path, **KNOWN)


def test_splines_are_refused_with_a_word(tmp_path):
    lines(tmp_path / "annotation.vsp", "148 - the number of splines",
          "9 - Num of control points", "279.0 -123.0 0 87.4 - (2D point, m_id)")  # fmt: skip
    assert "read the obsmat.txt" in refused(tmp_path / "annotation.vsp")


def test_dates_that_may_be_two_are_asked_about(tmp_path):
    rows = [f"0{k}/05/2015,06:00:00,10.0,47.0" for k in (1, 2)]
    lines(tmp_path / "goat.csv", "date,time,lon,lat", *rows)
    assert "may be two dates" in refused(tmp_path / "goat.csv")
    rows = [f"{k}/05/2015,06:00:00,10.0,47.0" for k in (1, 20)]
    lines(tmp_path / "goat.csv", "date,time,lon,lat", *rows)
    assert read(tmp_path / "goat.csv").time[-1] == 19 * 86400.0


def test_what_loggers_write_wrong_is_counted(tmp_path):
    form = next(one for one in FORMATS if one.name == "gps")
    tracks = read(form.written(tmp_path))
    assert sorted(str(one) for one in tracks.dropped) == [
        "1 rows dropped: another fix of the animal has the same time",
        "1 rows dropped: the place is blank or no number",
        "1 rows dropped: the time is none",
    ]


def test_a_bare_header_of_json_is_refused(tmp_path):
    deep = "[" * 100_000
    (tmp_path / "p.json").write_text('{"0": {"0.0": {"isActive": true, "position": ' + deep)
    assert "p.json" in refused(tmp_path / "p.json")
    (tmp_path / "q.json").write_text(json.dumps({"0": {"0.0": {"isActive": True}}}))
    assert "a person needs a position" in refused(tmp_path / "q.json")


# Whatever is cut or changed in a file: tracks, or one line.


@pytest.fixture(scope="module", params=FORMATS, ids=IDS)
def sound(request, tmp_path_factory):
    """A format, its options, the folder of its file, and the bytes of the file or one of them."""
    folder = tmp_path_factory.mktemp("sound")
    path = request.param.written(folder)
    file = sorted(path.iterdir())[0] if path.is_dir() else path
    return request.param, path, file, file.read_bytes()


def attempt(path, options):
    """Read it, to tracks or one line."""
    try:
        tracks = read(path, **options)
    except InputError as error:
        assert "\n" not in str(error)
        assert len(str(error)) < 1500
    else:
        assert isinstance(tracks, Tracks)
        assert not np.isinf(tracks.position).any()


@settings(
    max_examples=25, deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip
@given(data=st.data())
def test_a_file_that_is_cut_or_changed_is_tracks_or_one_line(sound, data):
    form, path, file, content = sound
    cut = data.draw(st.integers(0, len(content)), "cut at")
    flips = data.draw(
        st.lists(st.tuples(st.integers(0, len(content) - 1), st.integers(0, 255)), max_size=6),
        "bytes",
    )
    changed = bytearray(content)
    for at, byte in flips:
        changed[at] = byte
    changed = changed[:cut] if data.draw(st.booleans(), "is cut") else changed
    try:
        file.write_bytes(changed)
        attempt(path, form.options)
        attempt(path, {**form.options, "format": form.name, "columns": None})
    finally:
        file.write_bytes(content)


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=400))
def test_any_pickle_is_values_or_one_line(content):
    try:
        stored_arrays.plain_values(content, "any.npy")
    except InputError as error:
        assert "\n" not in str(error)


def test_a_sound_dictionary_is_read_by_the_same_way(tmp_path):
    write_npy(tmp_path / "fish.npy")
    content = io.BytesIO((tmp_path / "fish.npy").read_bytes())
    values = stored_arrays.npy_of(content, len(content.getvalue()), "fish.npy")
    assert {"trajectories", "frames_per_second", "body_length"} <= set(values)
