"""Writes the pages of lessons that are stories, from their files: see `make_lessons.py --pages`.

Lessons that are older have pages that somebody has written, with what forty students found.
"""

from __future__ import annotations

import textwrap
from pathlib import Path

from app.classroom.workers.page_worker import first_question
from app.viewer.gallery.lessons.lessons import lesson_names
from app.viewer.gallery.scene_collection import find_lesson
from app.viewer.gallery.scene_steps import SceneStep

FOLDER = Path(__file__).parent / "lessons"
WRITTEN = ("order-against-noise", "who-leads", "field-of-view", "beat-the-paper")
"""Lessons whose pages are written by hand."""
STORIES = tuple(name for name in lesson_names() if name not in WRITTEN)


def page_of(name: str) -> str:
    """The page of a lesson: how it is given, its steps, what their runs show, and its question."""
    scene = find_lesson(name)
    question = first_question(scene)
    rows = "\n".join(row_of(number, step) for number, step in enumerate(scene.steps, 1))
    assert question is not None, f"{name} has no question for a class"
    low, *_, high = map(question.value_text, question.values)
    aim = f"**Aim.** {scene.watch} [A class](../class.md) says what the buttons do."
    asked = (
        f"4. **Ask a question**, *{question.title}*: each student has one of "
        f"{len(question.values)} values from {low} to {high}. A result is {question.result_words}."
    )
    led = (
        f"2. **Lead, or let them go.** *All students see step 1 of {len(scene.steps)}* shows it to "
        "all, and *Next* the one after it: ask for reasons before anybody runs it. *Students go "
        "through the steps themselves* lets all go on alone."
    )
    return f"""# {scene.title}

{lines(aim)}

    flockscope class {name} --host 0.0.0.0

![{scene.title}](../../static/gallery/lesson-{name}.webp)

1. **Show the code** (key Q). Each student has a flock, and a card with the steps of the lesson.

{lines(led, "   ")}

3. **Predict, then run.** Your page counts what is predicted, and what runs showed.

{lines(asked, "   ")}

## Steps

What a run shows is that of the lesson's own scene, and of other seeds, too.

| step | what it says | prediction | a run shows |
|---|---|---|---|
{rows}

## What to ask next

{scene.tries}
"""


def lines(text: str, indent: str = "") -> str:
    """A paragraph in lines; all but the first are indented."""
    return textwrap.fill(
        text, 112, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def row_of(number: int, step: SceneStep) -> str:
    """A step as a row of a table."""
    asked = f"{step.ask} {' / '.join(step.choices)}" if step.ask else ""
    shown = f"**{step.shows}.** {step.why}".strip() if step.ask else ""
    cells = (str(number), step.say, asked, shown)
    return f"| {' | '.join(cell.replace('|', '∣') for cell in cells)} |"


def write_pages() -> None:
    """Write the pages of all stories."""
    for name in STORIES:
        (FOLDER / f"{name}.md").write_text(page_of(name), encoding="utf-8")
        print(FOLDER / f"{name}.md")
