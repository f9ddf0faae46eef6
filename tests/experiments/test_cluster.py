"""Sweeps on a cluster of this machine: workers and schedulers killed, the same bytes in the end."""

import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress

import pytest
from cli.calling import call, refusal, start, wait_until

from app.studies.cluster.cluster_options import Cluster
from app.studies.runs.store_reader import StoreReader, readable
from app.studies.sweeps.sweep_runner import run_sweep
from app.studies.sweeps.sweep_table import as_csv, long_table, wide_table
from app.studies.workers.run_executors import Task
from experiments.jobs import Sums
from experiments.test_sweep import SPREAD
from experiments.test_sweep_file import read
from worlds.input_error import InputError

pytest.importorskip("dask_jobqueue", reason="the extra cluster is not installed")
import psutil
from dask.config import set as dask_config
from distributed import Client

from app.studies.cluster.cluster_connection import open_cluster
from app.studies.cluster.cluster_executor import ClusterExecutor

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
SMALL, LARGE = TEXT.replace("TICKS", "300"), TEXT.replace("TICKS", "2000")


def tables(folder):
    return as_csv(wide_table(StoreReader(folder))), as_csv(long_table(StoreReader(folder)))


def done(folder):
    return sum(StoreReader(folder).counts.values()) if readable(folder) else 0


@pytest.fixture(scope="module")
def one_machine(tmp_path_factory):
    """The tables of the sweeps without a cluster."""
    made = {}
    for text in (SMALL, LARGE):
        folder = tmp_path_factory.mktemp("one")
        run_sweep(read(folder, text=text), folder / "out", workers=2)
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


def answers(port):
    """What a stranger without a key gets from a port."""
    with socket.create_connection(("127.0.0.1", port), timeout=60.0) as line:
        line.sendall(b"GET /info/main/workers.html HTTP/1.0\r\n\r\n")
        with suppress(ConnectionError):
            return line.recv(1000)
        return b""


def test_nothing_of_a_cluster_answers_a_browser():
    with open_cluster(Cluster(kind="local"), 2) as made:
        made.client.wait_for_workers(2, timeout=60)
        here = psutil.Process()
        ports = {
            line.laddr.port
            for one in (here, *here.children(recursive=True))
            for line in one.net_connections("tcp")
            if line.status == psutil.CONN_LISTEN
        }
        assert len(ports) >= 5  # the scheduler, two workers and their nannies
        for port in ports:
            assert not answers(port).startswith(b"HTTP"), port


def test_whatever_a_run_does_the_others_are_kept_once(tmp_path):
    payloads = {1: "raise", 2: "kill", 3: "kill once", 4: "kill worker", 5: "sleep"}
    kept = []
    with ClusterExecutor(Sums(str(tmp_path)), Cluster(kind="local"), 2, limit=4.0) as makers:
        tasks = [Task(1, seed, payloads.get(seed)) for seed in range(12)]
        assert makers.run(tasks, lambda task, outcome: kept.append((task.seed, outcome)))
        assert not makers.chunks, "whatever came back is released"
    assert sorted(seed for seed, _ in kept) == list(range(12))
    broken = {seed: (one.status, one.reason) for seed, one in kept if one.status != "ok"}
    assert broken == {
        1: ("failed", "ValueError: seed 1 is bad"),
        2: ("killed", "its process ended twice, with signal SIGKILL"),
        4: ("killed", "2 workers ended while it was made, alone"),
        5: ("killed", "it took longer than 4 s"),
    }
    assert all(one.values == {"sum": seed + 1} for seed, one in kept if seed not in broken)


def test_agents_that_differ_do_so_on_a_cluster(tmp_path):
    sweep = read(tmp_path, text=SPREAD)
    run_sweep(sweep, tmp_path / "here", workers=1)
    run_sweep(sweep, tmp_path / "there", workers=1, cluster=Cluster(kind="local"))
    assert tables(tmp_path / "here") == tables(tmp_path / "there")


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
    made = run_sweep(sweep, tmp_path / "out", workers=2, cluster=Cluster(kind="local"))
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


SBATCH = """#!/bin/sh
cp "$1" {folder}/job.sh
setsid sh {folder}/job.sh > {folder}/job.log 2>&1 &
echo $! >> {folder}/jobs
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/sh
kill -- -$1
"""


@pytest.fixture
def slurm(tmp_path, monkeypatch):
    """A queue that begins each job at once, on this machine; the folder in which it notes them."""
    folder = tmp_path / "queue"
    folder.mkdir()
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        (folder / name).write_text(text.format(folder=folder))
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    return folder


