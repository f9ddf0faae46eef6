"""Whether what a page says can be read: contrast as WCAG 2 asks for it, measured by axe."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

AXE = (files("axe_playwright_python") / "axe.min.js").read_text()
RULE = "color-contrast"
"""4.5 to 1, and 3 to 1 for large words."""


NO_FADES = """() => document.getAnimations().every(
    fade => fade.playState !== "running" || fade.effect.getTiming().iterations === Infinity)"""
"""Whether nothing on a page is just appearing or going, as a notification does."""


def faint(page: Any) -> list[str]:
    """The words on a page that cannot be read well, and why; empty if all can.

    What is just appearing or going is not meant: only words that are faint twice, with nothing
    fading before either measurement, are returned.
    """
    page.wait_for_function(NO_FADES)
    first = measure_contrast(page)
    if not first:
        return first
    page.wait_for_function(NO_FADES)
    again = measure_contrast(page)
    return [words for words in first if words in again]


def measure_contrast(page: Any) -> list[str]:
    """The words that are faint at this moment.

    axe is brought in past the page's policy, which lets no script in but the page's own.
    """
    if not page.evaluate("'axe' in window"):
        page.evaluate(f"() => {{ {AXE} }}")
    found = page.evaluate(
        "rule => axe.run(document, {runOnly: [rule], resultTypes: ['violations']})", RULE
    )
    checked = found["violations"] + found["passes"]
    assert any(one["nodes"] for one in checked), "nothing on the page was measured"
    return [
        f"{node['html'][:160]} at {node['target']}: {node['any'][0]['message']}"
        for one in found["violations"]
        for node in one["nodes"]
    ]


def faint_on_tabs(page: Any) -> list[str]:
    """The same, with each tab open in turn; those that were open are again, then."""
    tabs = page.get_by_role("tab")
    shown = [place for place in range(tabs.count()) if tabs.nth(place).is_visible()]
    chosen = [place for place in shown if tabs.nth(place).get_attribute("aria-selected") == "true"]
    found = []
    for place in shown:
        tabs.nth(place).click()
        page.mouse.move(0, 0)
        found += faint(page)
    for place in chosen:
        tabs.nth(place).click()
    return found
