"""Acts as three users of the page, from start to result: `make_walks.py FOLDER [NAMES]`.

A teacher, a researcher and a roboticist (needs Chromium). What each of them takes home is saved in
the folder, and at each station a sheet with the page at four widths in both themes.
"""

from __future__ import annotations

import io
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from make_looks import SIZES, THEMES
from make_screenshots import ARGUMENTS
from PIL import Image
from playwright.sync_api import Page, sync_playwright

HIGH, GAP = 540, 12
"""Height of a picture on a sheet, and what is between two, pixels."""
WIDE, TALL = 1440, 900
"""The window in which a walk is walked, pixels."""
TIMEOUT = 240_000
"""Milliseconds for what may have to be compiled."""


class Walk:
    """One user before the page of a command."""

    def __init__(self, page: Page, folder: Path):
        self.page, self.folder, self.number = page, folder, 0
        folder.mkdir(parents=True, exist_ok=True)

    def open(self, address: str) -> None:
        """Open the page, and put away the word of the browser that it draws without a GPU."""
        self.page.goto(address)
        self.page.get_by_text("Software WebGL").wait_for(timeout=TIMEOUT)
        self.page.locator(".mantine-Notification-closeButton").first.click()

    def press(self, name: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=name, exact=True).first.click()

    def tab(self, name: str) -> None:
        """Open a tab."""
        self.page.get_by_role("tab", name=name, exact=True).click()

    def choose(self, label: str, option: str) -> None:
        """Choose from a list."""
        self.page.get_by_label(label, exact=True).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def take(self, act: Callable[[], None]) -> Path:
        """Do what gives a file, and keep that."""
        with self.page.expect_download(timeout=TIMEOUT) as coming:
            act()
        kept = self.folder / coming.value.suggested_filename
        coming.value.save_as(kept)
        print(f"{kept.name}: {kept.stat().st_size} bytes")
        return kept

    def running(self) -> None:
        """Wait until what the page shows runs, compiled."""
        self.page.get_by_text("running").first.wait_for(timeout=TIMEOUT)
        self.page.locator(".fs-compiling").wait_for(state="detached", timeout=TIMEOUT)

    def taking(self) -> Any:
        """The sheet of what can be taken along, opened: its parts."""
        self.press("Take")
        self.page.locator("section.fs-take").first.wait_for()
        return self.page.locator("section.fs-take")

    def look(self, name: str) -> None:
        """A sheet of the page as it is, at all sizes and in all themes."""
        self.number += 1
        rows = [[self.shot(theme, size) for size in SIZES] for theme in THEMES]
        self.page.emulate_media(color_scheme=THEMES[0])
        self.page.set_viewport_size({"width": WIDE, "height": TALL})
        width = sum(one.width + GAP for one in rows[0])
        made = Image.new("RGB", (width, (HIGH + GAP) * len(rows)), "#b00080")
        for down, row in enumerate(rows):
            left = 0
            for one in row:
                made.paste(one, (left, (HIGH + GAP) * down))
                left += one.width + GAP
        made.save(self.folder / f"{self.number:02d}-{name}.png")
        print(f"{self.folder.name} {self.number}: {name}", flush=True)

    def shot(self, theme: str, size: tuple[int, int]) -> Image.Image:
        """The page in a theme and a size, as high as a row of a sheet."""
        self.page.emulate_media(color_scheme=theme)
        self.page.set_viewport_size({"width": size[0], "height": size[1]})
        self.page.wait_for_timeout(1200)
        seen = Image.open(io.BytesIO(self.page.screenshot())).convert("RGB")
        return seen.resize((round(size[0] * HIGH / size[1]), HIGH))


class Served:
    """A command that serves a page; a context manager."""

    def __init__(self, *command: str):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "flockscope", *command, "--port", "0", "--no-open"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.said: list[str] = []
        threading.Thread(target=self.listen, daemon=True).start()

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait()

    def listen(self) -> None:
        """Keep what it prints."""
        assert self.process.stdout is not None
        self.said.extend(self.process.stdout)

    def find(self, what: str) -> str:
        """The first piece of what it prints that fits a pattern, as soon as it is there."""
        end = time.monotonic() + TIMEOUT / 1000
        while time.monotonic() < end and self.process.poll() is None:
            if found := re.search(what, "".join(self.said)):
                return found[0]
            time.sleep(0.05)
        raise SystemExit(f"no {what} in: {''.join(self.said)}")

    @property
    def address(self) -> str:
        """Of the page."""
        return self.find(r"http://\S+")


