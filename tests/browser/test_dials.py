"""The sliders as the page draws them: what they span, what they are put on, what puts them back."""

from __future__ import annotations

import math

import pytest

from agents.models.declare import DeclaredParameter
from app.viewer.run.run_preset import preset_spec
from tests.browser.accessibility import find_violations
from tests.viewer.waiting import until


class Slider:
    """A slider of the Rule tab."""

    def __init__(self, window, laboratory, name: str):
        self.page, self.window, self.panel = window.page, window, laboratory.parameters
        self.control = self.panel.controls[name]
        self.uuid = self.control._impl.uuid
        self.root = self.page.locator(f'[data-of="{self.uuid}"]')
        self.thumb = self.root.get_by_role("slider")
        self.label = self.page.locator(f'label[for="{self.uuid}"]')
        self.flock = lambda: getattr(laboratory.simulation.run.flock.parameters, name)
        self.root.scroll_into_view_if_needed()

    @property
    def one(self) -> DeclaredParameter:
        """How the parameter is declared."""
        return next(dial.one for dial in self.panel.dials.dials if dial.control is self.control)

    def at(self, share: float) -> tuple[float, float]:
        """Where on the page so much of the rail is."""
        box = self.root.locator(".fs-rail").bounding_box()
        return box["x"] + share * box["width"], box["y"] + box["height"] / 2

    def thumb_at(self) -> float:
        """Where on the rail the thumb is."""
        rail, thumb = (self.root.locator(one).bounding_box() for one in (".fs-rail", ".fs-thumb"))
        return (thumb["x"] + thumb["width"] / 2 - rail["x"]) / rail["width"]

    def drag(self, share: float) -> None:
        """Drag the thumb to so much of the rail; what is changed is listed above and moves it."""
        self.root.scroll_into_view_if_needed()
        self.page.mouse.move(*self.at(self.thumb_at()))
        self.page.mouse.down()
        self.page.mouse.move(*self.at(share), steps=6)
        self.page.mouse.up()

    def ends(self) -> list[float]:
        """What it says at its ends."""
        return [float(text) for text in self.root.locator("span").all_inner_texts()]

    def box(self) -> str:
        """What the box beside it says."""
        return self.window.number(self.control).input_value()

    def is_marked(self) -> bool:
        """Whether its label says that it is changed."""
        return self.label.evaluate("one => getComputedStyle(one, '::before').content") != "none"


@pytest.fixture
def slider(window, laboratory):
    window.tab("Rule")
    return lambda name: Slider(window, laboratory, name)


def test_a_slider_is_dragged_and_a_double_click_puts_it_back(slider):
    eta = slider("eta")
    assert eta.ends() == [0.0, 6.2832]
    until(lambda: eta.thumb_at() == pytest.approx(0.3 / 6.2832, abs=0.01))
    assert not eta.is_marked(), "what a scene sets is no change"
    eta.drag(0.5)
    until(lambda: eta.flock() == pytest.approx(3.15, abs=0.051))
    until(lambda: eta.box() == f"{eta.flock():g}")
    until(eta.is_marked)
    eta.page.mouse.dblclick(*eta.at(0.8))
    until(lambda: eta.flock() == 0.3 and eta.box() == "0.3")
    until(lambda: not eta.is_marked())
    eta.drag(0.5)
    until(eta.is_marked)
    eta.label.dblclick()
    until(lambda: eta.flock() == 0.3)


def test_a_click_brings_the_thumb_and_arrows_move_it_by_a_step(slider, laboratory):
    eta = slider("eta")
    eta.page.mouse.click(*eta.at(0.75))
    until(lambda: eta.flock() == pytest.approx(4.7, abs=0.051))
    before = eta.flock()
    eta.page.keyboard.press("ArrowLeft")
    until(lambda: eta.flock() == pytest.approx(before - 0.05))
    eta.page.keyboard.press("Shift+ArrowRight")
    until(lambda: eta.flock() == pytest.approx(before + 0.45))
    eta.page.keyboard.press("End")
    until(lambda: eta.flock() == 6.2832)
    assert eta.thumb.get_attribute("aria-valuenow") == "6.2832"
    assert eta.thumb.get_attribute("aria-label") == "Noise η, rad"
    eta.page.keyboard.press("Space")
    until(lambda: laboratory.simulation.state.running, what="a key that acts after a drag")


