"""The flock's arrays in motion: the state, the compiled loop over it, the ticks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property, partial
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from agents import catalogue
from agents.conditions import Wind, messages, ticks_back
from agents.engine import runner
from agents.engine.arrays import NEVER, Arrays, Context, EngineStopCondition, WorldContext
from agents.engine.cells import Space
from agents.engine.compiled_loop import delayed_module, is_compiled, loop_module, turns_module
from agents.engine.heeding import COLUMNS
from agents.engine.noise import ANGULAR, NO_WIND, VECTORIAL
from agents.engine.pairs import pair_runner
from agents.engine.pairs.pair_runner import PairEngine
from agents.engine.pass_engine import ModelPass, PassEngine, copy_moving
from agents.engine.runner import (
    UNTRACED,
    DelayedEngine,
    SequentialEngine,
    SynchronousEngine,
)
from agents.individuals import (
    BY_HAND,
    Distribution,
    draw_values,
    normal,
    split_individuals,
)
from agents.kind_models import demand_kind_models, shared_numbers
from agents.kinds import NO_KINDS, KindTable
from agents.models.declare import NumberParameter, Parameters, as_floats, checked, describe
from agents.models.model import Model
from agents.models.model_calls import call
from agents.observables.consistency import DESIRED, HOLD, is_consistent, stop_when_consistent
from agents.snapshot import FlockState, Snapshot
from agents.spec import CompleteSpec, Options
from agents.state.agent_rows import StrayAgents, resize_past, select_rows, stray
from agents.strips.strip_engine import (
    RankProcesses,
    StripEngine,
    longest_stride,
    reason_for_one_process,
)
from worlds.compilation import DISABLED
from worlds.input_error import InputError
from worlds.memory import demand_memory
from worlds.number_text import counted
from worlds.queries.surroundings import Surroundings
from worlds.queries.survey import survey_world
from worlds.world import World

if TYPE_CHECKING:
    from agents.flock_words import ParameterWords

NOISE = "eta"
"""The parameter that the engine takes for the noise intensity; a rule without it has no noise."""
NOT_NEAREST = (
    "kinds are not allowed where the nearest are neighbours, whatever their distance: set "
    "neighbours=metric"
)
NO_RELATIONS = np.empty((0, 0, COLUMNS))
STRETCH = 100_000
"""Ticks for which the wind is known in advance."""
CHUNK = 500
"""Ticks of a long run between two looks at the world outside."""


LoopKind = tuple[int, bool, bool, bool, bool, bool, bool]
"""What `loop_of` asks for beside the model."""


class Motion(FlockState):
    """State and ticks of a flock; what `agents.Flock` is beside a Mesa model.

    The arrays are the truth and may be written to between ticks.
    """

    options: Options = Options()
    """How agents act."""
    threads: int
    next_id: int
    ranks: Any = 1
    """Processes that share a tick, or a client of Dask whose workers do."""
    interpret: bool = False
    """Whether the model runs as plain Python, slowly, with `print` and `pdb`."""
    context: Context
    """What every agent goes by: the compiled parameters, kind of noise and reach."""
    passing: str
    """The setting with which agents go through what is solid here, or an empty string."""
    split_from: int | None = None
    """Agents from which on a tick is shared among threads; None: as it is worth it."""
    _engine: SynchronousEngine | PairEngine | SequentialEngine | PassEngine | StripEngine | None
    _wind: Wind
    _beginning: tuple[CompleteSpec, World]
    """The run as it began, and its world before random obstacles are drawn."""
    _acted: set[int]
    """Rows that have stepped in a tick that is not over."""
    redrawn: Mapping[str, int] = MappingProxyType({})
    """How many of the agents' numbers were drawn again, by parameter: `eta`, of the agents of a
    kind `eta of shark`."""
    drawn: Mapping[str, int] = MappingProxyType({})
    """Of how many agents, by the same names."""
    tell: Callable[[str], object] = staticmethod(lambda line: None)  # noqa: ARG005
    """What is given a line that whoever watches is to be told while it runs."""
    _came_from: tuple[np.ndarray, np.ndarray] | None = None
    """Where agents were before the last tick, by identity; None where that is not known."""

    def _set_arrays(self, arrays: Arrays) -> None:
        """Take these arrays as the flock's state."""
        if len(arrays.own) != len(arrays.ids):  # a flock that was pickled before there were any
            arrays = arrays._replace(own=np.empty((len(arrays.ids), 0)))
        no_wishes = self._no_wishes(len(arrays.ids))
        if len(no_wishes) != len(arrays.wish):  # a file does not hold them
            arrays = arrays._replace(wish=no_wishes)
        self.arrays = arrays
        self._engine = None
        self.context = self._make_context()
        self._make_past()

    def _swap_arrays(self, arrays: Arrays) -> None:
        """Take arrays of as many agents, which begin the same run with another seed."""
        self.arrays = arrays
        if self._engine is not None:
            assert not isinstance(self._engine, PassEngine)
            self._engine.arrays, self._engine.seed = arrays, self.seed
        if self.differing:
            self._follow_own()
        elif self.options.is_windy:
            self._wind = Wind(self.options, self.seed, self.dt, self.world.dim)
        self._make_past()

    def _follow_own(self) -> None:
        """Have the loop go by the agents' own numbers as they are now: by how far they notice each
        other, and what is solid."""
        self.context = self._make_context()
        if self._engine is not None and self.sight > self._engine.surroundings.reach:
            self._engine = None

    def _make_past(self) -> None:
        """Keep as much of the past as messages may tell of."""
        ages = ticks_back(self.options, self.dt)
        if ages != self.arrays.past.shape[1]:
            size = 2 * self.world.dim + 1 + len(self.model.signals)
            demand_memory("what messages tell", float(len(self.ids)) * ages * size * 8)
            self.arrays = resize_past(self.arrays, ages, len(self.model.signals), self.tick)
            self._engine = None

    @property
    def of_pairs(self) -> bool:
        """Whether agents act eight at once: see `agents.engine.pairs`."""
        return self._is_of_pairs(self.model)

    def _is_of_pairs(self, model: Model) -> bool:
        """Whether agents of a model act eight at once here."""
        interpreted = self.interpret or DISABLED
        is_synchronous = self.options.activation == "synchronous" and not self.options.is_late
        return model.is_of_pairs and is_synchronous and not interpreted

    @property
    def loop(self) -> ModuleType:
        """The module of the compiled loop, of the flock's own model."""
        return loop_of(self.model, *self._loop_kind)

    @property
    def loops(self) -> tuple[ModuleType, ...]:
        """The modules of the compiled loops of all its models, the flock's own the first."""
        others = (loop_of(one.model, *self._loop_kind_of(one.model)) for one in self.kind_models)
        return self.loop, *others

    @property
    def _loop_kind(self) -> LoopKind:
        """What `loop_of` asks for beside the model."""
        return self._loop_kind_of(self.model)

    def _loop_kind_of(self, model: Model) -> LoopKind:
        """The same of any model of this flock."""
        world_kind = self.world.dim, self.world.is_solid, self._is_of_pairs(model)
        is_nearest, kinds = self.nearest > 0, bool(self.kinds.kinds)
        differ = kinds or bool(self.individuals)
        return *world_kind, self.options.is_windy, is_nearest, differ, kinds

    @property
    def engine(
        self,
    ) -> SynchronousEngine | PairEngine | SequentialEngine | PassEngine | StripEngine:
        """The compiled loop over these arrays. Raises InputError where ranks cannot share it."""
        if self._engine is None:
            engine = self._make_engine(self.arrays)
            if self.ranks != 1:
                self._demand_strips()
                assert isinstance(engine, SynchronousEngine | PairEngine)
                build = partial(named_loop, self.model.name, *self._loop_kind)
                stride = longest_stride(self.model, self.parameters, self.world, self.options)
                self._engine = StripEngine(engine, self.processes, build, stride)
            else:
                self._engine = engine
        return self._engine

    @cached_property
    def processes(self) -> RankProcesses:
        """The processes of its ranks, begun when first asked for."""
        return RankProcesses(self.ranks)

    def _demand_strips(self) -> None:
        """Raise InputError where ranks cannot share a tick of this flock."""
        reason = reason_for_one_process(self.model, self.nearest, self.options)
        if self.interpret or DISABLED:
            reason = "plain Python runs in one process"
        if self.world.has_gates:
            reason = f"agents come and go in {self.world.name}"
        if self.individuals:
            reason = f"agents differ in {', '.join(self.individuals)}"
        if self.kinds.kinds:
            reason = f"there are kinds of agents: {', '.join(self.kinds.names)}"
        if self.threads > 1:
            reason = f"threads = {self.threads}, and each rank has one thread"
        if reason:
            raise InputError(f"ranks are not allowed here: {reason}")

    def _make_engine(
        self, arrays: Arrays
    ) -> SynchronousEngine | PairEngine | SequentialEngine | PassEngine:
        if not self.kind_models:
            return self._engine_of(self, arrays)
        names = self.own_columns
        columns = [names.index(name) for name in self.model.individual]
        own = arrays.own[:, columns]
        # Who goes by another model is met in this pass, and moved by none of its numbers.
        own[np.isnan(own).any(axis=1)] = [
            getattr(self.parameters, name) for name in self.model.individual
        ]
        first = self._engine_of(self, arrays._replace(own=np.ascontiguousarray(own)))
        passes = []
        for one in self.kind_models:
            # Passes are made again whenever parameters, kinds or rows change.
            view = replace(self.snapshot(copy=False), arrays=arrays)._by_kind_model(one)
            engine = self._engine_of(view, copy_moving(view.arrays))
            passes.append(ModelPass(one.number, engine, self._context_of(view)))
        return PassEngine(first, arrays, passes)

    def _engine_of(
        self, state: FlockState, arrays: Arrays
    ) -> SynchronousEngine | PairEngine | SequentialEngine:
        """The compiled loop of a state's model over arrays."""
        space = Space(
            pad_to_space(self.world.size, float),
            pad_to_space(self.world.wraps, int),
            pad_to_space(self.world.images, int),
            self.world.low[2] if self.world.dim == 3 else 0.0,
        )
        place = WorldContext(space, survey_world(self.world, state.sight))
        loop = loop_of(state.model, *self._loop_kind_of(state.model))
        called = partial(call, state.model, self.interpret)
        if self.options.is_late:
            late = messages(self.options, self.dt)
            return DelayedEngine(delayed_module(loop), arrays, place, self.seed, late, called)
        if self.options.activation == "synchronous":
            of_pairs = self._is_of_pairs(state.model)
            engine = PairEngine if of_pairs else SynchronousEngine
            split_from = self.split_from or (pair_runner if of_pairs else runner).SPLIT_FROM
            split = not self.interpret and len(arrays.ids) >= split_from
            threads = self.threads if split else 1
            return engine(loop, arrays, place, self.seed, threads, called)
        is_random = self.options.activation == "random"
        return SequentialEngine(turns_module(loop), arrays, place, self.seed, is_random, called)

    def compile_tick(self) -> None:
        """Compile what ticks and `stray` call, or load it from the cache.

        The flock stays as it is: a copy of its first agent runs a tick by itself.
        """
        if len(self.ids):
            # It has surroundings of its own: a tick writes the place of the mission's goal there.
            engine = self._make_engine(select_rows(self.arrays, np.arange(1)))
            engine.run(self._context_with_wind(1), self.tick, 1)
            self.stray()

    def _make_context(self) -> Context:
        self._wind = Wind(self.options, self.seed, self.dt, self.world.dim)
        self.passing = next(iter(self._passing_settings.values()), "")
        return self._context_of(self)

    @property
    def _passing_settings(self) -> dict[str, str]:
        """The settings with which agents go through what is solid here, by the names of models."""
        if not self.world.is_solid:
            return {}
        models = [(self.model, self.parameters)]
        models += [(one.model, one.parameters) for one in self.kind_models]
        settings = {model.name: model.passing(parameters) for model, parameters in models}
        return {name: setting for name, setting in settings.items() if setting}

    def _context_of(self, state: FlockState) -> Context:
        """What every agent goes by that has the model of a state."""
        model = state.model
        noise = model.rule.noise if state.viewed_kind and model.rule.noise else self.options.noise
        values = {NOISE: 0.0, **as_floats(state.parameters)}
        if self.interpret or DISABLED:  # numbers that divide by zero as compiled ones do
            values = {name: np.float64(value) for name, value in values.items()}
        numbers = loop_of(model, *self._loop_kind_of(model)).P(**values)
        unbounded = numbers
        if self.nearest:
            unbounded = numbers._replace(**{model.bound: np.float64(np.inf)})
        relations = NO_RELATIONS
        if self.kinds.kinds:
            reach = state._largest(model.rule.reach)
            relations = self.kinds.to_array(reach, state.viewed_kind)
        return Context(
            numbers,
            VECTORIAL if noise == "vectorial" else ANGULAR,
            state.reach_of_model,
            self.dt,
            NO_WIND,
            0,
            unbounded,
            self.nearest,
            relations,
        )

    def context_of(self, row: int) -> Context:
        """What the agent of a row goes by, with its own parameters as if all shared them."""
        if not self.differing:
            return self.context
        one, context, model = self.kind_model_of(row), self.context, self.model
        if one is not None:
            context, model = self._pass_of(row).context, one.model
        own = {
            name: float(column[row])
            for name, column in self.own.items()
            if name in model.individual and not np.isnan(column[row])
        }
        heard = {name: value for name, value in own.items() if name != model.bound}
        return context._replace(
            parameters=context.parameters._replace(**own),
            unbounded=context.unbounded._replace(**(heard if self.nearest else own)),
        )

    def surroundings_of(self, row: int) -> Surroundings:
        """What stands around, as the agent of a row notices it."""
        if self.kind_model_of(row) is None:
            return self.engine.surroundings
        return self._pass_of(row).engine.surroundings

    def _pass_of(self, row: int) -> ModelPass:
        """The pass in which an agent acts whose kind has a model of its own."""
        assert isinstance(self.engine, PassEngine)
        own_pass = self.engine.pass_of(self.arrays.kind[row])
        assert own_pass is not None
        return own_pass

    def _context_with_wind(self, ticks: int) -> Context:
        """What agents go by in the next ticks, the wind with it."""
        wind = self._wind.displacements(self.tick, ticks)
        return self.context._replace(wind=wind, since=self.tick)

    def stray(self) -> StrayAgents | None:
        """The first agent that is inside an obstacle or beyond a solid edge, None if nobody is.

        Where nothing is solid, or agents go through it by their model's own setting, all can be
        anywhere.
        """
        if not self.world.is_solid or self.passing or not len(self.ids):
            return None
        return stray(self.engine.surroundings, self.arrays, self.tick)

    @property
    def warning(self) -> str:
        """A warning about agents that go through what is solid, and about numbers that were drawn
        again; or an empty string."""
        drawn_from: dict[str, Any] = dict(self.individuals)
        for kind in self.kinds.kinds:
            drawn_from |= {f"{name} of {kind.name}": one for name, one in kind.parameters.items()}
        warnings = [
            f"{name} = {drawn_from[name]}: {counted(number, 'number')} of {self.drawn[name]} drawn "
            "again, outside of the range of the parameter"
            for name, number in self.redrawn.items()
            if name in drawn_from and number
        ]
        never = {kind.name for kind in self.kinds.kinds if not kind.agents}
        warnings += [
            f"nobody of kind {name} is left"
            for name in self.kinds.names
            if self.kinds.catchers and name not in never and not len(self.rows_of(name))
        ]
        for name, setting in self._passing_settings.items():
            warnings.insert(
                0,
                f"{name} with {setting}: agents go through obstacles and solid edges, as in the "
                "literal text of its paper",
            )
        return "; ".join(warnings)

    def snapshot(self, copy: bool = True, signals: bool = False) -> Snapshot:
        """The flock frozen as it is now.

        `copy`: whether its arrays are copies; without, they are the flock's own, and good until it
        goes on. `signals`: whether to hold what agents tell each other now, for which the model's
        kernel is compiled where it is not.
        """
        if signals:
            self.signals()
        arrays = Arrays._make(map(np.array, self.arrays)) if copy else self.arrays
        return Snapshot(
            self.model,
            self.world,
            self.parameters,
            self.seed,
            self.tick,
            arrays,
            self.next_id,
            signals,
            entries=self.entries,
            exits=self.exits,
            individuals=dict(self.individuals),
            kinds=self.kinds,
            catches=self.catches,
        )

    def return_to(self, past: Snapshot) -> None:
        """Be as a snapshot of this run was, and go on from there as it did, to the bit."""
        self._acted.clear()
        self.world, self.parameters = past.world, past.parameters
        self.individuals = dict(past.individuals)
        self.kinds, self.catches = past.kinds, past.catches
        self.tick, self.next_id = past.tick, past.next_id
        self.entries, self.exits = past.entries, past.exits
        self._set_arrays(Arrays._make(map(np.array, past.arrays)))
        self._match_members()

    def links(self) -> np.ndarray:
        """Pairs of rows (i < j) within reach of each other, int (M, 2)."""
        return self.snapshot(copy=False).links()

    def group_labels(self) -> np.ndarray:
        """The connected group within `together` of each agent, int (N,), 0 the largest."""
        return self.snapshot(copy=False).group_labels()

    def layers(self) -> np.ndarray:
        """Hops from an information agent plus 1, as the flock stands; N + 1 unknown; int (N,)."""
        return self.snapshot(copy=False).layers()

    @property
    def is_compiled(self) -> bool:
        """Whether the compiled loop is at hand, so that the first tick will not wait for it."""
        return self.interpret or DISABLED or all(map(is_compiled, self.modules))

    @property
    def modules(self) -> list[ModuleType]:
        """The modules that its engine calls, one for each of its models."""
        engine = self.engine
        passes = engine.passes if isinstance(engine, PassEngine) else ()
        return [engine.module, *(one.engine.module for one in passes)]

    def set(self, **values: Unpack[ParameterWords]) -> None:
        """Change parameters of the running flock. Raises InputError, and then changes nothing.

        A number is that of all agents. A distribution (`flockscope.normal`, ...) or an array (N,)
        in the order of the rows gives each agent its own.
        """
        old_loop = self.loop
        shared, individuals = split_individuals(values)
        parameters = checked(self.model.parameters, {**self.parameters.model_dump(), **shared})
        if self.kinds.kinds and self.model.nearest(parameters):
            raise InputError(NOT_NEAREST)
        demand_kind_models(self.model, parameters, self.kinds)
        remaining = {name: d for name, d in self.individuals.items() if name not in values}
        self.model.demand_individual(individuals)
        new = remaining | individuals
        own = self._own_of(self.ids, parameters, individuals, new, self.arrays.kind, self.kinds)
        for name in remaining:  # as they are: some may have been set by hand
            column = self.own_columns.index(name)
            own[:, column] = self.arrays.own[:, column]
        if self.kind_models:
            own[~self.goes_by_model] = self.arrays.own[~self.goes_by_model]
        by_hand = {name: BY_HAND for name, d in individuals.items() if d.kind == "each"}
        self._take_own(parameters, new | by_hand, own, old_loop)

    def set_own(self, row: int, name: str, value: Any) -> None:
        """Give the agent of a row its own number of a parameter. Raises InputError."""
        if (one := self.kind_model_of(row)) is not None:
            checked(one.model.parameters, {**one.parameters.model_dump(), name: value})
            one.model.demand_individual({name: BY_HAND})
            own = self.arrays.own.copy()
            own[row, self.own_columns.index(name)] = float(value)
            self.kinds = self.kinds.with_kind(one.kind.with_parameters({name: BY_HAND}))
            self._take_own(self.parameters, self.individuals, own, self.loop)
            return
        checked(self.model.parameters, {**self.parameters.model_dump(), name: value})
        self.model.demand_individual({name: BY_HAND})
        individuals = {**self.individuals, name: BY_HAND}
        own = self.arrays.own
        if not own.shape[1]:
            own = self._own_of(self.ids, self.parameters, {}, individuals, self.arrays.kind)
        own = own.copy()
        own[row, self.own_columns.index(name)] = float(value)
        self._take_own(self.parameters, individuals, own, self.loop)

    def _own_of(
        self,
        ids: np.ndarray,
        parameters: Parameters,
        drawn: Mapping[str, Distribution],
        individuals: Mapping[str, Distribution],
        kind: np.ndarray,
        before: KindTable = NO_KINDS,
    ) -> np.ndarray:
        """The agents' own parameters (N, Q) of `own_columns`; (N, 0) where none differs.

        Those of `drawn` are drawn by identity, all others are shared, unless a kind has its own;
        `kind` is the number of each agent's, (N,) or (0,). Kinds keep the numbers that the kinds
        `before` had from the same distribution: some may have been set by hand. Who has a model
        without a parameter has nan of it. Raises InputError.
        """
        if not individuals and not self.kinds.kinds:
            return np.empty((len(ids), 0))
        columns, own_models = self.own_columns, {one.number: one for one in self.kind_models}
        numbers = kind if len(kind) else np.zeros(len(ids))
        shared = shared_numbers(self.model, parameters, self.kinds, numbers)
        own = shared.copy()

        def draw(
            rows: np.ndarray, model: Model, name: str, distribution: Distribution, title: str
        ) -> None:
            bounds = bounds_of(model, name)
            column, redrawn = draw_values(distribution, self.seed, name, ids[rows], bounds)
            own[rows, columns.index(name)] = column
            self.redrawn = {**self.redrawn, title: redrawn}
            self.drawn = {**self.drawn, title: len(rows)}

        for name, distribution in drawn.items():
            rows = np.arange(len(ids))
            if distribution.kind != "each":
                others = [*self.kinds.numbers_with(name), *own_models]
                rows = rows[~np.isin(numbers, others)]
            if not distribution.is_by_hand:
                draw(rows, self.model, name, distribution, name)
        known = {one.name: one.parameters for one in before.kinds}
        for number, one in enumerate(self.kinds.kinds, 1):
            rows, model, values = np.flatnonzero(numbers == number), self.model, one.parameters
            if number in own_models:
                model, values = own_models[number].model, own_models[number].own_numbers
                own[rows] = shared[rows]  # what ordinary agents differ in is theirs alone
            for name, value in values.items():
                if known.get(one.name, {}).get(name) == value:
                    column = columns.index(name)
                    own[rows, column] = self.arrays.own[rows, column]
                elif len(rows):
                    distribution = value if isinstance(value, Distribution) else normal(value, 0.0)
                    draw(rows, model, name, distribution, f"{name} of {one.name}")
        return own

    def _demand_kinds(self, kinds: KindTable) -> None:
        """Raise InputError for kinds that this flock's model cannot have."""
        spec, world = self._beginning
        demand_kinds(self.model, self.parameters, kinds, spec, world.dim)

    def _no_wishes(self, n: int) -> np.ndarray:
        """What n agents are told to wish where some kind is steered: nothing yet. `Arrays.wish`."""
        is_steered = any(kind.steered for kind in self.kinds.kinds)
        return np.full((n if is_steered else 0, 3), np.nan)

    def steer(self, kind: str, wishes: Any) -> None:
        """Tell the agents of a steered kind what to wish from the next tick on.

        `wishes` (M, dim), in the order of `rows_of(kind)`, is what the model's rule wishes: a
        heading, an acceleration or a velocity (`Model.rule.wish`); the body keeps to its limits. A
        row of nan has its agent follow its rule. It holds until it is told otherwise. Raises
        InputError, and then changes nothing.
        """
        rows = self.rows_of(kind)
        steered = [one.name for one in self.kinds.kinds if one.steered]
        if kind not in steered:
            raise InputError(
                f"agents of kind {kind} are not steered: make the kind with steered = true"
            )
        try:
            array = np.asarray(wishes, float)
        except (TypeError, ValueError):
            array = np.empty(0)
        if array.shape != (len(rows), self.world.dim):
            raise InputError(
                f"wishes of kind {kind} have the shape {array.shape}: "
                f"({len(rows)}, {self.world.dim}) is needed"
            )
        is_given = ~np.isnan(array).any(axis=1)
        if not np.isfinite(array[is_given]).all():
            raise InputError(f"wishes of kind {kind} are not all finite numbers")
        self.steer_rows(rows, array)

    def steer_rows(self, rows: np.ndarray, wishes: np.ndarray) -> None:
        """The same of the agents of rows (M,) of steered kinds, with what has been checked."""
        is_given = ~np.isnan(wishes).any(axis=1)
        self.arrays.wish[rows] = np.nan
        steered_rows = rows[is_given]
        self.arrays.wish[steered_rows] = 0.0
        self.arrays.wish[steered_rows, : self.world.dim] = wishes[is_given]

    def _own_of_new(self, ids: np.ndarray) -> np.ndarray:
        """The own parameters of agents that join: what is given agent by agent they share."""
        drawn = {name: d for name, d in self.individuals.items() if d.kind != "each"}
        redrawn, count = self.redrawn, self.drawn
        ordinary = np.zeros(len(ids))
        own = self._own_of(ids, self.parameters, drawn, self.individuals, ordinary)
        self.redrawn, self.drawn = redrawn, count
        return own

    def _take_own(
        self,
        parameters: Parameters,
        individuals: Mapping[str, Distribution],
        own: np.ndarray,
        old_loop: ModuleType,
    ) -> None:
        """Go on with these parameters, shared and own."""
        self.parameters, self.individuals = parameters, dict(individuals)
        if own.shape == self.arrays.own.shape:
            self.arrays.own[:] = own
        else:
            self.arrays = self.arrays._replace(own=own)
            self._engine = None
        self._follow_own()
        if self.loop is not old_loop:
            self._end_tick()
            self._engine = None
        self._make_past()
        if isinstance(self._engine, PassEngine):  # its passes have numbers of their own
            self._engine = None
        if isinstance(self._engine, StripEngine):  # strides may be longer
            self._engine = None

    def change_world(self, world: World) -> None:
        """Put the running flock among other obstacles, edges or another mission.

        Raises InputError if the world has other dimensions; nothing then changes. Agents stay where
        they are: see `worlds.queries.surface` for those that an obstacle has come upon.
        """
        if world.dim != self.world.dim:
            raise InputError(f"a {self.world.dim}-D flock cannot go on in a {world.dim}-D world")
        self._demand_gates(world)
        self._end_tick()
        self.world = world
        self._engine = None
        self.context = self._make_context()

    def advance(self, ticks: int, until_ended: bool = False) -> None:
        """Run ticks without collecting anything; frees the GIL while it runs.

        `until_ended`: stop at the tick at which the flock has become empty for good.
        """
        if ticks > 0 and self._acted:
            remaining_rows = [
                row for row in np.argsort(self.ids).tolist() if row not in self._acted
            ]
            for row in remaining_rows:
                self.step_member(row)
            ticks -= 1
        while ticks > 0:
            ticks_to_run = self._ticks_together(min(ticks, STRETCH))
            if len(self.ids):
                self._run(ticks_to_run)
            self._count_ticks(ticks_to_run)
            ticks -= ticks_to_run
            if until_ended and self.world.has_gates and self.has_ended:
                return

    def _ticks_together(self, ticks: int) -> int:
        """How many of so many ticks, one at least, run before an event, or somebody may come or
        go."""
        is_single = bool(self.kinds.catchers) or self.is_flown
        ticks = self._ticks_to_event(1 if is_single else ticks)
        return self._ticks_to_gates(ticks) if self.world.has_gates else ticks

    def _ticks_to_gates(self, ticks: int) -> int:
        """How many of so many ticks, one at least, run before somebody may come or go."""
        return ticks

    @property
    def is_flown(self) -> bool:
        """Whether somebody is asked, tick by tick, what steered agents wish."""
        return False

    def _ask_pilots(self) -> None:
        """Ask who flies agents what these wish in the coming tick."""

    def _catch(self) -> None:
        """Let those who chase catch who is near enough."""

    def _pass_gates(self) -> None:
        """Let agents come and go at the end of a tick."""

    def _demand_gates(self, world: World) -> None:
        """Raise InputError for gates that agents of this flock cannot pass."""

    def _ticks_to_event(self, ticks: int) -> int:
        """How many of so many ticks, one at least, can run before something else has its turn."""
        return ticks

    def _fire_due(self) -> None:
        """Let what is due at this tick have its turn."""

    def _match_members(self) -> None:
        """Let what stands for single agents follow the rows, whose identities may have changed."""

    def _count_ticks(self, ticks: int) -> None:
        """Count ticks that were run, and let what is due have its turn."""
        self.tick += ticks
        if self.kinds.catchers:
            self._catch()
        if self.world.has_gates:
            self._pass_gates()
        self._fire_due()

    def _run(self, ticks: int, until: EngineStopCondition = NEVER, trace: np.ndarray = UNTRACED):
        """Run the compiled loop from this tick on; what its `run` answers."""
        if self.is_flown:
            self._ask_pilots()
        if self.kinds.catchers:
            self._came_from = self.ids.copy(), self.position.copy()
        return self.engine.run(self._context_with_wind(ticks), self.tick, ticks, until, trace)

    def trace(self, ticks: int) -> np.ndarray:
        """Run ticks (>= 0); the positions after each of them, (ticks, N, dim)."""
        self._end_tick()
        self._demand_no_gates()
        positions = np.empty((ticks, *self.position.shape))
        done = 0
        while done < ticks:
            ticks_to_run = self._ticks_together(ticks - done)
            self._demand_as_many(positions.shape[1])
            self._run(ticks_to_run, trace=positions[done : done + ticks_to_run])
            self._count_ticks(ticks_to_run)
            done += ticks_to_run
        return positions

    def _demand_no_gates(self) -> None:
        """Raise InputError where agents come and go."""
        if self.world.has_gates:
            raise InputError(
                f"agents come and go in {self.world.name}: a run that traces positions, or waits "
                "for something to hold, needs the same agents throughout"
            )

    def _demand_as_many(self, n: int) -> None:
        """Raise InputError where an event has changed the number of agents of such a run."""
        if len(self.ids) != n:
            raise InputError(
                f"an event at tick {self.tick} left {len(self.ids)} agents of {n}: a run that "
                "traces positions, or waits for consistency, needs the same agents throughout"
            )

    def run_until_consistent(
        self,
        limit: int,
        desired: float = DESIRED,
        hold: int = HOLD,
        between: Callable[[], None] = lambda: None,
    ) -> int | None:
        """k_con of Liu et al. 2021 (27): ticks until Deg_con >= `desired`, held for `hold` ticks.

        None if it has not come after `limit` ticks. Runs compiled, some hundred ticks at a time;
        `between` is called between them and may end the run by raising.
        """
        self._end_tick()
        until = stop_when_consistent(len(self.ids), self.reference, desired, hold)
        return self.run_until_held(until, limit, between)

    def run_until_held(
        self, until: EngineStopCondition, limit: int, between: Callable[[], None] = lambda: None
    ) -> int | None:
        """Run until something has held; the tick from which it does, None if not by `limit`.

        The rest as `run_until_consistent`.
        """
        self._end_tick()
        self._demand_no_gates()
        until, n = until._replace(last_off=self.tick - 1), len(self.ids)
        while self.tick < limit:
            between()
            ticks = self._ticks_together(min(CHUNK, limit - self.tick))
            self._demand_as_many(n)
            done, last_off = self._run(ticks, until)
            self._count_ticks(done)
            if done < ticks:
                return last_off + 1
            until = until._replace(last_off=last_off)
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
            if self.is_flown:
                self._ask_pilots()
            self.engine.open(self.context, self.tick)
        self.engine.one(self._context_with_wind(1), self.tick, row)
        self._acted.add(row)
        if len(self._acted) == len(self.ids):
            self._end_tick()

    def _end_tick(self) -> None:
        """End a tick in which agents have stepped one by one, if there is one."""
        if self._acted:
            self._acted.clear()
            self._count_ticks(1)

    def signals(self) -> np.ndarray:
        """Signals, memories and measures of the agents now, (K, N): `model.columns`.

        A layer that is not known is infinite.
        """
        if len(self.model.signals) and len(self.ids) and not self._acted:
            self.engine.open(self.context, self.tick)
        return self.arrays.memory

    def signal(self, name: str) -> np.ndarray:
        """One row of `signals` by name, a copy (N,); a layer of N + 1 is unknown. Or InputError."""
        return self.snapshot(copy=False, signals=name in self.model.signals).signal(name)


