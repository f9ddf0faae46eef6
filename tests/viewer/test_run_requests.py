"""What the rows of runs ask for by HTTP, as strangers may ask for it too."""

from __future__ import annotations

import pytest

from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels import runs_panel
from app.viewer.lab.runs_file import read_runs, runs_as_bytes
from app.viewer.run.run_preset import preset_spec
from tests.viewer.http_client import ask
from tests.viewer.test_kept_runs import kept, read
from tests.viewer.waiting import until

OPENS = {"X-Flockscope": "scene"}


@pytest.fixture(scope="module")
def laboratory():
    made = Laboratory(preset_spec("vem", agents=20, seed=2), port=0, running=False)
    made.open(read_runs("runs.jsonl", runs_as_bytes(kept(read(seed=7), read(seed=8)).rows)))
    assert made.simulation.ready.wait(60)
    yield made
    made.close()


@pytest.mark.parametrize("act", ["show", "name", "delete", "open"])
def test_a_foreign_page_changes_no_run(laboratory, act):
    before = laboratory.plots.runs.rows
    assert ask(laboratory.port, f"/runs/{act}?run=1&to=on").status == 403
    assert laboratory.plots.runs.rows == before


@pytest.mark.parametrize("run", ["", "0", "99", "-1", "1.5", "x", "9" * 40, "%00"])
@pytest.mark.parametrize("act", ["show", "name", "delete", "open"])
def test_a_run_that_is_not_there_is_refused_in_a_line(laboratory, act, run):
    answer = ask(laboratory.port, f"/runs/{act}?run={run}&to=on", OPENS)
    assert answer.status == 400
    assert "\n" not in answer.text.strip()


def test_a_run_is_shown_named_and_opened_from_its_start(laboratory):
    assert ask(laboratory.port, "/runs/show?run=1&to=on", OPENS).status == 200
    assert laboratory.plots.runs.find(1).is_shown
    assert ask(laboratory.port, "/runs/name?run=1&to=first", OPENS).status == 200
    assert laboratory.plots.runs.find(1).name == "first"
    assert ask(laboratory.port, f"/runs/name?run=1&to={61 * 'x'}", OPENS).status == 400
    assert ask(laboratory.port, "/runs/open?run=1", OPENS).status == 200
    until(lambda: laboratory.simulation.state.spec.seed == 7)
    until(lambda: not laboratory.simulation.state.busy)


def test_runs_of_a_file_are_added_with_numbers_of_their_own(laboratory):
    runs = laboratory.plots.runs
    before = len(runs.rows)
    laboratory.open(read_runs("runs.jsonl", runs_as_bytes(kept(read(seed=9)).rows)))
    assert len(runs.rows) == before + 1
    assert runs.rows[0].number > max(run.number for run in runs.rows[1:])


def test_of_many_runs_the_latest_and_those_that_are_ticked_are_rows(laboratory, monkeypatch):
    monkeypatch.setattr(runs_panel, "LISTED", 2)
    runs, panel = laboratory.plots.runs, laboratory.runs
    laboratory.open(read_runs("runs.jsonl", runs_as_bytes(kept(read(seed=20), read(seed=21)).rows)))
    assert len(runs.rows) > 3
    oldest = runs.rows[-1].number
    runs.show(oldest, True)
    laboratory.drawing.show_to_newcomer()
    # The run that is open becomes a row once it is begun anew, perhaps only now.
    until(lambda: f"{len(runs.rows) - 3} older run" in panel.list.content)
    assert panel.list.content.count('role="checkbox"') == 3
    assert f'data-run="{oldest}"' in panel.list.content
