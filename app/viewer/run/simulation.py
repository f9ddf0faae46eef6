"""A flock that runs in a thread of its own and never waits for whoever watches it."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np

from agents.spec import CompleteSpec, Spec
from app.viewer.run.command_queue import GO
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.played_kind import PlayedKind
from app.viewer.run.simulation_thread import Models, SimulationThread
from app.viewer.run.step_trial import StepTrial
from app.viewer.run.stored_flock import InitialState


class Simulation(SimulationThread):
    """Runs a flock; `frame`, `state` and `readings` are always the latest.

    Commands return at once and are carried out in order, between two ticks; a pause comes first.
    However much is told, little waits: what comes to the same is merged, and what is too much is
    refused. What a user must be told is left in `notices`; `edits` change the world, `time_line`
    goes back in time. While a run is not compiled a preview of it goes on, if it is quick enough,
    and takes the same commands. A recording is played by the same commands. With an `allowance` it
    keeps to that. `clock`, s, says when ticks and frames are due. `pilots` steer
    its agents, beside policies and people.
    """

    def play(self, kind: str, spec: CompleteSpec) -> None:
        """From now on let nothing of a run change but the numbers of a kind, which somebody plays.

        `spec`: the run that is set up next. Empty: everything may change. Raises InputError for a
        kind that it has not.
        """
        self.played = PlayedKind(kind, spec) if kind else None

    # Commands, from any thread.

    def setup(self, spec: CompleteSpec, beside: Spec | None = None) -> Future:
        """Build a new flock; of several set-ups at once only the last is built."""
        return self.tell(lambda: self.schedule(spec, beside), "set up")

    def try_step(self, spec: CompleteSpec, trial: StepTrial) -> Future:
        """Build the flock of a lesson's step, which is measured on its way and stands at its
        end."""
        return self.tell(lambda: self.schedule(spec, None, trial=trial))

    def open(self, stored: InitialState) -> Future:
        """Go on from a saved state, or play a recording."""
        return self.tell(lambda: self.begin(stored), "set up")

    def take_rule(self, path: Path) -> Future:
        """Read the file of a rule anew; a flock that goes by it goes on under what it says now.

        The answer is the name of its model. What is wrong with it is refused, and the rule of
        before goes on.
        """
        return self.tell(lambda: self.take_rule_now(path), f"rule {path}")

    def reset(self) -> Future:
        """The same flock again: same seed, same start, the parameters as they are now."""
        return self.tell(
            lambda: self.schedule(*self.state.current_specs(), self.state.stored), "set up"
        )

    def go(self) -> Future:
        """Run."""
        return self.tell(lambda: self.switch(True), GO, runs=True)

    def pause(self) -> Future:
        """Stop running, before anything else that waits, until told to go."""
        return self.commands.pause(lambda: self.switch(False))

    def toggle(self) -> Future:
        """Pause if it runs once all is done that waits, go if not."""
        return self.pause() if self.commands.will_run(self.state.running) else self.go()

    def step(self, ticks: int = 1) -> Future:
        """Pause and run a few ticks; with those that wait already never very many."""
        return self.queue_answered(lambda: self.commands.step(self.step_now, ticks))

    def run_at(self, speed: float) -> Future:
        """Run at so many ticks per second; infinity for as fast as it goes."""
        return self.tell(lambda: self.change_pace(speed), "pace")

    def set(
        self, name: str, value: Any, beside: bool = False, models: Models | None = None
    ) -> Future:
        """Give a parameter a new value, in both flocks if they share it; or only `beside`.

        The answer is the value that it has taken: a zone stops at the next one, which is told. If
        `models` are given, and others have come since, nothing is done.
        """
        key = f"set {name} {beside} {models}"
        return self.tell(lambda: self.set_now(name, value, beside, models), key)

    def move(
        self, name: str, value: Any, beside: bool = False, models: Models | None = None
    ) -> Future:
        """Give a parameter the value of a slider: as `set`, but where agents differ they keep their
        spread about it."""
        key = f"move {name} {beside} {models}"
        return self.tell(lambda: self.move_now(name, value, beside, models), key)

    def spread(
        self, name: str, deviation: float, beside: bool = False, models: Models | None = None
    ) -> Future:
        """Let agents differ in a parameter normally about its value, by a standard deviation; 0:
        all are alike. Else as `set`."""
        key = f"spread {name} {beside} {models}"
        return self.tell(lambda: self.spread_now(name, deviation, beside, models), key)

    def relate(self, kind: str, other: str, name: str, value: Any) -> Future:
        """Change one thing of what agents of a kind do about those of another: `deed`, `weight`,
        `radius`, `catch` or `caught`. The answer is its value."""
        key = f"relate {kind} {other} {name}"
        return self.tell(lambda: self.relate_now(kind, other, name, value), key)

    def set_kind(self, kind: str, name: str, value: Any) -> Future:
        """Give the agents of a kind alone a value of a parameter, or what they have in common with
        all: None. The answer is the value."""
        return self.tell(lambda: self.set_kind_now(kind, name, value), f"set {name} of {kind}")

    def paint_kind(self, kind: str, colour: str) -> Future:
        """Give a kind a colour, `#rrggbb`, or one of its own: nothing."""
        return self.tell(lambda: self.paint_kind_now(kind, colour), f"paint {kind}")

    def place(self, row: int, position: np.ndarray, heading: np.ndarray) -> Future:
        """Put an agent somewhere and turn it."""
        return self.tell(lambda: self.place_now(row, position, heading), f"place {row}")

    def set_request(self, request: FrameRequest) -> Future:
        """Say what frames should hold beside positions and headings."""
        return self.tell(lambda: self.set_request_now(request), "want")

    def watch(self, names: Iterable[str]) -> Future:
        """Say which observables should be measured beside those that always are."""
        chosen = frozenset(names)
        return self.tell(lambda: self.watch_now(chosen), "watch")

    def set_watched(self, is_seen: bool) -> None:
        """Say whether anybody looks: what has an allowance takes less if nobody does."""
        if is_seen != self.keeping.seen:
            self.keeping.seen = is_seen
            self.tell(self.set_watched_now, "seen")

    def look_again(self) -> Future:
        """Take another frame, though nothing has moved."""
        return self.tell(self.look_again_now, "look again")

    def spec(self) -> Future:
        """The run as TOML, bytes; of two flocks a ZIP of both."""
        return self.tell(lambda: self.require_run().spec(), "spec")

    def flocks(self) -> Future:
        """A copy of the flock as it is, and of the one beside it, if there is one: a tuple."""
        return self.tell(self.copy_flocks, "flocks")

    def save(self) -> Future:
        """The flock's saved state, bytes; of two flocks a ZIP of both."""
        return self.tell(lambda: self.compiled_run("what is saved").save(), "saved")
