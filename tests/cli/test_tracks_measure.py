"""`flockscope tracks measure`, in a terminal and in scripts."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from agents import Flock
from agents.recordings.recorder import Recorder
from app.tracks.measure_report import measure_tracks
from app.tracks.measures.track_measure import MeasureOptions
from app.tracks.read_tracks import read
from cli.calling import call, refusal

ROOM = "POLYGON ((-9 -9, 99 -9, 99 99, -9 99, -9 -9))"


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A recording of a flock, and what was observed of it at each tick."""
    path = tmp_path_factory.mktemp("recorded") / "run.parquet"
    flock = Flock("vem", agents=40, size=5.0, eta=1.0, rng=4)
    names = ("polarisation", "angular-momentum", "correlation-length", "mean-neighbours")
    observed = []
    with Recorder(path, flock) as recorder:
        for _ in range(41):
            recorder.write()
            observed.append([flock.observe(name) for name in names])
            flock.run(1)
    return path, names, np.array(observed), flock.reach


@pytest.fixture
def table(tmp_path):
    """Six individuals as a table of the kind that `convert` writes, with one gap."""
    rng = np.random.default_rng(2)
    place = rng.uniform(0.0, 3.0, (6, 2)) + np.cumsum(rng.normal(0.05, 0.05, (80, 6, 2)), axis=0)
    rows = [
        f"{t},{i},{place[t, i, 0]:.6f},{place[t, i, 1]:.6f}"
        for t in range(80)
        for i in range(6)
        if not (i == 2 and 30 <= t < 34)
    ]
    path = tmp_path / "animals.csv"
    path.write_text("\n".join(["frame,id,x,y", *rows]) + "\n", encoding="utf-8")
    return path


TOLD = ("--rate", "25", "--unit", "m", "--origin", "bottom-left")


def test_a_recording_read_as_tracks_has_the_observables_of_its_flock(recording):
    path, names, observed, reach = recording
    for use_file in (False, True):
        report = measure_tracks(
            read(path), list(names), MeasureOptions(reach=reach), window=0.0,
            use_file_headings=use_file,
        )  # fmt: skip
        for k, name in enumerate(names):
            found = report.results[name].tables[""][name.replace("-", "_")][1:]
            np.testing.assert_allclose(found, observed[1:, k], rtol=1e-6, err_msg=name)


def test_numbers_are_printed_with_window_noise_and_number_seen(table):
    lines = call(
        "tracks", "measure", table, *TOLD, "--only", "polarisation,speed"
    ).stdout.splitlines()
    assert lines[0].startswith("6 individuals, 80 frames")
    assert any("window 5 frames (0.16 s); noise of places" in line for line in lines)
    assert any(line.startswith("polarisation: mean 0.") for line in lines)
    assert any("least number seen 5, largest number seen 6" in line for line in lines)
    assert not any(line.startswith("spacing") for line in lines)


def test_a_folder_is_written_and_not_written_over(table, tmp_path):
    out = tmp_path / "out"
    arguments = (
        "tracks",
        "measure",
        table,
        *TOLD,
        "--all",
        "--window",
        0.2,
        "--longest-delay",
        0.5,
    )
    made = call(*arguments, "--out", out)
    assert "report.html" in made.stderr
    names = {path.name for path in out.iterdir()}
    assert {"report.html", "report.pdf", "numbers.json", "series.parquet"} <= names
    assert {"polarisation.csv", "leadership.csv", "turning-map.csv"} <= names
    before = (out / "report.html").read_bytes()
    assert "exists already" in refusal(*arguments, "--out", out)
    assert (out / "report.html").read_bytes() == before
    call(*arguments, "--overwrite", "--out", out)
    assert (out / "report.html").read_bytes() == before, "the same tracks are the same page"


def test_json_is_all_of_it(table, tmp_path):
    chosen = ("--only", "speed,crowd-density", "--walkable", ROOM, "--least", 2)
    more = ("--json", "--quiet", "--out", tmp_path / "o")
    made = call("tracks", "measure", table, *TOLD, *chosen, *more)
    value = json.loads(made.stdout)
    assert made.stderr == ""
    assert set(value["measures"]) == {"speed", "crowd-density"}
    assert (value["least"], value["window_frames"], value["unit"]) == (2, 5, "m")
    assert str(tmp_path / "o" / "report.html") in value["files"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--only", "polarisaton"), "unknown measure 'polarisaton': did you mean 'polarisation'?"),
        (("--only", ""), "unknown measure ''"),
        (("--only", "speed", "--all"), "--all and --only speed are not allowed together"),
        (("--window", "-1"), "window = -1 s is not allowed"),
        (("--window", "60"), "take a shorter one"),
        (("--least", "0"), "least = 0 is not allowed"),
        (("--least-speed", "nan"), "least speed = nan"),
        (("--headings", "file"), "holds no headings"),
        (("--headings", "nose"), "--headings"),
        (("--only", "flow"), "where people can walk is needed: --walkable WKT"),
        (("--only", "flow", "--walkable", ROOM), "a line to cross is needed: --line WKT"),
        (("--only", "crowd-density", "--walkable", "1 2 3"), "--walkable = '1 2 3' is no WKT"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(table, options, words):
    assert words in refusal("tracks", "measure", table, *TOLD, *options)


def test_a_folder_that_cannot_be_is_refused_before_the_work(table):
    line = refusal("tracks", "measure", table, *TOLD, "--out", table / "folder")
    assert "is no folder to write to" in line


def test_an_interrupt_leaves_no_half_of_a_report(tmp_path, table):
    out = tmp_path / "out"
    code = (
        "import sys, time, app.tracks.measure_report as report, app.cli.main as main\n"
        "def stop(*_):\n"
        "    print('measuring', flush=True); time.sleep(600)\n"
        "report.draw_charts = stop\n"
        "main.main()"
    )
    arguments = ["tracks", "measure", str(table), *TOLD, "--only", "speed", "--out", str(out)]
    command = [sys.executable, "-c", code, *arguments]
    process = subprocess.Popen(
        command,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=Path(__file__).parents[2],
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "measuring\n"
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=600)
    assert process.returncode == 130
    assert not out.exists()
