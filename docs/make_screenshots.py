"""Takes the pictures of the laboratory: `python docs/make_screenshots.py` (needs Chromium).

Names of pictures as arguments take these alone.
"""

from __future__ import annotations

import re
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

from agents.spec import Spec
from app.live.laboratory.lab_file import example
from app.live.operating.lab_choices import Choices
from app.viewer.lab.laboratory import Laboratory
from app.viewer.live.page import LivePage
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.shown.drawing_style import STEP_OFF

HERE = Path(__file__).parent
LIVE = "live-armed.png"
BESIDE = {"laboratory-beside.png": "vem-a-nav", "laboratory-pocket.png": "olfati-saber"}
"""The second model of a picture that has two."""
UNFOLDED = {"laboratory-zones.png": "Zones", "laboratory-forces.png": "Forces"}
"""What of an agent's card is unfolded in a picture: how that begins."""
ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]


def main(only: tuple[str, ...] = ()) -> None:
    """The plane, an agent from close, space; then missions. `only` these, or all."""
    plane = preset_spec("hwvem", agents=250, seed=7, parameters={"eta": 0.6})
    space = preset_spec("hwvem", agents=700, seed=3, dim=3, parameters={"eta": 0.7})
    zones = preset_spec("couzin", dim=3, agents=150, seed=3, parameters={"dr_a": 4.0})
    riders = preset_spec("couzin", dim=3, agents=100, seed=3)
    echelons = preset_spec("echelon", seed=4)
    mission = preset_spec("hwvem-nav", seed=3)
    yard = preset_spec("hwvem-nav", world="obstacles", agents=80, seed=3)
    pocket = preset_spec("boundary-points", seed=3)
    rooms = preset_spec("hwvem-nav", world="rooms-3d", agents=150, seed=3)
    cars = preset_spec("squashing-cars", seed=2)
    beside = preset_spec("hwvem-nav", seed=3)
    pockets = preset_spec("boundary-points", seed=3)
    for name, *scene in (
        ("laboratory.png", plane, 15.0, 45, in_layers),
        ("laboratory-agent.png", plane, 15.0, 45, from_close),
        ("laboratory-3d.png", space, 10.0, 20, in_space),
        ("laboratory-zones.png", zones, 50.0, 160, with_zones),
        ("laboratory-ride.png", riders, 50.0, 240, on_a_bird),
        ("laboratory-echelons.png", echelons, 200.0, 430, with_wakes),
        ("laboratory-mission.png", mission, 60.0, 245, on_a_mission),
        ("laboratory-obstacles.png", yard, 60.0, 150, among_obstacles),
        ("laboratory-forces.png", pocket, 100.0, 254, with_forces),
        ("laboratory-rooms.png", rooms, 30.0, 110, through_rooms),
        ("laboratory-cars.png", cars, 300.0, 1250, in_space_and_time),
        ("laboratory-beside.png", beside, 60.0, 96, side_by_side),
        ("laboratory-pocket.png", pockets, 100.0, 1500, before_a_pocket),
    ):
        if not only or name in only:
            take(name, *scene)
    if not only or LIVE in only:
        take_live()


def in_layers(laboratory: Laboratory, _page: Any) -> None:
    """Colours are layers, and there are trails."""
    laboratory.view.form["colour"].value = "layer"
    laboratory.view.form["trails"].value = "line"
    laboratory.view.form["trail_length"].value = 30


def from_close(laboratory: Laboratory, page: Any) -> None:
    """An agent is inspected; the View tab is open."""
    laboratory.view.form["colour"].value = "layer"
    laboratory.select(200)
    page.get_by_role("tab", name="View").click()


def in_space(_laboratory: Laboratory, page: Any) -> None:
    """Colours are headings; the Setup tab is open."""
    page.get_by_role("tab", name="Setup").click()


def with_zones(laboratory: Laboratory, _page: Any) -> None:
    """An agent behind others is inspected, and the camera is near."""
    laboratory.select(in_company(laboratory))
    point(laboratory, "follow")


def on_a_bird(laboratory: Laboratory, page: Any) -> None:
    """The camera rides along; the View tab is open."""
    page.get_by_role("tab", name="View").click()
    point(laboratory, STEP_OFF)
    for client in laboratory.server.get_clients().values():
        laboratory.scene.ride(client, in_company(laboratory))


def with_wakes(laboratory: Laboratory, _page: Any) -> None:
    """Colours are what each bird saves; the camera is near one that has others ahead."""
    laboratory.view.form["colour"].value = "energy saved"
    laboratory.view.form["wake"].value = True
    for client in laboratory.server.get_clients().values():
        laboratory.scene.follow(client, in_company(laboratory))


