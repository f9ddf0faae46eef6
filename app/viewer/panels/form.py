"""Controls for the fields of a dataclass, made from how they are declared to be chosen."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import viser

from app.viewer.scene.shown.control import Control


class Form[T]:
    """A control for each field in `controls`, in groups; other fields keep their values.

    One that does not apply is out of sight, as is a group without any; it keeps its value.
    """

    def __init__(self, gui: viser.GuiApi, value: T, controls: Mapping[str, Control]):
        self.value = value
        self.controls = controls
        groups = dict.fromkeys(one.group for one in controls.values())
        self.folders = {group: gui.add_folder(group) for group in groups}
        self.handles: dict[str, Any] = {}
        for name, control in controls.items():
            with self.folders[control.group]:
                self.handles[name] = handle(gui, control, getattr(value, name))
        self.fit(value, ())

    def __getitem__(self, name: str) -> Any:
        """The control of a field."""
        return self.handles[name]

    def read(self, **instead: Any) -> T:
        """The dataclass as the controls have it, with other values `instead` of some."""
        values = {name: one.value for name, one in self.handles.items()} | instead
        return replace(self.value, **values)  # type: ignore[type-var]

    def fit(self, value: T, scene: Iterable[Any]) -> None:
        """Show those controls that apply to anything in the scene, as things are chosen now."""
        applies = {name: control.is_for(scene, value) for name, control in self.controls.items()}
        there = {self.controls[name].group for name, shown in applies.items() if shown}
        for group, folder in self.folders.items():
            sight(folder, group in there)
        for name, shown in applies.items():
            sight(self.handles[name], shown)


def sight(control: Any, wanted: bool) -> None:
    """Show a control, or hide it; browsers are told only what changes."""
    if control.visible != wanted:
        control.visible = wanted


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
