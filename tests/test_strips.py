"""A flock in strips has the bits of one process, on any number of ranks; or it is refused."""

from __future__ import annotations

import asyncio
import os
import pickle
import signal
import threading
import weakref

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.catalogue import MODELS
from agents.engine.runner import NotANumber
from agents.strips import strip_engine
from agents.strips.strip_rank import StripColumns, StripRank
from worlds.input_error import InputError


class RanksOfOneLoop:
    """Ranks in this process: they speak as Dask's actors do, without Dask."""

    def __init__(self, number):
        self.number, self.stopped = number, 0
        self.loop = asyncio.new_event_loop()
        weakref.finalize(self, self.loop.close)

    def place_ranks(self, build, kind, place):
        ranks = [StripRank(rank, build, kind, place) for rank in range(self.number)]
        self.call_all(ranks, [("meet", ranks)] * self.number)
        return ranks

    def call_all(self, ranks, calls):
        async def answers():
            named = zip(ranks, calls, strict=True)
            return await asyncio.gather(
                *(getattr(rank, name)(*rest) for rank, (name, *rest) in named)
            )

        return self.loop.run_until_complete(answers())

    def stop(self, ranks):
        self.call_all(ranks, [("stop",)] * len(ranks))
        self.stopped += 1


def in_strips(model, ranks, **options):
    flock = Flock(model, ranks=ranks if ranks > 1 else 2, rng=5, **options)
    flock.processes = RanksOfOneLoop(ranks)
    return flock


def is_alike(flock, other):
    pairs = zip(flock.arrays, other.arrays, strict=True)
    return flock.tick == other.tick and all(np.array_equal(a, b, equal_nan=True) for a, b in pairs)


FAST = {"v0": 0.3, "eta": 0.7}
CASES = [
    ("vem", {"agents": 400, "size": 10.0, **FAST}),
    ("vem", {"agents": 40, "size": 2.5, **FAST}),
    ("vem", {"agents": 60, "size": 40.0, **FAST}),
    ("vem", {"agents": 300, "dim": 3, "size": 5.0, **FAST}),
    ("vem", {"agents": 200, "world": "obstacles", **FAST}),
    ("vem", {"agents": 200, "size": 8.0, "world": "open", **FAST}),
    ("vem", {"agents": 200, "size": 8.0, "world": "wrap-plain", **FAST}),
    ("vem", {"agents": 200, "size": 8.0, "wind": 0.2, "gusts": 0.1, **FAST}),
    ("vem-a", {"agents": 100, "informed": 3, **FAST}),
    ("ivem", {"agents": 300, "size": 9.0, **FAST}),
    ("inertial-spin", {"agents": 300, "size": 9.0, "T": 0.5}),
    ("boundary-points", {}),
]


@pytest.mark.parametrize("ranks", [1, 2, 3, 7])
@pytest.mark.parametrize(("model", "options"), CASES)
def test_strips_have_the_bits_of_one_process(model, options, ranks):
    one, many = Flock(model, rng=5, **options), in_strips(model, ranks, **options)
    assert is_alike(one, many)
    for ticks in (1, 2, 47):
        one.run(ticks)
        many.run(ticks)
        assert is_alike(one, many)


