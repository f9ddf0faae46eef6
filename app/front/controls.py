"""What browsers give to controls and handles, before viser and other browsers see it."""

from __future__ import annotations

import math
from typing import Any

import viser

from app.front.client_addresses import RateLimit
from app.front.viser_internals import guard_drags, guard_updates

# Lets only usable values of a browser through to a control.

LONGEST_TEXT = 200


class UnusableError(ValueError):
    """A value that cannot even be clamped: the wrong type, NaN, or an unknown choice."""


def clamp_number(value: Any, low: float | None, high: float | None, kind: type = float) -> Any:
    """A number clamped to [low, high], as `kind`. Raises UnusableError for what is no number.

    >>> clamp_number(7, 0.0, 6.28), clamp_number(-3.7, 1, 100, int)
    (6.28, 1)
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value:
        raise UnusableError(f"{value!r} is not a number")
    if low is not None:
        value = max(low, value)
    if high is not None:
        value = min(high, value)
    if isinstance(value, float) and math.isinf(value):
        raise UnusableError("infinity is not allowed")
    try:
        return kind(value)
    except OverflowError:
        raise UnusableError("the number is too large") from None


def offered_choice(value: Any, choices: tuple[str, ...]) -> str:
    """A choice that is offered. Raises UnusableError for any other."""
    if not isinstance(value, str) or value not in choices:
        raise UnusableError(f"{value!r} is not offered")
    return value


def is_pose(position: Any, wxyz: Any) -> bool:
    """Whether a browser has dragged something to a place, with an attitude.

    >>> is_pose((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0)), is_pose((1.0, 2.0), (1.0, 0.0, 0.0, 0.0))
    (True, False)
    """
    try:
        place, attitude = [float(x) for x in position], [float(x) for x in wxyz]
    except (TypeError, ValueError, OverflowError):
        return False
    if len(place) != 3 or len(attitude) != 4:
        return False
    return all(map(math.isfinite, place)) and 1e-6 < math.hypot(*attitude) < math.inf


def usable_value(control: Any, value: Any) -> Any:
    """The value that a control may take when a browser sends `value`. Raises UnusableError."""
    if getattr(control, "disabled", False):
        raise UnusableError("the control is disabled")
    if isinstance(control, viser.GuiButtonHandle):
        return True
    if isinstance(control, viser.GuiCheckboxHandle):
        if not isinstance(value, bool):
            raise UnusableError(f"{value!r} is neither on nor off")
        return value
    if isinstance(control, viser.GuiSliderHandle | viser.GuiNumberHandle):
        return clamp_number(value, control.min, control.max, type(control.value))
    if isinstance(control, viser.GuiDropdownHandle | viser.GuiButtonGroupHandle):
        return offered_choice(value, tuple(control.options))
    if isinstance(control, viser.GuiTextHandle):
        if not isinstance(value, str) or len(value) > LONGEST_TEXT:
            raise UnusableError("the text is too long")
        return value
    raise UnusableError("this control takes no values")


def set_value(control: Any, value: Any) -> None:
    """Give a control a value in all browsers; viser's types do not say that one may."""
    control.value = value


PRESSES = (10.0, 20.0)
"""Presses of buttons by one browser, a second and at once; a value costs far less than what a
button begins."""
BUTTONS = (viser.GuiButtonHandle, viser.GuiButtonGroupHandle)


class ButtonPresses:
    """The presses of every browser that is there; used by viser's thread."""

    def __init__(self) -> None:
        self.limits: dict[int, RateLimit] = {}

    def take(self, browser: int) -> bool:
        """Whether a browser may press a button now."""
        return self.limits.setdefault(browser, RateLimit(*PRESSES)).take()

    def forget(self, browser: int) -> None:
        """A browser is gone."""
        self.limits.pop(browser, None)


def guard_values(server: viser.ViserServer) -> None:
    """Look at all that browsers give to the controls of a server."""
    presses = ButtonPresses()
    guard_controls(server.gui, presses)

    async def guard_own(client: viser.ClientHandle) -> None:
        guard_controls(client.gui, presses)

    async def forget(client: viser.ClientHandle) -> None:
        presses.forget(client.client_id)

    server.on_client_connect(guard_own)
    server.on_client_disconnect(forget)


def guard_controls(gui: viser.GuiApi, presses: ButtonPresses) -> None:
    """Clamp what browsers send before viser, callbacks and other browsers see it."""

    def check(browser: int, control: Any, updates: dict[str, Any]) -> tuple[bool, Any]:
        sent = updates["value"]
        if isinstance(control, BUTTONS) and not presses.take(browser):
            return False, sent
        try:
            return True, usable_value(control, sent)
        except UnusableError:
            return False, control.value

    guard_updates(gui, check)
    guard_drags(gui, is_pose)