def teacher(walk: Walk) -> None:
    """Gallery, scene, three experiments, a picture for the blackboard."""
    page = walk.page
    with Served("lab") as lab:
        walk.open(lab.address)
        walk.running()
        walk.look("opens")
        walk.press("Gallery")
        page.locator(".fs-choice").first.wait_for()
        walk.look("gallery")
        page.locator(".fs-sheet input").fill("mill")
        page.locator(".fs-choice:visible").first.click()
        page.locator(".fs-sheet").wait_for(state="detached")
        page.wait_for_timeout(6000)
        walk.look("scene")
        for number in range(3):
            page.keyboard.press("h")
            walk.tab("Try this")
            walk.press("Do it")
            if number == 0:
                walk.look("guide")
            walk.press("Close")
            page.wait_for_timeout(5000)
            walk.look(f"experiment-{number + 1}")
        walk.taking()
        walk.look("take")
        walk.take(lambda: walk.press("Save picture"))


def researcher(walk: Walk) -> None:
    """Two models beside each other, the numbers of both, a film, the spec."""
    page = walk.page
    with Served("lab", "boundary-points", "--beside", "olfati-saber", "--seed", "3") as lab:
        walk.open(lab.address)
        walk.running()
        page.wait_for_timeout(8000)
        walk.look("beside")
        walk.taking().nth(1).get_by_label("Pixels").select_option("640x360")
        walk.press("Record")
        page.wait_for_timeout(10_000)
        walk.look("films")
        walk.take(lambda: page.locator(".fs-recording").get_by_text("Stop").click())
        walk.press("Pause")
        walk.take(lambda: walk.press("CSV"))
        walk.press("Large")
        walk.look("plot")
        page.keyboard.press("Escape")
        walk.tab("Save")
        walk.take(lambda: walk.press("Download spec (TOML)"))
        walk.look("taken")


def roboticist(walk: Walk) -> None:
    """Emulated cars: armed, driven, stopped, looked at once more."""
    page = walk.page
    with Served("live", "lab", "--record", str(walk.folder / "drives")) as lab:
        code = lab.find(r"(?<=with the code )\d{6}")
        walk.open(lab.address)
        page.get_by_text("Ready to be armed").wait_for(timeout=TIMEOUT)
        walk.look("room")
        walk.press("Arm …")
        page.locator(".mantine-Modal-body input").fill(code)
        walk.look("asked")
        walk.press("Arm")
        page.locator(".fs-running").wait_for(timeout=TIMEOUT)
        page.wait_for_timeout(8000)
        walk.look("drives")
        page.locator(".fs-stop").click()
        page.get_by_text("All cars are told to stop").wait_for()
        walk.look("stopped")
        walk.press("Reset the emergency stop")
        walk.look("again")
        walk.tab("Record")
        walk.press("Stop recording")
        walk.press("Show this recording")
        page.get_by_text("Time, s", exact=True).first.wait_for(timeout=TIMEOUT)
        page.wait_for_timeout(8000)
        walk.look("replayed")


WALKS = {"teacher": teacher, "researcher": researcher, "roboticist": roboticist}


def main(folder: Path, names: tuple[str, ...]) -> None:
    """All walks, or those of these names."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        for name in names or tuple(WALKS):
            page = browser.new_page(
                viewport={"width": WIDE, "height": TALL}, color_scheme=THEMES[0]
            )
            WALKS[name](Walk(page, folder / name))
            page.close()
        browser.close()


if __name__ == "__main__":
    if len(sys.argv) < 2 or set(sys.argv[2:]) - set(WALKS):
        sys.exit(f"usage: python docs/make_walks.py FOLDER [{' | '.join(WALKS)} ...]")
    main(Path(sys.argv[1]), tuple(sys.argv[2:]))
