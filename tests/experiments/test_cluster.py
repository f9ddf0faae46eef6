"""Sweeps on a cluster of this machine: workers and schedulers killed, the same bytes in the end."""

import os
import re
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import pytest
from cli.calling import call, start, wait_until

from app.experiments.cluster.asked import Cluster
from app.experiments.runs.reading import Kept, readable
from app.experiments.sweeps.conduct import conduct
from app.experiments.sweeps.table import as_csv, long, wide
from app.experiments.workers.makers import Task
from experiments.jobs import Sums
from experiments.test_sweep_file import read

pytest.importorskip("dask_jobqueue", reason="the extra cluster is not installed")
import psutil

from app.experiments.cluster.on_cluster import OnCluster

TEXT = """
[run]
model = "vem"
agents = 30
size = 3.0
ticks = TICKS
[[design]]
kind = "grid"
axes = { eta = { from = 0, to = 6, count = 5 } }
[replicates]
count = 24
[[observe]]
name = "polarisation"
[[observe]]
name = "groups"
when = "every 100"
"""
SMALL, LARGE = TEXT.replace("TICKS", "300"), TEXT.replace("TICKS", "3000")


def tables(folder):
    return as_csv(wide(Kept(folder))), as_csv(long(Kept(folder)))


def done(folder):
    return sum(Kept(folder).counts.values()) if readable(folder) else 0


@pytest.fixture(scope="module")
def one_machine(tmp_path_factory):
    """The tables of the sweeps without a cluster."""
    made = {}
    for text in (SMALL, LARGE):
        folder = tmp_path_factory.mktemp("one")
        conduct(read(folder, text=text), folder / "out", workers=2)
        made[text] = tables(folder / "out")
    return made


def wait(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.05)


def workers_of(parent):
    """The processes of Dask's workers on this machine: those that were spawned, with no nanny."""
    return [one for one in psutil.Process(parent).children() if "spawn_main" in str(one.cmdline())]


def test_whatever_a_run_does_the_others_are_kept_once(tmp_path):
    payloads = {1: "raise", 2: "kill", 3: "kill once", 4: "kill worker", 5: "print"}
    kept = []
    with OnCluster(Sums(str(tmp_path)), Cluster(kind="local"), 2, 0, None) as makers:
        tasks = [Task(1, seed, payloads.get(seed)) for seed in range(12)]
        assert makers.run(tasks, lambda task, outcome: kept.append((task.seed, outcome)))
        assert makers.workers == 2
        assert not makers.chunks, "whatever came back is released"
    assert sorted(seed for seed, _ in kept) == list(range(12))
    broken = {seed: (one.status, one.reason) for seed, one in kept if one.status != "ok"}
    assert broken == {
        1: ("failed", "ValueError: seed 1 is bad"),
        2: ("killed", "its process ended twice, with signal SIGKILL"),
        4: ("killed", "2 workers ended while it was made, alone"),
    }
    assert all(one.values == {"sum": seed + 1} for seed, one in kept if seed not in broken)


def test_a_worker_that_is_killed_loses_nothing(tmp_path, one_machine):
    killed = []

    def kill_one():
        if not killed:
            wait(lambda: done(tmp_path / "out") > 20)
            killed.extend(workers_of(os.getpid())[:1])
            killed[0].kill()

    thread = threading.Thread(target=kill_one)
    thread.start()
    sweep = read(tmp_path, text=LARGE)
    made = conduct(sweep, tmp_path / "out", workers=2, cluster=Cluster(kind="local"))
    thread.join()
    assert len(killed) == 1
    assert (made.made, made.broken, made.whole) == (120, 0, True)
    assert tables(tmp_path / "out") == one_machine[LARGE]


@contextmanager
def dask(folder, *more):
    """A scheduler and a worker of this machine, as somebody else has begun them: its address."""
    program = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1"]
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    scheduler = subprocess.Popen([*program, "--port", "0", "--no-dashboard"], **options)
    with scheduler:
        address = next(found[0] for line in scheduler.stderr
                       if (found := re.search(r"tcp://127.0.0.1:\d+", line)))  # fmt: skip
        threading.Thread(target=scheduler.stderr.read, daemon=True).start()
        program = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-dashboard"]
        worker = subprocess.Popen(
            [*program, "--nthreads", "2", "--death-timeout", "5", *more],
            cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            yield scheduler, worker, f"dask:{address}"
        finally:
            worker.terminate()
            scheduler.kill()
            worker.wait()


def test_a_scheduler_that_is_killed_loses_what_was_under_way_only(tmp_path, one_machine):
    sweep = tmp_path / "s.toml"
    sweep.write_text(LARGE)
    out = tmp_path / "out"
    with dask(tmp_path) as (scheduler, _, address):
        process = start("sweep", "run", sweep, "--out", out, "--cluster", address)
        wait_until(lambda: done(out) > 20, process)
        scheduler.kill()
        _, stderr = process.communicate(timeout=60)
    assert process.returncode == 2
    assert "is gone: finished runs are kept, and the same call goes on" in stderr
    assert 20 < done(out) < 120
    with dask(tmp_path) as (_, _, address):
        result = call("sweep", "run", sweep, "--out", out, "--cluster", address, "--quiet")
    assert result.exit_code == 0, result.stderr
    assert tables(out) == one_machine[LARGE]
