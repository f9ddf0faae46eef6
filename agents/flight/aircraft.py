"""The aircraft of the thesis, table 2.1, with what is wrong or missing in it put right.

Every field says where its value comes from: `thesis` as printed, `thesis, corrected` where the
print cannot be meant, `DeLaurier 1993` for the aerodynamics, `free choice` where nobody says.
"""

from __future__ import annotations

import math
from functools import cached_property

from agents.models.declare import Parameters, parameter
from worlds.input_error import InputError

THESIS = "thesis, table 2.1"
CORRECTED = "thesis, table 2.1, corrected"
DELAURIER = "DeLaurier 1993"
FREE = "free choice"

AIR = 1.225
"""Density of air, kg/m^3 (standard atmosphere at sea level)."""
GRAVITY = 9.81
"""m/s^2."""


class Aircraft(Parameters):
    """A flapping-wing aircraft: a body with a tail, and two wings that flap and twist."""

    mass: float = parameter(
        0.300,
        "Mass of the whole aircraft",
        symbol="m",
        unit="kg",
        low=0.05,
        high=5.0,
        source=THESIS,
    )
    wing_mass: float = parameter(
        0.030,
        "Mass of one wing; the thesis leaves it out",
        symbol="m_2",
        unit="kg",
        low=0.0,
        high=1.0,
        source=FREE,
    )
    body_length: float = parameter(
        0.50,
        "Length of the body, a cylinder",
        symbol="l",
        unit="m",
        low=0.05,
        high=2.0,
        source=THESIS,
    )
    body_diameter: float = parameter(
        0.09,
        "Diameter of the body",
        symbol="2r",
        unit="m",
        low=0.01,
        high=0.5,
        source=THESIS,
    )
    span: float = parameter(
        2.50,
        "Span from tip to tip, through the body",
        symbol="l_1",
        unit="m",
        low=0.3,
        high=6.0,
        source=THESIS,
    )
    chord: float = parameter(
        0.36,
        "Chord of the rectangular wing",
        symbol="l_3",
        unit="m",
        low=0.05,
        high=1.0,
        source=THESIS,
    )
    wing_centre: float = parameter(
        0.40,
        "How far out along the wing its centre of mass is from the body's",
        symbol="l_2",
        unit="m",
        low=0.0,
        high=3.0,
        source=THESIS,
    )
    centre_of_mass: float = parameter(
        0.0845,
        "Body's centre of mass behind the leading edge; printed 0.845, longer than the body",
        symbol="x_g",
        unit="m",
        low=-0.2,
        high=0.5,
        source=CORRECTED,
    )
    twist_axis: float = parameter(
        0.0845,
        "Axis of the twist behind the leading edge: a spar, through the centre of mass",
        symbol="x_e",
        unit="m",
        low=0.0,
        high=1.0,
        source=FREE,
    )
    tail_chord: float = parameter(
        0.25,
        "Length of a tail plate along the flight",
        symbol="l_4",
        unit="m",
        low=0.02,
        high=1.0,
        source=THESIS,
    )
    tail_width: float = parameter(
        0.45,
        "Width of one of the two tail plates",
        symbol="l_5",
        unit="m",
        low=0.02,
        high=1.0,
        source=THESIS,
    )
    tail_arm: float = parameter(
        0.354,
        "Where the tail's force acts, behind the body's centre of mass",
        symbol="l_t",
        unit="m",
        low=0.05,
        high=2.0,
        source=FREE,
    )
    downwash: float = parameter(
        0.4,
        "Share of the angle of attack that the wing's downwash takes away at the tail",
        symbol=r"\epsilon",
        low=0.0,
        high=0.9,
        source=FREE,
    )
    suction: float = parameter(
        0.8,
        "Efficiency of the leading-edge suction",
        symbol=r"\eta_s",
        low=0.0,
        high=1.0,
        source=f"{DELAURIER}; value: {FREE}",
    )
    friction: float = parameter(
        0.03,
        "Drag coefficient of skin friction, both sides",
        symbol="C_{d0}",
        low=0.0,
        high=0.2,
        source=f"{DELAURIER}; value: {FREE}",
    )
    stall: float = parameter(
        math.radians(14.0),
        "Angle of attack at which half of the flow has left the section",
        symbol=r"\alpha_s",
        unit="rad",
        low=0.05,
        high=1.0,
        source=f"{DELAURIER}; value: {FREE}",
    )
    stall_width: float = parameter(
        math.radians(1.5),
        "Over what angle the flow leaves; DeLaurier switches at once",
        symbol=r"\delta_s",
        unit="rad",
        low=0.005,
        high=0.2,
        source=FREE,
    )
    cross_flow: float = parameter(
        1.98,
        "Drag coefficient of a section that the flow crosses, when stalled",
        symbol="C_{d,cf}",
        low=0.5,
        high=3.0,
        source=DELAURIER,
    )

    @cached_property
    def half_span(self) -> float:
        """Length of one wing, m."""
        return 0.5 * self.span

    @cached_property
    def aspect_ratio(self) -> float:
        """Span over chord of the two wings together."""
        return self.span / self.chord

    @cached_property
    def body_inertia(self) -> float:
        """I_1y, kg m^2: a solid cylinder of mass m - 2 m_2. Printed (2.6): an area, in m^4."""
        body = self.mass - 2.0 * self.wing_mass
        return body * (0.75 * self.body_diameter**2 + self.body_length**2) / 12.0

    @cached_property
    def wing_inertia(self) -> float:
        """I_2y of one wing, kg m^2: a thin plate, m_2 c^2 / 12. Printed (2.7): an area, in m^4."""
        return self.wing_mass * self.chord**2 / 12.0

    @cached_property
    def flap_inertia(self) -> float:
        """I_2x of one wing about its centre of mass, kg m^2: m_2 (b/2)^2 / 12."""
        return self.wing_mass * self.half_span**2 / 12.0

    @cached_property
    def weight(self) -> float:
        """N."""
        return self.mass * GRAVITY


def demand_possible(craft: Aircraft, origin: str = "") -> None:
    """Refuse an aircraft whose parts do not fit each other. Raises InputError.

    >>> demand_possible(Aircraft(mass=0.1, wing_mass=0.06))
    Traceback (most recent call last):
    worlds.input_error.InputError: wing_mass = 0.06 kg is outside [0, 0.0475] kg with mass = 0.1 kg
    """
    location = f" ({origin})" if origin else ""
    for name, limit, unit, other in (
        ("wing_mass", 0.475 * craft.mass, "kg", "mass"),
        ("wing_centre", craft.half_span, "m", "span"),
        ("twist_axis", craft.chord, "m", "chord"),
        ("body_diameter", craft.body_length, "m", "body_length"),
    ):
        value = getattr(craft, name)
        if value > limit:
            raise InputError(
                f"{name} = {value:g} {unit} is outside [0, {limit:g}] {unit}"
                f" with {other} = {getattr(craft, other):g} {unit}{location}"
            )
