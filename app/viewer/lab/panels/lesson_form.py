"""A form with which a teacher writes the steps of a lesson over the scene that runs."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import viser

from app.front.controls import set_value
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_steps import (
    MOST_AGENTS,
    MOST_STEPS,
    MOST_TICKS,
    number_parameters,
    page_observables,
    read_steps,
)
from app.viewer.gallery.step_pictures import gallery_pictures
from app.viewer.measuring.observable_format import observable_words
from app.viewer.panels.shell import block
from worlds.input_error import InputError

NONE = "none"
ADD, REMOVE = "Add step", "Remove last"
APART = "/"
"""Stands between answers, and between bounds."""
PLACE = "the form"
TICKS = 300


class LessonForm:
    """Adds a step to the scene of now, and takes the last one off.

    `now` gives the scene that runs, `take` is given the one with other steps, `tell` refusals. What
    is written goes along as the scene is saved, shared and exported.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        now: Callable[[], SavedScene],
        take: Callable[[SavedScene], None],
        tell: Callable[[str], None],
    ):
        self.now, self.take, self.tell = now, take, tell
        self.model = ""
        with gui.add_folder("Write a lesson", expand_by_default=False):
            gui.add_markdown(
                "A lesson leads through steps over this scene. The step is run with the sliders "
                "as they are now. *Save scene* keeps it; *Open a file* opens it again."
            )
            self.say = gui.add_text("Text", "", hint="What to know or to do, one sentence")
            self.picture = gui.add_dropdown(
                "Picture", (NONE, *gallery_pictures()), hint="Of the gallery, with the text"
            )
            self.observables = {observable_words(name): name for name in page_observables()}
            measures = tuple(self.observables)
            self.controls = [
                gui.add_dropdown(name, (NONE,), hint="A slider that stands with the step")
                for name in ("Slider", "Second slider")
            ]
            self.watch = gui.add_dropdown("Watch", (NONE, *measures), hint="Its curve comes first")
            self.ask = gui.add_text("Question", "", hint="What to predict; empty: nothing")
            self.choices = gui.add_text(
                "Answers",
                "",
                hint="2 to 4, as less / more, in the order of the measure",
            )
            self.measure = gui.add_dropdown(
                "Measure", measures, hint="Its mean over the last half of the run answers"
            )
            self.ticks = gui.add_number("Ticks", TICKS, min=2, max=MOST_TICKS, step=1)
            self.bounds = gui.add_text(
                "Bounds", "", hint="Between one answer and the next, as 0.25 / 0.75"
            )
            self.than = gui.add_number(
                "Compare with step",
                0,
                min=0,
                max=MOST_STEPS,
                step=1,
                hint="The earlier step whose mean is taken off before it is compared; 0: none",
            )
            self.agents = gui.add_number(
                "Agents of the step",
                0,
                min=0,
                max=MOST_AGENTS,
                step=1,
                hint="0: as many as the scene has",
            )
            self.shows = gui.add_text(
                "Right answer", "", hint="The answer that the run of the scene shows; may be empty"
            )
            self.why = gui.add_text(
                "Why", "", hint="What a reader is told after a run that shows it"
            )
            self.actions = gui.add_button_group("Steps of the lesson", (ADD, REMOVE))
            self.steps = gui.add_html("")
        self.actions.on_click(self.press_button)

    async def press_button(self, event: viser.GuiEvent) -> None:
        """Add the step of the form, or take off the last one."""
        try:
            scene = self.now()
            if event.target.value == REMOVE:
                self.take(replace(scene, steps=scene.steps[:-1]))
                return
            fields = [step.values() for step in scene.steps]
            steps = read_steps([*fields, self.fields(scene)], scene.spec, PLACE)
            if scene.beside is not None:
                raise InputError(
                    f"steps and beside exclude each other: a lesson is of one flock ({PLACE})"
                )
            self.take(replace(scene, steps=steps))
        except InputError as refusal:
            self.tell(str(refusal))
            return
        for text in (self.say, self.ask, self.choices, self.bounds, self.shows, self.why):
            set_value(text, "")
        for count in (self.than, self.agents):
            set_value(count, 0)
        set_value(self.picture, NONE)

    def fields(self, scene: SavedScene) -> dict[str, Any]:
        """The step as a file would have it. Raises InputError for bounds that are no numbers."""
        names = {each.words: each.name for each in number_parameters(scene.spec.model).values()}
        controls = [names[one.value] for one in self.controls if one.value in names]
        fields: dict[str, Any] = {"say": self.say.value.strip(), "controls": controls}
        if self.picture.value != NONE:
            fields["picture"] = self.picture.value
        if self.watch.value != NONE:
            fields["watch"] = self.observables[self.watch.value]
        if not self.ask.value.strip():
            return fields
        begins = {name: float(scene.spec.parameters[name]) for name in controls}
        if self.agents.value:
            begins["agents"] = float(self.agents.value)
        return fields | {
            "ask": self.ask.value.strip(),
            "choices": split(self.choices.value),
            "measure": self.observables[self.measure.value],
            "ticks": int(self.ticks.value),
            "bounds": [number(part) for part in split(self.bounds.value)],
            "set": begins,
            "than": int(self.than.value),
            "shows": self.shows.value.strip(),
            "why": self.why.value.strip(),
        }

    def refresh(self, scene: SavedScene | None, model: str) -> None:
        """Offer the sliders of the model, and show the steps that there are."""
        if model != self.model:
            self.model = model
            words = tuple(each.words for each in number_parameters(model).values())
            for control in self.controls:
                control.options = (NONE, *words)
        steps = () if scene is None else scene.steps
        lines = "".join(f"<li>{html.escape(step.say)}</li>" for step in steps)
        content = block(f"<ol>{lines}</ol>") if steps else ""
        if content != self.steps.content:
            self.steps.content = content


def split(text: str) -> list[str]:
    """The parts of a line, without those that are empty.

    >>> split("less / more")
    ['less', 'more']
    """
    return [part.strip() for part in text.split(APART) if part.strip()]


def number(text: str) -> float:
    """A number that somebody has typed. Raises InputError."""
    try:
        return float(text)
    except ValueError:
        raise InputError(f"bounds = {text!r} is no number ({PLACE})") from None
