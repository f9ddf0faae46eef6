"""docs/observables.md names every observable with its unit and range."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Observable

PAGE = (Path(__file__).parents[1] / "docs" / "observables.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `([\w-]+)` \| (.*?) \| (.*?) \| (.*?) \|$", PAGE, re.MULTILINE)


def test_every_observable_has_its_row_in_order():
    assert [row[:3] for row in ROWS] == [
        (one.name, one.unit, str(one.range)) for one in OBSERVABLES.values()
    ]


@pytest.mark.parametrize("name", ["susceptibility", "binder"])
def test_what_is_measured_over_a_run_says_so(name):
    assert next(row[3] for row in ROWS if row[0] == name).startswith("over a run")


def test_the_tables_are_those_with_an_arrow():
    assert {row[0] for row in ROWS if "->" in row[2]} == {
        one.name for one in OBSERVABLES.values() if one.is_table
    }


def test_a_range_is_one_of_numbers():
    with pytest.raises(TypeError, match="'heads'"):
        Observable("heads", "Agents", "agents", "[0, N]", len)
    share, table = OBSERVABLES["polarisation"].range, OBSERVABLES["group-table"].range
    assert (share.low, share.high, share.is_share) == (0.0, 1.0, True)
    assert [one.is_share for one in table.columns] == [False, True, True]


def test_observables_share_charts_with_those_that_there_are():
    besides = {one.beside for one in OBSERVABLES.values() if one.beside}
    assert besides
    assert besides <= set(OBSERVABLES)
