"""The command that opens the laboratory."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest
from cli.calling import refusal

from app.cli.lab import open_argument, parameters
from app.viewer.gallery.scene_collection import FIRST, built_in_scene
from tests.cli.test_rule_files import CODE
from tests.live.stand_in import StandIn
from tests.viewer.waiting import until
from worlds.input_error import InputError

COLD = 120.0
"""Seconds for what a busy machine compiles without a cache."""
ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, "-c", "from app.cli.main import main; main()", "lab"]


def start(*arguments: str, **environment: str) -> subprocess.Popen:
    return subprocess.Popen(
        [*COMMAND, "--no-open", "--agents", "20", *arguments],
        cwd=ROOT,
        env=os.environ | {"PYTHONUNBUFFERED": "1", "PYTHONFAULTHANDLER": "1"} | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def stopped(process, how):
    """Stop it once it serves; its exit code and what it printed."""
    try:
        line = process.stdout.readline()
        address = re.search(r"http://localhost:\d+", line)[0]
        assert b"<html" in urllib.request.urlopen(address, timeout=60).read()
        process.send_signal(how)
        out, err = process.communicate(timeout=60)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGABRT)  # what its threads are at
        pytest.fail(process.communicate()[1])
    finally:
        process.kill()
    assert "Traceback" not in out + err
    assert out.count("\n") <= 2
    return process.returncode, err


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_it_tells_its_address_serves_there_and_stops_cleanly(how):
    assert stopped(start("--port", "0"), how)[0] == 0


def test_it_stops_cleanly_while_it_compiles(tmp_path):
    code, err = stopped(start("--port", "0", FLOCKSCOPE_CACHE=str(tmp_path)), signal.SIGTERM)
    assert code == 0
    assert "Assertion" not in err


@contextmanager
def first_browser(process):
    """The first browser of a laboratory that is starting; both are ended."""
    try:
        address = re.search(r"http://localhost:(\d+)", process.stdout.readline())
        with StandIn(int(address[1])) as browser:
            yield browser
    finally:
        process.kill()
        process.communicate()


def panels(browser) -> str:
    """All that the page's panels say."""
    return " ".join(str(one.get("content", "")) for one in tuple(browser.controls.values()))


def test_who_comes_while_a_model_compiles_sees_a_preview_and_then_the_run(tmp_path):
    process = start("--port", "0", FLOCKSCOPE_CACHE=str(tmp_path))
    with first_browser(process) as browser:
        until(lambda: "</b> until compiled:" in panels(browser) and browser.nodes, COLD)
        until(lambda: "</b> until compiled:" not in panels(browser), COLD)
        assert "Stopped." not in panels(browser)


def test_who_comes_to_a_rule_with_a_fault_is_told_it_in_one_line(tmp_path):
    rule = tmp_path / "mine.py"
    rule.write_text(CODE.replace("for j in", "nothing = me.no_such_field\n    for j in", 1))
    line = next(n for n, one in enumerate(CODE.splitlines(), 1) if "for j in" in one)
    words = f"decide, line {line}: me has no &#x27;no_such_field&#x27; (mine.py)<br>"
    process = start("--port", "0", "--rule", str(rule), FLOCKSCOPE_CACHE=str(tmp_path / "cache"))
    with first_browser(process) as browser:
        until(lambda: words in panels(browser), COLD)


def test_a_busy_port_is_one_line_and_exit_code_2():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        process = start("--port", str(port))
        out, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert out == ""
    assert err.count("\n") == 1
    assert f"port {port} on 127.0.0.1 cannot be used" in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["hwven"], "did you mean 'hwvem'?"),
        (["--set", "eta=99"], "eta = 99 rad is outside"),
        (["--set", "eta"], "--set eta is not of the form NAME=VALUE"),
        (["--set", "etta=1"], "unknown parameter 'etta'"),
        (["--world", "torus"], "torus"),
        (["--activation", "at-once"], "unknown activation 'at-once'"),
        (["thesis", "--spacing", "50"], "agents = 20 do not fit"),
        (["--beside", "hwvem"], "beside = 'hwvem' is the model itself"),
        (["--beside", "vem-b"], "unknown model 'vem-b'"),
    ],
)
def test_what_cannot_be_is_one_line_and_exit_code_2(arguments, words, monkeypatch):
    monkeypatch.setattr("app.cli.lab.serve", lambda laboratory: laboratory.close())
    assert words in refusal("lab", "--no-open", "--agents", 20, "--port", 0, *arguments)


def test_settings_are_checked_and_a_little_noise_keeps_it_alive():
    assert parameters("hwvem", []) == ({"eta": 0.3}, {})
    settings = ["eta=0", "p2 = 20", "layers=instant"]
    assert parameters("hwvem", settings) == ({"eta": 0.0, "p2": 20.0, "layers": "instant"}, {})
    with pytest.raises(InputError, match="NAME=VALUE"):
        parameters("hwvem", ["=3"])


def test_it_opens_scenes_by_name_and_from_files(tmp_path):
    assert open_argument(None, None, None, None, {}, None) == built_in_scene(FIRST)
    assert open_argument(None, None, "vem", None, {}, None) is None
    assert open_argument(None, None, None, None, {"agents": 5}, None) is None
    assert open_argument(None, "mill", None, None, {}, None) == built_in_scene("mill")
    file = tmp_path / "mine.toml"
    file.write_text(built_in_scene("order").to_toml(), encoding="utf-8")
    assert open_argument(None, str(file), None, None, {}, None) == built_in_scene("order")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--scene", "mil"), "unknown scene 'mil': did you mean 'mill'?"),
        (("--scene", "mill", "--agents", "5"), "--scene has a run of its own"),
        (("nothing-there.toml",), "cannot be read: No such file"),
        (("vem", "--scene", "mill"), "cannot be given with MODEL"),
    ],
)
def test_a_scene_that_cannot_be_opened_is_one_line(arguments, words):
    assert words in refusal("lab", "--no-open", *arguments)
