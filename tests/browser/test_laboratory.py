"""The laboratory as a browser shows it."""

from __future__ import annotations

import http.server
import threading

import numpy as np
import pytest
import viser

from agents.catalogue import MODELS
from app.viewer.lab.panels.model_guide import current_value, is_done
from tests.browser.conftest import START
from tests.browser.window import Window, is_compiled, is_new
from tests.viewer.waiting import COMPILED, until


def test_the_page_draws_the_flock_and_its_monitors(window):
    assert window.shows_a_flock()
    assert window.card("agents") == "61"
    assert 0.0 <= float(window.card("polarisation")) <= 1.0
    assert "information agent" in window.text()


def test_go_moves_the_picture_and_pause_stops_it(window, laboratory):
    still = window.pixels()
    window.press("Go")
    until(lambda: int(window.card("tick") or 0) > 30, 60)
    assert np.mean(np.abs(window.pixels() - still) > 40) > 0.003
    window.press("Pause")
    until(lambda: not laboratory.simulation.state.running)
    window.page.get_by_role("button", name="Go", exact=True).wait_for()


def test_step_runs_one_tick(window):
    for tick in ("1", "2", "3"):
        window.press("Step")
        until(lambda tick=tick: window.card("tick") == tick)


def test_reset_goes_back_to_the_same_start(window, laboratory):
    start = laboratory.simulation.frame.position.copy()
    window.press("Step")
    until(lambda: window.card("tick") == "1")
    window.press("Reset")
    until(lambda: window.card("tick") == "0")
    np.testing.assert_array_equal(laboratory.simulation.frame.position, start)


def test_a_slider_acts_on_the_running_flock_and_is_clamped(window, laboratory):
    slider = laboratory.parameters.controls["eta"]
    window.enter(slider, "1.25")
    until(lambda: laboratory.simulation.run.flock.parameters.eta == 1.25)
    window.enter(slider, "88")
    until(lambda: laboratory.simulation.run.flock.parameters.eta == pytest.approx(6.2832))
    until(lambda: window.number(slider).input_value() == "6.2832")


def test_setup_takes_the_new_number_of_agents(window, laboratory):
    window.tab("Setup")
    box = window.box(laboratory.setup.agents)
    box.fill("150")
    window.page.get_by_text("Press Setup to use it").wait_for()
    assert laboratory.simulation.state.agents == 61
    window.press("Setup")
    until(lambda: window.card("agents") == "151", 60)
    until(lambda: "Press Setup to use it" not in window.text())
    assert laboratory.simulation.state.spec.seed == 4
    box.fill("60")
    window.tab("Rule")


def test_another_model_brings_its_own_sliders(window, laboratory):
    window.tab("Setup")
    window.page.get_by_label("Model", exact=True).click()
    window.page.get_by_role("option", name="Vicsek model", exact=True).click()
    window.press("Setup")
    until(lambda: laboratory.simulation.state.spec.model == "vem", 60)
    until(lambda: is_compiled(laboratory.simulation), COMPILED)
    until(lambda: set(laboratory.parameters.controls) == {"r", "eta", "neighbours", "k", "v0"})
    window.tab("Rule")
    window.page.get_by_text("Noise η, rad").wait_for()
    assert window.page.get_by_text("p₁").count() == 0


def test_the_space_bar_goes_and_pauses_even_after_a_click_on_the_button(window, laboratory):
    running = lambda: laboratory.simulation.state.running  # noqa: E731
    window.press("Go")
    until(running)
    window.page.keyboard.press("Space")
    until(lambda: not running())
    window.page.wait_for_timeout(300)
    assert not running()
    window.page.keyboard.press("Space")
    until(running)


def test_keys_step_and_open_the_guide(window):
    window.page.keyboard.press("t")
    until(lambda: window.card("tick") == "1")
    window.page.keyboard.press("h")
    window.page.locator(".fs-page").get_by_text("Neighbours count by how few hops").wait_for()
    window.press("Close")
    until(lambda: "Neighbours count by how few hops" not in window.text())


