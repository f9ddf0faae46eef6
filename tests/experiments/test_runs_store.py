"""The store of runs: what is committed stays, other files are left alone, others may read."""

import json
import os
import sqlite3
import subprocess
import sys
import textwrap
import time
from contextlib import closing, suppress

import numpy as np
import pytest

from app.studies.runs.database import FILE, Outcome, open_for_reading
from app.studies.runs.store import Store, is_locked
from app.studies.runs.store_reader import StoreReader, readable
from app.studies.sweeps.sweep_table import long_table, wide_table
from worlds.input_error import InputError

CELLS = [("aaa", '{"axes":{"p":1}}'), ("bbb", '{"axes":{"p":2}}')]


def statuses(store):
    return {key: one.status for key, one in store.outcomes([]).items()}


def test_what_is_added_is_read_back_in_the_order_of_the_plan(tmp_path):
    series = {"s": (np.array([10, 20]), np.array([0.5, np.nan]))}
    with Store(tmp_path / "deep", ["k", "x"]) as store:
        second, first = store.store_plan(CELLS[::-1])
        store.add(first, 2, Outcome("ok", {"k": 7, "x": 1.0}, ticks=9))
        store.add(second, 1, Outcome("failed", reason="ValueError: no"))
        store.add(first, 1, Outcome("gave-up", {"k": None, "x": np.float64(0.1)}, series=series))
        store.store_plan(CELLS)
    kept = StoreReader(tmp_path / "deep")
    rows = [
        (cell, seed, status, ticks, k, x)
        for cell, seed, status, _, _, ticks, _, k, x in kept.runs()
    ]
    assert rows == [
        (first, 1, "gave-up", 0, None, 0.1),
        (first, 2, "ok", 9, 7, 1.0),
        (second, 1, "failed", 0, None, None),
    ]
    assert isinstance(rows[1][-1], float), "1.0 does not come back as 1"
    assert kept.counts == {"ok": 1, "gave-up": 1, "failed": 1, "killed": 0}
    [(cell, seed, name, ticks, values)] = kept.series()
    assert (cell, seed, name, ticks.tolist()) == (first, 1, "s", [10, 20])
    assert values[0] == 0.5
    assert np.isnan(values[1])


def test_cells_that_are_no_longer_planned_stay(tmp_path):
    with Store(tmp_path, ["k"]) as store:
        [first, second] = store.store_plan(CELLS)
        store.add(first, 1, Outcome("ok", {"k": 1}))
        store.add(second, 1, Outcome("ok", {"k": 2}))
    with Store(tmp_path, ["k", "new"]) as store:
        assert store.store_plan(CELLS[1:]) == [second]
        assert statuses(store) == {(first, 1): "ok", (second, 1): "ok"}
    kept = StoreReader(tmp_path)
    assert (kept.others, kept.counts["ok"], kept.columns) == (1, 1, ["k", "new"])


def test_failed_runs_are_forgotten_on_request(tmp_path):
    with Store(tmp_path, []) as store:
        [cell, _] = store.store_plan(CELLS)
        for seed, status in enumerate(("ok", "gave-up", "failed", "killed")):
            store.add(cell, seed, Outcome(status))
        store.commit()
        assert store.forget_broken() == 2
        assert statuses(store) == {(cell, 0): "ok", (cell, 1): "gave-up"}


@pytest.mark.parametrize("content", [b"a,b,c\n1,2,3\n", b"SQLite format 3\0 torn"])
def test_another_file_is_refused_and_left_alone(tmp_path, content):
    (tmp_path / FILE).write_bytes(content)
    with (
        pytest.raises(InputError, match="is not a store of runs: move it away"),
        Store(tmp_path, []),
    ):
        pass
    assert (tmp_path / FILE).read_bytes() == content
    assert not readable(tmp_path)


def test_a_database_of_anything_else_is_refused_and_left_alone(tmp_path):
    other = sqlite3.connect(tmp_path / FILE)
    other.execute("CREATE TABLE run (mine)")
    other.close()
    before = (tmp_path / FILE).read_bytes()
    with pytest.raises(InputError, match="is not a store of runs"), Store(tmp_path, []):
        pass
    assert (tmp_path / FILE).read_bytes() == before


def test_a_store_of_a_newer_format_is_refused(tmp_path):
    with Store(tmp_path, []) as store:
        store.connection.execute("PRAGMA user_version = 99")
    with (
        pytest.raises(InputError, match=r"newer .* \(format 99, here 1\)"),
        Store(tmp_path, []),
    ):
        pass


def test_two_parents_cannot_have_one_store(tmp_path):
    with Store(tmp_path, []):
        assert is_locked(tmp_path)
        with (
            pytest.raises(InputError, match="by another process"),
            Store(tmp_path, []),
        ):
            pass
    assert not is_locked(tmp_path)


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot be made"), Store(tmp_path / "file" / "deep", []):
        pass


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_only_be_read_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="cannot be written"), Store(tmp_path, []):
        pass


