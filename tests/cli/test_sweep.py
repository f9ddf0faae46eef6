"""`flockscope sweep`: exit codes, tables, and the same bytes whoever is killed on the way."""

import json
import random
import signal
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from app.studies.runs.store_reader import StoreReader, readable
from cli.calling import call, refusal, start, wait_until

FILE = """
[run]
model = "vem"
agents = 30
size = 3.0
ticks = 300
[[design]]
kind = "grid"
axes = { eta = { from = 0, to = 6, count = 5 } }
[replicates]
count = 80
[[observe]]
name = "polarisation"
[[observe]]
name = "groups"
when = "every 100"
"""


def written(folder, text=FILE):
    path = folder / "s.toml"
    path.write_text(text)
    return path


def done(folder):
    return sum(StoreReader(folder).counts.values()) if readable(folder) else 0


def table(folder, *options):
    result = call("sweep", "export", folder, *options)
    assert result.exit_code == 0, result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The tables of a sweep that nobody stopped."""
    folder = tmp_path_factory.mktemp("undisturbed")
    result = call("sweep", "run", written(folder), "--out", folder / "out", "--quiet", "--json")
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    assert (made["made"], made["whole"], made["runs"]["ok"]) == (400, True, 400)
    return table(folder / "out"), table(folder / "out", "--long")


@pytest.mark.exhaustive
def test_killed_at_any_moment_and_gone_on_with_it_is_the_same_table(tmp_path, undisturbed):
    path, out = written(tmp_path), tmp_path / "out"
    chance = random.Random(1)
    for kind in (signal.SIGKILL, signal.SIGTERM):
        before = done(out)
        process = start("sweep", "run", path, "--out", out, "--quiet", "--nice", 1)
        target = before + chance.randint(1, 150)
        wait_until(lambda target=target: done(out) >= target, process)
        process.send_signal(kind)
        _, stderr = process.communicate(timeout=60)
        assert process.returncode == (-9 if kind == signal.SIGKILL else 130), stderr
        assert ("go on with: flockscope sweep run" in stderr) == (kind != signal.SIGKILL)
        assert target <= done(out) < 400
    result = call("sweep", "run", out, "--quiet", "--json")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["taken"] >= target
    assert (table(out), table(out, "--long")) == undisturbed


def test_another_process_looks_and_stops_it_and_none_other_writes(tmp_path):
    path = written(tmp_path, FILE.replace("ticks = 300", "ticks = 20000"))
    out = tmp_path / "results" / "s"
    process = start("sweep", "run", path, "--out", out, "--workers", 1)
    wait_until(lambda: done(out) >= 3, process)
    value = json.loads(call("sweep", "status", out, "--json").stdout)
    assert (value["state"], value["of"]) == ("running", 400)
    assert value["pid"] == process.pid
    assert value["rate"] > 0.0
    assert "by another process" in refusal("sweep", "run", path, "--out", out, "--quiet")
    assert call("sweep", "stop", out, "--quiet").exit_code == 0
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert "stopped" in call("sweep", "status", out).stdout
    listed = json.loads(call("sweep", "list", "--in", out.parent, "--json").stdout)["sweeps"]
    assert [one["state"] for one in listed] == ["stopped"]
    assert "no process runs" in refusal("sweep", "stop", out)


def test_failed_runs_give_code_3_and_can_be_repeated(tmp_path):
    (tmp_path / "mine.py").write_text("def m(flock):\n    return 1 / (flock.seed - 1)\n")
    text = FILE.replace('name = "polarisation"', 'measure = "mine.py:m"').replace("80", "2")
    out = tmp_path / "out"
    result = call("sweep", "run", written(tmp_path, text), "--out", out, "--quiet", "--plot")
    assert result.exit_code == 3
    assert "cell 1, seed 1: failed: ZeroDivisionError: division by zero" in result.stdout
    assert {"m.png", "m.svg"} <= {path.name for path in out.iterdir()}
    shown = json.loads(call("sweep", "show", out, "--json").stdout)
    assert [row["failed"] for row in shown["cells"]] == [1] * 5
    assert shown["cells"][0]["m"]["mean"] == 1.0
    spec = call("sweep", "show", out, "--cell", 2, "--seed", 1).stdout
    assert "seed = 1" in spec
    assert "eta = 1.5" in spec


def test_the_common_case_needs_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    asked = ("vem", "--vary", "eta=0:6:3", "--vary", "agents=10,20", "--set", "size=3", "--runs", 2)
    result = call("sweep", "check", *asked, "--ticks", 50, "--observe", "polarisation", "--json")
    value = json.loads(result.stdout)
    assert (value["cells"], value["runs"], value["axes"]) == (6, 12, ["eta", "agents"])
    assert not (tmp_path / "results").exists()
    result = call("sweep", "run", *asked, "--ticks", 50, "--observe", "polarisation", "--quiet")
    assert result.exit_code == 0, result.stderr
    lines = table("vem-eta-agents").splitlines()
    assert lines[0] == "place,eta,agents,seed,status,reason,ticks,astray,polarisation"
    assert len(lines) == 13
    exponents = ["--beta", "0.45", "--nu", "1.6", "--critical", "4.3"]
    more_of = {"map": ["--snapshots"], "scaling": exponents}
    for ending, kind in (
        (".pdf", "lines"), (".svg", "map"), (".png", "distribution"), (".PNG", "scaling"),
    ):  # fmt: skip
        path = tmp_path / f"x{ending}"
        more = more_of.get(kind, [])
        drawn = call("sweep", "plot", "vem-eta-agents", "--kind", kind, "--out", path, *more)
        assert drawn.exit_code == 0, drawn.stderr
        assert path.stat().st_size > 1000


def test_a_spread_is_varied_without_a_file_and_gone_on_with(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    vary = ("--vary", "v0.spread=0:0.01:2", "--vary", "eta.mean=0.2,0.4")
    more = ("--set", "eta=normal:0.3:0.1", "--set", "agents=10", "--observe", "polarisation")
    result = call("sweep", "run", "vem", *vary, *more, "--runs", 2, "--ticks", 5, "--limit", 3)
    assert result.exit_code == 0, result.stderr
    assert "v0.spread: spread of v0 / length/tick" in result.stdout
    result = call("sweep", "run", "vem-v0.spread-eta.mean", "--json")
    assert (json.loads(result.stdout)["made"], json.loads(result.stdout)["taken"]) == (5, 3)
    lines = table("vem-v0.spread-eta.mean").splitlines()
    assert lines[0].startswith("place,v0.spread,eta.mean,seed,")
    assert [line.split(",")[1:3] for line in lines[1::2]] == [
        ["0.0", "0.2"], ["0.0", "0.4"], ["0.01", "0.2"], ["0.01", "0.4"],
    ]  # fmt: skip
    call("sweep", "export", "vem-v0.spread-eta.mean", "runs.parquet")
    assert pq.read_table("runs.parquet").column_names[1:3] == ["v0.spread", "eta.mean"]
    spec = call("sweep", "show", "vem-v0.spread-eta.mean", "--cell", 4, "--seed", 1).stdout
    assert "[parameters.v0]\nnormal = [0.03, 0.01]" in spec
    assert "[parameters.eta]\nnormal = [0.4, 0.1]" in spec
    drawn = call("sweep", "plot", "vem-v0.spread-eta.mean", "--kind", "map", "--out", "map.svg")
    assert drawn.exit_code == 0, drawn.stderr
    for label in ("spread of $v_0$ / length/tick", r"mean of $\eta$ / rad"):
        assert label in Path("map.svg").read_text()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("run", "vem"), "for a model give --vary"),
        (("run", "vem", "--vary", "v0.spread=-1:1:3"), "a spread is >= 0 (--vary v0.spread="),
        (("run", "vem", "--vary", "k.mean=3,4"), "neighbours of all (--vary k.mean=3,4"),
        (("run", "vem", "--vary", "v0.mean=0,9"), "is outside [0, 1] length/tick (--vary v0.mea"),
        (("run", "vem", "--vary", "v0.mean=0,1", "--vary", "v0=1"), "beside v0, which is one"),
        (("run", "nowhere.toml"), "cannot be read"),
        (("run", "vem", "--vary", "eta"), "is not of the form NAME=FROM:TO:COUNT"),
        (("run", "vem", "--vary", "eta=0:9:3"), "is outside [0, 6.2832] rad (--vary eta="),
        (("run", "vem", "--vary", "eta=0:6:3", "--set", "v0=-1"), "(--set v0=-1"),
        (("run", "vem", "--vary", "eta=0:6:3", "--observe", "x"), "unknown observable 'x'"),
        (("run", "vem", "--vary", "eta=0:6:3", "--over", "9"), "--over needs --observe"),
        (("plot", "x", "--beta", "1"), "a collapse takes --beta and --nu"),
        (("status", "nothing"), "there is no sweep 'nothing'"),
        (("show", "nothing"), "there is no sweep 'nothing'"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_a_line(args, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in refusal("sweep", *args)
    assert list(tmp_path.iterdir()) == []


def test_a_world_that_is_not_the_papers_is_named():
    asked = ("hwvem", "--vary", "p2=1,5", "--set", "agents=20", "--observe", "consistency")
    for world, warned in (("wrap", True), ("wrap-plain", False)):
        result = call("sweep", "check", *asked, "--set", f"world={world}", "--set", "size=2.2")
        assert ("used wrap-plain" in result.stderr) == warned
