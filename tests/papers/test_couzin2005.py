"""Couzin et al. 2005 in small: informed agents lead, and two opinions are averaged or chosen of."""

import numpy as np
import pytest

from agents import Flock
from agents.individuals import each, one_of
from app.studies.experiment import flock_of
from app.studies.experiment_reader import read_experiment, read_file
from app.studies.figures.leading import LeadingSettings, preferred_directions
from papers.flying import borne_out, flown, values
from worlds.input_error import InputError


def test_large_groups_follow_and_two_opinions_are_averaged_when_they_are_near(tmp_path):
    experiment, made = flown("couzin2005-leadership", tmp_path, 12, agents=[10, 50, 100])
    assert borne_out(experiment, made)
    cosine = {key: np.mean(of) for key, of in values(made, "accuracy").items()}
    assert cosine["a fifth informed", 100] > 0.7
    assert cosine["80 deg apart", 50] > 0.9
    angle = {label: np.mean(of) for (label, _), of in values(made, "apart").items()}
    assert angle["80 deg apart"] < 20.0 < angle["160 deg apart"]


def test_n_counts_agents_of_all_kinds():
    experiment = read_experiment("couzin2005-leadership")
    assert {case.spec.count == case.agents for case in experiment.cases} == {True}


def flock_with(**words):
    return Flock("leadership", agents=4, rng=1, **words)


def test_the_middle_of_two_directions_and_of_one():
    two = flock_with(omega=each([0.5, 0.5, 0.0, 0.5]), g=each([350.0, 70.0, 200.0, 70.0]))
    middle, half = preferred_directions(two)
    angle = np.radians(30.0)
    assert middle == pytest.approx([np.cos(angle), np.sin(angle)])
    assert half == pytest.approx(40.0)
    middle, half = preferred_directions(flock_with(omega=one_of(0.5, 1.0), g=90.0))
    assert middle == pytest.approx([0.0, 1.0], abs=1e-12)
    assert half == 0.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({}, "0 preferred directions"),
        ({"omega": 0.5, "g": each([0.0, 10.0, 20.0, 20.0])}, "3 preferred directions"),
        ({"omega": 0.5, "g": each([0.0, 180.0, 0.0, 0.0])}, "g = 0 and 180 deg are opposite"),
    ],
)
def test_no_direction_and_too_many_are_refused(words, message):
    settings = LeadingSettings(world="open", lasts=2.0, over=1.0)
    with pytest.raises(InputError, match=message):
        settings.run(flock_with(**words), lambda: None)


ROW = """
kind = "leading"
title = "Kinds"
source = "these tests"
picture = "leading"
runs = 1

[settings]
world = "open"
lasts = 2.0
over = 1.0
n_counts_informed = true

[[rows]]
model = "leadership"
agents = 5
size = 4.0
kinds = [{ name = "informed", agents = 2, parameters = { omega = 0.5 } }]
"""


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("agents = 2", "agents = 5", "agents = 5, but 5 of them are"),
        ("omega = 0.5", "omega = 99", "omega = 99"),
        ('name = "informed"', 'nom = "informed"', "unknown key of a kind 'nom'"),
        ("kinds = [", 'to = { sharks = "own" }\nkinds = [', "unknown kind 'sharks'"),
    ],
)
def test_a_row_with_wrong_kinds_is_refused_with_its_file(tmp_path, before, after, message):
    path = tmp_path / "kinds.toml"
    path.write_text(ROW)
    assert read_file(path).cases[0].spec.agents == 3
    assert before in ROW
    path.write_text(ROW.replace(before, after))
    with pytest.raises(InputError, match=message) as refusal:
        flock_of(read_file(path).cases[0], 1)
    assert "\n" not in str(refusal.value)
