"""`flockscope export`: what it writes, and what it refuses before anything is written."""

from __future__ import annotations

import json
import re

import pytest

from agents.flock import Flock
from app.cli.take import page_gallery
from app.cli.take.export import lesson_to_export
from app.viewer.gallery.lessons.lessons import lesson_names
from app.viewer.gallery.scene_collection import cards
from app.viewer.lab.flock_page import PageWords, steps_to_try
from tests.cli.calling import call, refusal
from worlds.input_error import InputError


def test_a_page_is_written_and_its_size_printed(tmp_path):
    out = tmp_path / "vem.html"
    done = call("export", "vem", "--agents", "20", "--out", out, "--json", "--quiet")
    page = out.read_text("utf-8")
    assert json.loads(done.stdout) == {
        "page": str(out),
        "model": "vem",
        "bytes": len(page.encode()),
    }
    assert "flockscope export vem --agents 20" in page
    assert len(page) < 150_000
    assert "class KindKernel" not in page, "only pages of agents that differ need it"
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (["vem", "--out", "flock.txt"], ".html"),
        (["no-such-model"], "no-such-model"),
        (["missing.toml"], "No such file"),
        (["state.parquet"], "state.parquet is a recording"),
        (["vem", "--agents", "0"], "agents"),
        (["--scene", "no-such"], "no-such"),
        (["--scene", "beside", "--folder", "site"], "one file: leave --folder out"),
        (["--lesson", "who-leads", "--beside", "vem"], "are for one flock: leave --beside out"),
        (["vem", "--beside", "vem"], "beside = 'vem' is the model itself"),
        (["--all", "--folder", "site", "--beside", "vem"], "--beside vem cannot be given with"),
        (["--scene", "mill", "--agents", "5"], "--agents 5 cannot be given with --scene"),
        (["--scene", "mill", "--agents", "0"], "--agents 0 cannot be given with --scene"),
        (["--scene", "mill", "--lesson", "who-leads"], "--scene cannot be given with --lesson"),
        (["vem", "--lesson", "who-leads"], "MODEL vem cannot be given with --lesson"),
        (["--lesson", "no-such"], "no-such"),
        (["--paper", "no-such"], "no-such"),
        (["no-such", "--paper", "liu2021-table1"], "no-such"),
    ],
)
def test_what_no_page_can_do_is_refused_in_a_line(tmp_path, monkeypatch, given, why):
    monkeypatch.chdir(tmp_path)
    assert why in refusal("export", *given, "--quiet")
    assert list(tmp_path.iterdir()) == []


def test_a_page_that_is_there_is_not_replaced(tmp_path):
    out = tmp_path / "flock.html"
    out.write_text("mine")
    assert "flock.html" in refusal("export", "vem", "--out", out)
    assert out.read_text() == "mine"


SOURCES = {
    "a scene": (["--scene", "order"], "order"),
    "a lesson": (["--lesson", "order-against-noise"], "order-against-noise"),
    "a paper": (["--paper", "liu2021-table1"], "liu2021-table1"),
}


@pytest.mark.exhaustive
@pytest.mark.parametrize("source", SOURCES)
def test_a_page_says_what_it_was_made_of(tmp_path, source):
    given, name = SOURCES[source]
    out = tmp_path / "page.html"
    call("export", *given, "--out", out, "--quiet")
    page = out.read_text("utf-8")
    assert f"flockscope export {given[0]} {name}" in page
    assert "<h1></h1>" not in page


def test_the_words_of_a_scenes_file_are_on_its_page(tmp_path):
    scene = tmp_path / "mine.toml"
    scene.write_text(
        'title = "Mine <b>"\nwatch = "See it."\ntry = "Turn it."\n'
        '[run]\nmodel = "vem"\nagents = 12\nworld = "wrap"\nsize = 5.0\nseed = 4\n'
    )
    out = tmp_path / "page.html"
    call("export", scene, "--out", out, "--quiet")
    page = out.read_text("utf-8")
    assert "<h1>Mine &lt;b&gt;</h1><p>See it.</p>" in page
    assert "Turn it." in page


