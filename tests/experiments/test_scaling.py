"""Finite-size scaling: lines that are made to cross, and to fall on one, do so."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from app.studies.charts.run_group import CellRuns
from app.studies.charts.scaling import Scaling, crossing_of, draw_collapse, group_by_size
from worlds.input_error import InputError

BETA, NU, CRITICAL = 0.45, 1.6, 4.3
SIZES = {100: 5.0, 400: 10.0, 1600: 20.0}


def sweep(value):
    """A store and cells in which an observable is a function of eta and the side."""
    groups, cells = [], {}
    for agents, side in SIZES.items():
        for eta in np.linspace(3.0, 5.0, 11).tolist():
            number = len(groups)
            exact = value(eta, side)
            groups.append(CellRuns({"agents": agents, "eta": eta}, number, [exact, exact]))
            cells[number] = {"identity": {"spec": {"size": [side, side]}}}
    return SimpleNamespace(cells=cells), groups


def scaled(eta, side):
    """An order parameter that scales exactly."""
    return side ** (-BETA / NU) / (1.0 + math.exp((eta - CRITICAL) * side ** (1.0 / NU)))


def test_lines_of_all_sizes_fall_on_one_with_the_exponents_they_were_made_with():
    from matplotlib.figure import Figure  # half a second, which collecting need not take

    lines = group_by_size(*sweep(scaled), "eta")
    assert {agents: side for agents, (side, _) in lines.items()} == SIZES
    panel = Figure().subplots()
    draw_collapse(panel, lines, "eta", Scaling(BETA, NU), CRITICAL)
    drawn = [container[0].get_xydata() for container in panel.containers]
    assert len(drawn) == len(SIZES)
    for points in drawn:
        assert points[:, 1] == pytest.approx(1.0 / (1.0 + np.exp(points[:, 0])))


def test_cumulants_cross_where_they_were_made_to():
    lines = group_by_size(*sweep(lambda eta, side: 0.5 - 0.1 * (eta - 4.27) * side), "eta")
    assert crossing_of(lines, "eta") == pytest.approx(4.27)


@pytest.mark.parametrize(
    "value",
    [lambda eta, side: 0.1 * eta - 0.01 * side, lambda eta, side: math.sin(9.0 * eta) * side],
)
def test_lines_that_do_not_cross_exactly_once_have_no_crossing(value):
    assert crossing_of(group_by_size(*sweep(value), "eta"), "eta") is None


def test_what_does_not_scale_is_refused():
    kept, groups = sweep(scaled)
    with pytest.raises(InputError, match="scaling needs the axis 'agents'"):
        group_by_size(kept, [one for one in groups if one.axes["agents"] == 100], "eta")
    for number, one in enumerate(groups):
        one.axes["v0"] = number % 2
    with pytest.raises(InputError, match=r"^v0 varies too: say at which value"):
        group_by_size(kept, groups, "eta")
    with pytest.raises(InputError, match=r"^nu = 0 is not above 0$"):
        Scaling(0.5, 0.0)
