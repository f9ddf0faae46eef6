"""What a screen reader is told of the laboratory: parts, names, the picture, what happens."""

from __future__ import annotations

import re

from tests.viewer.waiting import until

NAMELESS = re.compile(r"^ *- (?:button|textbox|slider|combobox|checkbox)(?: \[.*)?(?::.*)?$", re.M)
"""Lines of a tree whose control has no name."""


def tree(page) -> str:
    """The page as a screen reader has it, a line for each thing."""
    return page.locator("body").aria_snapshot()


def test_each_control_has_a_name_and_the_page_its_parts(window):
    page = window.page
    until(lambda: not NAMELESS.findall(tree(page)), 30, "a name for each control")
    told = tree(page)
    assert '- heading "Hierarchical weighting Vicsek model · flockscope" [level=1]' in told
    for part in ("main", 'region "Monitors"', 'region "Run and settings"', 'navigation "Scene"'):
        assert f"- {part}" in told
    slider = page.get_by_role("slider", name="Noise η, rad", exact=True)
    assert slider.get_attribute("aria-valuenow") == "0.3"
    assert page.get_by_role("textbox", name="Noise η, rad", exact=True).input_value() == "0.3"


def test_the_picture_says_what_is_shown_and_a_change_of_state_is_told(window, laboratory):
    page = window.page
    picture = page.get_by_role("img", name="Picture: ")
    told = page.get_by_role("status").filter(has_text="Hierarchical weighting Vicsek model")
    until(
        lambda: (
            picture.get_attribute("aria-label")
            == ("Picture: paused · Hierarchical weighting Vicsek model, 61 agents, tick 0")
        )
    )
    laboratory.simulation.step(7)
    until(lambda: picture.get_attribute("aria-label").endswith(", tick 7"))
    assert "paused" in told.inner_text()
    laboratory.simulation.go()
    until(lambda: "paused" not in told.inner_text())
    laboratory.simulation.pause()
    until(lambda: "paused" in told.inner_text())
