"""Mathematical functions of pages: close to the library's, and the browser's own is not called."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from agents.web.web_math import FUNCTIONS, page_function
from tests.worlds.test_web_assembly import Running
from worlds.web_assembly import SLOT, MemoryImage, web_module
from worlds.web_binary import imported_functions

UNITS = {"tan": 8.0, "acos": 6.0, "asin": 6.0}
"""Units in the last place by which a function may differ; else 4."""
EXTREME = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan, 5e-324, 1e308, -1e308, 0.5, -2.0]


@pytest.fixture(scope="module")
def page():
    """All of them in one module that runs."""
    image = MemoryImage()
    image.add("x", 0.0)
    image.add("y", 0.0)
    image.finish()
    module = web_module({name: page_function(name) for name in FUNCTIONS})
    assert imported_functions(module.content) == []
    running = Running(module.content, image)

    def value(name: str, *arguments: float) -> float:
        packed = struct.pack("<2d", *arguments, *[0.0] * (2 - len(arguments)))
        running.memory.write(running.store, packed, image.block + 2 * SLOT)
        running.call(name, image)
        (found,) = running.read(image.answer, "<d")
        return found

    return value


def expected(name: str, *arguments: float) -> float:
    """What NumPy gives."""
    names = {"acos": "arccos", "asin": "arcsin", "atan": "arctan", "atan2": "arctan2"}
    function = getattr(np, {"pow": "power"}.get(name, names.get(name, name)))
    with np.errstate(all="ignore"):
        return float(function(*arguments))


def demand_close(found: float, wanted: float, units: float) -> None:
    """Demand that numbers differ by few units in the last place, or are the same special one."""
    if math.isfinite(wanted) and math.isfinite(found):
        assert abs(found - wanted) <= units * math.ulp(wanted), (found, wanted)
    else:
        assert found == wanted or (math.isnan(found) and math.isnan(wanted)), (found, wanted)


ONE = {
    "exp": st.floats(-745.0, 709.0),
    "log": st.floats(0.0, 1e308),
    "sin": st.floats(-19.0, 19.0),
    "cos": st.floats(-19.0, 19.0),
    "tan": st.floats(-1.5, 1.5),
    "atan": st.floats(-1e300, 1e300),
    "acos": st.floats(-1.0, 1.0),
    "asin": st.floats(-1.0, 1.0),
}


@given(st.data())
def test_a_function_of_one_number_is_close_to_the_librarys(page, data):
    name = data.draw(st.sampled_from(sorted(ONE)))
    x = data.draw(ONE[name])
    wanted = expected(name, x)
    units = UNITS.get(name, 4.0)
    if name in ("sin", "cos"):  # near their zeros the argument itself is known no better
        assert page(name, x) == pytest.approx(wanted, rel=1e-15, abs=3e-15)
    elif name == "exp" and wanted < 1e-300:
        assert page(name, x) == pytest.approx(wanted, rel=1e-9, abs=1e-310)
    else:
        demand_close(page(name, x), wanted, units)


NUMBERS = st.floats(-1e120, 1e120)


@given(NUMBERS, NUMBERS)
@example(0.0, -0.0)
@example(-0.0, -0.0)
@example(-0.0, 1.0)
@example(3.0, -1e-300)
def test_angles_and_lengths_are_close_to_the_librarys(page, y, x):
    demand_close(page("atan2", y, x), expected("atan2", y, x), 4.0)
    assert math.copysign(1.0, page("atan2", y, x)) == math.copysign(1.0, expected("atan2", y, x))
    demand_close(page("hypot", y, x), expected("hypot", y, x), 3.0)


@given(st.floats(1e-6, 1e6), st.floats(-20.0, 20.0))
def test_powers_are_close_to_the_librarys(page, x, y):
    wanted = expected("pow", x, y)
    assert page("pow", x, y) == pytest.approx(wanted, rel=4e-16 * (4.0 + abs(y * math.log(x))))


@given(st.floats(-1e3, 1e3), st.integers(-8, 8))
def test_whole_powers_are_products(page, x, y):
    if x != 0.0:
        wanted = expected("pow", x, float(y))
        assert page("pow", x, float(y)) == pytest.approx(wanted, rel=2e-15)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_is_no_plain_number_is_answered_as_by_the_library(page, name):
    if FUNCTIONS[name].py_func.__code__.co_argcount == 1:
        for x in EXTREME:
            if name not in ("sin", "cos", "tan") or abs(x) < 1e6:
                wanted = expected(name, x)
                assert page(name, x) == pytest.approx(wanted, rel=1e-14, abs=1e-300, nan_ok=True)
        return
    for x in EXTREME:
        for y in EXTREME:
            wanted = expected(name, x, y)
            found = page(name, x, y)
            assert found == pytest.approx(wanted, rel=1e-12, abs=1e-300, nan_ok=True), (x, y)


def test_large_angles_are_taken_round(page):
    for x in (1e3, -12345.678, 1e6):
        assert page("sin", x) == pytest.approx(math.sin(x), abs=1e-9)
        assert page("cos", x) == pytest.approx(math.cos(x), abs=1e-9)
