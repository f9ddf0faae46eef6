"""Runs on all cores: the longest first, one thread each, because compiled ticks free the GIL."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed

from app.experiments.kinds import Settings
from app.experiments.trial import Result, Stopped, Trial, run_trial


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_all(
    trials: Sequence[Trial],
    settings: Settings,
    workers: int,
    keep: Callable[[Trial, list[Result]], None],
) -> None:
    """Run the trials in their order; `keep` receives the results of each in the calling thread.

    On KeyboardInterrupt, or if `keep` fails, the runs under way stop at their next chunk, what was
    finished is kept, and the exception goes on.
    """
    stop = threading.Event()
    with ThreadPoolExecutor(workers) as pool:
        futures = {pool.submit(run_trial, trial, settings, stop): trial for trial in trials}
        try:
            for future in as_completed(futures):
                keep(futures.pop(future), future.result())
        except KeyboardInterrupt:
            halt(pool, stop)
            keep_finished(futures, keep)
            raise
        except BaseException:
            halt(pool, stop)
            raise


def halt(pool: ThreadPoolExecutor, stop: threading.Event) -> None:
    """Stop what runs and forget what waits."""
    stop.set()
    pool.shutdown(wait=True, cancel_futures=True)


def keep_finished(
    futures: dict[Future[list[Result]], Trial], keep: Callable[[Trial, list[Result]], None]
) -> None:
    """Keep what was finished while the pool was stopped."""
    for future, trial in futures.items():
        if future.cancelled() or isinstance(future.exception(), Stopped):
            continue
        keep(trial, future.result())
