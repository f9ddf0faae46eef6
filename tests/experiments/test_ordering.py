"""Experiments about order: what is measured of a run, claims over noise and size, the picture."""

import io
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from agents import Flock
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_file import EqualityClaim, MeanClaim, ReachClaim, SizeClaim
from app.studies.experiment_reader import read_experiment, read_file
from app.studies.experiment_runner import MeasuredCase, run_experiment
from app.studies.figures import draw
from app.studies.figures.ordering import OrderingSettings, binder
from app.studies.reports.report_formats import show
from worlds.input_error import InputError

MEASURES = ("order", "binder", "chi")
TEXT = """
kind = "ordering"
title = "Small order"
source = "these tests"
picture = "ordering"
runs = 3
report = ["order", "binder"]

[settings]
world = "wrap"
settle = 40
looks = 10
every = 2

[sizes]
20 = 2.0
60 = 3.5

[[claims]]
says = "sizes"
measure = "order"
label = "vicsek1995"
value = 6.0
agents = [20, 60]
trend = "falls"

[[claims]]
says = "order"
measure = "order"
labels = ["thin", "dense"]

[[sweeps]]
model = "vicsek1995"
agents = [20, 60]
parameter = "eta"
values = [0.0, 6.0]
trend = "falls"

[[rows]]
model = "vicsek1995"
label = "thin"
agents = 4
size = 4.0
parameters = { eta = 2.0 }

[[rows]]
model = "vicsek1995"
label = "dense"
agents = 60
size = 4.0
parameters = { eta = 2.0 }
"""


def small(folder, text=TEXT):
    """The small experiment, read from a file."""
    path = folder / "small.toml"
    path.write_text(text)
    return read_file(path)


def test_binders_cumulant_of_known_distributions():
    rng = np.random.default_rng(1)
    assert binder(np.full(10, 0.3)) == pytest.approx(2 / 3)
    assert binder(np.zeros(10)) == 0.0
    rayleigh = np.linalg.norm(rng.normal(size=(200_000, 2)), axis=1)
    assert binder(rayleigh) == pytest.approx(1 / 3, abs=0.01)
    # ordered for a share f of the time: 1 - 1 / (3 f)
    for f, expected in ((1.0, 2 / 3), (0.5, 1 / 3), (0.1, -7 / 3)):
        switching = np.where(np.arange(1000) < 1000 * f, 0.9, 0.0)
        assert binder(switching) == pytest.approx(expected)


def test_a_run_is_looked_at_as_the_settings_say():
    settings = OrderingSettings(world="wrap", settle=7, looks=3, every=2)
    flock, again = (Flock("vicsek1995", agents=30, eta=3.0, rng=4) for _ in range(2))
    found = settings.run(flock, lambda: None)
    assert flock.tick == 13 == settings.ticks(None, 1.0)
    again.run(7)
    seen = []
    for _ in range(3):
        again.run(2)
        seen.append(again.observe("polarisation"))
    assert found["order"] == pytest.approx(np.mean(seen))
    assert found["chi"] == pytest.approx(30 * np.var(seen))
    assert found["binder"] == pytest.approx(
        1 - np.mean(np.power(seen, 4)) / 3 / np.mean(np.square(seen)) ** 2
    )


def test_a_small_one_is_carried_out_judged_and_drawn(tmp_path):
    experiment = small(tmp_path)
    done = run_experiment(
        experiment, tmp_path, runs=8, seed=1, workers=1, tell=None, at=lambda *_: None
    )
    made = verdicts(experiment, done.measured)
    said = claims(made, experiment.said)
    assert [one.text.split(":")[0] for one in said] == [
        "N = 20, eta from 0 to 6",
        "N = 60, eta from 0 to 6",
        "vicsek1995, eta = 6",
        "order",
    ]
    assert [one.word for one in said[:2]] == ["holds", "holds"]
    paper = io.StringIO()
    show(Console(file=paper, width=80), experiment, made, said)
    text = paper.getvalue()
    assert " eta        order            G " in text
    assert "…" not in text
    files = draw(experiment, made, tmp_path)
    assert all(path.stat().st_size > 5000 for path in files.values())


def made_up(tmp_path, values, measure="order"):
    """Verdicts with values of 20 runs (N -> eta -> mean) for the sweep of the small experiment."""
    experiment = small(tmp_path)
    rng = np.random.default_rng(2)
    measured = [
        MeasuredCase(
            case,
            {
                name: list(
                    (values[case.agents, case.value] if case.sweep and name == measure else 0.5)
                    + 0.01 * rng.normal(size=20)
                )
                for name in MEASURES
            },
        )
        for case in experiment.cases
    ]
    return verdicts(experiment, measured)


