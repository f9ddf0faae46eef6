"""Whatever browsers send to a room, in whatever order: nothing raises, nothing exceeds a limit."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from agents.catalogue import cars_for_rule
from agents.models.declare import checked
from app.live.laboratory.lab_file import example
from app.live.operating.flock_driver import NOT_SIMULATED
from app.live.operating.lab_choices import Choices
from app.viewer.live.session import Session
from tests.viewer.stub_operator import Operators, driver
from tests.viewer.waiting import until

CHOICES = Choices.of(example())
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
NAMES = st.one_of(JUNK, st.sampled_from(sorted(cars_for_rule("squashing").parameters.model_fields)))
CALLS = st.one_of(
    st.tuples(st.just("ask"), st.one_of(JUNK, st.sampled_from(["arm", "disarm", "reset"]))),
    st.tuples(st.just("set_parameter"), NAMES, st.one_of(JUNK, st.floats(0.0, 5.0))),
    st.tuples(st.just("set_companions"), st.one_of(JUNK, st.integers(-1, 10))),
    st.tuples(st.just("place"), JUNK, st.one_of(JUNK, st.floats(-1.0, 1.0))),
    st.tuples(
        st.just("choose"),
        st.one_of(JUNK, st.sampled_from(list(CHOICES.sources))),
        st.one_of(JUNK, st.sampled_from(list(CHOICES.links))),
        st.one_of(JUNK, st.sampled_from(CHOICES.rules)),
    ),
    st.tuples(st.just("emergency")),
    st.tuples(st.just("reopen")),
    st.tuples(st.just("browsers")),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(CALLS, max_size=25))
def test_nothing_raises_and_nothing_exceeds_a_limit(calls):
    operators = Operators()
    session = Session(CHOICES, operator=operators, driver=driver)
    try:
        until(lambda: session.state.phase == "open")
        for name, *values in calls:
            more = () if name in ("place", "choose") else ("browser 1",)
            getattr(session, name)(*values, *((0,) if name == "browsers" else more))
        until(lambda: session.next is None and session.state.phase == "open")
        session.emergency("browser 1")
        until(lambda: session.status is not None and session.status.arm == "emergency")
    finally:
        session.close()
    assert session.state.phase == "closed"
    for operator in operators.made:
        assert operator.closed == 1
        assert operator.lab.source in CHOICES.sources.values()
        assert operator.lab.link in {*CHOICES.links.values(), "simulated"}
        model = cars_for_rule(operator.lab.rule)
        for values in operator.tuned():
            assert not set(values) & set(NOT_SIMULATED)
            assert checked(model.parameters, values)
        for x, y in operator.placed:
            assert math.isfinite(x)
            assert math.isfinite(y)
        for request in operator.asked:
            if request.action == "accompany":
                assert 0 <= int(request.words) <= CHOICES.lab.simulated.most
    while not session.notices.empty():
        assert len(session.notices.get()) < 1000