def test_a_full_disk_is_told_in_a_line_and_loses_nothing_that_was_kept(tmp_path):
    with Store(tmp_path, []) as store:
        [cell, _] = store.store_plan(CELLS)
        store.add(cell, 1, Outcome("ok"))
        store.commit()
        pages = store.connection.execute("PRAGMA page_count").fetchone()[0]
        store.connection.execute(f"PRAGMA max_page_count = {pages}")
        for seed in range(2, 2000):
            store.add(cell, seed, Outcome("ok"))
        with pytest.raises(InputError, match="cannot be kept: the disk is full"):
            store.commit()
    assert StoreReader(tmp_path).counts["ok"] == 1
    with Store(tmp_path, []) as store:
        assert list(statuses(store)) == [(cell, 1)]


def test_another_process_reads_while_one_writes(tmp_path):
    with Store(tmp_path, ["k"]) as store:
        [cell, _] = store.store_plan(CELLS)
        store.add(cell, 1, Outcome("ok", {"k": 1}))
        store.tell(progress={"rate": 2.0})
        store.commit()
        store.add(cell, 2, Outcome("ok", {"k": 2}))
        ask = f"""
            from pathlib import Path
            from app.studies.runs.store_reader import StoreReader
            kept = StoreReader(Path({str(tmp_path)!r}))
            print(kept.counts["ok"], kept.state["progress"]["rate"])
        """
        said = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(ask)], capture_output=True, text=True, check=True
        )
        assert said.stdout == "1 2.0\n"


def test_a_hundred_thousand_runs_load_in_five_times_what_their_bare_rows_take(tmp_path):
    cells = [(str(number), "{}") for number in range(100)]
    with Store(tmp_path, ["k", "x"]) as store:
        numbers = store.store_plan(cells)
        for seed in range(1000):
            for cell in numbers:
                store.add(cell, seed, Outcome("ok", {"k": seed, "x": 0.1 * seed}, "", 0.01, 100))
    began = time.process_time()
    with Store(tmp_path, ["k", "x"]) as store:
        assert len(store.outcomes(["k", "x"])) == 100_000
    assert len(StoreReader(tmp_path).runs()) == 100_000
    worked, began = time.process_time() - began, time.process_time()
    with closing(sqlite3.connect(tmp_path / FILE)) as bare:
        for _ in range(2):
            assert len(bare.execute("SELECT * FROM run").fetchall()) == 100_000
    assert worked < 5.0 * (time.process_time() - began)
    assert (tmp_path / FILE).stat().st_size < 60 * 100_000


def test_a_reader_of_what_is_not_there_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no store of runs"):
        open_for_reading(tmp_path / FILE)


ENDLESS = "WITH RECURSIVE r(n) AS (VALUES (1) UNION ALL SELECT n + 1 FROM r)"


@pytest.mark.parametrize(
    "change",
    [
        "DROP TABLE run; CREATE VIEW run AS " + ENDLESS + " SELECT n AS cell, n AS seed, 'ok' AS "
        "status, '' AS reason, n AS seconds, n AS ticks, '' AS astray FROM r;",
        "CREATE TRIGGER t AFTER INSERT ON run BEGIN DELETE FROM cell; END;",
        "DROP TABLE state; CREATE TABLE state (key TEXT);",
        "DROP TABLE plan;",
        "CREATE VIRTUAL TABLE more USING fts5(a);",
    ],
    ids=["endless view", "trigger", "columns", "no plan", "virtual"],
)
def test_a_store_of_anything_but_plain_tables_is_refused(tmp_path, change):
    with Store(tmp_path, ["k"]):
        pass
    with closing(sqlite3.connect(tmp_path / FILE)) as connection:
        connection.executescript(change)
    for look in (lambda: StoreReader(tmp_path).counts, lambda: Store(tmp_path, ["k"]).__enter__()):
        with pytest.raises(InputError, match="is not a store of runs"):
            look()


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, "9" * 10_000, "{", b"\xff", "NaN", "1e999", '"\\ud800"', "[" * 41 + "]" * 41],
)
def test_json_in_a_store_that_others_cannot_read_is_refused_in_a_line(tmp_path, text):
    with Store(tmp_path, ["k"]):
        pass
    with closing(sqlite3.connect(tmp_path / FILE)) as connection, connection:
        connection.execute("INSERT INTO state VALUES ('runs', ?)", [text])
    with pytest.raises(InputError, match="broken JSON"):
        _ = StoreReader(tmp_path).state


def long_plan(folder):
    """A store whose plan takes SQLite more than one look at the clock."""
    with Store(folder, ["k"]) as store:
        [cell] = store.store_plan(CELLS[:1])
        series = {"s": (np.array([1]), np.array([0.5]))}
        store.add(cell, 1, Outcome("ok", {"k": 1}, series=series))
    with closing(sqlite3.connect(folder / FILE)) as connection, connection:
        rows = ((place, cell) for place in range(10, 100_000))
        connection.executemany("INSERT INTO plan (place, cell) VALUES (?, ?)", rows)


