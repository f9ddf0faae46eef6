"""The tab Fit: which model and which parameters, how far a fit is, and what it says."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Any

import viser

from agents.catalogue import MODELS, PLAYED
from agents.spec import Spec
from app.front.controls import set_value
from app.studies.run_axes import number_parameters
from app.tracks.playing.played_tracks import PlayedTracks
from app.tracks.tracks import PIXELS, Tracks
from app.viewer.lab.fits.cost_map import cost_map
from app.viewer.lab.fits.fit_worker import FitState, TracksFit
from app.viewer.lab.panels.tracks_panel import TracksPanel, usual_model
from app.viewer.panels.dials import set_visible
from app.viewer.panels.parameters import parameter_label
from app.viewer.panels.shell import block
from app.viewer.run.simulation_state import SimulationState
from app.viewer.run.stored_tracks import ModelStart, StoredTracks
from worlds.input_error import InputError
from worlds.number_text import counted

NONE = "none"
ABOUT = (
    "Each frame is foretold by the model's own rule from the frame before. The fit is judged on "
    "frames it has not seen, beside keeping the heading and beside headings shuffled in time."
)
NO_TRACKS = "Open tracks first, in the tab Tracks: a fit says what they tell of a model."


class FitPanel:
    """Begins one fit at a time, and shows it in all browsers."""

    def __init__(
        self,
        gui: viser.GuiApi,
        fit: TracksFit,
        tracks: TracksPanel,
        tick: Callable[[], int],
        tell: Callable[[str], None],
    ):
        self.fit, self.tracks, self.tick, self.tell = fit, tracks, tick, tell
        self.shown: FitState | None = None
        self.names: dict[str, str] = {}
        self.about = gui.add_html(block(f'<div class="fs-quiet">{NO_TRACKS}</div>'))
        titles = tuple(model.title for model in MODELS.values())
        self.model = gui.add_dropdown("Model", titles, initial_value=MODELS[usual_model()].title)
        self.first = gui.add_dropdown("Parameter", (NONE,), hint="What is looked for")
        self.second = gui.add_dropdown("And", (NONE,), hint="A second one makes a map of costs")
        self.every = gui.add_number(
            "Frames in a tick", 1, min=1, max=1000, step=1,
            hint="A tick of the model is so many frames of the tracks",
        )  # fmt: skip
        self.length = gui.add_number(
            "One length", 1.0, min=1e-6, max=1e9, step=1e-6,
            hint="How much of the tracks is one length of the model",
        )  # fmt: skip
        self.window = gui.add_number(
            "Smoothed over, s", 0.0, min=0.0, max=1e6, step=0.01,
            hint="Places and headings are smoothed first; 0: over 7 frames. A second, longer "
            "window says whether the answer hangs on it",
        )  # fmt: skip
        self.scale = gui.add_html("")
        self.go = gui.add_button("Fit", icon=viser.Icon.TARGET)
        self.stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, color="gray", visible=False)
        self.progress = gui.add_html("")
        self.result = gui.add_html("")
        self.begin_fitted = gui.add_button(
            "Start it here with these", icon=viser.Icon.GHOST, visible=False
        )
        self.offer()
        self.model.on_update(self.choose_model)
        self.go.on_click(self.begin)
        self.stop.on_click(self.end)
        self.begin_fitted.on_click(self.start_fitted)

    # What browsers ask for.

    async def choose_model(self, event: viser.GuiEvent) -> None:
        """Another model has other parameters."""
        if event.client is not None:
            self.offer()

    def offer(self) -> None:
        """Let the parameters of the chosen model be chosen: numbers, but for noise."""
        name = self.chosen()
        offered = [parameter for parameter in number_parameters(name) if not parameter.noise]
        self.names = {parameter_label(one)[0]: one.name for one in offered}
        labels = {name: label for label, name in self.names.items()}
        proposed = proposed_parameters(name)
        for place, control in enumerate((self.first, self.second)):
            control.options = (NONE, *self.names)
            wanted = labels[proposed[place]] if place < len(proposed) else NONE
            set_value(control, wanted)

    def chosen(self) -> str:
        """The name of the chosen model."""
        return next(name for name, one in MODELS.items() if one.title == self.model.value)

    def begin(self, event: viser.GuiEvent) -> None:
        """Begin what the form says."""
        if event.client is None:
            return
        try:
            tracks, request = self.request()
            self.fit.begin(tracks, request)
        except InputError as refusal:
            self.tell(str(refusal))

    def request(self) -> tuple[Tracks, Any]:
        """What the form says. Raises InputError."""
        from app.tracks.fit.fit_request import FitRequest

        if self.tracks.plain is None:
            raise InputError(NO_TRACKS)
        tracks = self.tracks.plain.tracks
        picked = dict.fromkeys(
            self.names[control.value]
            for control in (self.first, self.second)
            if control.value in self.names
        )
        request = FitRequest(
            models=(self.chosen(),),
            parameters=tuple(picked),
            every=int(self.every.value),
            length=float(self.length.value),
            window=float(self.window.value) or None,
        )
        return tracks, request

    def end(self, event: viser.GuiEvent) -> None:
        """Stop the fit that runs."""
        if event.client is not None:
            self.fit.stop()

    def start_fitted(self, event: viser.GuiEvent) -> None:
        """Start the fitted model in the frame that is shown, over the tracks."""
        state, plain = self.fit.state, self.tracks.plain
        if event.client is None or state.result is None or plain is None:
            return
        try:
            self.tracks.open_stored(fitted_start(state, plain, self.tick()), False)
        except InputError as refusal:
            self.tell(str(refusal))

    # What the page shows.

    def refresh(self, state: SimulationState) -> None:
        """Follow the fit, and the tracks that are played."""
        is_played = state.spec.model in PLAYED and self.tracks.plain is not None
        text = block(
            f'<div class="fs-quiet">{html.escape(ABOUT if is_played else NO_TRACKS)}</div>'
        )
        if self.about.content != text:
            self.about.content = text
        plain, now = self.tracks.plain, self.fit.state
        if plain is not None:
            label = f"One length ({plain.tracks.unit})"
            if self.length.label != label:
                self.length.label = label
                if plain.tracks.unit == PIXELS:
                    set_value(self.length, float(self.tracks.length.value))
                else:
                    set_value(self.length, 1.0)
            self.scale.content = block(self.describe_scale(plain))
        if self.go.disabled != (not is_played or now.running):
            self.go.disabled = not is_played or now.running
        if now is self.shown:
            return
        self.shown = now
        set_visible(self.stop, now.running)
        set_visible(self.begin_fitted, now.result is not None and not now.running)
        self.progress.content = block(describe_progress(now))
        self.result.content = block(describe_result(now))

    def describe_scale(self, plain: PlayedTracks) -> str:
        """How frames become ticks, HTML."""
        seconds = plain.tracks.step * int(self.every.value)
        unit = plain.tracks.unit
        words = (
            f"1 tick is {counted(int(self.every.value), 'frame')} ({seconds:.4g} s); "
            f"1 length is {float(self.length.value):.4g} {unit}."
        )
        return f'<div class="fs-quiet">{words}</div>'


def proposed_parameters(model: str) -> list[str]:
    """What is looked for at first: of a rule with zones the widths of the outer two, else the first
    length, or number."""
    offered = [parameter for parameter in number_parameters(model) if not parameter.noise]
    lengths = [one.name for one in offered if one.unit in ("length", "m")]
    if MODELS[model].rule.zones and len(lengths) >= 3:
        return lengths[1:3]
    return lengths[:1] or [one.name for one in offered[:1]]


def fitted_start(state: FitState, plain: PlayedTracks, tick: int) -> StoredTracks:
    """The tracks with the fitted model, which starts at a tick, with its best parameters. Raises
    InputError where other tracks are played by now."""
    assert state.result is not None
    assert state.request is not None
    if state.tracks is not plain.tracks:
        raise InputError("other tracks are played by now: open those of the fit again")
    fit = state.result.fits[0]
    length = state.request.length or 1.0
    played = plain if length == 1.0 else PlayedTracks(plain.tracks, length)
    seconds = plain.tracks.step * state.request.every
    spec = Spec(fit.model, parameters={**fit.fixed, **fit.best})
    return StoredTracks(played).with_model(ModelStart(spec, tick, 1.0 / seconds, is_over=True))


def describe_progress(state: FitState) -> str:
    """How far a fit is, or why there is none, HTML."""
    if state.running:
        words = html.escape(state.words or "preparing")
        return (
            f'<div class="fs-compiling"><b>Fitting</b>: {words}'
            f'<i><i style="width:{100.0 * state.share:.0f}%"></i></i></div>'
        )
    if state.refusal:
        return f'<div class="fs-error"><b>No fit.</b> {html.escape(state.refusal)}</div>'
    return ""


def describe_result(state: FitState) -> str:
    """What a fit says, with a map of its costs, HTML."""
    if state.result is None:
        return ""
    fit = state.result.fits[0]
    verdict = "".join(f"<p>{html.escape(line)}</p>" for line in fit.sentences())
    others = [line for line in state.result.sentences() if line not in fit.sentences()]
    more = "".join(f"<p>{html.escape(line)}</p>" for line in others)
    return f'{verdict}<div class="fs-fit">{cost_map(fit)}</div><div class="fs-quiet">{more}</div>'
