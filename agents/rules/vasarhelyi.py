"""Flocking of real drones: repulsion, alignment by a braking curve, shill agents at every surface.

Vasarhelyi et al. 2018, "Optimized flocking of autonomous drones in confined environments", Science
Robotics 3, eaat3536. The equations are those of the paper as two public implementations repeat
them: robotsim (github.com/csviragh/robotsim), the authors' own simulator, and SwarmLab
(github.com/lis-epfl/swarmlab; Soria et al. 2020). The paper's table of optimised parameters was not
at hand: each parameter below says which of them its default is from.

The paper adds up a shill agent for each wall and each obstacle. Here there is one, at the nearest
surface.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, adjacent
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from worlds.compilation import compiled
from worlds.queries.surroundings import solids_around, surface

FORCES = ("self-propulsion", "repulsion", "alignment", "shill")
"""The terms of the wanted velocity, m/s."""

ROBOTSIM = "robotsim of Vasarhelyi et al. 2018: parameters"
SWARMLAB = (
    "SwarmLab, parameters/param_swarm/param_vasarhelyi.m, which does not say for what v^flock; not "
    "checked against the paper's table"
)


class Drones(Parameters):
    """Parameters of the flocking of drones."""

    r: float = parameter(
        100.0,
        "Range of communication, and distance within which surfaces are noticed",
        words="Range of communication",
        symbol="r^c",
        unit="m",
        low=1.0,
        high=500.0,
        proposed=(10.0, 300.0),
        step=1.0,
        source=f"{ROBOTSIM}/unitparams.dat, R_C",
    )
    v_flock: float = parameter(
        4.0,
        "Speed at which a drone flies on its own",
        words="Speed",
        symbol="v^{flock}",
        unit="m/s",
        low=0.0,
        high=32.0,
        proposed=(0.0, 16.0),
        step=0.1,
        source=f"Vasarhelyi et al. 2018 (flights at 4, 6, 8 m/s); {ROBOTSIM}/flockingparams.dat",
    )
    r0_rep: float = parameter(
        25.6668,
        "Distance within which neighbours repel each other",
        words="Radius of the repulsion",
        symbol="r_0^{rep}",
        unit="m",
        low=0.0,
        high=200.0,
        proposed=(0.0, 100.0),
        step=0.1,
        source=f"{ROBOTSIM}/flockingparams.dat, R_0 (at 4 m/s); SwarmLab has 25",
    )
    p_rep: float = parameter(
        0.13,
        "Strength of the repulsion: speed per metre that a neighbour is too close",
        words="Repulsion",
        symbol="p^{rep}",
        unit="1/s",
        low=0.0,
        high=5.0,
        proposed=(0.0, 1.0),
        step=0.01,
        source="DANCERS (github.com/Chroma-CITI/DANCERS), config_robotsim_default.yaml, whose "
        "braking curve of the alignment is SwarmLab's; SwarmLab has 0.03; not checked against the "
        "paper's table",
    )
    r0_frict: float = parameter(
        85.3,
        "Distance up to which all difference in velocity beyond the slack is taken out",
        words="Radius of the alignment",
        symbol="r_0^{frict}",
        unit="m",
        low=0.0,
        high=500.0,
        proposed=(0.0, 200.0),
        step=0.1,
        source=SWARMLAB,
    )
    c_frict: float = parameter(
        0.05,
        "Strength of the alignment, of the difference in velocity that is too much",
        words="Alignment",
        symbol="C^{frict}",
        low=0.0,
        high=2.0,
        proposed=(0.0, 0.5),
        step=0.01,
        source=SWARMLAB,
    )
    v_frict: float = parameter(
        0.63,
        "Slack: difference in velocity that is always allowed",
        words="Slack of the alignment",
        symbol="v^{frict}",
        unit="m/s",
        low=0.0,
        high=10.0,
        proposed=(0.0, 5.0),
        step=0.01,
        source=SWARMLAB,
    )
    p_frict: float = parameter(
        3.2,
        "Slope of the braking curve of the alignment near its stopping point",
        words="Slope of the alignment",
        symbol="p^{frict}",
        unit="1/s",
        low=0.01,
        high=20.0,
        proposed=(0.2, 10.0),
        step=0.1,
        source=SWARMLAB,
    )
    a_frict: float = parameter(
        4.16,
        "Deceleration of the braking curve of the alignment",
        words="Braking of the alignment",
        symbol="a^{frict}",
        unit="m/s^2",
        low=0.01,
        high=50.0,
        proposed=(0.2, 12.0),
        step=0.01,
        source=SWARMLAB,
    )
    r0_shill: float = parameter(
        0.3,
        "Distance to a surface at which the velocity of the shill agent is to be taken on",
        words="Distance to walls",
        symbol="r_0^{shill}",
        unit="m",
        low=0.0,
        high=50.0,
        step=0.01,
        source=SWARMLAB,
    )
    v_shill: float = parameter(
        13.6,
        "Speed of the shill agents away from the surface",
        words="Speed of the shill agents",
        symbol="v^{shill}",
        unit="m/s",
        low=0.0,
        high=100.0,
        proposed=(0.0, 40.0),
        step=0.1,
        source=SWARMLAB,
    )
    p_shill: float = parameter(
        3.55,
        "Slope of the braking curve of the shill agents near its stopping point",
        words="Slope at walls",
        symbol="p^{shill}",
        unit="1/s",
        low=0.01,
        high=20.0,
        proposed=(0.2, 10.0),
        step=0.1,
        source=SWARMLAB,
    )
    a_shill: float = parameter(
        3.02,
        "Deceleration of the braking curve of the shill agents",
        words="Braking at walls",
        symbol="a^{shill}",
        unit="m/s^2",
        low=0.01,
        high=50.0,
        proposed=(0.2, 12.0),
        step=0.01,
        source=SWARMLAB,
    )


@compiled
def braking(r, a, p):
    """D(r, a, p), m/s: the speed from which one can still stop within r (m).

    Zero up to r = 0, then r p up to the speed a / p, then sqrt(2 a r - a^2 / p^2): deceleration a,
    with a soft end.
    """
    linear = p * max(r, 0.0)
    root = math.sqrt(max(0.0, 2.0 * a * r - a * a / (p * p)))
    return linear if linear < a / p else root


@compiled
def neighbourly(me, near, p):
    """Repulsion and alignment, summed over the neighbours: six numbers, m/s.

    v^rep = p^rep (r_0^rep - r_ij) along x_i - x_j within r_0^rep; v^frict = C^frict (v_ij - most)
    along v_j - v_i, if the difference v_ij is more than most = max(v^frict, D(r_ij - r_0^frict)).
    """
    vx, vy, vz = me.speed * me.ux, me.speed * me.uy, me.speed * me.uz
    speed = near.speed
    rx = ry = rz = fx = fy = fz = 0.0
    for j in range(near.n):
        dx = me.x - near.x[j]
        dy = me.y - near.y[j]
        dz = me.z - near.z[j]
        is_visible = adjacent(me, near, j, p.r)
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        push = is_visible * p.p_rep * max(0.0, p.r0_rep - d) / (d if d > 0.0 else 1.0)
        rx += push * dx
        ry += push * dy
        rz += push * dz
        wx = speed[j] * near.ux[j] - vx
        wy = speed[j] * near.uy[j] - vy
        wz = speed[j] * near.uz[j] - vz
        w = math.sqrt(wx * wx + wy * wy + wz * wz)
        slack_speed = max(p.v_frict, braking(d - p.r0_frict, p.a_frict, p.p_frict))
        pull = is_visible * p.c_frict * max(0.0, w - slack_speed) / (w if w > 0.0 else 1.0)
        fx += pull * wx
        fy += pull * wy
        fz += pull * wz
    return rx, ry, rz, fx, fy, fz


@compiled
def shill(me, surroundings, p):
    """v^wall and v^obst, m/s: alignment, without slack and in full, to a shill agent per solid.

    It stands at the solid's nearest place and flies with v^shill along the normal away from it.
    """
    x = y = z = 0.0
    nearby = solids_around(surroundings, me.x, me.y)
    for k in range(nearby.number):
        at = surface(surroundings, nearby, k, me.x, me.y, me.z)
        if at.distance <= p.r:
            wx = p.v_shill * at.nx - me.speed * me.ux
            wy = p.v_shill * at.ny - me.speed * me.uy
            wz = p.v_shill * at.nz - me.speed * me.uz
            w = math.sqrt(wx * wx + wy * wy + wz * wz)
            slack_speed = braking(at.distance - p.r0_shill, p.a_shill, p.p_shill)
            pull = max(0.0, w - slack_speed) / (w if w > 0.0 else 1.0)
            x += pull * wx
            y += pull * wy
            z += pull * wz
    return x, y, z


@compiled
def decide(me, near, surroundings, p):
    """The wanted velocity before it is cut at v^max; at rest, self-propulsion is ahead."""
    rx, ry, rz, fx, fy, fz = neighbourly(me, near, p)
    sx, sy, sz = shill(me, surroundings, p)
    return Decision(
        p.v_flock * me.ux + rx + fx + sx,
        p.v_flock * me.uy + ry + fy + sy,
        p.v_flock * me.uz + rz + fz + sz,
    )


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of the wanted velocity, m/s, in the order of FORCES."""
    out[0, 0], out[0, 1], out[0, 2] = p.v_flock * me.ux, p.v_flock * me.uy, p.v_flock * me.uz
    rx, ry, rz, fx, fy, fz = neighbourly(me, near, p)
    out[1, 0], out[1, 1], out[1, 2] = rx, ry, rz
    out[2, 0], out[2, 1], out[2, 2] = fx, fy, fz
    out[3, 0], out[3, 1], out[3, 2] = shill(me, surroundings, p)


