"""Trim by periodic shooting: the flap amplitude and the tail angle at which a flight repeats.

Unknown are the amplitude A, the tail angle and what the state is at the start of a wing beat (u, w,
q, theta and the slowed inflows); demanded are that all of the state comes back after the beat, that
the aircraft has not climbed and that it has gone as far as its speed says. Newton's method finds
them, with derivatives by differences of flights that share their steps; where it does not get there
at once, it is led there from a flight that is known, one step of speed, frequency and twist after
another.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import root

from agents.flight.air_forces import Flapping
from agents.flight.aircraft import Aircraft, demand_possible
from agents.flight.flight_motion import (
    MOVING,
    RELATIVE,
    SIZE,
    Controls,
    FlightTrack,
    X,
    Z,
    integrate,
    level,
)
from agents.flight.power import FlightHistory, history, readings
from worlds.input_error import InputError

# Stability of a periodic flight: Floquet's multipliers.

MULTIPLIER_STEP = 1e-5
"""Difference of the state, m/s, rad/s and rad, by which the derivative is taken."""


def monodromy(craft: Aircraft, controls: Controls, start: np.ndarray) -> np.ndarray:
    """What a wing beat makes of a small difference in u, w, q, theta and the slowed inflows.

    `start` is the state (SIZE,) at the beginning of a beat; returns a matrix in the order of
    `motion.MOVING`, taken by central differences. Raises InputError.
    """
    moves = MULTIPLIER_STEP * np.eye(start.size)[MOVING]
    starts = np.concatenate((start + moves, start - moves))
    beat = controls.flapping.period
    ends = integrate(craft, controls, starts, beat, np.array([beat]))[0][:, MOVING]
    return (ends[: len(moves)] - ends[len(moves) :]).T / (2.0 * MULTIPLIER_STEP)


def multipliers(matrix: np.ndarray) -> np.ndarray:
    """Floquet's multipliers of a monodromy matrix, complex, the largest first.

    A flight is stable where all are inside of the unit circle.

    >>> multipliers(np.diag([0.1, -0.5]))
    array([-0.5+0.j,  0.1+0.j])
    """
    eigenvalues = np.linalg.eigvals(matrix)
    return eigenvalues[np.argsort(-np.abs(eigenvalues), kind="stable")]


# Flight with wings held still, towed level: the drag that flapping must make up for.


@dataclass(frozen=True)
class Glide:
    """Steady level flight at a speed, the wings held flat and a tow rope along the flight."""

    speed: float
    """m/s."""
    pitch: float
    """Angle of attack, rad."""
    tail: float
    """rad, nose up."""
    drag: float
    """Pull of the rope, N."""
    state: np.ndarray
    """(SIZE,)."""


def glide(craft: Aircraft, speed: float) -> Glide:
    """The glide in which lift is weight and nothing pitches. Raises InputError if there is none.

    >>> made = glide(Aircraft(), 4.0)
    >>> f"{Aircraft().weight / made.drag:.1f}"
    '7.2'
    """

    def forces_at(angles: np.ndarray):
        pitch, tail = angles
        controls = Controls(Flapping(0.0, 0.0), float(tail))
        return readings(craft, controls, 0.0, level(speed, float(pitch)))

    def residual_forces(angles: np.ndarray) -> list[float]:
        forces = forces_at(angles)
        return [forces.lift / craft.weight - 1.0, forces.pitching / craft.weight]

    solution = root(residual_forces, np.array([0.1, -0.05]), tol=1e-12)
    if not solution.success or not np.abs(solution.x).max() < 0.7:
        raise InputError(f"the aircraft cannot glide at {speed:g} m/s: its wings stall")
    pitch, tail = (float(angle) for angle in solution.x)
    return Glide(speed, pitch, tail, -float(forces_at(solution.x).thrust), level(speed, pitch))


SPEEDS = (2.0, 15.0)
"""Speeds that may be asked for, m/s."""
FREQUENCIES = (0.5, 6.0)
"""Frequencies of the wing beat, Hz."""
TWISTS = (0.0, math.radians(45.0))
"""Twists of the tip, rad."""
EXACT = 1e-9
"""What is left of the demands in a trim, m/s, rad/s and rad."""
ROUGH, NEAR = 1e-6, 1e-3
"""Tolerance of the integration while more than this is left of the demands."""
ITERATIONS = 14
STALLED_STEPS = 3
"""Iterations without coming nearer after which a search is given up."""
STEP = 1e-6
STRIDES = np.array([0.3, 0.3, 1.0, 1.0, 1.0, 0.3])
"""Furthest step of Newton's method in A, tail (rad), u, w (m/s), q (rad/s) and theta (rad)."""
STEEP = 1.2
"""Largest |A|, tail and pitch of a trim, rad."""
SAMPLES = 512
"""Instants of a wing beat at which it is read."""
BEATING = 0.22
"""Amplitude with which a search begins, rad."""
STRIDE, SHORTEST = 0.25, 0.05
"""Share of the way from the known flight that is gone at once, at first and at the least."""
KNOWN = (3.5, 1.5, math.radians(20.0))
"""Speed (m/s), frequency (Hz) and twist (rad) of the flight that a search can start from."""


