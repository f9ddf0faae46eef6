"""Mathematical functions for pages: every browser gives the same bits.

A browser's own `Math` differs from the next one's in the last bit, and a flock may be chaotic. What
a loop takes from a library of mathematics is taken from here instead in the module of a page. The
bits are not those of the library here, from which these functions differ by some units in the last
place: so much a page differs from a run anyway.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from agents.engine.noise import cos_sin, exp, log
from worlds.compilation import compiled, entry
from worlds.web_assembly import LinkedCode, linked_code

LARGEST_ANGLE = 20.0
"""Of `cos_sin`, rad."""
TURN_HIGH, TURN_MIDDLE, TURN_LOW = (
    6.28318530693650245667,
    2.43084020252158639064e-10,
    8.08906499484466582320e-21,
)
"""A full turn, rad: the first two of few bits each, so that a multiple of them is exact."""
LARGEST_EXPONENT = 700.0
"""Of `exp`."""
SMALLEST_NORMAL = 2.2250738585072014e-308
MORE_OF_HALF_PI = 6.123233995736765886e-17
"""What pi / 2 is more than the nearest double."""
HUGE, TINY = 1e150, 1e-150
"""Beyond them a square has no place in a double."""
POWERS = 64.0
"""Whole exponents up to which a power is made by multiplying."""


@entry
def page_exp(x):
    """e^x."""
    if abs(x) <= LARGEST_EXPONENT:
        return exp(x)
    if x != x:
        return x
    half = exp(0.5 * min(max(x, -1400.0), 1400.0))
    return half * half


@entry
def page_log(x):
    """The natural logarithm."""
    if x != x or x < 0.0:
        return math.nan
    if x == 0.0:
        return -math.inf
    if x == math.inf:
        return x
    if x < SMALLEST_NORMAL:
        return log(x * 2.0**54) - 54.0 * math.log(2.0)
    return log(x)


@compiled
def within_turns(angle):
    """An angle, rad, brought near to 0."""
    if abs(angle) <= LARGEST_ANGLE:
        return angle
    turns = np.floor(angle / (2.0 * math.pi) + 0.5)
    return ((angle - turns * TURN_HIGH) - turns * TURN_MIDDLE) - turns * TURN_LOW


@entry
def page_sin(x):
    """The sine; within 1e-9 of it up to 1e6 rad."""
    _, sine = cos_sin(within_turns(x))
    return sine


@entry
def page_cos(x):
    """The cosine; see `page_sin`."""
    cosine, _ = cos_sin(within_turns(x))
    return cosine


@entry
def page_tan(x):
    """The tangent; see `page_sin`."""
    cosine, sine = cos_sin(within_turns(x))
    return sine / cosine


@compiled
def arctangent(x):
    """The angle in [0, pi / 2] whose tangent is x >= 0: a rational function, as Cephes has it."""
    begins = more = 0.0
    if x > 2.41421356237309504880:
        begins, more, x = 0.5 * math.pi, MORE_OF_HALF_PI, -1.0 / x
    elif x > 0.66:
        begins, more, x = 0.25 * math.pi, 0.5 * MORE_OF_HALF_PI, (x - 1.0) / (x + 1.0)
    z = x * x
    top = -8.750608600031904122785e-1 * z - 1.615753718733365076637e1
    top = ((top * z - 7.500855792314704667340e1) * z - 1.228866684490136173410e2) * z
    bottom = (z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2
    bottom = (bottom * z + 4.328810604912902668951e2) * z + 4.853903996359136964868e2
    ratio = z * (top - 6.485021904942025371773e1) / (bottom * z + 1.945506571482613964425e2)
    return begins + ((x * ratio + x) + more)


@compiled
def angle_of(y, x):
    """The angle of the vector (x, y), rad, in [-pi, pi]."""
    if x != x or y != y:
        return math.nan
    across, along = abs(y), abs(x)
    if across == math.inf and along == math.inf:
        angle = 0.25 * math.pi
    elif across == 0.0:
        angle = 0.0
    elif along == 0.0:
        angle = 0.5 * math.pi
    else:
        angle = arctangent(across / along)
    if math.copysign(1.0, x) < 0.0:
        angle = math.pi - (angle - 2.0 * MORE_OF_HALF_PI)
    return math.copysign(angle, y)


@entry
def page_atan2(y, x):
    """The angle of the vector (x, y), rad."""
    return angle_of(y, x)


@entry
def page_atan(x):
    """The angle whose tangent is x, rad."""
    return angle_of(x, 1.0)


@entry
def page_acos(x):
    """The angle whose cosine is x, rad."""
    return 2.0 * angle_of(math.sqrt(1.0 - x), math.sqrt(1.0 + x))


@entry
def page_asin(x):
    """The angle whose sine is x, rad."""
    return angle_of(x, math.sqrt((1.0 - x) * (1.0 + x)))


@entry
def page_hypot(x, y):
    """The length of the vector (x, y)."""
    large, small = max(abs(x), abs(y)), min(abs(x), abs(y))
    if abs(x) == math.inf or abs(y) == math.inf:
        return math.inf
    if x != x or y != y:
        return math.nan
    if TINY < large < HUGE or large == 0.0:
        return math.sqrt(x * x + y * y)
    ratio = small / large
    return large * math.sqrt(1.0 + ratio * ratio)


@entry
def page_pow(x, y):
    """x to the power of y; exact to rounding for small whole y."""
    if y == 0.0 or x == 1.0:
        return 1.0
    if x != x or y != y:
        return math.nan
    is_whole = np.floor(y) == y
    if is_whole and abs(y) <= POWERS:
        power, factor, left = 1.0, x, int(abs(y))
        while left > 0:
            if left & 1:
                power *= factor
            factor *= factor
            left >>= 1
        return 1.0 / power if y < 0.0 else power
    if y == 0.5:
        return math.sqrt(x)
    size = abs(x)
    if x < 0.0 and not is_whole and size < math.inf and abs(y) < math.inf:
        return math.nan
    is_odd = is_whole and abs(y) < 2.0**53 and np.floor(0.5 * y) != 0.5 * y
    sign = -1.0 if x < 0.0 and is_odd else 1.0
    if size == 1.0:
        return sign
    if size == 0.0 or size == math.inf or abs(y) == math.inf:
        return sign * (math.inf if (size > 1.0) == (y > 0.0) else 0.0)
    scaled = size * 2.0**54 if size < SMALLEST_NORMAL else size
    shift = 54.0 * math.log(2.0) if size < SMALLEST_NORMAL else 0.0
    exponent = y * (log(scaled) - shift)
    half = exp(0.5 * min(max(exponent, -1400.0), 1400.0))
    return sign * half * half


FUNCTIONS = {
    "exp": page_exp,
    "log": page_log,
    "sin": page_sin,
    "cos": page_cos,
    "tan": page_tan,
    "atan": page_atan,
    "atan2": page_atan2,
    "acos": page_acos,
    "asin": page_asin,
    "hypot": page_hypot,
    "pow": page_pow,
}
"""By the names that libraries have for them."""


@functools.cache
def page_function(name: str) -> LinkedCode:
    """The code of one of FUNCTIONS. Raises InputError as `linked_code`."""
    python = FUNCTIONS[name].py_func
    return linked_code(FUNCTIONS[name], (0.0,) * python.__code__.co_argcount)