@pytest.mark.parametrize("anew", [False, True])
def test_the_guide_does_what_it_proposes_and_takes_it_back(window, laboratory, anew):
    simulation, page = laboratory.simulation, window.page
    offered = MODELS[START.model].to_try
    number, one = next((n, one) for n, one in enumerate(offered) if one.anew == anew)
    run, before = (
        simulation.state.run,
        {name: current_value(simulation.state, name) for name in one.set},
    )
    assert not is_done(simulation.state, one)
    page.keyboard.press("h")
    window.tab("Try this")
    page.get_by_text(one.see).wait_for()
    page.get_by_role("button", name="Do it", exact=True).nth(number).click()
    until(lambda: is_done(simulation.state, one), what="what is proposed")
    until(lambda: simulation.state.running and simulation.frame.tick > 0, what="a flock that runs")
    assert (simulation.state.run > run) == anew
    page.get_by_role("button", name="Take it back", exact=True).click()
    until(lambda: {name: current_value(simulation.state, name) for name in one.set} == before)
    page.get_by_role("button", name="Do it", exact=True).nth(len(offered) - 1).wait_for()
    page.keyboard.press("Escape")
    until(lambda: page.locator(".fs-page").count() == 0, what="the guide to be closed")
    assert simulation.state.values["eta"] == START.parameters["eta"]
    until(lambda: "Takes effect at Setup" in laboratory.setup.note.content)


def test_an_agent_is_inspected_until_its_window_is_closed(window, laboratory):
    laboratory.select(5)
    window.page.get_by_text("Listens to").wait_for()
    assert f"Agent {laboratory.simulation.frame.ids[5]}" in window.text()
    window.press("Close")
    until(lambda: "Listens to" not in window.text())
    assert laboratory.selected is None


def test_two_browsers_see_the_same_run_and_the_same_sliders(window, laboratory, chromium):
    slider = laboratory.parameters.controls["eta"]
    other = Window(chromium.new_page(viewport={"width": 1100, "height": 600}), laboratory)
    until(lambda: window.card("browsers") == "2")
    window.enter(slider, "2.5")
    until(lambda: other.number(slider).input_value() == "2.5")
    other.press("Step")
    until(lambda: window.card("tick") == other.card("tick") == "1")
    other.page.close()
    until(lambda: window.card("browsers") == "")


def test_a_browser_that_lost_its_connection_comes_back(window, laboratory):
    window.page.evaluate("window.before = true")
    laboratory.server._websock_server.disconnect_all_clients()
    # viser's client is back at once, and the page loads again some seconds later: then it is whole.
    until(lambda: is_new(window.page), 60, "a page that is loaded again")
    window.page.locator(".fs-card").first.wait_for()
    window.press("Step")
    until(lambda: window.card("tick") == "1", 60)
    until(window.shows_a_flock, 60, "a flock on the screen")


def test_an_error_is_shown_and_setup_mends_it(window, laboratory):
    laboratory.simulation.tell(lambda: laboratory.simulation.run.flock.position.fill(np.nan))
    window.press("Go")
    window.page.locator(".fs-error").get_by_text("Stopped.").wait_for()
    assert "finite number" in window.text()
    window.press("Setup")
    until(lambda: "Stopped." not in window.text(), 60)
    window.press("Step")
    until(lambda: window.card("tick") == "1")


def test_a_page_of_another_origin_cannot_connect(laboratory, chromium):
    page = f"""<script>
    const socket = new WebSocket("ws://localhost:{laboratory.server.get_port()}",
                                 "viser-v{viser.__version__}");
    socket.onopen = () => document.title = "let in";
    socket.onerror = () => document.title = "kept out";
    </script>"""

    class Foreign(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(page.encode())

        def log_message(self, *_):
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Foreign) as elsewhere:
        threading.Thread(target=elsewhere.serve_forever, daemon=True).start()
        foreign = chromium.new_page()
        foreign.goto(f"http://localhost:{elsewhere.server_port}")
        assert until(lambda: foreign.title()) == "kept out"
        foreign.close()
        elsewhere.shutdown()
