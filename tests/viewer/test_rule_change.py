"""A rule whose file is saved anew: the running flock goes on under it, or under the one before."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import viser

from agents.catalogue import FILES, MODELS, from_file
from agents.flock import Flock
from app.viewer.lab.panels.rule_source import MOST_CODE, rule_code
from app.viewer.lab.rule_files import EVERY, RuleFiles
from app.viewer.panels.parameters import ParametersPanel
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from tests.viewer.waiting import until
from worlds.input_error import InputError

RULE = """
from flockscope.rules import Decision, Rule, Vicsek, compiled, parameter

class Own(Vicsek):
    {parameter}

@compiled
def decide(me, near, surroundings, p):
    {decide}

RULE = Rule(name="changing", title="Changing", summary="It changes.", equation="u_i",
            source="a test", parameters=Own, decide=decide{more})
"""
TURN = 'parameter(0.5, "How far", symbol="t", low=0.0, high=1.0, step=0.1, source="x")'


def text(decide: str, parameter: str = "pass", more: str = "") -> str:
    return RULE.format(decide=decide, parameter=parameter, more=more)


STRAIGHT = text("return Decision(me.ux, me.uy, me.uz)")


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "changing.py"
    path.write_text(STRAIGHT)
    from_file(str(path))
    yield path
    FILES.pop("changing", None)


@pytest.fixture
def simulation(path):
    assert path.exists()
    made = Simulation(
        preset_spec("changing", agents=20, seed=3, parameters={"r": 0.7}),
        running=False,
        build=partial(Flock, interpret=True),
    )
    until(lambda: made.frame)
    made.step(5).result(60)
    until(lambda: made.frame.tick == 5)
    yield made
    made.close()


def test_the_flock_goes_on_from_where_it_is_with_what_the_rule_has_new(path, simulation):
    before, run = simulation.frame, simulation.state.run
    path.write_text(text("return Decision(-me.uy, me.ux, 0.0)", f"turn: float = {TURN}"))
    assert simulation.take_rule(path).result(60) == "changing"
    until(lambda: simulation.frame.run > run)
    assert simulation.frame.tick == 5
    np.testing.assert_array_equal(simulation.frame.position, before.position)
    np.testing.assert_array_equal(simulation.frame.ids, before.ids)
    assert (simulation.state.values["r"], simulation.state.values["turn"]) == (0.7, 0.5)
    simulation.step(1).result(60)
    until(lambda: simulation.frame.tick == 6)
    left = np.column_stack([-before.heading[:, 1], before.heading[:, 0]])
    np.testing.assert_allclose(simulation.frame.heading, left, atol=1e-12)
    simulation.reset()
    until(lambda: simulation.frame.tick == 0), "a reset begins at the start, not at the change"


def test_what_a_rule_has_new_is_a_slider_and_no_change(path, simulation):
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        panel = ParametersPanel(server.gui, simulation)
        panel.refresh(simulation.state)
        before = panel.controls["r"]
        simulation.reset()
        until(lambda: simulation.state.run > panel.shown_run)
        panel.refresh(simulation.state)
        assert panel.controls["r"] is before, "the same rule keeps its sliders"
        path.write_text(text("return Decision(me.ux, me.uy, 0.0)", f"turn: float = {TURN}"))
        simulation.take_rule(path).result(60)
        panel.refresh(simulation.state)
        assert panel.controls["turn"].value == 0.5
        assert panel.changes == {}
    finally:
        server.stop()


def test_a_value_that_is_out_of_the_new_range_takes_the_default(path, simulation):
    narrow = 'r: float = parameter(0.2, "R", symbol="r", low=0.1, high=0.5, step=0.1, source="x")'
    path.write_text(text("return Decision(me.ux, me.uy, me.uz)", narrow))
    simulation.take_rule(path).result(60)
    until(lambda: simulation.state.values["r"] == 0.2)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        (STRAIGHT.replace("return", "return ("), "changing.py, line 9: '(' was never closed"),
        (text("return Decision(near.xx[0], 0.0, 0.0)"), "line 9: "),
        (text("return Decision(me.x / 0.0 * 0.0, 0.0, 0.0)"), "changing.py"),
        (text("return Decision(p.speeed, 0.0, 0.0)"), "no parameter 'speeed'"),
        (text("return None", more=", nonsense=1"), "unexpected keyword argument 'nonsense'"),
    ],
)
def test_what_is_wrong_is_one_line_and_the_rule_before_goes_on(path, simulation, written, words):
    before = MODELS["changing"]
    path.write_text(written)
    with pytest.raises(InputError) as fault:
        simulation.take_rule(path).result(60)
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)
    assert str(fault.value).count("changing.py") == 1
    assert MODELS["changing"] is before
    assert not simulation.state.error
    simulation.step(1).result(60)
    until(lambda: simulation.frame.tick == 6)
    path.write_text(STRAIGHT)
    assert simulation.take_rule(path).result(60) == "changing"


def test_agents_tell_and_remember_what_both_rules_have(path, simulation):
    two = ', memory=("one", "two"), units={"one": "1", "two": "1"}'
    path.write_text(text("me.memory[1] = 7.0\n    return Decision(me.ux, me.uy, 0.0)", more=two))
    simulation.take_rule(path).result(60)
    simulation.step(1).result(60)
    until(lambda: simulation.frame.tick == 6)
    other = ', memory=("two", "three"), units={"two": "1", "three": "1"}'
    path.write_text(text("return Decision(me.ux, me.uy, 0.0)", more=other))
    simulation.take_rule(path).result(60)
    until(lambda: simulation.run.flock.model.columns == ("two", "three"))
    assert (simulation.run.flock.arrays.memory == np.array([[7.0], [0.0]])).all()


def test_a_file_counts_once_it_is_whole_and_may_be_away_for_a_moment(tmp_path):
    path, now, changed = tmp_path / "rule.py", [0.0], []
    path.write_text("one")
    files = RuleFiles({"rule": path}, changed.append, clock=lambda: now[0])

    def look() -> None:
        now[0] += EVERY
        files.look()

    path.write_text("half of tw")
    look()
    path.write_text("two")
    look()
    assert changed == [], "it was still being written"
    look()
    assert changed == [path]
    path.unlink()
    look()
    path.write_text("two")
    look()
    look()
    assert changed == [path], "the same again"
    files.look()
    path.write_text("three")
    files.look()
    files.look()
    assert changed == [path], "it is not time to look"


@pytest.mark.parametrize("model", MODELS)
def test_the_code_of_every_model_can_be_read(model):
    code = rule_code(MODELS[model].rule)
    assert "def " in code
    assert "agents/rules/" in code
    assert len(code) < MOST_CODE
