"""The simple vehicle of Reynolds 1999: a point mass with a largest force and a largest speed.

Its least speed, for animals that cannot stop in the air, and `guard`, which keeps it out of what is
solid, are additions.
"""

from __future__ import annotations

import math

from agents.bodies.guard import guard_velocity
from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled
from worlds.queries.surroundings import surface_within


class SteeredVehicle(Parameters):
    """Parameters of the simple vehicle; its mass is 1."""

    dt: float = parameter(
        0.05,
        "Time of a tick",
        words="Time of a tick",
        symbol="\\Delta t",
        unit="s",
        low=0.001,
        high=1.0,
        step=0.01,
        source="chosen here; the step of Reynolds 1999 is a frame",
    )
    max_force: float = parameter(
        8.0,
        "Largest steering force, per mass",
        words="Largest force",
        symbol="F",
        unit="length/s^2",
        low=0.01,
        high=100.0,
        proposed=(0.5, 30.0),
        step=0.1,
        source="Reynolds 1999, simple vehicle model; value chosen here",
    )
    max_speed: float = parameter(
        4.0,
        "Largest speed",
        words="Largest speed",
        symbol="v_{max}",
        unit="length/s",
        low=0.01,
        high=100.0,
        proposed=(0.2, 10.0),
        step=0.1,
        source="Reynolds 1999, simple vehicle model; value chosen here",
    )
    min_speed: float = parameter(
        2.0,
        "Least speed, except where the guard holds a boid back; max_speed if that is less",
        words="Least speed",
        symbol="v_{min}",
        unit="length/s",
        low=0.0,
        high=100.0,
        proposed=(0.0, 6.0),
        step=0.1,
        source="added to Reynolds 1999",
    )
    margin: float = parameter(
        0.4,
        "Distance to a surface at which the guard takes out the velocity towards it, at half of it "
        "all",
        words="Margin of the guard",
        symbol="d^{guard}",
        unit="length",
        low=0.001,
        high=20.0,
        step=0.05,
        source="added to Reynolds 1999",
    )
    guard: bool = parameter(
        True,
        "Whether velocity towards a surface is taken out close to it, so that no boid enters it",
        words="Guard",
        symbol="g",
        source="added to Reynolds 1999",
    )


@compiled
def steer(me, want, p):
    """Heading and speed after a tick: v + dt a, |a| <= F, then min <= |v| <= max: four numbers."""
    force = math.sqrt(want.x * want.x + want.y * want.y + want.z * want.z)
    h = p.dt * (p.max_force / force if force > p.max_force else 1.0)
    vx = me.speed * me.ux + h * want.x
    vy = me.speed * me.uy + h * want.y
    vz = me.speed * me.uz + h * want.z
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    bounded = min(max(speed, p.min_speed), p.max_speed)
    if speed == 0.0:
        return me.ux, me.uy, me.uz, bounded
    return vx / speed, vy / speed, vz / speed, bounded


@compiled
def move(me, near, surroundings, want, p, out):
    """Velocity, then position; at rest the heading is kept."""
    ux, uy, uz, speed = steer(me, want, p)
    if p.guard > 0.0:
        step = p.dt * speed
        reach = max(p.margin, 2.0 * step)
        at = surface_within(surroundings, me.x, me.y, me.z, reach)
        if at.distance <= reach:
            gx, gy, gz = guard_velocity(
                surroundings, at, me, step * ux, step * uy, step * uz, reach
            )
            step = math.sqrt(gx * gx + gy * gy + gz * gz)
            speed = step / p.dt
            if step > 0.0:
                ux, uy, uz = gx / step, gy / step, gz / step
    step_length = p.dt * speed
    return BodyMove(
        me.x + step_length * ux, me.y + step_length * uy, me.z + step_length * uz, ux, uy, uz, speed
    )


@compiled
def passes(p):
    """Whether it goes through what is solid, as in the paper's literal text."""
    return p.guard == 0.0


BODY = Body(
    name="steered",
    title="Simple vehicle",
    source="Reynolds 1999, simple vehicle model",
    parameters=SteeredVehicle,
    move=move,
    takes="acceleration",
    sees_obstacles=True,
    passes=passes,
    passes_with="guard = false",
    lasts=lambda p: p.dt,
    unit="s",
)
