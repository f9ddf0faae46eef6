"""Experiments about flocks that gather and crash: looks, groups, shares, printed runs."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from agents import Flock
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment import flock_of
from app.studies.experiment_file import EveryRunClaim
from app.studies.experiment_reader import experiment_names, read_experiment, read_file
from app.studies.experiment_runner import MeasuredCase, fingerprint, run_experiment
from app.studies.figures.gathering import GatheringSettings, edges_of, faces_of, groups_of
from app.studies.judge.verdict import verdicts_on
from app.studies.reports.report_formats import show
from app.studies.runs.store_reader import StoreReader
from worlds.input_error import InputError

TEXT = """
kind = "gathering"
title = "Small gathering"
source = "these tests"
picture = "crashes"
runs = 3
report = ["at_0", "early", "late", "groups", "one", "largest", "p"]

[settings]
world = "thesis-sky"
looks = [1, 20, 60]
late = 15

[[rows]]
label = "literal"
model = "thesis"
agents = 30
published.at_0.values = [5.0, 7.0]
remark = "said once"

[[rows]]
label = "solid"
model = "thesis"
agents = 30
parameters = { contact = "always", d_0 = 0.0, body = 1.5 }
"""


def small(folder, text=TEXT):
    """The small experiment, read from a file."""
    path = folder / "small.toml"
    path.write_text(text)
    return read_file(path)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The small experiment carried out, and its folder."""
    folder = tmp_path_factory.mktemp("gathering")
    experiment = small(folder)
    made = run_experiment(
        experiment, folder, runs=3, seed=1, workers=2, tell=None, at=lambda *_: None
    )
    return experiment, made, folder


def test_a_row_is_a_run_with_several_looks(done):
    experiment, made, folder = done
    assert [(case.label, case.tick, case.last) for case in experiment.cases] == [
        (label, tick, tick == 60) for label in ("literal", "solid") for tick in (1, 20, 60)
    ]
    assert experiment.paths == [[0, 1, 2], [3, 4, 5]]
    assert made.made == 2 * 3
    assert StoreReader(folder).counts["ok"] == 2 * 3 * 3


def test_its_numbers_are_those_of_the_flock(done):
    _, made, _ = done
    for one in made.measured:
        for k, seed in enumerate((1, 2, 3)):
            flock = flock_of(one.case, seed)
            flock.run(one.case.tick)
            when = flock.crashes.tick
            counts = {"at_0": when == 0, "early": (when > 0) & (when <= 15), "late": when > 15}
            for name, there in counts.items():
                assert one.values[name][k] == there.sum()
            assert one.values["groups"][k] == flock.observe("groups"), "d_a is the reach"
            assert one.values["p"][k] == pytest.approx(flock.observe("polarisation"))
            assert one.values["one"][k] == 100 * (flock.observe("groups") == 1)
    total = [sum(made.measured[5].values[name]) for name in ("early", "late")]
    assert min(total) > 0, "the solid bodies here do crash, early and late"


def test_groups_are_of_those_that_fly_and_nearer_than_d_a():
    at = [[1.0, 1, 1], [1.2, 1, 1], [12.0, 1, 1], [14.9, 1, 1], [23.5, 1, 5.0]]
    start = {"position": np.array(at), "heading": np.array([[0.0, 1.0, 0.0]] * 5)}
    flock = Flock("thesis", start=start, rng=1, d_0=0.0, v0=0.0, d_a=3.0, d_o=1.5)
    settings = GatheringSettings(world="thesis-sky", looks=[1])
    assert groups_of(flock).max() == 2, "0 and 1 in one group, 2 and 3 in one, 4 alone"
    found = settings.run(flock, lambda: None)
    assert found["at_0"] == 2, "0 and 1 are nearer than their bodies are wide"
    assert (found["groups"], found["one"]) == (2, 0)
    assert found["largest"] == pytest.approx(200.0 / 3.0)
    wide = Flock("thesis", start=start, rng=1, d_0=0.0, v0=0.0, d_a=5.0)
    assert len(set(groups_of(wide))) == 2, "4 and 0 see each other across the seam"


def test_a_flock_of_which_nobody_flies_has_no_group():
    start = {"position": [[5.0, 5, 5], [5.2, 5, 5]], "heading": [[1.0, 0, 0]] * 2}
    flock = Flock("thesis", start=start, rng=1)
    found = GatheringSettings(world="thesis-sky", looks=[3]).run(flock, lambda: None)
    assert found["at_0"] == 2
    assert (found["groups"], found["one"], found["largest"], found["p"]) == (0, 0, None, None)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("looks = [1, 20, 60]", "looks = []", "settings.looks"),
        ("looks = [1, 20, 60]", "looks = [0, 20]", "above 0 and rise"),
        ("looks = [1, 20, 60]", "looks = [20, 20]", "above 0 and rise"),
        ("late = 15", "late = -1", "settings.late"),
        ("late = 15", 'late = 15\nwords = { a = "b" }', "words need ticks"),
        ("values = [5.0, 7.0]", "values = [5.0]\npublished.at_0.mean = 6.0", "already give"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path, before, after, words):
    with pytest.raises(InputError, match=words):
        small(tmp_path, TEXT.replace(before, after, 1))


def test_printed_runs_are_compared_with_their_own_spread(done):
    experiment, made, _ = done
    rows = verdicts_on(verdicts(experiment, made.measured), "at_0")
    assert [row.published is not None for row in rows] == [False, False, True, *[False] * 3]
    values = np.array(rows[2].values, float)
    theirs = max(2.0, values.var(ddof=1))  # two runs say little of their spread
    expected = (values.mean() - 6.0) / math.sqrt(values.var(ddof=1) / 3 + theirs / 2)
    assert rows[2].comparison.z == pytest.approx(expected)
    assert rows[2].as_row()["published_mean"] == 6.0


