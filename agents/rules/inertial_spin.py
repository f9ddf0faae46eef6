"""The inertial spin model: neighbours turn an agent's spin, and its spin turns the agent.

Attanasi et al. 2014, "Information transfer and behavioural inertia in starling flocks", Nature
Physics 10, 691; equations as in Cavagna et al. 2015, "Flocking and turning: a new model for
self-organized collective motion", Journal of Statistical Physics 158, 601. The spin s of an agent
is to its heading what angular momentum is to an angle, and chi its inertia:

    dv/dt = (1 / chi) s x v
    ds/dt = v x [J / v_0^2 sum_j n_ij v_j - eta / v_0^2 dv/dt + xi / v_0]

with white noise xi, of variance 2 eta T per time in each component. Without inertia (chi to 0) this
is a Vicsek model in continuous time. In the plane s is across it, and the angle phi of the heading
goes by chi d^2 phi/dt^2 = J sum_j sin(phi_j - phi) - eta dphi/dt + noise.

A tick takes the torque first, then friction, noise and turning together, as their equations are
solved exactly (Uhlenbeck and Ornstein 1930, Physical Review 36, 823): so the temperature, and how
far an agent without neighbours turns at random, are right at any length of the tick. Without
friction and noise that is symplectic.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, is_neighbour
from agents.engine.noise import cos_sin, normal
from agents.engine.own_parameters import may_be_positive
from agents.engine.vector_lanes import is_any, where
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sums import of_pairs
from worlds.compilation import compiled

SMALL = 0.01
"""Of eta dt / chi, below which series are taken: differences of near numbers tell nothing."""
DRAW = 4
"""The first of the draws of a rule's own; each normal number takes two."""


class Spins(Parameters):
    """Parameters of the inertial spin model."""

    r: float = parameter(
        1.0,
        "Interaction radius: agents within it are neighbours, n_ij = 1",
        words="Vision radius",
        symbol="r",
        unit="length",
        low=0.05,
        high=50.0,
        step=0.1,
        source="Cavagna et al. 2015, metric n_ij; value ours",
    )
    J: float = parameter(
        1.0,
        "Strength of alignment",
        words="Alignment",
        symbol="J",
        low=0.0,
        high=20.0,
        step=0.1,
        source="Cavagna et al. 2015; value ours",
    )
    chi: float = parameter(
        1.0,
        "Generalised moment of inertia: how much spin it takes to turn",
        words="Inertia",
        symbol="\\chi",
        unit="s^2",
        low=0.001,
        high=100.0,
        proposed=(0.01, 20.0),
        step=0.05,
        source="Attanasi et al. 2014; value ours",
    )
    eta: float = parameter(
        0.1,
        "Friction of the spin",
        words="Friction of the spin",
        symbol="\\eta",
        unit="s",
        low=0.0,
        high=100.0,
        proposed=(0.01, 20.0),
        step=0.05,
        source="Cavagna et al. 2015; value ours",
    )
    T: float = parameter(
        0.01,
        "Generalised temperature: strength of the noise, which friction balances",
        words="Temperature",
        symbol="T",
        low=0.0,
        high=100.0,
        proposed=(0.001, 10.0),
        step=0.01,
        source="Cavagna et al. 2015; value ours",
        noise=True,
    )


@compiled
def cross(ax, ay, az, bx, by, bz):
    """a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@compiled
def friction_decay(a):
    """What friction leaves of a spin after a tick, and of it over the tick in the mean: e^-a and
    (1 - e^-a) / a, where a = eta dt / chi."""
    is_small = a < SMALL
    series = 1.0 - a * (1.0 / 2.0 - a * (1.0 / 6.0 - a * (1.0 / 24.0 - a / 120.0)))
    decay = where(is_small, 1.0 - a * series, math.exp(-a))
    return decay, where(is_small, series, (1.0 - decay) / a)


@compiled
def noise_shares(a, decay, mean):
    """What noise adds to a spin over a tick, in units of sqrt(T chi): its standard deviation, the
    share of it that the mean over the tick has, and the standard deviation of that mean's rest."""
    deviation = math.sqrt(a * mean * (1.0 + decay))
    series = a * (1.0 / 3.0 - a * (1.0 / 4.0 - a * 7.0 / 60.0))
    half = where(a < SMALL, series, (1.0 - mean) / a - 0.5 * mean * mean)
    rest_variance = 2.0 * half - a * mean * mean * mean / (1.0 + decay)
    return deviation, mean / (1.0 + decay), math.sqrt(max(rest_variance, 0.0))


@compiled
def random_torque(me, size, draw):
    """u x xi: normal, of standard deviation `size` along each axis across the heading.

    In the plane it is along z alone. Draws for space are left out where no agent is in space.
    """
    deviation = size * normal(me.key, me.id, draw)
    s = me.memory
    is_in_space = math.fabs(me.uz) + math.fabs(s[0]) + math.fabs(s[1]) > 0.0
    x, y, z = 0.0, 0.0, deviation
    if is_any(is_in_space):
        two, three = size * normal(me.key, me.id, draw + 2), size * normal(me.key, me.id, draw + 4)
        tx, ty, tz = cross(me.ux, me.uy, me.uz, deviation, two, three)
        x, y, z = where(is_in_space, tx, x), where(is_in_space, ty, y), where(is_in_space, tz, z)
    return x, y, z


