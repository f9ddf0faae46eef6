"""Opening a cluster: on this machine, one that runs, or jobs of a queue; and closing it."""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import platform
import threading
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import platformdirs
from distributed import Reschedule, Worker, get_worker
from distributed.core import Status

from agents.spec import versions
from agents.strips.tls_cluster import TlsScheduler, TlsWorker, local_cluster, silence_dask
from app.studies.cluster.cluster_options import Cluster
from app.studies.runs.database import Outcome
from app.studies.workers.process_executor import ProcessExecutor
from app.studies.workers.run_executors import Task
from worlds.input_error import InputError
from worlds.plug_ins import demand

if TYPE_CHECKING:
    from distributed import Client, Security

# On a worker of Dask: the runs of a chunk are made in a process that stays beside the worker.
#
# So a run that kills its process does no harm to the worker, and one that holds the interpreter
# does not keep the worker from telling that it lives.

TIMEOUT = 30.0
"""Seconds after which a process that is asked for nothing ends."""
IDLE: dict[str, list[ProcessExecutor]] = {}
"""Processes that wait for the next chunk, by the job that they are for."""
LOCK = threading.Lock()
"""Of `IDLE`: a worker of Dask may make several chunks at once, each on a thread."""


def make(beginning: bytes, chunk: bytes, limit: float | None, like: dict[str, str]) -> bytes:
    """Make the runs of a chunk: payloads and seeds in, how each ended out, all pickled.

    Raises InputError where no run can be made, or versions are not `like` those of the parent.
    """
    demand_like(like)
    worker = get_worker()
    task_name = worker.get_current_task()
    job = hashlib.sha256(beginning).hexdigest()
    tasks = [Task(place, seed, run) for place, (run, seed) in enumerate(pickle.loads(chunk))]
    outcomes: dict[int, Outcome] = {}

    def keep(task: Task, outcome: Outcome) -> None:
        outcomes[task.cell] = outcome

    processes = take_worker(job, beginning, limit)
    is_complete = False
    try:
        is_complete = processes.run(tasks, keep, lambda: is_unwanted(worker, task_name))
    except InputError as refusal:
        raise InputError(f"{refusal} (a worker on {platform.node()})") from None
    finally:
        if not is_complete:
            processes.__exit__()
    if not is_complete:
        raise Reschedule  # whoever still waits for it has it made elsewhere
    with LOCK:
        IDLE.setdefault(job, []).append(processes)
    return pickle.dumps([outcomes[place] for place in sorted(outcomes)], -1)


def demand_like(like: Mapping[str, str]) -> None:
    """Refuse to make runs that might give other numbers. Raises InputError."""
    own = versions()
    unlike = [f"{name} {own.get(name)}, not {value}" for name, value in like.items()
              if own.get(name) != value]  # fmt: skip
    if unlike:
        raise InputError(
            f"a worker on {platform.node()} has {', '.join(unlike)} as here: its runs might differ"
        )


def is_unwanted(worker: Worker, chunk: Any) -> bool:
    """Whether nobody waits for a chunk any more, or the worker is about to end."""
    task = worker.state.tasks.get(chunk)
    ending = worker.status not in (Status.running, Status.paused)
    return ending or task is None or task.state == "cancelled"


def take_worker(job: str, beginning: bytes, limit: float | None) -> ProcessExecutor:
    """A process that waits for work of this job, or a new one; those of other jobs are let go."""
    with LOCK:
        for other in IDLE.keys() - {job}:
            for processes in IDLE.pop(other):
                processes.__exit__()
        if IDLE.get(job):
            return IDLE[job].pop()
    return ProcessExecutor(pickle.loads(beginning), 1, limit=limit, timeout=TIMEOUT)