def test_jobs_of_a_queue_make_the_runs_and_are_replaced(tmp_path, slurm, one_machine, monkeypatch):
    """Also one that ends, the only one, as its results are fetched: they are lost with it."""
    monkeypatch.setattr("app.studies.cluster.cluster_executor.AGAIN", 1.0)
    cluster = Cluster(kind="slurm", cores=2, shared=str(tmp_path / "shared"))
    ended = []
    fetch = ClusterExecutor.fetch

    def too_late(makers, results):
        if results and not ended and done(tmp_path / "out") > 20:
            ended.append(int((slurm / "jobs").read_text().split()[0]))
            os.killpg(ended[0], signal.SIGKILL)
        return fetch(makers, results)

    monkeypatch.setattr(ClusterExecutor, "fetch", too_late)
    with dask_config({"distributed.deploy.lost-worker-timeout": "1s"}):
        made = run_sweep(read(tmp_path, text=LARGE), tmp_path / "out", workers=9, cluster=cluster)
    assert (made.made, made.broken, made.whole) == (120, 0, True)
    assert tables(tmp_path / "out") == one_machine[LARGE]
    script = (slurm / "job.sh").read_text()
    assert "#SBATCH --cpus-per-task=2" in script
    assert len((slurm / "jobs").read_text().split()) == 2
    assert [path.name for path in (tmp_path / "shared").iterdir()] == ["logs"], "the keys are gone"
    wait(
        lambda: not any(psutil.pid_exists(int(pid)) for pid in (slurm / "jobs").read_text().split())
    )


def test_jobs_end_with_a_parent_that_is_killed(tmp_path, slurm):
    (tmp_path / "s.toml").write_text(LARGE + f"[cluster]\nshared = '{tmp_path}/shared'\n")
    out = tmp_path / "out"
    process = start("sweep", "run", tmp_path / "s.toml", "--out", out, "--cluster", "slurm")
    wait_until(lambda: done(out) > 0, process)
    job = psutil.Process(int((slurm / "jobs").read_text()))
    begun = [job, *job.children(recursive=True)]
    assert any("serve_pipes()" in str(one.cmdline()) for one in begun), "one of them makes runs"
    process.kill()
    process.communicate()
    assert psutil.wait_procs(begun, timeout=60)[1] == []


def test_a_worker_whose_time_is_over_hands_on_what_it_has(tmp_path, one_machine):
    """As `--lifetime` ends it: it tells the scheduler, and leaves while it is at a run."""
    out = tmp_path / "out"
    with dask(tmp_path, "--nworkers", "2") as (_, _, address):
        left = []

        def at(_share, _left, _words):
            if not left and done(out) > 20:
                with Client(address.removeprefix("dask:"), set_as_default=False) as client:
                    left.extend(client.retire_workers([min(client.nthreads())], close_workers=True))

        made = run_sweep(
            read(tmp_path, text=LARGE), out, workers=1, cluster=Cluster(kind=address), at=at
        )
    assert len(left) == 1
    assert (made.made, made.broken, made.whole) == (120, 0, True)
    assert tables(out) == one_machine[LARGE]


def test_a_queue_that_sends_no_worker_is_told_of(tmp_path, slurm, monkeypatch):
    monkeypatch.setattr("app.studies.cluster.cluster_executor.ALONE", 0.0)
    (slurm / "sbatch").write_text("#!/bin/sh\necho Submitted batch job 7\n")
    (slurm / "scancel").write_text(f"#!/bin/sh\necho $1 > {slurm}/cancelled\n")
    shared = str(tmp_path / "shared")
    cluster, told = Cluster(kind="slurm", shared=shared), []
    with ClusterExecutor(Sums(), cluster, 1, tell=told.append) as makers:
        tasks = [Task(1, seed, None) for seed in range(9)]
        assert not makers.run(tasks, lambda *_: None, lambda: bool(told))
    assert [f"logs of jobs are in {shared}/logs" in one for one in told] == [True]
    assert (slurm / "cancelled").read_text() == "7\n"


