"""A flock: a Mesa model whose agents are rows of arrays and whose rule is compiled."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Never, Unpack

import numpy as np
from pydantic import BaseModel

from agents import catalogue
from agents.engine.noise import compile_draws
from agents.flock_world import complete_spec, is_built_in, world_of_any_seed
from agents.inspection import Inspection, compile_inspection, inspect
from agents.kinds import INFORMED, Kind, KindTable, kind_table
from agents.mesa_import import mesa
from agents.mesa_interface import FlockSpace, Member, TickClock
from agents.models.declare import checked
from agents.models.model import Model
from agents.models.sources import cite
from agents.motion.flock_start import FlockStart
from agents.observables.catalogue import OBSERVABLES
from agents.option import whole_number
from agents.recordings.recorder import STATES, Recorder
from agents.recordings.recording import Recording
from agents.snapshot import Snapshot
from agents.spec import DEFAULT, LARGEST_SEED, OPTIONS, CompleteSpec, Spec, versions
from agents.state.agent_rows import (
    demand_memory_for,
    join_arrays,
    resize_past,
    select_rows,
    start_arrays,
)
from agents.state.passages import Passages
from agents.state.start import (
    free_positions,
    random_headings,
)
from agents.strips.strip_engine import checked_ranks
from worlds.generators import draw_obstacles
from worlds.input_error import InputError, shorten, unknown
from worlds.notebook_html import arrows, table

if TYPE_CHECKING:
    import pandas as pd

    from agents.flock_words import FlockWords, ParameterWords

OTHER_WORDS = {word: name for name, one in OPTIONS.items() for word in one.also}
"""What other tools call an option -> its name."""
MOST_DRAWN = 1_000
"""Agents in the picture that a notebook shows of a flock."""
MOST_THREADS = 1024
MADE_ANEW = {
    *("_engine", "_kept_start", "_policies", "_wind"),
    *("context", "passing", "pilots", "processes", "tell"),
}
"""Attributes of a flock that follow from the others, hold compiled code or processes, or are of
whoever runs it."""
OWN_WORDS = (
    *("start", "rng", "threads", "ranks", "interpret"),
    *("collect", "model_reporters", "agent_reporters"),
    *("kinds", "to", "members"),
)
"""What `Flock` takes beside options and parameters."""


class Flock(TickClock, FlockStart):
    """A flock of one model in one world.

    Parameters
    ----------
    model: name of a model, see `flockscope.MODELS`; a file has its rule put among them by
        `flockscope.from_file`. Or a `Spec`, which says more of the run.
    start: None for random, or arrays `position`, `heading` and, if wanted, `speed`, `informed`;
        `agents` is then not used. Positions are outside of obstacles, and in the box along axes
        that wrap or are solid; without speeds agents set off as at a random start, and those of a
        body of one speed have that.
    rng: the run's seed, an integer in [0, 2^63), or `seed`; None draws one. Of anything else that
        NumPy makes a generator of, as a `numpy.random.Generator`, the seed is the next number.
    threads: 1 to 1024, used from 10 000 agents on, or 20 000 of a rule that is no sum over pairs;
        the numbers do not depend on it.
    ranks: 1 to 1024 processes of this machine that share each tick, or a client of Dask, of which
        each worker is one; the numbers do not depend on it. See `docs/scale.md`. InputError for
        what strips cannot do. A copy of a flock of a client runs in one process.
    interpret: run the model as plain Python, some thousand times slower, with `print` and `pdb`;
        the numbers are the same up to rounding. All flocks do under NUMBA_DISABLE_JIT=1.
    collect: observables that `step` collects into `datacollector`; `model_reporters` and
        `agent_reporters` as Mesa's. A seed that was drawn is a column `seed`.
    kinds: kinds of agents beside the ordinary ones, `flockscope.Kind`; see docs/kinds.md.
    to: what the ordinary agents do about other kinds: `{"shark": flee(2.0)}`.
    members: the class of Mesa's agents of a kind, a subclass of `Member`, by the kind's name.
    words: options of the run, by default as the model or its world has them, and parameters of the
        rule and the body, see `flockscope list`. The options (see `Spec`) are
        agents: ordinary agents, >= 1. Information agents come on top: informed, >= 0;
        world: a layout by name (see `flockscope.worlds.layout_names`), a TOML file or a `World`;
        size: side of the box, or one per axis, length > 0; by default the layout's own, or such
        that the density is the model's, 4.102 unless its paper has another;
        dim: 2 or 3; by default as many as `size` has sides, the layout's own, or the model's;
        activation: `synchronous`, or `random` or `sequential` for agents that act in turn;
        noise: `angular` or `vectorial`: what `eta` means; one that is part of a rule stays;
        delay, jitter, lost: how old what agents know of each other is, time >= 0, and the share of
        messages that get lost, in [0, 0.99]; place_error: how exactly they know where others are;
        wind, wind_heading, wind_up, gusts, gust_time, pulse, pulse_at, pulse_lasts: what carries
        them along, see `agents.conditions.Conditions`;
        spacing: least distance at the start between agents and of agents to obstacles and solid
        edges, length >= 0; the model's own may be None: bodies only start clear of what is solid.

    Raises `flockscope.InputError`, a ValueError, for anything unknown or out of range.

    >>> from flockscope import Flock
    >>> flock = Flock("hwvem", agents=100, size=4.962, rng=1, p1=0.1)
    >>> flock.run(100)
    >>> flock.observe("consistency") > 0.99
    True
    """

    def __init__(
        self,
        model: str | Spec = DEFAULT,
        *others: Never,
        start: Mapping[str, np.ndarray] | None = None,
        rng: Any = None,
        threads: int = 1,
        ranks: Any = 1,
        interpret: bool = False,
        collect: Sequence[str] = ("polarisation",),
        model_reporters: Mapping[str, Any] | None = None,
        agent_reporters: Mapping[str, Any] | None = None,
        kinds: Sequence[Kind] = (),
        to: Mapping[str, Any] | None = None,
        members: Mapping[str, type[Member]] | None = None,
        **words: Unpack[FlockWords],
    ):
        values: dict[str, Any] = {**words}
        demand_names(model, others, values)
        rng = seed_from(rng)
        if rng is not None and values.setdefault("seed", rng) != rng:
            raise InputError(
                f"rng = {rng} and seed = {values['seed']}: both are the seed, give one"
            )
        spec_request = (model if isinstance(model, Spec) else Spec(model)).taking(**values)
        if kinds or to:
            spec_request = spec_request.but(
                kinds=kinds or spec_request.kinds, to=to or spec_request.to
            )
        if spec_request.start == "given" and start is None:
            raise InputError(
                "start = 'given' in the spec: a run from given arrays begins again only from its "
                "saved state, with Flock.load"
            )
        self.model = catalogue.model(spec_request.model)
        self.threads = whole_number("threads", threads, 1, MOST_THREADS)
        spec = complete_spec(spec_request, self.model)
        self._member_types = member_types(members or {}, kind_table(spec.kinds, spec.to))
        demand_memory_for(self.model, spec.count, self.threads)
        self.interpret = interpret
        self.ranks = checked_ranks(ranks)
        spec = spec.model_copy(update={"start": "random" if start is None else "given"})
        demand_own_words(self.model, spec.parameters)
        self.parameters = checked(
            self.model.parameters, spec.parameters, other_names=(*OPTIONS, *OWN_WORDS)
        )
        self._beginning = spec, world_of_any_seed(spec, self.model)
        if spec.informed and not self.model.rule.led:
            raise InputError(
                f"informed = {spec.informed} is not allowed: {spec.model} has no information agents"
            )
        reporters: dict[str, Any] = {
            name: partial(measure_observable, name=known_observable(name)) for name in collect
        }
        if spec_request.seed is None:
            reporters["seed"] = "seed"
        reporters |= {
            name: partial(measure_observable, name=what)
            if isinstance(what, str) and what in OBSERVABLES
            else what
            for name, what in (model_reporters or {}).items()
        }
        self._reporters = reporters, dict(agent_reporters or {})
        self.seed = spec.seed
        self._begin_model()
        self.model.demand_individual(spec.individuals)
        self._demand_kinds(kind_table(spec.kinds, spec.to))
        self._begin(spec.seed, start)
        if self.ranks != 1:
            self._demand_strips()

    def _begin(
        self, seed: int, start: Mapping[str, Any] | None = None, is_same: bool = False
    ) -> None:
        """Be at tick 0 of the run with a seed. Raises InputError.

        `is_same`: only the seed is another one than that of the run that it was at.
        """
        spec, world = self._beginning
        self.seed = seed
        self.world = draw_obstacles(world, seed)
        self.tick = 0
        self.options = spec
        self.individuals, self.redrawn, self.drawn = dict(spec.individuals), {}, {}
        self.kinds = kind_table(spec.kinds, spec.to)
        self.catches = Passages.none(self.world.dim)
        self._policies = None
        if not is_same:
            self._kept_start = None
        is_drawn = self._kept_start is None
        arrays = self._random_start([seed]) if start is None else self._given_start(start)
        informed_count = int(arrays.informed.sum())
        ordinary = len(arrays.ids) - informed_count - spec.count_of_kinds
        counts = {"agents": ordinary, "informed": informed_count}
        self.options = spec.model_copy(update={"seed": seed} | counts)
        self._members: list[Member] | None = None
        self._acted: set[int] = set()
        self.next_id = len(arrays.ids) + 1
        if is_same and len(self.ids) == len(arrays.ids):
            self._swap_arrays(arrays, is_drawn)
        else:
            self._set_arrays(arrays)
        self._begin_gates()
        model_reporters, agent_reporters = self._reporters
        self.datacollector = mesa.DataCollector(
            model_reporters=dict(model_reporters), agent_reporters=dict(agent_reporters)
        )

    def restart(self, seed: int) -> None:
        """Begin the same run anew with another seed, as a new flock would, to the bit.

        It takes a third of the time of a new one: what was checked, found and compiled for the run
        is used again. Agents, parameters and world are again those that the flock was made with;
        its members are gone, and so is what was collected. Raises InputError for a seed that is
        none, a run from given arrays, and obstacles of that seed among which there is no room.

        >>> from flockscope import Flock
        >>> flock = Flock("vem", agents=30, size=5.0, rng=1)
        >>> flock.run(10)
        >>> flock.restart(2)
        >>> flock
        <Flock vem, N = 30, world wrap, tick 0, seed 2>
        """
        if self._beginning[0].start == "given":
            raise InputError(
                "a run from given arrays has no random start: restart needs one, make a new Flock"
            )
        seed = whole_number("seed", seed, 0, LARGEST_SEED)
        compile_draws()
        spec, world = self._beginning
        parameters = checked(self.model.parameters, spec.parameters)
        is_same = self.ranks == 1 and self.world is world and self.parameters == parameters
        is_same = is_same and self.individuals == spec.individuals
        is_same = is_same and self.kinds == kind_table(spec.kinds, spec.to)
        is_same = is_same and not self.kinds.with_model  # whose passes have copies of the arrays
        self.parameters = parameters
        for member in self._members or ():
            member.leave()
        self.__dict__.pop("space", None)
        self._put_off_model()
        self._begin(seed, is_same=is_same)

    def catches_of(self, kind: str) -> Passages:
        """Those of a kind who were caught; not known of information agents. Raises InputError.

        The agents of kinds have the last identities of those with which a run begins; who enters
        later is ordinary.
        """
        if kind == INFORMED and INFORMED not in self.kinds.names:
            return replace(self.catches, is_known=False)
        first = self.options.agents + self.options.informed
        ends = first + np.cumsum([0, *(one.agents for one in self.kinds.kinds)])
        number = np.searchsorted(ends, self.catches.id, side="left")
        return self.catches.select(
            np.where(number == len(ends), 0, number) == self.kinds.number(kind)
        )

    def _has_parameter(self, name: str) -> bool:
        """Whether a name that nothing else has is that of a parameter."""
        own = self.__dict__
        parameters = own.get("parameters")  # a dictionary while a saved flock is restored
        return (
            name not in own
            and isinstance(parameters, BaseModel)
            and name in type(parameters).model_fields
        )

    def __getattr__(self, name: str) -> Any:
        """A parameter by its name; where agents differ in it, the number of each, (N,)."""
        if not self._has_parameter(name):
            return super().__getattr__(name)
        return self.own[name] if name in self.differing else getattr(self.parameters, name)

    def __setattr__(self, name: str, value: Any) -> None:
        """A parameter that is assigned is set, as by `set`: InputError if it is not allowed."""
        if self._has_parameter(name) and not hasattr(type(self), name):
            self.set(**{name: value})
        else:
            super().__setattr__(name, value)

    def __repr__(self) -> str:
        return (
            f"<Flock {self.model.name}, N = {len(self.ids)}, world {self.world.name}, "
            f"tick {self.tick}, seed {self.seed}>"
        )

    def _repr_html_(self) -> str:
        total, low, size = len(self.ids), np.asarray(self.world.low), np.asarray(self.world.size)
        apart = max(1, math.ceil(total / MOST_DRAWN))
        position, heading = self.position[::apart], self.heading[::apart]
        rows = {"agents": total, "world": self.world.name, "size": self.world.size}
        if apart > 1:
            rows["drawn"] = f"one agent of {apart}"
        beyond = np.any((self.position < low) | (self.position > low + size), axis=1).sum()
        if beyond:
            rows["outside the picture"] = int(beyond)
        rows |= {"tick": self.tick, "seed": self.seed, "polarisation": self.observe("polarisation")}
        picture = self.world.picture(arrows(position, heading, float(max(size)) / 80))
        return table(rows | self.parameters.model_dump(), self.model.title, picture)

    def to_dataframe(self) -> pd.DataFrame:
        """The agents as they are now, in the order of `position`, as a `pandas.DataFrame` by `id`.

        Columns: `x`, `y` and in space `z`, length; `heading_x`, `heading_y` (and `heading_z`), a
        unit vector; `speed`, the distance of the last tick, length/tick; `informed`; then the
        parameters that differ from agent to agent. Copies: what the flock does later changes none
        of them.

        >>> from flockscope import Flock
        >>> Flock("vem", agents=3, size=5.0, rng=1).to_dataframe().columns.tolist()
        ['x', 'y', 'heading_x', 'heading_y', 'speed', 'informed']
        """
        import pandas as pd

        axes = "xyz"[: self.world.dim]
        columns: dict[str, Any] = {axis: self.position[:, k] for k, axis in enumerate(axes)}
        columns |= {f"heading_{axis}": self.heading[:, k] for k, axis in enumerate(axes)}
        columns |= {"speed": self.speed, "informed": self.informed.astype(bool), **self.own}
        if self.kinds.kinds:
            columns["kind"] = self.kind_names
        return pd.DataFrame(
            {name: column.copy() for name, column in columns.items()},
            index=pd.Index(self.ids.copy(), name="id"),
        )

    def cite(self) -> str:
        """BibTeX of the papers that its model comes from, empty if it names none."""
        return "\n\n".join(cite(self.model))

    def step(self) -> None:
        """One tick, and collect the observables; what members have done in this tick stands."""
        self.advance(1)
        self.datacollector.collect(self)

    def run(self, ticks: int) -> None:
        """Run `ticks` ticks (>= 0) in compiled code, without collecting."""
        self.advance(whole_number("ticks", ticks, 0))

    def observe(self, name: str, *subscription: Any, kind: str | None = None) -> Any:
        """Measure an observable, see `agents.observables.catalogue.OBSERVABLES`.

        `kind`: of the agents of a kind alone, or of the information agents (`informed`), as if
        there were no others. Raises InputError. With a signal and a handler it subscribes to a Mesa
        observable, such as `time`, as in Mesa.
        """
        if subscription:
            return super().observe(name, *subscription)
        return measure_observable(self, known_observable(name), kind)

    def inspect(self, row: int) -> Inspection:
        """One agent seen from close: whom it listens to and how much."""
        snapshot = self.snapshot(copy=False, signals=True).by_model_of(row)
        surroundings, context = self.surroundings_of(row), self.context_of(row)
        return inspect(snapshot, surroundings, context, row, self.interpret)

    def warm(self) -> None:
        """Compile what `inspect` calls, which takes seconds; the flock may run on meanwhile."""
        snapshot = self.snapshot(copy=False)
        compile_inspection(snapshot, self.engine.surroundings, self.context, self.interpret)
        for one in self.kind_models:
            for row in self.rows_of(one.kind.name)[:1].tolist():
                surroundings, context = self.surroundings_of(row), self.context_of(row)
                compile_inspection(snapshot.by_model_of(row), surroundings, context, self.interpret)

    def set_kind(self, kind: str, **values: Unpack[ParameterWords]) -> None:
        """Change parameters of the agents of a kind alone. Raises InputError, and then changes
        nothing."""
        names = self.kinds.names
        if kind not in names[1:]:
            raise unknown("kind", kind, names[1:])
        kinds = tuple(
            one.with_parameters(values) if one.name == kind else one for one in self.kinds.kinds
        )
        self.change_kinds(replace(self.kinds, kinds=kinds))

    def relate(self, kind: str, other: str, relation: Any) -> None:
        """Change what the agents of a kind do about those of another: `chase(2.0, 10.0)`, `flee`,
        `"own"`, `"ignore"`. Raises InputError, and then changes nothing."""
        self.change_kinds(self.kinds.with_relation(kind, other, relation))

    def change_kinds(self, kinds: KindTable) -> None:
        """Go on with other parameters and relations of the same kinds. Raises InputError, and then
        changes nothing."""
        before = self.kinds
        if kinds.names != before.names:
            raise InputError(
                f"kinds {', '.join(kinds.names)} are not allowed: this flock has "
                f"{', '.join(before.names)}"
            )
        for one, other in zip(kinds.kinds, before.kinds, strict=True):
            if one.model != other.model:
                raise InputError(
                    f"kind {one.name}: model = {one.model or self.model.name} is not allowed: a "
                    f"running flock keeps its models, here {other.model or self.model.name}"
                )
        self._demand_kinds(kinds)
        self.kinds = kinds
        try:
            kind = self.arrays.kind
            own = self._own_of(self.ids, self.parameters, {}, self.individuals, kind, before)
        except InputError:
            self.kinds = before
            raise
        for name in self.individuals:
            column = self.own_columns.index(name)
            rows = ~np.isin(self.arrays.kind, kinds.numbers_with(name)) & self.goes_by_model
            own[rows, column] = self.arrays.own[rows, column]
        self._take_own(self.parameters, self.individuals, own, self.loop)

    @property
    def members(self) -> list[Member]:
        """The agents by row; made when first asked for."""
        if self._members is None:
            self._members = []
            self._match_members()
        return self._members

    def _match_members(self) -> None:
        """Let the members follow the rows by identity; those whose agent is not there are gone."""
        if self._members is None:
            return
        by_identity = {member.unique_id: member for member in self._members}
        ids = self.ids.tolist()
        if list(by_identity) == ids:
            return
        self._members = []
        for identity in by_identity.keys() - ids:
            self._deregister(by_identity.pop(identity))
        for row in np.argsort(self.ids).tolist():
            member = by_identity.get(ids[row])
            if member is None:
                kind = str(self.kind_names[row]) if self._member_types else ""
                by_identity[ids[row]] = self._member_types.get(kind, Member)(self, row=row)
            else:
                member.row = row
        self._members.extend(by_identity[identity] for identity in ids)

    @property
    def agents(self):
        """Mesa's `AgentSet` of all agents, by identity; made when first asked for."""
        _ = self.members
        return super().agents

    @agents.setter
    def agents(self, agents: Any) -> None:
        mesa.Model.agents.fset(self, agents)

    @property
    def agents_by_type(self):
        """Mesa's dictionary of agent sets."""
        _ = self.members
        return super().agents_by_type

    @property
    def agent_types(self) -> list[type]:
        """The types of its agents."""
        _ = self.members
        return super().agent_types

    @property
    def agent_id_counter(self) -> int:
        """The identity that the next agent will have."""
        return self.next_id

    @agent_id_counter.setter
    def agent_id_counter(self, value: int) -> None:
        self.next_id = value

    @cached_property
    def space(self) -> FlockSpace:
        """Mesa's continuous space over the flock's positions."""
        return FlockSpace(self)

    def append(self, member: Member, position, heading, informed: bool) -> int:
        """Make a row for a new agent, random where None is given, and return it.

        `Member(flock, ...)` calls this; the other agents keep their rows and identities.
        """
        self._end_tick()
        members = self.members
        dim, identity = self.world.dim, np.array([self.next_id])
        if position is None:
            gap = self._start_gap(self._own_of_new(identity))
            position = free_positions(self.world, identity, self.seed, gap=gap)[0]
        if heading is None:
            heading = random_headings(self.seed, identity, dim)[0]
        new, own = self._start_from_arrays(
            {"position": [position], "heading": [heading], "informed": [informed]}, self.next_id
        )
        ages = self.arrays.past.shape[1]
        new_arrays = start_arrays(new, self.model, self.next_id)
        new_arrays = self._as_ordinary(new_arrays, own)
        new_arrays = resize_past(new_arrays, ages, len(self.model.signals), self.tick)
        self._set_arrays(join_arrays(self.arrays, new_arrays))
        self.next_id += 1
        members.append(member)
        return len(self.ids) - 1

    def register_agent(self, agent: mesa.Agent) -> None:
        """Take an agent into Mesa's sets, as `mesa.Agent` does when it is made.

        A member has the identity of its row. Other Mesa agents are given the next one.
        """
        if not isinstance(agent, Member):
            _ = self.members
            super().register_agent(agent)
            return
        next_id, self.next_id = self.next_id, int(self.ids[agent.row])
        super().register_agent(agent)
        self.next_id = next_id

    def deregister_agent(self, agent: mesa.Agent) -> None:
        """Take an agent out of the flock, as `Agent.remove` does. KeyError if it is not there.

        The rows behind it move up; identities stay. A tick in which agents have stepped one by one
        ends before.
        """
        self._end_tick()
        if not isinstance(agent, Member):
            super().deregister_agent(agent)
        elif agent.is_gone or agent.model is not self:
            raise KeyError(agent)
        else:
            self._take_out([agent])

    def remove_all_agents(self) -> None:
        """Remove all agents, those that nobody has asked for yet among them."""
        self._end_tick()
        # Removed one by one, N agents copy the arrays N times.
        self._take_out([m for m in self.members if type(m).remove is Member.remove])
        super().remove_all_agents()

    def _take_out(self, members: Sequence[Member]) -> None:
        """Take members and their rows out, at once."""
        rows = [member.row for member in members]
        for member in members:
            self._deregister(member)
        self._set_arrays(select_rows(self.arrays, np.delete(np.arange(len(self.ids)), rows)))
        self._members = [member for member in self.members if not member.is_gone]
        for row, member in enumerate(self._members):
            member.row = row

    def _deregister(self, member: Member) -> None:
        """Take a member out of Mesa's sets; from then on it is gone."""
        super().deregister_agent(member)
        member.leave()

    def reset_rng(self, rng: Any = None) -> None:  # noqa: ARG002 - as in Mesa
        """Refused: the noise of a run follows its seed alone."""
        raise InputError(
            "reset_rng would not reset a flock: its noise follows its seed, tick and agents; make "
            "a new Flock(..., rng=SEED)"
        )

    def reset_randomizer(self, seed: int | None = None) -> None:  # noqa: ARG002 - as in Mesa
        """Refused, as `reset_rng`."""
        raise InputError(
            "reset_randomizer would not reset a flock: its noise follows its seed, tick and "
            "agents; make a new Flock(..., rng=SEED)"
        )

    def __getstate__(self) -> dict[str, Any]:
        """All but what is compiled. Raises InputError within a tick of agents that step one by
        one."""
        self._demand_whole_tick()
        state = {name: value for name, value in vars(self).items() if name not in MADE_ANEW}
        own = {"model": self.model.name, "parameters": self.parameters.model_dump()}
        return state | own | {"ranks": self.ranks if isinstance(self.ranks, int) else 1}

    def _demand_whole_tick(self) -> None:
        if self._acted:
            raise InputError(
                f"tick {self.tick} is not over: {len(self._acted)} of {len(self.ids)} agents have "
                "stepped; save, copy or pickle the flock between ticks"
            )

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.options = CompleteSpec(**dict(self.options))  # those of before were of type `Spec`
        self.model = catalogue.model(state["model"])
        self.parameters = checked(self.model.parameters, state["parameters"])
        self._set_arrays(self.arrays)

    @property
    def spec(self) -> CompleteSpec:
        """This run as a value, with its world and its parameters as they are now."""
        return self.options.with_parameters(
            self.all_parameters,
            world=self.world.name,
            size=self.world.size,
            dim=self.world.dim,
            kinds=self.all_kinds,
            to=self.kinds.to,
            layout=None if is_built_in(self.world, self.seed) else self.world.to_layout(),
            versions=versions(),
        )

    @classmethod
    def from_spec(cls, spec: Spec, **more: Any) -> Flock:
        """The run that a spec describes, at its first tick. Raises InputError."""
        return cls(spec, **more)

    def save(self, path: str | Path) -> None:
        """Write the state to a Parquet file; `Flock.load` goes on from it to the bit.

        The name ends in .parquet or .pq; a file of that name is replaced. Raises InputError, also
        within a tick of agents that step one by one, and for a flock of nobody.
        """
        self._demand_whole_tick()
        if not len(self.ids):
            raise InputError(
                f"the flock is empty at tick {self.tick}: a state holds one agent at least"
            )
        with Recorder(path, self, endings=STATES, with_past=True) as recorder:
            recorder.write()

    @classmethod
    def load(cls, path: str | Path, tick: int | None = None, **more: Any) -> Flock:
        """The flock of a saved state, or of one tick (the last) of a recording. Raises
        InputError."""
        recording = Recording(path)
        return cls.from_snapshot(recording.spec, recording.state(tick), **more)

    @classmethod
    def from_snapshot(cls, spec: Spec, saved: Snapshot, **more: Any) -> Flock:
        """The run of a spec as it was in a snapshot, from which it goes on. Raises InputError."""
        start = {"position": saved.position, "heading": saved.heading}
        run = complete_spec(spec, catalogue.model(spec.model))
        # Without its kinds: of these some may have been caught, and fewer be left than it asks for.
        flock = cls(run.but(kinds=(), to={}), start=start, **more)
        flock._demand_kinds(saved.kinds)
        flock.options = run
        flock.return_to(saved)
        return flock


