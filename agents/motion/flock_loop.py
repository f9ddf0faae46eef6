"""A flock's arrays and the compiled loop over them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property, partial
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from agents import catalogue
from agents.conditions import Wind, messages, ticks_back
from agents.engine import runner
from agents.engine.arrays import Arrays, Context, WorldContext
from agents.engine.cells import Space
from agents.engine.compiled_loop import delayed_module, is_compiled, loop_module, turns_module
from agents.engine.heeding import COLUMNS
from agents.engine.noise import ANGULAR, NO_WIND, VECTORIAL
from agents.engine.pairs import pair_runner
from agents.engine.pairs.pair_runner import PairEngine
from agents.engine.pass_engine import ModelPass, PassEngine, copy_moving
from agents.engine.runner import (
    DelayedEngine,
    Engine,
    LoopEngine,
    SequentialEngine,
    SynchronousEngine,
)
from agents.models.declare import as_floats
from agents.models.model import Model
from agents.models.model_calls import call
from agents.observables.consistency import is_consistent
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
from worlds.queries.surroundings import Surroundings
from worlds.queries.survey import survey_world
from worlds.world import World

if TYPE_CHECKING:
    pass

NOISE = "eta"
"""The parameter that the engine takes for the noise intensity; a rule without it has no noise."""
NO_RELATIONS = np.empty((0, 0, COLUMNS))
LoopKind = tuple[int, bool, bool, bool, bool, bool, bool]
"""What `loop_of` asks for beside the model."""


class FlockLoop(FlockState):
    """State of a flock, and the compiled loop that goes over it.

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
    _engine: Engine | None
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

    def _swap_arrays(self, arrays: Arrays, with_other_numbers: bool) -> None:
        """Take arrays of as many agents, which begin the same run with another seed.

        `with_other_numbers`: whether agents may have other numbers of their own than before.
        """
        self.arrays = arrays
        if self._engine is not None:
            assert isinstance(self._engine, LoopEngine)
            self._engine.arrays, self._engine.seed = arrays, self.seed
        if self.differing and with_other_numbers:
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
    def engine(self) -> Engine:
        """The compiled loop over these arrays. Raises InputError where ranks cannot share it."""
        if self._engine is None:
            engine = self._make_engine(self.arrays)
            if self.ranks != 1:
                self._demand_strips()
                assert isinstance(engine, SynchronousEngine)
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

    def _make_engine(self, arrays: Arrays) -> Engine:
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

    def _engine_of(self, state: FlockState, arrays: Arrays) -> LoopEngine:
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

    def _no_wishes(self, n: int) -> np.ndarray:
        """What n agents are told to wish where some kind is steered: nothing yet. `Arrays.wish`."""
        is_steered = any(kind.steered for kind in self.kinds.kinds)
        return np.full((n if is_steered else 0, 3), np.nan)

    def signals(self) -> np.ndarray:
        """Signals, memories and measures of the agents now, (K, N): `model.columns`.

        A layer that is not known is infinite.
        """
        if len(self.model.signals) and len(self.ids) and not self._acted:
            self.engine.open(self.context, self.tick)
        return self.arrays.memory


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