def test_agents_cross_strips_and_the_seam_and_several_ticks_run_together():
    options = {"agents": 900, "size": 15.0, **FAST}
    one, flock = Flock("vem", rng=5, **options), in_strips("vem", 3, **options)
    begin = flock.position[:, 0].copy()
    one.run(50)
    flock.run(50)
    assert 1 < flock.engine.ticks_together(flock.context) < 50
    assert is_alike(one, flock)
    strips = np.quantile(begin, [1 / 3, 2 / 3])
    before, after = (np.searchsorted(strips, x) for x in (begin, flock.position[:, 0]))
    assert {(0, 1), (1, 2), (2, 0), (0, 2)} <= set(
        zip(before.tolist(), after.tolist(), strict=True)
    )


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 1000),
    ranks=st.integers(1, 5),
    world=st.sampled_from(["wrap", "wrap-plain", "open"]),
    side=st.floats(0.5, 12.0),
    v0=st.floats(0.0, 1.0),
    exchange=st.floats(0.0, 50.0),
)
def test_any_crowd_in_any_strips(seed, ranks, world, side, v0, exchange):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 60))
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    position = rng.uniform(0.0, side, (n, 2))
    position[: n // 3, 0] = position[0, 0]  # a column of agents: strips without any
    start = {"position": position, "heading": np.column_stack([np.cos(angle), np.sin(angle)])}
    options = {"start": start, "size": side, "world": world, "v0": v0, "eta": 0.5}
    one, many = Flock("vem", rng=5, **options), in_strips("vem", ranks, **options)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(strip_engine, "EXCHANGE", exchange)
        one.run(12)
        many.run(12)
    assert is_alike(one, many)


def test_positions_outside_the_box_and_parameters_that_change():
    one, many = (
        Flock("vem", agents=200, size=7.0, rng=5),
        in_strips("vem", 3, agents=200, size=7.0),
    )
    for flock in (one, many):
        flock.run(5)
        flock.position[:50] += [7.0, -14.0]
        flock.run(5)
        flock.set(v0=0.9, r=1.4)
        flock.run(20)
        flock.agents[3].step()
        flock.run(3)
    assert is_alike(one, many)


def test_traces_and_waiting_for_consistency_look_at_every_tick():
    options = {"agents": 60, "size": 4.0, "eta": 0.0}
    one, many = Flock("vem", rng=5, **options), in_strips("vem", 2, **options)
    assert np.array_equal(one.trace(4), many.trace(4))
    assert one.run_until_consistent(400) == many.run_until_consistent(400) is not None
    assert is_alike(one, many)


@pytest.mark.parametrize("world", ["wrap", "open"])
def test_a_position_that_is_no_number_is_refused_and_the_flock_goes_on(world):
    options = {"agents": 90, "size": 6.0, "world": world}
    one, many = Flock("vem", rng=5, **options), in_strips("vem", 3, **options)
    place = many.position[7].copy()
    many.position[7] = np.nan
    with pytest.raises(NotANumber, match=f"agent {many.ids[7]} has position"):
        many.run(4)
    assert (many.tick, many.processes.stopped) == (0, 1)
    many.position[7] = place
    one.run(4)
    many.run(4)
    assert is_alike(one, many)


def test_agents_that_go_farther_than_declared_are_refused():
    flock = in_strips("vem", 2, agents=200, size=10.0, v0=0.5)
    flock.engine.stride = 0.1
    with pytest.raises(InputError, match=r"an agent went .* more than 0.1 a tick"):
        flock.run(20)
    assert flock.tick == 0


@pytest.mark.parametrize(
    ("model", "options", "reason"),
    [
        ("hwvem", {}, "the rule hwvem looks at the whole flock at each tick"),
        ("topological", {}, "the nearest agents may be anywhere"),
        ("vem", {"activation": "random"}, "what others have just done"),
        ("vem", {"delay": 2.0}, "late or inexact"),
        ("vem", {"place_error": 0.1}, "late or inexact"),
        ("vem", {"threads": 2}, "each rank has one thread"),
        ("vem", {"interpret": True}, "plain Python runs in one process"),
    ],
)
def test_what_strips_cannot_do_is_refused_in_a_line(model, options, reason):
    with pytest.raises(InputError, match=reason) as refusal:
        Flock(model, agents=30, rng=1, ranks=2, **options)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("ranks", [0, -1, 1.5, True, "2", 2000])
def test_ranks_that_are_no_number_of_processes(ranks):
    with pytest.raises(InputError, match=r"ranks = .* is not allowed"):
        Flock("vem", agents=30, rng=1, ranks=ranks)


def test_a_rule_that_asks_for_the_size_of_the_flock_is_refused_by_what_it_reads():
    refused = {
        name: strip_engine.reason_for_one_process(model, 0, Flock("vem", agents=3, rng=1).options)
        for name, model in MODELS.items()
    }
    assert "the whole flock" in refused["ivem-a"]
    assert not refused["couzin"]
    assert not refused["boundary-points"]


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    length=st.floats(3.5, 30.0),
    low=st.floats(0.0, 1.0),
    share=st.floats(0.0, 1.0),
    halo=st.floats(0.0, 4.0),
    seed=st.integers(0, 99),
)
def test_all_within_reach_of_a_strip_are_ghosts(length, low, share, halo, seed):
    number = int(length / (1.0 + 1e-9))
    columns = StripColumns(0.0, number / length, number, length)
    begin, x = low * length, np.random.default_rng(seed).uniform(0.0, length, 200)
    end = begin + share * (length - begin)
    apart = np.maximum.reduce([begin - x, x - end, np.zeros(200)])
    across = np.minimum(np.abs(x - begin + length), np.abs(end + length - x))
    near = np.minimum(apart, across) <= 1.0 + halo
    assert columns.is_met(x, begin, end, halo)[near].all()


@pytest.fixture
def client():
    distributed = pytest.importorskip("distributed", reason="the extra cluster is not installed")
    cluster = distributed.LocalCluster(
        n_workers=3, threads_per_worker=1, processes=False, dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        yield client


def test_workers_of_a_client_are_the_ranks(client):
    options = {"agents": 300, "size": 9.0, "rng": 5}
    one, many = Flock("vem", **options), Flock("vem", ranks=client, **options)
    one.run(30)
    many.run(30)
    assert len(many.engine.ranks) == 3
    assert is_alike(one, many)
    copy = pickle.loads(pickle.dumps(many))
    assert copy.ranks == 1
    many.position[7] = np.nan
    with pytest.raises(NotANumber, match=f"agent {many.ids[7]}"):
        many.run(3)


@pytest.mark.exhaustive
def test_two_processes_and_one_that_is_killed():
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    options = {"agents": 20_000, "size": 70.0, "rng": 5, "eta": 0.5}
    one, two = Flock("vem", **options), Flock("vem", ranks=2, **options)
    one.run(50)
    two.run(50)
    assert is_alike(one, two)
    pids = two.processes.client.run(os.getpid)
    assert len({os.getpid(), *pids.values()}) == 3
    heard = two.processes.client.run(signal.getsignal, signal.SIGINT)
    assert set(heard.values()) == {signal.SIG_IGN}  # a terminal sends Ctrl-C to all of them
    errors = []

    def run_on():
        try:
            two.run(10**9)
        except InputError as error:
            errors.append(str(error))

    thread = threading.Thread(target=run_on)
    thread.start()
    os.kill(next(iter(pids.values())), signal.SIGKILL)
    thread.join()
    (line,) = errors
    assert "a process has ended" in line
    assert "the flock is as it was at tick 50" in line
    one.run(5)
    two.run(5)
    assert is_alike(one, two)
    two.processes.close()


@pytest.mark.exhaustive
@pytest.mark.parametrize("model", MODELS)
def test_every_model_has_the_bits_of_one_process_or_is_refused(model):
    one = Flock(model, rng=5)
    reason = strip_engine.reason_for_one_process(one.model, one.nearest, one.options)
    if reason:
        with pytest.raises(InputError, match="ranks are not allowed here"):
            Flock(model, rng=5, ranks=3)
        return
    many = in_strips(model, 3)
    one.run(30)
    many.run(30)
    assert is_alike(one, many)
