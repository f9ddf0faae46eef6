"""Sources and exits: who enters and leaves when and where, against exact cases and naive walks."""

import copy
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.mesa_interface import Member
from agents.recordings.recorder import Recorder
from agents.recordings.recording import Recording
from agents.run_records import fly, follow
from agents.state.passages import Passages
from agents.web.web_program import web_program
from worlds.checks import problems
from worlds.input_error import InputError
from worlds.layout import world as built_in
from worlds.layout import world_from_layout
from worlds.mission import ExitRegion, Mission, SourceRegion, StartRegion
from worlds.obstacles import Box
from worlds.queries.clearance import clearance
from worlds.world import World

EAST = ExitRegion(low=(8.0, 0.0), high=(10.0, 10.0))
CORNER = ExitRegion(points=((0.0, 0.0), (4.0, 0.0), (0.0, 4.0)))
DOOR = Box(low=(3.0, 3.0), high=(5.0, 5.0))


def hall(*exits, sources=(), edges="solid", obstacles=(), size=(10.0, 10.0)):
    mission = Mission(sources=tuple(sources), exits=exits)
    return World("hall", size, edges, obstacles=obstacles, mission=mission)


def walker(x, world, speed=0.25, **more):
    """One agent that walks along +x, `speed` a tick."""
    start = {"position": [[x, 5.0]], "heading": [[1.0, 0.0]]}
    return Flock("vem", start=start, world=world, rng=1, eta=0.0, v0=speed, **more)


def alike(one, other):
    """Whether two flocks are the same, to the bit, and so is who has come and gone."""
    logs = [(a.tick, a.id, a.gate, a.place) for a in (one.entries, one.exits)]
    others = [(a.tick, a.id, a.gate, a.place) for a in (other.entries, other.exits)]
    pairs = [*zip(one.arrays, other.arrays, strict=True)]
    pairs += [pair for a, b in zip(logs, others, strict=True) for pair in zip(a, b, strict=True)]
    return (one.tick, one.next_id) == (other.tick, other.next_id) and all(
        np.array_equal(a, b, equal_nan=True) for a, b in pairs
    )


def test_one_agent_walks_out_at_the_tick_at_whose_end_it_is_in_the_exit():
    flock = walker(1.0, hall(EAST))
    flock.run(27)
    assert (len(flock.ids), flock.observe("exited")) == (1, 0)
    assert flock.position[0, 0] == 7.75
    flock.run(1)  # 1 + 28 / 4 = 8, the edge, which is in it
    assert len(flock.ids) == 0
    assert flock.exits.tick.tolist() == [28]
    assert flock.exits.id.tolist() == [1]
    assert flock.exits.gate.tolist() == [0]
    assert flock.exits.place.tolist() == [[8.0, 5.0]]
    assert flock.has_ended
    flock.run(100)
    assert (flock.tick, flock.observe("exited")) == (128, 1)
    assert math.isnan(flock.observe("flow"))


def test_a_run_until_its_end_stops_at_the_tick_of_the_last_exit():
    flock = walker(1.0, hall(EAST))
    flock.advance(1000, until_ended=True)
    assert flock.tick == 28


def test_flow_is_that_of_crowd_science():
    """Three leave at ticks 12, 16 and 28: J = 2 / 16 per tick."""
    start = {"position": [[1.0, 2.0], [4.0, 5.0], [5.0, 8.0]], "heading": [[1.0, 0.0]] * 3}
    flock = Flock("vem", start=start, world=hall(EAST), rng=1, eta=0.0, v0=0.25, r=0.5)
    flock.run(12)
    assert math.isnan(flock.observe("flow"))
    flock.run(4)
    assert flock.observe("flow") == 1.0 / 4.0
    flock.run(20)
    assert flock.exits.tick.tolist() == [12, 16, 28]
    assert flock.exits.id.tolist() == [3, 2, 1]
    assert flock.observe("flow") == 2.0 / 16.0