@dataclass(frozen=True)
class Trim:
    """A flight that repeats itself every wing beat, level, at a mean speed."""

    aircraft: Aircraft
    speed: float
    """Mean speed over the ground, m/s."""
    controls: Controls
    state: np.ndarray
    """(SIZE,) at the start of a beat."""
    residual: float
    """Largest deviation from the demands, m/s, rad/s and rad."""

    @property
    def amplitude(self) -> float:
        """A of the flap, rad."""
        return float(self.controls.flapping.amplitude)

    @property
    def tail(self) -> float:
        """Tail angle, rad, nose up."""
        return float(self.controls.tail)

    @property
    def frequency(self) -> float:
        """Of the wing beat, Hz."""
        return self.controls.flapping.frequency

    @cached_property
    def track(self) -> FlightTrack:
        """One wing beat at SAMPLES instants, the end left out."""
        beat = self.controls.flapping.period
        times = np.arange(SAMPLES) * beat / SAMPLES
        states = integrate(self.aircraft, self.controls, self.state[None], beat, times)[:, 0]
        return FlightTrack(self.aircraft, self.controls, times, states)

    @cached_property
    def beat(self) -> FlightHistory:
        """One wing beat as people read it."""
        return history(self.track)

    @property
    def power(self) -> float:
        """Mean power of the shafts, W: what the wings give back counts as regained."""
        return float(self.beat.power.mean())

    @property
    def power_without_regain(self) -> float:
        """Mean power of the shafts, W, of a drive that cannot take anything back."""
        return float(np.maximum(self.beat.power, 0.0).mean())

    @property
    def energy_per_metre(self) -> float:
        """Power over speed, J/m."""
        return self.power / self.speed

    @property
    def cost_of_transport(self) -> float:
        """Energy per metre over weight."""
        return self.energy_per_metre / self.aircraft.weight

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Floquet's multipliers, complex, the largest first (see `agents.flight.trim`)."""
        return multipliers(monodromy(self.aircraft, self.controls, self.state))

    @property
    def stable(self) -> bool:
        """Whether a small push dies out."""
        return bool(np.abs(self.multipliers[0]) < 1.0)


@dataclass(frozen=True)
class TrimTarget:
    """The flight that is looked for."""

    craft: Aircraft
    speed: float
    frequency: float
    twist: float

    def controls(self, unknowns: np.ndarray) -> Controls:
        """Controls of unknowns (..., 2 + len(MOVING))."""
        return Controls(Flapping(unknowns[..., 0], self.twist, self.frequency), unknowns[..., 1])

    def deviation(self, unknowns: np.ndarray, relative: float) -> np.ndarray:
        """What of the demands fails for unknowns (B, M), (B, M), integrated with a tolerance.

        Raises InputError.
        """
        starts = np.zeros((len(unknowns), SIZE))
        starts[:, MOVING] = unknowns[:, 2:]
        beat = 1.0 / self.frequency
        control, end = self.controls(unknowns), np.array([beat])
        ends = integrate(self.craft, control, starts, beat, end, relative=relative)[0]
        back = (ends - starts)[:, MOVING]
        mean_speed_error = ends[:, X] / beat - self.speed
        return np.column_stack((back, mean_speed_error, ends[:, Z] / beat))

    def known(self, share: float) -> TrimTarget:
        """Between the known flight (0) and this one (1), of the same aircraft."""
        speed, frequency, twist = KNOWN
        return TrimTarget(
            self.craft,
            speed + share * (self.speed - speed),
            frequency + share * (self.frequency - frequency),
            twist + share * (self.twist - twist),
        )


