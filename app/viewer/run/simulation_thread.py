"""The thread of a simulation: it obeys, compiles, runs ticks and leaves frames."""

from __future__ import annotations

import math
import queue
import re
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from copy import deepcopy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from agents.catalogue import MODELS, PLAYED, from_file
from agents.flock import Flock
from agents.individuals import Distribution, moved, normal
from agents.kinds import Kind, KindTable, replace_kind
from agents.models.rule_file import describe_fault
from agents.motion.steered_motion import Pilot
from agents.policies import Policy
from agents.spec import CompleteSpec, Spec
from app.steering.hand_pilot import HandPilot
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.time_series import refuse_too_dense
from app.viewer.run.allowance import Allowance
from app.viewer.run.command_queue import CommandQueue, QueuedCommand
from app.viewer.run.edits import Edits, free_place
from app.viewer.run.flock_run import FlockRun, StrayAgentError, describe_error, zone_notice
from app.viewer.run.flock_run_builder import FlockRunBuilder
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.kernel_compiler import KernelCompiler, Preview, preview_size
from app.viewer.run.paired_run import companion
from app.viewer.run.playback import Playback
from app.viewer.run.played_kind import PlayedKind
from app.viewer.run.simulation_limits import SimulationLimits
from app.viewer.run.simulation_state import ChangeNotifier, SimulationState
from app.viewer.run.step_trial import ANOTHER, StepTrial
from app.viewer.run.stored_flock import InitialState, under_new_rule
from app.viewer.run.time_line import TimeLine
from app.viewer.run.tracks_run import TracksRun
from app.viewer.scene.shown.drawing_style import DENSITY_PERIOD, shows_density
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

LOOK = 0.05
"""Time between two looks whether the run is compiled, s."""
TRIED = 30
"""Agents with which a rule that was edited is tried before a flock goes by it."""
OBEDIENCE = 0.03
"""Longest time for commands before ticks are run again, s."""


Models = tuple[str, str | None]
"""Names of the model and of the one beside it."""
PendingRun = tuple[CompleteSpec, Spec | None, InitialState | None]
"""A run, what is beside it, and what it begins from if that is not its start."""


