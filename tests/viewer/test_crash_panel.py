"""Crashes as the monitors tell them."""

from __future__ import annotations

import numpy as np
import pytest

from agents.state.agent_rows import Crashes
from app.viewer.lab.panels.flock_monitors import LATEST, crash_counts, crash_table


def crashes_at(*ticks: int) -> Crashes:
    n = len(ticks)
    return Crashes(
        np.array(ticks, int),
        np.arange(11, 11 + n),
        np.arange(n),
        np.arange(3.0 * n).reshape(n, 3),
        np.arange(n) % 2 + 1,
    )


@pytest.mark.parametrize(
    ("ticks", "text"),
    [
        ((), "Crashed <b>0</b> of 50"),
        ((0,), "Crashed <b>1</b> of 50 (1 at the start)"),
        ((0, 0, 0, 0, 0, 101, 2999), "Crashed <b>7</b> of 50 (5 at the start, 2 after tick 100)"),
        ((1, 100), "Crashed <b>2</b> of 50 (2 up to tick 100)"),
    ],
)
def test_they_are_counted_by_when_they_happened(ticks, text):
    assert crash_counts(np.array(ticks, int), 50) == text


def test_the_latest_are_listed_newest_first_with_cause_and_place():
    text = crash_table(crashes_at(0, 0, 1, 2, 3, 40), "safe")
    assert "safe" in text
    assert text.count("<tr>") == 1 + LATEST
    rows = text.split("<tr>")[2:]
    assert rows[0].startswith("<td>40</td><td>16</td><td>an obstacle or a wall</td>")
    assert "15.0, 16.0, 17.0" in rows[0]
    assert rows[1].startswith("<td>3</td><td>15</td><td>another agent</td>")
    assert rows[-1].startswith("<td>0</td><td>12</td>")
    assert crash_table(crashes_at(5)).count("<tr>") == 1 + 1
