"""A flock's page in which the information agents are steered by hand."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from tests.browser.test_export import positions
from tests.viewer.waiting import until

CASES = {
    "pairs": ("vem", {"agents": 40, "informed": 1, "eta": 0.5}),
    "of several": ("vem", {"agents": 40, "informed": 3, "eta": 0.5}),
    "in space": ("couzin", {"agents": 30, "informed": 1}),
    "led by layers": ("hwvem", {"agents": 30}),
    "in turn": ("hwvem", {"agents": 30, "activation": "sequential"}),
    "late": ("hwvem", {"agents": 30, "delay": 3.0}),
}
MOVE = """([which, degrees]) => {
  const { input } = page.angles[which];
  input.value = degrees;
  input.oninput();
}"""


def heading_of(azimuth: float, climb: float, dim: int) -> np.ndarray:
    """The unit vector of angles in degrees, (dim,)."""
    a, c = np.radians([azimuth, climb if dim == 3 else 0.0])
    return np.array([np.cos(c) * np.cos(a), np.cos(c) * np.sin(a), np.sin(c)])[:dim]


@pytest.mark.parametrize("case", CASES)
def test_a_page_steered_by_hand_flies_as_here(opened, case):
    model, options = CASES[case]
    flock = Flock(model, rng=3, **options)
    shape, dim = flock.position.shape, flock.world.dim
    with opened(Flock(model, rng=3, **options)) as page:
        flock.run(20)
        assert positions(page, 20, shape) == pytest.approx(flock.position, abs=1e-9)
        for which, degrees in enumerate((135, -20)[: dim - 1]):
            page.evaluate(MOVE, [which, degrees])
            until(lambda: page.evaluate("!page.busy && !page.turn"), 60, "the turn")
        flock.heading[flock.informed] = heading_of(135.0, -20.0, dim)
        flock.run(20)
        assert positions(page, 20, shape) == pytest.approx(flock.position, abs=1e-9)
        shown = page.evaluate("page.angles.map((one) => one.output.textContent)")
        assert shown == ["135°", "\u221220°"][: dim - 1]


def test_reset_and_a_double_click_put_the_heading_back(opened):
    with opened(Flock("hwvem", agents=30, rng=3)) as page:
        row = page.locator(".slider").filter(has_text="Heading of the information agent")
        start = row.locator("output").inner_text()
        for back in ("page.reset()", "page.steer(page.start)"):
            page.evaluate(MOVE, [0, 250])
            until(lambda: row.locator("output").inner_text() == "250°", 60, "the turn")
            page.evaluate(back)
            until(lambda: row.locator("output").inner_text() == start, 60, "the heading")
        flock = Flock("hwvem", agents=30, rng=3)
        flock.run(20)
        assert positions(page, 20, (31, 2)) == pytest.approx(flock.position, abs=1e-9)


def test_a_turn_counts_while_the_flock_goes_on(opened):
    with opened(Flock("hwvem", agents=30, rng=3)) as page:
        page.click("#go")
        page.evaluate(MOVE, [0, 200])
        until(lambda: page.evaluate("page.angles[0].output.textContent") == "200°", 60, "the turn")
        page.click("#go")


@pytest.mark.parametrize("model", ["vem", "hwvem-nav"])
def test_nobody_is_steered_who_would_not_keep_to_it(opened, model):
    """Without information agents, and where a path tells them their heading."""
    with opened(Flock(model, rng=3)) as page:
        assert page.locator(".slider").filter(has_text="information agent").count() == 0