def test_the_table_has_a_line_for_each_look_within_80_columns(done):
    experiment, made, _ = done
    paper = io.StringIO()
    show(Console(file=paper, width=80), experiment, verdicts(experiment, made.measured), [])
    text = paper.getvalue()
    assert "…" not in text
    assert text.count("said once") == 1
    assert text.count("published  ") == 1
    lines = [line.split() for line in text.splitlines() if line.split()]
    assert [line[0] for line in lines if line[0] in ("20", "60")] == ["20", "60"] * 2
    assert [line[1] for line in lines if line[0] == "30"] == ["literal", "solid"]
    assert "own spread" in " ".join(text.split())
    assert "bootstrap" not in text


def share(done, values, said):
    """A claim about made-up numbers of the last look of the first row."""
    experiment = done[0]
    names = [one.name for one in GatheringSettings.measures]
    measured = [
        MeasuredCase(case, dict.fromkeys(names, values if case.tick == 60 else [7, 7, 7, 7]))
        for case in experiment.cases[:3]
    ]
    part = replace(experiment, cases=experiment.cases[:3])
    [claim] = claims(verdicts(part, measured), [said])
    return claim


def test_a_claim_about_a_share_of_the_runs_at_a_tick(done):
    said = EveryRunClaim(says="every", measure="late", tick=60, at_most=0.0, share=0.75)
    assert share(done, [0] * 90 + [4] * 10, said).word == "holds"
    assert share(done, [0] * 50 + [3] * 50, said).word == "does not hold"
    assert share(done, [0, 0, 3, 4], said).word == "undecided"
    text = share(done, [0, 0, 3, 4], said).text
    assert "late at most 0 agents at tick 60 in 75% of the runs or more" in text
    assert "in 4 runs, 2 not; at 99 % in 2.9% of all or more" in text
    whole = said.model_copy(update={"share": 1.0})
    assert share(done, [0, 0, 0, 4], whole).word == "does not hold"
    assert share(done, [0] * 50, whole).word == "holds"
    there = done[0].cases[0].agents
    assert share(done, [0] * 50, whole.model_copy(update={"agents": [there]})).word == "holds"
    with pytest.raises(ValueError, match="not enough values"):  # no claim of a size that is not run
        share(done, [0] * 50, whole.model_copy(update={"agents": [there + 1]}))
    at_any = whole.model_copy(update={"tick": None})
    assert share(done, [0] * 50, at_any).word == "does not hold"


def test_a_claim_that_cannot_fail_says_so(done):
    said = EveryRunClaim(says="every", measure="late", tick=60, at_most=0.0, by_construction="why")
    found = share(done, [0] * 4, said)
    assert (found.word, found.by_construction) == ("by construction", "why")
    assert share(done, [0, 1], said).word == "does not hold"


def test_the_boxes_of_a_picture():
    low, size = np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0])
    edges = edges_of(low, size)
    assert len(edges) == 12
    assert sum(np.linalg.norm(b - a) for a, b in edges) == 4 * (4.0 + 5.0 + 6.0)
    faces = faces_of(low, size)
    assert len(faces) == 6
    assert (faces[0][:, 2] == 3.0).all(), "the floor comes first"
    for face in faces:
        assert (face.min(axis=0) >= low).all()
        assert (face.max(axis=0) <= low + size).all()
        sides = np.diff(np.vstack([face, face[:1]]), axis=0)
        assert (np.count_nonzero(sides, axis=1) == 1).all(), "one axis at a time, round the face"


def test_what_the_thesis_prints():
    printed = {
        name: {
            case.label: case.published("at_0").values
            for case in read_experiment(name).cases
            if case.published("at_0")
        }
        for name in ("thesis-table5.1", "thesis-table5.2")
    }
    assert printed == {
        "thesis-table5.1": {"thesis": [10, 7, 7, 5, 4]},
        "thesis-table5.2": {"thesis": [6, 8, 4, 6, 2]},
    }
    assert {"thesis-fig3.7", "thesis-fig5.4", "thesis-fig5.7"} <= set(experiment_names())


def test_a_row_may_have_its_own_box_and_activation(tmp_path):
    """Agents that act in turn are another run, and are kept as one."""
    text = TEXT.replace('label = "solid"', 'label = "solid"\nsize = 30.0\nactivation = "random"')
    experiment = small(tmp_path, text)
    first, last = experiment.cases[0], experiment.cases[-1]
    flocks = [flock_of(case, 1) for case in (first, last)]
    assert [flock.world.size for flock in flocks] == [(24.0,) * 3, (30.0,) * 3]
    assert [flock.spec.activation for flock in flocks] == ["synchronous", "random"]
    turns = replace(first, spec=first.spec.but(activation="random"))
    assert fingerprint(turns, experiment.settings) != fingerprint(first, experiment.settings)


def test_words_that_are_only_shown_make_no_other_run(tmp_path):
    spoken = small(tmp_path, TEXT.replace("late = 15", 'late = 15\nwords = { 20 = "few" }'))
    silent = small(tmp_path)
    prints = [fingerprint(one.cases[0], one.settings) for one in (spoken, silent)]
    assert prints[0] == prints[1]
    later = fingerprint(silent.cases[1], silent.settings)
    assert later != prints[1], "each look has its own line in the store"
