"""The collection: built-in scenes and lessons, every model where it is at home, every world with a
flock."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path

from agents.catalogue import MODELS
from agents.catalogue import model as find_model
from agents.models.model import Model
from agents.models.related import MOST, related_models
from agents.spec import DEFAULT
from app.viewer.gallery.lessons.lessons import built_in_lesson, lesson_names
from app.viewer.gallery.saved_scene import PACKED, SavedScene, unpack_scene
from app.viewer.gallery.step_pictures import MOVES, PICTURES
from app.viewer.run.run_preset import preset_spec, world_defaults, world_title
from worlds.input_error import InputError, unknown
from worlds.layout import layout_names, shared_layout

FOLDER = Path(__file__).parent / "scenes"
"""A scene a file; its name is that by which it is opened."""
FIRST, NEXT = "spread", "order"
"""The scene that the page opens on, and the one that comes next."""
MODEL, WORLD, LESSON = "model:", "world:", "lesson:"
"""Stand before the name of a model, of a world or of a lesson, that is opened as a scene."""
LESSONS = "Lessons"
GROUPS = (
    "Scenes",
    LESSONS,
    "Alignment",
    "Zones",
    "Navigators",
    "Drones and birds",
    "Cars",
    "Others",
)
WORLDS = "Worlds"


@dataclass(frozen=True)
class GalleryCard:
    """Something that can be opened, as the gallery shows it."""

    name: str
    """By which it is opened."""
    group: str
    title: str
    line: str
    """What it is, in a sentence or two."""
    picture: str = ""
    """Name of its picture, if it has one."""
    tags: tuple[str, ...] = ()
    """Words by which it is found too; topics are offered to choose from."""
    moves: str = ""
    """Name of the loop that the picture begins, if it has one."""
    related: tuple[str, ...] = ()
    """Names of what else one may want to open, three at most."""


@cache
def scene_names() -> tuple[str, ...]:
    """Names of the built-in scenes; the first is what the page opens on."""
    names = sorted(path.stem for path in FOLDER.glob("*.toml"))
    return tuple(dict.fromkeys((FIRST, NEXT, *names)))


def find_scene(name: str) -> SavedScene:
    """What is called `name`: a scene, `model:NAME`, `world:NAME`, `lesson:NAME`, or one packed in
    an address.

    Names come from browsers too: none is that of a file. Raises InputError.
    """
    if name.startswith(PACKED):
        return unpack_scene(name)
    if name.startswith(MODEL):
        model = find_model(name.removeprefix(MODEL))
        tries = "".join(f"{step.words} {step.see}" for step in model.to_try[:1])
        return SavedScene(model.title, preset_spec(model.name), watch=model.summary, tries=tries)
    if name.startswith(WORLD):
        return scene_of_world(name.removeprefix(WORLD))
    if name.startswith(LESSON):
        lesson = name.removeprefix(LESSON)
        if lesson not in lesson_names():
            raise unknown("lesson", lesson, lesson_names())
        return built_in_lesson(lesson)
    if name not in scene_names():
        raise unknown("scene", name, scene_names())
    return built_in_scene(name)


def find_lesson(name: str) -> SavedScene:
    """The scene of a lesson, or a scene of the gallery. Raises InputError."""
    if name in lesson_names():
        return built_in_lesson(name)
    if ":" not in name and name not in scene_names():
        raise unknown("lesson or scene", name, (*lesson_names(), *scene_names()))
    return find_scene(name)


@cache
def built_in_scene(name: str) -> SavedScene:
    """One of the built-in scenes."""
    return SavedScene.from_toml((FOLDER / f"{name}.toml").read_text("utf-8"), f"scene {name}")


def scene_of_world(world: str) -> SavedScene:
    """A world with a model that is at home in it, or can be. Raises InputError."""
    if world not in layout_names():
        raise unknown("world", world, layout_names())
    own = next((model for model in MODELS.values() if model.world == world), None)
    if own is None:
        in_space = next(model for model in MODELS.values() if model.dim == 3)
        own = in_space if world_defaults(world).dim == 3 else find_model(DEFAULT)
    return SavedScene(world_title(world), preset_spec(own.name, world=world))


def cards() -> tuple[GalleryCard, ...]:
    """All that can be opened, in the order in which it is shown."""
    return cards_with(tuple(MODELS.values()))


@lru_cache(maxsize=1)
def cards_with(model_set: tuple[Model, ...]) -> tuple[GalleryCard, ...]:
    """The same with these models, all that there are."""
    scenes = [
        GalleryCard(
            name,
            GROUPS[0],
            built_in_scene(name).title,
            built_in_scene(name).watch,
            picture_name(name),
            tags_of(find_model(built_in_scene(name).spec.model), built_in_scene(name).spec.dim),
            picture_name(name + MOVES),
        )
        for name in scene_names()
    ]
    lessons = [
        GalleryCard(
            LESSON + name,
            LESSONS,
            built_in_lesson(name).title,
            built_in_lesson(name).watch,
            picture_name(f"lesson-{name}"),
            lesson_tags(built_in_lesson(name)),
            picture_name(f"lesson-{name}{MOVES}"),
        )
        for name in lesson_names()
    ]
    models = [
        GalleryCard(
            MODEL + model.name,
            group(model),
            model.title,
            model.summary,
            picture_name(f"model-{model.name}"),
            tags_of(model, *model.dimensions),
            picture_name(f"model-{model.name}{MOVES}"),
        )
        for model in model_set
    ]
    worlds = [
        GalleryCard(
            WORLD + name,
            WORLDS,
            world_title(name),
            describe_world(name),
            picture_name(f"world-{name}"),
            dimension_words(world_defaults(name).dim),
        )
        for name in layout_names()
    ]
    order = {title: place for place, title in enumerate((*GROUPS, WORLDS))}
    every = [*scenes, *lessons, *models, *worlds]
    linked = (replace(card, related=related_cards(card.name, model_set)) for card in every)
    return tuple(sorted(linked, key=lambda card: order[card.group]))


def related_cards(name: str, model_set: tuple[Model, ...]) -> tuple[str, ...]:
    """Names of the cards that one is related to: of a world the models that are at home there, of
    anything else its model, another run of that model, and the models related to it."""
    if name.startswith(WORLD):
        home = name.removeprefix(WORLD)
        found = [MODEL + model.name for model in model_set if model.world == home]
        return tuple(found[:MOST])
    model = card_model(name)
    runs = [*scene_names(), *(LESSON + lesson for lesson in lesson_names())]
    shown = [run for run in runs if run != name and card_model(run) is model]
    others = (MODEL + other.name for other in related_models(model, model_set))
    own = [] if name.startswith(MODEL) else [MODEL + model.name]
    return (*own, *shown[:1], *others)[:MOST]


def card_model(name: str) -> Model:
    """The model of a scene, a lesson or a model, by the name of its card."""
    if name.startswith(MODEL):
        return find_model(name.removeprefix(MODEL))
    is_lesson = name.startswith(LESSON)
    scene = built_in_lesson(name.removeprefix(LESSON)) if is_lesson else built_in_scene(name)
    return find_model(scene.spec.model)


def tags_of(model: Model, *dims: int) -> tuple[str, ...]:
    """Words by which what has a model is found: of its rule, dimensions and source."""
    words = [word for dim in dims for word in dimension_words(dim)]
    return tuple(dict.fromkeys([*model.rule.tags, *words, model.rule.source]))


def lesson_tags(lesson: SavedScene) -> tuple[str, ...]:
    """Words by which a lesson is found: those of its model, and the topic of all lessons."""
    words = tags_of(find_model(lesson.spec.model), lesson.spec.dim)
    return tuple(dict.fromkeys(["classroom", "lesson", *words]))


def dimension_words(dim: int | None) -> tuple[str, ...]:
    """How people write a number of dimensions."""
    return ("3-D", "3d", "space") if dim == 3 else ("2-D", "2d", "plane")


def group(model: Model) -> str:
    """The part of the gallery that a model is in."""
    body = model.body
    if body.vehicle is not None:
        return "Cars"
    if body.family in FAMILIES:
        return FAMILIES[body.family]
    if model.rule.zones:
        return "Zones"
    return "Navigators" if "gamma" in model.rule.forces else "Others"


FAMILIES = {"vicsek": "Alignment", "mission": "Navigators", "aircraft": "Drones and birds"}
"""Parts of the gallery, by the family of the body."""


def describe_world(world: str) -> str:
    """What a world is, from its own words."""
    try:
        layout = shared_layout(world)
    except InputError:
        return ""
    own = world_defaults(world)
    dim = "2-D or 3-D" if own.dim is None else f"{own.dim}-D"
    count = len(layout.get("obstacle", []))
    solid = "" if count == 0 else f", {count} obstacle{'s' if count > 1 else ''}"
    return f"{dim}{solid}"


def picture_name(name: str) -> str:
    """The name of the picture of something, empty if it has none."""
    return f"{name}.webp" if f"{name}.webp" in pictures() else ""


@cache
def pictures() -> dict[str, bytes]:
    """The pictures of the gallery by their names, read once."""
    return {path.name: path.read_bytes() for path in sorted(PICTURES.glob("*.webp"))}
