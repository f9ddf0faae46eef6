"""Helbing and Molnar 1995 in small: lanes of people who walk both ways."""

import numpy as np

from papers.flying import borne_out, flown, values

RUNS = 3


def test_people_form_lanes_if_they_mind_each_other(tmp_path):
    experiment, made = flown("helbing1995-lanes", tmp_path, RUNS, [60])
    assert borne_out(experiment, made)
    gain = {label: one for (label, _), one in values(made, "gain").items()}
    assert min(gain["social forces"]) > 0.08
    assert max(np.abs(gain["no repulsion"])) < 0.12, "chance, and no more"
    assert min(gain["equal speeds"]) > 0.5
    progress = values(made, "progress")["equal speeds", 60]
    assert all(97.0 < one <= 101.0 for one in progress)
