"""Runs on threads of this process, as kernels free the GIL; processes take over once these pay.

To begin a process costs as much as a thousand short runs: it imports, and loads what is compiled.
So the first runs are made here, which shows what a run costs. Only code of flockscope's own may run
so: nothing could stop code of others, or outlive its crash.
"""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import ExitStack, suppress
from typing import Any

from app.studies.runs.database import Outcome
from app.studies.workers import run_worker
from app.studies.workers.process_executor import BEAT, ProcessExecutor
from app.studies.workers.run_executors import Beat, Keep, Task

START = 1.5
"""Seconds of a core that a process takes to begin: `benchmarks/studies/short_runs.py` measures
it."""
SHARE = 0.1
"""Processes begin where their start is at most this share of all the work."""
TRIAL = 1.0
"""Seconds of a core after which what runs have cost so far says what the others will."""
GRACE = 1.0
"""Seconds to wait at the end for threads whose runs are not wanted any more."""
Report = list[tuple[Task, Outcome]]


class ThreadExecutor:
    """So many threads of this process; what they have not begun goes to processes that pay.

    `begin_processes` makes these. `expected`: seconds of a core that all runs are thought to take,
    0 where nobody knows. Leaving it waits a moment for runs under way, which nobody takes.
    """

    def __init__(
        self,
        job: Any,
        workers: int,
        begin_processes: Callable[[], ProcessExecutor],
        expected: float = 0.0,
    ):
        self.job, self.workers, self.begin_processes = job, workers, begin_processes
        self.is_dear = workers * START <= SHARE * expected
        self.processes: ProcessExecutor | None = None
        self.stack = ExitStack()
        self.stopped = threading.Event()
        self.threads: list[threading.Thread] = []
        self.count = 0
        """Runs that are over."""
        self.since = time.process_time()

    def __enter__(self) -> ThreadExecutor:
        self.job.prepare()
        return self

    def __exit__(self, *_: object) -> None:
        self.stopped.set()
        self.stack.close()
        late = time.monotonic() + GRACE
        for thread in self.threads:
            thread.join(max(0.0, late - time.monotonic()))

    def run(self, tasks: Iterable[Task], keep: Keep, beat: Beat = lambda: False) -> bool:
        """Make the runs, begun in their order; False if `beat` wanted them stopped.

        `keep` receives each in the calling thread.
        """
        ahead = deque(tasks)
        if self.is_dear:
            return self.run_in_processes(ahead, keep, beat)
        reports: queue.SimpleQueue[Report] = queue.SimpleQueue()
        left, beaten = len(ahead), time.monotonic()
        self.threads = [
            threading.Thread(target=self.make_runs, args=(ahead, reports), daemon=True)
            for _ in range(min(self.workers, left))
        ]
        for thread in self.threads:
            thread.start()

        def take_reports(seconds: float) -> None:
            nonlocal left
            with suppress(queue.Empty):
                report = reports.get(timeout=seconds)
                while True:
                    for task, outcome in report:
                        left -= 1
                        self.count += 1
                        keep(task, outcome)
                    report = reports.get_nowait()

        def take_and_beat() -> bool:
            take_reports(0.0)
            return beat()

        while left:
            if not any(thread.is_alive() for thread in self.threads) and reports.empty():
                raise RuntimeError(f"{left} runs are lost: the threads that made them have ended")
            take_reports(BEAT)
            if ahead and self.is_worth_processes(len(ahead)):
                self.is_dear = True
                remaining = take_all(ahead)
                left -= len(remaining)
                if not self.run_in_processes(remaining, keep, take_and_beat):
                    return False
            if time.monotonic() - beaten >= BEAT:
                beaten = time.monotonic()
                if beat():
                    return False
        return True

    def run_in_processes(self, tasks: deque[Task], keep: Keep, beat: Beat) -> bool:
        """Make the runs in processes, which begin with the first of them."""
        if self.processes is None:
            self.processes = self.stack.enter_context(self.begin_processes())
        return self.processes.run(tasks, keep, beat)

    def is_worth_processes(self, ahead: int) -> bool:
        """Whether the start of processes is hardly seen in what runs cost, those ahead as others.

        By seconds of a core: by the clock everything is long where others keep the machine busy.
        """
        spent = time.process_time() - self.since
        each = spent / (self.count + len(self.threads))  # each thread is at one
        return spent >= TRIAL and self.workers * START <= SHARE * (spent + ahead * each)

    def make_runs(self, ahead: deque[Task], reports: queue.SimpleQueue[Report]) -> None:
        """What a thread does: one run after the other, reported some at a time."""
        run_worker.STOPPED.event = self.stopped
        done: Report = []
        reported = time.monotonic()
        try:
            with suppress(IndexError, run_worker.RunStoppedError):
                while not self.stopped.is_set():
                    task = ahead.popleft()  # atomic: threads need no lock to share a deque
                    done.append((task, run_worker.make_run(self.job, task.payload, task.seed)))
                    if time.monotonic() - reported >= run_worker.REPORTS:
                        reports.put(done)
                        done, reported = [], time.monotonic()
        finally:
            reports.put(done)


def take_all(tasks: deque[Task]) -> deque[Task]:
    """What is ahead, which no thread then begins any more."""
    taken: deque[Task] = deque()
    with suppress(IndexError):
        while True:
            taken.append(tasks.popleft())
    return taken
