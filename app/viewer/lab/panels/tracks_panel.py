"""Tracks in the laboratory: opened from a file, what they are, and a model that starts in them."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Callable
from typing import Any

import viser

from agents.catalogue import MODELS, PLAYED
from agents.spec import Spec
from app.front.controls import set_value
from app.tracks.playing.played_tracks import PlayedTracks
from app.tracks.tracks import PIXELS, UNITS
from app.viewer.gallery.tracks_opener import TracksFields, open_tracks
from app.viewer.panels.dials import set_visible
from app.viewer.panels.shell import block, table
from app.viewer.run.allowance import Allowance
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from app.viewer.run.stored_flock import LARGEST
from app.viewer.run.stored_tracks import (
    ModelStart,
    StoredTracks,
    proposed_length,
    proposed_ticks,
)
from worlds.input_error import InputError
from worlds.number_text import counted

OF_FILE = "as the file says"
TOPIC = "biology"
BESIDE, OVER = "beside the tracks", "over the tracks"
FIELDS = {
    "--rate": "Frames per second",
    "--unit": "Unit of places",
    "--scale": "Metres in a pixel",
    "--origin": "Where y begins",
}
"""The options of the command line, and the fields of the page that say the same."""
MOST_NOTES = 6
"""Lines of notes that are shown."""


class TracksPanel:
    """Opens tracks, says what they are, and starts a model in them.

    `open_stored` plays tracks in all browsers; its second argument says whether they are others
    than those before. `tell` takes what is refused.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        simulation: Simulation,
        open_stored: Callable[[StoredTracks, bool], None],
        tell: Callable[[str], None],
        allowance: Allowance | None = None,
    ):
        self.simulation, self.open_stored, self.tell = simulation, open_stored, tell
        self.allowance = allowance
        self.plain: PlayedTracks | None = None
        """The tracks that are played, in their own unit."""
        self.waiting: tuple[str, bytes] | None = None
        """A file that was not read, since it does not say all."""
        self.shown: object = None
        self.fitted: object = None
        self.status = gui.add_html("")
        self.upload = gui.add_upload_button(
            "Open tracks ...",
            icon=viser.Icon.UPLOAD,
            color="gray",
            hint="Where animals, people or robots were, of any format that `flockscope tracks` "
            f"reads, up to {LARGEST // 10**6} MB: replaces the run in all browsers",
        )
        gui.add_html(block(f'<div class="fs-quiet">{html.escape(LARGER)}</div>'))
        self.fault = gui.add_html("")
        self.again = gui.add_button("Read the file with these", visible=False)
        self.facts = gui.add_html("")
        self.within = gui.add_number(
            "Neighbours within", 1.0, min=0.0, max=1e9, step=0.001, visible=False,
            hint="How far apart individuals are neighbours, and of one group",
        )  # fmt: skip
        self.form = gui.add_folder("Start a model here", visible=False)
        titles = tuple(model.title for model in MODELS.values())
        with self.form:
            gui.add_html(block(f'<div class="fs-quiet">{html.escape(ABOUT)}</div>'))
            self.model = gui.add_dropdown(
                "Model", titles, initial_value=MODELS[usual_model()].title, hint="Its rule"
            )
            self.drawn = gui.add_dropdown(
                "Drawn", (OVER, BESIDE), hint="Over them the individuals are hollow, as ghosts"
            )
            self.ticks = gui.add_number(
                "Ticks of the model in 1 s", 1.0, min=1e-6, max=1e4, step=1e-6,
                hint="How fast the model's time goes; proposed such that its agents go at the "
                "median speed of the tracks",
            )  # fmt: skip
            self.length = gui.add_number(
                "One length", 1.0, min=1e-6, max=1e9, step=1e-6,
                hint="How much of the tracks is one length of the model; of pixels proposed as the "
                "median distance to the nearest other",
            )  # fmt: skip
            self.mapping = gui.add_html("")
            self.start = gui.add_button("Start a model here", icon=viser.Icon.GHOST)
        self.stop = gui.add_button("Tracks alone", icon=viser.Icon.X, color="gray", visible=False)
        with gui.add_folder("What the file does not say", expand_by_default=False) as self.folder:
            self.rate = gui.add_number(
                FIELDS["--rate"], 0.0, min=0.0, max=1e6, step=0.001, hint="0: as the file says"
            )
            self.unit = gui.add_dropdown(
                FIELDS["--unit"], (OF_FILE, *UNITS, PIXELS), hint="Of the numbers in the file"
            )
            self.scale = gui.add_number(
                FIELDS["--scale"], 0.0, min=0.0, max=1e3, step=1e-6, hint="0: pixels stay pixels"
            )
            self.origin = gui.add_dropdown(
                FIELDS["--origin"],
                (OF_FILE, "top-left", "bottom-left"),
                hint="top-left: y points down, as in the pictures of a camera",
            )
        self.upload.on_upload(self.take_upload)
        self.again.on_click(self.read_again)
        self.model.on_update(self.choose_model)
        self.within.on_update(self.set_within)
        self.start.on_click(self.start_model)
        self.stop.on_click(self.stop_model)

    # What browsers ask for.

    def take_upload(self, event: viser.GuiEvent) -> None:
        """Read a file; called aside, since a process of its own reads it."""
        file = event.target.value
        self.read(file.name, file.content)

    def read_again(self, event: viser.GuiEvent) -> None:
        """Read the file that does not say all, with what the fields say."""
        if event.client is not None and self.waiting is not None:
            self.read(*self.waiting)

    def read(self, name: str, content: bytes) -> None:
        """Play what is in a file, or say what is missing."""
        try:
            if self.allowance is not None:
                self.allowance.demand_recordings(name)
            stored = StoredTracks(PlayedTracks(open_tracks(name, content, self.fields())))
            self.open_stored(stored, True)
        except InputError as refusal:
            self.refuse(name, content, str(refusal))
            return
        self.waiting = None
        set_visible(self.again, False)
        self.fault.content = ""

    def refuse(self, name: str, content: bytes, why: str) -> None:
        """Say why a file is not read, and which field mends it, if one does."""
        asked = [field for option, field in FIELDS.items() if option in why]
        self.waiting = (name, content) if asked else None
        set_visible(self.again, bool(asked))
        text = html.escape(in_page_words(why))
        more = ""
        if asked:
            more = "<br>Fill in what is missing below, then press <b>Read the file with these</b>."
        self.fault.content = block(f'<div class="fs-error"><b>Not read.</b> {text}{more}</div>')
        self.tell(in_page_words(why))

    def fields(self) -> TracksFields:
        """What the fields say; None for what is left to the file."""
        return TracksFields(
            rate=self.rate.value or None,
            unit=None if self.unit.value == OF_FILE else self.unit.value,
            scale=self.scale.value or None,
            origin=None if self.origin.value == OF_FILE else self.origin.value,
        )

    async def choose_model(self, event: viser.GuiEvent) -> None:
        """Another model brings its own ticks."""
        if event.client is not None:
            self.propose()

    def propose(self) -> None:
        """The scale of the chosen model, as it follows from the tracks."""
        if self.plain is None:
            return
        length = proposed_length(self.plain)
        set_value(self.length, length)
        played = self.plain if length == 1.0 else PlayedTracks(self.plain.tracks, length)
        set_value(self.ticks, proposed_ticks(played, Spec(self.chosen())))

    def chosen(self) -> str:
        """The name of the chosen model."""
        return next(name for name, one in MODELS.items() if one.title == self.model.value)

    async def set_within(self, event: viser.GuiEvent) -> None:
        """Change what counts as near."""
        if event.client is not None:
            self.simulation.set("within", float(self.within.value))

    def start_model(self, event: viser.GuiEvent) -> None:
        """Start the chosen model in the frame that is shown."""
        frame = self.simulation.frame
        if event.client is None or self.plain is None or frame is None:
            return
        try:
            length = float(self.length.value)
            plain = self.plain
            played = plain if length == plain.length else PlayedTracks(plain.tracks, length)
            start = ModelStart(
                Spec(self.chosen()), frame.tick, float(self.ticks.value), self.drawn.value == OVER
            )
            self.open_stored(StoredTracks(played).with_model(start), False)
        except InputError as refusal:
            self.tell(str(refusal))

    async def stop_model(self, event: viser.GuiEvent) -> None:
        """Play the tracks alone, from where they are."""
        frame = self.simulation.frame
        if event.client is not None and self.plain is not None and frame is not None:
            self.open_stored(StoredTracks(self.plain).without_model(frame.tick), False)

    # What the page shows.

    def follow(self, stored: StoredTracks) -> None:
        """Other tracks are played."""
        played = stored.recording
        if self.plain is None or played.tracks is not self.plain.tracks:
            self.plain = played if played.length == 1.0 else PlayedTracks(played.tracks)
            self.propose()

    def refresh(self, state: SimulationState) -> None:
        """Say what is played."""
        stored = state.stored
        is_played = isinstance(stored, StoredTracks) and state.spec.model in PLAYED
        set_visible(self.form, is_played)
        set_visible(self.within, is_played)
        set_visible(self.stop, is_played and state.beside is not None)
        if not is_played or not isinstance(stored, StoredTracks):
            if self.shown is not None or not self.status.content:
                self.status.content = block(f'<div class="fs-quiet">{html.escape(OPENS)}</div>')
                self.facts.content, self.shown = "", None
            return
        if self.shown is not stored:
            self.shown = stored
            self.follow(stored)
            self.status.content = ""
            self.facts.content = block(describe_tracks(stored.recording))
            unit = stored.recording.length_unit
            self.within.label = f"Neighbours within ({unit})"
            self.length.label = f"One length ({stored.recording.tracks.unit})"
            set_value(self.within, float(f"{state.values.get('within', 1.0):.4g}"))
        self.mapping.content = block(self.describe_mapping(stored))

    def describe_mapping(self, stored: StoredTracks) -> str:
        """How seconds become ticks, and lengths lengths, HTML."""
        start, unit = stored.start, stored.recording.tracks.unit
        if start is not None:
            title = MODELS[start.spec.model].title
            words = mapping_words(start.ticks_per_second, stored.recording.length, unit)
            at = start.tick * stored.recording.time_per_tick
            text = f"<b>{html.escape(title)}</b> started at {at:.2f} s: {words}"
            return f'<div class="fs-quiet">{text}</div>'
        words = mapping_words(float(self.ticks.value), float(self.length.value), unit)
        return f'<div class="fs-quiet">{words}</div>'


