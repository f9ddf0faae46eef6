"""A drone that takes on the wanted velocity, as fast as its controller and motors allow.

The robot model of Vasarhelyi et al. 2018, who have it from Viragh et al. 2014, without what makes
it a real one: no delay of communication, no noise of the satellite positions, no noise in the
acceleration, no wind, no lost packets, and sensors that are read at every tick. The position
follows the new velocity. `guard` is an addition.
"""

from __future__ import annotations

import math
from typing import Any

from agents.bodies.guard import guard_velocity
from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, Rule, declared, parameter
from agents.models.model import Model
from worlds.compilation import compiled
from worlds.queries.surroundings import surface_within


class Drone(Parameters):
    """Parameters of the drone."""

    dt: float = parameter(
        0.1,
        "Time of a tick: the drone looks, decides and moves on",
        words="Time of a tick",
        symbol="\\Delta t",
        unit="s",
        low=0.001,
        high=0.5,
        step=0.01,
        source="chosen here; robotsim moves on every 0.01 s and decides every 0.2 s",
    )
    tau: float = parameter(
        1.0,
        "Relaxation time of the velocity",
        words="Relaxation time",
        symbol="\\tau^{pid}",
        unit="s",
        low=0.5,
        high=10.0,
        step=0.1,
        source="robotsim of Vasarhelyi et al. 2018: parameters/unitparams.dat, tau_PID_XY",
    )
    a_max: float = parameter(
        6.0,
        "Largest acceleration",
        words="Largest acceleration",
        symbol="a^{max}",
        unit="m/s^2",
        low=0.01,
        high=50.0,
        proposed=(0.5, 20.0),
        step=0.05,
        source="robotsim of Vasarhelyi et al. 2018: parameters/unitparams.dat, a_max",
    )
    v_max: float = parameter(
        6.0,
        "Speed at which the wanted velocity is cut",
        words="Largest speed",
        symbol="v^{max}",
        unit="m/s",
        low=0.01,
        high=50.0,
        proposed=(0.5, 20.0),
        step=0.1,
        source="robotsim of Vasarhelyi et al. 2018: src/algo_spp_evol.c, V_Max at 4 m/s",
    )
    margin: float = parameter(
        1.0,
        "Distance to a surface at which the guard takes out the velocity towards it, at half of it "
        "all",
        words="Margin of the guard",
        symbol="d^{guard}",
        unit="m",
        low=0.001,
        high=20.0,
        step=0.05,
        source="added to Vasarhelyi et al. 2018",
    )
    guard: bool = parameter(
        True,
        "Whether velocity towards a surface is taken out close to it, so that no drone enters it",
        words="Guard",
        symbol="g",
        source="added to Vasarhelyi et al. 2018",
    )


@compiled
def follow_velocity(me, want, p):
    """Velocity (m/s) after a tick: v + dt / tau (v^d - v), |change| <= a^max dt, |v^d| <= v^max."""
    wanted_speed = math.sqrt(want.x * want.x + want.y * want.y + want.z * want.z)
    cut = p.v_max / wanted_speed if wanted_speed > p.v_max else 1.0
    vx, vy, vz = me.speed * me.ux, me.speed * me.uy, me.speed * me.uz
    share = p.dt / p.tau
    ax = share * (cut * want.x - vx)
    ay = share * (cut * want.y - vy)
    az = share * (cut * want.z - vz)
    change = math.sqrt(ax * ax + ay * ay + az * az)
    speed_step = p.a_max * p.dt
    slow = speed_step / change if change > speed_step else 1.0
    return vx + slow * ax, vy + slow * ay, vz + slow * az


@compiled
def move(me, near, surroundings, want, p, out):
    """Velocity, then position; at rest the heading is kept."""
    vx, vy, vz = follow_velocity(me, want, p)
    if p.guard > 0.0:
        step = p.dt * math.sqrt(vx * vx + vy * vy + vz * vz)
        reach = max(p.margin, 2.0 * step)
        at = surface_within(surroundings, me.x, me.y, me.z, reach)
        if at.distance <= reach:
            gx, gy, gz = guard_velocity(
                surroundings, at, me, p.dt * vx, p.dt * vy, p.dt * vz, reach
            )
            vx, vy, vz = gx / p.dt, gy / p.dt, gz / p.dt
    x, y, z = me.x + p.dt * vx, me.y + p.dt * vy, me.z + p.dt * vz
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    if speed == 0.0:
        return BodyMove(x, y, z, me.ux, me.uy, me.uz, 0.0)
    return BodyMove(x, y, z, vx / speed, vy / speed, vz / speed, speed)


@compiled
def passes(p):
    """Whether it goes through what is solid, as in the paper's literal text."""
    return p.guard == 0.0


BODY = Body(
    name="drone",
    title="Drone",
    source="Vasarhelyi et al. 2018, robot model; robotsim, src/robotmodel.c",
    parameters=Drone,
    move=move,
    takes="velocity",
    sees_obstacles=True,
    passes=passes,
    passes_with="guard = false",
    lasts=lambda p: p.dt,
    unit="s",
    family="aircraft",
)


def scale_to_tenth(rule: Rule, **more: Any) -> Model:
    """The model NAME-tenth: drones and flight at a tenth of the size, for small worlds.

    Every default in m, m/s and m/s^2 is divided by 10 and time goes on as before: in a world that
    is as much smaller the motion is the same. `more` goes to the model.
    """
    parameters = declared(rule.parameters) + declared(Drone)
    small = {
        declaration.name: declaration.default / 10.0
        for declaration in parameters
        if declaration.unit in ("m", "m/s", "m/s^2")
    }
    return Model(
        rule,
        BODY,
        suffix="-tenth",
        title_suffix=" at a tenth of the size",
        summary_suffix=" All lengths are a tenth of the real ones.",
        defaults=small,
        world="obstacles",
        agents=30,
        **more,
    )