def test_a_flow_is_per_unit_of_time_and_not_per_tick():
    source = SourceRegion(low=(0.0, 0.0), high=(1.0, 10.0), times=(0.0, 1.0, 2.0),
                          speed_low=(1.0, 0.0), speed_high=(1.0, 0.0))  # fmt: skip
    world = hall(EAST, sources=[source])
    start = {"position": [[9.0, 1.0]], "heading": [[1.0, 0.0]]}
    flock = Flock("pedestrian", start=start, world=world, rng=1, ways="own")
    flock.advance(10_000, until_ended=True)
    ticks = flock.exits.tick
    assert len(ticks) == 4
    expected = 3.0 / (0.05 * (ticks[-1] - ticks[0]))
    assert flock.observe("flow") == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("rate", [0.1, 0.3, 1.0, 2.9, 7.0])
def test_a_rate_lets_in_as_many_as_are_due_at_every_tick(rate):
    source = SourceRegion(low=(0.0, 0.0), high=(10.0, 10.0), rate=rate)
    flock = walker(1.0, hall(sources=[source], edges="wrap"))
    for tick in range(1, 60):
        flock.run(1)
        assert flock.observe("entered") == math.floor(round(rate * tick, 9))
        assert len(flock.ids) == 1 + flock.observe("entered")
        assert flock.observe("waiting-to-enter") == 0
    assert flock.ids.tolist() == list(range(1, len(flock.ids) + 1))


def test_a_rate_in_units_of_time_is_exact_where_ticks_are_tenths():
    """10 a second at dt = 0.1 s: one each tick, whatever 0.1 is in binary."""
    source = SourceRegion(low=(0.0, 0.0), high=(10.0, 10.0), rate=10.0)
    flock = Flock("pedestrian", agents=1, world=hall(sources=[source]), rng=1, dt=0.1)
    flock.run(300)
    assert flock.entries.tick.tolist() == list(range(1, 301))


def test_given_times_are_kept_and_a_tick_that_holds_several_lets_in_all():
    times = (0.0, 0.5, 3.0, 3.0, 3.2, 40.0)
    source = SourceRegion(low=(0.0, 0.0), high=(10.0, 10.0), times=times)
    flock = walker(1.0, hall(sources=[source], edges="wrap"))
    assert flock.entries.tick.tolist() == [0]
    flock.run(100)
    assert flock.entries.tick.tolist() == [0, 1, 3, 3, 4, 40]
    assert not flock.has_ended


def test_a_rate_ends_with_the_most_that_it_lets_in():
    source = SourceRegion(low=(0.0, 0.0), high=(10.0, 10.0), rate=2.0, most=7)
    flock = walker(1.0, hall(sources=[source], edges="wrap"))
    flock.run(50)
    assert (flock.observe("entered"), flock.observe("waiting-to-enter")) == (7, 0)


def test_who_finds_no_place_waits_and_enters_once_there_is_one():
    """The source holds nobody beside the agent that stands in it until that one has walked on."""
    source = SourceRegion(low=(1.0, 4.9), high=(1.2, 5.1), rate=0.5, spacing=3.0, most=3)
    flock = walker(1.0, hall(sources=[source]), speed=0.125)
    flock.run(20)
    assert (flock.observe("entered"), flock.observe("waiting-to-enter")) == (0, 3)
    flock.run(8)
    first = flock.entries.tick.tolist()
    assert len(first) == 1
    assert 24 <= first[0] <= 26  # 3 to 3.2 away by then
    assert flock.observe("waiting-to-enter") == 2


@pytest.mark.parametrize("region", [EAST, CORNER])
def test_every_agent_leaves_where_a_naive_walk_first_enters_the_exit(region):
    """Agents that take no notice of each other go as without exits, until they are gone."""

    def inside(x, y):
        if region is EAST:
            return 8.0 <= x <= 10.0 and 0.0 <= y <= 10.0
        return x >= 0.0 and y >= 0.0 and x + y <= 4.0

    kind = {"agents": 60, "rng": 4, "ways": "own", "repulsion": 0.0, "spacing": 0.0}
    free = Flock("pedestrian", world=World("hall", (10.0, 10.0), "solid"), **kind)
    gated = Flock("pedestrian", world=hall(region), **kind)
    expected, gone = [], set()
    for tick in range(1, 121):
        free.run(1)
        for row in np.argsort(free.ids, kind="stable"):
            identity, place = int(free.ids[row]), free.position[row].tolist()
            if identity not in gone and inside(*place):
                gone.add(identity)
                expected.append((tick, identity, place))
    gated.run(120)
    exits = gated.exits
    found = sorted(zip(exits.tick.tolist(), exits.id.tolist(), exits.place.tolist(), strict=True))
    assert 5 < len(found) < 60
    assert found == sorted(expected)
    left = free.position[~np.isin(free.ids, exits.id)]
    np.testing.assert_array_equal(gated.position, left)


