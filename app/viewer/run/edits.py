"""Changes of a running flock's world, as commands of its simulation."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from agents.flock import Flock
from agents.spec import CompleteSpec, Spec
from app.viewer.editing.editor import Editor, MissingObstacleError
from app.viewer.editing.free_places import move_out
from app.viewer.editing.layout_file import layout_from_browser
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.paired_run import companion
from app.viewer.run.played_kind import PlayedKind
from app.viewer.run.simulation_limits import SimulationLimits
from app.viewer.run.simulation_state import SimulationState
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError
from worlds.obstacles import Disc
from worlds.readers.drawing_contents import PlanQuestion
from worlds.world import World

Change = Callable[[Editor], Editor]


class EditsHost(Protocol):
    """What changes of a world need of the simulation whose world it is."""

    run: FlockRun | None
    state: SimulationState
    stale: bool
    keeping: SimulationLimits
    played: PlayedKind | None

    def tell(self, command: Callable[[], Any], key: str = "") -> Future: ...

    def require_run(self) -> FlockRun: ...

    def change(self, change: Callable[[FlockRun], None]) -> None: ...

    def schedule(self, spec: CompleteSpec, beside: Spec | None) -> None: ...


class Edits:
    """Changes a simulation's world; commands return at once, as the simulation's own do."""

    def __init__(self, host: EditsHost) -> None:
        self.host = host
        self.editor: Editor | None = None
        """The world with its history, a value that any thread may read; None until the first flock
        is there."""
        self.untouched: World | None = None
        """The world before the first change."""
        self.plain: CompleteSpec | None = None
        """What sets it up."""
        self.drags: dict[str, Change] = {}
        """The newest change of each drag that is not carried out yet."""
        self.drags_lock = threading.Lock()
        self.prepared: set[str] = set()
        """Models, dimensions and options that have been compiled for obstacles, aside."""

    # Commands.

    def change(self, change: Change) -> Future:
        """Change the world between two ticks. What is refused becomes a notice.

        Agents that an obstacle comes upon are put on the nearest free place; if there is none, the
        change is refused.
        """
        return self.host.tell(lambda: self.edit_now(change))

    def drag(self, gesture: str, change: Change) -> None:
        """Change the world as a part of a drag: only the newest change is carried out.

        What cannot be is left out without a word, as the hand moves on.
        """
        with self.drags_lock:
            waiting = gesture in self.drags
            self.drags[gesture] = change
        if not waiting and self.host.tell(lambda: self.drag_now(gesture), f"drag {gesture}").done():
            with self.drags_lock:  # it was refused: the next change of this drag is told again
                self.drags.pop(gesture, None)

    def open_layout(
        self,
        name: str,
        content: bytes,
        options: Mapping[str, Any] | None = None,
        ask: Callable[[PlanQuestion], None] | None = None,
    ) -> Future:
        """Set up the flock anew in the world of a layout file, TOML or a drawing.

        A file that is refused, or a world in which the flock cannot be, changes nothing. `options`
        say how a drawing is read. `ask` takes the question of one that may mean two things, on
        the simulation's thread; without it, it is refused.
        """
        return self.host.tell(lambda: self.open_now(name, content, options or {}, ask))

    def layout(self) -> Future:
        """The world as TOML, bytes."""
        return self.host.tell(self.layout_now, "layout")

    def prepare(self) -> None:
        """Compile the model for obstacles in a thread aside, so that the first one comes sooner."""
        run, state = self.host.run, self.host.state
        if run is None or run.flock.world.is_solid or self.host.played is not None:
            return
        dim = run.flock.world.dim
        kind = f"{state.models} {dim} {state.spec.chosen}"
        if kind not in self.prepared:
            self.prepared.add(kind)
            threading.Thread(
                target=try_world, args=(state.spec, state.beside, dim), daemon=True
            ).start()

    # The simulation's own thread.

    def demand_editable(self) -> None:
        """Raise InputError where who sits before it plays a kind of agents: the world is not its
        own."""
        if self.host.played is not None:
            raise self.host.played.refuse("the world")

    def edit_now(self, change: Change) -> None:
        self.demand_editable()
        run, before = self.host.require_run(), self.editor
        if before is None:
            raise InputError("there is no world to change yet")
        self.host.keeping.demand_turn()
        after = change(before)
        self.host.keeping.demand_world(after.world, before.world)
        if after.world is not run.flock.world:
            self.host.change(lambda run: move_to_world(run, after))
        self.editor = after
        spec, plain = self.host.state.spec, self.plain
        if after.world is self.untouched and plain is not None:
            spec = spec.with_values(world=plain.world, size=plain.size)
        else:
            spec = spec.with_values(world=after.world, size=None)
        self.host.state = replace(self.host.state, spec=spec)
        self.host.stale = True

    def drag_now(self, gesture: str) -> None:
        with self.drags_lock:
            change = self.drags.pop(gesture, None)
        self.demand_editable()  # told, unlike what only this step of the drag cannot be
        with contextlib.suppress(InputError):
            if change is not None:
                self.edit_now(change)

    def layout_now(self) -> bytes:
        return self.host.require_run().flock.world.to_toml().encode()

    def open_now(
        self,
        name: str,
        content: bytes,
        options: Mapping[str, Any],
        ask: Callable[[PlanQuestion], None] | None,
    ) -> None:
        self.demand_editable()
        try:
            world = layout_from_browser(name, content, options)
        except PlanQuestion as question:
            if ask is None:
                raise
            ask(question)
            return
        spec, beside = self.host.state.current_specs()
        self.host.schedule(spec.with_values(world=world, size=None, dim=world.dim), beside)

    def take_over(self, run: FlockRun, spec: CompleteSpec) -> None:
        """Edit the world of a new run; the history goes on where it is the same world."""
        world = run.flock.world
        is_same = self.editor is not None and self.editor.world == world
        if not is_same:
            self.editor = Editor.of(world)
            self.untouched = world
        if not is_same or not isinstance(spec.world, World):
            self.plain = spec


def move_to_world(run: FlockRun, editor: Editor) -> None:
    """Let a flock go on in another world. Raises InputError, and then changes nothing."""
    world = editor.world
    freed = [move_out(world, run.flock.position) for run in run.both]
    for flock_run, position in zip(run.both, freed, strict=True):
        flock, before = flock_run.flock, flock_run.flock.loop
        flock.change_world(world)
        if position is not flock.position:
            flock.position[:] = position
        flock_run.compiled = flock_run.compiled and flock.loop is before


def try_world(spec: Spec, beside: Spec | None, dim: int) -> None:
    """Run a flock of two, and the one beside it, for a tick in a small world with an obstacle."""
    pillar = Disc(centre=(9.0, 9.0), radius=0.5)
    world = World("aside", (10.0,) * dim, ("open",) * dim, obstacles=(pillar,))
    with contextlib.suppress(InputError):
        flock = Flock(spec.but(agents=2, size=None, world=world))
        flock.advance(1)
        if beside is not None:
            companion(flock, beside).advance(1)


def free_place(run: FlockRun, position: np.ndarray) -> np.ndarray:
    """A place (dim,) for an agent, the nearest one that is not solid. Raises InputError."""
    return move_out(run.flock.world, np.asarray(position, float)[None])[0]


def ignoring_gone(change: Change) -> Change:
    """A change that does nothing to an obstacle that somebody else has deleted."""

    def tried(editor: Editor) -> Editor:
        try:
            return change(editor)
        except MissingObstacleError:
            return editor

    return tried


# Where an agent may be put that a browser drags about.

FARTHEST = 100.0
"""How far out of an open world an agent may be dragged, longest sides."""


def leader(frame: Frame | None) -> int | None:
    """Row of the information agent; None if there is none."""
    if frame is None or not frame.informed.any():
        return None
    return int(np.argmax(frame.informed))


def usable_pose(
    frame: Frame, position: np.ndarray, heading: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """A position (dim,) within the world and a unit vector (dim,); None for what is neither."""
    position, heading = np.asarray(position, float), np.asarray(heading, float)
    if position.shape != (frame.dim,) or heading.shape != (frame.dim,):
        return None
    length = float(np.linalg.norm(heading))
    if not np.isfinite(position).all() or not math.isfinite(length) or length < 1e-9:
        return None
    far = FARTHEST * float(frame.size.max())
    inside = np.where(
        frame.wraps,
        position % frame.size,
        np.clip(position, frame.low - far, frame.low + far),
    )
    return inside, heading / length
