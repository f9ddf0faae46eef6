"""Noise that is a hash: the same (seed, tick, agent, draw) gives the same number, always.

Nothing is drawn in order, so the order of agents, the number of threads and a restart from a
saved state cannot change it. The hash is the finaliser of SplitMix64 (Steele, Lea and Flood 2014)
applied to a counter, which is that generator read at a chosen place.
"""

from __future__ import annotations

import math

import numpy as np

from agents.engine.block import BodyMove, Decision
from agents.engine.cache import compile_to_disk
from agents.engine.own_parameters import may_be_positive
from agents.engine.vector_lanes import (
    as_float,
    as_unsigned,
    exponent,
    mantissa,
    power_of_two,
    where,
)
from worlds.compilation import PLAIN, compiled, plain_python

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
M1 = np.uint64(0xBF58476D1CE4E5B9)
M2 = np.uint64(0x94D049BB133111EB)
S27, S30, S31, S11 = np.uint64(27), np.uint64(30), np.uint64(31), np.uint64(11)
ONE = np.uint64(1)
DRAWS = np.uint64(16)
"""Draws reserved for each agent and tick: 0 to 3 are the engine's, 4 to 15 a rule's own."""

AT_ONCE = 65_536
"""Agents that are drawn for together, so that a large flock needs no more memory to start than to
run."""
BEYOND = 2**60
"""No run comes to this tick. From it on ticks stand for what is drawn beside the ticks of a run, so
that no number is drawn twice: see `ORDERS`, `GUSTS` and `agents.state.start.FIRST`."""
ORDERS = BEYOND
"""The first of the ticks of random orders, one for each tick of a run."""
GUSTS = 2 * BEYOND
"""The tick of all gusts; the tick at which a gust blows stands in place of an agent."""

ANGULAR, VECTORIAL = 0, 1
"""Kinds of noise: turn the wanted heading by an angle, or add a random vector to the mean."""

HALF_PI_HIGH = 1.57079632673412561417
HALF_PI_LOW = 6.07710050650619224932e-11
LN2_HIGH = 6.93147180369123816490e-01
LN2_LOW = 1.90821492927058770002e-10
INVERSE_LN2 = 1.44269504088896338700


@compiled
def mix(z):
    """The finaliser of SplitMix64: uint64 -> uint64, a bijection."""
    z = (z ^ (z >> S30)) * M1
    z = (z ^ (z >> S27)) * M2
    return z ^ (z >> S31)


@compiled
def tick_key(seed, tick):
    """Key of one tick's random numbers, uint64, from the run's seed (>= 0) and the tick (>= 0)."""
    return mix(mix(np.uint64(seed) + GOLDEN) + (np.uint64(tick) + ONE) * GOLDEN)


@compiled
def uniform(key, agent, draw):
    """A number uniform in [0, 1) for this tick's key, agent id and draw (0 to 15)."""
    counter = as_unsigned(agent) * DRAWS + np.uint64(draw)
    return as_float(mix(key + counter * GOLDEN) >> S11) * 2.0**-53


def uniform_numbers(
    seed: int, tick: int, ids: np.ndarray, draws: int, first: int = 0
) -> np.ndarray:
    """What `uniform` gives for agents (N,) and the draws from `first` on, (N, draws)."""
    numbers = np.empty((len(ids), draws))
    if fill_uniform.overloads and not PLAIN.get():
        fill_uniform(numbers, seed, tick, np.ascontiguousarray(ids, np.int64), first)
        return numbers
    with plain_python():
        key, draw = tick_key(seed, tick), np.arange(first, first + draws, dtype=np.uint64)
        for begin in range(0, len(ids), AT_ONCE):
            some = slice(begin, begin + AT_ONCE)
            counter = ids[some].astype(np.uint64)[:, None] * DRAWS + draw
            numbers[some] = (mix(key + counter * GOLDEN) >> S11) * 2.0**-53
    return numbers


@compile_to_disk
def fill_uniform(chance, seed, tick, ids, first):
    """The same for `chance` (N, draws): a tenth of the time, once it is compiled."""
    key = tick_key(seed, tick)
    for i in range(np.uintp(chance.shape[0])):
        for k in range(np.uintp(chance.shape[1])):
            chance[i, k] = uniform(key, ids[i], np.int64(first) + np.int64(k))


def compile_draws() -> None:
    """Have random numbers of many agents drawn by compiled code from now on: the same ones."""
    if not fill_uniform.overloads and not PLAIN.get():
        fill_uniform(np.empty((1, 1)), 0, 0, np.zeros(1, np.int64), 0)


@compiled
def cos_sin(angle):
    """Cosine and sine of |angle| <= 20 rad, within 2 units in the last place, without a branch.

    Of a larger angle they are those of one that differs from it by less than its last place.
    Argument reduction and polynomials are those of fdlibm; written out so that the bits do not
    depend on the machine's mathematical library.
    """
    quarter = math.floor(angle * (2.0 / math.pi) + 0.5)
    y = (angle - quarter * HALF_PI_HIGH) - quarter * HALF_PI_LOW
    z = y * y
    s = y + y * z * (
        -1.66666666666666324348e-01
        + z
        * (
            8.33333333332248946124e-03
            + z
            * (
                -1.98412698298579493134e-04
                + z
                * (
                    2.75573137070700676789e-06
                    + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
                )
            )
        )
    )
    c = (
        1.0
        - 0.5 * z
        + z
        * z
        * (
            4.16666666666666019037e-02
            + z
            * (
                -1.38888888888741095749e-03
                + z
                * (
                    2.48015872894767294178e-05
                    + z
                    * (
                        -2.75573143513906633035e-07
                        + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
                    )
                )
            )
        )
    )
    quadrant = quarter - 4.0 * math.floor(0.25 * quarter)
    is_odd = (quadrant == 1.0) | (quadrant == 3.0)
    cosine, sine = where(is_odd, s, c), where(is_odd, c, s)
    cosine = where((quadrant == 1.0) | (quadrant == 2.0), -cosine, cosine)
    sine = where(quadrant >= 2.0, -sine, sine)
    return cosine, sine