@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 2**31),
    spacing=st.sampled_from((0.0, 0.4, 1.0)),
    edges=st.sampled_from(("wrap", "solid", "open")),
    dim=st.sampled_from((2, 3)),
)
def test_newcomers_stand_in_their_source_clear_of_walls_and_of_each_other(
    seed, spacing, edges, dim
):
    low, high = (0.0, 2.0, 0.0)[:dim], (9.5, 6.0, 2.0)[:dim]
    source = SourceRegion(low=low, high=high, rate=3.0, spacing=spacing)
    obstacles = (DOOR,)
    world = hall(sources=[source], edges=edges, obstacles=obstacles, size=(10.0,) * dim)
    flock = Flock("vem", agents=5, world=world, rng=seed, v0=0.1, informed=0)
    for _ in range(12):
        flock.run(1)
        new = flock.entries.tick == flock.tick
        rows = np.flatnonzero(np.isin(flock.ids, flock.entries.id[new]))
        np.testing.assert_array_equal(flock.position[rows], flock.entries.place[new])
        place = flock.position[rows]
        assert np.all((place >= low) & (place <= high))
        assert np.all(clearance(world, place) > 0.0)
        for row in rows:
            away = flock.position[row] - np.delete(flock.position, row, axis=0)
            if edges == "wrap":
                away -= np.round(away / 10.0) * 10.0
            assert np.linalg.norm(away, axis=1).min() >= spacing
    assert flock.observe("entered") + flock.observe("waiting-to-enter") == 36
    assert len(np.unique(flock.ids)) == len(flock.ids)


SOURCE = SourceRegion(low=(0.5, 0.5), high=(2.5, 9.5), rate=4.0, spacing=0.3,
                      speed_low=(1.0, -0.2), speed_high=(1.4, 0.2))  # fmt: skip
BUSY = hall(EAST, sources=[SOURCE], obstacles=(DOOR,))


def busy(model="pedestrian", **more):
    more = {"ways": "own"} | more if model == "pedestrian" else more
    return Flock(model, agents=25, world=BUSY, rng=7, **more)


def test_the_velocities_of_a_source_are_those_that_agents_set_off_with():
    flock = busy()
    flock.run(5)
    newcomer = int(flock.ids[flock.ids > 25][0])
    assert newcomer == 26
    row = int(np.argmax(flock.ids == newcomer))
    velocity = flock.speed[row] * flock.heading[row]
    assert np.all((velocity >= (1.0, -0.2)) & (velocity <= (1.4, 0.2)))


@pytest.mark.parametrize("split", [False, True])
def test_numbers_do_not_depend_on_threads_or_on_how_ticks_are_asked_for(split):
    one, other = busy(), busy(threads=2)
    if split:
        other.split_from = 1
    one.run(400)
    for _ in range(100):
        other.run(4)
    assert alike(one, other)
    assert min(len(one.entries), len(one.exits)) > 10


@pytest.mark.parametrize(
    ("model", "more"),
    [
        ("vem", {"activation": "random"}),
        ("vem", {"activation": "sequential"}),
        ("vem", {"delay": 3.0}),
        ("couzin", {}),
        ("reynolds", {}),
        ("vem", {"interpret": True}),
    ],
)
def test_agents_come_and_go_however_they_act(model, more):
    one, other = busy(model, **more), busy(model, **more)
    ticks = 12 if more.get("interpret") else 60
    one.run(ticks)
    for _ in range(ticks):
        other.run(1)
    assert alike(one, other)
    assert len(one.entries) > 5
    assert np.isfinite(one.position).all()


def test_wrecks_stay_where_they_lie_and_others_leave():
    sky = hall(ExitRegion(low=(8.0, 0.0, 0.0), high=(20.0,) * 3), edges="open", size=(20.0,) * 3)
    start = {
        "position": [[4.0, 5.0, 5.0], [9.0, 5.0, 5.0], [4.0, 15.0, 5.0]],
        "heading": [[1.0, 0.0, 0.0]] * 3,
    }
    flock = Flock("safe", start=start, world=sky, rng=1)
    assert flock.can_crash
    flock.arrays.crash_record[1] = [0.0, 2.0, 9.0, 5.0, 5.0]
    flock.run(200)
    assert sorted(flock.exits.id.tolist()) == [1, 3]
    assert flock.ids.tolist() == [2]
    assert flock.crashes.id.tolist() == [2]
    assert (flock.observe("exited"), flock.observe("crashes")) == (2, 1)


