"""The card of an agent: words and units for every row, six of them at first, the rest folded up."""

from __future__ import annotations

import html
import re
from dataclasses import replace

import numpy as np
import pytest
import viser

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.individuals import normal, one_of, uniform
from agents.inspection import Inspection
from agents.kinds import Kind, chase
from agents.models.model import vector_name
from app.viewer.lab.panels.inspector import FIRST, ON_ITS_WAY, Inspector, facts, folds, head
from app.viewer.run.frame_builder import FrameBuilder
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.shown.frame import Frame

VALUE = 0.25
ANGLES, UNIT_FREE = {"heading", "climb"}, {"group", "listens to"}


def inspected(name: str) -> tuple[Frame, Inspection]:
    """Agent 3 of a model at home that hears agents 1 and 2, one of them thrice as much."""
    flock = Flock(preset_spec(name, seed=3, agents=5))
    rule, body, dim = flock.model.rule, flock.model.body, flock.world.dim
    forces = {force: np.arange(1.0, dim + 1) for force in (*rule.forces, *body.forces)}
    seen = Inspection(
        int(flock.ids[3]),
        3,
        np.array([1, 2]),
        np.ones((2, dim)),
        np.array([3.0, 1.0]),
        dict.fromkeys(flock.model.columns, VALUE),
        forces,
        places=rule.places,
        minds=True,
        model=flock.model,
    )
    return FrameBuilder(flock, 1).build(), seen


