"""Controls for the fields of a dataclass, made from how they are declared to be chosen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import viser

from app.viewer.scene.shown.control import Control


class Form[T]:
    """A control for each field in `controls`, in their order; other fields keep their values."""

    def __init__(self, gui: viser.GuiApi, value: T, controls: Mapping[str, Control]):
        self.value = value
        self.handles = {
            name: handle(gui, control, getattr(value, name)) for name, control in controls.items()
        }

    def __getitem__(self, name: str) -> Any:
        """The control of a field."""
        return self.handles[name]

    def read(self, **instead: Any) -> T:
        """The dataclass as the controls have it, with other values `instead` of some."""
        values = {name: one.value for name, one in self.handles.items()} | instead
        return replace(self.value, **values)  # type: ignore[type-var]


def handle(gui: viser.GuiApi, control: Control, value: Any) -> Any:
    """The control of one field."""
    if isinstance(value, bool):
        return gui.add_checkbox(control.label, value, hint=control.hint)
    if control.choices:
        return gui.add_dropdown(
            control.label, control.choices, initial_value=value, hint=control.hint
        )
    if control.typed:
        low, high, step = control.low, control.high, control.step
        return gui.add_number(control.label, value, min=low, max=high, step=step, hint=control.hint)
    return gui.add_slider(
        control.label, control.low, control.high, control.step, value, hint=control.hint
    )
