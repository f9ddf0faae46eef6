"""What changes in a running flock: parameters, agents' own numbers, what they are told to wish."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from agents.engine.pass_engine import PassEngine
from agents.individuals import BY_HAND, Distribution, draw_values, normal, split_individuals
from agents.kind_models import demand_kind_models, shared_numbers
from agents.kinds import NO_KINDS, KindTable
from agents.models.declare import NumberParameter, Parameters, checked, describe
from agents.models.model import Model
from agents.motion.flock_ticks import FlockTicks
from agents.spec import Options
from agents.strips.strip_engine import StripEngine
from worlds.input_error import InputError
from worlds.number_text import counted

if TYPE_CHECKING:
    from agents.flock_words import ParameterWords

NOT_NEAREST = (
    "kinds are not allowed where the nearest are neighbours, whatever their distance: set "
    "neighbours=metric"
)


class Motion(FlockTicks):
    """State and ticks of a flock; what `agents.Flock` is beside a Mesa model.

    The arrays are the truth and may be written to between ticks.
    """

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