def words(made, claim):
    return [one.word for one in claims(made, [claim])][-1:]


def test_what_size_does_is_judged_at_one_noise(tmp_path):
    falls = {"says": "sizes", "measure": "order", "label": "vicsek1995", "value": 6.0}
    claim = SizeClaim(agents=[20, 60], trend="falls", **falls)
    rises = SizeClaim(agents=[20, 60], trend="rises", **falls)
    means = {(20, 0.0): 1.0, (60, 0.0): 1.0, (20, 6.0): 0.3, (60, 6.0): 0.2}
    made = made_up(tmp_path, means)
    assert words(made, claim) == ["holds"]
    assert words(made, rises) == ["does not hold"]
    assert words(made_up(tmp_path, means | {(60, 6.0): 0.3}), claim) == ["undecided"]
    assert len(claims(made, [claim.model_copy(update={"agents": [20, 61]})])) == len(claims(made))
    fifth = claim.model_copy(update={"by": 0.2})
    assert words(made, fifth) == ["holds"], "it is a third less"
    assert words(made, claim.model_copy(update={"by": 0.5})) == ["does not hold"]
    assert "falls with N by 20% or more: 0.3" in claims(made, [fifth])[-1].text


def test_what_comes_up_somewhere_or_nowhere(tmp_path):
    claim = {"says": "reaches", "measure": "binder", "label": "vicsek1995", "agents": [60]}
    dips = ReachClaim(below=0.0, **claim)
    never = ReachClaim(below=0.0, nowhere=True, **claim)
    means = {(20, 0.0): -1.0, (60, 0.0): 0.6, (20, 6.0): 0.3, (60, 6.0): -0.2}
    low = made_up(tmp_path, means, "binder")
    high = made_up(tmp_path, means | {(60, 6.0): 0.2}, "binder")
    assert words(low, dips) == words(high, never) == ["holds"]
    assert words(low, never) == words(high, dips) == ["does not hold"]
    unclear = made_up(tmp_path, means | {(60, 6.0): 0.001}, "binder")
    assert words(unclear, dips) == words(unclear, never) == ["undecided"]
    assert words(high, ReachClaim(above=0.5, **claim)) == ["holds"]


def test_two_rows_are_alike_within_a_distance(tmp_path):
    experiment = small(tmp_path)
    rng = np.random.default_rng(3)
    for apart, word in ((0.0, "holds"), (0.2, "does not hold"), (0.05, "undecided")):
        shift = {"thin": 0.0, "dense": apart}
        measured = []
        for case in experiment.cases:
            values = 0.5 + shift.get(case.label, 0.0) + 0.02 * rng.normal(size=20)
            measured.append(MeasuredCase(case, {name: list(values) for name in MEASURES}))
        claim = EqualityClaim(says="alike", measure="order", labels=("thin", "dense"), within=0.05)
        assert words(verdicts(experiment, measured), claim) == [word]


def test_the_means_of_rows_are_beyond_a_bound(tmp_path):
    experiment = small(tmp_path)
    rng = np.random.default_rng(3)
    for mean, word in ((0.3, "holds"), (-0.3, "does not hold"), (0.001, "undecided")):
        measured = [
            MeasuredCase(case, {name: list(mean + 0.1 * rng.normal(size=20)) for name in MEASURES})
            for case in experiment.cases
        ]
        made = verdicts(experiment, measured)
        claim = MeanClaim(says="mean", measure="order", labels=["thin", "dense"], above=0.0)
        told = claims(made, [claim])[-2:]
        assert [one.word for one in told] == [word, word]
        assert "mean order above 0; it is" in told[0].text
        below = MeanClaim(says="mean", measure="order", labels=["thin"], below=0.0)
        opposite = {"holds": "does not hold", "does not hold": "holds"}
        assert words(made, below) == [opposite.get(word, word)]


def test_a_claim_needs_one_bound(tmp_path):
    bare = '[[claims]]\nsays = "reaches"\nmeasure = "order"\nlabel = "vicsek1995"\nagents = [20]\n'
    text = TEXT.replace("[[sweeps]]", f"{bare}\n[[sweeps]]")
    assert text != TEXT
    with pytest.raises(InputError, match="either above or below is needed"):
        small(tmp_path, text)


def test_rows_of_one_density_are_drawn_as_boxes(tmp_path):
    experiment = read_experiment("vicsek1995-headings")
    made = [
        MeasuredCase(case, {name: [0.2, 0.3, 0.25] for name in MEASURES})
        for case in experiment.cases
    ]
    experiment = replace(experiment, runs=3)
    files = draw(experiment, verdicts(experiment, made), tmp_path)
    assert "vicsek1995" in files["svg"].read_text()
