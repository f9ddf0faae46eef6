"""One run: a flock from its set-up to the next, and what is seen of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from agents.engine.cache import is_at_hand
from agents.flock import Flock
from agents.individuals import Distribution
from agents.kinds import KindTable
from agents.models.declare import Parameters
from agents.state.agent_rows import StrayAgents
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.time_series import refuse_too_dense
from app.viewer.run.frame_builder import FrameBuilder, FrameRequest
from app.viewer.run.step_trial import CHANGED, StepTrial
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

# Errors in the words of whoever has to read them.


class ComparedFlockError(RuntimeError):
    """What one of two flocks raised, told with the name of its model."""


class StrayAgentError(Exception):
    """An agent is where it cannot be; the flock runs on."""


def describe_error(error: BaseException) -> str:
    """An error as one line for the user.

    >>> describe_error(IndexError("out of reach")), describe_error(InputError("there is no flock"))
    ('IndexError: out of reach', 'there is no flock')
    """
    if isinstance(error, InputError | ArithmeticError | ComparedFlockError | StrayAgentError):
        return str(error)
    return f"{type(error).__name__}: {error}"


# Keeps the zones around an agent in their order while somebody moves a slider.


def radii(flock: Flock, parameters: Parameters) -> list[float]:
    """Outer radii of the zones of a flock's rule, from the inside out, length."""
    return [zone.radius(parameters) for zone in flock.model.rule.zones]


def are_zones_nested(radii: list[float]) -> bool:
    """Whether no zone ends inside of the one before it."""
    return all(inner <= outer for inner, outer in pairwise(radii))


def nearest_allowed(flock: Flock, name: str, value: Any) -> Any:
    """The value nearest to the wanted one that keeps the zones in order.

    A zone that would pass another one ends where that one does. Zones that are out of order
    already, as a spec may have them, are left alone. Of a distribution it is its centre that keeps
    them: single agents may have a wider zone inside of a narrower one. Raises InputError where no
    value will do.
    """
    if isinstance(value, Distribution):
        return value.about(nearest_allowed(flock, name, value.centre))
    now = flock.parameters
    before = radii(flock, now)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    parameters = now.model_copy(update={name: value})
    if not before or not are_zones_nested(before) or are_zones_nested(radii(flock, parameters)):
        return value
    for other in sorted(before, key=lambda radius: abs(radius - value)):
        if are_zones_nested(radii(flock, now.model_copy(update={name: other}))):
            return other
    raise InputError(f"{name} = {value:g} would put the zones out of order: nothing is changed")


def zone_notice(flock: Flock, name: str, value: Any) -> str:
    """What is told when a zone stops at another one."""
    if isinstance(value, Distribution):
        value = value.centre
    others = (
        f"{zone.name} ends at {value:g}"
        for zone in flock.model.rule.zones
        if zone.radius(flock.parameters) == value
    )
    return f"{name} stops at {value:g}: {', '.join(others)}, and zones keep their order"


