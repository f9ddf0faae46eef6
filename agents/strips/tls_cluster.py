"""Dask's cluster of processes of this machine, in which all speak by TLS alone."""

from __future__ import annotations

import atexit
import logging
import multiprocessing
import signal
from contextlib import suppress
from typing import Any

from distributed import Nanny, Scheduler, Security, Worker
from distributed.deploy.spec import SpecCluster, close_clusters


class TlsScheduler(Scheduler):
    """A scheduler that listens by TLS only.

    Dask's own also serves pages and numbers by plain HTTP to whoever asks, dashboard or not.
    """

    def start_http_server(self, *_: Any, **__: Any) -> None:
        """Open no server."""


class TlsWorker(Worker):
    """A worker that listens by TLS only, as its scheduler does."""

    def __init__(self, *arguments: Any, **options: Any):
        if multiprocessing.parent_process() is not None:
            # Ctrl-C is for the process that has begun it, and that ends it.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        super().__init__(*arguments, **options)

    def start_http_server(self, *_: Any, **__: Any) -> None:
        """Open no server."""


def local_cluster(workers: int, security: Security) -> Any:
    """Dask's cluster of processes of this machine, whose scheduler is in this one."""
    options: dict[str, Any] = {"host": "127.0.0.1", "protocol": "tls://", "security": security}
    worker = {
        "cls": Nanny,
        "options": options
        | {
            "worker_class": TlsWorker,
            "nthreads": 1,
            "memory_limit": 1.0 / workers,
            "silence_logs": logging.CRITICAL,
        },
    }
    try:
        return SpecCluster(
            scheduler={"cls": TlsScheduler, "options": options | {"dashboard": False}},
            workers=dict.fromkeys(range(workers), worker),
            worker=worker,
            security=security,
            silence_logs=logging.CRITICAL,
        )
    except KeyboardInterrupt:
        # Dask closes what is left as the interpreter ends: of a cluster that never was open it
        # cannot, waits, and shows a traceback for the next Ctrl-C. Workers end with this process.
        with suppress(Exception):
            close_clusters()
        atexit.unregister(close_clusters)
        raise


def silence_dask() -> None:
    """Keep Dask's own lines, tracebacks among them, off the terminal: what matters is told."""
    for name in [*logging.root.manager.loggerDict, "asyncio"]:
        if name.startswith(("distributed", "dask_jobqueue", "asyncio")):
            logging.getLogger(name).setLevel(logging.CRITICAL)
