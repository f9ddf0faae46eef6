"""A model: a rule, the body that carries it out, and what a flock of it starts with."""

from __future__ import annotations

import dis
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field
from functools import cache, cached_property
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher
from pydantic import create_model

from agents.engine.block import neighbour_of, points_of
from agents.engine.cache import global_values
from agents.engine.neighbour_search import UNKNOWN
from agents.engine.solid_collision import BOUNCES, PASSES, SLIDES, STOPS
from agents.models.declare import (
    Body,
    NumberParameter,
    Parameters,
    Rule,
    Symmetry,
    as_floats,
    declared,
)
from agents.models.slider_range import fits_default
from agents.models.tries import LessonStep
from worlds.compilation import compiled
from worlds.input_error import InputError, unknown

NEIGHBOURS, NUMBER = "neighbours", "k"
"""The parameters that say who the neighbours are, and how many of the nearest, of rules that leave
it open."""


def python_of(function: Callable) -> FunctionType:
    """The Python of a compiled function."""
    return function.py_func  # type: ignore[attr-defined]


def python_of_any(function: Callable) -> FunctionType:
    """The Python of a function, compiled or not."""
    python = vars(function).get("py_func", function)
    assert isinstance(python, FunctionType)
    return python


def uses_argument(name: str, function: Callable) -> bool:
    """Whether a compiled function uses its argument of that name."""
    return any(
        name
        in (instruction.argval if isinstance(instruction.argval, tuple) else (instruction.argval,))
        for instruction in dis.get_instructions(python_of(function))
        if instruction.opname.startswith("LOAD_FAST")
    )


def reads(name: str, function: Callable | None) -> bool:
    """Whether a compiled function, or one that it reaches, reads an attribute of that name.

    `seen`, which hands on all that there is of a neighbour, does not count.
    """
    if function is None or function is neighbour_of:
        return False
    python = python_of(function)
    inner = [callee for callee in global_values(python) if isinstance(callee, Dispatcher)]
    return name in python.__code__.co_names or any(
        reads(name, callee_function) for callee_function in inner
    )


def calls(target: Callable, function: Callable) -> bool:
    """Whether a compiled function, or one that it reaches, reaches another."""
    inner = [
        callee for callee in global_values(python_of(function)) if isinstance(callee, Dispatcher)
    ]
    return any(
        callee_function is target or calls(target, callee_function) for callee_function in inner
    )


def vector_name(column: str) -> str:
    """The name of the point or vector that a column is a part of; its own, if of none.

    >>> vector_name("aim_x"), vector_name("phase")
    ('aim', 'phase')
    """
    return column[:-2] if column[-2:] in ("_x", "_y", "_z") else column


@cache
def view_function(name: str) -> Callable:
    """Compiled: (p) -> the parameter that is the field of view, deg."""
    names: dict[str, Any] = {"__name__": __name__}
    exec(f"def view_of(p):\n    return p.{name}\n", names)
    return compiled(names["view_of"])


