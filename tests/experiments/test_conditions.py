"""Comparisons that a file may make; nothing else of Python gets through."""

import pytest

from app.studies.sweeps.sweep_file import Condition, ObservableBound, comparison
from worlds.input_error import InputError

VALUES = {"a": 2.0, "b": 3, "name": "x"}


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("a < b", True),
        ("b > a + 1", False),
        ("1 < a <= b", True),
        ("a > 5 or not (b == 4)", True),
        ("a * b == 6 and -a < 0", True),
        ("name == 'x'", True),
        ("name != 'x' or a / b > 1", False),
    ],
)
def test_it_holds_where_it_is_true(text, holds):
    assert Condition(text, VALUES).holds(VALUES) is holds


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('x')", "a.real > 1", "a if b else a", "[a] == [b]", "(a := 3) > 1",
        "lambda: a", "a ** 9 > 1", "a", "a + b", "", "a >", "a > b" * 200, "f'{a}' == 'x'",
        "a in b", "a is b", "a > b; c", "(" * 200 + "a" + ")" * 200, "a[0] > 1", "b'x' == a",
    ],
)  # fmt: skip
def test_whatever_is_no_comparison_is_refused(text):
    with pytest.raises(InputError):
        Condition(text, VALUES)


def test_a_spread_is_compared_as_any_other_axis():
    condition = Condition("s.spread < s.mean / 2", ["s.mean", "s.spread"])
    assert condition.holds({"s.mean": 3.0, "s.spread": 1.0})
    assert not condition.holds({"s.mean": 3.0, "s.spread": 2.0})
    with pytest.raises(InputError, match=r"unknown axis 's.width'"):
        Condition("s.width > 1", ["s.mean"])


def test_an_unknown_axis_is_named_with_the_nearest():
    with pytest.raises(InputError, match="unknown axis 'aa'"):
        Condition("aa > b", VALUES)


@pytest.mark.parametrize("text", ["name > 1", "a / (b - 3) > 1"])
def test_what_cannot_be_compared_is_refused(text):
    with pytest.raises(InputError, match=r"cannot be said of a = 2.0, b = 3, name = 'x'"):
        Condition(text, VALUES).holds(VALUES)


def test_a_comparison_of_an_observable():
    assert comparison(" mean-neighbours>=-1e3 ") == ObservableBound(
        "mean-neighbours", ">=", -1000.0
    )
    assert comparison("x < 2").holds(1.0)
    assert not comparison("x < 2").holds(float("nan"))


@pytest.mark.parametrize(
    "text", ["x", "x > y", "1 < x < 2", "x >= 1 and y > 2", "x > 1" + " " * 900]
)
def test_another_comparison_is_refused(text):
    with pytest.raises(InputError, match="one comparison of an observable with a number is needed"):
        comparison(text)
