"""The top of the panel, which is always in view: the banner, and the buttons that count.

The emergency stop works in every state and from the moment that the button goes down.
"""

from __future__ import annotations

import html

import viser

from app.live.control.loop_status import Status
from app.viewer.live.banner import Banner, banner_of
from app.viewer.live.panels.arming_confirmation import ArmingConfirmation
from app.viewer.live.session import Session
from app.viewer.live.session_state import SessionState
from app.viewer.panels.style import block

STEADY = 5.0
"""Messages a second while the emergency stop is held down."""


class StatePanel:
    """Emergency stop, banner, and the one thing that can be done next: arm, disarm or reset.

    The stop is on top and never moves.
    """

    def __init__(self, server: viser.ViserServer, session: Session):
        gui = server.gui
        self.session = session
        self.confirming = ArmingConfirmation(server, session)
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
        self.session.emergency(whose(event))

    async def arming(self, event: viser.GuiEvent) -> None:
        now = banner_of(self.session.state, self.session.status)
        if not now.armable:
            self.session.notices.put("; ".join(("cannot be armed now", *now.reasons)))
        elif event.client is not None:
            self.confirming.ask(event.client)

    async def disarmed(self, event: viser.GuiEvent) -> None:
        self.session.ask("disarm", whose(event))

    async def reset_asked(self, event: viser.GuiEvent) -> None:
        self.session.ask("reset", whose(event))

    async def opened_again(self, event: viser.GuiEvent) -> None:
        self.session.reopen(whose(event))

    def refresh(self, state: SessionState, status: Status | None) -> None:
        """Show the state of the cars."""
        now = banner_of(state, status)
        self.banner.content = block(banner_html(now))
        self.arm.visible = now.kind == "safe"
        self.arm.disabled = not now.armable
        self.disarm.visible = now.kind in ("running", "held up")
        self.reset.visible = now.kind == "emergency" and state.phase == "open"
        self.again.visible = now.kind in ("failed", "replay") and state.phase != "closed"
        self.again.label = "Back to the room" if now.kind == "replay" else "Open again"
        if now.kind != "safe" or not state.browsers_arm:
            self.confirming.withdraw()


def whose(event: viser.GuiEvent) -> str:
    """Who asks, for the log."""
    return f"browser {event.client_id}"


def banner_html(now: Banner) -> str:
    """A banner as HTML, in the colour of its kind."""
    reasons = "".join(f"<li>{html.escape(reason)}</li>" for reason in now.reasons)
    listed = f"<ul>{reasons}</ul>" if reasons else ""
    alarm = f'<div class="fs-alarm">{html.escape(now.alarm)}</div>' if now.alarm else ""
    return (
        f'<div class="fs-banner fs-{now.kind.replace(" ", "-")}">{alarm}'
        f"<b>{html.escape(now.title)}</b><span>{html.escape(now.words)}</span>{listed}</div>"
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
        f"div:has(> {button}) {{ position: sticky; top: 0; z-index: 30; "
        "background: var(--fs-surface); padding-top: 6px; margin-top: -6px; }</style>"
    )
