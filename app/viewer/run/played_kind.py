"""A kind of agents that a person plays: nothing of the run but its own numbers may change.

It is checked in the thread of the simulation, where all that changes a run comes by, whatever
controls a page shows; and where a person asks to steer an agent by hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from agents.catalogue import MODELS
from agents.kinds import ORDINARY, Kind, KindTable, kind_table, replace_kind
from agents.models.declare import checked
from agents.spec import OPTIONS, Spec
from worlds.input_error import InputError, unknown


def with_kinds_apart(spec: Spec) -> Spec:
    """The same run, of which each kind has all its numbers and relations as its own.

    What one kind is given then changes no other, which would else share it. Raises InputError.
    """
    table, model = kind_table(spec.kinds, spec.to), MODELS[spec.model]
    shared = checked(model.parameters, spec.parameters).model_dump() | spec.individuals
    for kind in table.kinds:
        if not kind.model:  # one by a model of its own shares no number with others
            own = {name: shared[name] for name in model.individual} | kind.parameters
            table = table.with_kind(replace_kind(kind, parameters=own))
    for (name, other), relation in tuple(table.relations.items()):
        table = table.with_relation(name, other, relation)
    return spec.but(kinds=table.kinds, to=table.to)


@dataclass(frozen=True)
class PlayedKind:
    """A kind by its name, and the run with which its player begins; see `with_kinds_apart`.

    Raises InputError for a kind that the run has not.
    """

    name: str
    spec: Spec

    def __post_init__(self) -> None:
        names = kind_table(self.spec.kinds, self.spec.to).names
        if self.name not in names:
            raise unknown("kind", self.name, names)

    @property
    def own(self) -> tuple[str, ...]:
        """The parameters that all agents share by default and that are its own: of the ordinary
        agents those in which agents may differ."""
        return MODELS[self.spec.model].individual if self.name == ORDINARY else ()

    def own_of(self, kind: Kind) -> tuple[str, ...]:
        """The parameters of which a kind may have numbers of its own."""
        return MODELS[kind.model or self.spec.model].individual

    def demand_run(self, spec: Spec, beside: Spec | None) -> None:
        """Raise InputError for a run that differs by more than its own numbers and the seed."""
        if beside is not None:
            raise self.refuse("the model beside")
        meant, given = self.options(self.spec), self.options(spec)
        for name, value in meant.items():
            if given.get(name) != value:
                raise self.refuse(name)
        self.demand_kinds(kind_table(spec.kinds, spec.to))

    def options(self, spec: Spec) -> dict[str, Any]:
        """What of a run is not its own, but for kinds and the seed."""
        declared = checked(MODELS[spec.model].parameters, spec.parameters).model_dump()
        values = declared | spec.individuals
        options = {name: getattr(spec, name) for name in OPTIONS if name != "seed"}
        return options | {"model": spec.model} | {
            name: value for name, value in values.items() if name not in self.own
        }  # fmt: skip

    def demand_parameter(self, name: str, beside: bool) -> None:
        """Raise InputError for a parameter of all agents that is not its own."""
        if beside or name not in self.own:
            raise self.refuse(name)

    def demand_steering(self, kind: str) -> None:
        """Raise InputError for steering agents of another kind by hand."""
        if kind != self.name:
            raise self.refuse(f"the steering of {kind}")

    def demand_kinds(self, kinds: KindTable) -> None:
        """Raise InputError for kinds that differ by more than its own numbers."""
        begun = self.others(kind_table(self.spec.kinds, self.spec.to))
        given = self.others(kinds)
        for name in dict.fromkeys([*begun, *given]):
            if begun.get(name) != given.get(name):
                raise self.refuse(name)

    def others(self, kinds: KindTable) -> dict[str, Any]:
        """What of kinds is not its own, by what it is called."""
        values: dict[str, Any] = {}
        for kind in kinds.kinds:
            values[f"the number of {kind.name}"] = kind.agents
            values[f"the start of {kind.name}"] = kind.start
            values[f"the steering of {kind.name}"] = kind.steered, kind.policy
            values[f"the model of {kind.name}"] = kind.model
            values[f"the colour of {kind.name}"] = kind.colour
            free = self.own_of(kind) if kind.name == self.name else ()
            values |= {
                f"{key} of {kind.name}": own
                for key, own in kind.parameters.items()
                if key not in free
            }
        for (name, other), relation in kinds.relations.items():
            is_own = name == self.name
            what = (relation.deed, relation.power, relation.first, relation.caught)
            values[f"what {name} does about {other}"] = what if is_own else relation
        return values

    def refuse(self, what: str) -> InputError:
        """The refusal of what is not its own."""
        return InputError(f"you play {self.name}: {what} cannot be changed here")
