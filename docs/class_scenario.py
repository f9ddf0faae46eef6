"""A class as it goes: a teacher and students in browsers, the others as programs, one question.

The teacher shows the code, the students enter by it; the teacher asks the question that is ready
for the lesson, each student hands in a run with the value that they were given or choose, a sweep
draws the curve beside, and the results are taken along. `StoreReader` says what becomes of
pictures.
"""

from __future__ import annotations

import csv
import io
import json
import re
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import segno
from PIL import Image
from websockets.exceptions import WebSocketException

from app.viewer.gallery.saved_scene import SavedScene, pack_scene
from tests.classroom.running import Person, Running, roster

NAMES = (
    "Ada", "Ben", "Chiara", "Dmitri", "Eszter", "Fatima", "Goran", "Hana", "Ibrahim", "Jun",
    "Katarzyna", "Liam", "Maximiliane-Sophie Oberhuber", "Noor", "Oluwaseun", "Priya", "Quentin",
    "Rosa", "Søren", "Tomás", "Ulla", "Véronique", "Wei", "Ximena", "Yuki", "Zeynep", "Anouk",
    "Bilal", "Carlos", "Dana", "Elif", "Finn", "Greta", "Hugo", "Ines", "Jakob", "Kofi", "Lena",
    "Mateo", "Nina",
)  # fmt: skip
DESK, PHONE = (1440, 900), (390, 844)
TIMEOUT = 120.0
"""Seconds for what may have to be compiled, on a busy machine."""
AT_ONCE = 6
"""Programs that enter, or hand in, at a time."""
Choose = Callable[[int, SavedScene], SavedScene]
"""The scene that the student of a number chooses, where a question leaves the choice to them."""
Kept = Callable[[Any, str], None]
"""Keeps a page as it is now under a name."""


def until(holds: Callable[[], Any], seconds: float = TIMEOUT) -> Any:
    """What holds, as soon as it does. Raises TimeoutError."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := holds():
            return found
        time.sleep(0.1)
    raise TimeoutError(f"not within {seconds:g} s")


def read_code(picture: bytes, links: list[str]) -> str:
    """Of these links the one whose QR code is on a picture (PNG), or nothing.

    The picture is read module by module, as a phone does once it has found the code, and held
    against the modules that segno makes of each link: what no module differs from is the link.
    """
    seen = np.asarray(Image.open(io.BytesIO(picture)).convert("L"))
    for link in links:
        made = np.array([list(row) for row in segno.make_qr(link, error="m").matrix])
        count = len(made) + 4  # two modules are left white all round
        places = [((np.arange(count) + 0.5) * side / count).astype(int) for side in seen.shape]
        if np.array_equal(seen[np.ix_(*places)][2:-2, 2:-2] < 128, made > 0):
            return link
    return ""


@dataclass
class Program:
    """A student who is a program: enters, reads all that comes, and hands in."""

    person: Person
    name: str
    moved: threading.Event = field(default_factory=threading.Event)
    """Set when the class shows this student another flock: the page connects anew."""
    values: dict[str, float] = field(default_factory=dict)
    """Where the sliders of a page stand that has the flock in it."""

    @classmethod
    def enter(cls, ours: Running, link: str, name: str) -> Program:
        """Enter by the link."""
        return cls(ours.student(name, link.rpartition("/")[2]), name)

    @contextmanager
    def looking(self) -> Iterator[None]:
        """Have a page open, and read what it is sent."""
        over = threading.Event()

        def read() -> None:
            while not over.is_set():
                self.moved.clear()
                with suppress(WebSocketException, OSError), self.person.connect() as line:
                    while not over.is_set() and not self.moved.is_set():
                        with suppress(TimeoutError):
                            line.recv(timeout=0.5)

        reading = threading.Thread(target=read, daemon=True)
        reading.start()
        try:
            yield
        finally:
            over.set()
            reading.join(10.0)

    def take(self, scene: SavedScene) -> None:
        """Have one's flock begin with a scene. Raises RuntimeError where the class refuses it."""
        headers = {"X-Flockscope": "scene", "Sec-Fetch-Site": "same-origin"}
        answer = self.person.ask(f"/open?scene={pack_scene(scene)}&sure=1", headers=headers)
        if answer.status != 200:
            raise RuntimeError(answer.text)

    def hand_in(self) -> str:
        """Hand in, as soon as one has a flock of one's own; the result in a sentence."""

        def handed() -> str:
            answer = self.person.send("/class/hand-in", {"values": self.values})
            return answer.text.strip() if answer.status == 200 and "seed" in answer.text else ""

        return str(until(handed))


