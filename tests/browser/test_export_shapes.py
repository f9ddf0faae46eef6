"""Birds, fish and cars in a flock's page: the laboratory's meshes, how they hold themselves."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from app.viewer.lab import flock_page
from app.viewer.lab.flock_page import PageWords
from app.viewer.run.frame_builder import FrameBuilder
from app.viewer.scene.draw.agent_shapes import BIRD, CAR, MOTION, SWIMMER, SWIMMING
from app.viewer.scene.marks.agents import FlockMotion
from tests.browser import exported_page
from tests.viewer.sky import Clock, shown
from tests.viewer.waiting import until

CALLS = """() => {
  const { gl } = page.view, calls = [];
  for (const name of ["drawArraysInstanced", "drawElementsInstanced"])
    gl[name] = (...given) => {
      calls.push([name, ...given]);
      WebGL2RenderingContext.prototype[name].apply(gl, given);
    };
  page.show();
  for (const name of ["drawArraysInstanced", "drawElementsInstanced"]) delete gl[name];
  return [calls, gl.getError()];
}"""
FOLLOWED = """(seconds) => {
  const { view, state } = page, before = performance.now;
  globalThis.followed ??= new AgentShape(view);
  performance.now = () => 1000 * seconds;
  const poses = followed.follow(state, view.inSpace(state.heading, state.ids.length));
  performance.now = before;
  return [...poses];
}"""


def triangles(shape) -> int:
    """Of how many an agent is made in the laboratory."""
    return sum(len(part.mesh[1]) for part in shape.parts)


def birds(count: int = 40) -> Flock:
    """A flock in space."""
    return Flock("vem", agents=count, dim=3, rng=2)


def fish(dim: int = 3) -> Flock:
    """A school."""
    return Flock("couzin", agents=40, dim=dim, rng=2)


def drawn(page) -> list:
    """The one call that draws all agents: its name and arguments."""
    calls, error = page.evaluate(CALLS)
    assert error == 0
    (call,) = calls
    return call


@pytest.mark.parametrize(
    ("flock", "shape"), [(birds(), BIRD), (fish(), SWIMMER), (fish(dim=2), SWIMMER)]
)
def test_animals_are_the_laboratorys_meshes(opened, flock, shape):
    with opened(flock) as page:
        parts = page.evaluate("page.manifest.shape.parts")
        for part, known in zip(parts, shape.parts, strict=True):
            assert part["hinge"] == list(known.hinge)
            vertices, faces = known.mesh
            corners = np.reshape(part["corners"], vertices.shape) / 1000.0
            assert corners == pytest.approx(vertices, abs=5.1e-4)
            assert np.reshape(part["faces"], faces.shape).tolist() == faces.tolist()
        name, _, corners, _, _, count = drawn(page)
        assert (name, corners, count) == ("drawElementsInstanced", 3 * triangles(shape), 40)


def test_more_than_the_laboratory_draws_as_birds_are_darts(opened):
    with opened(birds()) as page:
        assert page.evaluate("page.manifest.shape.most") == BIRD.most
        assert page.evaluate("[3000, 3001].map((count) => page.view.shape.fits(count))") == [
            True,
            False,
        ]
        page.evaluate("page.manifest.shape.most = 39")
        assert drawn(page)[0] == "drawArraysInstanced"


def test_a_bird_is_picked_where_it_is_drawn(opened):
    with opened(birds()) as page:
        x, y = page.evaluate(
            """() => {
              const { view } = page, box = view.canvas.getBoundingClientRect();
              const [x, y] = view.project(...view.placeOf(view.ids.indexOf(7n)));
              return [box.x + x / view.scale, box.y + y / view.scale];
            }"""
        )
        page.mouse.click(x, y)
        until(lambda: page.inner_text("#picked").startswith("Agent "), 30, "a picked bird")
        page.click("#step")
        until(lambda: page.evaluate("page.state.tick") == 1, 30, "a tick")
        assert page.evaluate("page.view.picked") is not None


def test_birds_beat_and_bank_as_in_the_laboratory(opened):
    flock, clock = birds(), Clock()
    motion, camera = FlockMotion(clock), FrameBuilder(flock, 1)
    with opened(birds()) as page:
        for tick in range(6):
            poses = motion.follow(shown(camera.build()))
            until(lambda tick=tick: page.evaluate("page.state.tick") == tick, 30, "a tick")
            lean, beat = np.reshape(page.evaluate(FOLLOWED, clock.now), (-1, 2)).T
            assert beat == pytest.approx(poses.beat, abs=1e-5)
            assert lean == pytest.approx(motion._lean, abs=1e-5)
            clock.now += 0.04
            flock.run(1)
            page.click("#step")
    assert np.abs(lean).max() > 0.05
    assert np.ptp(beat) > MOTION.amplitude


def test_fish_beat_their_tails_as_in_the_laboratory(opened):
    flock, clock = fish(dim=2), Clock()
    motion, camera = FlockMotion(clock), FrameBuilder(flock, 1)
    with opened(fish(dim=2)) as page:
        for tick in range(6):
            poses = motion.follow(shown(camera.build()))
            until(lambda tick=tick: page.evaluate("page.state.tick") == tick, 30, "a tick")
            lean, beat = np.reshape(page.evaluate(FOLLOWED, clock.now), (-1, 2)).T
            assert beat == pytest.approx(poses.beat, abs=1e-5)
            assert lean == pytest.approx(0.0), "a fish is level"
            clock.now += 0.04
            flock.run(1)
            page.click("#step")
    assert np.ptp(beat) > SWIMMING.amplitude


def test_a_scene_chooses_what_its_agents_are_drawn_as(opened):
    with opened(fish(), words=PageWords(form="birds")) as page:
        assert drawn(page)[2] == 3 * triangles(BIRD)


def test_wings_are_still_where_less_motion_is_asked_for(opened):
    with opened(birds(), reduced_motion="reduce") as page:
        page.click("#go")
        until(lambda: page.evaluate("page.view.shape.beats") > 0.1, 60, "the flock to go on")
        page.click("#go")
        beat = np.reshape(page.evaluate(FOLLOWED, 5.0), (-1, 2))[:, 1]
        assert beat == pytest.approx(MOTION.dihedral)


def test_the_crashed_fall_with_folded_wings_and_lie_flat(opened):
    with opened(birds()) as page:
        poses, headings = page.evaluate(
            """() => {
              const { view, state } = page, count = state.ids.length;
              const crashed = state.crashed.slice().fill(1), speed = state.speed.slice().fill(0, 1);
              const headings = view.inSpace(state.heading, count);
              const poses = new AgentShape(view).follow({ ...state, crashed, speed }, headings);
              return [[...poses], [...headings]];
            }"""
        )
    assert np.reshape(poses, (-1, 2))[:2, 1] == pytest.approx([MOTION.folded, MOTION.flat])
    rise = np.reshape(headings, (-1, 3))[:, 2]
    assert rise[0] == pytest.approx(np.sin(MOTION.dive))
    assert rise[1:] == pytest.approx(0.0)


def test_cars_are_the_laboratorys_meshes_true_to_scale(opened, monkeypatch):
    # The page of a flock of cars compiles for long: here one of darts is told that they are cars.
    monkeypatch.setattr(flock_page, "shape_of", lambda *_: CAR)
    monkeypatch.setattr(exported_page, "PAGES", {})
    with opened(Flock("vem", agents=31, rng=5)) as page:
        page.evaluate("page.state.car = [0.5, 0.25]")
        name, _, corners, _, _, count = drawn(page)
        assert (name, corners, count) == ("drawElementsInstanced", 3 * triangles(CAR), 31)
        assert page.evaluate("page.view.shape.size(page.state)") == pytest.approx(
            [0.5, 0.25, 0.25 * CAR.height]
        )


def test_a_page_of_darts_has_no_shape(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        assert "shape" not in page.evaluate("page.manifest")
        assert page.evaluate("typeof AgentShape") == "undefined"
        assert drawn(page)[0] == "drawArraysInstanced"