EXTRA = "cluster"
CONNECT = 10.0
"""Seconds to wait for a scheduler that runs."""
FAILURES = 1
"""Workers that may die of a chunk before it is halved, but for one."""
JOB = "flockscope"
KEYS = {"cert.pem": "tls_client_cert", "key.pem": "tls_client_key"}
"""Files of the keys, and what they are of Security's; all roles have the same."""
SETTINGS = {
    "distributed.scheduler.allowed-failures": FAILURES,
    "distributed.comm.timeouts.connect": "30s",
}


@dataclass
class ClusterConnection:
    """A client of a cluster, and the queue behind it if there is one."""

    client: Client
    queue: Any = None
    faults: list[str] = field(default_factory=list)
    """What the queue has said when it took no job."""
    jobs: int = 0

    def renew(self) -> None:
        """Ask the queue again for jobs that have ended. Raises InputError if it takes none."""
        if self.queue is None:
            return
        if self.faults:
            raise InputError(f"the queue takes no job: {self.faults[0]}")
        self.queue.scale(jobs=self.jobs)


def demand_packages(cluster: Cluster) -> None:
    """Refuse with one line what needs a package that is not installed."""
    demand("distributed", f"--cluster {cluster.kind}", EXTRA)
    if cluster.queued:
        demand("dask_jobqueue", f"--cluster {cluster.kind}", EXTRA)
    if not cluster.address:
        demand("cryptography", f"--cluster {cluster.kind}", EXTRA)


@contextmanager
def open_cluster(cluster: Cluster, workers: int) -> Iterator[ClusterConnection]:
    """A cluster with a client of it; what was begun for it ends with it. Raises InputError."""
    demand_packages(cluster)
    import dask
    from distributed import Client, Security

    silence_dask()
    with ExitStack() as stack:
        stack.enter_context(dask.config.set(SETTINGS))
        connection = ClusterConnection(client=None)  # type: ignore[arg-type]
        security: Security | None = None
        where: Any = cluster.address
        if cluster.kind == "local":
            security = Security.temporary()
            where = local_cluster(workers, security)
        elif cluster.queued:
            security = stack.enter_context(keys(shared_folder(cluster)))
            where = connection.queue = queue_of(cluster, security, connection.faults)
            connection.jobs = cluster.jobs
        if not cluster.address:
            stack.enter_context(closing(where))
        connection.renew()
        try:
            connection.client = Client(
                where, timeout=CONNECT, set_as_default=False, security=security
            )
        except (OSError, TimeoutError):
            raise InputError(f"no scheduler of Dask answers at {cluster.address}") from None
        stack.enter_context(connection.client)
        yield connection


def queue_of(cluster: Cluster, security: Security, faults: list[str]) -> Any:
    """Dask's cluster of jobs of a queue, whose scheduler is in this process."""
    import dask_jobqueue
    from distributed.deploy.spec import ProcessInterface

    kind = {"slurm": "SLURMCluster", "pbs": "PBSCluster"}[cluster.queued or ""]
    base = getattr(dask_jobqueue, kind)

    class Job(base.job_cls):  # type: ignore[name-defined]
        """A job that keeps what the queue says when it does not take it."""

        async def start(self) -> None:
            try:
                await super().start()
            except (RuntimeError, OSError, ValueError) as error:
                words = str(error).rpartition("stderr:")[2].split()
                faults.append(f"{self.submit_command}: {' '.join(words)}")
                await ProcessInterface.start(self)

    return base(job_cls=Job, scheduler_cls=TlsScheduler, **arguments(cluster, security))