ABOUT = (
    "The model starts from the places, smoothed headings and speeds of those who are seen in this "
    "frame, in the world of the tracks."
)
LARGER = "Larger files: flockscope lab --tracks FILE"
OPENS = (
    "Play tracks of real animals, people or robots, measure them as a flock, and start a model in "
    "any of their frames."
)


def usual_model() -> str:
    """The model that is proposed to be set beside tracks: the first of animals with zones, whose
    time is counted in seconds as that of tracks is."""
    return next(
        name
        for name, one in MODELS.items()
        if one.rule.zones and TOPIC in one.rule.tags and one.body.unit != "ticks"
    )


def in_page_words(line: str) -> str:
    """A refusal with the fields of the page for the options of the command line.

    >>> in_page_words("a.npy does not say its rate: give --rate")
    'a.npy does not say its rate: give Frames per second'
    """
    return re.sub(r"--(rate|unit|scale|origin)\b", lambda found: FIELDS[found[0]], line)


def mapping_words(ticks: float, length: float, unit: str) -> str:
    """How the time and the lengths of a model go with those of tracks.

    >>> mapping_words(10.0, 70.7, "px")
    '1 s is 10 ticks (a tick is 0.1 s); 1 length is 70.7 px.'
    """
    each = 1.0 / ticks if ticks > 0.0 else math.inf
    return f"1 s is {ticks:.4g} ticks (a tick is {each:.3g} s); 1 length is {length:.4g} {unit}."


