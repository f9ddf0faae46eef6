"""Experiments about Couzin's phases: runs there and back, names of phases, maps, claims."""

import io
import shutil
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from agents import Flock
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_file import LagClaim, PhaseClaim
from app.studies.experiment_reader import read_experiment, read_file
from app.studies.experiment_runner import MeasuredCase, run_experiment
from app.studies.figures.phases import PHASES, PhaseSettings, detects, place_in_sight
from app.studies.reports.report_formats import as_value, show
from app.studies.reports.tables import table_of
from app.studies.runs.database import FILE
from app.studies.runs.store import Store
from app.studies.runs.store_reader import StoreReader
from worlds.input_error import InputError

TEXT = """
kind = "phases"
title = "Small phases"
source = "these tests"
picture = "phases"
runs = 2
report = ["p", "m", "largest", "mixing", "phase"]

[settings]
world = "open"
dim = 3
settle = 30
hold = 10
looks = 2
every = 10

[sizes]
12 = 4.0

[[claims]]
says = "found"
measure = "phase"
word = "swarm"

[[sweeps]]
model = "couzin"
agents = [12]
parameter = "dr_o"
values = [0.0, 2.0, 6.0]
against = "dr_a"
against_values = [5.0, 9.0]

[[sweeps]]
model = "couzin"
agents = [12]
parameter = "dr_o"
values = [0.0, 2.0, 6.0]
there_and_back = true
fixed = { dr_a = 9.0 }
"""


def small(folder, text=TEXT):
    """The small experiment, read from a file."""
    path = folder / "small.toml"
    path.write_text(text)
    return read_file(path)