def test_a_number_outside_of_what_is_proposed_is_taken_and_shown(slider, window):
    weight = slider("p2")
    low, high = weight.one.proposed
    assert weight.ends() == [low, high]
    assert high < 60.0 < weight.one.high
    window.enter(weight.control, "60")
    until(lambda: weight.flock() == 60.0)
    until(lambda: weight.ends() == [low, 100.0])
    assert 0.5 < weight.thumb_at() < 0.7
    until(weight.is_marked)
    weight.drag(0.1)
    until(lambda: weight.flock() < high)
    assert weight.ends() == [low, 100.0], "what it spans stays while it is looked at"
    weight.thumb.dblclick()
    until(lambda: weight.flock() == weight.one.default)
    until(lambda: weight.ends() == [low, high])


def test_what_is_changed_is_marked_so_that_it_can_be_read_in_both_themes(slider):
    eta, speed = slider("eta"), slider("v0")
    eta.drag(0.5)
    until(eta.is_marked)
    assert not speed.is_marked()
    colour = "one => getComputedStyle(one).color"
    for _ in ("one theme", "the other"):
        eta.page.mouse.move(0, 0)
        assert eta.label.evaluate(colour) != speed.label.evaluate(colour)
        assert find_violations(eta.page) == []
        eta.page.keyboard.press("m")
        eta.page.wait_for_timeout(300)
    mark, rail = (eta.root.locator(one).bounding_box() for one in (".fs-usual-mark", ".fs-rail"))
    share = (mark["x"] + mark["width"] / 2 - rail["x"]) / rail["width"]
    assert share == pytest.approx(0.3 / 6.2832, abs=0.01)


def test_a_wide_range_above_zero_is_looked_at_by_its_logarithm(slider, window, laboratory):
    before = laboratory.simulation.state.run
    laboratory.simulation.setup(preset_spec("hwvem-nav", world="obstacles"))
    until(lambda: laboratory.simulation.state.run > before)
    until(lambda: "c_att" in laboratory.parameters.controls)
    slide = slider("c_att")
    low, high = slide.one.proposed
    assert slide.ends() == [low, high]
    share = math.log(slide.one.default / low) / math.log(high / low)
    until(lambda: slide.thumb_at() == pytest.approx(share, abs=0.01))
    for at in (0.25, 0.5, 0.75):
        slide.drag(at)
        wanted = low * (high / low) ** at
        until(lambda wanted=wanted: slide.control.value == pytest.approx(wanted, rel=0.1))
        assert slide.control.value == float(f"{slide.control.value:.2g}")
    window.enter(slide.control, "0")
    until(lambda: slide.control.value == 0.0)
    until(lambda: slide.thumb_at() == pytest.approx(0.0, abs=0.01))
    assert slide.ends() == [low, high]


def test_sliders_go_on_after_one_was_taken_away_while_it_was_held(slider, laboratory):
    before, state = slider("eta"), laboratory.simulation.state
    before.page.mouse.move(*before.at(before.thumb_at()))
    before.page.mouse.down()
    laboratory.simulation.setup(preset_spec("hwvem-nav", world="obstacles"))
    until(lambda: laboratory.simulation.state.run > state.run)
    until(lambda: before.root.count() == 0, what="other sliders")
    before.page.mouse.up()
    after = slider("eta")
    until(lambda: after.root.count() == 1)
    after.drag(0.5)
    until(lambda: after.control.value == pytest.approx(3.15, abs=0.051))
