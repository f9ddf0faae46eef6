"""Runs that are over as rows: laid under the plots, named, deleted, in a table, in a file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from agents.flock import Flock
from agents.individuals import normal
from agents.kinds import Kind, chase
from agents.spec import Spec
from app.viewer.lab.panels.runs_panel import small_curve, table_bytes, table_html
from app.viewer.lab.runs_file import (
    HEAD,
    RunsFile,
    line_of,
    read_runs,
    run_values,
    runs_as_bytes,
    spec_of,
)
from app.viewer.measuring import kept_runs
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.kept_runs import KeptRuns, differing_names, runs_table
from app.viewer.measuring.observable_curves import ObservableHistory
from worlds.input_error import InputError


def read(ticks: int = 10, model: str = "vem", **given) -> FlockReadings:
    """A flock that has run, measured now and then."""
    kinds = given.pop("kinds", ())
    words = {"agents": 8, "seed": 1} | given
    readings = FlockReadings(Flock(Spec(model, kinds=kinds), **words))
    readings.read(at_once=True)
    for _ in range(ticks // 5):
        readings.flock.advance(5)
        readings.read(at_once=True)
    return readings


def change(readings: FlockReadings, **values) -> None:
    """Change parameters of a run, and go on."""
    readings.flock.set(**values)
    readings.note_conditions()
    readings.flock.advance(5)
    readings.read(at_once=True)


def kept(*runs: FlockReadings) -> KeptRuns:
    """All of these as rows."""
    rows = KeptRuns()
    for run in runs:
        rows.follow([run])
    rows.close()
    return rows


def test_every_run_is_a_row_and_one_that_is_repeated_has_the_row_of_the_first():
    rows = kept(read(seed=1), read(seed=2), read(ticks=20, seed=1), read(ticks=5, seed=1))
    assert [(run.number, run.ticks) for run in rows.rows] == [(1, 20), (2, 10)]
    rows.follow([read(seed=3, eta=0.4)])
    rows.close()
    assert [run.number for run in rows.rows] == [3, 1, 2]


def test_the_last_run_of_each_model_lies_under_the_plots_by_itself():
    rows = kept(read(seed=1), read(seed=2), read(seed=3), read(model="couzin"))
    assert [run.number for run in rows.rows if run.is_shown] == [4, 3]
    rows.show(1, True)
    rows.follow([read(seed=5)])
    rows.close()
    assert [run.number for run in rows.rows if run.is_shown] == [5, 4, 1]
    rows.lays_last = False
    rows.follow([read(seed=6)])
    rows.close()
    assert [run.number for run in rows.rows if run.is_shown] == [5, 4, 1]


def test_no_more_than_three_lie_under_the_plots():
    rows = kept(*(read(seed=seed) for seed in range(1, 6)))
    for number in range(1, 6):
        rows.show(number, True)
    vem = rows.rows[0].model
    assert [run.number for run in rows.shown_of(vem)] == [5, 4, 3]


def test_the_oldest_leave_a_list_that_is_too_long(monkeypatch):
    monkeypatch.setattr(kept_runs, "MOST_RUNS", 2)
    rows = kept(*(read(seed=seed, ticks=5) for seed in (1, 2, 3)))
    assert ([run.number for run in rows.rows], rows.dropped) == ([3, 2], 1)


def test_runs_are_named_and_deleted():
    rows = kept(read(seed=1), read(seed=2))
    rows.rename(1, "  much   noise ")
    assert rows.find(1).label == "run 1, much noise"
    rows.delete(2)
    assert [run.number for run in rows.rows] == [1]
    with pytest.raises(InputError, match="no run 2"):
        rows.delete(2)
    with pytest.raises(InputError, match="no run 7"):
        rows.show(7, True)
    with pytest.raises(InputError, match="at most 60 letters"):
        rows.rename(1, 61 * "x")
    rows.follow([read(seed=3)])
    rows.close()
    assert rows.rows[0].number == 3  # a number is not given twice


def test_the_table_has_a_row_for_each_run_and_says_what_was_changed():
    run = read(seed=2, eta=0.25)
    change(run, eta=1.5)
    rows = kept(read(seed=1, eta=0.5), run).rows
    table = runs_table(rows)
    assert table["run"] == [1, 2]
    assert table["seed"] == [1, 2]
    assert table["eta"] == [0.5, 0.25]
    assert table["ticks"] == [10, 15]
    assert table["changed"] == ["", "eta 0.25 → 1.5 at tick 10"]
    last = run.series("polarisation").recorded()[1][-1]
    assert table["polarisation"][1] == last
    assert differing_names(rows) == ["seed", "eta"]
    page = table_html(rows)
    assert "<th>eta</th>" in page
    assert "<th>noise</th>" not in page  # the same in all
    assert table_bytes(rows, "CSV").decode().count("\n") == 3


def test_a_small_curve_has_a_dot_where_something_was_changed():
    run = read()
    assert "<circle" not in small_curve(ObservableHistory.of(run), ("polarisation",))
    change(run, eta=1.0)
    assert small_curve(ObservableHistory.of(run), ("polarisation",)).count("<circle") == 1
    assert small_curve(ObservableHistory.of(run), ()) == "<i></i>"


def same(one, other) -> bool:
    """Whether two runs went alike, to nine figures, and under the same conditions."""
    return (
        one.course.history == other.course.history
        and one.course.tick == other.course.tick
        and one.name == other.name
        and one.course.curves.keys() == other.course.curves.keys()
        and all(
            np.allclose(one.course.points(name), other.course.points(name), rtol=1e-8)
            for name in one.course.curves
        )
    )


def test_a_file_of_runs_is_read_again():
    changed = read(seed=2, world="obstacles", agents=6)
    change(changed, eta=1.5)
    rows = kept(read(seed=1), changed, read(model="couzin", dim=3), read(size=7.0))
    rows.rename(2, "a name")
    found = read_runs("runs.jsonl", runs_as_bytes(rows.rows))
    assert found.skipped == ()
    assert all(same(*both) for both in zip(found.runs, rows.rows, strict=True))
    before = kept(read(seed=9))
    before.take(found.runs)
    assert [run.number for run in before.rows] == [5, 4, 3, 2, 1]


def test_runs_are_written_down_as_they_end(tmp_path: Path):
    path = tmp_path / "results" / "runs.jsonl"
    rows = KeptRuns(storage=RunsFile(path))
    for seed in (1, 2, 3):
        rows.follow([read(seed=seed)])
    assert len(RunsFile(path).found.runs) == 2  # the third goes on
    rows.close()
    rows.rename(1, "first")
    rows.delete(2)
    found = RunsFile(path).found
    assert [(run.course.conditions.seed, run.name) for run in found.runs] == [(3, ""), (1, "first")]


def test_a_file_that_a_kill_has_cut_loses_that_run_alone(tmp_path: Path):
    path = tmp_path / "runs.jsonl"
    rows = KeptRuns(storage=RunsFile(path))
    rows.follow([read(seed=1)])
    rows.close()
    with open(path, "ab") as file:
        file.write(b'{"key": "abc", "run": 2, "stre')
    again = RunsFile(path)
    assert again.found.skipped == ("line 3 is damaged",)
    assert "left out: line 3 is damaged" in again.found.told("runs.jsonl")
    rows = KeptRuns(again.found.runs, again)
    rows.follow([read(seed=2)])
    rows.close()
    assert [run.course.conditions.seed for run in RunsFile(path).found.runs] == [2, 1]


def test_a_disk_that_takes_nothing_is_told_once(tmp_path: Path):
    file = RunsFile(tmp_path / "folder" / "runs.jsonl")
    (tmp_path / "folder").write_text("no folder")
    told: list[str] = []
    file.tell = told.append
    rows = KeptRuns(storage=file)
    for seed in (1, 2):
        rows.follow([read(seed=seed)])
    rows.close()
    assert len(rows.rows) == 2
    assert len(told) == 1
    assert told[0].startswith("The runs are kept no more")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"model = 'vem'\n", "is no file of runs"),
        (b'{"flockscope": "runs", "format": 2}\n', "has the format 2"),
        (b"\xff\xfe", "is no file of runs"),
        (b"[" * 100_000, "is no file of runs"),
    ],
)
def test_what_is_no_file_of_runs_is_refused(data: bytes, words: str):
    with pytest.raises(InputError, match=words):
        read_runs("mine.jsonl", data)


def broken(values: dict, at: str, value: object) -> dict:
    """The values of a run with one of them replaced."""
    values = json.loads(json.dumps(values))
    *path, last = at.split(".")
    place = values
    for part in path:
        place = place[int(part)] if part.isdigit() else place[part]
    place[last] = value
    return values


@pytest.mark.parametrize(
    ("at", "value"),
    [
        ("stretches", []),
        ("stretches", "x"),
        ("stretches.0.spec", "model = 'vem'"),
        ("stretches.0.spec.model", "nothing"),
        ("stretches.0.spec.agents", 10**9),
        ("stretches.0.parameters.eta", 99.0),
        ("stretches.0.parameters", None),
        ("stretches.0.agents", "many"),
        ("curves.polarisation", [[0, 0], [1, 1]]),
        ("curves.polarisation", [[0, 5], [1]]),
        ("curves.polarisation", [[0], ["x"]]),
        ("curves", 3),
        ("tick", -3),
        ("dt", 0),
        ("name", "x" * 61),
        ("name", "\u202e"),
    ],
)
def test_a_run_that_is_wrong_is_left_out_and_told(at: str, value: object):
    (run,) = kept(read()).rows
    values = broken(run_values(run, "k"), at, value)
    found = read_runs("mine.jsonl", line_of(HEAD) + line_of(values))
    assert found.runs == ()
    assert len(found.skipped) == 1
    assert found.skipped[0].startswith("run 1: ")


def test_a_file_needs_its_ending_and_must_be_readable(tmp_path: Path):
    with pytest.raises(InputError, match=r"ends in \.jsonl"):
        RunsFile(tmp_path / "runs.toml")
    (tmp_path / "runs.jsonl").mkdir()
    with pytest.raises(InputError, match="cannot be read"):
        RunsFile(tmp_path / "runs.jsonl")


def test_python_reads_the_runs_and_makes_them_again(tmp_path: Path):
    import flockscope

    path = tmp_path / "runs.jsonl"
    rows = KeptRuns(storage=RunsFile(path))
    for run in (read(seed=3, eta=0.5), read(seed=4, eta=0.25)):
        rows.follow([run])
    rows.close()
    frame = flockscope.runs_frame(path)
    assert frame.seed.tolist() == [3, 4]
    assert frame.eta.tolist() == [0.5, 0.25]
    again = flockscope.Flock(frame.spec[1])
    again.advance(10)
    assert again.observe("polarisation") == pytest.approx(frame.polarisation[1], rel=1e-8)
    with pytest.raises(InputError, match="no such file"):
        flockscope.runs_frame(tmp_path / "other.jsonl")
    path.write_bytes(path.read_bytes() + b"{\n")
    with pytest.warns(UserWarning, match="line 4 is damaged"):
        flockscope.runs_frame(path)


def test_what_differs_is_written_in_the_table_and_read_again():
    run = read(s=normal(3.0, 0.5), model="couzin")
    change(run, s=2.0)
    change(run, s=[1.0 + k for k in range(8)])
    rows = kept(run)
    table = runs_table(rows.rows)
    assert table["s"] == ["normal(3, 0.5)"]
    assert "s normal(3, 0.5) → … → each of 8 agents" in table["changed"][0]
    assert b"normal(3, 0.5)" in table_bytes(rows.rows, "CSV")
    assert table_bytes([*rows.rows, *kept(read(s=2.0, model="couzin")).rows], "Parquet")
    read_again = read_runs("it", runs_as_bytes(rows.rows))
    assert read_again.skipped == ()
    history = read_again.runs[0].course.history
    assert history.steps["s"] == rows.rows[0].course.history.steps["s"]
    assert spec_of(history.first).individuals == {"s": normal(3.0, 0.5)}


def test_kinds_are_written_in_the_table_and_read_again():
    shark = Kind("shark", 2, v0=normal(0.05, 0.01), to={"flock": chase(1.5, 2.0, catch=0.2)})
    run = read(model="vem", agents=20, kinds=[shark])
    run.flock.relate("shark", "flock", chase(3.0, 2.0))
    run.note_conditions()
    run.watch(frozenset({"polarisation of shark"}))
    run.flock.advance(5)
    run.read(at_once=True)
    rows = kept(run)
    table = runs_table(rows.rows)
    assert table["agents"] == [20]
    assert table["agents of shark"] == [2]
    assert table["v0 of shark"] == ["normal(0.05, 0.01)"]
    assert table["shark to flock"] == ["chase 1.5, radius 2, catch 0.2, taken"]
    assert "→ chase 3, radius 2 at tick 10" in table["changed"][0]
    assert table["polarisation of shark"][0] <= 1.0
    assert b"polarisation of shark" in table_bytes(rows.rows, "CSV")
    read_again = read_runs("it", runs_as_bytes(rows.rows))
    assert read_again.skipped == ()
    (again,) = read_again.runs
    assert again.course.history.steps == rows.rows[0].course.history.steps
    assert spec_of(again.course.conditions).kinds == (shark,)
    robot = Kind("robot", 2, model="gregoire-chate", v0=0.05)
    rows = kept(read(model="vem", agents=20, kinds=[robot]))
    assert runs_table(rows.rows)["model of robot"] == ["gregoire-chate"]
    (again,) = read_runs("it", runs_as_bytes(rows.rows)).runs
    assert spec_of(again.course.conditions).kinds == (robot,)
    alone = kept(read(model="vem", agents=20), read(model="vem", agents=20, seed=2))
    assert all("kinds" not in one for one in run_values(alone.rows[0], "a")["stretches"])