def carry_out(experiment, folder):
    return run_experiment(
        experiment, folder, runs=2, seed=1, workers=2, tell=None, at=lambda *_: None
    )


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The small experiment carried out, and its folder."""
    folder = tmp_path_factory.mktemp("phases")
    experiment = small(folder)
    return experiment, carry_out(experiment, folder), folder


def test_two_parameters_are_combined_and_a_way_goes_there_and_back(done):
    cases = done[0].cases
    assert [(case.at, case.value) for case in cases[:6]] == [
        (dr_a, dr_o) for dr_a in (5.0, 9.0) for dr_o in (0.0, 2.0, 6.0)
    ]
    assert [(case.way, case.value) for case in cases[6:]] == [
        *(("there", dr_o) for dr_o in (0.0, 2.0, 6.0)),
        *(("back", dr_o) for dr_o in (6.0, 2.0, 0.0)),
    ]
    assert {case.spec.parameters["dr_a"] for case in cases[6:]} == {9.0}
    assert done[0].paths == [*([k] for k in range(6)), [6, 7, 8, 9, 10, 11]]


def test_a_way_is_one_run(done):
    """Each step is that of one flock whose parameter is changed."""
    experiment, made, _ = done
    steps = made.measured[6:]
    for k, seed in enumerate((1, 2)):
        flock = Flock("couzin", agents=12, size=4.0, dim=3, world="open", rng=seed, dr_a=9.0)
        for one in steps:
            flock.set(dr_o=one.case.value)
            assert one.values["p"][k] == experiment.settings.run(flock, lambda: None)["p"]
        assert flock.tick == 30 + 20 + 5 * (10 + 20)


def test_what_is_done_is_in_the_store_step_by_step(done, tmp_path):
    experiment, made, folder = done
    rows = StoreReader(folder).runs()
    assert len({(cell, seed) for cell, seed, *_ in rows}) == len(rows) == 2 * 12
    again = carry_out(experiment, folder)
    assert (again.made, again.taken) == (0, 2 * 7)
    assert again.measured == made.measured
    shutil.copy(folder / FILE, tmp_path / FILE)
    with Store(tmp_path, []) as store:
        store.connection.execute(
            "DELETE FROM run WHERE cell IN (SELECT id FROM cell WHERE json LIKE '%\"dr_o\":6.0%')"
        )
    mended = carry_out(experiment, tmp_path)
    assert (mended.made, mended.taken) == (2 * 3, 2 * 4), "a way that lacks a step is run again"
    assert mended.measured == made.measured


@pytest.mark.parametrize(
    ("measures", "phase"),
    [
        ((0.9, 0.0, 94.9, 1.0), "fragments"),
        ((0.49, 0.49, 95.0, 1.0), "swarm"),
        ((0.49, 0.5, 100.0, 1.0), "torus"),
        ((0.5, 0.9, 100.0, 0.04), "dynamic parallel"),
        ((1.0, 0.0, 100.0, 0.039), "highly parallel"),
    ],
)
def test_phases_by_their_borders(measures, phase):
    settings = PhaseSettings(world="open", settle=0, hold=0, looks=1, every=1)
    assert settings.phase_of(*measures) == phase


def test_the_measures_of_groups_that_are_known():
    """Two pairs that fly apart, each along one line, and change no places within a pair."""
    position = np.array([[0.0, 0, 0], [2.0, 0, 0], [90.0, 0, 0], [92.0, 0, 0]])
    heading = np.array([[1.0, 0, 0]] * 4)
    flock = Flock(
        "couzin", world="open", size=100.0, dim=3, rng=1, sigma=0.0,
        start={"position": position, "heading": heading},
    )  # fmt: skip
    flock.tick = 1
    settings = PhaseSettings(world="open", settle=9, hold=3, looks=2, every=5)
    found = settings.run(flock, lambda: None)
    assert flock.tick == 1 + 3 + 2 * 5
    assert found["p"] == pytest.approx(1.0)
    assert found["m"] == pytest.approx(0.0, abs=1e-12)
    assert found["largest"] == 50.0
    assert found["mixing"] == pytest.approx(0.0, abs=1e-9)
    assert PHASES[found["phase"]] == "fragments"


def seen(position, heading, p):
    """Whether each agent detects another, one by one."""
    found = []
    for i, (x, u) in enumerate(zip(position, heading, strict=True)):
        others = [y - x for j, y in enumerate(position) if j != i]
        found.append(
            any(
                np.linalg.norm(d) < p.r_r
                or (
                    np.linalg.norm(d) <= p.r_r + p.dr_o + p.dr_a
                    and np.degrees(np.arccos(d @ u / np.linalg.norm(d))) <= p.alpha / 2
                )
                for d in others
            )
        )
    return found


@pytest.mark.parametrize("seed", range(5))
def test_every_agent_detects_another_at_the_start(seed):
    flock = Flock("couzin", agents=20, size=9.0, dim=3, world="open", rng=seed, dr_o=0.5, dr_a=1.0)
    before = flock.position.copy()
    at_first = seen(flock.position, flock.heading, flock.parameters)
    assert not all(at_first)
    assert detects(flock).tolist() == at_first
    place_in_sight(flock)
    assert all(seen(flock.position, flock.heading, flock.parameters))
    stay = detects(flock) & (flock.position == before).all(axis=1)
    assert stay.any()
    assert (flock.position >= 0.0).all()
    assert (flock.position < 9.0).all()


def test_a_start_without_company_is_refused():
    flock = Flock("couzin", agents=2, size=900.0, dim=3, world="open", rng=1, dr_o=0.0, dr_a=0.0)
    with pytest.raises(InputError, match="cannot be placed"):
        place_in_sight(flock)


def made_up(values):
    """Verdicts of the whole map of the paper with made-up values, by case."""
    experiment = read_experiment("couzin2002-phases")
    return experiment, verdicts(
        experiment, [MeasuredCase(case, values(case)) for case in experiment.cases]
    )


def memory(case):
    """A flock that stays parallel on the way back from dr_o = 4 down to 2."""
    torus = case.value <= 3.5 and not (case.way == "back" and case.value >= 2.0)
    p, phase = (0.1, "torus") if torus else (0.9, "highly parallel")
    noise = np.random.default_rng([case.way == "back", int(10 * case.value)]).normal(0.0, 0.003, 24)
    known = {"p": [p, p + 0.02], "m": [0.7, 0.7], "largest": [100.0] * 2, "mixing": [1.0] * 2}
    known |= {"phase": [PHASES.index(phase)] * 2}
    known = {name: values * 12 for name, values in known.items()}
    return known | {"p": list(known["p"] + noise), "m": list(known["m"] + noise)}


def test_claims_about_phases_and_memory():
    experiment, made = made_up(memory)
    found = {claim.text.partition(":")[0]: claim for claim in claims(made, experiment.said)}
    assert found["torus"].word == "holds"
    assert "in 56 of 84 cells" in found["torus"].text
    assert found["swarm"].word == "does not hold"
    assert found["dynamic parallel"].word == "does not hold"
    memorises = claims(made, [LagClaim(says="lags", measure="p", by=0.7)])
    assert [claim.word for claim in memorises] == ["holds"]
    assert "dr_o = 2 it is 0.11 on the way there, 0.91 on the way back" in memorises[0].text
    for measure, by in (("p", 0.81), ("m", 0.01)):
        [claim] = claims(made, [LagClaim(says="lags", measure=measure, by=by)])
        assert claim.word == "does not hold"


def test_a_word_that_is_none_is_refused(tmp_path):
    assert PhaseClaim(says="found", measure="phase", word="mill").word == "mill"
    with pytest.raises(InputError, match=r"unknown phase 'swam'.*'swarm'"):
        small(tmp_path, TEXT.replace('word = "swarm"', 'word = "swam"'))


def test_a_second_parameter_needs_values(tmp_path):
    with pytest.raises(InputError, match="against and against_values need each other"):
        small(tmp_path, TEXT.replace("against_values = [5.0, 9.0]", ""))


def test_the_table_is_within_80_columns_and_shows_every_cell():
    experiment, made = made_up(memory)
    paper = io.StringIO()
    show(Console(file=paper, width=80), experiment, made, [])
    text = paper.getvalue()
    assert "…" not in text
    assert text.count("torus") == 56 + 8 + 4 + 2, "in the cases, in the title and in a note"
    assert text.count("0.11") == 56 + 8 + 4


def test_a_table_of_a_map_alone_or_of_a_way_alone(done):
    experiment, made, _ = done
    for cases in (slice(0, 6), slice(6, 12)):
        part = replace(experiment, cases=experiment.cases[cases])
        found = verdicts(part, made.measured[cases])
        console = Console(file=io.StringIO(), width=80)
        console.print(table_of(found))
        assert ("columns: dr_o" in console.file.getvalue()) == (cases.start == 0)


def test_the_value_for_json_names_place_way_and_phase(done):
    experiment, made, _ = done
    rows = as_value(experiment, verdicts(experiment, made.measured), [])["rows"]
    assert len(rows) == 12 * 5
    assert {(row["against"], row["at"]) for row in rows[:30]} == {("dr_a", 5.0), ("dr_a", 9.0)}
    assert {row["way"] for row in rows[30:]} == {"there", "back"}
    phases = [row["commonest"] for row in rows if row["measure"] == "phase"]
    assert set(phases) <= set(PHASES)
    assert {row["commonest"] for row in rows if row["measure"] != "phase"} == {""}