def arguments(cluster: Cluster, security: Security) -> dict[str, Any]:
    """What dask-jobqueue is told of a cluster."""

    lifetime, stagger = cluster.lifetime
    logs = log_folder(cluster)
    ports = ["--worker-port", cluster.worker_ports, "--nanny-port", cluster.worker_ports]
    scheduler: dict[str, Any] = {"port": cluster.port, "dashboard": False}
    if cluster.interface:
        scheduler["interface"] = cluster.interface
    days, rest = divmod(cluster.seconds, 86400)
    hours, minutes, seconds = rest // 3600, rest // 60 % 60, rest % 60
    if cluster.queued == "slurm":
        walltime = f"{days}-{hours:02}:{minutes:02}:{seconds:02}" if days else cluster.walltime
        written = [f"-o {logs}/{JOB}-%j.log"]
    else:
        walltime = f"{24 * days + hours:02}:{minutes:02}:{seconds:02}"
        written = ["-j oe", f"-o {logs}/"]
    return {
        "queue": cluster.queue or None,
        "account": cluster.account or None,
        "cores": cluster.cores,
        "processes": 1,
        "memory": f"{cluster.bytes}B",
        "walltime": walltime,
        "interface": cluster.interface or None,
        "local_directory": cluster.scratch or None,
        "job_name": JOB,
        "job_extra_directives": [*written, *cluster.directives],
        "job_script_prologue": [*environment(), *cluster.prologue],
        "worker_extra_args": [
            *("--lifetime", f"{lifetime}s", "--lifetime-stagger", f"{stagger}s"),
            *(ports if cluster.worker_ports else ()),
            "--no-dashboard",
            *("--worker-class", f"{TlsWorker.__module__}.{TlsWorker.__name__}"),
        ],
        "scheduler_options": scheduler,
        "security": security,
        "silence_logs": logging.CRITICAL,
    }


def environment() -> list[str]:
    """Lines that give jobs the folder of compiled kernels, where this process was given one."""
    import shlex

    cache = os.environ.get("FLOCKSCOPE_CACHE")
    return [f"export FLOCKSCOPE_CACHE={shlex.quote(str(Path(cache).absolute()))}"] if cache else []


def shared_folder(cluster: Cluster) -> Path:
    """The folder that this machine and the nodes see."""
    own = platformdirs.user_data_path("flockscope") / "cluster"
    return (
        Path(os.path.expandvars(cluster.shared)).expanduser().absolute() if cluster.shared else own
    )


def log_folder(cluster: Cluster) -> Path:
    """Where jobs write what happens to them."""
    return shared_folder(cluster) / "logs"


def make_security(folder: Path) -> Security:
    """The keys in a folder: who has none of them sends no work, and reads none."""
    from distributed import Security

    cert, key = str(folder / "cert.pem"), str(folder / "key.pem")
    roles = {
        f"tls_{role}_{part}": path
        for role in ("client", "scheduler", "worker")
        for part, path in (("cert", cert), ("key", key))
    }
    return Security(require_encryption=True, tls_ca_file=cert, **roles)


@contextmanager
def keys(folder: Path) -> Iterator[Security]:
    """Fresh keys, which only their owner can read, until it is left. Raises InputError."""
    from distributed import Security

    security = Security.temporary()
    try:
        (folder / "logs").mkdir(parents=True, exist_ok=True)
        place = TemporaryDirectory(prefix="keys-", dir=folder)
        for name, part in KEYS.items():
            path = Path(place.name) / name
            path.touch(mode=0o600)
            path.write_text(getattr(security, part))
    except OSError as error:
        raise InputError(f"{str(folder)!r} cannot be written: {error.strerror or error}") from None
    try:
        yield make_security(Path(place.name))
    finally:
        with suppress(OSError):
            place.cleanup()


def job_script(cluster: Cluster) -> str:
    """The job that the queue would be asked for; nothing is begun, and nothing written."""
    demand_packages(cluster)
    import dask_jobqueue

    job = {"slurm": dask_jobqueue.slurm.SLURMJob, "pbs": dask_jobqueue.pbs.PBSJob}[
        cluster.queued or ""
    ]
    options = arguments(cluster, make_security(shared_folder(cluster) / "keys-XXXX"))
    for name in ("scheduler_options", "silence_logs"):
        options.pop(name)
    host, port = "THIS-MACHINE", cluster.port or "PORT"
    return str(job(f"tls://{host}:{port}", name=f"{JOB}-0", **options).job_script())
