"""Pictures of a lesson's steps: which are taken, and that pages and the laboratory show them."""

from __future__ import annotations

import base64
import io
import json
import struct
import zlib

import pytest
from PIL import Image

from agents.flock import Flock
from app.classroom.workers.page_worker import PageWorker
from app.viewer.gallery.lessons.lessons import built_in_lesson, lesson_names
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_collection import pictures
from app.viewer.gallery.step_pictures import MOVES, gallery_pictures, picture_address
from app.viewer.lab.flock_page import PageWords, flock_page, page_files
from app.viewer.lab.panels.step_progress import sentence
from worlds.input_error import InputError

RUN = '[run]\nmodel = "vem"\nagents = 20\nsize = 5.0\nworld = "wrap"\n'


def written(kind: str, width: int = 3, height: int = 2, **options) -> bytes:
    """A picture of one colour in a format of Pillow's."""
    made = io.BytesIO()
    Image.new("RGB", (width, height), "red").save(made, kind, **options)
    return made.getvalue()


def address(content: bytes, kind: str) -> str:
    """What a lesson carries of a picture."""
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def huge_png() -> bytes:
    """A small file whose head says that it has thirty thousand pixels a side."""
    head = b"IHDR" + struct.pack(">IIBBBBB", 30_000, 30_000, 8, 2, 0, 0, 0)
    data = b"IDAT" + zlib.compress(b"")
    parts = (struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part))
             for part in (head, data, b"IEND"))  # fmt: skip
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def moving() -> bytes:
    """A picture that moves."""
    frames = [Image.new("RGB", (2, 2), colour) for colour in ("red", "blue")]
    made = io.BytesIO()
    frames[0].save(made, "WEBP", save_all=True, append_images=frames[1:])
    return made.getvalue()


def scene_with(picture: str) -> SavedScene:
    """A scene of two steps, of which the first has a picture. Raises InputError."""
    steps = f'[[steps]]\nsay = "Look."\npicture = {json.dumps(picture)}\n[[steps]]\nsay = "On."\n'
    return SavedScene.from_toml(RUN + steps, "mine.toml")


@pytest.mark.parametrize("kind", ["webp", "png", "jpeg"])
def test_a_picture_goes_along_with_its_lesson(kind):
    picture = address(written(kind.upper(), 2000, 1), kind)
    scene = scene_with(picture)
    again = SavedScene.from_toml(scene.to_toml(), "again.toml")
    assert again.steps == scene.steps
    assert again.steps[0].values() == {"say": "Look.", "picture": picture}
    assert again.steps[0].page_values()["picture"] == picture


def test_a_picture_of_the_gallery_is_called_by_its_name():
    scene = scene_with("lesson-who-leads")
    assert 'picture = "lesson-who-leads"' in scene.to_toml()
    assert SavedScene.from_toml(scene.to_toml(), "again.toml").steps == scene.steps
    shown = picture_address("lesson-who-leads")
    assert shown == address(pictures()["lesson-who-leads.webp"], "webp")
    assert not [name for name in gallery_pictures() if name.endswith(MOVES)]


PNG = address(written("PNG"), "png")
REFUSED = {
    "no such name": ("none-such", "the gallery has no such picture"),
    "a path": ("../logo", "the gallery has no such picture"),
    "a loop": ("order-moves", "the gallery has no such picture"),
    "elsewhere": ("https://example.org/a.png", "the gallery has no such picture"),
    "a drawing": ("data:image/svg+xml;base64,AAAA", "it is of another kind"),
    "a page": ("data:text/html;base64,AAAA", "it is of another kind"),
    "more in the head": (PNG.replace(";base64", ";a=1;base64"), "it is of another kind"),
    "no base 64": ("data:image/png;base64,AA%22", "it is no base 64"),
    "marks": (PNG + '" onerror="alert(1)', "it is no base 64"),
    "nothing": ("data:image/png;base64,", "it cannot be read as PNG"),
    "another format": (PNG.replace("png", "webp"), "it cannot be read as WEBP"),
    "a part": (address(written("PNG", 99, 99)[:-30], "png"), "it cannot be read as PNG"),
    "too wide": (address(written("PNG", 2001, 1), "png"), "it has 2001 x 1 pixels"),
    "a bomb": (address(huge_png(), "png"), "it has too many pixels"),
    "a film": (address(moving(), "webp"), "it moves"),
    "too long": ("data:image/png;base64," + "A" * 100_000, "it has 100,022 characters"),
}


@pytest.mark.parametrize(("picture", "said"), REFUSED.values(), ids=REFUSED)
def test_another_picture_is_refused_in_a_line(picture, said):
    with pytest.raises(InputError) as refused:
        scene_with(picture)
    line = str(refused.value)
    assert said in line
    assert line.startswith("picture = ")
    assert "step 1, mine.toml" in line
    assert "at most 100,000 characters and 2000 x 2000 pixels" in line
    assert "\n" not in line
    assert len(line) < 400


@pytest.mark.parametrize("value", [3, True, ["order"]])
def test_what_is_no_text_is_no_picture(value):
    with pytest.raises(InputError, match="step 1: picture"):
        SavedScene.from_toml(
            f'{RUN}[[steps]]\nsay = "Look."\npicture = {json.dumps(value)}\n', "mine.toml"
        )


def test_the_laboratory_shows_it_with_its_step():
    first, second = scene_with("order").steps
    assert f'<img alt="" src="{picture_address("order")}">' in sentence(0, 2, first)
    assert "<img" not in sentence(1, 2, second)


def test_built_in_lessons_begin_with_a_picture():
    shown = [name for name in lesson_names() if built_in_lesson(name).steps[0].picture]
    assert len(shown) >= 4


def test_pages_have_it_and_allow_it_and_nothing_more():
    scene, plain = scene_with("lesson-braking-drones"), scene_with("")
    words = PageWords.of_scene(scene, "flockscope export mine.toml")
    shown = picture_address("lesson-braking-drones")
    page = flock_page(Flock(scene.spec), words)
    assert f'"picture":"{shown}"' in page
    assert "img-src data:; " in page
    files = page_files(Flock(scene.spec), "mine", words)
    assert b"connect-src &#x27;self&#x27;; img-src data:; base-uri" in files["mine.html"]
    without = PageWords.of_scene(plain, "flockscope export mine.toml")
    assert "img-src" not in flock_page(Flock(plain.spec), without)
    student = PageWorker().write(scene.to_toml(), None, {})
    assert "connect-src 'self'; img-src data:; base-uri" in student.policy
