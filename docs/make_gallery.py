"""Draws the gallery's pictures into static/gallery: `python docs/make_gallery.py [NAMES]`.

Each run has a still picture, and a short loop of what comes after it; worlds have pictures alone.
"""

from __future__ import annotations

import io
import sys
from dataclasses import dataclass, replace

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from PIL import Image
from rule_pictures import (
    by_heading,
    by_layer,
    draw_agents,
    draw_tails,
    draw_world,
    frame,
    moment,
    on_mission,
)
from rule_scenes import ON_TORUS, Scene, flock_of, scene_of
from rule_scenes import SCENES as SCENES_OF_MODELS

from agents import Flock
from agents.catalogue import MODELS
from app.viewer.gallery.lessons.lessons import built_in_lesson, lesson_names
from app.viewer.gallery.scene_collection import MOVES, PICTURES, built_in_scene, scene_names
from app.viewer.scene.shown.palette import colours_by_kind
from app.worlds.world_picture import LOOK, draw_plan
from worlds.generators import draw_obstacles
from worlds.layout import layout_names, world

SIDE = 10.0
"""Of worlds without a size of their own."""
WIDTH, HEIGHT = 360, 240
"""Of a picture, pixels."""
LOOP, PICTURES_OF_LOOP, LASTS, LARGEST = (240, 160), 24, 80, 40_000
"""Of a loop: pixels, pictures, ms that each lasts, bytes."""
STEP, MOST_TICKS = 0.012, 100
"""How far agents get from one to the next, as a share of its width; after how many ticks."""
SCENES = {
    "spread": Scene((9,), 0.28),
    "bands": Scene((200,), 0.7),
    "beside": Scene((5,), 0.3),
    "cars": Scene((400,), 0.5, tail=200),
    "clusters": Scene((5000,), 0.9),
    "drones": Scene((900,), 7.0, tail=60),
    "echelons": Scene((2000,), 4.0),
    "lanes": Scene((3000,), 1.1, tail=25),
    "mill": Scene((3000,), 0.2, tail=15),
    "mission": Scene((190,), 0.5, tail=30, window=(11, 8)),
    "opinions": Scene((1200,), 0.5, tail=12),
    "order": Scene((60,), 0.6),
    "pocket": Scene((1000,), 2.2, tail=200),
    "predator": Scene((500,), 0.3),
    "school": Scene((1000,), 1.6),
    "sheep": Scene((400,), 0.6, tail=12, form="darts"),
    "sorted": Scene((1000,), 1.0),
    "spins": Scene((60,), 0.36),
}
"""The tick at which one sees what a scene shows, and how long its agents are drawn."""
LESSONS = {
    "order-against-noise": Scene((200,), 0.3),
    "beat-the-paper": Scene((3,), 0.3),
    "braking-drones": Scene((400,), 7.0, tail=60),
    "delay-breaks-flocks": Scene((900,), 2.0, tail=150),
    "fast-and-slow": Scene((700,), 1.0),
    "field-of-view": Scene((1000,), 0.8, window=(24, 16)),
    "lanes-of-pedestrians": Scene((2000,), 1.3),
    "leaders-who-disagree": Scene((900,), 0.5, tail=12),
    "phase-transition": Scene((200,), 0.33),
    "predators-and-prey": Scene((220,), 0.25),
    "seven-neighbours": Scene((300,), 0.33),
    "shepherd": Scene((700,), 0.6, tail=12, form="darts"),
    "who-leads": Scene((9,), 0.4),
    "zones-and-the-mill": Scene((1000,), 0.8, window=(24, 16)),
}
"""The same for lessons."""
MODELS_APART = {
    "active-brownian": Scene((0, 0, 5000), 0.7, view=((4.0, 4.0), (16.0, 12.0))),
    "boundary-points": replace(SCENES_OF_MODELS["boundary-points"], ticks=(0, 0, 400)),
    "gregoire-chate": replace(ON_TORUS, seed=9, tail=12),
    "hwvem": replace(ON_TORUS, ticks=(0, 0, 4), seed=21),
    "hwvem-nav": replace(SCENES_OF_MODELS["hwvem-nav"], ticks=(0, 0, 600)),
    "ivem-a": replace(ON_TORUS, ticks=(0, 0, 6), seed=12, tail=5),
    "leadership": replace(SCENES_OF_MODELS["leadership"], view=((4.0, 0.0), (30.0, 16.0))),
    "pedestrian": Scene((0, 0, 1000), 0.9, view=((8.0, 0.0), (23.0, 10.0))),
    "prey-swarm": Scene((0, 0, 100), 0.13, tail=40, view=((0.6, 0.6), (4.34, 4.34))),
    "squashing": Scene((0, 0, 100), 0.8, tail=100),
    "squashing-best": Scene((0, 0, 400), 0.8, tail=200),
    "topological": replace(ON_TORUS, seed=14, tail=10, length=0.3),
    "vasarhelyi": replace(SCENES_OF_MODELS["vasarhelyi"], ticks=(0, 0, 1300)),
    "vem-a": replace(ON_TORUS, seed=13, tail=8, length=0.3),
    "vicsek1995": replace(ON_TORUS, ticks=(0, 0, 60), agents=400, size=10.0, seed=5),
    "wvem": replace(ON_TORUS, ticks=(0, 0, 30), seed=16),
}
"""Models whose pictures would look like others: another moment, part or number of agents."""


@dataclass(frozen=True)
class Camera:
    """What a picture shows of the plane."""

    middle: np.ndarray
    half: np.ndarray
    """Half of its sides, (2,), length."""


