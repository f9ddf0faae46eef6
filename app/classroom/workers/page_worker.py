"""What the process of students' pages does: it compiles a class's flock and writes pages of it.

A page has its student's own start in it, some ten kilobytes. What runs is one WebAssembly module
for all whose flocks differ by seed and values alone; it is served beside the pages.
"""

from __future__ import annotations

import gzip
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from agents.flock import Flock
from agents.web.web_program import demand_possible, zones
from app.classroom.collect.question import Question
from app.classroom.collect.question_choices import ready_for
from app.package_files import STATIC
from app.viewer.gallery.lessons.lessons import lesson_of
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_steps import SceneStep
from app.viewer.lab.flock_page import (
    PageWords,
    packed,
    page_parts,
    page_policy,
    short_script,
    with_steps,
)
from worlds.input_error import InputError

SCRIPTS = ("../classroom/chart.js", "../classroom/flock.js")
"""Of a student's page, behind those that every page of a flock has."""
STYLES = ("classroom/chart.css", "classroom/flock.css")
MOST_SLIDERS = 2
"""Where no question, and none that is ready, names any."""
COMMAND = "flockscope class"
MODULES = "flock/"
"""Where a page finds its module, from its own address."""


@dataclass(frozen=True)
class StudentPage:
    """The page of one student's flock."""

    html: bytes
    """Packed by gzip."""
    policy: str
    """What it may do (Content-Security-Policy)."""
    module: str
    """The name of its WebAssembly."""
    sliders: tuple[str, ...]
    """Parameters that the student may change."""
    steps: tuple[SceneStep, ...] = ()
    """Of the lesson that it leads through."""

    def step_at(self, number: int) -> SceneStep:
        """A step by its number, from 1. Raises InputError for one that the page has not."""
        if not 1 <= number <= len(self.steps):
            known = f"1 to {len(self.steps)}" if self.steps else "this flock has no steps"
            raise InputError(f"step = {number} is not allowed: {known}")
        return self.steps[number - 1]


def demand_in_browser(scene: SavedScene) -> None:
    """Refuse a scene whose flock cannot run in students' browsers, as far as can be told before it
    is compiled. Raises InputError."""
    demand_alone(scene)
    flock = Flock(scene.spec)
    demand_possible(flock)
    zones(flock)
    demand_known_sliders(flock, scene)


def demand_known_sliders(flock: Flock, scene: SavedScene) -> None:
    """Refuse a lesson with the slider of a number that differs from agent to agent: the class knows
    nothing of it. Raises InputError."""
    own = flock.model.individual if flock.kinds.kinds or flock.individuals else ()
    for number, step in enumerate(scene.steps, 1):
        for name in step.controls:
            if name in own:
                raise InputError(
                    f"step {number} has the slider of {name}, which each agent has its own of: "
                    "a student's page has no such slider"
                )


def demand_alone(scene: SavedScene) -> None:
    """Refuse a scene with two flocks. Raises InputError."""
    if scene.beside is not None:
        raise InputError("two flocks beside each other cannot run in a student's page")


def named_sliders(question: Question | None, known: Sequence[str]) -> tuple[str, ...]:
    """The parameters that a class changes, of those that a page can: the question's, else the first
    of the model."""
    if question is None:
        return tuple(known[:MOST_SLIDERS])
    return tuple(name for name in question.open if name in known)


def first_question(scene: SavedScene) -> Question | None:
    """The question that is ready for a scene, that of its lesson first."""
    ready = ready_for(scene.spec, lesson_of(scene), scene.steps)
    return ready[0].question if ready else None


class PageWorker:
    """Compiles, which takes some ten seconds for each model and kind of world, and writes pages."""

    def __init__(self) -> None:
        self.modules: dict[str, bytes] = {}
        """Packed by gzip, by their names."""

    def compile(self, scene: str) -> str:
        """Compile what the flock of a scene, TOML, runs; the name of its module. Raises
        InputError."""
        opened = SavedScene.from_toml(scene, "the class's scene")
        demand_in_browser(opened)
        return self.write(scene, None, {}).module

    def module(self, name: str) -> bytes:
        """A module, packed by gzip. Raises InputError."""
        found = self.modules.get(name)
        if found is None:
            raise InputError("this flock is compiled anew: load the page again")
        return found

    def write(self, scene: str, question: Question | None, student: dict[str, Any]) -> StudentPage:
        """The page of a student whose flock begins with a scene, TOML. Raises InputError.

        `student`: what its script is told at first.
        """
        opened = SavedScene.from_toml(scene, "the student's flock")
        demand_alone(opened)
        asked = question or first_question(opened)
        observable = "" if asked is None else asked.measure.observable
        plots = plots_with(observable, opened.plots)
        words = replace(PageWords.of_scene(opened, COMMAND), plots=plots)
        # A step that sets how many agents there are needs a page that can begin anew.
        is_fixed = not any("agents" in step.set for step in opened.steps)
        page, script, style = page_parts(Flock(opened.spec), words, is_fixed=is_fixed)
        if page.has_steps:
            script, style = with_steps(script, style)
        module = hashlib.sha256(page.program.module).hexdigest()[:32]
        if module not in self.modules:
            self.modules[module] = gzip.compress(page.program.module, mtime=0)
        sliders = page.program.manifest["parameters"]
        # The class knows nothing of sliders that change what agents differ in.
        movable = [one["name"] for one in sliders if one["slots"] and "of" not in one]
        shown = named_sliders(asked, movable)
        measured = [one["name"] for one in page.program.manifest["measures"]]
        told = student | {
            "sliders": shown,
            "measure": None if asked is None or observable not in measured else measure_of(asked),
        }
        script, style = "\n".join((script, class_script())), style + class_style()
        policy = page_policy([script], [style], f"connect-src 'self'; {page.picture_policy}")
        text = page.filled(
            policy=policy,
            style=f"<style>{style}</style>",
            module=f'<script type="text/plain" id="module" data-file="{MODULES}{module}.wasm">'
            "</script>",
            memory=f'<script type="text/plain" id="memory">{packed(page.program.memory)}</script>',
            script=f'<script type="application/json" id="class">{as_json(told)}</script>'
            f"<script>{script}</script>",
        )
        html = gzip.compress(text.encode(), 6, mtime=0)
        return StudentPage(html, policy, module, shown, opened.steps)


def plots_with(observable: str, plots: Sequence[str]) -> tuple[str, ...]:
    """What a page plots: first what is asked for, each once.

    >>> plots_with("consistency", ("polarisation", "consistency"))
    ('consistency', 'polarisation')
    """
    return tuple(dict.fromkeys(name for name in (observable, *plots) if name))


def measure_of(question: Question) -> dict[str, Any]:
    """What a page measures of its run, as the question does: by `observable` alone, its mean over
    so many ticks, or the tick from which a bound held."""
    condition = question.measure.condition
    return {
        "observable": question.measure.observable,
        "ticks": question.ticks,
        "over": question.measure.over,
        "until": None if condition is None else [condition.sign, condition.bound],
        "hold": question.measure.hold,
        "words": question.result_words,
    }


@cache
def class_script() -> str:
    """What a student's page has beside the scripts of every page of a flock."""
    return "\n".join(short_script(name) for name in SCRIPTS)


@cache
def class_style() -> str:
    """The styles of what a student's page has beside a flock."""
    return "".join((STATIC / name).read_text("utf-8") for name in STYLES)


def as_json(values: dict[str, Any]) -> str:
    """Values as a script of a page can hold them."""
    return json.dumps(values, separators=(",", ":")).replace("<", "\\u003c")