def rows(text: str) -> dict[str, str]:
    """The rows of the tables in some HTML, first cell -> last."""
    cells = (re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", text))
    return {html.unescape(row[0]): html.unescape(row[-1]) for row in cells}


@pytest.mark.parametrize("name", MODELS)
def test_every_row_has_words_and_its_unit(name):
    frame, seen = inspected(name)
    model, told = MODELS[name], facts(frame, seen)
    length, pace = model.in_units("length"), model.in_units("length/time")
    assert list(told)[:2] == [f"position ({length})", "heading"]
    assert told["speed"].endswith(f" {pace}")
    assert told["neighbours"] == "2 agents"
    for column in model.columns:
        if ON_ITS_WAY in column:
            continue
        words = {**model.rule.words, **model.body.words}
        called = words.get(column, words.get(vector_name(column), ""))
        assert called, f"{column} of {name} has no words"
        assert len(called) <= 24
        unit = model.unit_of(column)
        shown = next(row for row in told if row.startswith(called.removesuffix("?")))
        if called.endswith("?"):
            assert told[shown] == "yes"
        elif unit != "1":
            assert unit in (shown + told[shown]).replace("(", " ").replace(")", " ").split()
    for row, value in told.items():
        assert row not in ANGLES or value.endswith("°")
        assert "_" not in row


@pytest.mark.parametrize("name", MODELS)
def test_six_rows_come_first_and_the_others_are_folded_up(name):
    frame, seen = inspected(name)
    told = facts(frame, seen)
    folded = folds(frame, seen)
    assert list(rows(head(frame, seen))) == list(told)[:FIRST]
    rest = rows(folded["rest"][1]) if "rest" in folded else {}
    assert list(rest) == list(told)[FIRST:]
    assert len(rest) == max(0, len(told) - FIRST)
    if rest:
        more = len(rest)
        assert folded["rest"][0] == (f"{more} more rows" if more > 1 else "1 more row")
    assert ("forces" in folded) == bool(seen.forces)
    assert folded["heard"][0] == "Listens to 2 agents"
    assert list(rows(folded["heard"][1]).values()) == ["75 %", "25 %"]


@pytest.mark.parametrize("name", ["boundary-points", "vasarhelyi", "olfati-saber", "squashing"])
def test_forces_have_the_unit_of_what_they_are_terms_of(name):
    frame, seen = inspected(name)
    model = MODELS[name]
    unit = model.in_units("length/time") + ("²" if model.rule.wish == "acceleration" else "")
    told = rows(folds(frame, seen)["forces"][1])
    assert len(told) == len(seen.forces)
    assert all(value.endswith(f" {unit}") for value in told.values())


def test_drag_saved_is_among_the_first_and_in_per_cent():
    frame, seen = inspected("safe")
    assert rows(head(frame, seen))["drag saved"] == "+25.0 %"
    unknown = replace(seen, signals={"saved": np.nan})
    assert facts(frame, unknown)["drag saved"] == "unknown"


def test_one_that_listens_to_nobody_says_so():
    frame, seen = inspected("vem")
    alone = replace(seen, weights=np.zeros(2))
    assert facts(frame, alone)["listens to"] == "nobody"
    assert "heard" not in folds(frame, alone)


@pytest.fixture(scope="module")
def server():
    made = viser.ViserServer(port=0, verbose=False)
    yield made
    made.stop()


def test_the_window_says_whose_it_is_and_where_that_one_is_drawn(server):
    frame, seen = inspected("guarded")
    inspector = Inspector(server.gui, lambda: None)
    assert not inspector.panel.visible
    inspector.refresh(replace(frame, inspected=seen), 3, (1.0, -2.5, 0.25))
    assert inspector.panel.visible
    assert 'data-at="1.0000 -2.5000 0.2500"' in inspector.head.content
    assert f"Agent {seen.id}" in inspector.head.content
    shown = {name for name, (folder, _) in inspector.folds.items() if folder.visible}
    assert shown == {"rest", "heard"}
    inspector.refresh(frame, 3, (1.0, -2.5, 0.25))
    assert "Looking closer" in inspector.head.content
    assert not any(folder.visible for folder, _ in inspector.folds.values())
    inspector.refresh(frame, None)
    assert not inspector.panel.visible


def test_browsers_are_told_nothing_while_nothing_changes(server, monkeypatch):
    frame, seen = inspected("guarded")
    inspector = Inspector(server.gui, lambda: None)
    one = replace(frame, inspected=seen)
    inspector.refresh(one, 3, (1.0, 2.0, 3.0))
    told = []
    monkeypatch.setattr(server.gui._websock_interface, "queue_message", told.append)
    inspector.refresh(one, 3, (1.0, 2.0, 3.0))
    assert told == []


def test_an_agent_shows_its_own_numbers_beside_what_they_are_drawn_from():
    flock = Flock(preset_spec("couzin", seed=3, agents=9, parameters={"s": normal(3.0, 0.5)}))
    flock.run(2)
    frame, seen = FrameBuilder(flock, 1).build(), flock.inspect(4)
    title, text = folds(frame, seen)["own"]
    assert title == f"Its own s: {flock.own['s'][4]:.4g}"
    (value,) = rows(text).values()
    assert value.startswith(f"{flock.own['s'][4]:.4g}")
    assert value.endswith("of normal(3, 0.5)")
    flock.set(r_r=uniform(0.5, 1.5))
    frame, seen = FrameBuilder(flock, 1).build(), flock.inspect(4)
    assert folds(frame, seen)["own"][0] == "2 numbers of its own"
    assert f"{flock.own['r_r'][4]:g}" in folds(frame, seen)["zones"][1]
    flock.set(s=3.0, r_r=1.0)
    assert "own" not in folds(FrameBuilder(flock, 1).build(), flock.inspect(4))


def test_the_reach_is_that_of_the_agent():
    flock = Flock(preset_spec("vem", seed=3, agents=9, parameters={"r": one_of(0.5, 1.0)}))
    frame = FrameBuilder(flock, 1).build()
    assert frame.reach == 1.0
    assert np.array_equal(frame.reaches, flock.own["r"])
    couzin = Flock("couzin", agents=5, rng=1, dr_o=uniform(1.0, 4.0))
    reaches = FrameBuilder(couzin, 1).build().reaches
    assert np.allclose(reaches, [couzin.parameters_of(row).range for row in range(5)])
    assert FrameBuilder(Flock("vem", agents=5), 1).build().reaches is None


def test_an_agent_tells_its_kind_and_what_that_has_as_its_own():
    kinds = [Kind("shark", 1, s=normal(4.0, 0.1), to={"flock": chase(1.0, 5.0)}), Kind("whale", 1)]
    flock = Flock(
        preset_spec("couzin", seed=3, agents=9, kinds=kinds, parameters={"s": normal(3.0, 0.5)})
    )
    frame = FrameBuilder(flock, 1).build()
    for kind, source in (
        ("shark", "normal(4, 0.1)"), ("whale", "normal(3, 0.5)"), ("flock", "normal(3, 0.5)"),
    ):  # fmt: skip
        seen = flock.inspect(int(flock.rows_of(kind)[0]))
        assert f"kind {kind}" in head(frame, seen)
        (value,) = rows(folds(frame, seen)["own"][1]).values()
        assert value.endswith(f"of {source}")
    other = Kind("robot", 1, model="leadership", parameters={"tau": 0.1, "omega": 0.7})
    both = Flock(preset_spec("couzin", seed=3, agents=9, dim=2, kinds=[other]))
    frame, seen = FrameBuilder(both, 1).build(), both.inspect(int(both.rows_of("robot")[0]))
    assert "kind robot, leadership" in head(frame, seen)
    own = rows(folds(frame, seen)["own"][1])
    assert [value for name, value in own.items() if name.endswith("ω")] == ["0.7"]
    assert len(own) == len(MODELS["leadership"].individual)
    flock.arrays.kind[2] = -1.0
    assert "caught" in head(FrameBuilder(flock, 1).build(), flock.inspect(2))
    alone = Flock("vem", agents=5, rng=1)
    assert "kind" not in head(FrameBuilder(alone, 1).build(), alone.inspect(2))
