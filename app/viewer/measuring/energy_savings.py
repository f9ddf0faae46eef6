"""What formation saves in joules: a share of what an aircraft needs that flies alone."""

from __future__ import annotations

from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.background_worker import BackgroundWorker
from app.viewer.measuring.flock_readings import FlockReadings
from worlds.input_error import InputError

SAVES = tuple(name for name, one in OBSERVABLES.items() if one.saves_power)
"""The observables that say what share of their power, in percent, agents save."""
STEP = 0.25
"""Speeds are rounded to it, m/s: a trim takes seconds."""


class EnergySavings:
    """Energy per metre of the thesis's aircraft in trim, found aside, once for each speed."""

    def __init__(self) -> None:
        self.known: dict[float, float | None] = {}
        """Speed (m/s) -> J/m; None where it cannot fly level."""
        self.aside = BackgroundWorker()
        self.sought = 0.0

    def alone(self, speed: float) -> float | None:
        """J/m of an aircraft alone at about a speed (m/s); None until, or unless, it is known."""
        speed = round(speed / STEP) * STEP
        done = self.aside.finished()
        if done is not None:
            self.known[self.sought] = done.result()
        if speed not in self.known and self.aside.idle:
            self.sought = speed
            self.aside.begin(lambda: trimmed(speed))
        return self.known.get(speed)

    def of(self, readings: FlockReadings) -> tuple[float, float] | None:
        """What a flock saves at the speed its body cruises at, and what one needs alone, J/m."""
        share = next((readings.values[name] for name in SAVES if name in readings.values), None)
        speed = getattr(readings.flock.parameters, "v0", None)
        if speed is None or share is None:
            return None
        alone = self.alone(speed)
        return None if alone is None else (0.01 * share * alone, alone)

    def saved(self, readings: FlockReadings) -> str:
        """The same in words."""
        found = self.of(readings)
        return "–" if found is None else f"{found[0]:.3f} of {found[1]:.2f}"


def trimmed(speed: float) -> float | None:
    """J/m in trim at a speed (m/s); None where the aircraft cannot fly level."""
    from agents.flight.trim import trim

    try:
        return trim(speed=speed).energy_per_metre
    except InputError:
        return None
