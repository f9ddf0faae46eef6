"""Every model keeps to what `agents.conformance` says, built in or brought by a plug-in."""

from __future__ import annotations

from dataclasses import replace

import pytest

from agents.bodies import constant_speed
from agents.catalogue import MODELS
from agents.conformance import CHECKS, outcome
from agents.engine.block import Wish
from agents.models.declare import ALL_ALIKE
from agents.models.model import Model
from worlds.compiled import compiled

NOT_ALIKE = {
    "ivem": {"rotation"},
    "ivem-a": {"rotation"},
    "ivem-a-nav": {"rotation"},
    "guarded": {"mirror"},
    "pedestrian": {"rotation"},
}
"""Models for which space has a preferred direction or side, by their papers' own equations."""


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
@pytest.mark.parametrize("check", CHECKS)
def test_every_model_conforms(model, check):
    found = outcome(model, check)
    assert found.result != "fails", found.reason
    assert (found.result == "does not apply") == (check in NOT_ALIKE.get(model.name, ()))


@compiled
def east(me, near, surroundings, p):  # noqa: ARG001
    """To the east, whatever anybody does."""
    return Wish(1.0, 0.0, 0.0)


@compiled
def restless(me, near, surroundings, p):  # noqa: ARG001
    """Turns the first of its neighbours around, in the copy that the next one is given."""
    near.ux[0] = -near.ux[0]
    return Wish(near.ux[0], near.uy[0], 0.0)


@compiled
def nowhere(me, near, surroundings, p):  # noqa: ARG001
    """Nowhere: the square root of what is negative."""
    return Wish((me.ux - 9.0) ** 0.5, 0.0, 0.0)


@pytest.mark.parametrize(
    ("decide", "fails", "holds"),
    [
        (east, {"rotation"}, {"shift", "mirror", "order", "threads", "one spot"}),
        (restless, {"order"}, {"shift"}),
        (nowhere, {"one spot", "inside", "bounds"}, set()),
    ],
    ids=["points east", "writes to its neighbours", "is nowhere"],
)
def test_a_rule_that_breaks_a_fact_is_found_out(monkeypatch, decide, fails, holds):
    rule = replace(MODELS["vem"].rule, name="wrong", decide=decide, dimensions=(2,))
    made = Model(rule, constant_speed.BODY)
    monkeypatch.setitem(MODELS, "wrong", made)
    for check in fails:
        assert outcome(made, check).result == "fails", check
    for check in holds:
        assert outcome(made, check).result == "holds", check
    declared = replace(rule, symmetries=tuple(s for s in ALL_ALIKE if s not in fails))
    if "rotation" in fails:
        unsymmetric = Model(declared, constant_speed.BODY)
        assert outcome(unsymmetric, "rotation").result == "does not apply"
