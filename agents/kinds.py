"""Kinds of agents in one flock: how many, their own parameters, and whom each heeds.

A relation says what agents of one kind do about those of another: take them as neighbours of their
rule (`own`), do not meet them (`ignore`), flee from them or chase them. Within a kind agents are
neighbours, between kinds they ignore each other, unless a relation says otherwise; those who are
chased flee from who chases them, unless they are told not to.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from agents.engine.heeding import (
    CATCH,
    COLUMNS,
    FIRST,
    LINEAR,
    MOST_KINDS,
    OWN,
    POWER,
    RADIUS,
    WEIGHT,
)
from agents.individuals import Distribution, as_distribution
from agents.policies import demand_policy_name
from worlds.input_error import InputError, shorten, unknown

ORDINARY = "flock"
"""What the agents are called that are of no kind of `kinds`."""
ALIASES = {"prey": ORDINARY, "ordinary": ORDINARY}
"""What else they may be called."""
INFORMED = "informed"
"""How information agents are asked for, as agents of a kind are: they are ordinary ones."""
ALL = "all"
"""All other kinds, where a relation names nobody."""
DEEDS = ("own", "ignore", "flee", "chase")
CAUGHT_ARE = ("taken", "frozen", "moved", "counted")
"""What becomes of who is caught: it leaves the flock, stands still and nobody meets it, begins anew
elsewhere, or nothing but that it is counted."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,31}")
STEERING_FIELDS = ("steered", "policy")
"""What a table of a kind says of how its agents are steered."""
KEYS = ("name", "agents", "model", "parameters", "start", "colour", "to", *STEERING_FIELDS)
"""What a table of a kind may say."""


@dataclass(frozen=True)
class Relation:
    """What agents of one kind do about those of another; made by `flee` and `chase`, or of a table.

    Raises InputError.
    """

    deed: str
    weight: float = 1.0
    """How much it counts beside the rule's own wish: of a heading 1 is what all agree on."""
    radius: float | None = None
    """How far they notice each other, length; None: as far as the rule does."""
    power: float | None = None
    """The wish falls with distance d as d^-power; None: as 1 - d / radius."""
    first: bool = False
    """Whether nothing else counts while there is one within the radius."""
    catch: float = 0.0
    """At which distance a chaser catches, length; 0: never."""
    caught: str = "taken"
    """What becomes of who is caught: one of CAUGHT_ARE."""

    def __post_init__(self) -> None:
        if self.deed not in DEEDS:
            raise unknown("relation", self.deed, DEEDS)
        numbers = {"weight": self.weight, "catch": self.catch}
        numbers |= {} if self.radius is None else {"radius": self.radius}
        numbers |= {} if self.power is None else {"power": self.power}
        for name, value in numbers.items():
            is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
            if not is_number or not 0.0 <= value < math.inf:
                raise InputError(
                    f"{name} = {shorten(value)} of {self.deed} is not allowed: a finite number "
                    ">= 0 is needed"
                )
        if self.radius == 0.0:
            raise InputError(f"radius = 0 of {self.deed} is not allowed: it is > 0")
        if self.caught not in CAUGHT_ARE:
            raise unknown("caught", self.caught, CAUGHT_ARE)
        if self.catch and self.deed != "chase":
            raise InputError(f"catch = {self.catch:g} of {self.deed}: only who chases can catch")

    def to_value(self) -> dict[str, Any]:
        """As TOML and JSON have it."""
        if self.deed in ("own", "ignore"):
            return {self.deed: True}
        values: dict[str, Any] = {self.deed: self.weight}
        for name in ("radius", "power"):
            if getattr(self, name) is not None:
                values[name] = getattr(self, name)
        if self.first:
            values["first"] = True
        if self.catch:
            values |= {"catch": self.catch, "caught": self.caught}
        return values


def flee(weight: float = 1.0, radius: float | None = None, **more: Any) -> Relation:
    """To flee from those of another kind: see `Relation`. Raises InputError."""
    return Relation("flee", weight, radius, **more)


def chase(weight: float = 1.0, radius: float | None = None, **more: Any) -> Relation:
    """To chase those of another kind: see `Relation`. Raises InputError."""
    return Relation("chase", weight, radius, **more)


