"""Values from browsers: clamped, or not let through."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.front.controls import UnusableError, clamp_number, offered_choice

HOSTILE = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text()
    | st.binary()
    | st.sampled_from([10**400, -(10**400), 1e308, math.inf, -math.inf, math.nan, "NaN", "1e9"]),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=5,
)


@given(HOSTILE)
def test_a_number_comes_out_within_its_range_or_not_at_all(value):
    try:
        made = clamp_number(value, 0.0, 6.28)
    except UnusableError:
        return
    assert type(made) is float
    assert 0.0 <= made <= 6.28


@given(HOSTILE)
def test_an_integer_without_bounds_is_an_integer_or_nothing(value):
    try:
        made = clamp_number(value, None, None, int)
    except UnusableError:
        return
    assert type(made) is int


@given(st.floats(0.0, 6.28))
def test_a_number_within_its_range_stays_what_it_is(value):
    assert clamp_number(value, 0.0, 6.28) == value


@pytest.mark.parametrize("value", [math.nan, "1", None, True, [1.0], {"a": 1}])
def test_what_is_no_number_is_unusable(value):
    with pytest.raises(UnusableError):
        clamp_number(value, 0.0, 1.0)


@pytest.mark.parametrize(("value", "clamped"), [(math.inf, 1.0), (-math.inf, 0.0), (10**400, 1.0)])
def test_what_is_too_large_is_clamped(value, clamped):
    assert clamp_number(value, 0.0, 1.0) == clamped


@given(HOSTILE)
def test_only_offered_choices_come_through(value):
    try:
        assert offered_choice(value, ("heading", "layer")) in ("heading", "layer")
    except UnusableError:
        assert value not in ("heading", "layer")
