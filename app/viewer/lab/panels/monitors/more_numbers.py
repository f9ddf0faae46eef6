"""More numbers of a flock, for whoever wants them."""

from __future__ import annotations

from collections.abc import Iterable

import viser

from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.energy_savings import SAVES, EnergySavings
from app.viewer.measuring.flock_numbers import Number, observed
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_format import over_a_run, told, words

JOULES = "joules-per-metre"
"""None of the observables: it takes an aircraft as well."""
SIZES = "group sizes"
"""Drawn as bars, not told as a number."""


class MoreNumbers:
    """A folder of switches, one for each observable; off, it costs nothing."""

    def __init__(self, gui: viser.GuiApi):
        self.joules = EnergySavings()
        self.switches = {}
        with gui.add_folder("More numbers", expand_by_default=False):
            for name, one in OBSERVABLES.items():
                everyone = one.card is not None and one.card.of is None
                if not (everyone or one.events or one.is_table):
                    self.switches[name] = gui.add_checkbox(words(name), False, hint=one.title)
            self.switches[SIZES] = gui.add_checkbox(SIZES, False, hint="Groups of each size")
            self.switches[JOULES] = gui.add_checkbox(
                "saved J/m",
                False,
                hint="What the flock saves of the energy per metre that the aircraft of the thesis "
                "needs alone at v0, in trim, if a unit of length is a metre; found in some seconds",
            )

    def offer(self, offered: Iterable[str]) -> None:
        """Show the switches of what these flocks have."""
        there = {*offered, *over_a_run(), SIZES}
        if there.intersection(SAVES):
            there.add(JOULES)
        for name, switch in self.switches.items():
            if switch.visible != (name in there):
                switch.visible = name in there

    @property
    def chosen(self) -> tuple[str, ...]:
        """What is switched on and to be had."""
        return tuple(name for name, one in self.switches.items() if one.value and one.visible)

    @property
    def names(self) -> frozenset[str]:
        """The observables that must be measured for it."""
        measured = (name for name in self.chosen if name not in (SIZES, JOULES))
        return frozenset(name for name in measured if OBSERVABLES[name].over is None)

    def numbers(self, readings: FlockReadings, last: float) -> dict[str, str]:
        """The numbers of a flock, name -> text; those over a run are of its `last` ticks."""
        found = {}
        for name in self.chosen:
            if name == JOULES:
                found["saved J/m"] = self.joules.saved(readings)
            elif OBSERVABLES[name].over is not None:
                found[words(name)] = told(name, readings.over(name, last))
            elif name != SIZES:
                found[words(name)] = told(name, readings.values.get(name))
        return found

    def values(self, readings: FlockReadings, last: float) -> dict[str, Number]:
        """The same numbers in full, but for those of one tick, which the readings have."""
        found = {
            words(name): observed(name, readings.over(name, last), readings.flock.model)
            for name in self.chosen
            if name in OBSERVABLES and OBSERVABLES[name].over is not None
        }
        saved = self.joules.of(readings) if JOULES in self.chosen else None
        if saved is not None:
            found["energy saved by formation"] = Number(saved[0], "J/m")
            found["energy needed alone"] = Number(saved[1], "J/m")
        return found