@compiled
def turn_with(s, angle):
    """Turn the spin s[0:3] as its agent turns, about s[3:6] by so much for each unit of it."""
    size = math.sqrt(s[3] * s[3] + s[4] * s[4] + s[5] * s[5])
    length = where(size == 0.0, 1.0, size)
    ax, ay, az = s[3] / length, s[4] / length, s[5] / length
    c, si = cos_sin(angle * size)
    x, y, z = cross(ax, ay, az, s[0], s[1], s[2])
    along = (1.0 - c) * (ax * s[0] + ay * s[1] + az * s[2])
    s[0] = c * s[0] + si * x + along * ax
    s[1] = c * s[1] + si * y + along * ay
    s[2] = c * s[2] + si * z + along * az


@compiled
def term(me, other, p):
    """The heading of a neighbour: n_ij u_j."""
    n = is_neighbour(other, p.r)
    return n * other.ux, n * other.uy, n * other.uz


@compiled
def bring_spin_on(me, sums, p):
    """The spin after this tick, and its mean over it: ds/dt = J u x sum_j u_j - (eta / chi) s +
    u x xi.

    With dv/dt = s x v / chi the friction v x (eta / v_0^2) dv/dt is (eta / chi) s, as s stays
    across v.
    """
    tx, ty, tz = cross(me.ux, me.uy, me.uz, *sums)
    s = me.memory
    along = s[0] * me.ux + s[1] * me.uy + s[2] * me.uz  # 0 but where an edge has turned the heading
    a = p.eta * p.dt / p.chi
    decay, mean = friction_decay(a)
    h = p.J * p.dt
    x = s[0] - along * me.ux + h * tx
    y = s[1] - along * me.uy + h * ty
    z = s[2] - along * me.uz + h * tz
    nx = ny = nz = rx = ry = rz = share = 0.0
    size = math.sqrt(p.T * p.chi)
    if may_be_positive(a * size):
        deviation, share, rest_deviation = noise_shares(a, decay, mean)
        nx, ny, nz = random_torque(me, size * deviation, DRAW)
        rx, ry, rz = random_torque(me, size * rest_deviation, DRAW + 6)
    s[0], s[1], s[2] = decay * x + nx, decay * y + ny, decay * z + nz
    s[3] = mean * x + share * nx + rx
    s[4] = mean * y + share * ny + ry
    s[5] = mean * z + share * nz + rz
    if may_be_positive(a * size):
        turn_with(s, p.dt / p.chi)


@compiled
def answer(me, sums, surroundings, p):
    """dv/dt = (1 / chi) s x v, with the mean of s over the tick."""
    bring_spin_on(me, sums, p)
    h = p.v0 / p.chi
    s = me.memory
    x, y, z = cross(s[3], s[4], s[5], me.ux, me.uy, me.uz)
    return Decision(h * x, h * y, h * z)


RULE = Rule(
    name="inertial-spin",
    title="Inertial spin model",
    summary="Neighbours turn each other as in the Vicsek model, but against inertia: a turn runs "
    "through the flock as a wave, at constant speed, and does not fade.",
    equation=r"\frac{dv_i}{dt} = \frac{1}{\chi}\, s_i \times v_i, \qquad "
    r"\frac{ds_i}{dt} = v_i \times \Big[\frac{J}{v_0^2} \sum_j n_{ij} v_j - "
    r"\frac{\eta}{v_0^2} \frac{dv_i}{dt} + \frac{\xi_i}{v_0}\Big]",
    source="Attanasi et al. 2014; Cavagna et al. 2015",
    tags=("biology", "physics", "starling", "waves", "turning", "information"),
    parameters=Spins,
    **of_pairs(3, term, answer, by_lanes=True),
    wish="acceleration",
    memory=("spin_x", "spin_y", "spin_z", "mean_spin_x", "mean_spin_y", "mean_spin_z"),
    written=("mean_spin_x", "mean_spin_y", "mean_spin_z"),
    units={"spin": "s", "mean_spin": "s"},
    words={"spin": "spin", "mean_spin": "mean spin of a tick"},
    checked="a turn runs through the flock as a wave, the faster the stronger it is ordered "
    "(Attanasi et al. 2014, figures 2 and 4; a: exponent of distance over delay, c: speed of the "
    "wave): {attanasi2014#1}; {attanasi2014#3}; {attanasi2014#7} (`flockscope paper "
    "attanasi2014`)",
    tries=(
        LessonStep(
            "Heat it to T = 5.",
            "The order goes down, but not all of it: the alignment holds against the noise.",
            {"T": 5.0},
            LessonCheck("polarisation", "below", 0.6, 400),
        ),
        LessonStep(
            "Take the alignment away.",
            "Everybody wanders on its own.",
            {"J": 0.0},
            LessonCheck("polarisation", "below", 0.2, 400),
            anew=True,
        ),
        LessonStep(
            "Give everybody ten times the inertia.",
            "Turning takes so long that order has hardly begun at tick 400.",
            {"chi": 10.0},
            LessonCheck("polarisation", "below", 0.48, 400),
            anew=True,
        ),
    ),
)
