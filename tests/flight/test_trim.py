"""Level flights: what they must meet, their power, the U curve, their stability."""

import math

import numpy as np
import pytest

from agents.flight.aircraft import Aircraft
from agents.flight.flight_motion import MOVING, THETA, Q, U, W, X, Z, fly
from agents.flight.power import readings
from agents.flight.trim import glide, monodromy, trim
from worlds.input_error import InputError

READING = {3.0: 0.55, 3.5: 0.49, 4.0: 0.53, 5.0: 0.71, 6.0: 0.95}
"""Energy per metre (J/m) that the reading of the thesis measured with its own closure."""


@pytest.mark.parametrize("speed", READING)
def test_lift_is_weight_and_it_does_not_climb(trims, speed):
    made = trims[speed]
    assert made.beat.lift.mean() == pytest.approx(made.aircraft.weight, abs=1e-6)
    assert made.beat.climb.mean() == pytest.approx(0.0, abs=1e-6)
    assert made.beat.thrust.mean() == pytest.approx(0.0, abs=1e-6)
    assert made.residual < 1e-9


def test_after_three_beats_it_is_where_it_should_be(trims):
    made = trims[3.5]
    flown = fly(made.aircraft, made.controls, made.state, 2.0).state[-1]
    assert flown[MOVING] == pytest.approx(made.state[MOVING], abs=1e-6)
    assert flown[X] == pytest.approx(7.0, abs=1e-6)
    assert flown[Z] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("speed", READING)
def test_the_shafts_give_what_the_air_takes(trims, speed):
    """Over a beat the energy of the aircraft comes back; the power is counted twice, apart."""
    made = trims[speed]
    felt = readings(made.aircraft, made.controls, made.track.time, made.track.state)
    assert felt.power.mean() == pytest.approx(felt.taken.mean(), rel=1e-7)
    assert np.abs(felt.power - felt.taken).max() > 0.1  # within the beat they are not the same
    assert made.power_without_regain > made.power


@pytest.mark.parametrize("speed", READING)
def test_power_is_more_than_drag_times_speed(trims, speed):
    still = glide(Aircraft(), speed)
    assert still.drag > 0.0
    assert trims[speed].power > still.drag * speed


def test_energy_per_metre_is_u_shaped(trims):
    costs = [trims[speed].energy_per_metre for speed in sorted(READING)]
    steps = np.diff(costs)
    assert (steps < 0.0).tolist() == [True, False, False, False]
    for speed, published in READING.items():
        assert trims[speed].energy_per_metre == pytest.approx(published, rel=0.25)


def test_the_flight_of_the_reading(trims):
    """A = 13.1 deg, 1.69 W, 0.483 J/m, |mu| = 0.74 there; its closure is not known exactly."""
    made = trims[3.5]
    assert math.degrees(made.amplitude) == pytest.approx(13.1, rel=0.12)
    assert made.power == pytest.approx(1.69, rel=0.12)
    assert made.energy_per_metre == pytest.approx(made.power / 3.5, rel=1e-12)
    assert abs(made.multipliers[0]) == pytest.approx(0.74, abs=0.04)


@pytest.mark.parametrize("speed", READING)
def test_it_is_stable(trims, speed):
    made = trims[speed]
    assert made.stable
    assert np.abs(made.multipliers).max() == pytest.approx(abs(made.multipliers[0]))
    assert abs(made.multipliers[0]) < 1.0


def test_a_small_push_becomes_what_the_monodromy_says(trims):
    made = trims[4.0]
    push = np.zeros(len(MOVING))
    push[[U, W, Q, THETA]] = 1e-4, -2e-4, 3e-4, 1e-4
    start = made.state.copy()
    start[MOVING] += push
    beat = made.controls.flapping.period
    flown = fly(made.aircraft, made.controls, start, 2.0 * beat).state[-1]
    matrix = monodromy(made.aircraft, made.controls, made.state)
    assert flown[MOVING] - made.state[MOVING] == pytest.approx(matrix @ matrix @ push, abs=2e-7)


def test_far_behind_its_neutral_point_the_centre_of_mass_makes_it_unstable(trims):
    made = trim(Aircraft(centre_of_mass=0.2), 4.0, near=trims[4.0])
    assert not made.stable
    assert made.multipliers[0].real > 1.5


def test_where_it_is_searched_from_does_not_matter(trims):
    made = trim(speed=5.0)
    assert made.amplitude == pytest.approx(trims[5.0].amplitude, rel=1e-7)
    assert made.power == pytest.approx(trims[5.0].power, rel=1e-6)


def test_a_heavier_aircraft_needs_more(trims):
    made = trim(Aircraft(mass=0.33), 4.0, near=trims[4.0])
    assert made.energy_per_metre > 1.02 * trims[4.0].energy_per_metre


def test_a_glide_has_nothing_left_to_balance():
    """A plain sum of a parabolic polar: drag of friction, and of lift without full suction."""
    craft = Aircraft(suction=1.0, tail_width=0.02)
    made = glide(craft, 8.0)
    area = craft.span * craft.chord + 2.0 * craft.tail_width * craft.tail_chord
    push = 0.5 * 1.225 * 64.0
    lift = craft.weight / (push * craft.span * craft.chord)
    slope = 2.0 * math.pi * craft.aspect_ratio / (craft.aspect_ratio + 2.0)
    induced = lift**2 / slope * 2.0 / (craft.aspect_ratio + 2.0)
    expected = push * (craft.friction * area + induced * craft.span * craft.chord)
    assert made.drag == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"speed": 1.0}, r"speed = 1 m/s is outside \[2, 15\] m/s"),
        ({"speed": math.nan}, "speed = nan m/s is outside"),
        ({"frequency": 9.0}, r"frequency = 9 Hz is outside \[0.5, 6\] Hz"),
        ({"twist": 2.0}, "twist = 2 rad is outside"),
    ],
)
def test_what_cannot_be_asked_is_refused(values, said):
    with pytest.raises(InputError, match=said):
        trim(**values)


def test_a_flight_that_is_not_there_is_refused():
    with pytest.raises(InputError, match=r"no level flight was found at 3.5 m/s with 1.5 Hz"):
        trim(Aircraft(mass=2.0))
    with pytest.raises(InputError, match=r"cannot glide at 3.5 m/s: its wings stall"):
        glide(Aircraft(mass=2.0), 3.5)


def test_a_flight_that_tumbles_is_refused(trims):
    made = trims[3.5]
    start = made.state.copy()
    start[Q] = 150.0
    with pytest.raises(InputError, match="the aircraft tumbles at 0 s"):
        fly(made.aircraft, made.controls, start, 3.0)
