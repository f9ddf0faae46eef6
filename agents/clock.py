"""A flock's ticks as Mesa's time: its `time`, its `steps`, and its events when they are due."""

from __future__ import annotations

import math

import mesa


class TickClock(mesa.Model):
    """A `mesa.Model` whose time is the tick of a flock, however the flock came to it.

    Mesa counts only what passes through its own `step`; a flock also runs ticks in compiled code,
    goes on as its agents step one by one, and goes back to a saved state. So `time` and `steps`
    follow `tick`, and a run stops for each event. An event at time t happens once tick t is done.

    Mesa has no public name for its list of events and for the schedule that calls `step`: those
    that are used here are the same in Mesa 3.5 and 4.0.0a0, and `tests/mesa` says when not.
    """

    time: float
    _tick = 0
    _loops = 0
    """How many of Mesa's event loops are under way, one inside the other."""
    _took_step = False
    """Whether the step that Mesa would call next was taken out of its list."""

    @property
    def tick(self) -> int:
        """Ticks done."""
        return self._tick

    @tick.setter
    def tick(self, value: int) -> None:
        self._tick = self.steps = value
        if self.time != value:
            self.time = float(value)

    def _advance_time(self, until: float) -> None:
        """Mesa's loop over events, `step` among them, up to a time."""
        if not self._loops:
            self._schedule_step()
        self._loops += 1
        try:
            super()._advance_time(until)
        finally:
            self._loops -= 1
        if self.time < self._tick:  # a step may run many ticks; Mesa then sets the time it expected
            self.time = float(self._tick)
            self._fire(self.time)

    def _ticks_to_event(self, ticks: int) -> int:
        """How many of so many ticks, one at least, can run before an event; fires what is due."""
        self._fire(math.nextafter(self._tick + 1, 0.0))
        due = self._next_event()
        return ticks if due >= self._tick + ticks else max(1, math.floor(due) - self._tick)

    def _fire_due(self) -> None:
        """Fire the events of this tick, unless a loop of Mesa's is about to."""
        if not self._loops:
            self._fire(self.time)
        elif self._took_step:
            self._schedule_step()

    def _next_event(self) -> float:
        """The time of the next event, infinite without one."""
        try:
            event = self._event_list.pop_event()
        except IndexError:
            return math.inf
        self._event_list.add_event(event)
        return float(event.time)

    def _fire(self, until: float) -> None:
        """Execute the events up to a time; the scheduled step is no event, and is taken out."""
        while True:
            try:
                event = self._event_list.pop_event()
            except IndexError:
                return
            if event is self._default_schedule._current_event:
                event.cancel()
                self._took_step = True
            elif event.time <= until:
                self.time = max(self.time, float(event.time))
                event.execute()
            else:
                self._event_list.add_event(event)
                return

    def _schedule_step(self) -> None:
        """Have Mesa call `step` at the next whole time, whatever moved the flock since."""
        self._took_step = False
        schedule, at = self._default_schedule, math.floor(self.time) + 1
        event = schedule._current_event
        if event is not None and not event.CANCELED:
            if event.time == at:
                return
            event.cancel()
        schedule._schedule_next(float(at))
