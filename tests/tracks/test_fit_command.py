"""`flockscope fit`: sentences, a table, files; killed at any moment it goes on where it was."""

from __future__ import annotations

import json
import signal
import sqlite3

import numpy as np
import pytest
from cli.calling import call, refusal, start, wait_until

from app.studies.runs.store_reader import StoreReader, readable
from tracks.fitted_flocks import mill
from worlds.file_writer import csv_text

READING = ("--rate", 10, "--unit", "m", "--origin", "bottom-left")
GRID = ("--model", "couzin", "--parameters", "dr_o=2:4:3,dr_a=8:12:3", "--shuffles", 1)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A mill with noise of 10 % of a step, as a plain table."""
    place = mill(0.1, frames=160).position
    frame, individual = np.indices(place.shape[:2])
    columns = np.column_stack([frame.ravel(), individual.ravel(), place.reshape(-1, 2)])
    path = tmp_path_factory.mktemp("tracks") / "mill.csv"
    path.write_text(csv_text(["frame", "id", "x", "y"], columns.tolist()))
    return path


def values(result):
    """What does not depend on where it was run, and how often it was stopped."""
    assert result.exit_code == 0, result.stderr
    value = json.loads(result.stdout)
    return {key: value[key] for key in value.keys() - {"files", "evaluated", "taken"}}


def test_it_says_what_the_tracks_tell_and_writes_it_down(file, tmp_path):
    result = call("fit", file, *READING, *GRID, "--out", tmp_path / "fit")
    assert result.exit_code == 0
    assert "couzin explains" in result.stdout
    assert "dr_o 3" in result.stdout
    assert "keeps its heading" in result.stdout
    assert "9 cells evaluated, 0 taken" in result.stderr
    names = {"fit.json", "costs.csv", "fit-couzin.png", "fit-couzin.svg", "runs.sqlite"}
    assert names <= {path.name for path in (tmp_path / "fit").iterdir()}
    rows = (tmp_path / "fit" / "costs.csv").read_text().splitlines()
    assert rows[0] == "model,dr_o,dr_a,cost,cost_second_window,in_region,in_region_second_window"
    assert len(rows) == 10
    stored = json.loads((tmp_path / "fit" / "fit.json").read_text())
    assert stored["models"][0]["best"] == {"dr_o": 3.0, "dr_a": 10.0}


def test_called_again_it_evaluates_nothing_and_says_the_same(file, tmp_path):
    command = ("fit", file, *READING, *GRID, "--out", tmp_path / "fit", "--json", "--quiet")
    first = call(*command)
    again = call(*command)
    assert json.loads(first.stdout)["evaluated"] == 9
    assert (json.loads(again.stdout)["evaluated"], json.loads(again.stdout)["taken"]) == (0, 9)
    assert values(first) == values(again)


def test_stopped_by_its_limit_it_goes_on(file, tmp_path):
    command = ("fit", file, *READING, *GRID, "--out", tmp_path / "fit", "--quiet")
    stopped = call(*command, "--limit", 4)
    assert stopped.exit_code == 0
    assert "not all cells are evaluated; the same command goes on" in stopped.stderr
    rest = json.loads(call(*command, "--json").stdout)
    assert (rest["evaluated"], rest["taken"]) == (5, 4)


@pytest.mark.exhaustive
def test_killed_and_gone_on_with_it_is_the_same_answer(file, tmp_path):
    wide = ("--model", "couzin", "--parameters", "dr_o,dr_a", "--shuffles", 2, "--quiet")
    command = ("fit", file, *READING, *wide, "--workers", 1)
    whole = values(call(*command, "--out", tmp_path / "a", "--json"))
    out = tmp_path / "b"

    def done():
        return sum(StoreReader(out).counts.values()) if readable(out) else 0

    for kind in (signal.SIGKILL, signal.SIGINT):
        before = done()
        process = start(*command, "--out", out)
        wait_until(lambda before=before: done() > before, process)
        process.send_signal(kind)
        process.communicate()
    assert 0 < done() < 256
    with sqlite3.connect(out / "runs.sqlite") as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    rest = call(*command, "--out", out, "--json")
    assert json.loads(rest.stdout)["taken"] > 0
    assert values(rest) == whole


def test_several_models_stand_in_one_table(file, tmp_path):
    result = call(
        "fit", file, *READING, "--model", "couzin", "--model", "vem", "--parameters",
        "dr_o=2:4:3,r=1:3:3", "--shuffles", 1, "--out", tmp_path / "fit", "--json", "--quiet",
    )  # fmt: skip
    table = json.loads(result.stdout)["table"]
    assert [row["rule"] for row in table] == ["keeps its heading", "couzin", "vem"]
    assert [row["explains"] for row in table] == [None, True, False]


def test_likelihood_and_abc_by_command(file, tmp_path):
    likelihood = call(
        "fit", file, *READING, "--model", "vem", "--method", "likelihood", "--parameters",
        "r=1:4:4", "--shuffles", 1, "--out", tmp_path / "likelihood", "--json", "--quiet",
    )  # fmt: skip
    assert json.loads(likelihood.stdout)["models"][0]["explains"] is False
    abc = call(
        "fit", file, *READING, "--every", 5, "--model", "couzin", "--method", "abc",
        "--frame-ticks", 5, "--parameters", "dr_o=1:5:2", "--runs", 50, "--fit-frames", 10,
        "--out", tmp_path / "abc", "--quiet",
    )  # fmt: skip
    assert "couzin explains nothing: none of 50 runs is like these tracks" in abc.stdout
    assert "not told" in abc.stdout
    assert "5 ticks are 1 frame (a tick is 0.1 s)" in abc.stdout
    assert (tmp_path / "abc" / "fit-couzin.svg").exists()


def test_what_cannot_be_fitted_is_one_line(file, tmp_path):
    out = ("--out", tmp_path / "fit")
    assert "which model?" in refusal("fit", file, *READING, *out)
    assert "unknown model 'cousin'" in refusal("fit", file, *READING, "--model", "cousin", *out)
    line = refusal("fit", file, "--model", "couzin", "--parameters", "dr_x", *out)
    assert "unknown parameter 'dr_x': did you mean 'dr_o'?" in line  # before the file is read
    pixels = refusal("fit", file, "--rate", 10, "--unit", "px", "--origin", "bottom-left",
                     *GRID, *out)  # fmt: skip
    assert "mill.csv is in pixels: give --scale, metres in a pixel, or --length" in pixels
    (tmp_path / "paper").mkdir()
    (tmp_path / "paper" / "runs.sqlite").write_text("no store")
    busy = refusal("fit", file, *READING, *GRID, "--quiet", "--out", tmp_path / "paper")
    assert "is not a store of runs" in busy
