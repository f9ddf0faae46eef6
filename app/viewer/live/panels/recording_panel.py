"""Recording: begun and ended while the room is open; earlier ones are played."""

from __future__ import annotations

import html
import time
from pathlib import Path

import viser

from app.front.controls import set_value
from app.viewer.live.panels.state_panel import describe_client
from app.viewer.live.room_replay import RoomReplay, recording_names, size
from app.viewer.live.session import Session
from app.viewer.live.session_requests import SessionState
from app.viewer.panels.shell import block

NONE = "none"
LOOK = 1.0
"""Seconds between two looks at the disk."""
HELD = 0.5
"""Seconds after somebody has moved the time line for which nothing else moves it."""
SPEEDS = {"1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "4": 4.0, "10": 10.0}
STEP = 0.05
"""Of the time line, s."""


class ReplayPanel:
    """In view while an earlier recording plays: how far it is, pause and speed."""

    def __init__(self, gui: viser.GuiApi, session: Session):
        self.session = session
        self.moved = 0.0
        self.name = gui.add_html("", visible=False)
        self.slider = gui.add_slider(
            "Time, s", 0.0, 1.0, STEP, 0.0, visible=False, hint="Drag to any time of the recording"
        )
        self.speed = gui.add_dropdown(
            "Speed", tuple(SPEEDS), initial_value="1", visible=False, hint="Times as fast as it was"
        )
        self.switch = gui.add_button(
            "Pause", icon=viser.Icon.PLAYER_PAUSE, color="gray", visible=False
        )
        self.slider.on_update(self.drag_slider)
        self.speed.on_update(self.set_pace)
        self.switch.on_click(self.toggle_playing)

    async def drag_slider(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.moved = time.monotonic()
            self.session.seek(float(self.slider.value))

    async def set_pace(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.session.replay_at(SPEEDS[self.speed.value])

    async def toggle_playing(self, _event: viser.GuiEvent) -> None:
        self.session.toggle_replay()

    def refresh(self) -> None:
        """Follow the recording that plays, if one does."""
        played = self.session.replaying
        for control in (self.name, self.slider, self.speed, self.switch):
            if control.visible != (played is not None):
                control.visible = played is not None
        if played is None:
            return
        self.name.content = block(f'<div class="fs-quiet">{html.escape(played.name)}</div>')
        if self.slider.max != max(played.seconds, STEP):
            self.slider.max = max(played.seconds, STEP)
            set_value(self.speed, "1")
        if time.monotonic() - self.moved > HELD:
            set_value(self.slider, round(min(played.time, played.seconds), 2))
        self.switch.label = "Pause" if played.plays else "Play"
        self.switch.icon = viser.Icon.PLAYER_PAUSE if played.plays else viser.Icon.PLAYER_PLAY


def describe_moment(played: RoomReplay) -> str:
    """Of which moment of a recording all is that is shown."""
    return (
        f"As it was {min(played.time, played.seconds):.1f} s into {played.name}, not as it is now."
    )


class RecordingPanel:
    """A button that begins and ends the recording, and a list of those that are there."""

    def __init__(self, gui: viser.GuiApi, session: Session, line: viser.GuiHtmlHandle):
        """`line` is in view whichever tab is open: it says that something is recorded."""
        self.session = session
        self.line = line
        self.due = 0.0
        self.begun: tuple[str, float] = "", 0.0
        """The folder of the recording that goes on, and since when, s."""
        self.told = gui.add_html("")
        self.button = gui.add_button(
            "Record",
            icon=viser.Icon.PLAYER_RECORD,
            color="red",
            hint="Poses, commands and events go to a new folder on the machine of the room",
        )
        self.earlier = gui.add_dropdown(
            "Earlier", (NONE,), hint="Recordings in the folder, by the time at which they began"
        )
        self.play = gui.add_button(
            "Show this recording",
            icon=viser.Icon.HISTORY,
            color="gray",
            hint="Closes the room and shows the recording; nothing is sent to any car meanwhile",
        )
        self.button.on_click(self.toggle_recording)
        self.play.on_click(self.open_recording)

    async def toggle_recording(self, event: viser.GuiEvent) -> None:
        self.session.record(not self.session.state.recording, describe_client(event))

    async def open_recording(self, event: viser.GuiEvent) -> None:
        if self.earlier.value != NONE:
            self.session.play(self.earlier.value, describe_client(event))

    def refresh(self, state: SessionState, armed: bool) -> None:
        """Show what is recorded, and once a second what is there."""
        now = time.monotonic()
        if state.recording != self.begun[0]:
            self.begun, self.due = (state.recording, now), 0.0
        self.button.label = "Stop recording" if state.recording else "Record"
        self.button.icon = viser.Icon.PLAYER_STOP if state.recording else viser.Icon.PLAYER_RECORD
        self.button.disabled = state.phase != "open" or self.session.shelf is None
        self.play.disabled = armed or self.earlier.value == NONE
        if now < self.due:
            return
        self.due = now + LOOK
        names = recording_names(self.session.shelf) or (NONE,)
        if tuple(self.earlier.options) != names:
            self.earlier.options = names
            set_value(self.earlier, names[0])
        self.told.content = block(describe_folder(state, self.session.shelf))
        if state.recording:
            self.line.content = block(describe_size(state.recording, now - self.begun[1]))
        self.line.visible = bool(state.recording)


def describe_size(folder: str, seconds: float) -> str:
    """How long something has been recorded, and how large it is, HTML."""
    minutes, rest = divmod(int(seconds), 60)
    return (
        '<div class="fs-status"><span class="fs-dot" style="background:#d6001c"></span>'
        f"<span><b>recording</b> · {minutes}:{rest:02d} · {size(Path(folder)) / 1e6:.1f} MB</span>"
        "</div>"
    )


def describe_folder(state: SessionState, shelf: Path | None) -> str:
    """Where something is recorded, or would be, HTML."""
    if state.recording:
        words = f"Recorded in {state.recording}."
    else:
        words = "Nothing is recorded." + ("" if shelf is None else f" Recordings are in {shelf}.")
    return f'<div class="fs-quiet">{html.escape(words)}</div>'
