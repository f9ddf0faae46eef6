"""Whatever browsers send to a room, in whatever order: nothing raises, nothing exceeds a limit."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from agents.catalogue import cars_by
from agents.declare import checked
from app.live.example import example
from app.live.operating.choices import links, rules, sources
from app.live.operating.squashing_driver import NOT_SIMULATED
from app.viewer.live.room import Room
from tests.viewer.stub_desk import Desks, driver
from tests.viewer.waiting import until

LAB = example()
JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.binary(max_size=5),
    st.just(10**5000),
    st.just("x" * 10_000),
    st.lists(st.integers(), max_size=2),
)
NAMES = st.one_of(JUNK, st.sampled_from(sorted(cars_by("squashing").parameters.model_fields)))
CALLS = st.one_of(
    st.tuples(st.just("ask"), st.one_of(JUNK, st.sampled_from(["arm", "disarm", "reset"]))),
    st.tuples(st.just("tune"), NAMES, st.one_of(JUNK, st.floats(0.0, 5.0))),
    st.tuples(st.just("accompany"), st.one_of(JUNK, st.integers(-1, 10))),
    st.tuples(st.just("place"), JUNK, st.one_of(JUNK, st.floats(-1.0, 1.0))),
    st.tuples(
        st.just("choose"),
        st.one_of(JUNK, st.sampled_from(list(sources(LAB)))),
        st.one_of(JUNK, st.sampled_from(list(links(LAB)))),
        st.one_of(JUNK, st.sampled_from(list(rules(LAB)))),
    ),
    st.tuples(st.just("emergency")),
    st.tuples(st.just("reopen")),
    st.tuples(st.just("browsers")),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(CALLS, max_size=25))
def test_nothing_raises_and_nothing_exceeds_a_limit(calls):
    desks = Desks()
    room = Room(LAB, desk=desks, driver=driver)
    try:
        until(lambda: room.state.status == "open")
        for name, *values in calls:
            more = () if name in ("place", "choose") else ("browser 1",)
            getattr(room, name)(*values, *((0,) if name == "browsers" else more))
        until(lambda: room.next is None and room.state.status == "open")
        room.emergency("browser 1")
        until(lambda: room.look is not None and room.look.arm == "emergency")
    finally:
        room.close()
    assert room.state.status == "closed"
    for desk in desks.made:
        assert desk.closed == 1
        assert desk.lab.source in sources(LAB).values()
        assert desk.lab.link in {*links(LAB).values(), "simulated"}
        model = cars_by(desk.lab.rule)
        for values in desk.tuned():
            assert not set(values) & set(NOT_SIMULATED)
            assert checked(model.parameters, values)
        for x, y in desk.placed:
            assert math.isfinite(x)
            assert math.isfinite(y)
        for request in desk.asked:
            if request.wish == "accompany":
                assert 0 <= int(request.words) <= LAB.simulated.most
    while not room.notices.empty():
        assert len(room.notices.get()) < 1000