def camera_of(flock: Flock, scene: Scene) -> Camera:
    """What is shown of a run: its world, filled by where the flock is, or what its scene says."""
    low, high = scene.view or (flock.world.low, np.add(flock.world.low, flock.world.size))
    low, high = np.array(low)[:2], np.array(high)[:2]
    place = flock.position[:, :2]
    if not any(flock.world.wraps) and (np.any(place < low) or np.any(place > high)):
        low, high = place.min(axis=0), place.max(axis=0)  # an open plane, of which it takes a part
    if scene.window:  # of a long way, the part where the flock is
        low, high = np.array([np.median(place, axis=0) - 12.0, np.median(place, axis=0) + 12.0])
    half = 0.53 * (high - low)
    sides = half / [WIDTH, HEIGHT]
    fills = flock.world.dim == 2 and all(flock.world.wraps)  # nothing is lost: it goes on
    half = (min(sides) if fills else max(sides)) * np.array([WIDTH, HEIGHT])
    return Camera((low + high) / 2, half)


def draw(flock: Flock, scene: Scene, trace: np.ndarray, camera: Camera) -> Figure:
    """One moment of a run, with where its agents have just been, (T, N, dim)."""
    colour = by_layer(flock) if on_mission(flock) else by_heading(flock)
    if flock.kinds.kinds:
        colour = colours_by_kind(flock.arrays.kind.astype(int), flock.kinds)
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure = Figure(figsize=(WIDTH / 50, HEIGHT / 50))
        axes = figure.add_axes((0, 0, 1, 1))
        draw_world(axes, flock)
        draw_tails(axes, without_jumps(trace, flock), colour, 1.2)
        draw_agents(axes, flock, colour, 1.4 * scene.length, scene.form)
        frame(axes, camera.middle - camera.half, camera.middle + camera.half, "")
    return figure


def without_jumps(trace: np.ndarray, flock: Flock) -> np.ndarray:
    """The same with no place where an agent came in on the other side."""
    jumps = np.abs(np.diff(trace, axis=0)) > 0.5 * np.array(flock.world.size)
    bare = trace.copy()
    bare[1:][(jumps & flock.world.wraps).any(axis=2)] = np.nan
    return bare


def picture_run(name: str, flock: Flock, scene: Scene, tick: int) -> None:
    """Draw a run at a tick, and what comes after it."""
    trace = moment(flock, tick, scene.tail)
    camera = camera_of(flock, scene)
    save(name, taken(draw(flock, scene, trace, camera)))
    far = float(np.median(flock.speed)) * flock.dt
    ticks = int(np.clip(round(STEP * 2.0 * camera.half[0] / max(far, 1e-9)), 1, MOST_TICKS))
    pictures = []
    for k in range(PICTURES_OF_LOOP):
        if k:
            trace = np.concatenate([trace, flock.trace(ticks)])[-scene.tail - 1 :]
        pictures.append(taken(draw(flock, scene, trace, camera), LOOP))
    (PICTURES / f"{name}{MOVES}.webp").write_bytes(as_loop(pictures))


def as_loop(pictures: list[Image.Image]) -> bytes:
    """Pictures as an animated WebP of at most `LARGEST` bytes: coarser, and then fewer, if need
    be."""
    for every, quality in ((1, 50), (1, 30), (1, 15), (2, 30), (2, 15), (2, 5), (3, 5)):
        data, (first, *rest) = io.BytesIO(), pictures[::every]
        first.save(
            data, "webp", save_all=True, append_images=rest, duration=LASTS * every, loop=0,
            quality=quality, method=4,
        )  # fmt: skip
        if data.tell() <= LARGEST:
            break
    return data.getvalue()


def taken(figure: Figure, size: tuple[int, int] = (WIDTH, HEIGHT)) -> Image.Image:
    """A figure at a size, pixels; without another that of the gallery's pictures."""
    data = io.BytesIO()
    figure.savefig(data, dpi=100 * size[0] / WIDTH)
    return Image.open(data).convert("RGB").resize(size, Image.Resampling.LANCZOS)


def save(name: str, picture: Image.Image) -> None:
    """Write one of them."""
    picture.save(PICTURES / f"{name}.webp", quality=80, method=6)


def main(only: tuple[str, ...] = ()) -> None:
    """Draw all pictures, or these."""
    PICTURES.mkdir(exist_ok=True)
    for name in scene_names():
        if not only or name in only:
            scene = SCENES[name]
            picture_run(name, Flock(built_in_scene(name).spec), scene, scene.ticks[0])
    for name in lesson_names():
        if not only or f"lesson-{name}" in only:
            scene = LESSONS[name]
            picture_run(f"lesson-{name}", Flock(built_in_lesson(name).spec), scene, scene.ticks[0])
    for name, model in MODELS.items():
        if not only or f"model-{name}" in only:
            scene = MODELS_APART.get(name, scene_of(model))
            picture_run(f"model-{name}", flock_of(model, scene), scene, scene.ticks[2])
    for name in layout_names():
        if not only or f"world-{name}" in only:
            figure = Figure(figsize=(WIDTH / 50, HEIGHT / 50))
            axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
            draw_plan(axes, draw_obstacles(world(name, unsized=lambda _: SIDE), 1))
            axes.set(aspect="equal", xticks=[], yticks=[])
            axes.spines[:].set_visible(False)
            save(f"world-{name}", taken(figure))


if __name__ == "__main__":
    main(tuple(sys.argv[1:]))