def as_relation(value: Any) -> Relation:
    """The relation that a value is or describes: `"ignore"`, or `{"chase": 2.0, "radius": 10.0}`.

    Raises InputError.
    """
    if isinstance(value, Relation):
        return value
    if isinstance(value, str):
        return Relation(value)
    if not isinstance(value, Mapping):
        raise InputError(f"{shorten(value)} is not a relation: one of {', '.join(DEEDS)}")
    deeds = [name for name in value if name in DEEDS]
    known = ("weight", "radius", "power", "first", "catch", "caught")
    for name in value:
        if name not in (*DEEDS, *known):
            raise unknown("key", str(name), (*DEEDS, *known))
    if len(deeds) != 1:
        raise InputError(f"{shorten(dict(value))} is not a relation: one of {', '.join(DEEDS)}")
    rest = {name: one for name, one in value.items() if name not in DEEDS}
    amount = value[deeds[0]]
    if not isinstance(amount, bool):
        rest.setdefault("weight", amount)
    elif not amount:
        raise InputError(f"{deeds[0]} = false is not a relation: leave it out, or ignore = true")
    return Relation(deeds[0], **rest)


@dataclass(frozen=True)
class Kind:
    """A kind of agents beside the ordinary ones. Raises InputError.

    >>> Kind("shark", 2, s=4.0, to={"flock": chase(2.0, 10.0)}).agents
    2
    """

    name: str
    agents: int
    """How many there are at the start; 0 of one that is there by its number and relations alone."""
    parameters: dict[str, Any] = field(default_factory=dict)
    """Its own numbers, or distributions, of parameters of the rule and the body."""
    start: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    """The box in which it starts, two corners, length; None: where the others do."""
    colour: str = ""
    """`#rrggbb`; empty: one of its own."""
    to: dict[str, Relation] = field(default_factory=dict)
    steered: bool = False
    """Whether its agents are told from outside what to wish, by `Flock.steer`."""
    model: str = ""
    """The name of a model of its own, whose parameters it then has; empty: the flock's."""
    policy: str = ""
    """The name of the policy that flies them; then they are steered."""

    def __init__(
        self,
        name: Any,
        agents: Any = 1,
        *,
        parameters: Mapping[str, Any] | None = None,
        start: Any = None,
        colour: str = "",
        to: Mapping[str, Any] | None = None,
        steered: Any = False,
        model: Any = "",
        policy: str = "",
        **more: Any,
    ) -> None:
        if (
            not isinstance(name, str)
            or not NAME.fullmatch(name)
            or name in (ORDINARY, ALL, *ALIASES)
        ):
            raise InputError(
                f"kind {shorten(name)} is not allowed: a name of letters, digits, - and _ that is "
                f"not one of {', '.join((ORDINARY, ALL, *ALIASES))} is needed"
            )
        is_count = isinstance(agents, int | np.integer) and not isinstance(agents, bool)
        if not is_count or agents < 0:
            raise InputError(
                f"kind {name}: agents = {shorten(agents)} is not allowed: a whole number >= 0 is "
                "needed"
            )
        if colour and not re.fullmatch(r"#[0-9a-fA-F]{6}", str(colour)):
            raise InputError(f"colour = {shorten(colour)} of kind {name} is not #rrggbb")
        try:
            relations = {str(other): as_relation(one) for other, one in (to or {}).items()}
        except InputError as error:
            raise InputError(f"kind {name}: {error}") from None
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "agents", int(agents))
        own = {**(parameters or {}), **more}
        for key, value in own.items():
            try:
                own[key] = as_distribution(value) or value
            except InputError as error:
                raise InputError(f"kind {name}: {key}: {error}") from None
        object.__setattr__(self, "parameters", own)
        object.__setattr__(self, "start", None if start is None else start_box_of(name, start))
        object.__setattr__(self, "colour", str(colour))
        object.__setattr__(self, "to", relations)
        if not isinstance(steered, bool):
            raise InputError(f"kind {name}: steered = {shorten(steered)} is not true or false")
        if not isinstance(model, str):
            raise InputError(f"kind {name}: model = {shorten(model)} is not the name of a model")
        if model and (steered or policy):
            raise InputError(
                f"kind {name} has a model of its own, {shorten(model)}: it cannot be steered"
            )
        object.__setattr__(self, "model", model)
        if policy:
            try:
                demand_policy_name(policy)
            except InputError as error:
                raise InputError(f"kind {name}: {error}") from None
        object.__setattr__(self, "steered", steered or bool(policy))
        object.__setattr__(self, "policy", policy)

    def with_parameters(self, values: Mapping[str, Any]) -> Kind:
        """The same with some parameters changed."""
        return replace_kind(self, parameters={**self.parameters, **values})

    def to_value(self) -> dict[str, Any]:
        """As TOML and JSON have it."""
        values: dict[str, Any] = {"name": self.name, "agents": self.agents}
        if self.model:
            values["model"] = self.model
        if self.colour:
            values["colour"] = self.colour
        if self.start is not None:
            values["start"] = [list(corner) for corner in self.start]
        if self.parameters:
            values["parameters"] = {
                name: value.to_value() if isinstance(value, Distribution) else value
                for name, value in self.parameters.items()
            }
        if self.policy:
            values["policy"] = self.policy
        elif self.steered:
            values["steered"] = True
        if self.to:
            values["to"] = {name: one.to_value() for name, one in self.to.items()}
        return values


