"""`flockscope picture`: a picture of the size asked for, of the flock that the run has then."""

import json
import shutil
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from PIL import Image

from agents import Flock
from agents.kinds import Kind, chase
from agents.spec import Spec
from app.viewer.pictures.key import caption, changes, nice, ruler
from app.viewer.pictures.picture_camera import CameraRequest
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.plane import DART, place_shapes
from app.viewer.pictures.shot import look_of, shot
from app.viewer.pictures.space_picture import CameraAxes, split
from app.viewer.scene.cameras.camera import view
from app.viewer.scene.shown import palette
from cli.calling import call, refusal
from worlds.input_error import InputError

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def flock():
    made = Flock("hwvem", agents=30, rng=2)
    made.run(4)
    return made


def test_a_png_has_the_pixels_asked_for(tmp_path):
    out = tmp_path / "flock.png"
    result = call("picture", "hwvem", "--agents", 30, "--seed", 2, "--tick", 4, "--out", out,
                  "--pixels", "901x643", "--json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout) == {
        "picture": str(out), "model": "hwvem", "tick": 4, "time": 4.0, "renderer": "plain",
    }  # fmt: skip
    with Image.open(out) as image:
        assert image.size == (901, 643)
        colours = {colour[:3] for _, colour in image.convert("RGB").getcolors(10**6)}
    assert tuple(np.rint(255 * palette.LEADER).astype(int)) in colours
    assert "exists already" in refusal("picture", "hwvem", "--out", out)


@pytest.mark.parametrize("dim", [2, 3])
def test_an_svg_parses_and_a_pdf_is_one(tmp_path, dim):
    flock = Flock("vem", agents=10, dim=dim, rng=1)
    flock.save(tmp_path / "state.parquet")
    for ending in ("svg", "pdf"):
        result = call("picture", tmp_path / "state.parquet", "--out", tmp_path / f"a.{ending}")
        assert result.exit_code == 0, result.stderr
    assert (tmp_path / "a.pdf").read_bytes()[:5] == b"%PDF-"
    drawn = ElementTree.parse(tmp_path / "a.svg").getroot()
    assert drawn.tag == f"{SVG}svg"
    assert len(list(drawn.iter(f"{SVG}path"))) > 10


def test_darts_are_where_the_agents_are_and_point_where_they_head(flock):
    now = flock.snapshot(signals=True)
    one = shot(now, look_of(now, None))
    sheet = Sheet(one, (640, 480))
    verts = [path.vertices[:4] for path in sheet.scene.bodies.get_paths()]
    order = np.argsort(one.made.size, kind="stable")
    assert len(verts) == 31
    for corners, row in zip(verts, order, strict=True):
        nose = corners[0] - now.position[row]
        assert np.allclose(nose / np.linalg.norm(nose), now.heading[row])
    assert order[-1] == np.flatnonzero(now.informed)[0]
    assert np.allclose(sheet.scene.bodies.get_facecolor()[:, :3], one.made.colour[order])


def test_a_shape_is_turned_and_stretched():
    made = place_shapes(DART, np.array([[1.0, 2.0]]), np.array([[0.0, 1.0]]), np.array([2.0]))
    assert np.allclose(made[0, 0], [1.0, 3.2])
    assert np.allclose(made[0, 1], [1.0 - 0.72, 2.0 - 0.8])


def test_the_words_say_which_run_it_is(flock):
    now = flock.snapshot(signals=True)
    one = shot(now, look_of(now, "heading"))
    side = f"{flock.world.size[0]:.4g}"
    assert caption(one) == (
        f"hwvem in wrap, {side} × {side} · 30 agents and 1 information agent · seed 2"
    )
    assert ruler(one, 0.83) == (0.5, "0.5 lengths")
    assert [nice(length) for length in (0.099, 0.1, 19.9, 3000.0)] == [0.05, 0.1, 10.0, 2000.0]
    metres = Flock("olfati-saber", agents=4, rng=1).snapshot(signals=True)
    assert ruler(shot(metres, look_of(metres, None)), 12.0) == (10.0, "10 m")


def test_the_scale_bar_is_as_long_as_it_says(flock):
    now = flock.snapshot(signals=True)
    sheet = Sheet(shot(now, look_of(now, None)), (800, 500))
    lines = [one for one in sheet.figure.artists if hasattr(one, "get_ydata")]
    bar = next(one for one in lines if np.ptp(one.get_ydata()) == 0.0)
    (low, _), (high, _) = sheet.scene.axes.transData.transform([(0.0, 0.0), (1.0, 0.0)])
    pixels = np.ptp(bar.get_xdata()) * sheet.figure.bbox.width
    words = {text.get_text() for text in sheet.figure.texts}
    assert f"{pixels / (high - low):g} length" in {word.removesuffix("s") for word in words}


def test_a_camera_sees_what_is_nearer_larger():
    half = np.ones(3)
    eye = CameraAxes.of(view("perspective", 3, -half, half, 1.0))
    seen, away = eye.seen(eye.view.target + np.array([[0.0, 0, 0], *(0.5 * np.eye(3))]))
    assert np.allclose(seen[0], 0.0)
    assert away[0] == pytest.approx(np.linalg.norm(eye.view.position - eye.view.target))
    assert seen[3, 1] > 0.0
    assert abs(seen[3, 0]) < 1e-9


