"""How the simulation stands."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from agents.kinds import NO_KINDS, KindTable
from agents.spec import CompleteSpec, Spec
from app.viewer.run.kernel_compiler import CompileEstimate
from app.viewer.run.stored_flock import InitialState

# That there is something new to draw, told to each of those who draw it.


class ChangeNotifier(threading.Event):
    """An event that sets others too: each of those who wait clears its own.

    >>> news, other = ChangeNotifier(), threading.Event()
    >>> news.tell(other)
    >>> news.set()
    >>> other.is_set()
    True
    """

    def __init__(self) -> None:
        super().__init__()
        self.others: frozenset[threading.Event] = frozenset()

    def tell(self, other: threading.Event) -> None:
        """Set another event as well from now on."""
        self.others |= {other}

    def forget(self, other: threading.Event) -> None:
        """Do so no more."""
        self.others -= {other}

    def set(self) -> None:
        super().set()
        for event in self.others:
            event.set()


@dataclass(frozen=True)
class TimeLineState:
    """The ticks along which a run can be moved, and which of them is shown."""

    first: int
    last: int
    at: int
    looks_back: bool = False
    """Whether it is a tick of a live run that has gone on from there."""
    recording: str = ""
    """The name of the recording that is played; empty: it is a live run."""
    sought: int | None = None
    """The tick that was asked for, where the last one before it that is kept is shown instead."""


@dataclass(frozen=True)
class SimulationState:
    """How the simulation stands; replaced as a whole, never changed."""

    spec: CompleteSpec
    """The run that was set up."""
    beside: Spec | None = None
    """A second model, whose flock flies in the same world from the same start: what it has of its
    own."""
    stored: InitialState | None = None
    """The saved state, recording or flock that it began from."""
    line: TimeLineState | None = None
    """Along which ticks it can be moved."""
    run: int = 0
    """Counts the set-ups."""
    running: bool = False
    busy: bool = False
    """Whether a flock is being set up."""
    compiling: CompileEstimate | None = None
    """How long it may take until what the run calls is compiled; None: it is."""
    preview: bool = False
    """Whether the flock on screen is a preview meanwhile, the same run as plain Python."""
    moving: int = 0
    """Agents on screen: those of a preview may be the first of many."""
    error: str = ""
    """What stopped the run; Setup or Reset mends it."""
    speed: float = 15.0
    """Wanted ticks per second; infinity for as fast as it goes."""
    rate: float = 0.0
    """Ticks per second as they happen."""
    agents: int = 0
    """Rows of the flock, information agents among them."""
    values: dict[str, Any] = field(default_factory=dict)
    """The flock's parameters, name -> value; a distribution where agents differ."""
    beside_values: dict[str, Any] = field(default_factory=dict)
    """Those that only the flock beside it has."""
    kinds: KindTable = NO_KINDS
    """The kinds of agents in the flock, with their parameters and relations as they are now."""
    redrawn: Mapping[tuple[str, bool], int] = field(default_factory=dict)
    """How many agents' numbers were drawn again, out of the range of their parameter: by its name
    and whether it is of the flock beside."""

    @property
    def models(self) -> tuple[str, str | None]:
        """Names of the model and of the one beside it."""
        return self.spec.model, None if self.beside is None else self.beside.model

    def current_specs(self) -> tuple[CompleteSpec, Spec | None]:
        """This run, and what is beside it, with parameters and kinds as they are now."""
        beside, spec = self.beside, self.spec
        if self.values:
            spec = spec.with_parameters(self.values, kinds=self.kinds.kinds, to=self.kinds.to)
        if beside is not None and self.beside_values:
            beside = beside.with_parameters(self.beside_values)
        return spec, beside
