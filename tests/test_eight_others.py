"""Sums over eight others at once, and how a loop's products and sums are rounded."""

from __future__ import annotations

import math
import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from llvmlite.binding import parse_assembly

from agents.engine.eight_others import (
    across,
    eight_from,
    is_there,
    least,
    no_lanes,
    sums_over_others,
    width,
)
from agents.engine.vector_lanes import where
from worlds.code_libraries import settle_rounding
from worlds.compilation import compiled, entry, levels_here, plain_python


@compiled
def sum_and_least(column, table, number):
    """Of the first `number`: the sum of a column, and the least of a table's second row."""
    total, smallest = no_lanes(), no_lanes() + math.inf
    for first in range(0, number, width()):
        j = eight_from(first, number)
        total += where(is_there(j), column[j], 0.0)
        smallest = min(smallest, where(is_there(j), table[1, j], math.inf))
    return across(total), least(smallest)


@entry
def measure(column, table, number):
    return sum_and_least(column, table, number)


@given(st.integers(0, 40), st.integers(0, 2**32 - 1))
def test_who_is_not_there_counts_nothing(number, seed):
    """Also where the lanes beyond the last one hold what is no number."""
    rng = np.random.default_rng(seed)
    column, table = rng.uniform(-1.0, 1.0, 48), rng.uniform(-1.0, 1.0, (3, 48))
    column[number:] = table[:, number:] = math.nan
    total, smallest = measure(column, table, number)
    assert total == pytest.approx(math.fsum(column[:number]), abs=1e-14)
    assert smallest == min(table[1, :number], default=math.inf)
    with plain_python():
        plain = sum_and_least.py_func(column, table, number)
    assert plain == pytest.approx((total, smallest), abs=1e-14)


def test_the_order_of_the_sum_is_always_the_same():
    """Lane by lane over the eights, then the lanes from the first to the last."""
    column = np.concatenate([10.0 ** np.arange(-8, 16), np.zeros(8)])
    lanes = np.zeros(8)
    for first in range(0, 24, 8):
        lanes += column[first : first + 8]
    total = 0.0
    for lane in lanes:
        total += lane
    assert measure(column, column[None].repeat(2, axis=0), 24)[0] == total


def test_a_term_is_asked_for_eight_at_once():
    class Near:
        n = 5

    def term(_me, _near, j, _p):
        return j, 2 * j

    with plain_python():
        around = sums_over_others(2, compiled(term))
        assert around.py_func(None, Near, None) == (10, 20)


WRITTEN = """
define double @f(double %a, double %b, double %c, ptr %out) {
  %1 = fmul reassoc nsz arcp contract double %a, %b
  %2 = fadd reassoc nsz arcp contract double %c, %1
  %x = fmul nsz contract double %a, %a
  %y = fsub nsz contract double %x, %c
  store double %y, ptr %out
  %q = fmul contract double %b, %b
  %r = fsub contract double %c, %q
  store double %r, ptr %out
  %t = fmul nsz contract double %c, %c
  store double %t, ptr %out
  %u = fadd nsz contract double %t, %a
  %v = fdiv arcp double %u, %2
  ret double %v
}
"""


def test_each_sum_with_a_product_of_its_own_is_rounded_once_and_nothing_stays_open():
    """A product that others use as well is rounded by itself."""
    settled = settle_rounding(WRITTEN)
    parse_assembly(settled).verify()
    assert re.findall(r"%(\w+) = call nsz double @llvm.fma.f64\((.*)\)", settled) == [
        ("2", "double %a, double %b, double %c"),
        ("y", "double %a, double %a, double %minus.y"),
        ("r", "double %minus.r, double %b, double %c"),
    ]
    assert "%minus.y = fneg double %c" in settled
    assert "%minus.r = fneg double %b" in settled
    assert "%u = fadd nsz double %t, %a" in settled
    assert "%v = fdiv double %u, %2" in settled
    assert settle_rounding(settled) == settled


@entry
def product_and_sum(a, b, c):
    return a * b + c


@pytest.mark.skipif(not levels_here(), reason="made for x86-64-v3 and later")
def test_a_loop_rounds_a_product_and_a_sum_once():
    a, b = 1.0 + 2.0**-30, 1.0 - 2.0**-30
    exact = float(Fraction(a) * Fraction(b) - 1)
    assert product_and_sum(a, b, -1.0) == exact != a * b - 1.0
