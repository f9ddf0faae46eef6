"""docs/observables.md names every observable with its unit and range."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from agents.observables.catalogue import OBSERVABLES

PAGE = (Path(__file__).parents[1] / "docs" / "observables.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `([\w-]+)` \| (.*?) \| (.*?) \| (.*?) \|$", PAGE, re.MULTILINE)


def test_every_observable_has_its_row_in_order():
    assert [row[:3] for row in ROWS] == [
        (one.name, one.unit, one.range) for one in OBSERVABLES.values()
    ]


@pytest.mark.parametrize("name", ["susceptibility", "binder"])
def test_what_is_measured_over_a_run_says_so(name):
    assert next(row[3] for row in ROWS if row[0] == name).startswith("over a run")


def test_the_tables_are_those_with_an_arrow():
    assert {row[0] for row in ROWS if "->" in row[2]} == {
        one.name for one in OBSERVABLES.values() if one.is_table
    }
