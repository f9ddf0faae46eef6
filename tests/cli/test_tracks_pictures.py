"""Pictures, films and pages of tracks, and the laboratory that opens on them, by command."""

from __future__ import annotations

import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from app.tracks.playing.played_tracks import PlayedTracks
from app.viewer.pictures import key
from app.viewer.pictures.plane import Plane
from app.viewer.pictures.shot import look_of, shot
from cli.calling import call, refusal
from tests.browser.test_tracks import written
from tests.tracks.playing.ring_tracks import COUNT, FRAMES, GAP, RATE, ring_tracks

HOW = ("--rate", RATE, "--unit", "m", "--origin", "bottom-left")


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """The ring as a plain table that says neither rate nor unit."""
    return written(tmp_path_factory.mktemp("tracks") / "ring.csv", with_time=False)


def test_a_picture_of_tracks_says_its_file_and_its_time(table, tmp_path):
    out = tmp_path / "ring.svg"
    result = call("picture", "--tracks", table, *HOW, "--tick", 50, "--out", out, "--json")
    assert result.exit_code == 0, result.stderr
    said = json.loads(result.stdout)
    assert (said["model"], said["tick"], said["time"]) == ("tracks", 50, 2.0)
    assert out.read_text("utf-8").startswith("<?xml")


def test_those_in_a_gap_are_drawn_in_outline_and_others_not_seen_are_not():
    played = PlayedTracks(ring_tracks())
    made = shot(played.at(GAP.start + 2), look_of(played.at(0), None))
    assert key.title(made) == "ring.csv"
    assert key.caption(made).endswith(f"{COUNT - 1} of {COUNT} individuals seen")
    assert key.moment(made) == f"{(GAP.start + 2) / RATE:.2f} s"
    axes = Figure().add_subplot()
    plane = Plane(axes, played.world)
    plane.show(made)
    assert len(plane.bodies.get_paths()) == COUNT
    opaque = plane.bodies.get_facecolor()[:, 3]
    assert np.count_nonzero(opaque == 0.0) == 1
    plane.show(shot(played.at(10), look_of(played.at(0), None)))  # one has not come yet
    assert len(plane.bodies.get_paths()) == COUNT - 1


def test_a_film_of_tracks_goes_as_fast_as_they_went(table, tmp_path):
    out = tmp_path / "ring.gif"
    result = call("film", "--tracks", table, *HOW, "--out", out, "--renderer", "plain",
                  "--from", 40, "--to", 60, "--pixels", "320x320", "--json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    said = json.loads(result.stdout)
    assert (said["first_tick"], said["last_tick"]) == (40, 60)
    assert said["seconds"] == pytest.approx(21 / RATE, rel=0.05)


def test_a_page_of_tracks_plays_by_itself(table, tmp_path):
    out = tmp_path / "ring.html"
    result = call("film", "--tracks", table, *HOW, "--out", out, "--every", 10)
    assert result.exit_code == 0, result.stderr
    assert "ring.csv" in out.read_text("utf-8")


@pytest.mark.parametrize("command", ["picture", "film", "lab"])
def test_what_is_wrong_with_tracks_is_one_line(command, table, tmp_path):
    missing = tmp_path / "no.csv"
    assert "no.csv cannot be read" in refusal(command, "--tracks", missing)
    line = refusal(command, "--tracks", table, "--unit", "m")
    assert "--rate" in line or "--origin" in line
    assert "unknown unit 'ells'" in refusal(command, "--tracks", table, "--unit", "ells")
    line = refusal(command, "--rate", 25)
    assert "it says how --tracks FILE is read" in line
    line = refusal(command, "--tracks", table, *HOW, "--agents", 20)
    assert "--agents 20" in line
    notes = tmp_path / "notes.txt"
    notes.write_text("nothing of this is a place\n")
    assert "notes.txt" in refusal(command, "--tracks", notes)


def test_a_tick_that_is_not_there_is_named(table, tmp_path):
    line = refusal("picture", "--tracks", table, *HOW, "--tick", FRAMES + 5,
                   "--out", tmp_path / "a.png")  # fmt: skip
    assert f"tick = {FRAMES + 5} is not in ring.csv" in line


@pytest.mark.parametrize("command", ["run", "lab", "picture"])
def test_tracks_are_no_model_to_run(command):
    assert "tracks-px is no model to run: `flockscope lab --tracks FILE` plays it" in refusal(
        command, "tracks-px"
    )
