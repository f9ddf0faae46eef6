"""Every model keeps to what `agents.conformance` says, built in or brought by a plug-in."""

from __future__ import annotations

from dataclasses import replace

import pytest

from agents.bodies import constant_speed
from agents.catalogue import MODELS
from agents.conformance import CHECKS, outcome
from agents.engine.block import Decision
from agents.models.declare import ALL_ALIKE
from agents.models.model import Model
from agents.models.tries import LessonCheck, LessonStep
from agents.spec import Options
from worlds.compilation import compiled

NOT_ALIKE = {
    "ivem": {"rotation"},
    "ivem-a": {"rotation"},
    "ivem-a-nav": {"rotation"},
    "guarded": {"mirror"},
    "leadership": {"rotation", "mirror"},
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
    return Decision(1.0, 0.0, 0.0)


@compiled
def restless(me, near, surroundings, p):  # noqa: ARG001
    """Turns the first of its neighbours around, in the copy that the next one is given."""
    near.ux[0] = -near.ux[0]
    return Decision(near.ux[0], near.uy[0], 0.0)


@compiled
def nowhere(me, near, surroundings, p):  # noqa: ARG001
    """Nowhere: the square root of what is negative."""
    return Decision((me.ux - 9.0) ** 0.5, 0.0, 0.0)


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


def test_each_model_has_three_things_to_try_each_told_in_full():
    for name, model in MODELS.items():
        assert len(model.to_try) == 3, name
        for one in model.to_try:
            assert one.words.endswith("."), one.words
            assert one.see.endswith("."), one.see
            assert len({other.words for other in model.to_try}) == 3
            assert set(one.set) <= {"agents", *Options.model_fields, *model.parameters.model_fields}


def test_what_does_not_come_true_is_found_out(monkeypatch):
    calm = LessonStep(
        "Add no noise.", "Disorder.", {"eta": 0.0}, LessonCheck("polarisation", "below", 0.3, 60)
    )
    begun = replace(calm, set={"agents": 20})
    for one, words in (
        (calm, "not polarisation: below 0.3 after 60 ticks, but"),
        (begun, "agents needs anew=True"),
    ):
        made = replace(MODELS["vem"], tries=(one,), suffix="-told")
        monkeypatch.setitem(MODELS, made.name, made)
        found = outcome(made, "tries")
        assert found.result == "fails"
        assert words in found.reason
    assert outcome(replace(made, tries=()), "tries").result == "does not apply"


def test_a_proof_has_a_relation():
    with pytest.raises(TypeError, match="'grows' is no relation: below, above, falls, rises"):
        LessonCheck("polarisation", "grows", 0.3, 60)
