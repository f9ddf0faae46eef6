"""A body with inertia: an acceleration changes its velocity, up to a largest speed (2).

The velocity itself is clamped, before the position follows it. Clamping only what the position
follows, or letting it follow the old velocity, takes agents into each other.
"""

from __future__ import annotations

import math

from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled


class DoubleIntegrator(Parameters):
    """Parameters of the double integrator."""

    p_max: float = parameter(
        5.0,
        "Largest speed",
        words="Largest speed",
        symbol="p^{max}",
        unit="m/s",
        low=0.1,
        high=50.0,
        step=0.5,
        source="Wu et al. 2023, (2), table 3",
    )
    dt: float = parameter(
        0.1,
        "The paper's step: within it, an agent counts on moving on unhindered",
        words="Step",
        symbol="\\Delta t",
        unit="s",
        low=0.001,
        high=1.0,
        step=0.01,
        source="Wu et al. 2023, (12), (18), table 3",
    )
    n_sub: float = parameter(
        5.0,
        "Ticks per step: each tick, agents look, decide and move on by dt / n_sub seconds",
        words="Ticks per step",
        symbol="n_{sub}",
        low=1.0,
        high=100.0,
        step=1.0,
        source="added to Wu et al. 2023, whose step is one tick",
    )


@compiled
def tick_length(p):
    """Seconds per tick: dt over the nearest whole number to n_sub."""
    return p.dt / math.floor(p.n_sub + 0.5)


def seconds_per_tick(p: DoubleIntegrator) -> float:
    """The same for the parameters as users give them."""
    return p.dt / math.floor(p.n_sub + 0.5)


@compiled
def move(me, near, surroundings, want, p, out):
    """p += h u, |p| <= p_max, q += h p (2) with h seconds per tick. At rest the heading is kept."""
    h = tick_length(p)
    vx = me.speed * me.ux + h * want.x
    vy = me.speed * me.uy + h * want.y
    vz = me.speed * me.uz + h * want.z
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    if speed == 0.0:
        return BodyMove(me.x, me.y, me.z, me.ux, me.uy, me.uz, 0.0)
    ux, uy, uz = vx / speed, vy / speed, vz / speed
    speed = min(speed, p.p_max)
    step_length = h * speed
    return BodyMove(
        me.x + step_length * ux, me.y + step_length * uy, me.z + step_length * uz, ux, uy, uz, speed
    )


BODY = Body(
    name="double-integrator",
    title="Double integrator",
    source="Wu et al. 2023, (1), (2)",
    parameters=DoubleIntegrator,
    move=move,
    takes="acceleration",
    stride=lambda p: p.p_max * seconds_per_tick(p),
    lasts=seconds_per_tick,
    unit="s",
)
