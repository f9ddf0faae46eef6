"""Snapshots: a flock frozen at a tick."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from agents import Flock
from agents.observables.array_checks import OmittedRowsWarning
from agents.observables.catalogue import OBSERVABLES
from agents.recordings.recorder import Recorder
from agents.recordings.recording import Recording
from worlds.input_error import InputError


def test_a_snapshot_stays_and_shares_nothing_with_the_flock():
    flock = Flock("hwvem", agents=30, rng=4, eta=1.0)
    now = flock.snapshot()
    before = [array.copy() for array in now.arrays]
    assert not any(
        np.shares_memory(one, other) for one, other in zip(now.arrays, flock.arrays, strict=True)
    )
    flock.run(5)
    assert now.tick == 0
    assert all(np.array_equal(a, b) for a, b in zip(before, now.arrays, strict=True))


def test_links_groups_and_layers_are_found_once_and_are_those_of_the_flock():
    flock = Flock("hwvem", agents=40, rng=4)
    now = flock.snapshot()
    for name in ("links", "group_labels", "layers"):
        found = getattr(now, name)()
        assert found is getattr(now, name)()
        assert np.array_equal(found, getattr(flock, name)())


def test_a_snapshot_of_some_agents_is_as_if_there_were_no_others():
    flock = Flock("vem", agents=3, rng=1, size=10.0, start=None)
    flock.position[:] = [[1.0, 1.0], [1.8, 1.0], [2.6, 1.0]]
    now = flock.snapshot()
    assert now.links().tolist() == [[0, 1], [1, 2]]
    ends = now.of(np.array([0, 2]))
    assert ends.links().tolist() == []
    assert ends.group_labels().tolist() == [0, 1]
    assert ends.ids.tolist() == flock.ids[[0, 2]].tolist()
    assert ends.dt == now.dt


def test_those_that_have_crashed_are_not_measured_but_known():
    flock = Flock("thesis", agents=6, rng=2)
    flock.arrays.crash_record[4] = (0.0, 1.0, *flock.position[4])
    seen = flock.snapshot().measurable()
    assert seen.ids.tolist() == np.delete(flock.ids, 4).tolist()
    assert seen.active.all()
    assert seen.crashes.id.tolist() == [flock.ids[4]]
    assert OBSERVABLES["crashes"].measure(seen) == 1


def test_agents_that_are_no_numbers_are_left_out_with_a_warning():
    flock = Flock("vem", agents=5, rng=2)
    flock.heading[2] = np.nan
    with pytest.warns(OmittedRowsWarning, match="1"):
        assert flock.snapshot().measurable().ids.tolist() == np.delete(flock.ids, 2).tolist()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(Flock("vem", agents=5, rng=2).snapshot().measurable().ids) == 5


def test_signals_are_in_a_snapshot_that_was_taken_with_them():
    flock = Flock("hwvem", agents=20, rng=3)
    flock.run(2)
    with pytest.raises(InputError, match="layer is not in this snapshot"):
        flock.snapshot().signal("layer")
    with pytest.raises(InputError, match="unknown signal"):
        flock.snapshot().signal("mood")
    assert np.array_equal(flock.snapshot(signals=True).signal("layer"), flock.signal("layer"))


def test_a_recording_is_read_as_snapshots_that_can_be_measured(tmp_path):
    flock = Flock("hwvem", agents=20, rng=3)
    path, seen = tmp_path / "run.parquet", []
    with Recorder(path, flock) as recorder:
        for _ in range(3):
            flock.run(1)
            recorder.write()
            seen.append((flock.position.copy(), flock.observe("polarisation")))
    for tick, (position, order) in enumerate(seen, 1):
        found = Recording(path)
        now = found.state(tick)
        assert (found.spec, now.tick, now.world) == (flock.spec, tick, flock.world)
        assert np.array_equal(now.position, position)
        assert OBSERVABLES["polarisation"].measure(now.measurable()) == order
