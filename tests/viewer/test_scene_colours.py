"""Colours of the scene and what they are said to mean."""

import re
from itertools import combinations, pairwise

import numpy as np
import pytest

from agents.catalogue import MODELS
from agents.kinds import Kind, kind_table
from app.viewer.panels.monitors import Monitors, climb_gradient, level_gradient, wheel
from app.viewer.pictures.browser import darkened
from app.viewer.scene.draw.drawn_frame import picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import COLOURINGS, KIND, MEASURED
from app.viewer.scene.shown.drawing_style import (
    DrawingStyle,
    agent_colours,
    default_style,
    has_needed,
    legend,
)
from app.viewer.scene.shown.frame import Frame, Inspection
from app.viewer.scene.shown.palette import linear_to_srgb, oklch, srgb_to_linear
from worlds.world import World


def flock(count: int = 60, dim: int = 2, **changes) -> Frame:
    rng = np.random.default_rng(count)
    heading = rng.standard_normal((count, dim))
    informed = np.zeros(count, dtype=bool)
    informed[:1] = True
    known = {
        "run": 1,
        "tick": 0,
        "world": World("wrap", (10.0,) * dim, ("wrap",) * dim),
        "reach": 1.0,
        "speed_scale": 0.1,
        "position": rng.random((count, dim)) * 10.0,
        "heading": heading / np.linalg.norm(heading, axis=1)[:, None],
        "speed": rng.random(count) * 0.1,
        "informed": informed,
        "ids": np.arange(count),
        "layer": np.r_[1, rng.integers(2, 6, count - 1)],
        "group": rng.integers(0, 4, count),
    }
    return Frame(**(known | changes))


@pytest.mark.parametrize("colour", COLOURINGS)
@pytest.mark.parametrize("dim", [2, 3])
def test_every_colouring_gives_colours_in_range_and_marks_the_leader(colour, dim):
    frame = flock(dim=dim)
    colours = agent_colours(frame, DrawingStyle(colour=colour))
    assert colours.shape == (60, 3)
    assert np.all((colours >= 0.0) & (colours <= 1.0))
    assert colours[0] == pytest.approx(palette.LEADER)
    entries = legend(DrawingStyle(colour=colour), frame)
    assert entries
    assert all(words and len(shade) == 7 and shade[0] == "#" for words, shade in entries)
    assert palette.css(palette.LEADER) in [shade for _, shade in entries]


def test_who_leads_is_red_by_day_and_by_night():
    def hue(colour):
        lab = np.linalg.inv(palette._RGB_FROM_LMS) @ srgb_to_linear(colour)
        _, a, b = np.linalg.inv(palette._LMS_FROM_LAB) @ np.cbrt(lab)
        return np.degrees(np.arctan2(b, a))

    drawn = np.rint(255.0 * palette.LEADER).astype(np.uint8)[None, None]
    for colour in (palette.LEADER, darkened(drawn)[0, 0] / 255.0):
        assert 20.0 < hue(colour) < 35.0, "pink is below 15, orange above 45"


def test_an_unknown_colouring_is_an_error():
    with pytest.raises(ValueError, match="colour = 'mood'"):
        DrawingStyle(colour="mood")


@pytest.mark.parametrize("colours", [palette.LAYERS, palette.GROUPS], ids=["layers", "groups"])
def test_named_colours_can_be_told_apart(colours):
    for one, other in combinations([*colours, palette.UNKNOWN][: len(colours)], 2):
        assert np.linalg.norm(one - other) > 0.15


def oklab(srgb: np.ndarray) -> np.ndarray:
    """sRGB -> OKLab with Ottosson's forward matrices (the code under test has the inverse ones)."""
    to_lms = np.array(
        [
            [0.4122214708, 0.5363325363, 0.0514459929],
            [0.2119034982, 0.6806995451, 0.1073969566],
            [0.0883024619, 0.2817188376, 0.6299787005],
        ]
    )
    to_lab = np.array(
        [
            [0.2104542553, 0.7936177850, -0.0040720468],
            [1.9779984951, -2.4285922050, 0.4505937099],
            [0.0259040371, 0.7827717662, -0.8086757660],
        ]
    )
    return np.cbrt(srgb_to_linear(srgb) @ to_lms.T) @ to_lab.T


def test_heading_colours_go_round_in_even_steps():
    angle = np.deg2rad(np.arange(361))
    wheel = palette.heading_colours(np.column_stack([np.cos(angle), np.sin(angle)]))
    assert wheel[0] == pytest.approx(wheel[-1])
    step = np.linalg.norm(np.diff(oklab(wheel), axis=0), axis=1)
    assert step.max() < 2.0 * step.min()
    quarters = wheel[[0, 90, 180, 270]]
    assert min(np.linalg.norm(a - b) for a, b in combinations(quarters, 2)) > 0.3


