"""Asks once more before the cars drive."""

from __future__ import annotations

import html

import viser
from viser._gui_handles import GuiModalHandle

from app.viewer.live.room import Room
from app.viewer.panels.style import block


class Confirming:
    """A question in the browser that wants to arm, at most one in each."""

    def __init__(self, room: Room):
        self.room = room
        self.open: dict[int, GuiModalHandle] = {}
        """By browser."""

    def ask(self, client: viser.ClientHandle) -> None:
        """Ask, unless it is being asked. Cancel comes first: it has the focus."""
        number = client.client_id
        if number in self.open:
            return
        modal = self.open[number] = client.gui.add_modal("Arm?")
        with modal:
            client.gui.add_html(block(question(list(self.room.lab.cars))))
            cancel = client.gui.add_button("Cancel", color="gray")
            arm = client.gui.add_button(
                "Arm", icon=viser.Icon.STEERING_WHEEL, color="green", hint="The cars drive at once"
            )

        async def cancelled(_event: viser.GuiEvent) -> None:
            self.close(number)

        async def armed(_event: viser.GuiEvent) -> None:
            if self.close(number):
                self.room.ask("arm", f"browser {number}")

        cancel.on_click(cancelled)
        arm.on_click(armed)

    def close(self, number: int) -> bool:
        """Take the question away from a browser; whether it was there."""
        modal = self.open.pop(number, None)
        if modal is not None:
            modal.close()
        return modal is not None

    def withdraw(self) -> None:
        """Take it away everywhere: the cars cannot be armed now."""
        for number in tuple(self.open):
            self.close(number)


def question(cars: list[str]) -> str:
    """What is asked."""
    count = "1 car" if len(cars) == 1 else f"{len(cars)} cars"
    return (
        f'<div class="fs-question"><b>{count} will drive</b> ({html.escape(", ".join(cars))}). '
        "Is the area clear?<br>Space or Esc stops them, in every browser.</div>"
    )