def bounds_of(model: Model, name: str) -> tuple[float, float]:
    """The least and the largest number that a parameter of a model may be."""
    declaration = describe(name, model.parameters.model_fields[name])
    assert isinstance(declaration, NumberParameter)
    return declaration.bounds


def demand_kinds(
    model: Model, parameters: Parameters, kinds: KindTable, options: Options, dim: int
) -> None:
    """Raise InputError for kinds that flocks of a model with these parameters cannot have, which
    act by these options in so many dimensions."""
    if kinds.kinds and model.nearest(parameters):
        raise InputError(NOT_NEAREST)
    known = model.rule.kinds
    if kinds.kinds and kinds.names[1 : 1 + len(known)] != known:
        raise InputError(
            f"kinds {', '.join(kinds.names[1:])} are not allowed: those that {model.name} knows "
            f"come first, {', '.join(known)}"
        )
    for kind in kinds.kinds:
        if kind.model:
            continue
        try:
            numbers = split_individuals(kind.parameters)[0]
            model.demand_individual(numbers)
            checked(model.parameters, {**parameters.model_dump(), **numbers})
        except InputError as error:
            raise InputError(f"kind {kind.name}: {error}") from None
    demand_kind_models(model, parameters, kinds, options, dim)


def pad_to_space(values: Sequence[float] | np.ndarray, kind: type) -> np.ndarray:
    """Numbers of each axis (dim,) with zeros for the axes that a plane has not, (3,)."""
    vector: np.ndarray = np.zeros(3, kind)
    vector[: len(values)] = values
    return vector


def named_loop(name: str, *kind: Any) -> ModuleType:
    """The same of a model by name, as another process asks for it."""
    return loop_of(catalogue.model(name), *kind)


@cache
def loop_of(
    model: Model,
    dim: int,
    solid: bool,
    of_pairs: bool,
    windy: bool,
    nearest: bool,
    differ: bool = False,
    kinds: bool = False,
) -> ModuleType:
    """The module of the compiled loop of a model, in a world with something solid, wind, or not.

    `nearest`: whether the nearest are neighbours, whatever their distance. `differ`: whether agents
    have parameters of their own. `kinds`: whether there are kinds of them.
    """
    fields = list(dict.fromkeys([*model.parameters.model_fields, NOISE]))
    own = [
        -1 if nearest and name == model.bound else fields.index(name) for name in model.individual
    ]
    parts = model.parts(dim, solid) | {
        "holds": is_consistent,
        "WINDY": windy,
        "NEAREST": nearest,
        "DIFFER": tuple(own) if differ else (),
        "KINDS": kinds,
    }
    return loop_module("pairs" if of_pairs else "sweep", parts, tuple(fields))