def test_climbing_is_lighter_than_level_and_diving_is_darker():
    elevation = np.deg2rad([-80.0, -40.0, 0.0, 40.0, 80.0])
    heading = np.column_stack([np.cos(elevation), np.zeros(5), np.sin(elevation)])
    light = srgb_to_linear(palette.heading_colours(heading)) @ np.array([0.2126, 0.7152, 0.0722])
    assert all(darker < lighter for darker, lighter in pairwise(light))


def test_speed_saturates_at_its_scale_and_stands_a_scale_of_zero():
    colours = palette.speed_colours(np.array([0.0, 1.0, 5.0]), 1.0)
    assert colours[1] == pytest.approx(colours[2])
    assert np.linalg.norm(colours[0] - colours[1]) > 0.4
    assert palette.speed_colours(np.array([0.0, 1.0]), 0.0)[1] == pytest.approx(palette.SPEEDS[0])


def test_layers_beyond_the_flock_are_unknown():
    layer = np.array([1, 2, 3, 5])
    assert palette.layer_colours(layer)[3] == pytest.approx(palette.UNKNOWN)
    assert palette.layer_colours(layer)[1] == pytest.approx(palette.LAYERS[1])


def test_labels_that_are_not_there_yet_are_grey():
    colours = agent_colours(flock(layer=None), DrawingStyle(colour="layer"))
    assert colours[1:] == pytest.approx(np.tile(palette.UNKNOWN, (59, 1)))


def test_layer_legend_names_the_layers_that_occur():
    words = [
        entry[0] for entry in legend(DrawingStyle(colour="layer"), flock(5, layer=np.arange(1, 6)))
    ]
    assert words == [
        "layer 1: information agent",
        "layer 2",
        "layer 3",
        "layer 4",
        "layer 5",
        "unknown",
    ]


def test_oklch_has_known_white_black_and_red():
    assert oklch(1.0, 0.0, 0.0) == pytest.approx([1, 1, 1], abs=1e-3)
    assert oklch(0.0, 0.0, 0.0) == pytest.approx([0, 0, 0], abs=1e-3)
    red = oklch(0.6279554, 0.2576833, np.deg2rad(29.2338851))
    assert red == pytest.approx([1, 0, 0], abs=2e-3)


def test_srgb_encoding_is_undone_by_decoding():
    light = np.linspace(0.0, 1.0, 101)
    assert srgb_to_linear(linear_to_srgb(light)) == pytest.approx(light, abs=1e-9)


def aces(linear: np.ndarray) -> np.ndarray:
    """three.js ACESFilmicToneMapping, transcribed from its shader."""
    v = (linear / 0.6) @ np.array(
        [[0.59719, 0.07600, 0.02840], [0.35458, 0.90834, 0.13383], [0.04823, 0.01566, 0.83777]]
    )
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    return v @ np.array(
        [
            [1.60475, -0.10208, -0.00327],
            [-0.53108, 1.10813, -0.07276],
            [-0.07367, -0.00605, 1.07602],
        ]
    )


def test_unlit_colours_come_back_through_the_browsers_tone_curve():
    meant = np.array([palette.EDGE, palette.LINK, [0.5, 0.5, 0.5], [0.3, 0.45, 0.6]])
    seen = linear_to_srgb(np.clip(aces(palette.unlit_bytes(meant) / 255.0), 0.0, 1.0))
    assert seen == pytest.approx(meant, abs=0.02)


def test_an_inspection_dims_all_but_the_agent_its_neighbours_and_the_leader():
    inspected = Inspection(5, 5, np.array([7, 9]), np.zeros((2, 2)), np.array([1.0, 0.5]), {})
    frame = flock()
    plain = picture(frame, DrawingStyle(), Stage.of(frame))
    shown = picture(flock(inspected=inspected), DrawingStyle(), Stage.of(frame))
    kept = np.isin(np.arange(60), [0, 5, 7, 9])
    assert shown.colour[kept] == pytest.approx(plain.colour[kept])
    faded = np.linalg.norm(shown.backdrop - shown.colour[~kept], axis=1)
    full = np.linalg.norm(plain.backdrop - plain.colour[~kept], axis=1)
    assert np.all(faded < 0.5 * full)
    assert shown.size[5] > shown.size[7] > shown.size[9] > shown.size[11] == 1.0


def test_any_number_of_the_agents_is_coloured_from_its_least_to_its_largest():
    values = np.linspace(-2.0, 3.0, 60)
    values[7] = np.nan
    frame, look = flock(measured=values), DrawingStyle(colour=MEASURED, measured="angle")
    colours = agent_colours(frame, look)
    assert colours[7] == pytest.approx(palette.UNKNOWN)
    assert colours[1] == pytest.approx(palette.SPEEDS[4], abs=0.01)
    assert colours[-1] == pytest.approx(palette.SPEEDS[-1])
    words = [word for word, _ in legend(look, frame)]
    assert words[:3] == ["-2", "0.5", "3"]
    assert words[-2:] == ["unknown", "information agent"]


