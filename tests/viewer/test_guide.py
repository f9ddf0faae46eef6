"""The guide's pages say of every model what is its own; what is tried belongs to what runs."""

from __future__ import annotations

import asyncio
import html
import queue
from types import SimpleNamespace

import pytest

from agents.catalogue import MODELS
from app.viewer.lab.panels.model_guide import (
    TryRunner,
    describe_model,
    describe_source,
    is_done,
    lesson,
)
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation_state import SimulationState


@pytest.mark.parametrize("model", MODELS.values(), ids=lambda model: model.name)
def test_it_says_what_a_model_is_and_what_to_try_with_it(model):
    page = html.unescape(describe_model(model.name))
    for words in (model.summary, model.rule.source, model.body.title, model.body.source):
        assert words in page
    for number, one in enumerate(model.to_try, 1):
        text = html.unescape(lesson(number, one, TryRunner.settings(model.name, one)))
        assert f"{number}. {one.words}" in text
        assert one.see in text
        assert ("The run begins again." in text) == one.anew
    assert f"{model.agents} agents" in describe_source(model)


def test_nothing_is_done_to_the_flock_of_another_model():
    told = queue.SimpleQueue()
    state = SimulationState(preset_spec("couzin"), values={"r": 1.0})
    tries = TryRunner(SimpleNamespace(state=state, notices=told), None, None)
    button = SimpleNamespace(label="Do it", color="green")
    one = MODELS["vem"].to_try[0]
    asyncio.run(tries.toggle_step("vem", one, SimpleNamespace(target=button)))
    assert told.get_nowait() == "Vicsek model does not run: open the guide again"
    assert button.label == "Do it"
    assert not is_done(state, one)
