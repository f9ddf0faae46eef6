"""Gives a class with forty students, lesson by lesson: `python docs/make_lessons.py [LESSON ...]`.

Needs Chromium. Three of the students are in browsers, one of them on a phone; the others are
programs. Flocks run in students' browsers, as is usual. What they see goes into `docs/class/`, what
it took is printed. "Order against noise" goes from the code on the wall to the exported table and
the end of the class; the other lessons take the pictures that their tutorials show. At the end it
is checked that forty results are in the table, and that they say what the lesson says; otherwise
the exit code is 1. `--review FOLDER` keeps every picture in full there, and the teacher's page in
all sizes and both themes. `--pages` gives no class: it writes the pages of the lessons that are
stories into `docs/lessons/`, from their files, and needs no browser.
"""

from __future__ import annotations

import argparse
import io
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from class_scenario import DESK, IN_BROWSER, NAMES, PHONE, Scenario, means
from lesson_pages import write_pages
from make_screenshots import ARGUMENTS
from PIL import Image
from playwright.sync_api import sync_playwright

from app.viewer.gallery.lessons.lessons import FIRST
from app.viewer.gallery.saved_scene import SavedScene
from tests.classroom.running import running

HERE = Path(__file__).parent / "class"
BROWSERS = [(PHONE, "light"), (DESK, "light"), ((1100, 800), "dark")]
"""Size and theme of the students in browsers; the phone is held by the first."""
SIZES = ((390, 844), (1100, 800), (1440, 900), (1920, 1080))
SMALLER = 0.75
"""How large a picture is stored, as a share of the page."""
PAIRS = [(p1, p2) for p1 in (0.0, 0.1, 0.5) for p2 in (1.5, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 50.0)]
"""Weights that students choose, one after the other."""


def choose(number: int, scene: SavedScene) -> SavedScene:
    """The scene with the weights that a student chooses."""
    p1, p2 = PAIRS[number % len(PAIRS)]
    spec = scene.spec
    chosen = {**spec.parameters, "p1": p1, "p2": p2}
    return replace(scene, spec=spec.but(parameters=chosen, seed=100 + number))


CHECKS: dict[str, Callable[[dict[float, float]], bool]] = {
    "order-against-noise": lambda found: found[min(found)] > 0.9 and found[max(found)] < 0.3,
    "who-leads": lambda found: found[1.0] > 3 * found[5.0],
    "field-of-view": lambda found: found[120.0] < 0.25 and found[270.0] > 0.5,
    "beat-the-paper": lambda found: found[20.0] < found[5.0] < found[1.5],
}
"""What the means by value say, if the lesson is right."""


class Pictures:
    """Where pictures go: small ones into `docs/class/`, and in full into another folder."""

    def __init__(self, lesson: str, review: Path | None):
        self.lesson = lesson
        self.review = review

    def keep(self, page: Any, name: str) -> None:
        """Keep a page as it is now."""
        page.wait_for_timeout(800)
        self.store(page.screenshot(), name)

    def store(self, seen: bytes, name: str) -> None:
        """Keep a picture."""
        named = f"{self.lesson}-{name}"
        if self.review is not None:
            (self.review / f"{named}.png").write_bytes(seen)
        picture = Image.open(io.BytesIO(seen)).convert("RGB")
        size = round(SMALLER * picture.width), round(SMALLER * picture.height)
        picture.resize(size, Image.Resampling.LANCZOS).save(
            HERE / f"{named}.webp", quality=80, method=6
        )

    def keep_all(self, page: Any, name: str) -> None:
        """For the review alone: a page in all sizes and both themes."""
        if self.review is None:
            return
        before = page.viewport_size
        for theme in ("light", "dark"):
            page.emulate_media(color_scheme=theme)
            for wide, tall in SIZES:
                page.set_viewport_size({"width": wide, "height": tall})
                page.wait_for_timeout(1200)
                page.screenshot(path=self.review / f"{self.lesson}-{name}-{wide}-{theme}.png")
        page.emulate_media(color_scheme="light")
        page.set_viewport_size(before)


def close_notices(page: Any) -> None:
    """Close what a browser without a graphics card is told."""
    page.locator(".mantine-Notification-closeButton").first.click()


