"""Compiles what a run calls, in a process of its own that fills the cache on disk.

So the page stays smooth meanwhile. The process ends when its work is done, when it is closed, and
when the process that began it is gone; what it was about to compile is then as if never begun.
"""

from __future__ import annotations

import pickle
import subprocess
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass

from agents.catalogue import FILES, from_file
from agents.engine.cache import cache_base
from agents.flock import Flock
from agents.spec import Spec
from app.processes import ChildError, ChildProcess, ProcessLostError
from app.studies.workers.kernels import compile_measures, single_agent_spec
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.frame_builder import FrameRequest
from worlds.input_error import InputError
from worlds.owned_files import read_owned, write_owned

USUAL = 15.0
"""What one model takes where nothing is known of it on this machine, s."""


@dataclass(frozen=True)
class CompileEstimate:
    """How long a compile may take."""

    began: float
    """When, by `time.monotonic`, s."""
    expected: float
    """What it took last on this machine, s; or what is usual."""
    known: bool
    """Whether it was ever measured here."""

    def share(self, now: float) -> float:
        """How much of it is done, in [0, 1]."""
        return min(1.0, (now - self.began) / self.expected)

    def describe(self, now: float) -> str:
        """How much longer it may take, for people.

        >>> later = CompileEstimate(0.0, 8.0, True)
        >>> later.describe(3.2), later.describe(9.0)
        ('about 5 s more', 'any moment now')
        >>> first = CompileEstimate(0.0, 15.0, False)
        >>> first.describe(1.0), first.describe(16.0)
        ('usually some 15 s', 'longer than usual')
        """
        left = self.expected - (now - self.began)
        if self.known:
            return f"about {left:.0f} s more" if left > 0.5 else "any moment now"
        return f"usually some {self.expected:.0f} s" if left > 0.0 else "longer than usual"


class KernelCompiler:
    """Compiles what runs of some flocks call; `ready` is done once it is at hand in this process.

    Where the process cannot do it, as without a cache on disk, a thread of this one does. Refusals
    of a model's author become the exception of `ready`.
    """

    def __init__(self, flocks: Sequence[Flock]):
        self.kernels = frozenset(kernel(flock) for flock in flocks)
        self.kept = all(
            module.advance.lock is not None for flock in flocks for module in flock.modules
        )
        """Whether there is a cache on disk that the process could fill."""
        self.specs = [single_agent_spec(flock) for flock in flocks]
        self.kinds = [kind(flock) for flock in flocks]
        self.estimate = estimate_compilation(self.kinds)
        self.ready: Future[None] = Future()
        self.closed = False
        self.child: ChildProcess | None = None
        threading.Thread(target=self.wait_for_process, name="compiling", daemon=True).start()

    def covers(self, flocks: Sequence[Flock]) -> bool:
        """Whether what these flocks need is under way, or done."""
        failed = self.ready.done() and self.ready.exception() is not None
        return not (self.closed or failed) and self.kernels.issuperset(map(kernel, flocks))

    def close(self) -> None:
        """End the process."""
        self.closed = True
        if self.child is not None:
            self.child.end(0.0)

    def wait_for_process(self) -> None:
        """On a thread of its own: wait for the process, and take over what it has compiled."""
        try:
            if self.kept:
                self.demand()
            if self.closed:
                return
            for spec in self.specs:
                call_all(Flock(spec))
            remember(self.kinds, time.monotonic() - self.estimate.began)
            self.ready.set_result(None)
        except Exception as error:
            self.ready.set_exception(error)
        if self.child is not None:
            self.child.end(None)

    def demand(self) -> None:
        """Have the process compile. Raises what the author of a model is to be told."""
        with suppress(pickle.PickleError, ChildError, ProcessLostError):
            files = [str(file) for file in FILES.values()]
            self.child = ChildProcess(CompileWorker, files, self.specs, stderr=subprocess.DEVNULL)
            if self.closed:
                self.child.end(0.0)
            self.child.ask("compile_run").result()
            self.child.ask("compile_rest")


class CompileWorker:
    """In the process that compiles: knows files of rules, and compiles what flocks call."""

    def __init__(self, files: Sequence[str], specs: Sequence[Spec]):
        for path in files:
            from_file(path)
        self.flocks = [Flock(spec) for spec in specs]

    def compile_run(self) -> None:
        """Compile what a run calls. Raises InputError."""
        for flock in self.flocks:
            call_all(flock)

    def compile_rest(self) -> None:
        """Compile what may be measured, too."""
        for flock in self.flocks:
            flock.warm()
            compile_measures(flock)


def call_all(flock: Flock) -> None:
    """Call all that a run in the laboratory calls: it is compiled, or taken from the cache."""
    run = FlockRun(flock, 0, FrameRequest())
    run.advance(1)
    run.look(closely=True)