@dataclass(frozen=True, eq=False)
class Model:
    """A rule and a body under one name, with one set of parameters.

    Raises TypeError if the body cannot take what the rule wishes.
    """

    rule: Rule
    body: Body
    suffix: str = ""
    """Put behind the rule's name, to tell models of one rule apart."""
    title_suffix: str = ""
    summary_suffix: str = ""
    defaults: Mapping[str, Any] = field(default_factory=dict)
    """Defaults that differ from those of the rule and the body."""
    world: str = "wrap"
    """The world that it is at home in."""
    dim: int | None = None
    """The dimensions that it starts in, where its world fits several."""
    spacing: float | None = None
    """At the start, least distance between agents and of agents to what is solid, length."""
    agents: int = 100
    """How many ordinary agents a flock has unless the user says otherwise."""
    density: float = 4.102
    """Agents per unit of area or volume in a world without a size of its own, unless the user says
    otherwise: by default rho of Liu et al. 2021, 3.1."""
    tells: tuple[str, ...] = ()
    """The observables that tell how its flocks do, the foremost first: a run prints them and the
    laboratory plots them, each of a flock that it applies to. None: those that
    `agents.observables.catalogue` has for flocks of its kind."""
    tries: tuple[LessonStep, ...] | None = None
    """What there is to try with it; None: what its rule declares, which is tried with this body."""

    def __post_init__(self):
        if self.rule.wish != self.body.takes:
            raise TypeError(
                f"rule {self.rule.name} wishes {self.rule.wish}, but the body {self.body.name} "
                f"takes {self.body.takes}"
            )

    def __repr__(self) -> str:
        return f"<Model {self.name}: {self.title}>"

    @property
    def name(self) -> str:
        """Name on the command line and in a spec."""
        return self.rule.name + self.suffix

    @property
    def title(self) -> str:
        """Name for people."""
        return self.rule.title + self.title_suffix

    @property
    def summary(self) -> str:
        """What it does, in a sentence or two."""
        return self.rule.summary + self.summary_suffix

    @property
    def to_try(self) -> tuple[LessonStep, ...]:
        """What there is to try with it."""
        return self.rule.tries if self.tries is None else self.tries

    @property
    def dimensions(self) -> tuple[int, ...]:
        """Dimensions in which it is defined."""
        return self.rule.dimensions

    def in_units(self, unit: str) -> str:
        """A unit of an observable or an option in the model's own: m, s where its paper has them.

        A length stays a length where the paper names no unit of it; that of tracks may be px.
        """
        own = {declaration.unit for declaration in declared(self.parameters)}
        length = next((unit for unit in ("m", "px") if unit in own), "length")
        if unit == "time":
            return self.body.unit
        time = "tick" if self.body.unit == "ticks" else self.body.unit
        return unit.replace("length", length).replace("/time", f"/{time}")

    def unit_of(self, column: str) -> str:
        """The unit of one of `columns`, 1 for a pure number."""
        units = {**self.rule.units, **self.body.units}
        return self.in_units(units.get(column, units.get(vector_name(column), "1")))

    def words_of(self, column: str) -> str:
        """What people call one of `columns`, or the point or vector that it is a part of."""
        labels, name = {**self.rule.words, **self.body.words}, vector_name(column)
        return labels.get(column, labels.get(name, name.replace("_", " ")))

    @property
    def informed(self) -> int:
        """Information agents unless the user says otherwise."""
        return self.rule.informed

    @cached_property
    def shared(self) -> dict[str, str]:
        """The parameters that all agents share whatever is asked for, and why, in few words."""
        rule, body = self.rule, self.body
        reasons: dict[str, str] = {}
        for declaration in declared(self.parameters):
            name = declaration.name
            if not isinstance(declaration, NumberParameter):
                reasons[name] = "it is no number"
            elif name in self.parameters_read(body.lasts):
                reasons[name] = "a tick is as long for all"
            elif rule.prepare is not None and name in self.parameters_read(rule.prepare):
                reasons[name] = "the rule looks at the whole flock with it"
            elif name == body.size:
                reasons[name] = "agents take the size of others for their own"
            elif name == NUMBER and NEIGHBOURS in self.parameters.model_fields:
                reasons[name] = "as many nearest agents are neighbours of all"
        return reasons

    @cached_property
    def individual(self) -> tuple[str, ...]:
        """The parameters that may differ from agent to agent, in their order."""
        return tuple(name for name in self.parameters.model_fields if name not in self.shared)

    def demand_individual(self, names: Iterable[str]) -> None:
        """Raise InputError for a parameter that is none, or that agents cannot differ in."""
        for name in names:
            if name not in self.parameters.model_fields:
                raise unknown("parameter", name, self.parameters.model_fields)
            if name in self.shared:
                raise InputError(
                    f"{name} cannot differ from agent to agent in {self.name}: {self.shared[name]}"
                )

    def parameters_read(self, function: Callable) -> frozenset[str]:
        """The parameters that a function of theirs reads, also through their properties."""
        python = python_of_any(function)
        names = set(python.__code__.co_names)
        for value in global_values(python):
            if isinstance(value, Dispatcher | FunctionType):
                names |= self.parameters_read(value)
        for name in tuple(names):
            computed = getattr(self.parameters, name, None)
            if isinstance(computed, property) and computed.fget is not None:
                names |= self.parameters_read(computed.fget)
        return frozenset(names & self.parameters.model_fields.keys())

    @property
    def signals(self) -> tuple[str, ...]:
        """What agents tell each other: the rule's signals, then the body's."""
        return self.rule.signals + self.body.signals

    @property
    def columns(self) -> tuple[str, ...]:
        """The rows of a flock's memory: signals, what agents keep to themselves, measures."""
        return self.signals + self.rule.memory + self.body.measures

    @cached_property
    def initial_columns(self) -> np.ndarray:
        """What the columns begin at: layers unknown, all heard, nothing remembered or measured."""
        rule, body = self.rule, self.body
        lengths = len(rule.signals), len(body.signals), len(rule.memory), len(body.measures)
        return np.repeat([UNKNOWN, 1.0, 0.0, np.nan], lengths)

    @property
    def sees_obstacles(self) -> bool:
        """Whether it steers clear of obstacles by itself."""
        return self.rule.sees_obstacles or self.body.sees_obstacles

    @property
    def symmetries(self) -> tuple[Symmetry, ...]:
        """What makes no difference to its agents in empty space, noise apart."""
        return tuple(
            symmetry for symmetry in self.rule.symmetries if symmetry in self.body.symmetries
        )

    def collision_kind(self, solid: bool) -> int:
        """What its agents do where a step enters a solid, of `agents.engine.solid_collision`.

        Those that do not see what is solid bounce off it; in a world without they need not ask.
        """
        if not self.sees_obstacles:
            return BOUNCES if solid else PASSES
        return STOPS if self.body.stops else SLIDES

    @cached_property
    def parameters(self) -> type[Parameters]:
        """The parameters of the rule and of the body, as one model."""
        bases = (self.body.parameters, self.rule.parameters)
        own: dict[str, Any] = {}
        for name, value in self.defaults.items():
            base = next(b for b in bases if name in b.model_fields)
            changed = copy(base.model_fields[name])
            extra: dict[str, Any] = dict(changed.json_schema_extra)  # type: ignore[arg-type]
            if not fits_default(extra["proposed"], changed.default, value):
                extra["proposed"] = None
            changed.default, changed.json_schema_extra = value, extra
            own[name] = (changed.annotation, changed)
        return create_model(self.name, __base__=bases, **own)

    def passing(self, parameters: Parameters) -> str:
        """The setting with which its agents go through what is solid, or an empty string."""
        passes = self.body.passes
        if passes is None:
            return ""
        floats = SimpleNamespace(**as_floats(parameters))
        return self.body.passes_with if passes.py_func(floats) else ""  # type: ignore[attr-defined]

    @cached_property
    def is_of_pairs(self) -> bool:
        """Whether its agents can act eight at once: see `agents.engine.pairs`.

        A rule whose `decide` is not made of its term, but has been put in its place, goes by that.
        Where `answer` is asked for one agent, lanes of what each keeps to itself are not made.
        """
        rule, body = self.rule, self.body
        needs = (self.signals, rule.perceive, rule.prepare, body.measure, body.touches)
        return (
            rule.term is not None
            and calls(rule.term, rule.decide)
            and (rule.by_lanes or not reads("memory", rule.term))
            and (not rule.sees_points or calls(points_of, rule.decide))
            and not any(needs)
            and not uses_argument("near", body.move)
        )

    @cached_property
    def asks_speed(self) -> bool:
        """Whether it reads a speed, which is then seen of others too."""
        rule, body = self.rule, self.body
        read = rule.perceive, rule.decide, rule.remember, body.move, body.measure, body.touches
        return any(reads("speed", function) for function in read)

    def nearest(self, parameters: Parameters) -> int:
        """How many nearest agents are neighbours; 0 where all within reach are."""
        if getattr(parameters, NEIGHBOURS, "") != "nearest":
            return 0
        return int(float(getattr(parameters, NUMBER)) + 0.5)

    def idle(self, values: Mapping[str, Any]) -> frozenset[str]:
        """The parameters that count for nothing beside these values."""
        if NEIGHBOURS not in values:
            return frozenset()
        return frozenset([self.bound if values[NEIGHBOURS] == "nearest" else NUMBER])

    @property
    def bound(self) -> str:
        """The parameter that does not count where the nearest are neighbours."""
        return self.rule.bound or self.rule.reach

    def parts(self, dim: int, solid: bool) -> dict[str, Any]:
        """What makes its loop in `dim` dimensions, in a world where something is solid or not."""
        rule, body = self.rule, self.body
        return {
            "DIM": dim,
            "SIGNALS": len(self.signals),
            "PRIVATE": len(rule.memory),
            "HEADS": rule.wish == "heading",
            "DEAFENS": body.deafens,
            "view_of": view_function(rule.view) if rule.view else None,
            "SEES_POINTS": rule.sees_points,
            "SIFTS": rule.sifts,
            "MEASURES": len(body.measures),
            "CRASHES": body.touches is not None,
            "ASKS_SPEED": self.asks_speed,
            "MEETS": self.collision_kind(solid),
            "perceive": rule.perceive,
            "decide": rule.decide,
            "term": rule.term,
            "answer": rule.answer,
            "SUMS": rule.sums,
            "BY_LANES": rule.by_lanes and body.by_lanes,
            "show": rule.show,
            "remember": rule.remember,
            "prepare": rule.prepare,
            "measure": body.measure,
            "touches": body.touches,
            "passes": body.passes,
            "move": body.move,
        }
