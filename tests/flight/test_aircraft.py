"""Table 2.1, corrected."""

import math

import pytest

from agents.flight.aircraft import Aircraft, demand_possible
from agents.models.declare import checked, declared
from worlds.input_error import InputError


def test_moments_of_inertia_are_of_masses():
    craft = Aircraft()
    assert craft.body_inertia == pytest.approx(0.24 * (3 * 0.045**2 + 0.5**2) / 12, rel=1e-12)
    assert craft.wing_inertia == pytest.approx(0.03 * 0.36**2 / 12, rel=1e-12)
    assert craft.aspect_ratio == pytest.approx(2.5 / 0.36)
    assert craft.weight == pytest.approx(2.943)


def test_the_centre_of_mass_is_within_body_and_chord():
    craft = Aircraft()
    assert craft.centre_of_mass < min(craft.body_length, craft.chord)
    assert craft.twist_axis == craft.centre_of_mass


def test_every_value_says_whose_it_is():
    sources = ("thesis, table 2.1", "DeLaurier 1993", "free choice")
    for one in declared(Aircraft):
        assert one.source.startswith(sources), one.name
        assert one.low <= one.default <= one.high


def test_values_out_of_range_are_refused():
    with pytest.raises(InputError, match=r"mass = 9.0 kg is outside \[0.05, 5\] kg \(test\)"):
        checked(Aircraft, {"mass": 9.0}, "test")
    with pytest.raises(InputError, match="did you mean 'chord'"):
        checked(Aircraft, {"cord": 0.3})
    with pytest.raises(InputError, match="suction"):
        checked(Aircraft, {"suction": math.nan})


def test_parts_that_do_not_fit_are_refused():
    with pytest.raises(InputError, match=r"wing_mass = 0.06 kg is outside \[0, 0.0475\] kg"):
        demand_possible(Aircraft(mass=0.1, wing_mass=0.06))
    with pytest.raises(InputError, match=r"twist_axis = 0.4 m .* with chord = 0.36 m \(here\)"):
        demand_possible(Aircraft(twist_axis=0.4), "here")
    with pytest.raises(InputError, match=r"wing_centre = 0\.4 m"):
        demand_possible(Aircraft(span=0.7))
