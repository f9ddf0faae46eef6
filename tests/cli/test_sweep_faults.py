"""`flockscope sweep run` when something goes wrong beside it: only what was under way is lost.

Its runs have a timeout, and so are made in processes: without it they are too short for these.
"""

import json
import os
import resource
import signal
import time

import psutil
import pytest

from app.studies.runs.database import FILE
from app.studies.runs.store import Store
from app.studies.runs.store_reader import StoreReader, readable
from cli.calling import call, refusal, start, wait_until

TEXT = """
[run]
model = "vem"
agents = 30
size = 3.0
ticks = 2000
timeout = 600.0
[[design]]
kind = "grid"
axes = { eta = [0.0, 3.0] }
[replicates]
count = 30
[[observe]]
name = "polarisation"
"""
RUNS = 60


def done(folder):
    return sum(StoreReader(folder).counts.values()) if readable(folder) else 0


def table(folder):
    result = call("sweep", "export", folder)
    assert result.exit_code == 0, result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The file of a sweep, and the table of it when nothing goes wrong."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "s.toml").write_text(TEXT)
    result = call("sweep", "run", folder / "s.toml", "--out", folder / "out", "--quiet")
    assert result.exit_code == 0, result.stderr
    return folder / "s.toml", table(folder / "out")


def begun(undisturbed, out, *options, runs=5, **more):
    """The sweep as a program of its own, once it has made some runs."""
    process = start("sweep", "run", undisturbed[0], "--out", out, *options, **more)
    wait_until(lambda: done(out) >= runs, process)
    return process


def children(process):
    return psutil.Process(process.pid).children(recursive=True)


def gone_on_with(undisturbed, out):
    result = call("sweep", "run", undisturbed[0], "--out", out, "--quiet", "--json")
    assert result.exit_code == 0, result.stderr
    assert table(out) == undisturbed[1]
    return json.loads(result.stdout)


def test_ctrl_c_ends_all_its_processes_and_loses_nothing_that_was_finished(tmp_path, undisturbed):
    """As a terminal sends it: to the whole group."""
    process = begun(undisturbed, tmp_path, start_new_session=True)
    makers = children(process)
    os.killpg(process.pid, signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "go on with: flockscope sweep run" in stderr
    assert makers
    assert psutil.wait_procs(makers, timeout=60)[1] == []
    before = done(tmp_path)
    assert gone_on_with(undisturbed, tmp_path)["taken"] == before >= 5


def test_ctrl_c_ends_runs_on_threads_and_loses_nothing_that_was_kept(tmp_path):
    text = TEXT.replace("timeout = 600.0\n", "").replace("count = 30", "count = 1500")
    (tmp_path / "s.toml").write_text(text)
    out = tmp_path / "out"
    process = begun((tmp_path / "s.toml", ""), out, start_new_session=True)
    assert children(process) == [], "so short runs need none"
    os.killpg(process.pid, signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "go on with: flockscope sweep run" in stderr
    before = done(out)
    assert 5 <= before < 3000
    options = ("--out", out, "--quiet", "--json", "--limit", 3)
    result = call("sweep", "run", tmp_path / "s.toml", *options)
    assert json.loads(result.stdout)["taken"] == before
    assert done(out) == before + 3


def test_a_process_that_is_killed_is_replaced(tmp_path, undisturbed):
    process = begun(undisturbed, tmp_path)
    makers = children(process)
    makers[0].kill()
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stderr
    assert f"{RUNS} runs made" in stderr
    assert table(tmp_path) == undisturbed[1]


def test_its_processes_end_with_a_parent_that_is_killed(tmp_path, undisturbed):
    process = begun(undisturbed, tmp_path)
    makers = children(process)
    process.kill()
    process.communicate()
    assert makers
    assert psutil.wait_procs(makers, timeout=60)[1] == []
    assert gone_on_with(undisturbed, tmp_path)["whole"]


def test_a_machine_that_sleeps_loses_no_run_and_no_time(tmp_path, undisturbed):
    """All processes are halted, and go on, longer than a run may take."""
    text = TEXT.replace("timeout = 600.0", "timeout = 8.0")
    (tmp_path / "s.toml").write_text(text)
    out = tmp_path / "out"
    alone = "--workers", 1  # one that has made runs: a second might just begin
    process = begun((tmp_path / "s.toml", ""), out, *alone, start_new_session=True)
    os.killpg(process.pid, signal.SIGSTOP)
    time.sleep(10.0)
    os.killpg(process.pid, signal.SIGCONT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stderr
    assert StoreReader(out).counts["ok"] == RUNS
    assert max(row[4] for row in StoreReader(out).runs()) < 9.0, "the sleep is no time of a run"
    assert table(out) == undisturbed[1], "a limit changes no numbers"


def test_a_disk_that_is_full_is_told_in_a_line_and_gone_on_with(tmp_path, undisturbed):
    """A process may write so much to a file only, which SQLite takes as it does a full disk."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))

    process = start("sweep", "run", undisturbed[0], "--out", tmp_path, preexec_fn=limited)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 2, stderr
    last = stderr.strip().splitlines()[-1]
    assert last.startswith("flockscope: store of runs")
    assert "cannot be kept: " in last
    assert gone_on_with(undisturbed, tmp_path)["taken"] < RUNS


def test_a_measure_that_hangs_is_killed_and_named(tmp_path):
    own = "def m(flock):\n    while flock.seed == 2:\n        pass\n    return 1.0\n"
    (tmp_path / "mine.py").write_text(own)
    text = TEXT.replace('name = "polarisation"', 'measure = "mine.py:m"').replace("30", "3")
    text = text.replace("ticks = 2000\ntimeout = 600.0", "ticks = 30\nseconds = 8")
    (tmp_path / "s.toml").write_text(text)
    out = tmp_path / "out"
    result = call("sweep", "run", tmp_path / "s.toml", "--out", out, "--quiet")
    assert result.exit_code == 3, result.stderr
    assert "cell 1, seed 2: killed: it took longer than 8 s" in result.stdout
    assert StoreReader(out).counts == {"ok": 4, "gave-up": 0, "failed": 0, "killed": 2}
    (tmp_path / "s.toml").write_text(text.replace("seconds = 8", "timeout = 0"))
    assert "run.timeout: a number > 0 is needed" in refusal("sweep", "run", tmp_path / "s.toml")


def test_a_store_of_another_kind_is_left_alone(tmp_path, undisturbed):
    (tmp_path / FILE).write_bytes(b"a,b\n")
    asked = ("sweep", "run", undisturbed[0], "--out", tmp_path, "--quiet")
    assert "is not a store of runs: move it away" in refusal(*asked)
    assert (tmp_path / FILE).read_bytes() == b"a,b\n"
    assert "cannot be made" in refusal(*asked[:-2], tmp_path / FILE, "--quiet")


def test_the_runs_of_a_paper_are_left_alone(tmp_path, undisturbed):
    with Store(tmp_path, ["k"]) as store:
        store.tell(kind="paper")
    before = (tmp_path / FILE).read_bytes()
    asked = ("sweep", "run", undisturbed[0], "--out", tmp_path, "--quiet")
    assert "has the runs of a paper" in refusal(*asked)
    assert (tmp_path / FILE).read_bytes() == before
