"""Fish: their meshes, how their tails swing, which scenes have them, and pictures of them."""

from __future__ import annotations

import numpy as np
import pytest

from agents import Flock
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.pictures.plane import swimming_outlines
from app.viewer.pictures.shot import look_of, shot
from app.viewer.pictures.space_picture import agent_corners
from app.viewer.run.frame_builder import FrameBuilder
from app.viewer.scene.draw.agent_meshes import HINGE, fish_tail, fish_trunk, turn_tails
from app.viewer.scene.draw.agent_shapes import BIRD, SWIMMER, SWIMMING
from app.viewer.scene.draw.attitude import OF_LENGTH, ahead_directions, up_directions
from app.viewer.scene.marks.agents import FlockMotion
from app.viewer.scene.scene import Parts
from tests.viewer.sky import STEP, Clock, frame, heading, shown
from tests.viewer.test_scene_worlds import Stand
from worlds.world import World

SEA = World("sea", (20.0, 20.0), ("wrap", "wrap"))


def swimming(tick: int = 0, dim: int = 3, **changes):
    """Two fish at a tick, in space or in the plane."""
    ahead = [heading(0.3, 0.4 * (dim - 2)), heading(2.0)]
    one = frame(ahead, tick, form="fish", **changes)
    if dim == 3:
        return one
    place = {"heading": one.heading[:, :2], "position": one.position[:, :2], "world": SEA}
    return frame(ahead, tick, form="fish", **(place | changes))


def test_the_meshes_are_as_alike_on_the_left_as_on_the_right():
    for vertices, faces in (fish_trunk(), fish_tail()):
        mirrored = vertices * np.array([1.0, -1.0, 1.0])
        assert {tuple(np.round(v, 9)) for v in vertices} == {
            tuple(np.round(v, 9)) for v in mirrored
        }
        assert faces.max() == len(vertices) - 1


def test_a_fish_takes_no_more_to_draw_than_a_bird():
    fish, bird = (sum(len(part.mesh[1]) for part in shape.parts) for shape in (SWIMMER, BIRD))
    assert fish <= bird
    assert len(SWIMMER.parts) == len(BIRD.parts)


@pytest.mark.parametrize("dim", [2, 3])
def test_tails_hang_at_their_trunks_and_swing_sideways_about_them(dim):
    scene, clock = Stand(), Clock()
    parts = Parts(scene)
    parts._flight._clock = clock
    angles = []
    for tick in range(60):
        made = shown(swimming(tick, dim))
        for node, name, value in parts.draw_flock(made):
            setattr(node, name, value)
        trunks, tails = scene.there("/flock/fish/trunks"), scene.there("/flock/fish/tails")
        size = SWIMMER.scale * made.length
        apart = tails.batched_positions - trunks.batched_positions
        ahead = ahead_directions(trunks.batched_wxyzs)
        near = 2.0 * OF_LENGTH * made.length
        assert apart == pytest.approx(HINGE[0] * size * ahead, abs=near)
        up = up_directions(trunks.batched_wxyzs)
        assert up_directions(tails.batched_wxyzs) == pytest.approx(up, abs=2e-3)
        turned = ahead_directions(tails.batched_wxyzs)
        angles.append(np.sum(np.cross(ahead, turned) * up, axis=1))
        clock.now += STEP
    assert np.all(np.ptp(angles, axis=0) > 1.6 * np.sin(SWIMMING.amplitude)), "to both sides"


def test_a_fish_does_not_bank_into_a_turn():
    clock = Clock()
    flight = FlockMotion(clock)
    for tick in range(20):
        clock.now += STEP
        made = shown(frame([heading(0.1 * tick)], tick, form="fish"))
        poses = flight.follow(made)
    assert poses.wxyz == pytest.approx(made.wxyz, abs=1e-6)


def test_a_flock_is_followed_anew_when_it_is_drawn_as_something_else():
    flight = FlockMotion(Clock())
    flight.follow(shown(frame([heading(0.3)], 5)))
    poses = flight.follow(shown(frame([heading(0.3)], 5, form="fish")))
    assert abs(poses.beat[0]) <= SWIMMING.amplitude


def test_models_about_fish_say_so_and_others_are_birds():
    assert FrameBuilder(Flock("couzin", agents=3, rng=1), 1).build().form == "fish"
    assert FrameBuilder(Flock("thesis", agents=3, rng=1), 1).build().form == "birds"


def test_a_scene_chooses_its_form_and_one_of_before_keeps_its_darts():
    scene = "[run]\nmodel = 'vem'\n[look]\n"
    assert SavedScene.from_toml(scene + "form = 'fish'", "a").look == {"form": "fish"}
    assert SavedScene.from_toml(scene + "birds = false", "a").look == {"form": "darts"}
    assert SavedScene.from_toml(scene + "birds = true", "a").look == {}


def test_a_tail_turns_about_its_hinge_and_the_head_stays():
    angle = np.array([0.0, 0.4])
    head, tip = turn_tails(np.array([[0.5, 0.0], [-0.6, 0.0]]), angle).transpose(1, 0, 2)
    assert head == pytest.approx(np.array([[0.5, 0.0]] * 2))
    from_hinge = tip - np.array(HINGE[:2])
    assert np.linalg.norm(from_hinge, axis=1) == pytest.approx(0.42)
    assert np.arctan2(*from_hinge.T[::-1]) % (2 * np.pi) == pytest.approx(np.pi + angle)


def test_pictures_show_fish_whose_tails_swing_from_tick_to_tick():
    ids = np.arange(3)
    before, after = swimming_outlines(ids, 0), swimming_outlines(ids, 3)
    head = before[0, :, 0] > HINGE[0]
    assert before[:, head] == pytest.approx(after[:, head])
    assert np.abs(before[:, ~head] - after[:, ~head]).max() > 0.1
    now = Flock("couzin", agents=4, dim=3, rng=1).snapshot()
    made = shot(now, look_of(now, None))
    corners = agent_corners(made, slice(None))
    mouth = corners[:, 0] - made.made.at
    along = np.einsum("ij,ij->i", mouth, now.heading)
    assert along == pytest.approx(0.5 * SWIMMER.scale * made.made.length)
