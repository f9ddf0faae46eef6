"""Whether everybody can use a page: what axe finds against WCAG 2.2 A and AA, and good practice."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

AXE = (files("axe_playwright_python") / "axe.min.js").read_text()
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
"""Tags of axe's rules: words to be read, names of all that is used, sizes, headings, parts."""


NO_FADES = """() => document.getAnimations().every(
    fade => fade.playState !== "running" || fade.effect.getTiming().iterations === Infinity)"""
"""Whether nothing on a page is just appearing or going, as a notification does."""


def find_violations(page: Any) -> list[str]:
    """What on a page breaks a rule, and why; empty if nothing does.

    What is just appearing or going is not meant: only what breaks a rule twice, with nothing
    fading before either look, is returned.
    """
    page.wait_for_function(NO_FADES)
    first = run_axe(page)
    if not first:
        return first
    page.wait_for_function(NO_FADES)
    again = run_axe(page)
    return [violation for violation in first if violation in again]


def run_axe(page: Any) -> list[str]:
    """What breaks a rule at this moment.

    axe is brought in past the page's policy, which lets no script in but the page's own.
    """
    if not page.evaluate("'axe' in window"):
        page.evaluate(f"() => {{ {AXE} }}")
    found = page.evaluate(
        "rules => axe.run(document, {runOnly: rules, resultTypes: ['violations']})", RULES
    )
    assert found["passes"], "nothing on the page was looked at"
    return [
        f"{rule['id']}: {node['html'][:160]} at {node['target']}: {node['failureSummary']}"
        for rule in found["violations"]
        for node in rule["nodes"]
    ]


def find_violations_in_both_themes(page: Any) -> list[str]:
    """The same of a page that is light or dark as the browser asks for it."""
    found = []
    for theme in ("light", "dark"):
        page.emulate_media(color_scheme=theme)
        found += find_violations(page)
    return found


def find_violations_on_tabs(page: Any) -> list[str]:
    """The same, with each tab open in turn; those that were open are again, then."""
    tabs = page.get_by_role("tab")
    shown = [place for place in range(tabs.count()) if tabs.nth(place).is_visible()]
    chosen = [place for place in shown if tabs.nth(place).get_attribute("aria-selected") == "true"]
    found = []
    for place in shown:
        tabs.nth(place).click()
        page.mouse.move(0, 0)
        found += find_violations(page)
    for place in chosen:
        tabs.nth(place).click()
    return found
