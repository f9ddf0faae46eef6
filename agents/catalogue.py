"""The models by name: a rule, the body that carries it out, and what they start with.

A new rule is one file in `agents/rules/` and one line in `RULES` below. Another package adds rules
through the entry-point group `flockscope.rules`, each entry a `Rule`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import entry_points

from pydantic import create_model

from agents.bodies import constant_speed
from agents.declare import Body, Parameters, Rule
from agents.rules import hwvem, ivem, vicsek, wvem
from worlds.refusal import unknown

RULES = [
    vicsek.VEM,
    vicsek.VEM_A,
    ivem.IVEM,
    ivem.IVEM_A,
    wvem.WVEM,
    hwvem.HWVEM,
]


@dataclass(frozen=True)
class Model:
    """A rule and a body under one name, with one set of parameters."""

    rule: Rule
    body: Body

    @property
    def name(self) -> str:
        """Name on the command line and in a spec."""
        return self.rule.name

    @property
    def title(self) -> str:
        """Name for people."""
        return self.rule.title

    @property
    def summary(self) -> str:
        """What it does, in a sentence or two."""
        return self.rule.summary

    @property
    def dimensions(self) -> tuple[int, ...]:
        """Dimensions in which it is defined."""
        return self.rule.dimensions

    @property
    def informed(self) -> int:
        """Information agents unless the user says otherwise."""
        return self.rule.informed

    @cached_property
    def parameters(self) -> type[Parameters]:
        """The parameters of the rule and of the body, as one model."""
        return create_model(self.rule.name, __base__=(self.body.parameters, self.rule.parameters))

    @cached_property
    def parts(self) -> dict:
        """The compiled functions that make its loop."""
        rule = self.rule
        return {
            "decide": rule.decide,
            "show": rule.show,
            "remember": rule.remember,
            "prepare": rule.prepare,
            "move": self.body.move,
        }


def collect() -> dict[str, Model]:
    """All models: the built-in ones, then those of other packages."""
    rules = [*RULES, *(entry.load() for entry in entry_points(group="flockscope.rules"))]
    return {rule.name: Model(rule, constant_speed.BODY) for rule in rules}


MODELS = collect()


def model(name: str) -> Model:
    """The model of that name. Raises Refusal with the nearest name."""
    if name not in MODELS:
        raise unknown("model", name, MODELS)
    return MODELS[name]