def test_a_number_that_a_model_does_not_have_or_that_is_the_same_for_all_has_a_colour_too():
    look = DrawingStyle(colour=MEASURED, measured="angle")
    assert agent_colours(flock(), look)[1] == pytest.approx(palette.UNKNOWN)
    assert legend(look, flock())[0][0] == "no angle in this model"
    same = flock(measured=np.full(60, 4.0))
    assert agent_colours(same, look)[1] == pytest.approx(palette.SPEEDS[0])
    assert legend(look, same)[0][0] == "4"


def stops(gradient: str) -> list[np.ndarray]:
    """The colours of a CSS gradient, which stand at even distances."""
    return [palette.srgb(one) for one in re.findall(r"#[0-9a-f]{6}", gradient)]


def test_the_wheel_shows_every_heading_where_it_points_as_seen_from_above():
    colours = stops(level_gradient())
    assert level_gradient().startswith(
        "conic-gradient(from 90deg,#"
    )  # from the right, with the clock
    turned = np.linspace(0.0, 2.0 * np.pi, len(colours))
    for dim in (2, 3):
        for k in range(720):
            clockwise = 2.0 * np.pi * k / 720
            shade = [np.interp(clockwise, turned, [one[i] for one in colours]) for i in range(3)]
            heading = np.zeros((1, dim))
            heading[0, :2] = np.cos(-clockwise), np.sin(-clockwise)
            assert shade == pytest.approx(palette.heading_colours(heading)[0], abs=0.02)


def test_the_wheel_names_degrees_and_axes_and_in_space_what_climbs():
    assert re.findall(r"<span>(.*?)</span>", wheel(2)) == ["0° +x", "90° +y", "180°", "270°"]
    assert "climbing" not in wheel(2)
    assert re.findall(r"<span>(.*?)</span>", wheel(3))[4:] == ["climbing", "level", "diving"]
    down, *_, up = stops(climb_gradient())
    assert down == pytest.approx(
        palette.heading_colours(np.array([[0.0, 0.0, -1.0]]))[0], abs=1 / 255
    )
    assert up == pytest.approx(palette.heading_colours(np.array([[0.0, 0.0, 1.0]]))[0], abs=1 / 255)


def test_headings_have_a_wheel_in_the_monitors_and_nothing_else_has(monkeypatch):
    told: dict[str, str] = {}
    monkeypatch.setattr(Monitors, "__init__", lambda _: None)
    monkeypatch.setattr(Monitors, "show", lambda _, contents: told.update(contents))
    for colour in COLOURINGS:
        Monitors().colours(DrawingStyle(colour=colour), flock(dim=3))
        assert ("fs-wheel" in told["key"]) == (colour == "heading")
        assert f"Colour: {colour}" in told["key"]


def kinds_frame(**changes) -> Frame:
    """A flock with an information agent, two sharks, three whales and one who is caught."""
    kind = np.zeros(60, int)
    kind[[4, 5]], kind[[7, 8, 9]], kind[12] = 1, 2, -1
    kinds = kind_table((Kind("shark", 2, colour="#b03a2e"), Kind("whale", 3)), {})
    return flock(kind=kind, kinds=kinds, **changes)


def test_each_kind_has_its_own_colour_with_its_name_and_who_is_caught_is_pale():
    frame = kinds_frame()
    look = DrawingStyle(colour=KIND)
    colours = agent_colours(frame, look)
    entries = dict(legend(look, frame))
    assert list(entries) == ["flock", "shark", "whale", "information agent", "caught"]
    assert entries["shark"] == "#b03a2e"
    assert len(set(entries.values())) == 5
    for row, name in ((1, "flock"), (4, "shark"), (7, "whale"), (12, "caught")):
        assert palette.css(colours[row]) == entries[name]
    by_heading = agent_colours(frame, DrawingStyle())
    assert by_heading[12] == pytest.approx(palette.CAUGHT)
    assert ("caught", palette.css(palette.CAUGHT)) in legend(DrawingStyle(), frame)


def test_colouring_by_kind_is_usual_where_there_are_kinds_and_offered_nowhere_else():
    model = MODELS["vem"]
    assert default_style(model, 60, 1.0, has_kinds=True).look.colour == KIND
    assert default_style(model, 60, 1.0).look.colour == "heading"
    assert has_needed(KIND, kinds_frame())
    assert not has_needed(KIND, flock())


def test_kinds_are_told_apart_by_all_and_stand_out_from_both_grounds():
    """The first eight of `OWN` can be told apart without seeing red or green."""
    kinds = kind_table(tuple(Kind(f"k{n}", 1) for n in range(7)), {})
    assert np.array_equal(palette.kind_colours(kinds), palette.COLOURS[:8])
    taken = kind_table((Kind("a", 1, colour=palette.css(palette.COLOURS[0])), Kind("b", 1)), {})
    assert len(np.unique(palette.kind_colours(taken), axis=0)) == 3
