"""How far a reader is with the steps of a lesson, and how a class leads through them."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from app.viewer.gallery.scene_steps import SceneStep, number_parameters
from app.viewer.gallery.step_pictures import picture_address
from app.viewer.measuring.observable_format import (
    format_observable,
    format_thousands,
    observable_words,
)
from app.viewer.panels.dials import plain_symbol
from app.viewer.run.step_trial import StepTrial


@dataclass(frozen=True)
class LessonLead:
    """How a class leads a laboratory through its lesson."""

    lesson: str = ""
    """Which lesson it is, by `lesson_key`: another one is not led. Empty: the class has none."""
    step: int = 0
    """The number of the step that all see, from 1; 0: nobody leads."""
    turn: int = 0
    """Counts the lessons of the class: with another one a reader begins anew, whatever they have
    done in it by themselves."""
    choices: Mapping[int, int] = field(default_factory=dict)
    """What the student predicted before, by the number of the step."""


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

    @property
    def has_prediction(self) -> bool:
        """Whether a choice is made that stays."""
        return self.is_fixed and self.choice >= 0

    @property
    def is_running(self) -> bool:
        """Whether a run of the step goes on."""
        return self.trial is not None and not self.trial.is_over

    def judge(self) -> None:
        """Take over what the last run shows, if it came to its end."""
        if self.trial is not None and self.trial.is_over and not self.trial.fault:
            self.mean = self.trial.mean


def sentence(number: int, steps: int, step: SceneStep) -> str:
    """Which step it is, its picture, and what it says, HTML."""
    # The sentence says what is to be known: to who does not see the picture it would say it twice.
    source = html.escape(picture_address(step.picture)) if step.picture else ""
    picture = f'<img alt="" src="{source}">' if source else ""
    return (
        f'<div class="fs-story"><h3>Step {number + 1} of {steps}</h3>{picture}'
        f"<p>{html.escape(step.say)}</p></div>"
    )


def describe_run(step: SceneStep, model_name: str) -> str:
    """What the button of a step runs, HTML."""
    sliders = number_parameters(model_name)
    values = []
    for name, value in step.set.items():
        kind, _, own = name.rpartition(".")
        symbol = plain_symbol(sliders[own].symbol) if own in sliders else own
        values.append(f"{symbol} = {value:g}{f' of {kind}' if kind else ''}")
    start = f", with {', '.join(values)}" if values else ""
    words = f"{format_thousands(step.ticks)} ticks from the start{start}."
    return f'<div class="fs-quiet">{html.escape(words)}</div>'


def place_shown(step: SceneStep, mean: float, than: float) -> int | None:
    """The place of the choice that a run showed, from 0; None where no run has shown any.

    `than`: the mean of the step that it is compared with, else 0.
    """
    return step.choices.index(step.choice_of(mean - than)) if math.isfinite(mean - than) else None


def verdict(step: SceneStep, progress: StepProgress, than: float) -> list[str]:
    """What the run of a step shows, and whether that was predicted, in sentences.

    `than`: the mean of the step that it is compared with, else 0.
    """
    trial = progress.trial
    assert trial is not None
    if trial.fault:
        return [f"{trial.fault}, so this is not the run of this step. It is not judged."]
    name = observable_words(step.measure).capitalize() + (f" of {step.kind}" if step.kind else "")
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
    lines = [f"{name}: {value}, the mean of {ticks}{less}. This run shows “{shown}”."]
    if progress.choice >= 0:  # else a class led past the step before anything was predicted
        holds = "holds" if step.choices[progress.choice] == shown else "does not hold"
        lines.append(f"Your prediction “{step.choices[progress.choice]}” {holds}.")
    return [*lines, step.why] if step.why and shown == step.shows else lines
