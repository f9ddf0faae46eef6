"""The lesson: steps of the scene, one at a time, each with its sliders, and a prediction that the
flock's own run judges."""

from __future__ import annotations

import html
import math
import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import viser

from agents.models.declare import NumberParameter
from agents.spec import CompleteSpec, Spec
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_steps import SceneStep, number_parameters, step_spec
from app.viewer.measuring.observable_format import (
    format_observable,
    format_thousands,
    observable_words,
)
from app.viewer.panels.dials import plain_symbol
from app.viewer.panels.followed_value import FollowedValue
from app.viewer.panels.parameters import ParametersPanel, add_control
from app.viewer.panels.shell import block
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from app.viewer.run.step_trial import StepTrial

BACK, NEXT = "Back", "Next"
RUN, AGAIN = "Run it", "Run it again"


@dataclass
class StepProgress:
    """What a reader has done at one step."""

    choice: int = -1
    """Which answer was chosen; -1: none yet."""
    is_fixed: bool = False
    """Whether the step's run was begun: from then on the prediction stays."""
    trial: StepTrial | None = None
    """The last run of the step."""
    mean: float = math.nan
    """What the last run that was judged has shown."""


@dataclass
class LessonPanel:
    """Leads through the steps of a scene; hidden where the scene has none.

    All browsers see one flock, and so one lesson. `set_up` is told which run is built for a step,
    `watch` which observable is to be plotted first.
    """

    gui: viser.GuiApi
    simulation: Simulation
    parameters: ParametersPanel
    set_up: Callable[[CompleteSpec, Spec | None], None]
    watch: Callable[[str], None]
    scene: SavedScene | None = None
    number: int = 0
    """Of the step that is shown, from 0."""
    progress: list[StepProgress] = field(default_factory=list)
    sliders: dict[str, Any] = field(default_factory=dict)
    """Controls of the step that is shown, by parameter."""
    followed: dict[str, FollowedValue] = field(default_factory=dict)
    """What keeps each of them at the flock's value."""
    answers: list[Any] = field(default_factory=list)
    """A button for each choice."""
    made: list[Any] = field(default_factory=list)
    """All controls of the step that is shown."""

    def __post_init__(self) -> None:
        self.lock = threading.Lock()
        """Held while controls are made anew: buttons are pressed on another thread."""
        self.folder = self.gui.add_folder("Lesson", visible=False)
        self.run: Any = None
        self.verdict: Any = None

    @property
    def steps(self) -> tuple[SceneStep, ...]:
        """The steps of the scene."""
        return () if self.scene is None else self.scene.steps

    @property
    def step(self) -> SceneStep:
        """The step that is shown."""
        return self.steps[self.number]

    @property
    def now(self) -> StepProgress:
        """How far the reader is with it."""
        return self.progress[self.number]

    def follow(self, scene: SavedScene | None, state: SimulationState) -> None:
        """Show the lesson of a scene from its first step, if it is another; else what goes on."""
        with self.lock:
            if scene is not self.scene:
                self.scene, self.number = scene, 0
                self.progress = [StepProgress() for _ in self.steps]
                self.folder.visible = bool(self.steps)
                self.show()
            if self.steps:
                self.refresh(state)

    def show(self) -> None:
        """Make the controls of the step."""
        for control in self.made:
            control.remove()
        self.made = []
        self.sliders, self.followed = {}, {}
        self.answers, self.run, self.verdict = [], None, None
        if not self.steps or self.scene is None:
            return
        step = self.step
        with self.folder:
            self.made.append(self.gui.add_html(block(sentence(self.number, len(self.steps), step))))
            sliders = number_parameters(self.scene.spec.model)
            for name in step.controls:
                self.sliders[name] = self.add_slider(sliders[name])
            if step.ask:
                self.add_prediction(step)
            buttons = self.gui.add_button_group("Steps", (BACK, NEXT))
            buttons.on_click(self.move)
            self.made += [*self.sliders.values(), buttons]
        if step.shown_observable:
            self.watch(step.shown_observable)

    def add_slider(self, parameter: NumberParameter) -> Any:
        """A slider that moves that of the Rule tab."""
        state, name = self.simulation.state, parameter.name
        slider = add_control(self.gui, parameter, state.values.get(name, parameter.default))

        def send(value: Any, _event: viser.GuiEvent) -> Future:
            self.parameters.remember_value(name, False)
            return self.parameters.set_parameter(name, value, False)

        def now() -> Any:
            return self.simulation.state.values.get(name, parameter.default)

        self.followed[name] = FollowedValue(slider, send, now)
        return slider

    def add_prediction(self, step: SceneStep) -> None:
        """The question, a button for each answer, and what runs the step."""
        asked = block(f'<div class="fs-try"><b>{html.escape(step.ask)}</b></div>')
        self.made.append(self.gui.add_html(asked))
        for number, words in enumerate(step.choices):
            button = self.gui.add_button(words, color="gray")
            button.on_click(partial(self.choose, number))
            self.answers.append(button)
        self.made += [*self.answers, self.gui.add_html(block(self.describe_run(step)))]
        # Not the icon of Go: by that the page finds the button that it keeps in reach.
        self.run = self.gui.add_button(RUN, icon=viser.Icon.FLASK, color="green")
        self.run.disabled = True
        self.run.on_click(self.begin)
        self.verdict = self.gui.add_html("")
        self.made += [self.run, self.verdict]

    def describe_run(self, step: SceneStep) -> str:
        """What the button runs, HTML."""
        assert self.scene is not None
        sliders = number_parameters(self.scene.spec.model)
        values = [
            f"{plain_symbol(sliders[name].symbol) if name in sliders else name} = {value:g}"
            for name, value in step.set.items()
        ]
        start = f", with {', '.join(values)}" if values else ""
        words = f"{format_thousands(step.ticks)} ticks from the start{start}."
        return f'<div class="fs-quiet">{html.escape(words)}</div>'

    async def move(self, event: viser.GuiEvent) -> None:
        """Go to the step before or after, if there is one."""
        to = self.number + (1 if event.target.value == NEXT else -1)
        with self.lock:
            if 0 <= to < len(self.steps):
                self.number = to
                self.show()

    async def choose(self, number: int, _event: viser.GuiEvent) -> None:
        """Predict an answer; once the run was begun it stays."""
        with self.lock:
            if not self.now.is_fixed and number < len(self.step.choices):
                self.now.choice = number
                self.show_state()

    async def begin(self, _event: viser.GuiEvent) -> None:
        """Run the step from its start: from here on the prediction stays as it is."""
        with self.lock:
            step, now = self.step, self.now
            if now.choice < 0 or self.lacks(step) or self.scene is None:
                return
            now.is_fixed = True
            now.trial = StepTrial(step.measure, step.first_measured_tick, step.ticks)
            spec = step_spec(self.scene.spec, step)
            self.set_up(spec, None)
            self.simulation.try_step(spec, now.trial)
            self.simulation.go()
            self.show_state()

    def lacks(self, step: SceneStep) -> str:
        """What has to be done before a step can be run; empty: nothing."""
        if self.progress[self.steps.index(step)].choice < 0:
            return "Choose an answer first."
        if step.than and math.isnan(self.progress[step.than - 1].mean):
            return f"Run step {step.than} first."
        return ""

    def refresh(self, state: SimulationState) -> None:
        """Follow the flock: sliders, and the run of the step."""
        for name, followed in self.followed.items():
            if name in state.values:
                followed.follow(state.values[name])
        for progress in self.progress:
            trial = progress.trial
            if trial is not None and trial.is_over and not trial.fault:
                progress.mean = trial.mean
        self.show_state()

    def show_state(self) -> None:
        """Show what is chosen, what goes on, and what the run has shown."""
        if self.run is None:
            return
        step, now = self.step, self.now
        for number, button in enumerate(self.answers):
            is_chosen = number == now.choice
            update(
                button,
                color="blue" if is_chosen else "gray",
                icon=viser.Icon.CHECK if is_chosen else None,
                disabled=now.is_fixed,
            )
        goes_on = now.trial is not None and not now.trial.is_over
        update(self.run, label=AGAIN if now.is_fixed else RUN, disabled=bool(self.lacks(step)))
        content = block(self.describe_trial(step, now, goes_on))
        if self.verdict.content != content:
            self.verdict.content = content

    def describe_trial(self, step: SceneStep, now: StepProgress, goes_on: bool) -> str:
        """How the run of a step stands, and what it shows, HTML."""
        if now.trial is None:
            return f'<div class="fs-quiet">{self.lacks(step)}</div>'
        if goes_on:
            frame = self.simulation.frame
            tick = min(0 if frame is None else frame.tick, step.ticks)
            words = f"Tick {format_thousands(tick)} of {format_thousands(step.ticks)}."
            return f'<div class="fs-quiet">{words}</div>'
        than = self.progress[step.than - 1].mean if step.than else 0.0
        lines = verdict(step, now, than)
        return (
            f'<div class="fs-note">{"".join(f"<p>{html.escape(one)}</p>" for one in lines)}</div>'
        )


