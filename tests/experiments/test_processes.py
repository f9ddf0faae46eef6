"""Runs in processes: order, failures, kills, stopping; none of them loses a run."""

import os
import signal
import threading
import time
from collections import deque

import pytest

from app.studies.runs.database import Outcome
from app.studies.workers.process_executor import ProcessExecutor, RunProcess
from app.studies.workers.run_executors import AwakeClock, Task
from experiments.jobs import Sums
from worlds.input_error import InputError


def carried_out(job, tasks, workers=2, beat=lambda: False):
    kept = []
    with ProcessExecutor(job, workers) as processes:
        whole = processes.run(tasks, lambda task, outcome: kept.append((task, outcome)), beat)
    return kept, whole


def test_each_run_is_kept_once_whatever_happens_to_some(tmp_path):
    payloads = {3: "raise", 5: "kill", 8: "kill once", 11: "print", 12: "kill"}
    tasks = [Task(1, seed, payloads.get(seed)) for seed in range(40)]
    kept, whole = carried_out(Sums(str(tmp_path)), tasks)
    assert whole
    assert sorted(task.seed for task, _ in kept) == list(range(40))
    found = {task.seed: outcome for task, outcome in kept}
    broken = {seed: one.status for seed, one in found.items() if one.status != "ok"}
    assert broken == {3: "failed", 5: "killed", 12: "killed"}
    assert found[3].reason == "ValueError: seed 3 is bad"
    assert found[5].reason == "its process ended twice, with signal SIGKILL"
    assert all(one.values == {"sum": seed + 1} for seed, one in found.items() if seed not in broken)


def test_one_process_keeps_the_order():
    kept, _ = carried_out(Sums(), [Task(1, seed, None) for seed in range(300)], workers=1)
    assert [task.seed for task, _ in kept] == list(range(300))


def test_it_stops_when_it_is_asked_to_and_its_processes_end():
    began = time.monotonic()
    with ProcessExecutor(Sums(), 1) as processes:
        whole = processes.run(
            [Task(1, 0, "sleep")], lambda *_: None, lambda: time.monotonic() - began > 0.5
        )
        [child] = [one.child for one in processes.processes]
    assert not whole
    assert child.pid is None
    assert time.monotonic() - began < 60.0, "it slept to its end"


def test_a_killed_process_is_replaced_and_its_run_made_again():
    kept = []
    with ProcessExecutor(Sums(), 1) as processes:

        def kill():
            while not processes.processes or processes.processes[0].runs_begun < 1:
                time.sleep(0.01)
            os.kill(processes.processes[0].child.pid, signal.SIGKILL)

        def is_begun_again():
            return any(one.waiting and one.waiting[0].tries for one in processes.processes)

        threading.Thread(target=kill).start()
        processes.run(
            [Task(1, 0, "sleep"), *(Task(1, seed, None) for seed in range(1, 20))],
            lambda task, _: kept.append(task),
            lambda: bool(kept) or is_begun_again(),
        )
        assert not kept
        assert len(processes.processes) == 1
        assert processes.processes[0].waiting[0] == Task(1, 0, "sleep", tries=1)


def test_a_job_that_cannot_begin_is_refused():
    with pytest.raises(InputError, match="can start: they end with code 1"):
        carried_out(Sums("nowhere"), [Task(1, 0, None)], workers=1)


def test_a_run_that_hangs_is_killed_and_the_others_are_made():
    tasks = [Task(1, seed, "sleep" if seed == 3 else None) for seed in range(9)]
    kept = []
    with ProcessExecutor(Sums(), 2, limit=1.0) as processes:
        assert processes.run(tasks, lambda task, outcome: kept.append((task.seed, outcome)))
    assert sorted(seed for seed, _ in kept) == list(range(9))
    broken = {seed: (one.status, one.reason) for seed, one in kept if one.status != "ok"}
    assert broken == {3: ("killed", "it took longer than 1 s")}


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="nothing halts a process here")
def test_a_process_that_is_halted_is_told_of_and_replaced_and_a_slow_one_goes_on(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("app.studies.workers.process_executor.SILENT", 6.0)
    payloads = {2: "halt once", 4: "work", 6: "halt"}
    tasks = [Task(1, seed, payloads.get(seed)) for seed in range(9)]
    kept, said = {}, []
    with ProcessExecutor(Sums(str(tmp_path)), 3, tell=said.append) as processes:
        assert processes.run(tasks, lambda task, outcome: kept.update({task.seed: outcome}))
    assert sorted(kept) == list(range(9))
    broken = {seed: (one.status, one.reason) for seed, one in kept.items() if one.status != "ok"}
    assert broken == {6: ("killed", "its process stood still twice, with signal SIGKILL")}
    assert len(said) == 3
    assert sum("the process of cell 1, seed 2 has stood still for " in line for line in said) == 1
    assert sum("the process of cell 1, seed 6 has stood still for " in line for line in said) == 2


def test_a_clock_that_jumps_neither_kills_a_run_nor_makes_it_long():
    """As after a machine has slept for a day while a run was under way."""
    now, kept = [0.0], []
    processes = ProcessExecutor(Sums(), 1, limit=100.0)
    processes.awake = AwakeClock(lambda: now[0])
    process = RunProcess(bytearray(8), deque([Task(1, 0, None)]))
    processes.processes.append(process)
    process.started[0] = 1
    for moment in (0.5, 1.0, 86_401.0, 86_401.5):
        now[0] = moment
        processes.end_late(processes.awake.read())
        assert not process.overran
    report = [Outcome("ok", seconds=86_400.0)]
    processes.take_report(process, report, deque(), lambda _, outcome: kept.append(outcome.seconds))
    assert 1.5 <= kept[0] <= 4.0
    assert processes.seconds < 1.0
