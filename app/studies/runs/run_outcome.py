"""How a run has ended, and what was measured of it."""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np

Status = Literal["ok", "gave-up", "failed", "killed"]
STATUSES: tuple[Status, ...] = get_args(Status)
BROKEN: tuple[Status, ...] = ("failed", "killed")
"""What `--retry-failed` makes again, and what the exit code tells of."""
Number = int | float


class Outcome(NamedTuple):
    """A run that is over; cheap to send from a process to another.

    `ok`: it came to its end. `gave-up`: what it waited for did not come within its ticks.
    `failed`: it raised. `killed`: its process was killed, twice.
    """

    status: Status
    values: dict[str, Number | None] = {}  # noqa: RUF012 - never written to
    """By column of the store; None where the run has none."""
    reason: str = ""
    """Of a run that failed: class and message."""
    seconds: float = 0.0
    ticks: int = 0
    astray: str = ""
    """The first agent that was seen where it cannot be, in words."""
    series: dict[str, tuple[np.ndarray, np.ndarray]] = {}  # noqa: RUF012 - never written to
    """Observables along the run: ticks (K,) int and values (K,) float."""
    rest: tuple[Outcome, ...] = ()
    """Of a run that goes on from cell to cell: what it gave in those after the first."""


def failure(error: BaseException) -> Outcome:
    """The outcome of a run that raised."""
    words = " ".join(str(error).split())
    return Outcome("failed", reason=f"{type(error).__name__}: {words}"[:1000])
