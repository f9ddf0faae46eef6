"""A laboratory and a real browser that looks at it.

FLOCKSCOPE_BROWSER_TESTS=required makes a missing browser an error; otherwise these tests are
skipped without one.
"""

from __future__ import annotations

import os
import shutil
from contextlib import contextmanager
from ctypes.util import find_library

import pytest

from agents.catalogue import MODELS
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.setup import NOBODY
from app.viewer.run.run_preset import preset_spec, world_title
from tests.browser.exported_page import opened  # noqa: F401 - a fixture of this folder
from tests.browser.window import Window, is_compiled
from tests.viewer.waiting import COMPILED, until

CHROMIUM = os.environ.get("FLOCKSCOPE_CHROMIUM") or shutil.which("chromium")
ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    f"--use-angle={'gl-egl' if find_library('EGL') else 'swiftshader'}",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
"""Pictures are drawn by Mesa where there is one: drawn by SwiftShader, Chromium's own way without a
GPU, the page of a running flock can stand still for longer than a test waits.
"""
POLICY = "Content Security Policy"
"""Stands in what a browser says of all that a policy forbids but `eval`, which is an error."""
START = preset_spec(agents=60, seed=3, parameters={"eta": 0.3})


def absent(what: str) -> None:
    """Skip, or fail where browser tests are required."""
    if os.environ.get("FLOCKSCOPE_BROWSER_TESTS") == "required":
        pytest.fail(f"FLOCKSCOPE_BROWSER_TESTS=required, but there is no {what}", pytrace=False)
    pytest.skip(f"no {what}: install it to run the browser tests")


def wait_longer(make):
    """Makes pages or contexts as `make` does; what waits there fails after COMPILED.

    After Playwright's own 30 s a page of a busy machine may not even have answered a click.
    """

    def make_and_tell(*arguments, **options):
        page = make(*arguments, **options)
        page.set_default_timeout(1000 * COMPILED)
        return page

    return make_and_tell


@pytest.fixture(scope="package")
def chromium():
    """One running browser."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        absent("playwright")
    if CHROMIUM is None:
        absent("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        browser.new_page = wait_longer(browser.new_page)
        browser.new_context = wait_longer(browser.new_context)
        yield browser
        browser.close()


@pytest.fixture(scope="package")
def served(chromium):
    """A laboratory on a port of its own."""
    assert chromium.is_connected()
    laboratory = Laboratory(START, port=0, speed=60.0, running=False)
    yield laboratory
    laboratory.close()


@contextmanager
def obeyed(page):
    """Whatever is done on a page within it keeps to the page's policy.

    But for one script of viser's, which sorts Gaussian splats: it makes functions of strings.
    """
    broken = []
    page.on("console", lambda said: broken.append(said.text) if POLICY in said.text else None)
    yield
    assert broken == []


@pytest.fixture(scope="package")
def shared_window(chromium, served):
    """A browser window that has loaded the laboratory; closed, since a picture costs a core."""
    page = chromium.new_page(viewport={"width": 1000, "height": 640})
    with obeyed(page):
        yield Window(page, served)
    page.close()


def refill(fields) -> None:
    """Have the Setup tab's fields say START again, whatever an earlier test chose."""
    fields.model.value = MODELS[START.model].title
    fields.world.value = world_title(START.world)
    fields.dim.value = f"{START.dim}-D"
    fields.beside.value = NOBODY
    fields.agents.value = START.agents
    fields.plain["informed"].value = MODELS[START.model].informed
    fields.size.value = 0.0


@pytest.fixture
def laboratory(served):
    """The laboratory, paused at tick 0 of a known flock, with nothing selected."""
    simulation = served.simulation
    before = simulation.state.run
    simulation.pause()
    simulation.run_at(60.0)
    served.select(None)
    controls = served.parameters.controls
    served.parameters.expect_scene()
    simulation.setup(START)
    refill(served.setup)
    until(lambda: simulation.state.run > before and simulation.frame.run == simulation.state.run)
    until(lambda: served.parameters.controls is not controls)
    until(lambda: served.parameters.controls.keys() >= simulation.state.values.keys() > set())
    until(lambda: is_compiled(simulation), COMPILED)
    until(lambda: served.drawing.drawn and served.drawing.drawn[0] is simulation.frame)
    return served


@pytest.fixture
def window(laboratory, shared_window):
    """The window, showing the paused laboratory at tick 0."""
    until(lambda: shared_window.card("tick") == str(laboratory.simulation.frame.tick), 60)
    return shared_window
