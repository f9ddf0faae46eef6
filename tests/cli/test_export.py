"""`flockscope export`: what it writes, and what it refuses before anything is written."""

from __future__ import annotations

import json

import pytest

from tests.cli.calling import call, refusal


def test_a_page_is_written_and_its_size_printed(tmp_path):
    out = tmp_path / "vem.html"
    done = call("export", "vem", "--agents", "20", "--out", out, "--json", "--quiet")
    page = out.read_text("utf-8")
    assert json.loads(done.stdout) == {"page": str(out), "model": "vem", "bytes": len(page)}
    assert "flockscope export vem --agents 20" in page
    assert len(page) < 150_000
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (["vem", "--activation", "random"], "activation = random cannot run in a page"),
        (["vem", "--wind", "0.1"], "wind and gusts cannot run in a page"),
        (["vem", "--out", "flock.txt"], ".html"),
        (["no-such-model"], "no-such-model"),
        (["missing.toml"], "No such file"),
        (["state.parquet"], "state.parquet is a recording"),
        (["vem", "--agents", "0"], "agents"),
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
