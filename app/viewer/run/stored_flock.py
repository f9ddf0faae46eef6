"""What a run goes on from: a saved state or a recording, of a file of this machine or from a
browser; or a flock in hand.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from agents.catalogue import model as find_model
from agents.engine.arrays import Arrays
from agents.engine.heeding import CAUGHT
from agents.flock import Flock
from agents.kind_models import kind_models, own_columns, shared_numbers
from agents.kinds import complete_kinds, replace_kind
from agents.models.declare import checked
from agents.motion.motion import demand_kinds
from agents.recordings.recording import Recording
from agents.snapshot import Snapshot
from agents.spec import CompleteSpec
from app.viewer.editing.layout_file import demand_few, demand_small, plain_name
from app.viewer.run.run_preset import MOST_AGENTS, lively_speed
from app.viewer.run.stored_tracks import StoredTracks
from worlds.input_error import InputError, unknown
from worlds.layout import layout_names
from worlds.plug_ins import demand_parquet
from worlds.world import World

PARQUET = b"PAR1"
"""What such a file begins with."""
LARGEST = 10_000_000
"""Bytes of a file from a browser: what its connection takes at once. Larger ones are opened by
`flockscope lab FILE`."""
MOST_NUMBERS = 2**25
"""Numbers that are decoded together."""
MOST_BYTES = 2**28
"""Bytes to which a file from a browser unpacks."""
MOST_ROWS = 2**26
"""Rows of a file, all ticks together."""
MOST_SIDE = 1e6
"""Side of a world, length."""
REWRITE = f"{__name__}:rewrite"
"""The reader of a file from a browser, for a process of its own."""
REWRITTEN_ROWS = 100_000
"""Rows of a group of what is written: what is decoded together when a tick is looked at."""


@dataclass(frozen=True)
class StoredFlock:
    """A state to go on from, or a recording to play: a state is a recording of one tick."""

    recording: Recording
    name: str
    tick: int | None = None
    """Of a recording that is gone on from: where."""

    @property
    def is_played(self) -> bool:
        """Whether it is a recording that is played."""
        return self.tick is None and len(self.recording.frames.ticks) > 1

    @property
    def kind(self) -> str:
        """What it is called."""
        return "recording" if self.is_played else "saved state"

    @cached_property
    def spec(self) -> CompleteSpec:
        """The run that Setup begins from it, at tick 0; what started from arrays starts anew."""
        return at_start(self.recording.spec, self.recording.world)

    @property
    def speed(self) -> float:
        """Ticks per second at which it can be watched: a picture of few ticks is not a long one."""
        ticks = self.recording.frames.ticks
        apart = (ticks[-1] - ticks[0]) / max(1, len(ticks) - 1)
        return lively_speed(self.spec) * max(1.0, float(apart))

    @property
    def most(self) -> int:
        """Agents that it has at most."""
        frames = self.recording.frames
        return int((frames.ends - frames.starts).max())

    @property
    def first(self) -> Snapshot:
        """The flock as it begins. Raises InputError."""
        frames = self.recording.frames
        return frames.at(int(frames.ticks[0]) if self.tick is None else self.tick)

    def flock(self, build: Callable[..., Flock], **more: Any) -> Flock:
        """The flock as it begins, ready to go on from there. Raises InputError."""
        return resume(self.recording.spec, self.first, build, **more)

    def going_on(self, tick: int) -> StoredFlock:
        """The state of a tick, to go on from. Raises InputError."""
        if self.recording.spec.is_late:
            raise InputError(
                f"{self.name} cannot go on: only saved states hold the messages that are on their "
                "way"
            )
        return replace(self, tick=tick)


@dataclass(frozen=True)
class InMemoryFlock:
    """A flock of this process, as it is, to go on from."""

    run: CompleteSpec
    """What it is a run of, with its parameters as they are."""
    now: Snapshot
    is_played = False
    kind = "flock"

    @property
    def name(self) -> str:
        """What it is called."""
        return f"{self.run.model} at tick {self.now.tick}"

    @cached_property
    def spec(self) -> CompleteSpec:
        """The run that Setup begins from it, at tick 0; what started from arrays starts anew."""
        return at_start(self.run, self.now.world)

    @property
    def most(self) -> int:
        """Agents that it has."""
        return len(self.now.ids)

    @property
    def speed(self) -> float:
        """Ticks per second at which it can be watched."""
        return lively_speed(self.spec)

    def flock(self, build: Callable[..., Flock], **more: Any) -> Flock:
        """The flock as it begins, ready to go on from there. Raises InputError."""
        return resume(self.run, self.now, build, **more)


InitialState = StoredFlock | InMemoryFlock | StoredTracks
"""What a run begins from, if not from its start."""


def at_start(spec: CompleteSpec, world: World) -> CompleteSpec:
    """The same run at tick 0; what started from arrays starts at random."""
    is_named = spec.layout is None and spec.world in layout_names()
    alike = len(set(world.size)) == 1
    if is_named and alike and world.random is None:
        where: dict[str, Any] = {"world": spec.world, "size": float(world.size[0])}
    else:
        where = {"world": world, "size": None}
    return spec.with_values(**where, layout=None, dim=world.dim, start="random", versions={})


def resume(spec: CompleteSpec, saved: Snapshot, build: Callable[..., Flock], **more: Any) -> Flock:
    """The flock of a run as it was in a snapshot, from which it goes on. Raises InputError."""
    spec = spec.with_values(world=saved.world, layout=None)
    start = {"position": saved.position, "heading": saved.heading}
    # Without its kinds: of these some may have been caught, and fewer be left than it asks for.
    flock = build(spec.with_values(kinds=(), to={}), start=start, **more)
    demand_kinds(flock.model, flock.parameters, saved.kinds, spec, saved.world.dim)
    flock.options = spec
    flock.return_to(saved)
    return flock


def under_new_rule(run: CompleteSpec, now: Snapshot, build: Callable[..., Flock]) -> InMemoryFlock:
    """A flock as it is, to go on under the rule that its model has by now.

    Parameters that the rule still has keep their values where they are in their range; what agents
    tell or remember is kept by its name, and all else is as at a start. Raises InputError, also
    where agents differ in what the rule lets them no longer.
    """
    kept: dict[str, Any] = {}
    model = find_model(run.model)
    parameters = model.parameters
    for name in parameters.model_fields.keys() & run.parameters.keys():
        with suppress(InputError):
            kept[name] = getattr(checked(parameters, {name: run.parameters[name]}), name)
    kept |= {name: one for name, one in run.individuals.items() if name in kept}
    kinds = tuple(
        one
        if one.model
        else replace_kind(one, parameters={k: v for k, v in one.parameters.items() if k in kept})
        for one in now.kinds.kinds
    )
    spec = run.with_parameters(kept, world=now.world, layout=None, kinds=kinds)
    alone = spec.with_values(kinds=(), to={})
    flock = build(alone, start={"position": now.position, "heading": now.heading})
    table = complete_kinds(model.rule.kinds, kinds, now.kinds.to)
    demand_kinds(model, flock.parameters, table, run, now.world.dim)
    arrays, columns = flock.arrays._asdict(), now.model.columns
    for name, array in now.arrays._asdict().items():
        if name not in ("memory", "past", "own") and array.shape == arrays[name].shape:
            arrays[name] = array
    memory = arrays["memory"] = np.array(arrays["memory"])
    for row, name in enumerate(flock.model.columns):
        if name in columns:
            memory[row] = now.arrays.memory[columns.index(name)]
    if kinds:
        number = np.array([*map(table.names.index, now.kinds.names), CAUGHT])
        arrays["kind"] = number[now.kind_numbers]
    if table.kinds:
        arrays["own"] = shared_numbers(model, flock.parameters, table, arrays["kind"])
    names = own_columns(model, kind_models(table))
    for name, column in now.own.items():
        if name in names and arrays["own"].shape[1]:
            is_known = ~np.isnan(column)
            arrays["own"][is_known, names.index(name)] = column[is_known]
    then = replace(
        flock.snapshot(),
        tick=now.tick,
        next_id=now.next_id,
        arrays=Arrays(**arrays),
        kinds=table,
        catches=now.catches,
    )
    return InMemoryFlock(flock.spec.with_values(kinds=table.kinds, to=table.to), then)


def read_stored(name: str, content: bytes | None = None, path: Path | None = None) -> StoredFlock:
    """The state or recording in the bytes of a file, or at a path. Raises InputError.

    Whoever made it: how much it unpacks to is looked at before anything is unpacked, its world is
    in it or built in, and every flock that is taken from it is one that a run can have.
    """
    demand_parquet(f"opening {name!r}")
    if content is not None:
        name = plain_name(name)
        if len(content) > LARGEST:
            raise InputError(
                f"{name} has {len(content)} bytes: from a browser at most {LARGEST} are taken, "
                "`flockscope lab FILE` opens larger ones"
            )
    try:
        recording = Recording(path or name, content)
        demand_modest(recording, name, content is not None)
        demand_own_world(recording, name)
        flock = StoredFlock(recording, name)
        demand_playable(flock, name)
    except InputError:
        raise
    except Exception as error:  # A broken file makes the parsers of others raise whatever they do.
        raise InputError(f"{name} cannot be read: {type(error).__name__}") from None
    return flock


def demand_modest(recording: Recording, name: str, whole: bool) -> None:
    """Raise InputError for a file that unpacks to too much, by what its footer and its pages say.

    `whole`: whether that holds for the file and not only for what is decoded together.
    """
    file = recording.file
    groups = range(file.meta.num_row_groups)
    numbers = [file.numbers(k, file.names) for k in groups]
    most = sum(numbers) if whole else max(numbers, default=0)
    much = most > MOST_NUMBERS or recording.rows > MOST_ROWS
    if not much and file.content is not None:
        much = sum(file.unpacked_size(k, file.names) for k in groups) > MOST_BYTES
    if much:
        raise InputError(
            f"{name} holds {recording.rows} rows of {len(recording.names)} columns: more than "
            "the laboratory takes"
        )


def demand_own_world(recording: Recording, name: str) -> None:
    """Raise InputError for a world that is too large, or that no page could have made."""
    spec = recording.spec
    if spec.layout is None and spec.world not in layout_names():
        raise unknown("world", str(spec.world), layout_names(), name)
    demand_few(recording.layout, name)
    world: World = recording.world
    demand_small(world, name)
    sides = (*world.size, *map(abs, world.low))
    if max(sides) > MOST_SIDE:
        raise InputError(f"{name}: a side of its world is {max(sides):g}, at most {MOST_SIDE:g}")
    if world.dim not in find_model(spec.model).dimensions:
        raise InputError(f"{name}: {spec.model} is not defined in {world.dim} dimensions")


def demand_playable(flock: StoredFlock, name: str) -> None:
    """Raise InputError for a flock that the laboratory does not take."""
    if flock.most > MOST_AGENTS:
        raise InputError(
            f"{name} has {flock.most} agents: the laboratory takes {MOST_AGENTS} at most"
        )
    flock.flock(Flock, interpret=True)
    _ = flock.spec


def rewrite(name: str, content: bytes) -> bytes:
    """The file written anew by ours, by the process that reads it. Raises InputError."""
    import pyarrow.parquet as pq

    # Not `pq.read_table`: that would see the footer as it came.
    table = read_stored(name, content).recording.file.read()
    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd", row_group_size=REWRITTEN_ROWS)
    return buffer.getvalue()
