"""The colours that cars have as their own: distinct, seen by everybody, and the same everywhere."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import OWN
from app.viewer.scene.shown.drawing_style import DrawingStyle, legend
from app.viewer.scene.shown.palette import srgb_to_linear
from tests.viewer.fleet import frame, known, shown

LMS = np.array(
    [[0.4122214708, 0.5363325363, 0.0514459929],
     [0.2119034982, 0.6806995451, 0.1073969566],
     [0.0883024619, 0.2817188376, 0.6299787005]]
)  # fmt: skip
LAB = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468],
     [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)  # fmt: skip
BLIND_TO_RED = np.array(
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
     [-0.003882, -0.048116, 1.051998]]
)  # fmt: skip
BLIND_TO_GREEN = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
     [-0.011820, 0.042940, 0.968881]]
)  # fmt: skip
"""What is seen of linear light by those without one of the cones: Machado, Oliveira, Fernandes, "A
physiologically-based model for simulation of color vision deficiency" (2009)."""
GROUNDS = {"light": "#ffffff", "dark": "#171c24"}


def seen(colours: np.ndarray, eye: np.ndarray | None = None) -> np.ndarray:
    """sRGB (N, 3) in OKLab, as an eye sees it."""
    light = (
        srgb_to_linear(colours)
        if eye is None
        else np.clip(srgb_to_linear(colours) @ eye.T, 0.0, 1.0)
    )
    return np.cbrt(light @ LMS.T) @ LAB.T


def nearest(lab: np.ndarray) -> float:
    """How far apart the two are that are closest."""
    return min(float(np.linalg.norm(a - b)) for a, b in combinations(lab, 2))


def test_twelve_colours_can_be_told_apart_and_from_the_injected_car():
    assert len(palette.COLOURS) == 12
    assert nearest(seen(np.vstack([palette.COLOURS, palette.GOAL]))) > 0.1


@pytest.mark.parametrize("eye", [BLIND_TO_RED, BLIND_TO_GREEN], ids=["red", "green"])
def test_the_first_eight_can_be_told_apart_without_seeing_red_or_green(eye):
    assert nearest(seen(palette.COLOURS[:8], eye)) > 0.065
    assert nearest(seen(palette.COLOURS, eye)) > 0.04


@pytest.mark.parametrize("ground", GROUNDS.values(), ids=list(GROUNDS))
def test_each_stands_out_from_either_ground(ground):
    def luminance(colour):
        return srgb_to_linear(colour) @ [0.2126, 0.7152, 0.0722]

    behind = luminance(palette.srgb(ground))
    for colour in palette.COLOURS:
        dark, light = sorted((luminance(colour), behind))
        assert (light + 0.05) / (dark + 0.05) >= 3.0


def test_a_colour_is_the_identity_s_and_stays_when_others_go():
    colours = palette.identity_colours(np.arange(1, 13))
    assert len(np.unique(colours, axis=0)) == 12
    assert palette.identity_colours(np.array([4, 9])) == pytest.approx(colours[[3, 8]])


def test_a_car_that_is_called_by_a_colour_has_it_and_no_other_has():
    names = ("car 1", "blue", "Purple one", "Bluebell", "red", "blue 2")
    colours = {name: palette.css(one) for name, one in palette.car_colours(names).items()}
    assert colours["blue"] == palette.css(palette.OWN["blue"])
    assert colours["Purple one"] == palette.css(palette.OWN["plum"])
    assert colours["red"] == palette.css(palette.OWN["red"])
    assert len(set(colours.values())) == len(names)
    many = palette.car_colours([f"car {k}" for k in range(20)])
    assert len({palette.css(one) for one in many.values()}) == 12


def test_in_a_simulation_the_key_names_each_car_but_those_that_wear_another_colour():
    hunts = known(predator=np.array([False, True, False]))
    one, look = frame(cars=hunts), DrawingStyle(colour=OWN)
    made = shown(one, look).colour
    assert made[[0, 2]] == pytest.approx(palette.identity_colours(np.array([1, 3])))
    assert made[1] == pytest.approx(palette.LEADER)
    assert legend(look, one) == [
        ("car 1", palette.css(made[0])),
        ("car 3", palette.css(made[2])),
        ("injected car", palette.css(palette.GOAL)),
        ("predator", palette.css(palette.LEADER)),
    ]
