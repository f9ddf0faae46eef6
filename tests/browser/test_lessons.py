"""Lessons about agents that differ, walked in the laboratory by somebody who predicts right."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from app.viewer.gallery.scene_collection import find_lesson
from app.viewer.lab.laboratory import Laboratory
from tests.viewer.waiting import COMPILED, until

OF_KINDS = ("leaders-who-disagree", "fast-and-slow", "predators-and-prey", "shepherd")


@pytest.fixture(params=OF_KINDS)
def lesson_page(chromium, request):
    """A page of a laboratory that opened on a lesson, and that one; runs go as fast as they can."""
    laboratory = Laboratory(opened=replace(find_lesson(request.param), speed=math.inf), port=0)
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    page.goto(laboratory.address)
    page.locator(".fs-card").first.wait_for(timeout=90_000)
    yield page, laboratory
    page.close()
    laboratory.close()


def test_each_step_shows_what_it_says(lesson_page):
    page, laboratory = lesson_page
    panel = laboratory.lesson
    steps = panel.steps
    for number, step in enumerate(steps, 1):
        page.get_by_text(f"Step {number} of {len(steps)}").wait_for()
        page.get_by_text(step.say).wait_for()
        until(lambda step=step: list(panel.sliders) == step.controls)
        if step.ask:
            page.get_by_role("button", name=step.shows, exact=True).click()
            page.get_by_role("button", name="Run it", exact=True).click()
            until(lambda: panel.now.trial is not None and panel.now.trial.is_over, COMPILED)
            page.get_by_text(f"Your prediction “{step.shows}” holds.").wait_for()
            page.get_by_text(step.why).wait_for()
        if number < len(steps):
            page.get_by_role("button", name="Next", exact=True).click()
        plotted = [name for chart in laboratory.plots.charts for name in chart.names]
        assert len(set(plotted)) == len(plotted), "one thing is plotted twice"