class SimulationThread:
    """Runs a flock on a thread of its own; what it is told comes through `tell`.

    Whoever watches reads `frame`, `state` and `readings`, each of which is replaced as a whole, so
    that no reader needs a lock.
    """

    def __init__(
        self,
        spec: CompleteSpec,
        beside: Spec | None = None,
        speed: float = 15.0,
        running: bool = True,
        build: Callable[..., Flock] = Flock,
        build_beside: Callable[[Flock, Spec], Flock] = companion,
        compiling: Callable[[Sequence[Flock]], KernelCompiler] = KernelCompiler,
        stored: InitialState | None = None,
        allowance: Allowance | None = None,
        clock: Callable[[], float] = time.perf_counter,
        pilots: Sequence[Pilot] = (),
    ):
        self.clock = clock
        self.keeping = SimulationLimits(allowance)
        self.notices: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.commands = CommandQueue()
        self.played: PlayedKind | None = None
        """The kind that who sits before it plays; None: everything may change."""
        self.edits = Edits(self)
        self.time_line = TimeLine(self)
        self.frame: Frame | None = None
        self.readings: FlockReadings | None = None
        self.readings_beside: FlockReadings | None = None
        self.state = SimulationState(spec, beside, running=running, busy=True, speed=speed)
        self.news = ChangeNotifier()
        """Set whenever a frame has been left; for who draws it."""
        self.ready = threading.Event()
        """Set when the first flock can be seen and, if it is to run, is compiled."""
        self.building = FlockRunBuilder(build, build_beside)
        self.compile = compiling
        self.compiling: KernelCompiler | None = None
        """What compiles, or has compiled, what the run calls."""
        self.preview: Preview | None = None
        self.run: FlockRun | None = None
        """The run on screen; a preview until its own is compiled."""
        self.wanted = FrameRequest()
        self.watched: frozenset[str] = frozenset()
        self.pace = self.keeping.pace(speed)
        self.next: PendingRun | None = spec, beside, stored
        """What is to be set up."""
        self.next_trial: StepTrial | None = None
        """What measures that run, if it is one of a lesson's step."""
        self.stale = False
        """Whether the flock has changed since the last frame."""
        self.hands = HandPilot()
        """The people who steer agents."""
        self.pilots: tuple[Pilot, ...] = (*pilots, self.hands)
        """Who flies agents of the flock, beside policies."""
        self.told: set[str] = set()
        """What its flocks have told since the last set-up."""
        self.next_frame = 0.0
        self.closing = False
        self.thread = threading.Thread(target=self.live, name="simulation", daemon=True)
        self.thread.start()

    def close(self, wait: float = 2.0) -> None:
        """Stop for good."""
        self.closing = True
        self.commands.wake()
        self.thread.join(wait)
        if self.compiling is not None:
            self.compiling.close()

    def tell(self, command: Callable[[], Any], key: str = "", runs: bool | None = None) -> Future:
        """Carry out a command between two ticks; what it refuses becomes a notice.

        Of commands with one `key` that follow each other only the last is carried out, as the
        answer to all. `runs` says whether the flock runs afterwards.
        """
        return self.queue_answered(lambda: self.commands.put(command, key, runs))

    def queue_answered(self, put: Callable[[], Future]) -> Future:
        """Let a command wait; if it may not, its answer says so, and a notice."""
        try:
            return put()
        except Exception as error:
            self.notices.put(describe_error(error))
            refused: Future = Future()
            refused.set_exception(error)
            return refused

    def carry_out(self, waiting: QueuedCommand) -> None:
        """On the simulation's own thread: do what waits, and answer."""
        try:
            waiting.answer.set_result(waiting())
        except Exception as error:
            self.notices.put(describe_error(error))
            waiting.answer.set_exception(error)

    def live(self) -> None:
        """Obey, run and leave frames, until closed."""
        while not self.closing:
            self.carry_out_commands()
            try:
                if self.next is not None and not self.keeping.wait:
                    self.set_up()
                self.look_for_kernels()
                self.time_line.settle()
                self.look_for_readings()
                self.leave_frame()
                if self.state.running and not self.keeping.wait:
                    self.run_due()
            except Exception as error:
                self.fail(error)
            self.keeping.note()
        self.end_run()

    def end_run(self) -> None:
        """Have who flies agents tell what only the end of a run shows."""
        if self.run is not None:
            for pilot in self.pilots:
                pilot.end_run(self.run.flock)

    def carry_out_commands(self) -> None:
        """Carry out what was told; wait for it if there is nothing else to do.

        However much is told, the flock gets its turn.
        """
        waiting = self.commands.get(timeout=self.idle_time())
        end = time.perf_counter() + OBEDIENCE
        while waiting is not None:
            self.carry_out(waiting)
            over = self.closing or time.perf_counter() >= end
            waiting = None if over else self.commands.get(timeout=0.0)

    def idle_time(self) -> float | None:
        """How long to wait for commands, s; None for ever."""
        if self.stale:
            return 0.0
        if self.next is not None:
            return self.keeping.wait
        now = self.clock()
        looks = None if self.state.compiling is None and not self.measures_aside else LOOK
        runs = None
        if self.state.running and not self.waits_for_compiler:
            runs = max(self.pace.wait(now), self.keeping.wait)
        settles = self.time_line.time_to_settle(time.perf_counter())
        due = [wait for wait in (looks, runs, settles) if wait is not None]
        return min(due, default=None)

    def run_due(self) -> None:
        """Run the ticks that are due."""
        if self.waits_for_compiler:
            return
        run = self.require_run()
        ticks = self.pace.ticks_due(self.clock())
        if run.trial is not None:
            ticks = run.trial.ticks_left(run.flock.tick, ticks)
            if self.stand_at_end(run):
                return
        if ticks == 0:
            return
        began, worked = self.clock(), time.thread_time()
        self.advance(run, ticks)
        now = self.clock()
        self.pace.note_ticks(ticks, now - began)
        if self.preview is not None:
            self.preview.note_tick((time.thread_time() - worked) / ticks)
            self.state = replace(self.state, preview=not self.preview.is_too_slow)
        self.stale = now >= self.next_frame
        if isinstance(run, Playback) and run.is_over:
            self.state = replace(self.state, running=False, rate=0.0)
            self.stale = True
        self.stand_at_end(run)

    def stand_at_end(self, run: FlockRun) -> bool:
        """Have the flock stand where the run of a lesson's step ends, once; whether it does now."""
        trial = run.trial
        if trial is None or trial.fault or trial.has_paused or run.flock.tick < trial.last:
            return False
        trial.has_paused = True
        self.end_run()
        self.state = replace(self.state, running=False, rate=0.0)
        self.stale = True
        return True

    def advance(self, run: FlockRun, ticks: int) -> None:
        """Run ticks; the first ones of a model may have to be loaded."""
        if run.is_compiled:
            run.advance(ticks)
            return
        self.state = replace(self.state, busy=True)
        run.advance(ticks)
        self.state = replace(self.state, busy=False)
        self.pace.restart()
        if self.state.compiling is None:
            self.ready.set()

    def leave_frame(self) -> None:
        """Leave a frame and readings for whoever watches, if there is anything new."""
        if not self.stale or self.run is None:
            return
        self.stale = False
        now = self.clock()
        apart = self.keeping.frame_interval
        if self.frame is not None and shows_density(self.frame):
            apart = max(apart, DENSITY_PERIOD)
        # A tick that is a little early is not left out for it, or every other one would be; frames
        # that commands ask for put none off.
        self.next_frame = min(max(self.next_frame, now - 0.5 * apart), now) + apart
        self.pass_warnings_on(self.run)
        trouble_count = len(self.run.troubles)
        # What measures is compiled with the flock: until then an obstacle is only shown.
        closely = not self.state.running and self.time_line.moved is None
        self.frame = self.run.look(closely, measured=not self.waits_for_compiler)
        for trouble in self.run.troubles[trouble_count:]:
            if not isinstance(trouble, InputError | StrayAgentError):
                traceback.print_exception(trouble)
            self.notices.put(describe_error(trouble))
        self.readings = self.run.readings
        second = self.run.second
        self.readings_beside = None if second is None else second.readings
        if self.state.compiling is None:
            self.time_line.note(self.run)
        rate = self.pace.rate(now) if self.state.running else 0.0
        self.state = replace(self.state, rate=rate, line=self.time_line.line(self.run))
        self.news.set()
        if not self.state.running:
            self.ready.set()

    def set_up(self) -> None:
        """Build the flock that is to be set up, and the one beside it."""
        if self.next is None:
            return
        (spec, beside, stored), self.next = self.next, None
        trial, self.next_trial = self.next_trial, None
        self.end_run()
        self.told.clear()
        self.hands.begin()
        self.end_trials(self.run, None if self.preview is None else self.preview.coming)
        self.state = replace(self.state, busy=True)
        try:
            self.keeping.demand(spec, beside, stored)
            if stored is None and spec.model in PLAYED:
                raise InputError("tracks follow no rule: open their file again, in the tab Tracks")
            flock = self.building.flock(spec, stored)
            refuse_too_dense(flock)
            run = self.new_run(flock, beside, stored)
            run.trial = trial
        except InputError as refusal:
            if trial is not None:
                trial.cancel(f"The run is refused ({refusal})")
            self.notices.put(str(refusal))
            self.state = replace(
                self.state, busy=False, running=self.state.running and self.run is not None
            )
            self.ready.set()
            return
        self.run, self.preview = run, None
        self.compile_ahead(run)
        if self.state.compiling is not None:
            self.begin_preview(run, spec, beside, stored)
        self.edits.take_over(self.run, spec)
        self.time_line.forget()
        self.pace.restart()
        self.stale = True
        self.state = replace(
            self.state,
            spec=spec,
            beside=beside,
            stored=stored,
            line=None,
            run=self.run.number,
            busy=False,
            preview=self.preview is not None,
            moving=len(self.run.flock.ids),
            error="",
            agents=len(flock.ids),
            values=self.run.values,
            beside_values=self.run.beside_values,
            redrawn=self.run.redrawn,
            kinds=self.run.kinds,
        )

    @staticmethod
    def end_trials(*runs: FlockRun | None) -> None:
        """Say to whoever waits for the trial of a run that it comes to no end."""
        for run in runs:
            if run is not None and run.trial is not None:
                run.trial.cancel(ANOTHER)

    def begin_preview(
        self, coming: FlockRun, spec: CompleteSpec, beside: Spec | None, stored: InitialState | None
    ) -> None:
        """Show as many agents of a run as plain Python moves well; of a stored one all, or none.

        They are its first ones: where an agent begins depends on no other.
        """
        if isinstance(coming, Playback):
            return
        complete = coming.flock.spec
        try:
            size = preview_size(complete.agents, partial(self.measure_tick, complete, beside))
        except InputError:  # so few agents are no such flock
            return
        if size == 0 or (stored is not None and size < complete.agents):
            return
        asked = complete.but(agents=size) if stored is None else spec.but(seed=complete.seed)
        twin = self.building.flock(asked, stored, interpret=True)
        self.preview = Preview(coming)
        self.run = self.new_run(twin, beside, stored)
        twin.pilots = ()  # the run itself makes it again, and nobody steers there
        for flock_run in self.run.both:
            flock_run.measures = False

    def measure_tick(self, spec: CompleteSpec, beside: Spec | None, agents: int) -> float:
        """What a tick of some agents of a run takes in plain Python, s of CPU."""
        flock = self.building.flock(spec.but(agents=agents), None, interpret=True)
        run = self.building.run(flock, beside, None, 0, FrameRequest(), frozenset())
        for flock_run in run.both:
            flock_run.measures = False
        run.advance(1)
        worked = time.thread_time()
        run.advance(1)
        return time.thread_time() - worked

    def new_run(self, flock: Flock, beside: Spec | None, stored: InitialState | None) -> FlockRun:
        """The run of a flock, and of the one beside it. Raises InputError."""
        number = self.state.run + 1
        run = self.building.run(flock, beside, stored, number, self.wanted, self.watched)
        self.keeping.take(run)
        for flock_run in run.both:
            flock_run.flock.tell = self.tell_once
        flock.pilots = self.pilots
        return run

    def tell_once(self, line: str) -> None:
        """Tell what has gone wrong with who flies agents: once for a preview and the run that
        follows it."""
        if line not in self.told:
            self.told.add(line)
            self.notices.put(line)

    def compile_ahead(self, *runs: FlockRun) -> None:
        """Have compiled what runs call, and nothing else, if it is not at hand."""
        flocks = [flock_run.flock for run in runs for flock_run in run.computed]
        if self.preview is None and all(run.is_ready for run in runs):
            self.state = replace(self.state, compiling=None)
            return
        compiling = self.compiling
        over = self.preview is None and compiling is not None and compiling.ready.done()
        if compiling is None or over or not compiling.covers(flocks):
            if compiling is not None:
                compiling.close()
            self.compiling = compiling = self.compile(flocks)
        self.state = replace(self.state, compiling=compiling.estimate)

    def look_for_kernels(self) -> None:
        """Go on with the compiled run as soon as it can: from where the preview is."""
        compiling, run = self.compiling, self.run
        if self.state.compiling is None or compiling is None or not compiling.ready.done():
            return
        compiling.ready.result()
        if self.preview is not None and run is not None:
            whole = self.preview.advance_compiled(run)
            if len(whole.flock.ids) != len(run.flock.ids):
                self.renumber(whole)  # whoever has drawn a part of it begins afresh
            self.run = whole
            self.run.set_request(self.wanted)
            self.run.watch(self.watched)
            if self.run.is_compiled:
                self.ready.set()
        self.preview = None
        self.state = replace(self.state, compiling=None, preview=False)
        self.pace.restart()
        self.stale = True

    @property
    def measures_aside(self) -> bool:
        """Whether a flock that stands is measured aside, of which there will be news."""
        run = self.run
        return (
            not self.state.running
            and run is not None
            and any(one.readings.is_large and not one.readings.aside.idle for one in run.both)
        )

    def look_for_readings(self) -> None:
        """Leave a frame of a flock that stands once it has been measured."""
        if self.measures_aside and self.run is not None:
            self.stale |= any(one.readings.is_found for one in self.run.both)

    def renumber(self, run: FlockRun) -> None:
        """Make a run the next one: its frames have other agents than those before."""
        number = self.state.run + 1
        for flock_run in run.both:
            flock_run.number = flock_run.camera.run = number
        self.state = replace(self.state, run=number)

    @property
    def waits_for_compiler(self) -> bool:
        """Whether the flock stands until it is compiled."""
        moves = self.preview is not None and not self.preview.is_too_slow
        return self.state.compiling is not None and not moves

    def compiled_run(self, wanted: str) -> FlockRun:
        """The run, if it is no preview. Raises InputError."""
        if self.preview is not None and self.state.compiling is not None:
            left = self.state.compiling.describe(time.monotonic())
            raise InputError(f"this is a preview, and {wanted} is the compiled run ({left})")
        return self.require_run()

    def copy_flocks(self) -> tuple[Flock, ...]:
        """Copies of the flock, and of the one beside it, at this tick. Raises InputError."""
        run = self.compiled_run("what a page runs")
        if isinstance(run, TracksRun):
            raise InputError(
                f"{run.stored.name} is a file of tracks, which no page can run: film it as HTML "
                "that plays"
            )
        return tuple(deepcopy(flock_run.flock) for flock_run in run.both)

    def change(
        self, change: Callable[[FlockRun], None], name: str = "", beside: bool = False
    ) -> None:
        """Change the run; of a preview, the run that takes over too, at the same tick.

        `name`: the parameter that is set, if it is that, and whether it is of the flock beside.
        """
        run = self.require_run()
        self.time_line.demand_now(name, beside)
        tick = run.flock.tick
        run.change(change)
        self.time_line.changed()
        if self.preview is None:
            self.compile_ahead(run)
        else:
            self.preview.changes.append((tick, change))
            self.compile_ahead(self.preview.coming, run)

    def fail(self, error: Exception) -> None:
        """A rule went wrong: stop the run, say why and live on."""
        if not isinstance(error, InputError | ArithmeticError):
            traceback.print_exception(error)
        self.stale = False
        self.notices.put(describe_error(error))
        self.preview = None
        self.state = replace(
            self.state,
            running=False,
            busy=False,
            compiling=None,
            preview=False,
            rate=0.0,
            error=describe_error(error),
        )
        self.ready.set()

    def require_run(self) -> FlockRun:
        """The run. Raises InputError if there is none, or it is broken."""
        if self.run is None or self.state.error:
            raise InputError("there is no flock to run: press Setup")
        return self.run

    def pass_warnings_on(self, run: FlockRun) -> None:
        """Tell what flocks warn of, once for each setting.

        Numbers change with every move of a slider: for them alone nothing is told again.
        """
        for flock_run in run.both:
            words = flock_run.flock.warning
            subject = re.sub(r"[\d.]+", "", words)
            if subject and subject != flock_run.warned:
                self.notices.put(words)
            flock_run.warned = subject

    def schedule(
        self,
        spec: CompleteSpec,
        beside: Spec | None,
        stored: InitialState | None = None,
        trial: StepTrial | None = None,
    ) -> None:
        if self.played is not None:
            if stored is not None:
                raise self.played.refuse("the run")
            self.played.demand_run(spec, beside)
        if self.next_trial is not None:
            self.next_trial.cancel(ANOTHER)
        self.next, self.next_trial = (spec, beside, stored), trial

    def begin(self, stored: InitialState) -> None:
        self.schedule(stored.spec, getattr(stored, "beside", None), stored)

    def take_rule_now(self, path: Path) -> str:
        """Raises InputError, after which everything is as before."""
        if self.played is not None:
            raise self.played.refuse("the rule")
        before = dict(MODELS)
        model = from_file(str(path))
        if isinstance(model, Policy):  # whoever flies by it asks the new one in the next tick
            return model.name
        try:
            if model is not before.get(model.name):
                self.go_on_under(model.name)
        except Exception as error:
            for name in MODELS.keys() - before.keys():
                del MODELS[name]
            MODELS.update(before)
            if isinstance(error, InputError) and path.name in str(error):
                raise
            raise describe_fault(path, str(path.resolve()), error) from error
        return model.name

    def go_on_under(self, name: str) -> None:
        """Go on with the flock as it is under the rule that the model of a name has by now."""
        run = self.run
        names = {*self.state.models, *self.state.spec.models}
        if run is None or name not in names or isinstance(run, Playback):
            return
        spec, beside = self.state.current_specs()
        stored = under_new_rule(spec, run.flock.snapshot(), self.building.build)
        begun = self.state.stored
        parameters = stored.run.all_parameters
        spec = spec.with_parameters(parameters) if begun is None else stored.spec
        self.measure_tick(spec, beside, min(TRIED, len(stored.now.ids)))
        self.next = spec, beside, stored
        self.set_up()
        self.state = replace(self.state, stored=begun)

    def switch(self, on: bool) -> None:
        if on and self.next is None:
            self.require_run()
            self.time_line.resume()
        self.pace.restart()
        self.state = replace(self.state, running=on)
        self.stale = self.run is not None and not self.state.error

    def step_now(self, ticks: int) -> None:
        run = self.require_run()
        if self.waits_for_compiler and self.state.compiling is not None:
            left = self.state.compiling.describe(time.monotonic())
            raise InputError(f"the flock stands until it is compiled ({left})")
        self.state = replace(self.state, running=False)
        try:
            if isinstance(run, Playback):
                run.step(ticks)
            else:
                self.time_line.resume()
                self.advance(run, ticks)
        except Exception as error:
            self.fail(error)
            return
        self.stale = True

    def change_pace(self, speed: float) -> None:
        if math.isnan(speed) or speed <= 0:
            raise InputError(f"speed = {speed} ticks/s is not allowed: it must be above 0")
        self.pace = self.keeping.pace(speed)
        self.state = replace(self.state, speed=speed)

    def set_watched_now(self) -> None:
        self.keeping.look()
        self.pace = self.keeping.pace(self.state.speed)
        self.next_frame = 0.0
        self.look_again_now()

    def set_now(self, name: str, value: Any, beside: bool, models: Models | None) -> Any:
        run = self.require_run()
        if models not in (None, self.state.models):
            return value
        if self.played is not None:
            self.played.demand_parameter(name, beside)
        accepted = run.allowed(name, value, beside)
        self.change(lambda run: run.set(name, accepted, beside), name, beside)
        if accepted != value:
            flock = run.second.flock if beside and run.second is not None else run.flock
            self.notices.put(zone_notice(flock, name, accepted))
        self.pace.reset_cost()
        self.state = replace(
            self.state,
            values=run.values,
            beside_values=run.beside_values,
            redrawn=run.redrawn,
        )
        self.stale = True
        return accepted

    def move_now(self, name: str, value: Any, beside: bool, models: Models | None) -> Any:
        before = self.value_now(name, beside, models)
        return self.set_now(name, moved(before, value), beside, models)

    def spread_now(self, name: str, deviation: float, beside: bool, models: Models | None) -> Any:
        before = self.value_now(name, beside, models)
        centre = before.centre if isinstance(before, Distribution) else before
        value = normal(centre, deviation) if deviation else centre
        return self.set_now(name, value, beside, models)

    def relate_now(self, kind: str, other: str, name: str, value: Any) -> Any:
        kinds = self.require_run().kinds
        changes = {name: value}
        if name == "deed" and value != "chase":  # only who chases can catch
            changes["catch"] = 0.0
        changed = replace(kinds.of(kind, other), **changes)
        self.change_kinds_now(kinds.with_relation(kind, other, changed))
        return value

    def set_kind_now(self, kind: str, name: str, value: Any) -> Any:
        one = self.require_run().kinds.kind(kind)
        own = {key: number for key, number in one.parameters.items() if key != name}
        self.change_kind_now(one, parameters=own if value is None else {**own, name: value})
        return value

    def paint_kind_now(self, kind: str, colour: str) -> str:
        self.change_kind_now(self.require_run().kinds.kind(kind), colour=colour)
        return colour

    def change_kind_now(self, kind: Kind, **changes: Any) -> None:
        self.change_kinds_now(self.require_run().kinds.with_kind(replace_kind(kind, **changes)))

    def change_kinds_now(self, kinds: KindTable) -> None:
        """Have the flock go on with other parameters and relations of its kinds."""
        run = self.require_run()
        if self.played is not None:
            self.played.demand_kinds(kinds)
        self.change(lambda run: run.change_kinds(kinds))
        self.pace.reset_cost()
        self.state = replace(self.state, kinds=run.kinds)
        self.stale = True

    def value_now(self, name: str, beside: bool, models: Models | None) -> Any:
        """The value of a parameter; 0 of models that run no longer, which nothing is set of."""
        run = self.require_run()
        is_other = models not in (None, self.state.models)
        return 0.0 if is_other else (run.beside_values if beside else run.values)[name]

    def place_now(self, row: int, position: np.ndarray, heading: np.ndarray) -> None:
        if self.played is not None:
            raise self.played.refuse("the place of an agent")
        place = free_place(self.require_run(), position)
        self.change(lambda run: run.place(row, place, heading))
        self.stale = True

    def look_again_now(self) -> None:
        self.stale = self.run is not None and not self.state.error

    def watch_now(self, names: frozenset[str]) -> None:
        self.watched = names
        if self.run is not None:
            self.run.watch(names)
            self.stale = not self.state.error

    def set_request_now(self, request: FrameRequest) -> None:
        self.wanted = request
        if self.run is not None and not self.state.error:
            self.run.set_request(request)
            self.stale = True