@compiled
def log(x):
    """The natural logarithm of a normal number x > 0, within 2 units in the last place.

    By the polynomial of fdlibm, for the reason of `cos_sin`.
    """
    m, k = mantissa(x), exponent(x)
    small = m < math.sqrt(0.5)
    m, k = where(small, 2.0 * m, m), where(small, k - 1.0, k)
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even_terms = w * (
        3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01)
    )
    odd_terms = z * (
        6.666666666666735130e-01
        + w
        * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01))
    )
    half = 0.5 * f * f
    return k * LN2_HIGH - ((half - (s * (half + even_terms + odd_terms) + k * LN2_LOW)) - f)


@compiled
def exp(x):
    """e^x of x <= 700, within 2 units in the last place; 0 below -700.

    By the rational function of fdlibm, for the reason of `cos_sin`.
    """
    k = math.floor(max(x, -700.0) * INVERSE_LN2 + 0.5)
    high, low = max(x, -700.0) - k * LN2_HIGH, k * LN2_LOW
    r = high - low
    t = r * r
    c = r - t * (
        1.66666666666666019037e-01
        + t
        * (
            -2.77777777770155933842e-03
            + t
            * (
                6.61375632143793436117e-05
                + t * (-1.65339022054652515390e-06 + t * 4.13813679705723846039e-08)
            )
        )
    )
    y = 1.0 - ((low - r * c / (2.0 - c)) - high)
    return where(x < -700.0, 0.0, y * power_of_two(k))


@compiled
def normal(key, agent, draw):
    """A normal number of deviation 1 for this tick's key, agent id and draws `draw`, `draw` + 1."""
    radius = math.sqrt(-2.0 * log(1.0 - uniform(key, agent, draw)))
    c, _ = cos_sin(2.0 * math.pi * uniform(key, agent, draw + 1))
    return radius * c


@compiled
def random_direction(key, agent, dim):
    """A unit vector, uniform on the circle (dim 2, draw 0) or the sphere (dim 3, draws 0 and 1)."""
    c, s = cos_sin(2.0 * math.pi * uniform(key, agent, 0))
    if dim == 2:
        return c, s, 0.0
    z = 2.0 * uniform(key, agent, 1) - 1.0
    rho = math.sqrt(max(0.0, 1.0 - z * z))
    return rho * c, rho * s, z


@compiled
def turn_by_noise(ux, uy, uz, eta, key, agent, dim):
    """A unit heading turned by angular noise of full width eta (rad).

    In 2-D by an angle uniform in [-eta/2, eta/2) (Vicsek et al. 1995; Liu et al. 2021 (6)); in 3-D
    to a direction uniform on the spherical cap of half-angle eta/2 about the heading, eta = 2 pi
    being the whole sphere.
    """
    if dim == 2:
        c, s = cos_sin(eta * (uniform(key, agent, 0) - 0.5))
        return c * ux - s * uy, s * ux + c * uy, 0.0
    edge, _ = cos_sin(0.5 * eta)
    along = 1.0 - uniform(key, agent, 1) * (1.0 - edge)
    sideways = math.sqrt(max(0.0, 1.0 - along * along))
    c, s = cos_sin(2.0 * math.pi * uniform(key, agent, 0))
    # An orthonormal pair across the heading, without a singular direction (Duff et al. 2017).
    sign = where(uz < 0.0, -1.0, 1.0)
    a = -1.0 / (sign + uz)
    b = ux * uy * a
    p, q = sideways * c, sideways * s
    return (
        along * ux + p * (1.0 + sign * ux * ux * a) + q * b,
        along * uy + p * sign * b + q * (sign + uy * uy * a),
        along * uz - p * sign * ux - q * uy,
    )


# From a rule's wish to the wanted heading: the noise, and what keeps a heading.

KEEP = 1e-12
"""A wish shorter than this has no direction: the heading is kept."""


@compiled
def add_heading_noise(me, wish, noise, eta, dim):
    """The wanted heading, a unit Wish: the wish with its noise; without a wish, the old one."""
    x, y, z = wish.x, wish.y, wish.z
    if noise == VECTORIAL and may_be_positive(eta):
        is_zero = (x * x + y * y + z * z < KEEP * KEEP) & (eta > 0.0)
        ex, ey, ez = random_direction(me.key, me.id, dim)
        x = where(is_zero, me.ux, x) + eta * ex
        y = where(is_zero, me.uy, y) + eta * ey
        z = where(is_zero, me.uz, z) + eta * ez
    length = math.sqrt(x * x + y * y + z * z)
    is_zero = length < KEEP
    length = where(is_zero, 1.0, length)
    x = where(is_zero, me.ux, x / length)
    y = where(is_zero, me.uy, y / length)
    z = where(is_zero, me.uz, z / length)
    if noise != VECTORIAL and may_be_positive(eta):
        x, y, z = turn_by_noise(x, y, z, eta, me.key, me.id, dim)
    return Decision(x, y, z)


# Wind: it carries all agents along in each tick, beside their own motion.

NO_WIND = np.empty((0, 3))
"""No wind."""


@compiled
def carry_with_wind(move, context, tick):
    """Where the wind of a tick has taken an agent that has moved so."""
    wind, at = context.wind, tick - context.since
    return BodyMove(
        move.x + wind[at, 0],
        move.y + wind[at, 1],
        move.z + wind[at, 2],
        move.ux,
        move.uy,
        move.uz,
        move.speed,
    )