def in_company(laboratory: Laboratory) -> int:
    """The row of the agent that has most others ahead of it and near."""
    frame = laboratory.simulation.frame
    away = frame.position - frame.position[:, None]
    distance = np.linalg.norm(away, axis=2)
    ahead = np.einsum("ijk,ik->ij", away, frame.heading) > 0.8 * distance
    return int(np.argmax(np.count_nonzero(ahead & (distance < 0.6 * frame.reach), axis=1)))


def on_a_mission(laboratory: Laboratory, _page: Any) -> None:
    """The first waypoint is done, and the passage lies behind."""
    laboratory.view.form["trails"].value = "line"
    point(laboratory, "perspective")


def among_obstacles(laboratory: Laboratory, page: Any) -> None:
    """A walled yard at a slant; the Setup tab is open."""
    laboratory.view.form["trails"].value = "line"
    page.get_by_role("tab", name="Setup").click()
    point(laboratory, "perspective")


def with_forces(laboratory: Laboratory, _page: Any) -> None:
    """An agent at the mouth of the pocket is inspected."""
    laboratory.select(7)
    point(laboratory, "follow")


def through_rooms(_laboratory: Laboratory, page: Any) -> None:
    """A hall in space; the View tab is open."""
    page.get_by_role("tab", name="View").click()


def in_space_and_time(laboratory: Laboratory, page: Any) -> None:
    """Cars, and what they leave behind them rises with time; the View tab is open."""
    laboratory.view.form["trails"].value = "rising in time"
    laboratory.view.form["trail_length"].value = 1000
    laboratory.view.form["labels"].value = True
    page.get_by_role("tab", name="View").click()
    point(laboratory, "perspective")


def side_by_side(laboratory: Laboratory, _page: Any) -> None:
    """Two models on one mission."""
    laboratory.view.form["trails"].value = "line"


def before_a_pocket(laboratory: Laboratory, page: Any) -> None:
    """One model goes round, the other one is caught; the Setup tab is open."""
    laboratory.view.form["trails"].value = "line"
    laboratory.view.form["trail_length"].value = 200
    laboratory.view.form["agent_size"].value = 1.6
    page.get_by_role("tab", name="Setup").click()


def point(laboratory: Laboratory, camera: str) -> None:
    """Point all cameras."""
    for client in laboratory.server.get_clients().values():
        laboratory.point(client, camera)


def take(
    name: str, spec: Spec, speed: float, tick: int, arrange: Callable[[Laboratory, Any], None]
) -> None:
    """Run a flock to a tick and take its picture, 1440 x 900."""
    beside = BESIDE.get(name)
    laboratory = Laboratory(
        spec, port=0, speed=speed, running=False, beside=Spec(beside) if beside else None
    )
    while laboratory.simulation.state.compiling is not None or laboratory.simulation.frame is None:
        time.sleep(0.1)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(laboratory.address)
        page.locator(".fs-card").first.wait_for()
        page.get_by_text("Software WebGL").wait_for()
        page.locator(".mantine-Notification-closeButton").first.click()
        arrange(laboratory, page)
        laboratory.simulation.go()
        while laboratory.simulation.frame.tick < tick:
            time.sleep(0.01)
        laboratory.simulation.pause()
        time.sleep(1.0)
        while laboratory.selected is not None and laboratory.simulation.frame.inspected is None:
            time.sleep(0.1)
        arrange(laboratory, page)
        if name in UNFOLDED:
            page.get_by_text(re.compile(f"^{UNFOLDED[name]}:")).first.click()
        time.sleep(2.0)
        page.screenshot(path=HERE / name)
        browser.close()
    laboratory.close()


def arm(page: Any, room: LivePage) -> None:
    """Arm the cars of a room in a browser, and wait until they drive."""
    page.get_by_role("button", name="Arm …").click()
    page.locator(".mantine-Modal-body input").fill(room.session.code.digits)
    page.wait_for_timeout(100)
    page.get_by_role("button", name="Arm", exact=True).click()
    page.locator(".fs-running").wait_for(timeout=180_000)


def take_live() -> None:
    """Two emulated cars and two simulated ones drive for a while, armed in the browser."""
    lab = example()
    lab = lab.model_copy(update={"simulated": lab.simulated.model_copy(update={"cars": 2})})
    laboratory = LivePage(Choices.of(lab).choosing(source="emulated cars"), port=0)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(180_000)
        page.goto(laboratory.address)
        page.get_by_text("Software WebGL").wait_for()
        page.locator(".mantine-Notification-closeButton").first.click()
        arm(page, laboratory)
        time.sleep(12.0)
        page.screenshot(path=HERE / LIVE)
        browser.close()
    laboratory.close()


if __name__ == "__main__":
    main(tuple(sys.argv[1:]))
