"""Which cluster makes the runs, and what is asked of its queue: the table [cluster] of a sweep."""

from __future__ import annotations

import re
from typing import Literal

from pydantic import Field, field_validator, model_validator

from app.strict_table import StrictTable

KINDS = "local, dask:ADDRESS, slurm or pbs"
QUEUES = ("slurm", "pbs")
ADDRESS = re.compile(r"dask:(?:(?:tcp|tls)://)?(?:[\w.-]+|\[[0-9a-fA-F:]+\]):[0-9]{1,5}")
WALLTIME = re.compile(r"(?:([0-9]{1,3})-)?([0-9]{1,4}):([0-5]?[0-9]):([0-5]?[0-9])")
MEMORY = re.compile(r"([0-9]{1,9}(?:\.[0-9]{1,3})?) ?(MB|GB|TB|MiB|GiB|TiB)")
NAME = re.compile(r"[A-Za-z0-9_][\w.@:,+-]{0,99}")
LEAST_WALLTIME = 300
BYTES = {"MB": 10**6, "GB": 10**9, "TB": 10**12, "MiB": 2**20, "GiB": 2**30, "TiB": 2**40}
LEAST_MEMORY = 256 * 2**20


class Cluster(StrictTable):
    """A cluster, and the jobs that are asked of its queue."""

    kind: str = ""
    """local, dask:ADDRESS, slurm or pbs; empty: this machine without Dask."""
    jobs: int = Field(default=1, ge=1, le=10_000)
    cores: int = Field(default=1, ge=1, le=1024)
    """Cores of a job, each of which makes a run at a time."""
    memory: str = ""
    """Of a job; by default 1 GB for each core and 1 GB more."""
    walltime: str = "01:00:00"
    queue: str = ""
    """SLURM's partition, the queue of PBS."""
    account: str = ""
    interface: str = Field(default="", max_length=40)
    """The network between this machine and the nodes, such as ib0."""
    port: int = Field(default=0, ge=0, le=65535)
    """The port of the scheduler on this machine; 0: any that is free."""
    worker_ports: str = ""
    """Ports of the nodes, FROM:TO; empty: any that is free."""
    shared: str = ""
    """A folder that this machine and the nodes see, for keys and logs; by default in the home."""
    scratch: str = ""
    """A folder on the disk of each node."""
    directives: list[str] = Field(default_factory=list, max_length=100)
    """More options of the queue, such as --exclusive."""
    prologue: list[str] = Field(default_factory=list, max_length=100)
    """Lines of the shell that come first in a job, such as module load python."""

    @field_validator("kind")
    @classmethod
    def _is_known(cls, value: str) -> str:
        if value and value not in ("local", *QUEUES) and not ADDRESS.fullmatch(value):
            raise ValueError(f"{value!r} is not {KINDS}, where ADDRESS is HOST:PORT")
        if value.startswith("dask:") and not 0 < int(value.rpartition(":")[2]) < 65536:
            raise ValueError(f"{value!r}: a port is 1 to 65535")
        return value

    @field_validator("walltime")
    @classmethod
    def _is_time(cls, value: str) -> str:
        if seconds_of(value) < LEAST_WALLTIME:
            raise ValueError(f"{value!r} is too short: five minutes, 00:05:00, are needed")
        return value

    @field_validator("memory")
    @classmethod
    def _is_memory(cls, value: str) -> str:
        if value and bytes_of(value) < LEAST_MEMORY:
            raise ValueError(f"{value!r} is too little: 256 MiB are needed")
        return value

    @field_validator("queue", "account", "interface")
    @classmethod
    def _is_name(cls, value: str) -> str:
        if value and not NAME.fullmatch(value):
            raise ValueError(f"{value!r} is not a name")
        return value

    @field_validator("worker_ports")
    @classmethod
    def _are_ports(cls, value: str) -> str:
        first, _, last = value.partition(":")
        if value and not (
            first.isdecimal() and last.isdecimal() and 0 < int(first) < int(last) < 65536
        ):
            raise ValueError(f"{value!r} is not FROM:TO, two ports")
        return value

    @field_validator("shared", "scratch")
    @classmethod
    def _is_folder(cls, value: str) -> str:
        if not value.isprintable() or (value and not re.fullmatch(r"[\w./~$ +@-]+", value)):
            raise ValueError(f"{value!r} is not a folder that a job can name")
        return value

    @field_validator("directives", "prologue")
    @classmethod
    def _are_lines(cls, value: list[str]) -> list[str]:
        for line in value:
            if not line.strip() or not line.isprintable():
                raise ValueError(f"{line!r} is not a line")
        return value

    @model_validator(mode="after")
    def _has_ports(self) -> Cluster:
        if self.worker_ports:
            first, last = map(int, self.worker_ports.split(":"))
            if last - first < 2:
                raise ValueError("worker_ports: a job needs two ports, better ten")
        return self

    @property
    def queued(self) -> Literal["slurm", "pbs"] | None:
        """Its queue, if it has one."""
        return self.kind if self.kind in QUEUES else None  # type: ignore[return-value]

    @property
    def address(self) -> str:
        """Where the scheduler of a running Dask listens; empty for others."""
        location = self.kind.removeprefix("dask:") if self.kind.startswith("dask:") else ""
        return location if not location or "://" in location else f"tcp://{location}"

    @property
    def bytes(self) -> int:
        """Memory of a job."""
        return bytes_of(self.memory) if self.memory else (self.cores + 1) * 10**9

    @property
    def seconds(self) -> int:
        """What a job may last."""
        return seconds_of(self.walltime)

    @property
    def lifetime(self) -> tuple[int, int]:
        """Seconds after which a worker ends by itself, and by how much that differs among them.

        A job has lasted some seconds already when its worker begins to count.
        """
        margin = max(60, min(300, self.seconds // 12))
        return self.seconds - margin, 2 * margin // 5


def seconds_of(walltime: str) -> int:
    """Seconds of a walltime. Raises ValueError for what is none.

    >>> seconds_of("01:30:00"), seconds_of("2-00:00:00")
    (5400, 172800)
    """
    match = WALLTIME.fullmatch(walltime)
    if match is None:
        raise ValueError(f"{walltime!r} is not HH:MM:SS or D-HH:MM:SS")
    days, hours, minutes, seconds = (int(part or 0) for part in match.groups())
    return ((24 * days + hours) * 60 + minutes) * 60 + seconds


def bytes_of(memory: str) -> int:
    """Bytes of a memory. Raises ValueError for what is none.

    >>> bytes_of("1.5 GB"), bytes_of("2GiB")
    (1500000000, 2147483648)
    """
    match = MEMORY.fullmatch(memory)
    if match is None:
        raise ValueError(f"{memory!r} is not a number of MB, GB, TB, MiB, GiB or TiB")
    return int(float(match[1]) * BYTES[match[2]])
