"""A flock: a Mesa model whose agents are rows of arrays and whose rule is compiled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import mesa
import numpy as np

from agents import catalogue
from agents.declare import as_floats, checked
from agents.engine.cells import Space
from agents.engine.loop import is_compiled, sweep_module, turns_module
from agents.engine.noise import ANGULAR, VECTORIAL
from agents.engine.runner import Arrays, InTurn, Synchronous
from agents.inspection import Inspection, inspect
from agents.member import Member
from agents.observables.catalogue import OBSERVABLES
from agents.observables.consistency import DESIRED, HOLD, watch_for
from agents.observables.groups import group_labels
from agents.observables.layers import layers
from agents.observables.neighbours import links
from agents.record import Recorder, read_state
from agents.space import FlockSpace
from agents.spec import ACTIVATIONS, NOISES, Spec, versions
from agents.start import Start, given_start, random_headings, random_start
from worlds.refusal import Refusal, unknown
from worlds.world import world as build_world

DENSITY = 4.102
"""Agents per unit of area or volume unless a size is given: rho of Liu et al. 2021, 3.1."""


class Flock(mesa.Model):
    """A flock of one model in one world.

    Parameters
    ----------
    model: name of a model, see `agents.catalogue.MODELS`.
    agents: ordinary agents, >= 1. Information agents come on top: `informed`, by default as many as
        the model is defined with (0 or 1).
    size: side of the box, or one per axis, length > 0; by default such that the density is 4.102.
    dim: 2 or 3. world: `wrap`, `wrap-plain`, `open`, or a TOML file.
    activation: `synchronous`, or `random` or `sequential` for agents that act in turn.
    noise: `angular` or `vectorial`: what `eta` means.
    start: None for random, or arrays `position`, `heading`, `informed`; then `agents` is not used.
    rng: the run's seed, an integer >= 0; None draws one.
    threads: used from 10 000 agents on; the numbers do not depend on it.
    collect: observables that `step` collects into `datacollector`; `agent_reporters` as Mesa's.
    parameters: those of the rule and the body, see `flockscope list`.

    Raises `worlds.refusal.Refusal`, a ValueError, for anything unknown or out of range.

    >>> flock = Flock("hwvem", agents=100, size=4.962, rng=1, p1=0.1)
    >>> flock.run(100)
    >>> flock.observe("consistency") > 0.99
    True
    """

    def __init__(
        self,
        model: str = "hwvem",
        *,
        agents: int = 100,
        size: float | Sequence[float] | None = None,
        dim: int = 2,
        world: str = "wrap",
        informed: int | None = None,
        activation: str = "synchronous",
        noise: str = "angular",
        start: Mapping[str, np.ndarray] | None = None,
        rng: int | None = None,
        threads: int = 1,
        collect: Sequence[str] = ("polarisation",),
        agent_reporters: Mapping[str, Any] | None = None,
        **parameters: Any,
    ):
        self.model = catalogue.model(model)
        seed = int(np.random.SeedSequence().entropy % 2**31) if rng is None else whole("seed", rng, 0)
        if dim not in self.model.dimensions:
            allowed = " or ".join(str(d) for d in self.model.dimensions)
            raise Refusal(f"dim = {dim!r} is not allowed: {model} is defined in {allowed} dimensions")
        if activation not in ACTIVATIONS:
            raise unknown("activation", activation, ACTIVATIONS)
        if noise not in NOISES:
            raise unknown("noise", noise, NOISES)
        agents = whole("agents", agents, 1)
        informed = self.model.informed if informed is None else whole("informed", informed, 0)
        self.parameters = checked(self.model.parameters, parameters)
        if size is None:
            size = ((agents + informed) / DENSITY) ** (1.0 / dim)
        self.world = build_world(world, dim, size)
        super().__init__(rng=seed)
        self.seed = seed
        self.tick = 0
        self.activation = activation
        self.noise = noise
        self.threads = whole("threads", threads, 1)
        if start is None:
            begin, self.given = random_start(self.world, agents, informed, self.rng), False
        else:
            begin, self.given = given_start(self.world, start), True
        self.started_with = len(begin.position) - int(begin.informed.sum()), int(begin.informed.sum())
        self._members: list[Member] | None = None
        self._acted: set[int] = set()
        self._lay_out(begin)
        self.datacollector = mesa.DataCollector(
            model_reporters={name: partial(observed, name=known(name)) for name in collect},
            agent_reporters=dict(agent_reporters or {}),
        )

    def _lay_out(self, begin: Start) -> None:
        """Make the arrays and the engine that runs over them."""
        n = len(begin.position)
        rule = self.model.rule
        self._use(
            Arrays(
                np.ascontiguousarray(begin.position),
                np.ascontiguousarray(begin.heading),
                np.zeros(n),
                begin.informed.astype(np.bool_),
                np.arange(1, n + 1),
                np.full((len(rule.signals), n), n + 1.0),
            )
        )
        self.next_id = n + 1

    def _use(self, arrays: Arrays) -> None:
        """Take these arrays as the flock's state."""
        self.arrays = arrays
        self.position, self.heading, self.speed, self.informed, self.ids, self._memory = arrays
        rule, dim, fields = self.model.rule, self.world.dim, self.model.parameters.model_fields
        module = sweep_module(dim, len(rule.signals), self.model.parts, fields)
        self._P = module.P
        self.compiled_parameters = self._P(**as_floats(self.parameters))
        three = 3 - dim
        space = Space(
            np.pad(np.array(self.world.size), (0, three)),
            np.pad(self.world.wraps.astype(np.int64), (0, three)),
            np.pad(self.world.images.astype(np.int64), (0, three)),
        )
        if self.activation == "synchronous":
            self.engine: Synchronous | InTurn = Synchronous(
                module, arrays, space, self.seed, self.threads
            )
        else:
            turns = turns_module(module)
            self.engine = InTurn(turns, arrays, space, self.seed, self.activation == "random")

    @property
    def reach(self) -> float:
        """The largest distance at which agents notice each other, length."""
        return float(getattr(self.parameters, self.model.rule.reach))

    @property
    def is_compiled(self) -> bool:
        """Whether the compiled loop is at hand, so that the first tick will not wait for it."""
        return is_compiled(self.engine.module)

    @property
    def reference(self) -> np.ndarray | None:
        """The heading that the flock is meant to take, (dim,); None for the mean of the flock."""
        if not self.model.rule.converges or not self.informed.any():
            return None
        return self.heading[np.argmax(self.informed)]

    @property
    def _how(self) -> tuple:
        noise = VECTORIAL if self.noise == "vectorial" else ANGULAR
        return self.compiled_parameters, noise, self.reach

    def set(self, **values: Any) -> None:
        """Change parameters of the running flock. Raises Refusal, and then changes nothing."""
        self.parameters = checked(
            self.model.parameters, {**self.parameters.model_dump(), **values}
        )
        self.compiled_parameters = self._P(**as_floats(self.parameters))

    def step(self) -> None:
        """One tick, and collect the observables; what members have done in this tick stands."""
        self.advance(1)
        self.datacollector.collect(self)

    def run(self, ticks: int) -> None:
        """Run `ticks` ticks (>= 0) in compiled code, without collecting."""
        self.advance(whole("ticks", ticks, 0))

    def advance(self, ticks: int) -> None:
        """Run ticks without collecting anything; frees the GIL while it runs."""
        if ticks > 0 and self._acted:
            for row in range(len(self.ids)):
                if row not in self._acted:
                    self.step_member(row)
            ticks -= 1
        if ticks > 0 and len(self.ids):
            self.engine.run(*self._how, self.tick, ticks)
        self.tick += ticks

    def run_until_consistent(
        self, limit: int, desired: float = DESIRED, hold: int = HOLD, chunk: int = 500
    ) -> int | None:
        """k_con of Liu et al. 2021 (27): ticks until Deg_con >= `desired`, held for `hold` ticks.

        None if it has not come after `limit` ticks. Compiled, in chunks that Ctrl-C can end.
        """
        watch = watch_for(len(self.ids), self.reference, desired, hold)
        while self.tick < limit:
            ticks = min(chunk, limit - self.tick)
            done, last_off = self.engine.run(*self._how, self.tick, ticks, watch)
            self.tick += done
            if done < ticks:
                return last_off + 1
            watch = watch._replace(last_off=last_off)
        return None

    def step_member(self, row: int) -> None:
        """Let one agent decide and move, as `Member.step` does.

        Synchronous: it decides on the flock as it stood when the first agent of the tick stepped,
        whatever has moved since. The tick ends when every agent has stepped, or when one steps for
        a second time: those that have not stepped then stay where they are.
        """
        if row in self._acted:
            self._end_tick()
        if not self._acted:
            self.engine.open(*self._how, self.tick)
        self.engine.one(*self._how, self.tick, row)
        self._acted.add(row)
        if len(self._acted) == len(self.ids):
            self._end_tick()

    def _end_tick(self) -> None:
        self._acted.clear()
        self.tick += 1

    def observe(self, name: str) -> Any:
        """Measure an observable, see `agents.observables.catalogue.OBSERVABLES`."""
        return observed(self, known(name))

    def inspect(self, row: int) -> Inspection:
        """One agent seen from close: whom it listens to and how much."""
        return inspect(self, row)

    def signals(self) -> np.ndarray:
        """What agents tell each other now, (K, N), in the order of the rule's `signals`."""
        if len(self._memory) and len(self.ids) and not self._acted:
            self.engine.open(*self._how, self.tick)
        return self._memory

    def signal(self, name: str) -> np.ndarray:
        """One signal by name, (N,). A layer of N + 1 is unknown. Raises Refusal."""
        names = self.model.rule.signals
        if name not in names:
            raise unknown("signal", name, names)
        return self.signals()[names.index(name)]

    def links(self) -> np.ndarray:
        """Pairs of rows (i < j) within reach of each other, int (M, 2)."""
        return links(self.position, self.reach, self.world.size, self.world.images)

    def group_labels(self) -> np.ndarray:
        """The connected group of each agent, int (N,), 0 the largest."""
        return group_labels(len(self.ids), self.links())

    def layers(self) -> np.ndarray:
        """Hops from an information agent plus 1, as the flock stands; N + 1 unknown; int (N,)."""
        return layers(self.links(), self.informed)

    @property
    def members(self) -> list[Member]:
        """The agents by row; made when first asked for."""
        if self._members is None:
            self._members = []
            self._members.extend(Member(self, row=row) for row in range(len(self.ids)))
        return self._members

    @property
    def agents(self):
        """Mesa's `AgentSet` of all agents; made when first asked for."""
        assert self.members is not None
        return super().agents

    @property
    def agents_by_type(self):
        """Mesa's dictionary of agent sets."""
        assert self.members is not None
        return super().agents_by_type

    @cached_property
    def space(self) -> FlockSpace:
        """Mesa's continuous space over the flock's positions."""
        return FlockSpace(self)

    def append(self, position=None, heading=None, informed: bool = False) -> int:
        """Room for one more agent, random where nothing is given; returns its row.

        `Member(flock, ...)` calls this; the other agents keep their rows and identities.
        """
        members = self.members
        self._finish_tick()
        dim = self.world.dim
        if position is None:
            position = self.rng.uniform(0.0, 1.0, dim) * self.world.size
        if heading is None:
            heading = random_headings(self.rng, 1, dim)[0]
        new = given_start(
            self.world, {"position": [position], "heading": [heading], "informed": [informed]}
        )
        n, k = len(self.ids), len(self._memory)
        self._use(
            Arrays(
                np.concatenate([self.position, new.position]),
                np.concatenate([self.heading, new.heading]),
                np.append(self.speed, 0.0),
                np.append(self.informed, new.informed),
                np.append(self.ids, self.next_id),
                np.hstack([self._memory, np.full((k, 1), n + 2.0)]),
            )
        )
        self.next_id += 1
        return n

    def _finish_tick(self) -> None:
        """End a tick that only some have stepped in; rows are about to change."""
        if self._acted:
            self._end_tick()

    def drop(self, member: Member) -> None:
        """Take an agent's row out; the rows behind it move up, identities stay."""
        self._finish_tick()
        keep = np.arange(len(self.ids)) != member.row
        self._use(Arrays(*(array[keep] for array in self.arrays[:-1]), self._memory[:, keep]))
        members = self.members
        del members[member.row]
        for later in members[member.row :]:
            later.row -= 1

    @property
    def spec(self) -> Spec:
        """This run as a value, with its parameters as they are now."""
        return Spec(
            model=self.model.name,
            agents=self.started_with[0],
            informed=self.started_with[1],
            seed=self.seed,
            world=self.world.name,
            size=self.world.size,
            activation=self.activation,
            noise=self.noise,
            start="given" if self.given else "random",
            parameters=self.parameters.model_dump(),
            versions=versions(),
        )

    @classmethod
    def from_spec(cls, spec: Spec, **more: Any) -> Flock:
        """The run that a spec describes, at its first tick. Raises Refusal."""
        if spec.start == "given" and "start" not in more:
            raise Refusal(
                "start = 'given' in the spec: a run from given arrays begins again only from its "
                "saved state, with Flock.load"
            )
        return cls(
            spec.model,
            agents=spec.agents,
            informed=spec.informed,
            size=spec.size,
            dim=spec.dim,
            world=spec.world,
            activation=spec.activation,
            noise=spec.noise,
            rng=spec.seed,
            **more,
            **spec.parameters,
        )

    def save(self, path: str | Path) -> None:
        """Write the state to a Parquet file; `Flock.load` goes on from it to the bit."""
        with Recorder(path, self) as recorder:
            recorder.write()

    @classmethod
    def load(cls, path: str | Path, tick: int | None = None, **more: Any) -> Flock:
        """The flock of a saved state, or of one tick (the last) of a recording. Raises Refusal."""
        saved = read_state(path, tick)
        start = {"position": saved.arrays.position, "heading": saved.arrays.heading}
        flock = cls.from_spec(saved.spec, start=start, **more)
        flock.given = saved.spec.start == "given"
        flock.started_with = saved.spec.agents, saved.spec.informed
        flock.tick, flock.next_id = saved.tick, saved.next_id
        flock._use(saved.arrays)
        return flock


def whole(name: str, value: Any, least: int) -> int:
    """`value` as a whole number >= `least`. Raises Refusal."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise Refusal(f"{name} = {value!r} is not allowed: a whole number >= {least} is needed")
    return int(value)


def known(name: str) -> str:
    """The name of an observable. Raises Refusal."""
    if name not in OBSERVABLES:
        raise unknown("observable", name, OBSERVABLES)
    return name


def observed(flock: Flock, name: str) -> Any:
    """The value of an observable now."""
    return OBSERVABLES[name].measure(flock)
