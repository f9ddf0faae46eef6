"""What an experiment leaves: table, JSON, CSV, pictures."""

import csv
import io
from dataclasses import replace

import pytest
from rich.console import Console

from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import MeasuredCase
from app.studies.figures import draw
from app.studies.reports.report_formats import as_value, show, write_summary
from app.studies.reports.tables import number
from worlds.input_error import InputError

NAMES = ("liu2021-table1", "liu2021-fig5", "liu2021-fig6")


def of_times(name):
    """An experiment of which the times alone are reported."""
    whole = read_experiment(name)
    return replace(whole, measures=[one for one in whole.measures if one.name == "k_con"])


def made_up(name):
    """An experiment with made-up times; one run is given up."""
    experiment = of_times(name)
    measured = [
        MeasuredCase(
            case, {"k_con": [None, *(int(50 + 7 * k + case.agents % 9) for k in range(9))]}
        )
        for case in experiment.cases
    ]
    return experiment, verdicts(experiment, measured)


@pytest.mark.parametrize("name", NAMES)
def test_the_table_shows_every_row_within_80_columns(name):
    experiment, made = made_up(name)
    paper = io.StringIO()
    show(Console(file=paper, width=80), experiment, made, claims(made))
    text = paper.getvalue()
    assert "…" not in text
    for one in made:
        assert one.case.spec.model in text
        assert f"≥{number(one.summary.mean)}" in text
    assert "1 of 10 runs given up at" in " ".join(text.split())
    assert "answers at 99 % each" in " ".join(text.split())
    if name == "liu2021-table1":
        assert text.count("paper  ") == 18
        assert "expected: differs" in text
        assert "the paper gives no spread" in " ".join(text.split())


@pytest.mark.parametrize("name", NAMES)
def test_the_value_for_json_has_every_row(name):
    experiment, made = made_up(name)
    value = as_value(experiment, made, claims(made))
    assert len(value["rows"]) == len(experiment.cases)
    assert all(row["absent"] == 1 and row["runs"] == 9 for row in value["rows"])
    assert "99 %" in value["notes"]["verdicts"]
    assert value["settings"]["world"] == "wrap-plain"


def test_the_summary_as_csv(tmp_path):
    _, made = made_up("liu2021-table1")
    write_summary(tmp_path / "summary.csv", made)
    with open(tmp_path / "summary.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 18
    assert float(rows[0]["published_mean"]) == 84.31
    assert float(rows[0]["mean"]) == made[0].summary.mean
    with pytest.raises(InputError, match="cannot be written"):
        write_summary(tmp_path / "no" / "summary.csv", made)


@pytest.mark.parametrize("name", NAMES)
def test_the_picture_is_drawn_as_png_and_svg(name, tmp_path):
    experiment, made = made_up(name)
    files = draw(experiment, made, tmp_path)
    assert files["png"].read_bytes()[:4] == b"\x89PNG"
    text = files["svg"].read_text()
    assert "<svg" in text
    assert experiment.source in text


def test_a_picture_without_any_run_that_converged_is_drawn(tmp_path):
    experiment = of_times("liu2021-table1")
    measured = [MeasuredCase(case, {"k_con": [None, None]}) for case in experiment.cases]
    nothing = verdicts(experiment, measured)
    assert draw(experiment, nothing, tmp_path)["png"].exists()
