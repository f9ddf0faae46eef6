"""The top of the panel, which is always in view: the banner, and the buttons that count.

The emergency stop works in every state and from the moment that the button goes down.
"""

from __future__ import annotations

import html
from dataclasses import dataclass, replace
from typing import Literal

import viser

from app.front.controls import set_value
from app.front.viser_internals import GuiModalHandle, identifier
from app.live.control.loop_status import Status
from app.live.links.link import RUN
from app.viewer.live.session import TRIES, Session
from app.viewer.live.session_requests import SessionState
from app.viewer.panels.shell import block

# The banner at the top of the panel: the state of the cars in large, plain words.

MOVES = "A CAR MOVES THOUGH TOLD TO STAND"
"""The alarm of a car that moves in whatever state; what to do follows in the reasons."""
NO_BROWSER = f"no browser arms after {TRIES} wrong codes; the key a in the terminal does"
EMULATED_CARS = "EMULATED CARS"
"""Stands beside the title where no real car is driven."""
MOST = 4
"""Reasons that are listed one by one."""
Kind = Literal["opening", "failed", "replay", "safe", "running", "held up", "emergency"]


@dataclass(frozen=True)
class Banner:
    """A title, a sentence, and reasons."""

    kind: Kind
    title: str
    words: str
    """One sentence."""
    reasons: tuple[str, ...] = ()
    """Why the cars do not run, or cannot be armed, and what else is wrong."""
    alarm: str = ""
    """What a person must act on at once, in large letters above all else; empty: nothing."""
    before: str = ""
    """Why the cars were disarmed or stopped last; empty: they were not."""
    emulated: bool = False
    """Whether the cars are emulated."""
    waits: bool = False
    """Whether something is being compiled, of which nobody knows how long it takes."""

    @property
    def can_be_armed(self) -> bool:
        """Whether the cars can be armed."""
        return self.kind == "safe" and not self.reasons


def banner_of(state: SessionState, status: Status | None) -> Banner:
    """The banner of a session with this state and this newest status of its loop."""
    banner = banner_of_phase(state, status)
    if state.phase == "replay":
        return banner
    stands = banner.kind in ("safe", "emergency")
    return replace(banner, before=state.disarmed if stands else "", emulated=state.emulated)


def banner_of_phase(state: SessionState, status: Status | None) -> Banner:
    """The banner without what is said of the cars in whatever phase."""
    if state.phase == "opening":
        if state.latched:
            return Banner("emergency", "EMERGENCY STOP", "Opening; it begins stopped.")
        words = state.compiling or "Waiting for the control loop."
        words = words[:1].upper() + words[1:]
        return Banner("opening", "Opening …", words, waits=bool(state.compiling))
    if state.phase == "replay":
        words = "An earlier recording. The room is closed: nothing is sent to any car."
        late = ("an emergency stop is latched",) if state.latched else ()
        return Banner("replay", "REPLAY", words, late)
    if state.phase != "open":
        title = "Closed" if state.phase == "closed" else "Not open"
        return Banner("failed", title, state.trouble or "The cars stop themselves.")
    if status is None:
        return Banner("opening", "Opening …", "Waiting for the control loop.")
    return banner_of_open(status, state.browsers_arm)


def banner_of_open(status: Status, browsers_arm: bool = True) -> Banner:
    """The banner of an open session."""
    moves = [reason.words for reason in status.reasons if reason.kind == "moves"]
    others = [reason.words for reason in status.reasons if reason.kind != "moves"]
    wrong = [f"{what}: {words}" for what, words in status.troubles.items()]
    alarm = MOVES if moves else ""
    if status.arm == "emergency":
        title, words = "EMERGENCY STOP", "All cars are told to stop."
        return Banner("emergency", title, words, first_reasons(moves + wrong), alarm)
    if status.arm == "safe":
        reasons = moves + ([] if browsers_arm else [NO_BROWSER]) + others
        words = "Cannot be armed:" if reasons else "No car is driven. Ready to be armed."
        return Banner("safe", "SAFE", words, first_reasons(reasons + wrong), alarm)
    if status.mode == RUN:
        return Banner("running", "ARMED", "The cars run.", first_reasons(wrong))
    words = "They go on by themselves once it is over:"
    return Banner(
        "held up", "ARMED, but stopped", words, first_reasons(moves + others + wrong), alarm
    )


def first_reasons(reasons: list[str]) -> tuple[str, ...]:
    """The first few of them.

    >>> first_reasons(["a", "b", "c", "d", "e", "f"])
    ('a', 'b', 'c', 'and 3 more')
    """
    if len(reasons) <= MOST:
        return tuple(reasons)
    return (*reasons[: MOST - 1], f"and {len(reasons) - MOST + 1} more")