def test_a_flock_with_gates_that_nobody_passes_has_the_bits_of_one_without():
    far = ExitRegion(low=(9.99, 9.99), high=(10.0, 10.0))
    late = SourceRegion(low=(0.0, 0.0), high=(1.0, 1.0), times=(1e6,))
    plain = World("hall", (10.0, 10.0), "solid", obstacles=(DOOR,))
    gated = replace(plain, mission=Mission(exits=(far,), sources=(late,)))
    one, other = (Flock("couzin", agents=30, world=w, rng=2) for w in (plain, gated))
    one.run(80)
    other.run(80)
    assert not len(other.exits)
    assert np.array_equal(one.position, other.position)


def test_a_saved_state_goes_on_with_its_counts(tmp_path):
    whole, first = busy(), busy()
    whole.run(300)
    first.run(150)
    first.save(tmp_path / "state.parquet")
    second = Flock.load(tmp_path / "state.parquet")
    assert alike(first, second)
    second.run(150)
    assert alike(whole, second)
    assert second.observe("flow") == whole.observe("flow")


def test_copies_pickles_and_snapshots_go_on_alike():
    flock = busy()
    flock.run(150)
    past = flock.snapshot()
    others = copy.deepcopy(flock), pickle.loads(pickle.dumps(flock))
    flock.run(100)
    for other in others:
        other.run(100)
        assert alike(flock, other)
    others[0].return_to(past)
    others[0].run(100)
    assert alike(flock, others[0])


def test_a_restart_begins_with_nobody_gone():
    flock = busy()
    flock.run(150)
    flock.restart(11)
    again = Flock("pedestrian", agents=25, world=BUSY, rng=11, ways="own")
    assert alike(flock, again)
    flock.run(100)
    again.run(100)
    assert alike(flock, again)


def test_a_recording_tells_at_each_tick_who_had_come_and_gone(tmp_path):
    flock, seen = busy(), {}
    path = tmp_path / "run.parquet"
    with Recorder(path, flock) as recorder:
        recorder.write()
        for _ in range(6):
            flock.run(50)
            recorder.write()
            seen[flock.tick] = flock.snapshot()
    recording = Recording(path)
    for tick, before in seen.items():
        now = recording.at(tick)
        assert now.exits.tick.tolist() == before.exits.tick.tolist()
        assert now.entries.place.tolist() == before.entries.place.tolist()
    assert alike(Flock.load(path), flock)
    half = Flock.load(path, tick=150)
    half.run(150)
    half.signals()  # as the recorder has asked for them: a newcomer shows them from then on
    assert alike(half, flock)


def test_what_a_kill_has_left_does_not_know_who_went_and_says_so(tmp_path):
    from agents.observables.catalogue import OBSERVABLES
    from agents.recordings.recorder import recover

    flock, path = busy(), tmp_path / "run.parquet"
    recorder = Recorder(path, flock)
    recorder.__enter__()
    recorder.write()
    flock.run(200)
    recorder.write()
    recorder.flush()
    recorder.stream.close()
    recorder.file.close()
    recover(recorder.part)
    found = Recording(path)
    assert math.isnan(OBSERVABLES["exited"].measure(found.at(200)))
    assert math.isnan(OBSERVABLES["waiting-to-enter"].measure(found.at(200)))
    with pytest.raises(InputError, match="does not hold who came and went") as caught:
        Flock.load(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "change",
    [
        {"tick": [1.5]}, {"tick": [True]}, {"id": [-1]}, {"gate": [1]}, {"place": [[1.0]]},
        {"place": [[math.nan, 0.0]]}, {"tick": [1, 2]}, {"tick": "1"}, {"place": None},
    ],
)  # fmt: skip
def test_passages_of_a_file_that_cannot_be_are_refused(change):
    sound = {"tick": [3], "id": [1], "gate": [0], "place": [[1.0, 2.0]]}
    assert len(Passages.from_table(sound, 2, 1, "f")) == 1
    with pytest.raises(InputError, match="f holds passages"):
        Passages.from_table(sound | change, 2, 1, "f")


