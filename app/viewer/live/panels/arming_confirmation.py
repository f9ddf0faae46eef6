"""Asks once more before the cars drive, and for the code that the terminal shows."""

from __future__ import annotations

import html
from dataclasses import dataclass

import viser
from viser._gui_handles import GuiModalHandle

from app.viewer.live.session import Session
from app.viewer.panels.style import block
from app.viewer.web.values import show

ASKED = "The terminal that runs <i>flockscope live lab</i> shows the code."
NO_CODE = "A code is six digits."


@dataclass(frozen=True)
class ArmingDialog:
    """A question in one browser."""

    modal: GuiModalHandle
    code: viser.GuiTextHandle
    message: viser.GuiHtmlHandle


class ArmingConfirmation:
    """A question in the browser that wants to arm, at most one in each."""

    def __init__(self, server: viser.ViserServer, session: Session):
        self.session = session
        self.open: dict[int, ArmingDialog] = {}
        """By browser."""
        server.on_client_disconnect(self.forget_client)

    async def forget_client(self, client: viser.ClientHandle) -> None:
        """A browser has gone, and its question with it: that holds all that viser has of it."""
        self.open.pop(client.client_id, None)

    def ask(self, client: viser.ClientHandle) -> None:
        """Ask, unless it is being asked."""
        number = client.client_id
        if number in self.open:
            return
        modal = client.gui.add_modal("Arm?")
        with modal:
            client.gui.add_html(block(question(list(self.session.lab.cars))))
            code = client.gui.add_text("Code", "", hint="Six digits, as the terminal shows them")
            message = client.gui.add_html(block(line(ASKED)))
            cancel = client.gui.add_button("Cancel", color="gray")
            arm = client.gui.add_button(
                "Arm", icon=viser.Icon.STEERING_WHEEL, color="green", hint="The cars drive at once"
            )
        self.open[number] = ArmingDialog(modal, code, message)

        async def cancelled(_event: viser.GuiEvent) -> None:
            self.close(number)

        async def armed(_event: viser.GuiEvent) -> None:
            self.answered(number)

        cancel.on_click(cancelled)
        arm.on_click(armed)

    def answered(self, number: int) -> None:
        """A browser says yes: arm if its code is right, else say so and ask again."""
        question = self.open.get(number)
        if question is None:
            return
        verdict = self.session.arm_by_code(question.code.value, f"browser {number}")
        show(question.code, "")
        if verdict in ("right", "off"):
            self.close(number)
        elif verdict == "no code":
            question.message.content = block(line(f"{NO_CODE} {ASKED}"))
        else:
            words = f"<b>Wrong code.</b> {tries(self.session.code.left)} for all browsers together."
            question.message.content = block(line(words))

    def close(self, number: int) -> None:
        """Take the question away from a browser."""
        question = self.open.pop(number, None)
        if question is not None:
            question.modal.close()

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


def line(words: str) -> str:
    """What is said below the field, as HTML."""
    return f'<div class="fs-quiet">{words}</div>'


def tries(count: int) -> str:
    """How many are left, in words.

    >>> tries(1)
    '1 try is left'
    """
    return "1 try is left" if count == 1 else f"{count} tries are left"
