"""Experiments about missions: runs, store, verdicts, claims, pictures."""

from dataclasses import replace

import numpy as np
import pytest

from agents.run_records import fly
from app.studies import figures
from app.studies.claims.claims import claims, verdicts
from app.studies.experiment import flock_of
from app.studies.experiment_file import EveryRunClaim, FasterClaim, OrderClaim
from app.studies.experiment_reader import experiment_names, read_experiment, read_file
from app.studies.experiment_runner import MeasuredCase, fingerprint, run_experiment
from app.studies.figures import draw
from app.studies.figures.mission import MissionSettings
from app.studies.judge.verdict import verdicts_on
from app.studies.reports.report_formats import as_value
from app.studies.reports.tables import table_of
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.sweep_table import wide_table
from experiments.test_schemes import SCHEMES
from worlds.input_error import InputError

TEXT = """
kind = "mission"
title = "Small mission"
source = "these tests"
picture = "success"
runs = 2
report = ["success", "d_obs", "d_ind"]

[settings]
world = "liu2021-mission"
limit = 150
n_counts_informed = true

[settings.parameters]
eta = 0.1

[not_compared]
d_ind = "because"

[[rows]]
label = "A"
model = "vem-a-nav"
agents = 4
published.success = { mean = 50.0, quartiles = [25.0, 50.0, 75.0] }
published.d_ind.mean = 0.2

[[rows]]
label = "H"
model = "hwvem-nav"
agents = 4
parameters = { p1 = 0.0, p2 = 100.0 }
"""


def small(folder, text=TEXT):
    """The small experiment, read from a file."""
    path = folder / "small.toml"
    path.write_text(text)
    return read_file(path)


