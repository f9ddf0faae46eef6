"""Worlds and missions as a browser shows them."""

from __future__ import annotations

import numpy as np

from app.viewer.scene.shown import palette
from tests.browser.window import Window, is_compiled
from tests.viewer.waiting import COMPILED, until


def near(picture: np.ndarray, colour: np.ndarray) -> float:
    """Share of the pixels that look like a colour.

    A browser that draws slowly draws fewer pixels, and fewer of those of a line.
    """
    return float(np.mean(np.abs(picture - 255.0 * colour).max(axis=2) < 40))


def steady(window: Window, colour: np.ndarray) -> float:
    """That share once the picture has come to rest; 0 while it changes."""
    before = window.pixels()
    window.page.wait_for_timeout(700)
    now = window.pixels()
    return near(now, colour) if np.mean(np.abs(now - before) > 20) < 1e-4 else 0.0


def test_a_model_proposes_its_world_and_the_mission_is_drawn_and_measured(window, laboratory):
    page = window.page
    assert "Mission" not in window.text()
    window.tab("Setup")
    page.get_by_label("Model", exact=True).click()
    page.get_by_role("option", name="Hierarchical weighting Vicsek model on a mission").click()
    until(lambda: laboratory.setup.agents.value == 49)
    world = page.get_by_label("World", exact=True)
    until(lambda: "Flocking navigation" in world.input_value())
    until(lambda: page.get_by_label("Side", exact=True).is_disabled())
    window.press("Setup")
    until(lambda: laboratory.simulation.state.spec.world == "liu2021-mission", 60)
    until(lambda: is_compiled(laboratory.simulation), COMPILED)
    until(lambda: window.card("waypoint") == "1 / 4", 60)
    assert window.card("collisions") == "0"
    assert float(window.card("to path's end")) > 40.0

    window.tab("View")
    until(lambda: laboratory.drawing.drawn[0].world.name == "liu2021-mission")
    shown = until(lambda: steady(window, palette.LEADER), 30, "the path")
    page.get_by_label("Path & goal").uncheck()
    until(lambda: near(window.pixels(), palette.LEADER) < 0.2 * shown, 20, "no path")
    page.get_by_label("Path & goal").check()
    until(lambda: near(window.pixels(), palette.LEADER) > 0.4 * shown, 20, "the path again")

    window.press("Step")
    until(lambda: window.card("tick") == "1", 90, "the first tick")
    laboratory.select(12)
    page.get_by_text("Forces:").wait_for(timeout=60_000)
    page.get_by_text("Forces:").click()
    page.get_by_text("repulsion", exact=True).wait_for()
    window.press("Close")
    window.tab("Setup")
    page.get_by_label("Model", exact=True).click()
    page.get_by_role("option", name="Hierarchical weighting Vicsek model", exact=True).click()
    until(lambda: not page.get_by_label("Side", exact=True).is_disabled())
    window.press("Setup")
    until(lambda: "Mission" not in window.text(), 60)
    window.tab("Rule")