def test_faces_are_split_and_cover_the_same_area():
    whole = np.array([[[0.0, 0, 0], [4, 0, 0], [0, 3, 0]]])
    parts = split(whole, 1.0)
    area = np.linalg.norm(np.cross(parts[:, 1] - parts[:, 0], parts[:, 2] - parts[:, 0]), axis=1)
    assert 0.5 * area.sum() == pytest.approx(6.0)
    assert np.linalg.norm(parts - np.roll(parts, 1, axis=1), axis=2).max() <= 1.0


def test_bad_input_is_one_line(tmp_path, flock):
    out = ("--out", tmp_path / "a.png")
    assert "ends in .png or .svg or .pdf" in refusal("picture", "vem", "--out", tmp_path / "a.gif")
    assert "is not a size: WIDTHxHEIGHT" in refusal("picture", "vem", *out, "--pixels", "800")
    assert "10 is outside [320, 8000]" in refusal("picture", "vem", *out, "--pixels", "800x10")
    assert "unknown model 'vm'" in refusal("picture", "vm", *out)
    assert "--tick -1 is not allowed" in refusal("picture", "vem", *out, "--tick", -1)
    assert "which MODEL?" in refusal("picture", *out)
    assert "there is no such file" in refusal("picture", "no.toml", *out)
    assert "unknown colour 'laver': did you mean 'layer'" in refusal(
        "picture", "hwvem", "--agents", 30, "--tick", 0, "--colour", "laver", *out
    )
    flock.save(tmp_path / "state.parquet")
    assert "--agents 5 is not allowed" in refusal(
        "picture", tmp_path / "state.parquet", "--agents", 5, *out
    )
    assert "tick = 9 is not in" in refusal("picture", tmp_path / "state.parquet", "--tick", 9, *out)
    assert not (tmp_path / "a.png").exists()
    now = flock.snapshot(signals=True)
    with pytest.raises(InputError, match="agent 99 is not there at tick 4"):
        CameraRequest(follow=99).camera(shot(now, look_of(now, None)))


def test_who_draws_is_said(tmp_path, monkeypatch):
    """A browser that cannot run makes no picture; where it is not demanded, we draw ourselves."""
    program = shutil.which("false")
    monkeypatch.setenv("FLOCKSCOPE_CHROMIUM", program)
    small = ("vem", "--dim", 3, "--agents", 9, "--tick", 0, "--pixels", "400x320", "--out")
    result = call("picture", *small, tmp_path / "a.png", "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["renderer"] == "plain"
    line = f"flockscope: the browser {program!r} ends at once: it cannot run here: drawn by the"
    assert line in result.stderr
    asked = ("picture", *small, tmp_path / "b.png", "--renderer", "browser")
    assert f"the browser {program!r} ends at once" in refusal(*asked, "--quiet")
    monkeypatch.setenv("FLOCKSCOPE_CHROMIUM", str(tmp_path / "nothing"))
    assert "nothing' is no program" in refusal(*asked, "--quiet")
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_what_cannot_be_drawn_so_is_refused(tmp_path):
    out = ("hwvem", "--agents", 9, "--tick", 0, "--quiet", "--out", tmp_path / "a.svg")
    assert "a browser draws no .svg" in refusal("picture", *out, "--renderer", "browser")
    assert "unknown renderer 'fast'" in refusal("picture", *out, "--renderer", "fast")
    assert "unknown camera 'behind'" in refusal("picture", *out, "--camera", "behind")
    assert "a picture stands still" in refusal("picture", *out, "--camera", "round")
    assert "--follow 3 is not allowed with --camera side" in refusal(
        "picture", *out, "--camera", "side", "--follow", 3
    )
    assert "the plain one looks straight down" in refusal("picture", *out, "--camera", "side")
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_as_in_the_paper_is_said(flock):
    now = flock.snapshot(signals=True)
    assert changes(shot(now, look_of(now, None))) == ""
    flock = Flock("vem", agents=9, rng=1, eta=0.25)
    assert (
        changes(shot(flock.snapshot(signals=True), look_of(flock.snapshot(), None)))
        == "eta = 0.25 rad"
    )


def test_a_picture_has_the_colours_and_the_names_of_kinds():
    kinds = [Kind("shark", 2, colour="#b03a2e", to={"flock": chase(1.0, 1.0, catch=0.3)})]
    flock = Flock(Spec("vem", agents=30, seed=2, size=5.0, kinds=kinds))
    now = flock.snapshot(signals=True)
    one = shot(now, look_of(now, None))
    assert [words for words, _ in one.entries] == ["flock", "shark"]
    rows = flock.rows_of("shark")
    assert [palette.css(colour) for colour in one.made.colour[rows]] == ["#b03a2e"] * 2
    assert "30 agents, 2 of kind shark · seed 2" in caption(one)
    assert Sheet(one, (640, 480), CameraRequest().camera(one)).as_bytes(".png")