def carry_out(experiment, folder, runs=2):
    return run_experiment(
        experiment, folder, runs=runs, seed=1, workers=2, tell=None, at=lambda *_: None
    )


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The small experiment carried out, and its folder."""
    folder = tmp_path_factory.mktemp("mission")
    experiment = small(folder)
    return experiment, carry_out(experiment, folder), folder


def test_its_numbers_are_those_of_the_flights(done):
    _, made, _ = done
    for one in made.measured:
        for k, seed in enumerate((1, 2)):
            record = fly(flock_of(one.case, seed), 150)
            assert one.values["success"][k] == 100.0 * record.success
            assert one.values["d_least"][k] == min(record.least_pair, record.least_obstacle)
            assert one.values["ticks"][k] == record.ticks == 150
            assert one.values["arrived"][k] == 0
            assert one.values["settled"][k] is one.values["through"][k] is None


def test_n_counts_the_information_agent(done):
    _, made, _ = done
    flock = flock_of(made.measured[0].case, 1)
    assert (len(flock.ids), int(flock.informed.sum())) == (4, 1)
    assert flock.world.size == (62.0, 18.0), "the layout's own box"


def test_the_store_has_a_column_for_each_measure(done):
    experiment, _, folder = done
    columns = wide_table(StoreReader(folder))
    assert len(columns["seed"]) == 4
    measures = [one.name for one in MissionSettings.measures]
    measures[measures.index("ticks")] = "ticks_measured"
    assert list(columns)[-len(measures) :] == measures
    assert set(columns["label"]) == {"A", "H"}
    again = carry_out(experiment, folder)
    assert (again.made, again.taken) == (0, 4)
    assert again.measured == done[1].measured


def test_a_store_of_another_kind_is_refused(tmp_path, done):
    (tmp_path / "runs.sqlite").write_text("model,agents,parameters,seed,fingerprint,k_con\n")
    with pytest.raises(InputError, match="is not a store of runs"):
        carry_out(done[0], tmp_path)


def test_a_verdict_for_each_row_and_measure(done):
    experiment, made, _ = done
    found = verdicts(experiment, made.measured)
    assert [(one.case.label, one.measure.name) for one in found] == [
        (label, measure) for label in "AH" for measure in ("success", "d_obs", "d_ind")
    ]
    assert found[0].comparison is not None
    assert (found[2].comparison, found[2].word, found[2].not_compared) == (None, "", "because")
    rows = as_value(experiment, found, [])["rows"]
    assert [row["published_mean"] for row in rows] == [50.0, None, 0.2, None, None, None]
    tables = table_of(found).renderables
    assert [table.row_count for table in tables] == [3, 3, 2], "rows, and what is published of one"


def test_rows_may_be_chosen_by_label(done):
    assert [case.spec.model for case in done[0].select(["H"], []).cases] == ["hwvem-nav"]


def test_a_world_without_its_obstacles_is_another_run(tmp_path):
    bare = small(tmp_path, TEXT.replace('label = "H"', 'label = "H"\nobstacles = false'))
    case, whole = bare.cases[1], small(tmp_path).cases[1]
    assert flock_of(case, 1).world.obstacles == ()
    start = [flock_of(one, 1).position.tobytes() for one in (case, whole)]
    assert start[0] == start[1]
    assert fingerprint(case, bare.settings) != fingerprint(whole, bare.settings)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("limit = 150", "limit = 0", "settings.limit"),
        ('report = ["success"', 'report = ["sucess"', "unknown measure 'sucess'"),
        ('d_ind = "because"', 'dind = "because"', "unknown measure 'dind'"),
        ("n_counts_informed = true", "hold = 5", "settings.hold"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path, before, after, words):
    with pytest.raises(InputError, match=words):
        small(tmp_path, TEXT.replace(before, after, 1))


def judged(experiment, values, said):
    """Whether what is said holds of the made-up values of a measure, one list per row."""
    measure = said.measure
    measured = [
        MeasuredCase(
            case,
            {m.name: v if m.name == measure else [0.0] * len(v) for m in MissionSettings.measures},
        )
        for case, v in zip(experiment.cases, values, strict=True)
    ]
    one = replace(experiment, measures=[MissionSettings.measure(measure)])
    return [claim.word for claim in claims(verdicts(one, measured), [said])]


def test_an_order_holds_if_every_step_rises(done):
    said = OrderClaim(says="order", measure="success", labels=["A", "H"], agents=[4, 50])
    low, high = [10.0, 20.0, 15.0] * 60, [20.0, 30.2, 25.1] * 60
    assert judged(done[0], [low, high], said) == ["holds"], "paired: by 10 in every pair"
    assert judged(done[0], [high, low], said) == ["does not hold"]
    assert judged(done[0], [low, [25.0, 12.0, 14.0] * 60], said) == ["undecided"]
    assert judged(done[0], [low[:3], high[:3]], said) == ["undecided"], "of three runs nothing"
    assert judged(done[0], [low, [None] * 180], said) == ["undecided"], "nobody knows the rest"
    gone = said.model_copy(update={"labels": ["A", "B"]})
    assert judged(done[0], [[10.0], [20.0]], gone) == []


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({"above": 0.0}, "does not hold"),
        ({"at_least": 0.0}, "holds"),
        ({"below": 2.0}, "does not hold"),
        ({"at_most": 2.0}, "holds"),
        ({"above": 0.0, "labels": ["H"]}, "holds"),
    ],
)
def test_bounds_of_every_run(done, bounds, words):
    said = EveryRunClaim(says="every", measure="d_obs", **bounds)
    assert judged(done[0], [[0.0, 1.0] * 22, [1.0, 2.0] * 22], said) == [words]


@pytest.mark.parametrize(("measure", "word"), [("d_obs", "holds"), ("success", "does not hold")])
def test_a_run_that_comes_near_nothing_is_infinitely_far(done, measure, word):
    said = EveryRunClaim(says="every", measure=measure, above=0.0)
    assert judged(done[0], [[None, 1.0] * 22, [1.0, 2.0] * 22], said) == [word]


@pytest.mark.parametrize(
    ("quick", "slow", "word"),
    [
        ([10.0, 19.0], [100.0, 100.0], "holds"),
        ([10.0, 20.0], [100.0, 100.0], "does not hold"),
        ([10.0, 19.0], [100.0, None], "holds"),
        ([10.0, None], [100.0, None], "undecided"),
        ([10.0, None], [100.0, 100.0], "does not hold"),
        ([0.0, 0.0], [0.0, 0.0], "does not hold"),
    ],
)
def test_faster_in_every_pair(done, quick, slow, word):
    said = FasterClaim(says="faster", measure="settled", label="A", than="H", by=0.8)
    assert judged(done[0], [quick * 22, slow * 22], said) == [word]


FEW = {"evaluations": 4, "population": 2, "seeds": 2, "fresh": 2}
SHORT = {
    "liu2021-fig2": ({}, []),
    "liu2021-fig3": ({}, []),
    "liu2021-fig4": ({"hold": 5, "limit": 40}, []),
    "liu2021-table2": ({}, [20]),
    "liu2021-fig7": ({"limit": 120.0}, []),
    "liu2021-fig8": ({"limit": 120.0}, []),
    "wu2023-fig3": ({"limit": 10.0}, []),
    "wu2023-fig4": ({"limit": 10.0}, []),
    "wu2023-fig5": ({"limit": 2.0}, []),
    "wu2023-fig6": ({"limit": 2.0}, []),
    "wu2023-fig7": ({"limit": 2.0}, []),
    "wu2023-fig8": ({"limit": 2.0}, []),
    "wu2023-fig9": ({"limit": 2.0}, [30]),
    "wu2023-fig10": ({}, []),
    "wu2023-plain": ({"limit": 2.0}, []),
    "wu2023-senses": ({"limit": 2.0}, []),
    "wu2023-turned": ({"limit": 2.0}, [30]),
    "wu2023-theorem1": ({"limit": 2.0}, []),
    "couzin2002-phases": ({}, []),
    "couzin2002-sorting": ({"settle": 5, "looks": 2, "every": 2}, []),
    "couzin2005-leadership": ({"lasts": 2.0, "over": 1.0}, [10, 50]),
    "thesis-table5.1": ({}, []),
    "thesis-table5.2": ({}, []),
    "thesis-fig5.3": ({}, []),
    "thesis-fig5.6": ({}, []),
    "thesis-fig5.4": ({"words": {"1": "all", "3": "few"}}, []),
    "thesis-fig5.7": ({"words": {"1": "all", "3": "few"}}, []),
    "thesis-delay": ({}, []),
    "thesis-fig3.7": ({"words": {"1": "all", "3": "few"}}, []),
    "guarded-alpha": ({"words": {"1": "all", "3": "few"}}, []),
    "formation-thesis": ({"settle": 5}, []),
    "formation-echelon": ({"settle": 5}, [20]),
    "wu2023-delay": ({"limit": 2.0}, []),
    "vicsek1995-fig2": ({"settle": 2, "looks": 2}, [40]),
    "vicsek1995-headings": ({"settle": 2, "looks": 2}, []),
    "gregoire-chate2004": ({"settle": 2, "looks": 2}, []),
    "ballerini2008": ({"settle": 2, "looks": 2}, []),
    "reynolds1987": ({"settle": 2, "looks": 2}, []),
    "vasarhelyi2018": ({"settle": 2, "looks": 2}, []),
    "cucker-smale2007": ({"lasts": 20, "looks": 2}, [2]),
    "adrian2020-bottleneck": ({"limit": 20.0}, []),
    "chen2014-predator": ({"settle": 1.0}, [100]),
    "chen2014-chase": ({"settle": 1.0, "lasts": 2.0, "last": 1.0}, []),
    "dorsogna2006": ({"lasts": 5, "looks": 2, "every": 2}, []),
    "dorsogna2006-size": ({"lasts": 5, "looks": 2, "every": 2}, []),
    "bechinger2016-msd": ({"long": 2.1}, []),
    "fily2012-speed": ({"lasts": 5, "looks": 2, "every": 2}, []),
    "attanasi2014": ({"limit": 4.0, "settle": 5}, []),
    "helbing1995-lanes": ({"settle": 5}, [20]),
    "jacobs-fig2": ({"looks": 5}, []),
    "jacobs-fig3": ({"limit": 45.0}, []),
    "jacobs-fig11": ({"limit": 12.0}, [4]),
    "jacobs-predator": ({"limit": 12.0}, []),
    "jacobs-future": ({"limit": 12.0}, []),
    "jacobs-gallery1": ({"limit": 12.0}, []),
    "jacobs-gallery2": ({"limit": 12.0}, []),
    "liu2021-weights": (FEW, []),
    "liu2021-tradeoff": (FEW, []),
}


def test_every_experiment_but_those_of_convergence_is_short_here():
    kinds = {name: read_experiment(name).settings.kind for name in experiment_names()}
    others = {name for name, kind in kinds.items() if kind != "convergence"} - set(SCHEMES)
    assert set(SHORT) == others, "schemes are drawn in test_schemes.py"
    assert set(kinds.values()) == set(figures.kinds())


@pytest.mark.parametrize("name", SHORT)
def test_the_picture_is_drawn_as_png_and_svg(name, tmp_path):
    settings, agents = SHORT[name]
    whole = read_experiment(name).select([], agents)
    experiment = replace(whole, settings=whole.settings.model_copy(update=settings))
    rng = np.random.default_rng(4)
    measured = [
        MeasuredCase(
            case, {one.name: list(rng.uniform(20, 80, 5)) for one in whole.settings.measures}
        )
        for case in experiment.cases
    ]
    made = verdicts(experiment, measured)
    files = draw(experiment, made, tmp_path, seed=2)
    assert files["png"].read_bytes()[:4] == b"\x89PNG"
    assert experiment.source in files["svg"].read_text()


def test_table_2_has_15_rows_as_printed():
    table = read_experiment("liu2021-table2")
    printed = {(case.label, case.agents): case.published("success").mean for case in table.cases}
    assert len(printed) == 15
    assert printed["HWVEM-II", 50] == 88.38
    assert printed["IVEM-A", 20] == 44.65
    made = verdicts(
        table,
        [
            MeasuredCase(c, {m.name: [50.0, 60.0] * 9 for m in MissionSettings.measures})
            for c in table.cases
        ],
    )
    assert {one.word for one in verdicts_on(made, "d_obs")} == {"differs"}
    assert {one.word for one in verdicts_on(made, "d_ind")} == {"differs"}


def test_paired_runs_start_alike():
    duel = read_experiment("wu2023-fig5")
    flocks = [flock_of(case, 7) for case in duel.cases]
    assert flocks[0].position.tobytes() == flocks[1].position.tobytes()
    assert flocks[0].speed.tobytes() == flocks[1].speed.tobytes()