def replace_kind(kind: Kind, **changes: Any) -> Kind:
    """The kind with some things changed. Raises InputError."""
    return Kind(**{name: getattr(kind, name) for name in KEYS} | changes)


def start_box_of(name: str, start: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Two corners of a box. Raises InputError."""
    try:
        low, high = (tuple(float(x) for x in corner) for corner in start)
    except (TypeError, ValueError):
        low, high = (), ()
    is_finite = all(math.isfinite(x) for x in (*low, *high))
    if not low or len(low) != len(high) or not is_finite or np.any(np.array(low) > np.array(high)):
        raise InputError(
            f"start = {shorten(start)} of kind {name} is not allowed: two corners of a box are "
            "needed, the low one first"
        )
    return low, high


def as_kind(value: Any) -> Kind:
    """The kind that a value is, or a table describes. Raises InputError."""
    if isinstance(value, Kind):
        return value
    if not isinstance(value, Mapping):
        raise InputError(f"{shorten(value)} is not a kind: a table with its name is needed")
    for key in value:
        if key not in KEYS:
            raise unknown("key of a kind", str(key), KEYS)
    if "name" not in value:
        raise InputError("a kind has no name")
    return Kind(**value)


def as_kinds(value: Any) -> tuple[Kind, ...]:
    """The kinds of a list. Raises InputError, also for two of one name."""
    if isinstance(value, str | Mapping) or not isinstance(value, Sequence):
        raise InputError(f"kinds = {shorten(value)} is not allowed: a list of kinds is needed")
    kinds = tuple(as_kind(one) for one in value)
    demand_number(len(kinds))
    names = [kind.name for kind in kinds]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two kinds are called {name}")
    return kinds


def demand_number(kinds: int) -> None:
    """Raise InputError for more kinds than a flock can have."""
    if kinds > MOST_KINDS:
        raise InputError(f"{kinds} kinds are not allowed: {MOST_KINDS} at most")


@dataclass(frozen=True)
class KindTable:
    """All kinds of a flock, the ordinary agents the first, and their relations."""

    kinds: tuple[Kind, ...]
    relations: dict[tuple[str, str], Relation]
    """Of whom to whom: those that are not there are `own` within a kind, else `ignore`."""
    to: dict[str, Relation] = field(default_factory=dict)
    """What the ordinary agents do by their own relation about other kinds."""

    def kind(self, name: str) -> Kind:
        """A kind by its name. Raises InputError for one that there is not, as the ordinary one."""
        for one in self.kinds:
            if one.name == name:
                return one
        raise unknown("kind", name, self.names[1:])

    def number(self, name: str, more: tuple[str, ...] = ()) -> int:
        """The number of a kind by its name, or by what the ordinary one may be called. Raises
        InputError for a kind that there is not; `more` names could stand there as well."""
        known = ALIASES.get(name, name) if name not in self.names else name
        if known not in self.names:
            raise unknown("kind", name, (*self.names, *more))
        return self.names.index(known)

    def with_kind(self, kind: Kind) -> KindTable:
        """The same with another kind in the place of the one of its name."""
        kinds = (kind if one.name == kind.name else one for one in self.kinds)
        return kind_table(tuple(kinds), self.to)

    def without(self, name: str) -> KindTable:
        """The same without a kind, and without what others do about it."""
        kinds = tuple(
            replace_kind(one, to={key: to for key, to in one.to.items() if key != name})
            for one in self.kinds
            if one.name != name
        )
        return kind_table(kinds, {key: to for key, to in self.to.items() if key != name})

    @property
    def names(self) -> tuple[str, ...]:
        """Of all kinds, in the order of their numbers."""
        return (ORDINARY, *(kind.name for kind in self.kinds))

    def of(self, kind: str, other: str) -> Relation:
        """The relation of one kind to another."""
        default = Relation("own" if kind == other else "ignore")
        return self.relations.get((kind, other), default)

    def to_array(self, reach: float, number: int | None = None) -> np.ndarray:
        """As compiled code has them, (K, K, COLUMNS); without a radius they reach so far.

        `number`: of those alone who go by the model of the kind of that number, 0 for the flock's;
        all others have to do with nobody. None: of all.
        """
        names, with_model = self.names, self.with_model
        table = np.zeros((len(names), len(names), COLUMNS))
        for i, kind in enumerate(names):
            if number is not None and number != (i if i in with_model else 0):
                continue
            for j, other in enumerate(names):
                relation = self.of(kind, other)
                row = table[i, j]
                row[POWER] = LINEAR if relation.power is None else relation.power
                row[RADIUS] = reach if relation.radius is None else relation.radius
                row[OWN] = relation.deed == "own"
                if relation.deed in ("flee", "chase"):
                    row[WEIGHT] = relation.weight * (1.0 if relation.deed == "chase" else -1.0)
                    row[FIRST] = relation.first
                    row[CATCH] = relation.catch
        return table

    def with_relation(self, kind: str, other: str, relation: Any) -> KindTable:
        """The same with another relation of a kind to another. Raises InputError."""
        first, second = (self.names[self.number(name)] for name in (kind, other))
        changed = as_relation(relation)
        kinds = tuple(
            replace_kind(one, to={**one.to, second: changed}) if one.name == first else one
            for one in self.kinds
        )
        to = {**self.to, second: changed} if first == ORDINARY else self.to
        return kind_table(kinds, to)

    def numbers_with(self, name: str) -> list[int]:
        """The numbers of the kinds that have a parameter of their own."""
        return [k for k, kind in enumerate(self.kinds, 1) if name in kind.parameters]

    @property
    def explicit(self) -> tuple[tuple[str, str], ...]:
        """Whose relation to whom somebody has said, in their order: the others follow from it."""
        found: dict[tuple[str, str], None] = {}
        for name, heeded in ((ORDINARY, self.to), *((kind.name, kind.to) for kind in self.kinds)):
            for other in heeded:
                others = [one for one in self.names if one != name] if other == ALL else [other]
                for one in others:
                    found[name, one if one in self.names else ALIASES[one]] = None
        return tuple(found)

    @property
    def with_model(self) -> dict[int, Kind]:
        """The kinds that have a model of their own, by their numbers."""
        return {number: kind for number, kind in enumerate(self.kinds, 1) if kind.model}

    @property
    def radius(self) -> float:
        """The largest radius that a relation names, length; 0 without one."""
        return max((one.radius or 0.0 for one in self.relations.values()), default=0.0)

    @property
    def catchers(self) -> list[tuple[int, int, Relation]]:
        """Who catches whom: numbers of both kinds, and their relation."""
        number = {name: k for k, name in enumerate(self.names)}
        return [
            (number[kind], number[other], relation)
            for (kind, other), relation in self.relations.items()
            if relation.catch > 0.0
        ]


def kind_table(kinds: tuple[Kind, ...], to: Mapping[str, Relation]) -> KindTable:
    """The kinds and their relations; `to` are those of the ordinary agents.

    Those whom another kind chases flee from it as far and as strongly, where nothing else is said.
    Raises InputError for a relation to a kind that there is not.
    """
    names = (ORDINARY, *(kind.name for kind in kinds))
    relations: dict[tuple[str, str], Relation] = {}
    for name, heeded in ((ORDINARY, to), *((kind.name, kind.to) for kind in kinds)):
        for other, relation in heeded.items():
            other = ALIASES.get(other, other) if other not in names else other
            if other == ALL:
                for one in names:
                    if one != name:
                        relations.setdefault((name, one), relation)
            elif other in names:
                relations[name, other] = relation
            else:
                raise InputError(
                    f"{unknown('kind', other, (*names, ALL))} ({relation.deed} of {name})"
                )
    for (name, other), relation in tuple(relations.items()):
        if relation.deed == "chase" and name != other:
            back = replace(relation, deed="flee", catch=0.0, caught="taken", first=False)
            relations.setdefault((other, name), back)
    return KindTable(kinds, relations, dict(to))


def complete_kinds(
    known: tuple[str, ...], kinds: tuple[Kind, ...], to: Mapping[str, Relation]
) -> KindTable:
    """The kinds of a flock whose rule knows some kinds by name, `agents.models.declare.Rule.kinds`.

    Those come first, in the rule's order, so that their numbers are 1, 2, ...; one that nobody asks
    for has no agents. They and the ordinary agents are neighbours, where no relation says
    otherwise. Raises InputError.

    >>> table = complete_kinds(("wolf",), (Kind("dog", 2),), {})
    >>> table.names, table.of("flock", "wolf").deed, table.of("flock", "dog").deed
    (('flock', 'wolf', 'dog'), 'own', 'ignore')
    """
    by_name = {kind.name: kind for kind in kinds}
    first = [by_name.pop(name, Kind(name, 0)) for name in known]
    table = kind_table((*first, *by_name.values()), to)
    demand_number(len(table.kinds))
    pairs = [(name, other) for name in (ORDINARY, *known) for other in (ORDINARY, *known)]
    for name, other in pairs if known else []:
        if name != other and (name, other) not in table.relations:
            table = table.with_relation(name, other, "own")
    return table


NO_KINDS = KindTable((), {})
"""Of a flock whose agents are all ordinary."""
