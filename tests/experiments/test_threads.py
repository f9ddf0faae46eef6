"""Runs on threads of the calling process: all kept once, stopped at once, handed to processes."""

import os
import threading
from collections import Counter
from dataclasses import dataclass, field

import pytest

from agents import Flock
from agents.catalogue import MODELS, is_built_in
from app.studies.runs.database import Outcome
from app.studies.runs.store_reader import StoreReader
from app.studies.study_runner import StudyRunner
from app.studies.sweeps.sweep_runner import run_sweep
from app.studies.sweeps.sweep_table import as_csv, wide_table
from app.studies.workers import thread_executor
from app.studies.workers.flock_pool import MOST_AGENTS, FlockPool
from app.studies.workers.process_executor import ProcessExecutor
from app.studies.workers.run_executors import Task
from app.studies.workers.run_worker import stop_if_unwanted
from app.studies.workers.thread_executor import ThreadExecutor
from experiments.jobs import Sums
from experiments.test_sweep import SMALL
from experiments.test_sweep_file import read


@dataclass
class Marked:
    """Says on which thread each run is made; a run that waits does so until nobody wants it."""

    begun: threading.Event = field(default_factory=threading.Event)
    names: Counter = field(default_factory=Counter)

    def prepare(self):
        pass

    def run(self, payload, seed):
        self.names[threading.current_thread().name] += 1
        if payload == "raise":
            raise ValueError(f"seed {seed}\nis bad")
        if payload == "wait":
            self.begun.set()
            while True:
                stop_if_unwanted()
        return Outcome("ok", {"sum": seed + 1})


def none():
    pytest.fail("no process is worth it")


def test_each_run_is_kept_once_and_one_that_raises_ends_nothing():
    tasks = [Task(1, seed, "raise" if seed == 3 else None) for seed in range(500)]
    kept = []
    job = Marked()
    with ThreadExecutor(job, 2, none) as threads:
        assert threads.run(tasks[:400], lambda task, outcome: kept.append((task.seed, outcome)))
        assert threads.run(tasks[400:], lambda task, outcome: kept.append((task.seed, outcome)))
        assert threads.run([], lambda *_: None)
    found = dict(kept)
    assert len(kept) == len(found) == 500
    assert found[3].reason == "ValueError: seed 3 is bad"
    assert all(found[seed].values == {"sum": seed + 1} for seed in found if seed != 3)
    assert threading.main_thread().name not in job.names, "an interrupt would wait for its run"


def test_an_interrupt_leaves_no_run_going_on():
    job, threads = Marked(), []

    def interrupt():
        job.begun.wait()
        threads.extend(executor.threads)
        raise KeyboardInterrupt

    tasks = [Task(1, 0, None), Task(1, 1, "wait"), Task(1, 2, "wait")]
    executor = ThreadExecutor(job, 2, none)
    with pytest.raises(KeyboardInterrupt), executor:
        executor.run(tasks, lambda *_: None, interrupt)
    for thread in threads:
        thread.join(60.0)
        assert not thread.is_alive()


def test_it_stops_when_it_is_asked_to():
    job = Marked()
    with ThreadExecutor(job, 1, none) as threads:
        assert not threads.run([Task(1, 0, "wait")], lambda *_: None, job.begun.wait)


@pytest.mark.parametrize("expected", [0.0, 1e9])
def test_processes_take_what_is_ahead_once_they_pay(monkeypatch, expected):
    """Because of what the runs cost, or as that was known before."""
    monkeypatch.setattr(thread_executor, "TRIAL", 0.0)
    monkeypatch.setattr(thread_executor, "START", 0.0)
    made, kept = [], []

    def begin():
        made.append(ProcessExecutor(Sums(), 1))
        return made[-1]

    with ThreadExecutor(Sums(), 1, begin, expected) as threads:
        tasks = [Task(1, seed, "print") for seed in range(20_000)]
        assert threads.run(tasks, lambda task, outcome: kept.append((task.seed, outcome)))
        last = [Task(1, -1, None)]
        assert threads.run(last, lambda task, outcome: kept.append((task.seed, outcome)))
    assert len(made) == 1
    assert sorted(seed for seed, _ in kept) == list(range(-1, 20_000))
    assert all(outcome.values == {"sum": seed + 1} for seed, outcome in kept)


def table(folder):
    return as_csv(wide_table(StoreReader(folder)))


def test_threads_and_processes_make_the_same_table(tmp_path, monkeypatch):
    monkeypatch.setattr(thread_executor, "START", 1e9)
    run_sweep(read(tmp_path, text=SMALL), tmp_path / "threads", workers=2)
    slow = SMALL.replace("ticks = 30", "ticks = 30\ntimeout = 600")
    run_sweep(read(tmp_path, text=slow), tmp_path / "processes", workers=2)
    assert table(tmp_path / "threads") == table(tmp_path / "processes")


@pytest.fixture
def chosen(monkeypatch):
    """What makes the runs of each study that is begun."""
    kinds = []
    begin = StudyRunner.make_executor

    def note(runner):
        executor = begin(runner)
        kinds.append(type(executor).__name__)
        return executor

    monkeypatch.setattr(StudyRunner, "make_executor", note)
    return kinds


@pytest.mark.parametrize(
    ("change", "more", "kind"),
    [
        (("", ""), {}, "ThreadExecutor"),
        (("", ""), {"nice": 1}, "ProcessExecutor"),
        (("ticks = 30", "ticks = 30\ntimeout = 600"), {}, "ProcessExecutor"),
        (('name = "polarisation"', 'measure = "mine.py:m"'), {}, "ProcessExecutor"),
    ],
)
def test_what_could_hang_or_crash_is_made_in_processes(tmp_path, chosen, change, more, kind):
    (tmp_path / "mine.py").write_text("import os\ndef m(flock):\n    return float(os.getpid())\n")
    sweep = read(tmp_path, text=SMALL.replace(*change).replace("count = 4", "count = 1"))
    run_sweep(sweep, tmp_path / "out", workers=1, **more)
    assert set(chosen) == {kind}
    own = wide_table(StoreReader(tmp_path / "out")).get("m", [])
    assert os.getpid() not in own


def test_all_models_are_built_in():
    assert all(map(is_built_in, MODELS))


def test_a_flock_is_begun_again_unless_its_run_has_raised():
    pool, key = FlockPool(), object()
    made = []

    def make():
        made.append(Flock("vem", agents=5, rng=len(made)))
        return made[-1]

    for seed in (0, 7):
        with pool.begin(key, seed, make) as flock:
            flock.run(3)
            assert flock.seed == seed
    assert len(made) == 1
    with pytest.raises(ValueError, match="bad"), pool.begin(key, 1, make):
        raise ValueError("bad")
    with pool.begin(key, 1, make) as flock:
        assert flock is made[1]
    start = {"position": [(1.0, 1.0)], "heading": [(1.0, 0.0)]}
    for _ in range(2):
        with pool.begin(pool, 1, lambda: Flock("vem", start=start, size=4.0)) as flock:
            assert flock.tick == 0
            flock.run(1)
    for count in range(3):
        with pool.begin(str(count), 1, lambda: Flock("vem", agents=MOST_AGENTS // 2, rng=1)):
            pass
    assert len(pool.flocks) == 2
