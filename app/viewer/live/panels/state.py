"""The top of the panel, which is always in view: how the room stands, and the buttons that count.

The emergency stop works in every state and from the moment that the button goes down.
"""

from __future__ import annotations

import html

import viser

from app.live.control.look import Look
from app.viewer.live.panels.confirming import Confirming
from app.viewer.live.room import Room
from app.viewer.live.room_state import RoomState
from app.viewer.live.standing import Standing, standing
from app.viewer.panels.style import block

STEADY = 5.0
"""Messages a second while the emergency stop is held down."""


class StatePanel:
    """Emergency stop, banner, and the one thing that can be done next: arm, disarm or reset.

    The stop is on top and never moves.
    """

    def __init__(self, gui: viser.GuiApi, room: Room):
        self.room = room
        self.confirming = Confirming(room)
        self.stop = gui.add_button(
            "EMERGENCY STOP",
            icon=viser.Icon.HAND_STOP,
            color="red",
            hint="Stops all cars at once, and latches. Space and Esc do it too, in any browser",
        )
        gui.add_html(button_style(self.stop._impl.uuid))
        self.banner = gui.add_html("")
        self.arm = gui.add_button(
            "Arm …",
            icon=viser.Icon.STEERING_WHEEL,
            color="green",
            hint="Asks once more and for the code in the terminal, then the cars drive",
            visible=False,
        )
        self.disarm = gui.add_button(
            "Disarm",
            icon=viser.Icon.PLAYER_STOP,
            color="gray",
            hint="Stops the cars; they can be armed again at once",
            visible=False,
        )
        self.reset = gui.add_button(
            "Reset the emergency stop",
            icon=viser.Icon.ROTATE,
            color="gray",
            hint="The cars stay where they are until armed again",
            visible=False,
        )
        self.again = gui.add_button(
            "Open again", icon=viser.Icon.REFRESH, color="blue", visible=False
        )
        self.stop.on_click(self.stopped)
        self.stop.on_hold(self.stopped, callback_hz=STEADY)
        self.arm.on_click(self.arming)
        self.disarm.on_click(self.disarmed)
        self.reset.on_click(self.reset_asked)
        self.again.on_click(self.opened_again)

    async def stopped(self, event: viser.GuiEvent) -> None:
        self.room.emergency(whose(event))

    async def arming(self, event: viser.GuiEvent) -> None:
        now = standing(self.room.state, self.room.look)
        if not now.armable:
            self.room.notices.put("; ".join(("cannot be armed now", *now.reasons)))
        elif event.client is not None:
            self.confirming.ask(event.client)

    async def disarmed(self, event: viser.GuiEvent) -> None:
        self.room.ask("disarm", whose(event))

    async def reset_asked(self, event: viser.GuiEvent) -> None:
        self.room.ask("reset", whose(event))

    async def opened_again(self, event: viser.GuiEvent) -> None:
        self.room.reopen(whose(event))

    def refresh(self, state: RoomState, look: Look | None) -> None:
        """Show how the room stands now."""
        now = standing(state, look)
        self.banner.content = block(banner(now))
        self.arm.visible = now.kind == "safe"
        self.arm.disabled = not now.armable
        self.disarm.visible = now.kind in ("running", "held up")
        self.reset.visible = now.kind == "emergency" and state.status == "open"
        self.again.visible = now.kind == "failed" and state.status == "failed"
        if now.kind != "safe" or not state.browsers_arm:
            self.confirming.withdraw()


def whose(event: viser.GuiEvent) -> str:
    """Who asks, for the log."""
    return f"browser {event.client_id}"


def banner(now: Standing) -> str:
    """How a room stands, as HTML in the colour of it."""
    reasons = "".join(f"<li>{html.escape(reason)}</li>" for reason in now.reasons)
    listed = f"<ul>{reasons}</ul>" if reasons else ""
    return (
        f'<div class="fs-banner fs-{now.kind.replace(" ", "-")}"><b>{html.escape(now.title)}</b>'
        f"<span>{html.escape(now.words)}</span>{listed}</div>"
    )


def button_style(uuid: str) -> str:
    """Style that makes the emergency stop large and keeps it and the banner in view.

    Buttons have no sizes of their own, and a panel scrolls as a whole.
    """
    button = f'[id="{uuid}"]'
    return (
        f"<style>{button} {{ height: 58px !important; font-size: 17px; background: #d6001c; "
        "border: 3px solid #ffd43b; border-radius: 8px; letter-spacing: 0.4px; }"
        f"{button} .mantine-Button-label {{ font-weight: 700; }}"
        f"{button} .mantine-Button-section {{ margin-right: 9px; }}"
        f"div:has(> {button}) {{ position: sticky; top: 0; z-index: 30; background: #fff; "
        "padding-top: 6px; margin-top: -6px; }</style>"
    )
