"""Draws the gallery's pictures into static/gallery: `python docs/make_gallery.py [NAMES]`."""

from __future__ import annotations

import io
import sys

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
from rule_scenes import Scene, flock_of, scene_of

from agents import Flock
from agents.catalogue import MODELS
from app.viewer.gallery.lessons.lessons import built_in_lesson, lesson_names
from app.viewer.gallery.scene_collection import PICTURES, built_in_scene, scene_names
from app.worlds.world_picture import LOOK, draw_plan
from worlds.generators import draw_obstacles
from worlds.layout import layout_names, world

SIDE = 10.0
"""Of worlds without a size of their own."""
WIDTH, HEIGHT = 360, 240
"""Of a picture, pixels."""
SCENES = {
    "spread": Scene((9,), 0.28),
    "bands": Scene((200,), 0.7),
    "beside": Scene((5,), 0.3),
    "cars": Scene((400,), 1.0),
    "clusters": Scene((5000,), 0.9),
    "drones": Scene((900,), 7.0, tail=60),
    "echelons": Scene((2000,), 4.0),
    "lanes": Scene((3000,), 1.3),
    "mill": Scene((3000,), 0.2, tail=15),
    "mission": Scene((190,), 0.5, tail=30, window=(11, 8)),
    "order": Scene((60,), 0.6),
    "pocket": Scene((1000,), 2.2, tail=200),
    "school": Scene((1000,), 1.6),
    "spins": Scene((60,), 0.36),
}
"""The tick at which one sees what a scene shows, and how long its agents are drawn."""
LESSONS = {
    "order-against-noise": Scene((200,), 0.3),
    "beat-the-paper": Scene((3,), 0.3),
    "braking-drones": Scene((400,), 7.0, tail=60),
    "delay-breaks-flocks": Scene((900,), 2.0, tail=150),
    "field-of-view": Scene((1000,), 1.6),
    "lanes-of-pedestrians": Scene((2000,), 1.3),
    "phase-transition": Scene((200,), 0.33),
    "seven-neighbours": Scene((300,), 0.33),
    "who-leads": Scene((9,), 0.4),
    "zones-and-the-mill": Scene((1000,), 1.6),
}
"""The same for lessons."""


def draw(flock: Flock, scene: Scene, tick: int) -> Image.Image:
    """One moment of a run, the picture filled by where the flock is."""
    trace = moment(flock, tick, scene.tail)
    colour = by_layer(flock) if on_mission(flock) else by_heading(flock)
    low, high = scene.view or (flock.world.low, np.add(flock.world.low, flock.world.size))
    low, high = np.array(low)[:2], np.array(high)[:2]
    place = flock.position[:, :2]
    if np.any(place < low) or np.any(place > high):  # an open plane, of which it takes a part
        low, high = place.min(axis=0), place.max(axis=0)
    if scene.window:  # of a long way, the part where the flock is
        low, high = np.array([np.median(place, axis=0) - 12.0, np.median(place, axis=0) + 12.0])
    middle, half = (low + high) / 2, 0.53 * (high - low)
    sides = half / [WIDTH, HEIGHT]
    fills = flock.world.dim == 2 and all(flock.world.wraps)  # nothing is lost: it goes on
    half = (min(sides) if fills else max(sides)) * np.array([WIDTH, HEIGHT])
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure = Figure(figsize=(WIDTH / 50, HEIGHT / 50))
        axes = figure.add_axes((0, 0, 1, 1))
        draw_world(axes, flock)
        draw_tails(axes, trace, colour, 1.2)
        draw_agents(axes, flock, colour, 1.4 * scene.length)
        frame(axes, middle - half, middle + half, "")
        return taken(figure)


def taken(figure: Figure) -> Image.Image:
    """A figure at the size of the gallery's pictures."""
    data = io.BytesIO()
    figure.savefig(data, dpi=100)
    return Image.open(data).convert("RGB").resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)


def save(name: str, picture: Image.Image) -> None:
    """Write one of them."""
    picture.save(PICTURES / f"{name}.webp", quality=80, method=6)


def main(only: tuple[str, ...] = ()) -> None:
    """Draw all pictures, or these."""
    PICTURES.mkdir(exist_ok=True)
    for name in scene_names():
        if not only or name in only:
            saved, scene = built_in_scene(name), SCENES[name]
            flock = Flock(saved.spec)
            save(name, draw(flock, scene, scene.ticks[0]))
    for name in lesson_names():
        if not only or f"lesson-{name}" in only:
            flock, scene = Flock(built_in_lesson(name).spec), LESSONS[name]
            save(f"lesson-{name}", draw(flock, scene, scene.ticks[0]))
    for name, model in MODELS.items():
        if not only or f"model-{name}" in only:
            flock, scene = flock_of(model), scene_of(model)
            save(f"model-{name}", draw(flock, scene, scene.ticks[2]))
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
