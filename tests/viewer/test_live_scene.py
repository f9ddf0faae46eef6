"""A room with real cars on the display: states, simulated cars, names, and the capture area."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import viser

from app.viewer.scene.draw.agent_meshes import hull, outline
from app.viewer.scene.marks.agents import Agents, FlockMotion
from app.viewer.scene.marks.area import INSIDE, THICK, CaptureArea, Fence, fence, frame_mesh
from app.viewer.scene.marks.car_outlines import CLEAR, LiveOutlines, StuckMarks
from app.viewer.scene.marks.car_outlines import THICK as STATE_LINES
from app.viewer.scene.marks.labels import Labels
from app.viewer.scene.marks.mission_marks import InjectedCar
from app.viewer.scene.scene import Parts, Scene
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import COLOURINGS, OWN, outlines
from app.viewer.scene.shown.drawing_style import DrawingStyle, legend
from app.viewer.scene.shown.frame import Live
from tests.viewer.fleet import AREA, frame, known, node, shown
from tests.viewer.live_fleet import STATES, live, live_frame, nobody
from tests.viewer.test_scene_geometry import rotated
from tests.viewer.test_scene_worlds import Stand, draw

LIVE_NODES = ("/area/", "/simulated/", "/flock/outlines/", "/names/")
CALLED = ("red", "blue", "green")
"""Cars that are called by a colour."""


def seen(state: Live, look: DrawingStyle | None = None, **changes: Any):
    return shown(live_frame(state=state, **changes), look)


def test_each_car_has_its_own_colour_whether_it_is_seen_or_not():
    look = DrawingStyle(colour=OWN)
    colour = seen(live(states=("tracked",) * 5), look).colour
    assert colour[:3] == pytest.approx(np.array([palette.OWN[one] for one in CALLED]))
    assert len(np.unique(colour, axis=0)) == 5
    fewer = live(names=("green", "sim 2"), states=("tracked",) * 2, ages=np.zeros(2))
    one = live_frame(state=fewer)
    rows = [2, 4]
    kept = replace(
        one, ids=one.ids[rows], position=one.position[rows], heading=one.heading[rows],
        speed=one.speed[rows], informed=one.informed[rows], cars=known(2),
    )  # fmt: skip
    assert shown(kept, look).colour == pytest.approx(colour[rows])
    pale = seen(live(), look).colour[2]
    assert np.linalg.norm(pale - palette.FLOOR) < np.linalg.norm(colour[2] - palette.FLOOR)
    names = [*live().names, "injected car"]
    entries = legend(look, live_frame())
    assert [name for name, _ in entries] == names
    assert [css for _, css in entries][:5] == [palette.css(one) for one in colour]
    assert entries[-1][1] == palette.css(palette.GOAL)


def test_the_key_to_the_outlines_has_every_state_that_may_be():
    entries = outlines(live_frame())
    assert entries == [(state, palette.css(colour)) for state, colour in palette.STATES.items()]
    alone = live_frame(state=live(states=("tracked",) * 5))
    assert "simulated" not in dict(outlines(alone))
    assert outlines(frame()) == []


def test_states_can_be_told_apart():
    colours = list(palette.STATES.values())
    for row, one in enumerate(colours):
        for other in colours[row + 1 :]:
            assert np.linalg.norm(one - other) > 0.25


def test_a_colouring_is_one_of_those_there_are():
    with pytest.raises(ValueError, match=r"colour = 'mood' is not one of heading, .*, plain"):
        DrawingStyle(colour="mood")


@pytest.mark.parametrize("colour", [one for one in COLOURINGS if one != OWN])
def test_every_other_colouring_colours_real_cars_as_it_does_simulated_ones(colour):
    look, one = DrawingStyle(colour=colour), live_frame()
    before = shown(replace(one, live=None), look).colour
    now = shown(one, look).colour
    there = np.array([0, 1, 3, 4])
    assert now[there] == pytest.approx(before[there])
    assert np.linalg.norm(now[2] - palette.FLOOR) < np.linalg.norm(before[2] - palette.FLOOR)
    assert legend(look, one) == legend(look, replace(one, live=None))


def test_simulated_cars_are_of_glass_and_the_others_are_not():
    scene = Stand()
    part = Agents(scene, "", FlockMotion())
    one = shown(live_frame())
    draw(part, one)
    real, glass = node(scene, "/cars/hulls"), node(scene, "/simulated/hulls")
    assert real.batched_positions[:, :2] == pytest.approx(one.at[:3, :2])
    assert glass.batched_positions[:, :2] == pytest.approx(one.at[3:, :2])
    assert (real.opacity, glass.opacity < 0.6) == (None, True)
    assert (real.cast_shadow, glass.cast_shadow) == (True, False)
    lines = node(scene, "/simulated/outlines")
    assert len(lines.points) == 2 * len(outline())
    for middle, points in zip(one.at[3:], np.split(lines.points, 2), strict=True):
        away = np.abs(points[..., :2] - middle[:2]).max(axis=(0, 1))
        assert away == pytest.approx([0.5 * one.length, 0.4 * one.length * 0.12 / 0.22])
    draw(part, seen(live(states=("tracked",) * 5)))
    assert (glass.visible, lines.visible, len(real.batched_positions)) == (False, False, 5)
    draw(part, shown(frame()))
    assert (glass.visible, len(real.batched_positions)) == (False, 3)


def test_an_outline_is_of_edges_of_the_hull():
    vertices, faces = hull()
    corners = {tuple(vertex) for vertex in np.round(vertices, 9)}
    sides = {
        frozenset(tuple(np.round(vertices[face[k]], 9)) for k in pair)
        for face in faces
        for pair in ((0, 1), (1, 2), (2, 0))
    }
    for start, end in np.round(outline(), 9):
        assert {tuple(start), tuple(end)} <= corners
        assert frozenset((tuple(start), tuple(end))) in sides


def test_a_lost_car_is_pale_as_a_whole_and_no_other_is():
    scene = Stand()
    draw(Agents(scene, "", FlockMotion()), shown(live_frame()))
    cabins, wheels = node(scene, "/cars/cabins"), node(scene, "/cars/wheels")
    dark = palette.lit_bytes(palette.GLASS[None])[0].tolist()
    assert cabins.batched_colors[:2].tolist() == [dark, dark]
    assert np.all(cabins.batched_colors[2] > cabins.batched_colors[0])
    assert np.all(wheels.batched_colors[8:] > wheels.batched_colors[:1])
    assert (
        wheels.batched_colors[:8].tolist()
        == [palette.lit_bytes(palette.TYRE[None])[0].tolist()] * 8
    )


def test_an_outline_of_its_state_is_around_each_real_car():
    scene = Stand()
    part = LiveOutlines(scene)
    one = shown(live_frame(heading=np.tile((0.0, 1.0), (5, 1))))
    draw(part, one)
    half = np.array([0.5 * 0.12 / 0.22 + CLEAR, 0.5 + CLEAR]) * one.length
    for row, state in enumerate(("tracked", "late", "lost")):
        lines = node(scene, f"/{state}")
        away = np.abs(lines.points[..., :2] - one.at[row, :2])
        assert away.max(axis=(0, 1)) == pytest.approx(half)
        assert np.all((away > half - CLEAR * one.length - 1e-6).any(axis=-1))
        assert lines.points[:, 1] == pytest.approx(np.roll(lines.points[:, 0], -1, axis=0))
        assert tuple(lines.colors) == palette.node_colour(palette.STATES[state])
    assert not node(scene, "/stopped").visible
    draw(part, seen(live(states=("tracked", "stopped", "late", "simulated", "simulated"))))
    there = {state: node(scene, f"/{state}").visible for state in STATE_LINES}
    assert there == {"tracked": True, "stopped": True, "late": True, "lost": False}
    assert not node(scene, "/lost").points.any(), "no old outline may flash up when one is lost"
    draw(part, shown(frame()))
    assert not node(scene, "/late").visible


def test_the_worse_a_state_the_thicker_its_outline():
    assert STATE_LINES["tracked"] < STATE_LINES["stopped"] < STATE_LINES["late"]
    assert STATE_LINES["late"] < STATE_LINES["lost"]


@pytest.mark.parametrize("inside", [0.4, 0.9])
def test_the_fence_is_where_the_laboratory_has_it(inside):
    low, high = fence(seen(live(fence=inside)))
    assert low == pytest.approx([-3.0 + inside, -4.0 + inside])
    assert high == pytest.approx([3.0 - inside, 4.0 - inside])
    assert fence(seen(live(fence=inside), DrawingStyle(fence=False))) is None
    assert fence(seen(live(fence=0.0))) is None
    assert fence(shown(frame()))[0] == pytest.approx([-3.0 + INSIDE, -4.0 + INSIDE])


def test_the_fence_is_drawn_again_when_it_is_elsewhere():
    scene = Stand()
    part = Fence(scene)
    for inside in (0.4, 0.9, 0.5):
        draw(part, seen(live(fence=inside)))
        most = np.abs(node(scene, "/fence").points[..., 0]).max()
        assert most == pytest.approx((3.0 - inside) * 1.25)
    assert part.draw(seen(live())) != []
    assert part.draw(seen(live())) == []


def test_the_edge_of_the_area_says_what_the_laboratory_may_do():
    scene = Stand()
    part = CaptureArea(scene)
    drawn = set()
    for arm in ("safe", "armed", "emergency"):
        draw(part, seen(live(arm=arm)))
        edge = node(scene, "/area/edge")
        assert np.abs(edge.points[..., :2]).max(axis=(0, 1)) == pytest.approx([3.75, 5.0])
        assert edge.thickness == THICK[arm]
        drawn.add(tuple(edge.colors))
        assert part.draw(seen(live(arm=arm))) == []
    assert len(drawn) == 3
    assert THICK["emergency"] > THICK["armed"] > THICK["safe"]
    red, *others = palette.node_colour(palette.ARMS["emergency"])
    assert red > 2 * max(others)


def test_the_area_has_its_size_at_a_corner():
    scene = Stand()
    draw(CaptureArea(scene), shown(live_frame(world=replace(AREA, size=(6.1, 6.71)))))
    caption = node(scene, "/area/size")
    assert (caption.visible, caption.text) == (True, "6.10 × 6.71 m")
    assert caption.position[0] == pytest.approx(5.0 * 6.1 / 6.71)
    assert caption.position[1] < -5.0


def test_what_is_beyond_the_fence_is_tinted():
    scene = Stand()
    part = CaptureArea(scene)
    draw(part, seen(live(fence=0.4)))
    tint = scene.there("/world/area/beyond")
    vertices, faces = tint.given
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    normal = np.cross(b - a, c - a)
    assert np.all(normal[:, 2] > 0.0)
    ring = 6.0 * 8.0 - (6.0 - 0.8) * (8.0 - 0.8)
    assert 0.5 * normal[:, 2].sum() == pytest.approx(ring * 1.25**2)
    draw(part, seen(live(), DrawingStyle(fence=False)))
    assert not tint.there
    draw(part, seen(live(arm="emergency")))
    assert scene.there("/world/area/beyond").color == palette.node_colour(palette.ARMS["emergency"])
    assert len(frame_mesh(np.ones(2), np.zeros(2), np.ones(2), 0.0)[0]) == 8


def test_the_injected_car_keeps_its_own_name_in_a_simulation_only():
    for one, named in ((frame(), True), (live_frame(), False)):
        scene = Stand()
        car, made = InjectedCar(scene, "/goal"), shown(one)
        for handle, prop, value in car.draw(made, made.frame.progress.goal):
            setattr(handle, prop, value)
        assert node(scene, "/car/hulls").visible
        assert node(scene, "/goal/name").visible is named


def test_the_noise_of_the_tracking_does_not_turn_the_injected_car():
    scene = Stand()
    car, rng = InjectedCar(scene, "/goal"), np.random.default_rng(1)

    def looks(at: np.ndarray) -> np.ndarray:
        for handle, prop, value in car.draw(shown(live_frame()), at):
            setattr(handle, prop, value)
        return rotated(node(scene, "/car/hulls").batched_wxyzs[0], np.array([1.0, 0.0, 0.0]))[:2]

    looks(np.array([0.0, 0.0]))
    looks(np.array([0.0, 0.2]))
    for _ in range(50):
        noise = rng.normal(0.0, 5e-4, 2)
        assert looks(np.array([0.0, 0.2]) + noise) == pytest.approx([0.0, 1.0], abs=1e-6)
    assert looks(np.array([0.1, 0.2])) == pytest.approx([1.0, 0.0], abs=0.05)


def test_numbers_are_for_simulations():
    for one, numbers in ((frame(), 3), (live_frame(), 0)):
        scene = Stand()
        draw(Labels(scene), shown(one, DrawingStyle(labels=True)))
        written = [each for each in scene.sent if "/identities/" in each.name and each.visible]
        assert len(written) == numbers


def test_nothing_of_it_is_in_a_simulation():
    scene = Stand()
    parts = Parts(scene)
    for one in (live_frame(), frame(), frame(1, cars=None)):
        made = shown(one)
        for changes in (parts.draw_box(made), parts.draw_flock(made)):
            for handle, prop, value in changes:
                setattr(handle, prop, value)
        nodes = [
            each
            for each in scene.sent
            if each.there and any(part in each.name for part in LIVE_NODES)
        ]
        there = {each.name for each in nodes if getattr(each, "visible", True)}
        assert bool(there) is (one.live is not None), there
    fresh = Parts(empty := Stand())
    fresh.draw_box(shown(frame()))
    fresh.draw_flock(shown(frame()))
    assert not [each for each in empty.sent if "/names/" in each.name or "beyond" in each.name]


def test_what_is_stuck_has_its_own_ring():
    scene = Stand()
    stuck = replace(live_frame().cars, stuck=np.array([True, False, False, False, False]))
    draw(StuckMarks(scene), shown(live_frame(cars=stuck)))
    assert node(scene, "/stuck").visible


def test_a_room_is_shown_from_before_the_first_car_is_seen_to_the_end():
    server = viser.ViserServer(host="localhost", port=0, verbose=False)
    try:
        scene = Scene(server)
        for look in (
            DrawingStyle(colour=OWN),
            DrawingStyle(colour="heading", trails="rising in time"),
        ):
            for tick, one in enumerate((nobody(live_frame()), live_frame(), frame())):
                scene.show(replace(one, tick=tick, run=tick), look)
    finally:
        server.stop()


def test_states_of_a_frame_are_those_that_are_asked_for():
    assert live().is_in_state("late").tolist() == [False, True, False, False, False]
    assert live().is_in_state("simulated", "lost").tolist() == [False, False, True, True, True]
    assert set(STATES) < set(palette.STATES)