def member_types(members: Mapping[str, type[Member]], kinds: KindTable) -> dict[str, type[Member]]:
    """The classes of Mesa's agents by the names of kinds. Raises InputError."""
    for name, member in members.items():
        if name not in kinds.names:
            raise unknown("kind", name, kinds.names, "members")
        if not (isinstance(member, type) and issubclass(member, Member)):
            raise InputError(f"members: {name} = {shorten(member)} is no subclass of Member")
    return dict(members)


def demand_names(model: Any, others: Sequence[Any], words: Mapping[str, Any]) -> None:
    """Refuse values that have no name, and words of other tools. Raises InputError."""
    number = isinstance(model, int | float | np.number)
    if others or number:
        given = shorten(model if number else others[0])
        raise InputError(
            f"Flock takes the name of a model, and everything else by name, as in "
            f"Flock('vem', agents=50): {given} has none"
        )
    if "scenario" in words:
        raise InputError(
            "scenario is not a parameter of Flock: give its values by name, as in "
            "Flock('vem', agents=50, eta=0.5), or as a flockscope.Spec"
        )


def demand_own_words(model: Model, words: Mapping[str, Any]) -> None:
    """Refuse what other tools call an option, with its name here. Raises InputError."""
    for word in words:
        if word in OTHER_WORDS and word not in model.parameters.model_fields:
            raise InputError(f"unknown option {word!r}: it is called {OTHER_WORDS[word]!r} here")


def seed_from(rng: Any) -> Any:
    """A seed of what Mesa takes as `rng`: numbers stand, of a generator it is the next number."""
    if isinstance(rng, np.integer):
        return int(rng)
    many = isinstance(rng, (list, tuple, np.ndarray))
    random = (np.random.Generator, np.random.BitGenerator, np.random.SeedSequence)
    if not many and not isinstance(rng, random):
        return rng
    try:
        return int(np.random.default_rng(rng).integers(2**31))
    except (TypeError, ValueError) as error:
        raise InputError(f"rng = {rng!r} is not allowed: {error}") from None


def known_observable(name: str) -> str:
    """The name of an observable. Raises InputError."""
    if name not in OBSERVABLES:
        raise unknown("observable", name, OBSERVABLES)
    return name


def measure_observable(flock: Flock, name: str, kind: str | None = None) -> Any:
    """The value of an observable now; of the agents of a kind alone, where one is named."""
    snapshot = flock.snapshot(copy=False)
    if kind is not None:
        snapshot = replace(snapshot.of_kind(kind), catches=flock.catches_of(kind))
    return OBSERVABLES[name].measure(snapshot.measurable())