class FlockRun:
    """A flock, its readings and the frames taken of it."""

    second: FlockRun | None = None
    """The run of the flock beside it, if there is one: see `beside.Pair`."""
    measures: bool = True
    """Whether it is measured; a preview is only looked at."""
    trial: StepTrial | None = None
    """What is measured of it tick by tick for the step of a lesson, if it is one's run."""

    def __init__(
        self,
        flock: Flock,
        number: int,
        request: FrameRequest,
        watched: frozenset[str] = frozenset(),
    ):
        self.flock = flock
        self.number = number
        self.readings = FlockReadings(flock, watched)
        self.camera = FrameBuilder(flock, number, request)
        self.compiled = False
        """Whether the flock has run, so that its next tick need not be compiled."""
        self.warned = ""
        """What its flock has warned of, without the numbers."""
        self.astray: StrayAgents | None = None
        """The first agent that was seen where it cannot be."""
        self.troubles: list[Exception] = []
        """What went wrong in looking, each kind once; the flock runs on all the same."""

    @property
    def values(self) -> dict[str, Any]:
        """The flock's parameters, name -> value; a distribution where agents differ."""
        return self.flock.all_parameters

    @property
    def beside_values(self) -> dict[str, Any]:
        """The parameters that only the flock beside it has; it has none."""
        return {}

    @property
    def kinds(self) -> KindTable:
        """The kinds of its agents, and whom each heeds."""
        return self.flock.kinds

    @property
    def redrawn(self) -> dict[tuple[str, bool], int]:
        """How many numbers were drawn again: see `SimulationState.redrawn`."""
        return {(name, False): number for name, number in self.flock.redrawn.items()}

    @property
    def both(self) -> tuple[FlockRun, ...]:
        """This run, and the one beside it."""
        return (self,) if self.second is None else (self, self.second)

    @property
    def computed(self) -> tuple[FlockRun, ...]:
        """Those of them that a rule moves, and that are to be compiled."""
        return self.both

    @property
    def is_compiled(self) -> bool:
        """Whether the next tick need not be compiled, neither here nor beside."""
        return all(run.compiled for run in self.both)

    @property
    def is_ready(self) -> bool:
        """Whether all that it calls has been compiled, or is on disk."""
        return all(
            run.flock.is_compiled and all(map(is_at_hand, run.readings.extremes.kernels))
            for run in self.both
        )

    def set_request(self, request: FrameRequest) -> None:
        """Change what frames hold beside positions and headings."""
        self.camera.set_request(request)

    def watch(self, names: frozenset[str]) -> None:
        """Change which observables are measured beside those that always are."""
        for run in self.both:
            run.readings.watch(names)

    def allowed(self, name: str, value: Any, beside: bool = False) -> Any:  # noqa: ARG002 - Pair's
        """The value nearest to the wanted one that keeps zones in order. Raises InputError."""
        return nearest_allowed(self.flock, name, value)

    def set(self, name: str, value: Any, beside: bool = False) -> None:  # noqa: ARG002 - Pair's
        """Give a parameter a value. Raises InputError, and then changes nothing."""
        before, loop = self.values, self.flock.loop
        self.flock.set(**{name: value})
        try:
            refuse_too_dense(self.flock)
        except InputError:
            self.flock.set(**before)
            raise
        self.compiled = self.compiled and self.flock.loop is loop

    def change_kinds(self, kinds: KindTable) -> None:
        """Give its kinds other parameters and relations. Raises InputError, and then changes
        nothing."""
        before = self.kinds
        self.flock.change_kinds(kinds)
        try:
            refuse_too_dense(self.flock)
        except InputError:
            self.flock.change_kinds(before)
            raise

    def change(self, change: Callable[[FlockRun], None]) -> None:
        """Carry out a change of this run, and note its conditions as they are from now on."""
        if self.trial is not None:
            self.trial.cancel(CHANGED)
        try:
            change(self)
        finally:
            for run in self.both:
                run.readings.note_conditions()

    def advance(self, ticks: int) -> None:
        """Run ticks. Raises whatever the rule raises."""
        left = ticks
        while left > 0:
            tick = self.flock.tick
            part = left if self.trial is None else self.trial.ticks_together(tick, left)
            if self.measures:
                self.readings.extremes.run(part)
            else:
                self.flock.advance(part)
            left -= part
            if self.trial is not None:
                self.trial.note(self.flock)
        self.compiled = True

    def look(self, closely: bool, measured: bool = True) -> Frame:
        """Read what is due (everything, if `closely`; nothing, if not `measured`) and take a frame.

        Raises ArithmeticError, naming the agent, if a position is no finite number.
        """
        flock = self.flock
        if not np.isfinite(flock.position).all():
            row = int(np.argmin(np.isfinite(flock.position).all(axis=1)))
            raise ArithmeticError(
                f"agent {flock.ids[row]} has position {flock.position[row].tolist()} at tick "
                f"{flock.tick}: every position must be a finite number"
            )
        if not (measured and self.measures):
            return self.camera.build()
        if self.astray is None:
            self.astray = flock.stray()
            self.troubles += [] if self.astray is None else [StrayAgentError(str(self.astray))]
        self.try_to_look(lambda: self.readings.read(at_once=closely))
        self.try_to_look(lambda: self.camera.examine(at_once=closely))
        self.try_to_look(self.camera.inspect)
        self.try_to_look(lambda: self.camera.inspect_others(at_once=closely))
        return self.camera.build()

    def try_to_look(self, look: Callable[[], None]) -> None:
        """Look; note what goes wrong."""
        try:
            look()
        except Exception as error:
            if repr(error) not in map(repr, self.troubles):
                self.troubles.append(error)

    def place(self, row: int, position: np.ndarray, heading: np.ndarray) -> None:
        """Put an agent somewhere and turn it."""
        self.flock.position[row] = position
        self.flock.heading[row] = heading
        self.readings.note_conditions(by_hand=True)

    def spec(self) -> bytes:
        """The run as TOML, with its parameters as they are now and a line on what was changed."""
        changed = self.readings.conditions.changes()
        text = " ".join(f"# Changed while it ran: {', '.join(changed)}".split())
        text += ". Here are the last values.\n"
        return f"{text if changed else ''}{self.flock.spec.to_toml()}".encode()

    def save(self) -> bytes:
        """The flock's state as a file."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "flock.parquet"
            self.flock.save(path)
            return path.read_bytes()
