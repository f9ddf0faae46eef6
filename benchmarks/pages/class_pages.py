"""Students of a class in real browsers, for `classroom.py --browsers N`: by Chromium."""

from __future__ import annotations

import shutil
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

ARGUMENTS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
"""A browser that draws without a graphics card."""
SIZE = {"width": 390, "height": 844}
"""Of a page: a phone's."""
COUNTS = """{
  const Own = window.Worker;
  window.pictures = 0;
  window.Worker = class extends Own {
    constructor(...given) {
      super(...given);
      this.addEventListener("message", ({ data }) => {
        const told = data && data.type === "message_batch" ? data.messages : [];
        if (told.some((one) => one.type === "SceneNodeUpdateMessage")) window.pictures += 1;
      });
    }
  };
}"""
"""Counts the pictures that viser's client hands to what draws them."""


class Page:
    """One student's page."""

    def __init__(self, page: Any):
        self.page = page
        self.answers: list[float] = []

    async def enter(self, link: str, name: str) -> None:
        """Enter the class, and wait for the first picture."""
        await self.page.add_init_script(COUNTS)
        await self.page.goto(link)
        await self.page.locator("input[name=name]").fill(name)
        await self.page.get_by_role("button", name="Join the class").click()
        await self.page.locator(".fs-class").wait_for()
        while not await self.pictures():
            await self.page.wait_for_timeout(100)

    async def pictures(self) -> int:
        """How many have come so far."""
        return int(await self.page.evaluate("window.pictures"))

    async def press(self) -> None:
        """Pause the flock, and let it go on when the page shows that it is paused."""
        go = self.page.get_by_role("button", name="Go", exact=True)
        began = time.perf_counter()
        await self.page.get_by_role("button", name="Pause", exact=True).click()
        await go.wait_for()
        self.answers.append(time.perf_counter() - began)
        await go.click()


@asynccontextmanager
async def pages(link: str, count: int) -> AsyncIterator[list[Page]]:
    """So many students' pages, each in a browser of its own; none starts no browser."""
    if not count:
        yield []
        return
    from playwright.async_api import async_playwright

    async with async_playwright() as playwright:
        opened = []
        for number in range(count):
            browser = await playwright.chromium.launch(
                executable_path=shutil.which("chromium"), args=ARGUMENTS
            )
            page = Page(await browser.new_page(viewport=SIZE))
            page.page.set_default_timeout(120_000)
            await page.enter(link, f"Page {number}")
            opened.append(page)
        yield opened
        for page in opened:
            await page.page.context.browser.close()