def test_what_a_queue_says_to_a_job_is_told(tmp_path, slurm):
    (slurm / "sbatch").write_text("#!/bin/sh\necho 'invalid partition specified' >&2; exit 1\n")
    cluster = Cluster(kind="slurm", shared=str(tmp_path / "shared"))
    with pytest.raises(InputError, match=r"takes no job: sbatch: invalid partition specified"):
        run_sweep(read(tmp_path, text=SMALL), tmp_path / "out", workers=1, cluster=cluster)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--cluster", "slur"), "'slur' is not local, dask:ADDRESS, slurm or pbs"),
        (("--cluster", "dask:host"), "'dask:host' is not local, dask:ADDRESS"),
        (("--cluster", "dask:host:99999"), "a port is 1 to 65535"),
        (("--cluster", "slurm", "--walltime", "9"), "--walltime: '9' is not HH:MM:SS"),
        (("--cluster", "slurm", "--walltime", "00:01:00"), "'00:01:00' is too short"),
        (("--cluster", "pbs", "--memory", "4"), "--memory: '4' is not a number of MB"),
        (("--cluster", "pbs", "--queue", "a;rm"), "--queue: 'a;rm' is not a name"),
        (("--cluster", "pbs", "--jobs", "0"), "--jobs: 0 is not allowed: a number >= 1"),
        (("--cluster", "slurm", "--workers", "3"), "--workers is of this machine"),
        (("--cluster", "local", "--cores", "3"), "--cores is of a queue"),
        (("--dry-run",), "--dry-run prints a job: give --cluster slurm"),
    ],
)  # fmt: skip
def test_a_cluster_that_cannot_be_is_refused_in_a_line(options, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in refusal("sweep", "run", "vem", "--vary", "eta=0:6:3", *options)
    assert list(tmp_path.iterdir()) == []


TABLE = """
[cluster]
kind = "slurm"
jobs = 4
cores = 8
memory = "12 GiB"
walltime = "1-02:00:00"
queue = "long"
interface = "ib0"
worker_ports = "9000:9099"
shared = "/work/flocks"
directives = ["--exclusive"]
prologue = ["module load python/3.12"]
"""


def test_the_job_is_printed_and_nothing_is_done(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FLOCKSCOPE_CACHE", "/work/kernels")
    monkeypatch.setattr("psutil.net_if_addrs", lambda: {"ib0": []})
    (tmp_path / "s.toml").write_text(SMALL + TABLE)
    printed = call("sweep", "run", "s.toml", "--dry-run")
    assert printed.exit_code == 0, printed.stderr
    assert "4 jobs of 8 cores asked of slurm, for 1-02:00:00 each" in printed.stderr
    lines = printed.stdout.splitlines()
    for line in (
        "#SBATCH -p long",
        "#SBATCH --cpus-per-task=8",
        "#SBATCH --mem=12G",
        "#SBATCH -t 1-02:00:00",
        "#SBATCH -o /work/flocks/logs/flockscope-%j.log",
        "#SBATCH --exclusive",
        "export FLOCKSCOPE_CACHE=/work/kernels",
        "module load python/3.12",
    ):
        assert line in lines
    for words in (
        "--nthreads 8",
        "--lifetime 93300s --lifetime-stagger 120s",
        "--worker-port 9000:9099 --nanny-port 9000:9099",
        "--interface ib0",
        "--tls-key /work/flocks/keys-XXXX/key.pem",
    ):
        assert words in lines[-1]
    changed = call("sweep", "run", "s.toml", "--dry-run", "--cluster", "pbs", "--queue", "short")
    lines = changed.stdout.splitlines()
    assert "#PBS -q short" in lines
    assert "#PBS -l walltime=26:00:00" in lines
    assert "#PBS -l select=1:ncpus=8:mem=12GB" in lines
    assert [path.name for path in tmp_path.iterdir()] == ["s.toml"]


def test_a_table_that_cannot_be_is_refused_with_its_line(tmp_path):
    text = SMALL + TABLE.replace("cores = 8", "cores = 0")
    line = text.splitlines().index("cores = 0") + 1
    said = f"cluster.cores: a number >= 1 is needed .*s.toml, line {line}"
    with pytest.raises(InputError, match=said):
        read(tmp_path, text=text)


def test_without_the_extra_a_line_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("worlds.plug_ins.find_spec", lambda _: None)
    asked = ("vem", "--vary", "eta=0:6:3", "--cluster", "slurm", "--dry-run")
    assert "install the extra cluster" in refusal("sweep", "run", *asked)


@pytest.mark.parametrize("walltime", ["00:05:00", "01:00:00", "7-00:00:00"])
def test_workers_end_before_their_job(walltime):
    cluster = Cluster(walltime=walltime)
    lifetime, stagger = cluster.lifetime
    assert 0.7 * cluster.seconds < lifetime - stagger
    assert lifetime + stagger <= cluster.seconds - 30


def test_two_interrupts_while_a_cluster_opens_say_once_how_to_go_on(tmp_path):
    (tmp_path / "s.toml").write_text(LARGE)
    asked = ("sweep", "run", tmp_path / "s.toml", "--out", tmp_path / "out", "--cluster", "local")
    process = start(*asked, "--workers", "2")
    opening = psutil.Process(process.pid)
    wait_until(opening.children, process)  # Dask begins its workers
    begun = opening.children(recursive=True)
    process.send_signal(signal.SIGINT)
    said = [next(line for line in process.stderr if "stopped" in line)]
    process.send_signal(signal.SIGINT)
    said += process.communicate(timeout=60)[1].splitlines()
    # A worker that was just beginning may say that its parent is gone; we say one line.
    said = [line for line in said if line.startswith("flockscope:")]
    assert len(said) == 1, said
    assert "finished runs are in" in said[0]
    assert process.returncode in (130, -signal.SIGINT)  # it may be as good as over
    assert psutil.wait_procs(begun, timeout=60)[1] == []