def update(control: Any, **values: Any) -> None:
    """Give a control what is another than before: each change is sent to all browsers."""
    for name, value in values.items():
        if getattr(control, name) != value:
            setattr(control, name, value)


def sentence(number: int, steps: int, step: SceneStep) -> str:
    """Which step it is, and what it says, HTML."""
    return (
        f'<div class="fs-story"><h3>Step {number + 1} of {steps}</h3>'
        f"<p>{html.escape(step.say)}</p></div>"
    )


def verdict(step: SceneStep, progress: StepProgress, than: float) -> list[str]:
    """What the run of a step shows, and whether that was predicted, in sentences.

    `than`: the mean of the step that it is compared with, else 0.
    """
    trial = progress.trial
    assert trial is not None
    if trial.fault:
        return [f"{trial.fault}, so this is not the run of this step. It is not judged."]
    name = observable_words(step.measure).capitalize()
    if not math.isfinite(trial.mean):
        return [f"{name} has no value in this run: it is not judged."]
    value = format_observable(step.measure, trial.mean)
    ticks = f"ticks {format_thousands(trial.first)} to {format_thousands(trial.last)}"
    less = ""
    if step.than:
        difference = trial.mean - than
        side = "more" if difference >= 0.0 else "less"
        size = format_observable(step.measure, abs(difference))
        less = f", {size} {side} than in step {step.than}"
    shown = step.choice_of(trial.mean - than)
    predicted = step.choices[progress.choice]
    holds = "holds" if shown == predicted else "does not hold"
    lines = [
        f"{name}: {value}, the mean of {ticks}{less}. This run shows “{shown}”.",
        f"Your prediction “{predicted}” {holds}.",
    ]
    return [*lines, step.why] if step.why and shown == step.shows else lines
