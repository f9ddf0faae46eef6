"""A picture from Python: what a notebook shows is what is saved."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from flockscope import Flock
from worlds.input_error import InputError


@pytest.fixture(scope="module")
def flock():
    made = Flock("vem", agents=30, rng=1, eta=0.4)
    made.run(20)
    return made


def test_it_is_a_png_of_its_size_with_agents_in_it(flock):
    still = flock.picture((640, 400))
    seen = Image.open(io.BytesIO(still._repr_png_()))
    assert seen.size == (640, 400)
    pixels = np.asarray(seen.convert("RGB"), int)
    assert np.mean(pixels.max(axis=2) - pixels.min(axis=2) > 90) > 0.001
    assert repr(still) == "<Picture of vem at tick 20, 640x400>"


def test_it_stays_as_the_flock_was(tmp_path):
    mine = Flock("vem", agents=30, rng=1, eta=0.4)
    still = mine.picture()
    before = still.drawn(".svg")
    mine.run(10)
    still.save(tmp_path / "then.svg")
    still.save(tmp_path / "then.png")
    assert (tmp_path / "then.svg").read_bytes() == before
    assert (tmp_path / "then.png").read_bytes() == still.png
    assert mine.picture().png != still.png


def test_in_space_and_after_an_agent(flock):
    space = Flock("vem", agents=20, size=4.0, dim=3, rng=1)
    assert space.picture(camera="side").png != space.picture().png
    assert flock.picture(follow=3).png != flock.picture(follow=4).png
    assert flock.picture(colour="plain").png != flock.picture().png


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ("outside \\[320, 8000\\]", {"size": (10, 500)}),
        ("not a width and a height", {"size": (500,)}),
        ("not a width and a height", {"size": (500.5, 400)}),
        ("unknown camera 'round'", {"camera": "round"}),
        ("unknown renderer", {"renderer": "pen"}),
        ("unknown colour", {"colour": "mood"}),
        ("takes renderer = 'browser'", {"camera": "side"}),
        ("follow = 1 is not allowed", {"camera": "side", "follow": 1}),
        ("agent 999 is not there", {"follow": 999}),
    ],
)
def test_what_cannot_be_drawn_is_refused(flock, words, options):
    with pytest.raises(InputError, match=words):
        flock.picture(**options)


def test_only_pictures_are_written(flock, tmp_path):
    with pytest.raises(InputError, match=r"ends in \.png or \.svg or \.pdf"):
        flock.picture().save(tmp_path / "flock.gif")
