"""`flockscope.batch_run`: the rows of `mesa.batch_run`, and a line for what it does not take."""

import os

import mesa
import numpy as np
import pytest

from agents.catalogue import MODELS
from agents.individuals import each, normal
from app.studies.sweeps import batch_run as module
from app.studies.workers import thread_executor
from flockscope import Flock, InputError, Spec, batch_run

PARAMETERS = {"model": "vem", "agents": 20, "eta": [0.0, 0.5], "r": np.array([0.5, 1.0])}
QUIET = {"display_progress": False}


@pytest.mark.parametrize(
    ("parameters", "more"),
    [
        ({}, {"rng": [1, 2, 3], "max_steps": 10}),
        ({}, {"rng": 5, "max_steps": 10, "data_collection_period": 1}),
        (
            {"collect": [["polarisation", "groups"]]},
            {"rng": (4, 5), "max_steps": 10, "data_collection_period": 4},
        ),
        ({"activation": "random", "dim": 3}, {"rng": [np.random.default_rng(1)], "max_steps": 3}),
        ({"seed": 3}, {"max_steps": 2}),
        ({}, {"rng": [1], "max_steps": 0}),
    ],
)
def test_the_rows_are_those_of_mesa(parameters, more):
    """In the same order of runs and of columns."""
    ours = batch_run(Flock, PARAMETERS | parameters, **more, **QUIET)
    if isinstance(more.get("rng"), list) and not isinstance(more["rng"][0], int):
        more = more | {"rng": [np.random.default_rng(1)]}
    theirs = mesa.batch_run(Flock, PARAMETERS | parameters, **more, **QUIET)
    for row in (*ours, *theirs):
        row.pop("rng") if isinstance(row["rng"], np.random.Generator) else None
    assert ours == theirs
    assert [list(row) for row in ours] == [list(row) for row in theirs]


def test_a_seed_that_is_drawn_is_told():
    rows = batch_run("vem", {"agents": 5}, iterations=2, max_steps=3, **QUIET)
    assert [(row["iteration"], row["rng"]) for row in rows] == [(0, None), (1, None)]
    assert rows[0]["seed"] != rows[1]["seed"]
    flock = Flock("vem", agents=5, rng=rows[0]["seed"])
    flock.run(3)
    assert rows[0]["polarisation"] == flock.observe("polarisation")


def test_values_may_be_distributions_which_rows_have_as_text():
    """A list is one of values: the numbers of each agent are a list in it, as are `each`'s."""
    values = [normal(0.3, 0.1), normal(0.3, 1 / 30), 0.3, [0.1, 0.2, 0.3]]
    rows = batch_run(
        Flock, {"agents": 3, "model": "vem", "eta": values}, rng=[1], max_steps=3, **QUIET
    )
    assert [row["eta"] for row in rows] == [
        "normal(0.3, 0.1)",
        "normal(0.3, 0.03333333333333333)",
        0.3,
        [0.1, 0.2, 0.3],
    ]
    for row, value in zip(rows, values, strict=True):
        flock = Flock("vem", agents=3, eta=value, rng=1)
        flock.run(3)
        assert row["polarisation"] == flock.observe("polarisation")
    one = batch_run(
        "vem", {"agents": 3, "eta": each([0.1, 0.2, 0.3])}, rng=[1], max_steps=3, **QUIET
    )
    assert one[0]["polarisation"] == rows[3]["polarisation"]
    assert one[0]["eta"] == "each of 3 agents"


def test_a_spec_says_what_all_runs_share():
    spec = Spec("hwvem", agents=8, parameters={"eta": 0.3})
    rows = batch_run(spec, {"p1": [0.1, 0.2]}, rng=[1], max_steps=5, **QUIET)
    for row in rows:
        flock = Flock("hwvem", agents=8, eta=0.3, p1=row["p1"], rng=1)
        flock.run(5)
        assert row["polarisation"] == flock.observe("polarisation")


def test_processes_find_the_same_rows(monkeypatch):
    more = {"rng": range(40), "max_steps": 10, "number_processes": 1, **QUIET}
    here = batch_run(Flock, PARAMETERS, **more)
    monkeypatch.setattr(thread_executor, "TRIAL", 0.0)
    monkeypatch.setattr(thread_executor, "START", 0.0)
    begun = []
    begin = module.ProcessExecutor

    def note(*arguments):
        begun.append(begin(*arguments))
        return begun[-1]

    monkeypatch.setattr(module, "ProcessExecutor", note)
    assert batch_run(Flock, PARAMETERS, **more) == here
    monkeypatch.setattr(module, "is_built_in", lambda _: False)
    monkeypatch.setattr(module, "ThreadExecutor", lambda *_: None)
    assert batch_run(Flock, PARAMETERS, **more) == here, "code of one's own has processes"
    assert begun


class OtherStep(Flock):
    def step(self):
        os.abort()


@pytest.mark.parametrize(
    ("arguments", "more", "message"),
    [
        ((mesa.Model, {}), {}, "model_cls = .* is not allowed: Flock, a Spec or the name"),
        ((OtherStep, {}), {}, "mesa.batch_run takes any Mesa model"),
        (("vemm", {}), {}, "vemm.*vem"),
        (("vem", {"agents": []}), {}, "agents has no values"),
        (("vem", {"agent_reporters": {}}), {}, "agent_reporters is not taken by .*batch_run"),
        (("vem", {}), {"iterations": 2, "rng": 1}, "iterations and rng both say"),
        (("vem", {}), {"data_collection_period": 0}, "data_collection_period = 0"),
        (("vem", {}), {"number_processes": 0}, "number_processes = 0"),
        (("vem", {}), {"max_steps": -1}, "max_steps = -1"),
        (("vem", {"agents": 5, "eta": [0.0, 99.0]}), {"rng": 1}, r"eta = 99.0 .* \(RunId 1\)"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(arguments, more, message):
    with pytest.raises(InputError, match=message):
        batch_run(*arguments, **more, **QUIET)


@pytest.mark.exhaustive
def test_every_model_runs_in_a_batch():
    names = list(MODELS)
    rows = batch_run(Flock, {"model": names, "agents": 6}, rng=[3], max_steps=2, **QUIET)
    assert [row["model"] for row in rows] == names