def kernel(flock: Flock) -> str:
    """The names of a flock's compiled loops: others for other functions or values in them."""
    return " ".join(module.__name__ for module in flock.modules)


def kind(flock: Flock) -> str:
    """What the time to compile is kept under: it goes by the model, its space and its turns."""
    solid = "-solid" if flock.world.is_solid else ""
    acts = "delayed" if flock.options.is_late else flock.options.activation
    names = [flock.model.name, *(one.model.name for one in flock.kind_models)]
    return f"{'+'.join(dict.fromkeys(names))}-{flock.world.dim}d{solid}-{acts}"


def estimate_compilation(kinds: Sequence[str]) -> CompileEstimate:
    """How long it may take to compile all of these, from now on."""
    times = [last_duration(kind) for kind in kinds]
    expected = sum(USUAL if seconds is None else seconds for seconds in times)
    return CompileEstimate(time.monotonic(), expected, None not in times)


def last_duration(kind: str) -> float | None:
    """What it took last to compile this on this machine, s; None if that is not known."""
    try:
        return float(read_owned(cache_base(), "seconds", kind))
    except (OSError, ValueError):
        return None


def remember(kinds: Sequence[str], seconds: float) -> None:
    """Keep what it took to compile these, shared out evenly, beside the cache, if that can be."""
    each = f"{max(seconds, 0.1) / len(kinds):.1f}"
    with suppress(OSError):
        for kind in kinds:
            write_owned(each.encode(), cache_base(), "seconds", kind)


# What moves on the page until a run is compiled: the same run as plain Python.

FIRST, FEWEST, GROWTH = 32, 4, 8
"""Agents that a preview is tried with first, those without which it is none, and the factor by
which it is tried with more."""
GOAL = 0.25
"""CPU time that a tick of a preview may take, s: more agents would move too seldom."""
SLOWEST, OFTEN = 0.4, 3
"""CPU time of a tick that is too long, s, as commands wait for it; and after how many such ticks a
preview rather stands."""
LOOKS = 100
"""Times that the curves are measured on the way to where the preview is."""


def preview_size(agents: int, tick_time: Callable[[int], float]) -> int:
    """How many of so many agents move at a fair pace in plain Python; 0 if not even a few do.

    `tick_time` measures what a tick of some agents takes, s of CPU.

    >>> preview_size(1001, lambda agents: agents * 1e-4), preview_size(9, lambda _: 7.0)
    (1001, 0)
    >>> preview_size(50_000, lambda agents: agents * 1e-4 + agents**2 * 1e-7)
    1191
    """
    size = min(agents, FIRST)
    seconds = tick_time(size)
    while size < agents and seconds < 0.6 * GOAL:
        # A tick takes longer by the number of agents, and of the neighbours of each.
        more = min(GROWTH, (GOAL / max(seconds, 1e-9)) ** 0.75)
        size = min(agents, int(size * more))
        seconds = tick_time(size)
    if seconds > SLOWEST:
        size = int(size * (GOAL / seconds) ** 0.75)
    return size if size >= min(agents, FEWEST) else 0


class Preview:
    """What a preview leaves to the compiled run, which repeats it from tick 0 and takes over."""

    def __init__(self, coming: FlockRun):
        self.coming = coming
        """The compiled run, at tick 0."""
        self.changes: list[tuple[int, Callable[[FlockRun], None]]] = []
        """What was changed on the way, and at which tick."""
        self.slow = 0
        """Ticks that have taken too long, one after the other."""

    @property
    def is_too_slow(self) -> bool:
        """Whether it is too slow to go on."""
        return self.slow >= OFTEN

    def note_tick(self, seconds: float) -> None:
        """Note what a tick has taken, s of CPU."""
        self.slow = self.slow + 1 if seconds > SLOWEST else 0

    def advance_compiled(self, run: FlockRun) -> FlockRun:
        """The compiled run, brought to where the preview is."""
        last = run.flock.tick
        for tick, change in self.changes:
            self.run_to(tick, last)
            with suppress(InputError):  # as far as rounding makes it another run
                self.coming.change(change)
        self.run_to(last, last)
        for flock_run, before in zip(self.coming.both, run.both, strict=True):
            flock_run.camera.fastest = before.camera.fastest
        return self.coming

    def run_to(self, until: int, last: int) -> None:
        """Run on to a tick, and look at the curves a few times on the way to the `last`."""
        flock = self.coming.flock
        while flock.tick < until:
            self.coming.advance(min(until - flock.tick, 1 + last // LOOKS))
            for run in self.coming.both:
                run.try_to_look(run.readings.read_cheap)
