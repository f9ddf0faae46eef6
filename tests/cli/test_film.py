"""`flockscope film`: as many pictures as it says, of the right ticks; whole or not at all."""

import base64
import json
import os
import re
import shutil
import signal
import tempfile
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

import msgspec
import numpy as np
import psutil
import pytest
import zstandard
from imageio_ffmpeg import count_frames_and_secs, read_frames

from agents import Flock
from agents.recordings.recorder import Recorder
from app.cli.take.film import plan_film
from app.cli.take.renderer import camera_request
from app.viewer.pictures.browser import GUARD, find_browser
from app.viewer.pictures.film_writer import Encoder, pictures
from app.viewer.pictures.picture_camera import Camera, CameraRequest
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.plane import Plots
from app.viewer.pictures.player import HOLDS
from app.viewer.pictures.shot import look_of, shot
from app.viewer.pictures.space_picture import CameraAxes
from cli.calling import call, refusal, start, wait_until
from worlds.input_error import InputError

SMALL = ("--pixels", "400x320", "--renderer", "plain")
RUN = ("hwvem", "--agents", 20, "--seed", 2)


def snapshots(ticks, name="hwvem", **words):
    """A flock at ticks."""
    flock = Flock(name, agents=20, rng=2, **words)
    for tick in ticks:
        flock.run(tick - flock.tick)
        yield flock.snapshot(signals=True)