def give(lesson: str, browser: Any, review: Path | None) -> bool:
    """Give a lesson; whether its results are there, and say what it says."""
    whole = lesson == FIRST
    pictures = Pictures(lesson, review)
    with (
        tempfile.TemporaryDirectory() as name,
        running(Path(name), "--out", "kept.zip", "--flocks", "in-browser", scene=lesson) as ours,
    ):
        folder = Path(name)
        print(lesson)
        keep = pictures.keep if whole else lambda _page, _name: None
        scene = Scenario(ours, browser, keep, IN_BROWSER)
        scene.open()
        pictures.keep_all(scene.teacher, "empty")
        link = scene.read_wall()
        scene.all_enter(link, BROWSERS if whole else BROWSERS[1:2], len(NAMES))
        with scene.looking():
            if whole:
                watch(scene, pictures)
            scene.ask()
            scene.students[-1].wait_for_timeout(8000)
            tell(scene, pictures, whole)
            scene.hand_in(choose if lesson == "beat-the-paper" else None)
            scene.draw_curve()
            pictures.keep(scene.teacher, "results")
            pictures.keep_all(scene.teacher, "results")
            rows = scene.export(folder)
            pictures.store((folder / "results.png").read_bytes(), "plot")
            if whole:
                scene.end(folder)
        for page in (scene.teacher, *scene.students):
            page.context.close()
    found = means(rows)
    print("         " + ", ".join(f"{value:g}: {mean:.3g}" for value, mean in found.items()))
    right = len(rows) == len(NAMES) and CHECKS[lesson](found)
    print(f"         {len(rows)} results; what the lesson says {'holds' if right else 'FAILS'}")
    return right


def watch(scene: Scenario, pictures: Pictures) -> None:
    """All watch the teacher's flock; the teacher has a page of their own for that."""
    scene.teacher.get_by_role("button", name="All look at mine").click()
    for page in scene.students:
        page.locator(".fs-class").wait_for()
        close_notices(page)
    own = scene.teacher.context.new_page()
    own.goto(scene.teacher.url.rpartition("/")[0])
    own.locator(".fs-card").first.wait_for()
    close_notices(own)
    own.wait_for_timeout(6000)
    pictures.keep(own, "teachers-flock")
    own.close()
    pictures.keep(scene.students[0], "watching-phone")
    pictures.keep(scene.teacher, "watching")


def tell(scene: Scenario, pictures: Pictures, whole: bool) -> None:
    """A word to all, and flocks as they are before anybody has handed in."""
    if not whole:
        pictures.keep(scene.students[0], "student")
        return
    scene.teacher.locator("#word").fill("Look at your own flock for a minute, then hand it in.")
    scene.teacher.get_by_role("button", name="Say it").click()
    scene.students[0].locator(scene.view.word).wait_for()
    for page, name in zip(
        scene.students, ("student-phone", "student", "student-dark"), strict=True
    ):
        pictures.keep(page, name)
    scene.teacher.get_by_role("button", name="Freeze all").click()
    scene.students[1].get_by_text("held by the teacher").wait_for()
    pictures.keep(scene.students[1], "held")
    scene.teacher.get_by_role("button", name="All go on").click()
    scene.teacher.locator("#students").scroll_into_view_if_needed()
    pictures.keep(scene.teacher, "students")
    pictures.keep_all(scene.teacher, "students")


def main() -> None:
    """Give the lessons that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("lessons", nargs="*", metavar="LESSON", help=", ".join(CHECKS))
    parser.add_argument("--review", type=Path, help="folder for every picture in full")
    parser.add_argument("--pages", action="store_true", help="write pages of stories, no pictures")
    asked = parser.parse_args()
    if asked.pages:
        write_pages()
        return
    if set(asked.lessons) - set(CHECKS):
        parser.error(f"lessons are {', '.join(CHECKS)}")
    HERE.mkdir(exist_ok=True)
    if asked.review is not None:
        asked.review.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        right = [give(one, browser, asked.review) for one in asked.lessons or CHECKS]
        browser.close()
    sys.exit(0 if all(right) else 1)


if __name__ == "__main__":
    main()