def trim(
    aircraft: Aircraft | None = None,
    speed: float = 3.5,
    *,
    frequency: float = 1.5,
    twist: float = math.radians(20.0),
    near: Trim | None = None,
    at: Callable[[float], None] | None = None,
) -> Trim:
    """The level flight of an aircraft at a mean speed (m/s).

    Parameters
    ----------
    aircraft: by default that of the thesis as corrected.
    speed: m/s, in SPEEDS. frequency: of flap and twist, Hz, in FREQUENCIES. twist: R of the wing
        tip, rad, in TWISTS.
    near: a trim to start from, of a flight not far from this one.
    at: called with the share of the search that is done, an estimate in [0, 1].

    Raises InputError for values out of range and where no such flight is found.

    >>> made = trim(speed=4.0)
    >>> f"{np.degrees(made.amplitude):.1f} deg, {made.energy_per_metre:.2f} J/m"
    '12.7 deg, 0.55 J/m'
    """
    craft = Aircraft() if aircraft is None else aircraft
    demand_possible(craft)
    demand("speed", speed, SPEEDS, "m/s")
    demand("frequency", frequency, FREQUENCIES, "Hz")
    demand("twist", twist, TWISTS, "rad")
    target = TrimTarget(craft, speed, frequency, twist)
    first = guess_unknowns(target) if near is None else unknowns(near)
    solution = None if first is None else newton(target, first, at)
    if solution is None:
        solution = continue_to_target(target, at)
    if solution is None:
        raise InputError(
            f"no level flight was found at {speed:g} m/s with {frequency:g} Hz and a twist of"
            f" {math.degrees(twist):g} deg: try another speed, frequency or twist"
        )
    unknown, residual = solution
    start = np.zeros(SIZE)
    start[MOVING] = unknown[2:]
    controls = Controls(Flapping(float(unknown[0]), twist, frequency), float(unknown[1]))
    return Trim(craft, speed, controls, start, residual)


def demand(name: str, value: float, bounds: tuple[float, float], unit: str) -> None:
    """Refuse a value out of its bounds. Raises InputError."""
    if not bounds[0] <= value <= bounds[1]:
        raise InputError(
            f"{name} = {value:g} {unit} is outside [{bounds[0]:g}, {bounds[1]:g}] {unit}"
        )


def unknowns(trimmed: Trim) -> np.ndarray:
    """The unknowns of a trim."""
    return np.concatenate(((trimmed.amplitude, trimmed.tail), trimmed.state[MOVING]))


def guess_unknowns(target: TrimTarget) -> np.ndarray | None:
    """Unknowns to begin with: a glide at the same speed, and wings that beat; None without one."""
    try:
        gliding = glide(target.craft, target.speed)
    except InputError:
        return None
    return np.concatenate(((BEATING, gliding.tail), gliding.state[MOVING]))


def newton(
    target: TrimTarget, first: np.ndarray, at: Callable[[float], None] | None = None
) -> tuple[np.ndarray, float] | None:
    """The unknowns that meet the demands and what is left of these, or None."""
    current, nearest, relative = first, [np.inf], ROUGH
    moves = STEP * np.eye(current.size)
    for done in range(ITERATIONS):
        if at is not None:
            at(done / ITERATIONS)
        try:
            deviations = target.deviation(
                np.concatenate((current[None], current + moves)), relative
            )
            residual = float(np.abs(deviations[0]).max())
            if residual < EXACT and relative == RELATIVE:
                return (current, residual) if current[0] > 0.0 else None
            relative = RELATIVE if residual < NEAR else ROUGH
            nearest.append(min(residual, nearest[-1]))
            if len(nearest) > STALLED_STEPS and residual > nearest[-1 - STALLED_STEPS]:
                return None
            step = np.linalg.solve((deviations[1:] - deviations[0]).T / STEP, -deviations[0])
        except (InputError, np.linalg.LinAlgError):
            return None
        current = current + step * min(1.0, float((STRIDES / np.abs(step[: STRIDES.size])).min()))
        if not np.abs(current[[0, 1, 5]]).max() < STEEP:
            return None
    return None


def continue_to_target(
    target: TrimTarget, at: Callable[[float], None] | None = None
) -> tuple[np.ndarray, float] | None:
    """As `newton`, from the known flight towards the asked one by steps that halve on failure."""
    first = guess_unknowns(target.known(0.0))
    solution = None if first is None else newton(target.known(0.0), first)
    share, stride = 0.0, STRIDE
    while solution is not None and share < 1.0:
        if at is not None:
            at(share)
        next_share = min(1.0, share + stride)
        next_solution = newton(target.known(next_share), solution[0])
        if next_solution is not None:
            solution, share = next_solution, next_share
        elif stride > SHORTEST:
            stride *= 0.5
        else:
            return None
    return solution