def answer(kept, ask):
    """All that a store answers to one question."""
    found = getattr(kept, ask)
    return list(found() if callable(found) else found)


@pytest.mark.parametrize("ask", ["counts", "runs", "series", "cells"])
def test_a_question_that_takes_too_long_is_interrupted(tmp_path, ask):
    long_plan(tmp_path)
    assert answer(StoreReader(tmp_path), ask), "in 30 s there is one"
    with pytest.raises(InputError, match="cannot be read: the answer takes too long"):
        answer(StoreReader(tmp_path, limit=0.0), ask)


def test_who_goes_on_with_a_store_that_takes_too_long_is_told_and_can_still_write(
    tmp_path, monkeypatch
):
    with Store(tmp_path, ["k"]) as store:
        store.store_plan(CELLS[:1])
    with closing(sqlite3.connect(tmp_path / FILE)) as connection, connection:
        rows = ((1, seed, "ok", 0.0, 1) for seed in range(100_000))
        into = "INSERT INTO run (cell, seed, status, seconds, ticks) VALUES (?, ?, ?, ?, ?)"
        connection.executemany(into, rows)
    with Store(tmp_path, ["k"]) as store:
        assert len(statuses(store)) == 100_000
        monkeypatch.setattr("app.studies.runs.store.LONGEST", 0.0)
        for ask in (lambda: statuses(store), lambda: store.others([2])):
            with pytest.raises(
                InputError, match="cannot be gone on with: the answer takes too long"
            ):
                ask()
        store.add(1, 100_001, Outcome("ok", {"k": 1}))
    assert StoreReader(tmp_path).counts["ok"] == 100_001


@pytest.mark.parametrize("axis", ["status", "place", "value", "k"])
def test_an_axis_with_the_name_of_another_column_makes_no_table(tmp_path, axis):
    with Store(tmp_path, ["k"]) as store:
        [cell] = store.store_plan([("a", json.dumps({"axes": {axis: 1}}))])
        store.add(cell, 1, Outcome("ok", {"k": 1}))
        store.tell(axes=[axis])
    for table in (wide_table, long_table):
        with pytest.raises(InputError, match=f"axis '{axis}' has the name of another column"):
            table(StoreReader(tmp_path))


def test_a_series_of_a_run_that_is_not_there_is_in_no_table(tmp_path):
    with Store(tmp_path, ["k"]) as store:
        [cell] = store.store_plan(CELLS[:1])
        series = {"s": (np.array([1]), np.array([0.5]))}
        for seed in (1, 2):
            store.add(cell, seed, Outcome("ok", {"k": 1}, series=series))
    with closing(sqlite3.connect(tmp_path / FILE)) as connection, connection:
        connection.execute("DELETE FROM run WHERE seed = 2")
    assert long_table(StoreReader(tmp_path))["seed"] == [1, 1]


@pytest.mark.parametrize(
    ("table", "column"),
    [
        *(("run", name) for name in ("status", "reason", "seconds", "ticks", "k")),
        *(("cell", name) for name in ("json",)),
        *(("series", name) for name in ("observable", "ticks", "values")),
        ("state", "value"),
    ],
)
@pytest.mark.parametrize("value", [b"\xff\x00", "words", 2**62, float("inf"), -1.5, None])
def test_a_value_of_any_kind_in_any_column_is_an_answer_or_a_line(tmp_path, table, column, value):
    with Store(tmp_path, ["k"]) as store:
        [cell] = store.store_plan(CELLS[:1])
        series = {"s": (np.array([1]), np.array([0.5]))}
        store.add(cell, 1, Outcome("ok", {"k": 1}, series=series))
        store.tell(runs=1)
    with closing(sqlite3.connect(tmp_path / FILE)) as connection, connection:
        try:
            connection.execute(f'UPDATE {table} SET "{column}" = ?', [value])
        except sqlite3.IntegrityError:
            return  # SQLite itself keeps it out
    for ask in ("counts", "state", "cells", "runs", "series"):
        with suppress(InputError):
            answer(StoreReader(tmp_path), ask)


def test_a_strangers_store_is_judged_before_anything_is_written(tmp_path):
    with Store(tmp_path, ["k"]):
        pass
    with closing(sqlite3.connect(tmp_path / FILE)) as connection:
        connection.execute("PRAGMA journal_mode = DELETE")
        connection.execute("CREATE VIEW more AS SELECT 1")
    before = (tmp_path / FILE).read_bytes()
    with pytest.raises(InputError, match="is not a store of runs"):
        Store(tmp_path, ["k"]).__enter__()
    assert (tmp_path / FILE).read_bytes() == before