def test_mesa_agents_come_and_go_with_the_rows():
    flock = busy()
    members = {member.unique_id: member for member in flock.agents}
    for _ in range(200):
        flock.step()
    gone = flock.exits.id.tolist()
    assert gone
    for identity, member in members.items():
        assert member.is_gone == (identity in gone)
    assert sorted(member.unique_id for member in flock.agents) == sorted(flock.ids.tolist())
    assert all(isinstance(member, Member) for member in flock.agents)


def test_agents_that_step_one_by_one_come_and_go_as_in_a_run():
    one, other = busy(), busy()
    for _ in range(60):
        other.agents.do("step")
    one.run(60)
    assert alike(one, other)


def test_a_series_over_a_run_has_the_counts():
    flock = busy()
    series = follow(flock, 200, ["entered", "exited", "waiting-to-enter"], every=50)
    assert series.values["exited"].tolist() == [
        int((flock.exits.tick <= tick).sum()) for tick in (50, 100, 150, 200)
    ]
    assert (series.agents == 25 + series.values["entered"] - series.values["exited"]).all()


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        ({}, "either rate or times"),
        ({"rate": 1.0, "times": [1.0]}, "either rate or times"),
        ({"rate": -1.0}, "rate = -1.0"),
        ({"rate": math.nan}, "rate = nan"),
        ({"times": []}, "times"),
        ({"times": [2.0, 1.0]}, "not in order"),
        ({"times": [0.0, math.nan]}, "times"),
        ({"times": [-1.0]}, "times"),
        ({"times": [1.0], "most": 3}, "most goes with rate"),
        ({"rate": 1.0, "most": 0}, "most = 0"),
        ({"rate": 1.0, "spacing": -1.0}, "spacing"),
        ({"rate": 1.0, "speed_low": [1.0, 0.0]}, "go together"),
        ({"rate": 1.0, "high": [1.0]}, "high"),
        ({"rate": 1.0, "high": [0.5, 0.5]}, "not above low"),
        ({"rate": 1.0, "low": [3.2, 3.2], "high": [4.8, 4.8]}, "no room outside the obstacles"),
        ({"rate": 1.0, "low": [-1.0, 1.0]}, "outside of the world"),
        ({"rate": 1.0, "low": [11.0, 1.0], "high": [12.0, 2.0]}, "outside of the world"),
        ({"rate": 1.0, "colour": 1}, "colour"),
        ({"times": [0.0] * 100_001}, "times"),
    ],
)
def test_a_source_that_cannot_be_is_refused_in_a_line(keys, why):
    demand_refused({"sources": [{"low": [1.0, 1.0], "high": [2.0, 2.0]} | keys]}, why)


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        ({}, "either low and high or points"),
        ({"low": [1.0, 1.0]}, "go together"),
        ({"low": [1.0, 1.0], "high": [2.0, 2.0], "points": [[0, 0], [1, 0], [0, 1]]}, "either"),
        ({"points": [[0.0, 0.0], [1.0, 1.0]]}, "points"),
        ({"points": [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]}, "cross itself"),
        ({"points": [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]}, "area"),
        ({"points": [[0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [2.0, 0.0, 1.0]]}, "no place on the plan"),
        ({"low": [10.0, 1.0], "high": [12.0, 2.0]}, "outside of the world"),
        ({"points": [[-1.0, 0.0], [-2.0, 0.0], [-1.0, 2.0]]}, "outside of the world"),
        ({"low": [3.2, 3.2], "high": [4.8, 4.8]}, "no room outside the obstacles"),
        ({"low": [1.0, 1.0, 1.0], "high": [2.0, 2.0, 2.0]}, "3 coordinates, the world has 2"),
    ],
)
def test_an_exit_that_cannot_be_is_refused_in_a_line(keys, why):
    demand_refused({"exits": [keys]}, why)


