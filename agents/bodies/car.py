"""A car with front wheels that steer, one motor, and a computer that sends it commands by radio.

The hardware of Jacobs and Koessler, section IV, and of their Flash simulation: the wheel points at
what the rule wishes as far as it can, the throttle is less the more it is turned. What the paper
does not give (lags, sizes, link) are the figures of such cars; each parameter says so.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal

from agents.bodies.car_commands import (
    FRESH,
    PACE,
    QUEUE,
    ROWS,
    SIGNALS,
    STEERING,
    STOPS,
    STUCK,
    WORDS,
    command,
    is_stopped,
    nearest_car,
    nearest_solid,
    queue_command,
    receive_command,
    roll,
    wheelbase,
)
from agents.bodies.tracking import Tracking
from agents.engine.block import BodyMove
from agents.models.declare import Body, Rule, Vehicle, parameter
from agents.models.model import Model
from worlds.compilation import compiled

CRASHES = 1.0
"""`contact` as compiled code has it."""
OURS = "ours: the figure of such cars; the paper gives none"


class Car(Tracking):
    """Parameters of the car."""

    v_max: float = parameter(
        1.0,
        "Speed at full throttle",
        words="Speed at full throttle",
        symbol="v_{max}",
        unit="m/s",
        low=0.05,
        high=10.0,
        step=0.05,
        source=OURS,
    )
    alpha_turn: float = parameter(
        0.4,
        "Share of the throttle that is taken off for each rad that the wheels are turned",
        words="Throttle off in turns",
        symbol="\\alpha",
        unit="1/rad",
        low=0.0,
        high=2.0,
        step=0.05,
        source="Jacobs and Koessler II, which gives no value",
    )
    wheel_max: float = parameter(
        45.0,
        "Largest angle of the front wheels",
        words="Largest wheel angle",
        symbol="\\delta_{max}",
        unit="deg",
        low=5.0,
        high=80.0,
        step=1.0,
        source="Jacobs and Koessler II: roughly 45 degrees",
    )
    circle: float = parameter(
        0.95,
        "Turning circle: its diameter, with the wheels turned as far as they go",
        words="Turning circle",
        symbol="d_{turn}",
        unit="m",
        low=0.05,
        high=10.0,
        step=0.05,
        source="Jacobs and Koessler V: a little less than one metre",
    )
    lag: float = parameter(
        0.15,
        "Time in which the motor closes 63 % of the gap to the wanted speed",
        words="Lag of the motor",
        symbol="\\tau_m",
        unit="s",
        low=0.0,
        high=2.0,
        step=0.01,
        source=OURS,
    )
    servo: float = parameter(
        7.0,
        "How fast the servo turns the wheels",
        words="Rate of the servo",
        symbol="\\omega_s",
        unit="rad/s",
        low=0.1,
        high=100.0,
        proposed=(0.5, 30.0),
        step=0.5,
        source=OURS,
    )
    latency: float = parameter(
        0.006,
        "Time from a frame to the command's leaving the computer",
        words="Latency",
        symbol="t_0",
        unit="s",
        low=0.0,
        high=0.1,
        step=0.001,
        source=OURS,
    )
    hop: float = parameter(
        0.007,
        "Time of a hop of the radio chain: car n hears its command after n of them; 0 for a "
        "broadcast. All in all no more than 23 ticks count",
        words="Time of a radio hop",
        symbol="t_{hop}",
        unit="s",
        low=0.0,
        high=0.1,
        step=0.001,
        source="Jacobs and Koessler IV.A: up to 7 ms",
    )
    loss: float = parameter(
        0.0,
        "Share of the commands that are lost: the car goes on with the last that came",
        words="Commands lost",
        symbol="p_{loss}",
        low=0.0,
        high=1.0,
        step=0.01,
        source="Jacobs and Koessler IV.A: without a value",
        noise=True,
    )
    length: float = parameter(
        0.22,
        "Length of the body",
        words="Length",
        symbol="a",
        unit="m",
        low=0.01,
        high=2.0,
        step=0.01,
        source=OURS,
    )
    width: float = parameter(
        0.12,
        "Width of the body",
        words="Width",
        symbol="b",
        unit="m",
        low=0.01,
        high=2.0,
        step=0.01,
        source=OURS,
    )
    contact: Literal["stops", "crashes"] = parameter(
        "stops",
        "What happens where bodies touch: they stop each other as real ones do, or both are out "
        "of the run",
        words="Contact",
        symbol="contact",
        source="Jacobs and Koessler V: after a head-on collision cars are stuck",
    )
    reverse: bool = parameter(
        False,
        "Whether a car that has not moved for half a second backs out for a second",
        words="Backs out",
        symbol="rev",
        source="Jacobs and Koessler V: the throttle never becomes negative",
    )
    yields: bool = parameter(
        False,
        "Whether a car looks ahead and brakes, swerves or backs out rather than touch another",
        words="Yields",
        symbol="yield",
        source="added to Jacobs and Koessler; see docs/cars.md",
    )
    ahead: float = parameter(
        1.0,
        "How far it looks ahead",
        words="Looks ahead",
        symbol="t_a",
        unit="s",
        low=0.1,
        high=5.0,
        step=0.1,
        source="added to Jacobs and Koessler",
    )
    margin: float = parameter(
        0.06,
        "Distance between bodies that it then keeps",
        words="Margin",
        symbol="d_y",
        unit="m",
        low=0.0,
        high=1.0,
        proposed=(0.0, 0.3),
        step=0.01,
        source="added to Jacobs and Koessler",
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """One tick: command, radio delay, servo, motor, then rolling if nothing is in the way."""
    base = out.shape[0] - ROWS
    ready = 1.0 - me.signal[base + FRESH]
    wheel, throttle = command(me, near, surroundings, want, p, base, out)
    queue_command(me, wheel, throttle, p, base, out)
    wheel, throttle = receive_command(me, p, base, out)
    servo_step = p.servo * p.dt
    steering = ready * me.signal[base + STEERING]
    steering += min(max(wheel - steering, -servo_step), servo_step)
    speed = me.speed + (p.v_max * throttle - me.speed) * (1.0 - math.exp(-p.dt / p.lag))
    x, y, ux, uy = roll(me.x, me.y, me.ux, me.uy, speed, steering, wheelbase(p), p.dt)
    stops = ready * me.signal[base + STOPS]
    if is_stopped(me, near, surroundings, x, y, ux, uy, p):
        x, y, ux, uy, speed = me.x, me.y, me.ux, me.uy, 0.0
        stops += 1.0
    out[base + FRESH] = 0.0
    out[base + STEERING] = steering
    out[base + PACE] = speed
    out[base + STOPS] = stops
    return BodyMove(x, y, me.z, ux, uy, 0.0, speed)


@compiled
def touches(me, near, surroundings, p):
    """1.0 if the body touches another car's, 2.0 if it touches what is solid, else 0.0.

    Bodies are rectangles. Where they only stop each other, nobody crashes.
    """
    if p.contact != CRASHES:
        return 0.0
    if nearest_car(me, near, me.x, me.y, me.ux, me.uy, p) <= 0.0:
        return 1.0
    return 2.0 if nearest_solid(surroundings, me.x, me.y, me.ux, me.uy, p) <= 0.0 else 0.0


@compiled
def measure(me, near, p, out):
    """Distance of the body to the nearest other one, m; inf for one that is alone."""
    out[0] = nearest_car(me, near, me.x, me.y, me.ux, me.uy, p)


BODY = Body(
    name="car",
    title="Car",
    source="Jacobs and Koessler, sections II and IV",
    parameters=Car,
    move=move,
    takes="velocity",
    signals=SIGNALS,
    size="length",
    touches=touches,
    measures=("clearance",),
    measure=measure,
    units={
        SIGNALS[STEERING]: "rad",
        SIGNALS[PACE]: "m/s",
        SIGNALS[STUCK]: "s",
        **dict.fromkeys((name for name in SIGNALS if name.startswith("wheel")), "rad"),
        "clearance": "m",
    },
    words={**WORDS, "clearance": "room to the next car"},
    sees_obstacles=True,
    stops=True,
    lasts=lambda p: p.dt,
    unit="s",
    vehicle=Vehicle(
        fresh=SIGNALS[FRESH],
        steering=SIGNALS[STEERING],
        pace=SIGNALS[PACE],
        stuck=SIGNALS[STUCK],
        wheel=SIGNALS[QUEUE],
        throttle=SIGNALS[QUEUE + 1],
    ),
)
STEERED = replace(BODY, name="steered-car", takes="heading")
"""The same car for rules that wish a heading; of a wish only the direction counts for either."""


def driving(rule: Rule, **more: Any) -> Model:
    """The model NAME-cars: cars driven by a rule that wishes a heading or a velocity.

    `more` goes to the model; cars are on a plane, whatever the rule can do, and what there is to
    try with the rule need not come true of them.
    """
    shared_names = sorted(
        set(rule.parameters.model_fields) & set(Car.model_fields) - set(Tracking.model_fields)
    )
    if shared_names:
        raise TypeError(f"rule {rule.name} and the car both have a parameter {shared_names[0]}")
    body = STEERED if rule.wish == "heading" else BODY
    return Model(
        replace(rule, dimensions=(2,)),
        body,
        suffix="-cars",
        title_suffix=", driven by cars",
        summary_suffix=" Here cars with a turning circle, lags and a radio link carry it out.",
        **{"tries": (), **more},
    )
