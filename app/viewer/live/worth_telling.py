"""Which events are told in every browser, beside the log that has them all."""

from __future__ import annotations

from app.live.control.events import Event

TROUBLES = ("source", "link", "recording")


def notice_of(event: Event, armed_by: str = "") -> str:
    """What is to be told of an event, in one line; empty: nothing.

    `armed_by` says who has armed the cars; of cars that are not armed nobody need hear that they
    are not seen.

    >>> notice_of(Event(7, 0.07, "emergency", "EMERGENCY STOP", cause="browser 2"))
    'EMERGENCY STOP (browser 2)'
    >>> notice_of(Event(7, 0.07, "run", "the cars run"))
    ''
    """
    if event.kind in ("emergency", "hold"):
        by = "" if event.cause in ("", "safety") else f" ({event.cause})"
        return event.words + by
    if event.kind == "unseen":
        # without how long: words that are told again within seconds are left out
        return f"{event.car} is not seen: the cars stop" if armed_by else ""
    if event.kind in TROUBLES:
        return "" if event.words.endswith("works again") else f"{event.kind}: {event.words}"
    return event.words if event.kind == "refused" and event.asked != "tune" else ""