class PageProgram(Program):
    """The same where flocks run in students' browsers."""

    @contextmanager
    def looking(self) -> Iterator[None]:
        """Have a page open, which hears of the class."""
        with self.person.listening("/class/mine"):
            yield

    def take(self, scene: SavedScene) -> None:
        """Move the sliders that one's page has to what a scene says."""
        told = re.search(r'id="class">(.*?)</script>', self.person.ask("/").text)
        if told is None:
            raise RuntimeError(f"the page of {self.name} has no flock")
        sliders = json.loads(told[1])["sliders"]
        self.values = {name: scene.spec.parameters[name] for name in sliders}


@dataclass(frozen=True)
class StudentView:
    """What a student's page is made of, by where flocks run."""

    flock: str
    """What is there with the flock."""
    word: str
    answer: str
    program: type[Program]


ON_SERVER = StudentView(".fs-class", ".fs-word", ".fs-answer", Program)
IN_BROWSER = StudentView("#go:enabled", ".word", ".answer", PageProgram)


@dataclass
class Scenario:
    """A class in a browser and around it."""

    ours: Running
    browser: Any
    keep: Kept
    view: StudentView = ON_SERVER
    times: list[tuple[str, float]] = field(default_factory=list)
    """What was done, and how long it took, s."""
    students: list[Any] = field(default_factory=list)
    """Pages."""
    programs: list[Program] = field(default_factory=list)

    @contextmanager
    def step(self, words: str) -> Iterator[None]:
        """Something that is done, and timed."""
        began = time.perf_counter()
        yield
        self.times.append((words, time.perf_counter() - began))
        print(f"{self.times[-1][1]:7.1f} s  {words}", flush=True)

    def page(self, size: tuple[int, int] = DESK, theme: str = "light") -> Any:
        """A browser of somebody's own."""
        context = self.browser.new_context(
            viewport={"width": size[0], "height": size[1]},
            color_scheme=theme,
            accept_downloads=True,
            has_touch=size == PHONE,
        )
        page = context.new_page()
        page.set_default_timeout(1000 * TIMEOUT)
        return page

    def shown(self) -> dict[str, Any]:
        """What the teacher's page is told."""
        return roster(self.person)

    def open(self) -> None:
        """The teacher opens the class."""
        self.person = self.ours.teacher()
        self.teacher = self.page()
        with self.step("the teacher's page is there"):
            self.teacher.goto(self.ours.teachers_link)
            self.teacher.get_by_text("Nobody is here yet").wait_for()
        self.keep(self.teacher, "empty")

    def read_wall(self) -> str:
        """The link in the QR code that the teacher shows."""
        with self.step("the code is on the wall, and read from its picture"):
            self.teacher.keyboard.press("q")
            wall = self.teacher.locator("dialog .fs-wall img")
            wall.wait_for()
            self.teacher.wait_for_timeout(500)
            link = read_code(wall.screenshot(), self.shown()["links"])
        if not link:
            raise RuntimeError("the picture on the wall is no code of the class's link")
        self.keep(self.teacher, "code")
        self.teacher.keyboard.press("Escape")
        return link

    def enter(self, link: str, name: str, size: tuple[int, int], theme: str) -> None:
        """A student enters in a browser."""
        page = self.page(size, theme)
        page.goto(link)
        page.locator("input[name=name]").fill(name)
        if size == PHONE:
            self.keep(page, "join-phone")
        page.get_by_role("button", name="Join the class").click()
        page.locator(self.view.flock).wait_for()
        self.students.append(page)

    def all_enter(self, link: str, browsers: list[tuple[tuple[int, int], str]], count: int) -> None:
        """Students enter: some in browsers, the others as programs."""
        with self.step(f"{len(browsers)} students are in by their browsers"):
            for name, (size, theme) in zip(NAMES, browsers, strict=False):
                self.enter(link, name, size, theme)
        rest = NAMES[len(browsers) : count]
        with self.step(f"{len(rest)} more are in as programs"), ThreadPoolExecutor(AT_ONCE) as pool:
            enter = self.view.program.enter
            self.programs = list(pool.map(lambda name: enter(self.ours, link, name), rest))

    def ask(self) -> None:
        """The teacher asks the first question that is ready; all have flocks of their own."""
        with self.step("the question is asked, and each has a flock of their own"):
            self.teacher.get_by_role("button", name="Ask a question").click()
            self.teacher.locator(".fs-ready").first.wait_for()
            self.keep(self.teacher, "question")
            self.teacher.locator(".fs-ready").first.click()
            self.teacher.locator(".fs-chart").wait_for()
            for one in self.programs:
                one.moved.set()
            until(lambda: not any(self.compiling()))
            for page in self.students:
                page.get_by_role("button", name="Hand in my run").wait_for()

    def hand_in(self, choose: Choose | None = None) -> None:
        """All hand in, those in browsers by the button."""
        with self.step("those in browsers have handed in"):
            for page in self.students:
                page.get_by_role("button", name="Hand in my run").click()
                page.locator(self.view.answer, has_text="seed").wait_for()
        with self.step("the others have handed in"), ThreadPoolExecutor(AT_ONCE) as pool:
            if choose is not None:
                scene = self.scene()
                for number, one in enumerate(self.programs):
                    one.take(choose(number, scene))
                until(lambda: not any(self.compiling()))
            half = len(self.programs) // 2
            list(pool.map(Program.hand_in, self.programs[:half]))
            self.teacher.evaluate("scrollTo(0, 0)")
            self.keep(self.teacher, "coming-in")
            list(pool.map(Program.hand_in, self.programs[half:]))
        told = self.shown()["question"]["told"]
        self.teacher.get_by_text(told, exact=True).wait_for()

    def scene(self) -> SavedScene:
        """What the class begins with."""
        from app.viewer.gallery.lessons.lessons import lesson_titles
        from app.viewer.gallery.scene_collection import find_lesson

        return find_lesson(lesson_titles()[self.shown()["title"]])

    def compiling(self) -> list[bool]:
        """Of each flock, whether it is not ready yet; those in browsers are compiled at once."""
        if self.view is IN_BROWSER:
            return [bool(self.shown()["flocks"])]
        return [not one["seen"] or one["seen"]["compiling"] for one in self.shown()["students"]]

    def draw_curve(self) -> None:
        """The teacher holds all flocks, which makes room, and has a sweep draw the curve."""
        with self.step("a sweep has drawn the curve"):
            self.teacher.get_by_role("button", name="Freeze all").click()
            self.teacher.get_by_role("button", name="All go on").wait_for()
            self.teacher.get_by_role("button", name="Make the curve", exact=True).click()
            until(lambda: self.shown()["question"]["making"])
            until(lambda: not self.shown()["question"]["making"])
            self.teacher.get_by_role("button", name="Make the curve anew").wait_for()
            self.teacher.locator(".fs-curve").wait_for()
            self.teacher.evaluate("scrollTo(0, 0)")

    def export(self, folder: Path) -> list[dict[str, str]]:
        """The teacher saves the results as CSV and PNG; the rows of the CSV."""
        with self.step("results are saved as CSV and PNG"):
            for kind in ("CSV", "PNG"):
                with self.teacher.expect_download() as coming:
                    self.teacher.get_by_role("link", name=kind, exact=True).click()
                coming.value.save_as(folder / f"results.{kind.lower()}")
        return list(csv.DictReader(io.StringIO((folder / "results.csv").read_text("utf-8"))))

    def end(self, folder: Path) -> None:
        """The teacher saves the class as a file and ends it."""
        with self.step("the class is saved as a file, and over"):
            self.teacher.get_by_role("button", name="End of class").click()
            self.keep(self.teacher, "end")
            with self.teacher.expect_download() as coming:
                self.teacher.get_by_role("link", name="Save the class as a file").click()
            coming.value.save_as(folder / "class.zip")
            self.teacher.get_by_role("button", name="End the class for all").click()
            self.students[0].get_by_text("The class has ended").wait_for()
            self.ours.process.wait(TIMEOUT)

    @contextmanager
    def looking(self) -> Iterator[None]:
        """All programs look at their flocks."""
        with ExitStack() as stack:
            for one in self.programs:
                stack.enter_context(one.looking())
            yield


def means(rows: list[dict[str, str]]) -> dict[float, float]:
    """Value of the parameter -> mean of the results, rising."""
    columns = list(rows[0])
    value = columns[columns.index("student") + 1]
    result = columns[columns.index("status") - 1]
    found: dict[float, list[float]] = {}
    for row in rows:
        found.setdefault(float(row[value]), []).append(float(row[result]))
    return {key: float(np.mean(found[key])) for key in sorted(found)}