def describe_tracks(played: PlayedTracks) -> str:
    """What tracks are, HTML."""
    tracks = played.tracks
    apart = f"{1.0 / tracks.step:.4g} frames/s" if tracks.step == tracks.step else "one frame"
    if not tracks.is_even:
        apart = f"{apart} as a rule, uneven"
    rows: dict[str, Any] = {
        "individuals": f"{played.count}, {played.usual} at a time",
        "frames": f"{len(tracks.frame)}, {apart}",
        "lasts": f"{tracks.time[-1] - tracks.time[0]:.4g} s",
        "unit": tracks.unit,
        "spacing": f"{played.spacing * played.length:.3g} {tracks.unit}",
        "median speed": f"{played.median_speed * played.length:.3g} {tracks.unit}/s",
        "read as": tracks.format or "tracks",
    }
    notes = [str(dropped) for dropped in tracks.dropped] + list(tracks.notes)
    if len(notes) > MOST_NOTES:
        notes = [
            *notes[: MOST_NOTES - 1],
            f"and {counted(len(notes) - MOST_NOTES + 1, 'more note')}",
        ]
    lines = "".join(f"<p>{html.escape(note)}</p>" for note in notes)
    head = f'<h2 class="fs-head">{html.escape(played.name)}</h2>'
    cells = {html.escape(name): html.escape(str(value)) for name, value in rows.items()}
    return f'{head}{table(cells)}<div class="fs-quiet">{lines}</div>'