# Asks once more before the cars drive, and for the code that the terminal shows.

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
        emulated = self.session.state.emulated
        question = arming_question(list(self.session.lab.cars), emulated)
        modal = client.gui.add_modal("Arm the emulated cars?" if emulated else "Arm?")
        with modal:
            client.gui.add_html(block(question))
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
            self.confirm(number)

        cancel.on_click(cancelled)
        arm.on_click(armed)

    def confirm(self, number: int) -> None:
        """A browser says yes: arm if its code is right, else say so and ask again."""
        question = self.open.get(number)
        if question is None:
            return
        verdict = self.session.arm_by_code(question.code.value, f"browser {number}")
        set_value(question.code, "")
        if verdict in ("right", "off"):
            self.close(number)
        elif verdict == "no code":
            question.message.content = block(line(f"{NO_CODE} {ASKED}"))
        else:
            tries = describe_tries(self.session.code.left)
            words = f"<b>Wrong code.</b> {tries} for all browsers together."
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


def arming_question(cars: list[str], emulated: bool = False) -> str:
    """What is asked of real cars, or of emulated ones."""
    kind = "emulated car" if emulated else "car"
    count = f"1 {kind}" if len(cars) == 1 else f"{len(cars)} {kind}s"
    clear = "No real car moves." if emulated else "Is the area clear?"
    return (
        f'<div class="fs-question"><b>{count} will drive</b> ({html.escape(", ".join(cars))}). '
        f"{clear}<br>Space or Esc stops them, in every browser.</div>"
    )


def line(words: str) -> str:
    """What is said below the field, as HTML."""
    return f'<div class="fs-quiet">{words}</div>'


def describe_tries(count: int) -> str:
    """How many are left, in words.

    >>> describe_tries(1)
    '1 try is left'
    """
    return "1 try is left" if count == 1 else f"{count} tries are left"


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
        gui.add_html(button_style(identifier(self.stop)))
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
        self.stop.on_click(self.stop_cars)
        self.stop.on_hold(self.stop_cars, callback_hz=STEADY)
        self.arm.on_click(self.arming)
        self.disarm.on_click(self.disarmed)
        self.reset.on_click(self.reset_asked)
        self.again.on_click(self.reopen_loop)

    async def stop_cars(self, event: viser.GuiEvent) -> None:
        self.session.emergency(describe_client(event))

    async def arming(self, event: viser.GuiEvent) -> None:
        now = banner_of(self.session.state, self.session.status)
        if not now.can_be_armed:
            self.session.notices.put("; ".join(("cannot be armed now", *now.reasons)))
        elif event.client is not None:
            self.confirming.ask(event.client)

    async def disarmed(self, event: viser.GuiEvent) -> None:
        self.session.ask("disarm", describe_client(event))

    async def reset_asked(self, event: viser.GuiEvent) -> None:
        self.session.ask("reset", describe_client(event))

    async def reopen_loop(self, event: viser.GuiEvent) -> None:
        self.session.reopen(describe_client(event))

    def refresh(self, state: SessionState, status: Status | None) -> None:
        """Show the state of the cars."""
        now = banner_of(state, status)
        self.banner.content = block(banner_html(now))
        self.arm.visible = now.kind == "safe"
        self.arm.disabled = not now.can_be_armed
        self.disarm.visible = now.kind in ("running", "held up")
        self.reset.visible = now.kind == "emergency" and state.phase == "open"
        self.again.visible = now.kind in ("failed", "replay") and state.phase != "closed"
        self.again.label = "Back to the room" if now.kind == "replay" else "Open again"
        if now.kind != "safe" or not state.browsers_arm:
            self.confirming.withdraw()


def describe_client(event: viser.GuiEvent) -> str:
    """Who asks, for the log."""
    return f"browser {event.client_id}"


def banner_html(now: Banner) -> str:
    """A banner as HTML, in the colour of its kind."""
    reasons = "".join(f"<li>{html.escape(reason)}</li>" for reason in now.reasons)
    listed = f"<ul>{reasons}</ul>" if reasons else ""
    alarm = f'<div class="fs-alarm">{html.escape(now.alarm)}</div>' if now.alarm else ""
    title = f"{now.title} · {EMULATED_CARS}" if now.emulated else now.title
    bar = '<i class="fs-waiting"><i></i></i>' if now.waits else ""
    before = f"<p>Why: {html.escape(now.before)}.</p>" if now.before else ""
    return (
        f'<div class="fs-banner fs-{now.kind.replace(" ", "-")}">{alarm}'
        f"<b>{html.escape(title)}</b><span>{html.escape(now.words)}</span>{before}{bar}{listed}</div>"
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