def demand_refused(mission, why):
    from worlds.checks import demand_sound

    obstacle = {"shape": "box", "low": [3.0, 3.0], "high": [5.0, 5.0]}
    layout = {"edges": "solid", "size": [10.0, 10.0], "mission": mission, "obstacle": [obstacle]}
    with pytest.raises(InputError, match=why) as caught:
        demand_sound(world_from_layout(layout, "hall"))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_source_within_an_exit_is_a_warning():
    world = hall(EAST, sources=[SourceRegion(low=(7.0, 1.0), high=(9.0, 2.0), rate=1.0)])
    (problem,) = problems(world)
    assert problem.severity == "warning"


@pytest.mark.parametrize(("rate", "fits"), [(20_000.0, True), (20_001.0, False)])
def test_a_source_has_no_more_due_in_a_tick_than_can_be(rate, fits):
    world = hall(sources=[SourceRegion(low=(1.0, 1.0), high=(2.0, 2.0), rate=rate)])
    if fits:
        Flock("pedestrian", agents=1, world=world, rng=1)
        return
    with pytest.raises(InputError, match="has 1001 agents due in one tick"):
        Flock("pedestrian", agents=1, world=world, rng=1)
    flock = Flock("pedestrian", agents=1, world=hall(), rng=1)
    with pytest.raises(InputError, match="has 1001 agents due in one tick"):
        flock.change_world(world)
    assert not flock.world.has_gates


def test_what_needs_the_same_agents_throughout_is_refused_in_a_line(tmp_path):
    flock = busy()
    for refused in (
        lambda: flock.trace(3),
        lambda: flock.run_until_consistent(10),
        lambda: fly(flock, 10),
        lambda: web_program(flock),
        lambda: busy(ranks=2),
    ):
        with pytest.raises(InputError, match="agents come and go in hall") as caught:
            refused()
        assert "\n" not in str(caught.value)
    empty = walker(7.9, hall(EAST))
    empty.run(1)
    with pytest.raises(InputError, match="the flock is empty at tick 1"):
        empty.save(tmp_path / "none.parquet")


def test_a_flat_layout_that_stands_up_has_gates_from_the_floor_to_the_top():
    layout = {
        "edges": "solid", "size": [10.0, 10.0], "height": 4.0,
        "mission": {
            "sources": [{"low": [0.0, 0.0], "high": [2.0, 2.0], "rate": 1.0}],
            "exits": [{"low": [8.0, 0.0], "high": [10.0, 10.0]},
                      {"points": [[0.0, 8.0], [2.0, 8.0], [0.0, 10.0]]}],
        },
    }  # fmt: skip
    world = world_from_layout(layout, "hall", dim=3)
    assert world.mission.sources[0].high == (2.0, 2.0, 4.0)
    assert world.mission.exits[0].low == (8.0, 0.0, 0.0)
    places = np.array([[9.0, 5.0, 3.9], [0.5, 8.5, 1.0], [1.9, 9.9, 1.0]])
    assert world.mission.exits[0].contains(places).tolist() == [True, False, False]
    assert world.mission.exits[1].contains(places).tolist() == [False, True, False]
    assert not problems(world)


def test_a_mission_without_gates_is_written_as_before():
    mission = Mission(start=StartRegion(low=(0.0, 0.0), high=(1.0, 1.0)))
    assert "sources" not in World(mission=mission).to_toml()
    assert "exits" not in World(mission=mission).to_toml()
    assert world_from_layout(BUSY.to_layout(), "hall") == BUSY


def test_pedestrians_go_to_the_goal_of_their_world():
    world = built_in("bottleneck")
    flock = Flock("pedestrian", agents=20, world=world, rng=1, ways="goal")
    flock.run(3)
    before = flock.position.copy()
    flock.run(1)  # what was seen in this tick is told at the beginning of the next
    aim = np.array(world.mission.goal.route[0]) - before
    aim /= np.linalg.norm(aim, axis=1)[:, None]
    told = np.column_stack([flock.signal("way_x"), flock.signal("way_y")])
    np.testing.assert_allclose(told, aim, atol=1e-12)


def test_people_get_through_the_bottleneck_where_its_walls_are_felt_less():
    flock = Flock(
        "pedestrian", agents=20, world="bottleneck", rng=1, ways="goal", r_border=0.05,
        step_time=0.2,
    )  # fmt: skip
    flock.advance(2000, until_ended=True)
    assert flock.observe("exited") >= 18
    assert np.all(flock.exits.place[:, 1] <= -1.1)
    assert np.all(np.abs(flock.exits.place[:, 0]) <= 0.7)
