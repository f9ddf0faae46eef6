"""The lesson: steps of the scene, one at a time, each with its sliders, and a prediction that the
flock's own run judges."""

from __future__ import annotations

import html
import math
import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import viser

from agents.models.declare import NumberParameter
from agents.spec import CompleteSpec, Spec
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_steps import SceneStep, lesson_key, number_parameters, step_spec
from app.viewer.lab.panels.step_progress import (
    LessonLead,
    StepProgress,
    describe_run,
    place_shown,
    sentence,
    verdict,
)
from app.viewer.measuring.observable_format import format_thousands
from app.viewer.panels.followed_value import FollowedValue
from app.viewer.panels.parameters import ParametersPanel, add_control, slider_value
from app.viewer.panels.shell import block
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from app.viewer.run.step_trial import StepTrial

BACK, NEXT = "Back", "Next"
RUN, AGAIN = "Run it", "Run it again"
LED = "Your teacher leads: all see this step."


@dataclass
class LessonPanel:
    """Leads through the steps of a scene; hidden where the scene has none.

    All browsers see one flock, and so one lesson. A class may lead through it: then it shows the
    step of the class, and nobody goes on or back. `set_up` is told which run is built for a step,
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
    lesson: str = ""
    """Which lesson the scene is, by `lesson_key`."""
    lead: LessonLead = field(default_factory=LessonLead)
    """How the class leads, which may be through another lesson."""
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

    @property
    def led(self) -> int:
        """The number of the step that the class shows, from 1; 0: nobody leads."""
        return self.lead.step if self.lead.lesson == self.lesson and self.steps else 0

    def follow(self, scene: SavedScene | None, state: SimulationState) -> None:
        """Show the lesson of a scene from its first step, if it is another; else what goes on."""
        with self.lock:
            if scene is not self.scene:
                self.keep_choices()
                self.scene, self.number = scene, 0
                self.lesson = lesson_key(self.steps)
                self.progress = [StepProgress() for _ in self.steps]
                self.restore_choices()
                self.number = max(self.led - 1, 0)
                self.folder.visible = bool(self.steps)
                self.show()
            if self.steps:
                self.refresh(state)

    def follow_lead(self, lead: LessonLead) -> None:
        """Show the step of a class from now on, or let the reader go on and back again."""
        with self.lock:
            before, is_other = self.led, lead.turn != self.lead.turn
            self.lead = lead
            if is_other:
                self.progress = [StepProgress() for _ in self.steps]
            self.restore_choices()
            if is_other or self.led != before:
                self.number = self.led - 1 if self.led else self.number
                self.show()
            self.show_state()

    def keep_choices(self) -> None:
        """Keep what is predicted in a class's lesson: it stays if that is opened anew."""
        if self.lead.lesson == self.lesson:
            made = {k: one.choice for k, one in enumerate(self.progress, 1) if one.has_prediction}
            self.lead = replace(self.lead, choices={**self.lead.choices, **made})

    def restore_choices(self) -> None:
        """Fix what was predicted in the lesson of a class before it was opened here."""
        if self.lead.lesson != self.lesson:
            return
        for number, progress in enumerate(self.progress, 1):
            if number in self.lead.choices and not progress.is_fixed:
                progress.choice, progress.is_fixed = self.lead.choices[number], True

    def predictions(self) -> tuple[str, int, tuple[tuple[int, int, int | None], ...]]:
        """Which lesson it is, in which turn of the class, and what stays predicted in it: by step
        its number, from 1, and the places of the choice and of that which its run showed."""
        with self.lock:
            self.judge()
            made = tuple(
                (number, progress.choice, place_shown(step, progress.mean, self.than_of(step)))
                for number, (step, progress) in enumerate(
                    zip(self.steps, self.progress, strict=True), 1
                )
                if progress.has_prediction
            )
            return self.lesson, self.lead.turn, made

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
            self.made += [*self.sliders.values(), self.add_move()]
        if step.shown_observable:
            self.watch(step.shown_observable)

    def add_move(self) -> Any:
        """Buttons that go back and on; who is led is told so instead."""
        if self.led:
            return self.gui.add_html(block(f'<div class="fs-quiet">{LED}</div>'))
        buttons = self.gui.add_button_group("Steps", (BACK, NEXT))
        buttons.on_click(self.move)
        return buttons

    def add_slider(self, parameter: NumberParameter) -> Any:
        """A slider that moves that of the Rule tab."""
        state, name = self.simulation.state, parameter.name
        value = slider_value(state.values.get(name, parameter.default))
        slider = add_control(self.gui, parameter, value)

        def send(value: Any, _event: viser.GuiEvent) -> Future:
            self.parameters.remember_value(name, False)
            return self.parameters.move_parameter(name, value, False)

        def now() -> Any:
            return slider_value(self.simulation.state.values.get(name, parameter.default))

        self.followed[name] = FollowedValue(slider, send, now)
        return slider

    def add_prediction(self, step: SceneStep) -> None:
        """The question, a button for each answer, and what runs the step."""
        assert self.scene is not None
        asked = block(f'<div class="fs-try"><b>{html.escape(step.ask)}</b></div>')
        self.made.append(self.gui.add_html(asked))
        for number, words in enumerate(step.choices):
            button = self.gui.add_button(words, color="gray")
            button.on_click(partial(self.choose, number))
            self.answers.append(button)
        self.made += [
            *self.answers,
            self.gui.add_html(block(describe_run(step, self.scene.spec.model))),
        ]
        # Not the icon of Go: by that the page finds the button that it keeps in reach.
        self.run = self.gui.add_button(RUN, icon=viser.Icon.FLASK, color="green")
        self.run.disabled = True
        self.run.on_click(self.begin)
        self.verdict = self.gui.add_html("")
        self.made += [self.run, self.verdict]

    async def move(self, event: viser.GuiEvent) -> None:
        """Go to the step before or after, if there is one."""
        to = self.number + (1 if event.target.value == NEXT else -1)
        with self.lock:
            # A press may have been on its way when the class began to lead.
            if not self.led and 0 <= to < len(self.steps):
                self.number = to
                self.show()

    async def choose(self, number: int, _event: viser.GuiEvent) -> None:
        """Predict an answer; once the run was begun it stays."""
        with self.lock:
            if not self.now.is_fixed and number < len(self.step.choices):
                self.now.choice = number
                self.show_state()

    async def begin(self, _event: viser.GuiEvent) -> None:
        """Run the step from its start: from here on the prediction stays as it is.

        Who is led cannot go back to a step that it is compared with: that one is run first, without
        a prediction if there is none.
        """
        with self.lock:
            if self.scene is None or not self.steps or self.lacks(self.step):
                return
            number = self.runs_first(self.step) or self.number + 1
            step, now = self.steps[number - 1], self.progress[number - 1]
            now.is_fixed = True
            now.trial = StepTrial(step.measure, step.first_measured_tick, step.ticks, step.kind)
            spec = step_spec(self.scene.spec, step)
            self.set_up(spec, None)
            self.simulation.try_step(spec, now.trial)
            self.simulation.go()
            self.show_state()

    def lacks(self, step: SceneStep) -> str:
        """What has to be done before a step can be run; empty: nothing."""
        progress = self.progress[self.steps.index(step)]
        if progress.choice < 0 and not progress.is_fixed:
            return "Choose an answer first."
        first = self.runs_first(step)
        return f"Run step {first} first." if first and not self.led else ""

    def runs_first(self, step: SceneStep) -> int:
        """The number of the step that it is compared with, while no run of it is judged, else 0."""
        return step.than if math.isnan(self.than_of(step)) else 0

    def than_of(self, step: SceneStep) -> float:
        """The mean of the step that it is compared with: NaN before a run of it is judged; 0 where
        it is compared with none."""
        return self.progress[step.than - 1].mean if step.than else 0.0

    def judge(self) -> None:
        """Take over what runs have shown."""
        for progress in self.progress:
            progress.judge()

    def refresh(self, state: SimulationState) -> None:
        """Follow the flock: sliders, and the run of the step."""
        for name, followed in self.followed.items():
            if name in state.values:
                followed.follow(slider_value(state.values[name]))
        self.judge()
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
        first = self.runs_first(step) if self.led else 0
        label = f"Run step {first} first" if first else AGAIN if now.is_fixed else RUN
        update(self.run, label=label, disabled=bool(self.lacks(step)))
        content = block(self.describe_trial(step, now))
        if self.verdict.content != content:
            self.verdict.content = content

    def describe_trial(self, step: SceneStep, now: StepProgress) -> str:
        """How the run of a step stands, and what it shows, HTML."""
        compared = [(self.steps[step.than - 1], self.progress[step.than - 1])] if step.than else []
        for running, progress in ((step, now), *compared):
            if progress.is_running:
                frame = self.simulation.frame
                tick = min(0 if frame is None else frame.tick, running.ticks)
                words = f"Tick {format_thousands(tick)} of {format_thousands(running.ticks)}."
                return f'<div class="fs-quiet">{words}</div>'
        if now.trial is None:
            return f'<div class="fs-quiet">{self.lacks(step)}</div>'
        lines = verdict(step, now, self.than_of(step))
        return (
            f'<div class="fs-note">{"".join(f"<p>{html.escape(one)}</p>" for one in lines)}</div>'
        )


def update(control: Any, **values: Any) -> None:
    """Give a control what is another than before: each change is sent to all browsers."""
    for name, value in values.items():
        if getattr(control, name) != value:
            setattr(control, name, value)
