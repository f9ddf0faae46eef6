"""The command of a class dies and is begun again: pages come back with nobody touching them."""

from __future__ import annotations

import signal
import time

import psutil

from tests.classroom.running import BUSY, Person, number_of, roster, running, seen
from tests.viewer.waiting import until

BACK = 60.0
"""Seconds in which a page is back, on a busy machine."""
KEPT = 60.0
"""Seconds in which a class is kept: it is done every twenty."""


class Pictures:
    """How often a page has been sent anything by a laboratory, over whichever line."""

    def __init__(self, page):
        self.came = 0
        page.on("websocket", lambda line: line.on("framereceived", self.count))

    def count(self, _) -> None:
        self.came += 1


def test_a_students_page_shows_its_flock_again_by_itself(chromium, tmp_path, capsys):
    page = chromium.new_page(viewport={"width": 1000, "height": 640})
    pictures = Pictures(page)
    try:
        with running(tmp_path, "--out", "kept.zip") as first:
            page.goto(f"http://localhost:{first.port}/{first.code}")
            page.fill("input[name=name]", "Ada")
            page.click("button.fs-main")
            page.locator("text=watching the teacher").wait_for(timeout=BUSY * 1000)
            teacher = first.teacher()
            teacher.do("role", role="own", students=[number_of(teacher, "Ada")])
            page.locator(".fs-class", has_text="your own flock").wait_for(timeout=BUSY * 1000)
            until(lambda: shows(page, pictures), BUSY)
            until(lambda: (seen(teacher, "Ada") or {}).get("tick", 0) > 5, BUSY)
            kept = tmp_path / "kept.zip"
            until(lambda: waited(page) and kept.exists(), KEPT)
            port, holding = first.port, psutil.Process(first.process.pid).children(recursive=True)
            first.process.send_signal(signal.SIGKILL)
            first.process.wait(BUSY)
            gone, _ = psutil.wait_procs(holding, BUSY)
            assert len(gone) == len(holding)  # nothing of it is left behind
        page.locator(".fs-lost").wait_for(timeout=BACK * 1000)
        with running(tmp_path, "--port", str(port), scene="kept.zip") as second:
            begun, before = time.monotonic(), pictures.came
            until(lambda: waited(page) and pictures.came > before + 10, BACK)
            page.locator(".fs-lost").wait_for(state="detached", timeout=BACK * 1000)
            page.locator(".fs-class", has_text="your own flock").wait_for(timeout=BACK * 1000)
            took = time.monotonic() - begun
            again = Person(port, dict(teacher.cookies))
            assert [one["here"] for one in roster(again)["students"]] == [True]
            assert seen(again, "Ada")["model"] == "Vicsek model"
            assert second.code == first.code
        with capsys.disabled():
            print(f"\na student's page shows its flock {took:.1f} s after the class serves again")
    finally:
        page.close()


def shows(page, pictures: Pictures) -> bool:
    """Whether pictures come."""
    before = pictures.came
    return waited(page) and pictures.came > before


def waited(page) -> bool:
    """Let the page go on for a moment: what it tells is heard only meanwhile."""
    page.wait_for_timeout(200)
    return True