VASARHELYI = Rule(
    name="vasarhelyi",
    title="Drones of Vasarhelyi et al.",
    summary="Drones keep their distance and match velocities as far as they could still brake; "
    "walls and obstacles are agents that fly away from the surface.",
    equation=r"\tilde v_i = v^{flock}\frac{v_i}{|v_i|} + \sum_{r_{ij} < r_0^{rep}} p^{rep}"
    r"(r_0^{rep} - r_{ij})\,\hat r_{ij} + C^{frict}\sum_{j} \big(v_{ij} - \max(v^{frict}, "
    r"D(r_{ij} - r_0^{frict}, a^{frict}, p^{frict}))\big)_+ \frac{v_j - v_i}{v_{ij}} + "
    r"\big(v_{is} - D(r_{is} - r_0^{shill}, a^{shill}, p^{shill})\big)_+ "
    r"\frac{v_s - v_i}{v_{is}}",
    source="Vasarhelyi et al. 2018, as in robotsim and SwarmLab",
    checked="{vasarhelyi2018#1}; {vasarhelyi2018#2} (`flockscope paper vasarhelyi2018`)",
    tags=("robotics", "drones", "quadcopters", "traffic", "collisions"),
    parameters=Drones,
    decide=decide,
    sifts=True,
    wish="velocity",
    forces=FORCES,
    explain=explain,
    sees_obstacles=True,
    led=False,
    tries=(
        LessonStep(
            "Take the alignment away.",
            "Drones bounce from wall to wall, each on its own course.",
            {"c_frict": 0.0},
            LessonCheck("polarisation", "below", 0.65, 400),
        ),
        LessonStep(
            "Take the repulsion away.",
            "They still fly one way, but nearest drones come into one another: nobody keeps a "
            "distance.",
            {"p_rep": 0.0},
            LessonCheck("nearest-neighbour", "falls", 0.8, 400),
        ),
        LessonStep(
            "Make the repulsion about eight times as strong.",
            "The flock spreads out: nearest drones are nearly twice as far apart.",
            {"p_rep": 1.0},
            LessonCheck("nearest-neighbour", "rises", 0.4, 400),
        ),
    ),
)