@pytest.mark.exhaustive
def test_pages_of_a_folder_share_what_shows_them(tmp_path):
    folder = tmp_path / "site"
    given = ("--folder", folder, "--agents", "9", "--quiet")
    done = call("export", "vem", *given, "--out", "one.html", "--json")
    told = json.loads(done.stdout)
    assert told["bytes"] == sum(file.stat().st_size for file in folder.iterdir())
    shared = {name: (folder / name).read_bytes() for name in ("viewer.js", "viewer.css")}
    call("export", "vem", *given, "--out", "two.html", "--set", "eta=1")
    assert {file.name for file in folder.iterdir()} == {
        *("one.html", "one.wasm", "one.bin", "two.html", "two.wasm", "two.bin"),
        *shared,
    }
    assert "two.html' exists already" in refusal("export", "vem", *given, "--out", "two.html")
    (folder / "viewer.js").write_text("of another version")
    assert "viewer.js' exists already" in refusal("export", "vem", *given, "--out", "three.html")
    assert not (folder / "three.html").exists()
    call("export", "vem", *given, "--out", "two.html", "--overwrite")
    assert (folder / "viewer.js").read_bytes() == shared["viewer.js"]
    assert "NAME.html" in refusal("export", "vem", *given, "--out", "a/b.html")


@pytest.mark.exhaustive
def test_a_gallery_has_a_page_of_each_and_says_what_has_none(tmp_path, monkeypatch, capsys):
    some = [card for card in cards() if card.name in ("beside", "model:vem", "model:couzin")]
    monkeypatch.setattr(page_gallery, "cards", lambda: tuple(some))
    files_of = page_gallery.page_files

    def refuses_couzin(flock, *given):
        if flock.model.name == "couzin":
            raise InputError("no browser can do it")
        return files_of(flock, *given)

    monkeypatch.setattr(page_gallery, "page_files", refuses_couzin)
    told = page_gallery.write_gallery(tmp_path / "site", overwrite=False, quiet=False)
    assert told["refused"] == {"model:couzin": "no browser can do it"}
    assert "model:couzin has no page: no browser can do it" in capsys.readouterr().err
    index = (tmp_path / "site" / "index.html").read_text("utf-8")
    assert 'href="model-vem.html"' in index
    assert 'href="beside.html"' in index
    beside = (tmp_path / "site" / "beside.html").read_text("utf-8")
    assert beside.count("<iframe") == 2
    files = {file.name for file in (tmp_path / "site").iterdir()}
    assert files == {*told["files"], "index.html"}
    with pytest.raises(InputError, match="exists already"):
        page_gallery.write_gallery(tmp_path / "site", overwrite=False, quiet=True)


def test_all_pages_go_into_a_folder_and_are_of_no_run(tmp_path):
    assert "--all needs --folder" in refusal("export", "--all")
    given = ("export", "--all", "--folder", tmp_path / "site")
    assert "MODEL vem cannot be given with --all" in refusal(*given, "vem")
    assert "--agents 4 cannot be given with --all" in refusal(*given, "--agents", "4")
    assert "--lesson x cannot be given with --all" in refusal(*given, "--lesson", "x")


@pytest.mark.parametrize("name", lesson_names())
def test_a_lesson_for_one_does_not_speak_of_the_class(name):
    lesson = lesson_to_export(name)
    assert lesson.tries
    assert not re.search("class|hand", lesson.tries)


def test_what_to_try_is_what_was_found_so():
    found = steps_to_try(Flock("vem", rng=5), PageWords())
    assert [step["set"] for step in found] == [{"eta": 5.5}]
    assert steps_to_try(Flock("vem", rng=5, agents=90), PageWords()) == []
    assert steps_to_try(Flock("vem", rng=5, eta=1.0), PageWords()) == []