@pytest.mark.parametrize("ending", ["mp4", "webm", "gif"])
def test_a_film_has_the_pictures_it_says(tmp_path, ending):
    out = tmp_path / f"flock.{ending}"
    result = call("film", *RUN, "--from", 4, "--to", 20, "--every", 4, "--speed", 40, "--out", out,
                  *SMALL, "--json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    assert made["pictures"] == 5
    assert (made["first_tick"], made["last_tick"], made["fps"]) == (4, 20, 10.0)
    assert count_frames_and_secs(str(out))[0] == 5
    assert next(read_frames(str(out)))["size"] == (400, 320)
    assert "exists already" in refusal("film", *RUN, "--out", out)


def test_a_film_of_a_recording_shows_recorded_ticks(tmp_path):
    flock = Flock("hwvem", agents=20, rng=2)
    with Recorder(tmp_path / "run.parquet", flock) as recorder:
        for tick in range(0, 41, 5):
            flock.run(tick - flock.tick)
            recorder.write()
    result = call("film", tmp_path / "run.parquet", "--from", 10, "--out", tmp_path / "a.mp4",
                  "--speed", 50, *SMALL, "--plot", "polarisation,groups", "--json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    assert (made["pictures"], made["fps"], made["last_tick"]) == (7, 10.0, 40)
    assert count_frames_and_secs(str(tmp_path / "a.mp4"))[0] == 7


def test_ticks_that_are_left_out_at_the_end_are_said(tmp_path):
    for ending in ("mp4", "html"):
        out = tmp_path / f"a.{ending}"
        result = call("film", *RUN, "--to", 10, "--every", 4, "--out", out)
        assert result.exit_code == 0, result.stderr
        assert "the film ends at tick 8: 2 ticks more make no picture\n" in result.stderr


def test_which_ticks_are_shown():
    ticks = list(range(301))
    assert plan_film(ticks, 0, 300, None, 30.0, 30.0).ticks == ticks
    plan = plan_film(ticks, 0, 300, None, 300.0, 30.0)
    assert (plan.ticks, plan.fps) == (list(range(0, 301, 10)), 30.0)
    plan = plan_film(ticks, 50, 100, 25, 50.0, 30.0)
    assert (plan.ticks, plan.fps, plan.left_out) == ([50, 75, 100], 2.0, 0)
    assert plan_film(ticks, 50, 110, 25, 50.0, 30.0).left_out == 10
    assert plan_film([0, 20, 40], 0, 40, None, 60.0, 30.0).fps == 3.0
    with pytest.raises(InputError, match="no tick from 41 to 50"):
        plan_film([0, 20, 40], 41, 50, None, 60.0, 30.0)


@pytest.mark.parametrize(("dim", "follow"), [(2, None), (2, 5), (3, None), (3, 5)])
def test_a_picture_of_a_film_is_the_picture_of_its_tick(dim, follow):
    """What does not move is drawn once; nothing of the pictures before is left on the next."""
    *_, last = pictures(
        snapshots((0, 3, 9), dim=dim), (400, 320), "heading", CameraRequest(follow=follow)
    )
    (now,) = snapshots((9,), dim=dim)
    one = shot(now, look_of(now, "heading"))
    alone = Sheet(one, (400, 320), Camera.of(one, follow)).pixels()
    assert last.shape == (320, 400, 3)
    assert np.array_equal(last, alone)


def test_a_followed_agent_is_in_the_middle():
    (now,) = snapshots((4,))
    one = shot(now, look_of(now, None))
    sheet = Sheet(one, (400, 320), Camera.of(one, 7))
    axes = sheet.scene.axes
    place = now.position[now.ids == 7][0]
    assert np.allclose([np.mean(axes.get_xlim()), np.mean(axes.get_ylim())], place)
    assert np.allclose(np.ravel(sheet.scene.ring.get_data()), place)


def test_plots_are_what_is_observed():
    plots = Plots(["polarisation", "mean-neighbours"], 0.0, 9.0)
    list(pictures(snapshots((0, 3, 9)), (400, 320), plots=plots))
    assert plots.times == [0.0, 3.0, 9.0]
    flock = Flock("hwvem", agents=20, rng=2)
    flock.run(9)
    assert plots.values["mean-neighbours"][-1] == flock.observe("mean-neighbours")
    assert plots.lines[0].get_ydata()[-1] == flock.observe("polarisation")
    assert plots.lines[0].axes.get_xlim() == (0.0, 9.0)


def test_what_goes_wrong_leaves_nothing(tmp_path):
    out = tmp_path / "half.mp4"
    with suppress(ZeroDivisionError), Encoder(out, (320, 320), 10.0) as encoder:
        encoder.add(np.zeros((320, 320, 3), np.uint8))
        _ = 1 / 0
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_leaves_no_half_film_and_the_old_one(tmp_path):
    out = tmp_path / "flock.mp4"
    out.write_text("mine")
    process = start("film", *RUN, "--to", 10**6, "--out", out, "--overwrite", *SMALL,
                    env=environment(tmp_path))  # fmt: skip
    wait_until(lambda: list(tmp_path.glob("flockscope-film-*/film.mp4")), process)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert (process.returncode, stdout) == (130, "")
    assert stderr.splitlines()[-1] == "flockscope: stopped; no film was written"
    assert [path.name for path in tmp_path.iterdir()] == ["flock.mp4"]
    assert out.read_text() == "mine"


def environment(folder):
    """That of this process, with a folder for what is in the making."""
    return {**os.environ, "TMPDIR": str(folder)}


@pytest.mark.skipif(os.name != "posix", reason="nothing is killed so here")
@pytest.mark.parametrize("renderer", ["plain", "browser"])
def test_a_film_that_is_killed_leaves_no_process_and_no_folder(tmp_path, renderer):
    if renderer == "browser" and find_browser() is None:
        pytest.skip("there is no browser")
    place = Path(tempfile.mkdtemp(prefix="film", dir="/tmp"))  # short enough for a browser's socket
    wanted = {"plain": {"film"}, "browser": {"film", "browser"}}[renderer]

    def folders():
        return {one.name.split("-")[1] for one in place.glob("flockscope-*-*")}

    def begun():
        return [
            one for one in psutil.process_iter(["cmdline"])
            if one.pid != os.getpid() and str(place) in " ".join(one.info["cmdline"] or [])
        ]  # fmt: skip

    def guards():
        return [one for one in begun() if GUARD in one.info["cmdline"]]

    process = start(
        "film", *RUN, "--to", 100_000, "--pixels", "400x320", "--renderer", renderer,
        "--out", tmp_path / "a.mp4", env=os.environ | {"TMPDIR": str(place)},
    )  # fmt: skip
    try:
        wait_until(lambda: folders() >= wanted and len(guards()) == len(wanted), process)
        wait_until(lambda: len(begun()) >= 2 * len(wanted), process)
        process.kill()
        process.communicate()
        end = time.monotonic() + 60.0
        while begun() or folders():
            assert time.monotonic() < end, (begun(), folders())
            time.sleep(0.1)
    finally:
        shutil.rmtree(place, ignore_errors=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="no limit of a file's size here")
def test_a_limit_of_a_files_size_is_named(tmp_path):
    process = start(
        "film", *RUN, "--to", 100, *SMALL, "--out", tmp_path / "a.mp4",
        preexec_fn=partial(limit_files, 20_000),
    )  # fmt: skip
    _, said = process.communicate(timeout=120)
    assert process.returncode == 2, said
    assert "it is larger than the limit of this session for a file (`ulimit -f`)" in said
    assert list(tmp_path.iterdir()) == []


def limit_files(size):
    """In a process that begins: no file of more bytes."""
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def test_bad_input_is_one_line(tmp_path):
    out = ("--out", tmp_path / "a.mp4", *SMALL)
    assert "ends in .mp4 or .webm or .gif or .html" in refusal(
        "film", *RUN, "--out", tmp_path / "a.avi"
    )
    assert "--fps 500 is outside [0.1, 120]" in refusal("film", *RUN, *out, "--fps", 500)
    assert "--speed 0 is outside" in refusal("film", *RUN, *out, "--speed", 0)
    assert "--to 3 is not allowed" in refusal("film", *RUN, *out, "--from", 5, "--to", 3)
    short = (*RUN, *out, "--to", 1, "--quiet")
    assert "unknown observable 'polarization'" in refusal("film", *short, "--plot", "polarization")
    assert "--plot layers is not one number" in refusal("film", *short, "--plot", "layers")
    assert "agent 99 is not there at tick 0" in refusal("film", *short, "--follow", 99)
    assert "--turn 20 is not allowed" in refusal("film", *short, "--turn", 20)
    assert "--turn 0 is outside" in refusal("film", *short, "--camera", "round", "--turn", 0)
    assert "takes --renderer browser" in refusal("film", *short, "--camera", "round")
    page = (*RUN, "--to", 1, "--quiet", "--out", tmp_path / "a.html")
    assert "it holds the scene alone" in refusal("film", *page, "--plot", "polarisation")
    assert "who watches it moves the camera" in refusal("film", *page, "--follow", 1)
    assert list(tmp_path.iterdir()) == []


def test_a_camera_goes_round():
    """Once in the film, or as many degrees a second as asked for; its agents stay in sight."""
    first, last = snapshots((0, 20), dim=3)
    begin, end = (shot(now, look_of(now, None)) for now in (first, last))
    camera = camera_request("round", None, None, 1.0, 40).camera(begin)
    at, half_way = (camera.view(one, 1.2).position for one in (begin, end))
    assert np.allclose(half_way, at * [-1.0, -1.0, 1.0])
    quarter = camera_request("round", None, -45.0, 10.0, 20).camera(begin).view(end, 1.2).position
    assert np.allclose(quarter, [at[1], -at[0], at[2]])
    assert not camera.follow
    seen, _ = CameraAxes.of(camera.view(end, 1.2)).seen(end.made.at)
    assert (abs(seen) < [1.2, 1.0]).all()


def test_a_page_plays_a_run_and_asks_nobody(tmp_path):
    """200 agents over 1 000 ticks take less than 5 MB, each tick of them."""
    out = tmp_path / "run.html"
    result = call("film", "vicsek1995", "--agents", 200, "--seed", 1, "--to", 1000, "--out", out,
                  "--json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    assert (made["pictures"], made["renderer"]) == (1001, "html")
    assert made["bytes"] == out.stat().st_size < 5e6
    text = out.read_text()
    assert "<title>Vicsek" in text
    assert "seed 1 · ticks 0 to 1000, 30 a second" in text
    assert "connect-src data: blob:;" in text
    recorded = played(text)
    assert recorded["durationSeconds"] == pytest.approx(1000 / 30 + HOLDS)
    moved = [
        at for at, one in recorded["messages"] if "batched_positions" in one.get("updates", ())
    ]
    assert len(set(moved)) == 1001


def played(page):
    """What a page of viser's plays."""
    data = base64.b64decode(re.search(r'__VISER_EMBED_DATA__="([^"]+)"', page)[1])
    inner = zstandard.ZstdDecompressor().decompress(data[8:], int.from_bytes(data[:8], "little"))
    return msgspec.msgpack.decode(inner[8 : 8 + int.from_bytes(inner[:8], "little")])


def test_a_large_page_is_thinned_or_refused(tmp_path):
    out = tmp_path / "run.html"
    run = ("vem", "--agents", 900, "--seed", 1, "--to", 599, "--out", out)
    result = call("film", *run, "--json")
    assert result.exit_code == 0, result.stderr
    assert "one of 3 pictures is taken" in result.stderr
    assert json.loads(result.stdout)["pictures"] == 200
    many = refusal("film", *run[:-3], 2999, "--every", 1, "--out", tmp_path / "b.html", "--quiet")
    assert "3000 pictures of 900 agents are too many" in many
    assert "by --every 2," in many
