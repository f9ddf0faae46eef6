"""`flockscope live`, in a terminal and in scripts."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import shutil
import signal
import subprocess
import termios
import time
from pathlib import Path

import pytest
from live.natnet_emulator import Body, NatNetEmulator, free_port

from app.live.laboratory.lab_file import EXAMPLE_FILE, example, lab_from_toml
from app.live.links.link_catalogue import open_link
from app.live.operating.flock_driver import FlockDriver
from app.live.operating.lab_choices import laboratory
from app.live.recording.recording_replay import read
from app.live.recording.recording_writer import TABLES, RecordingWriter
from cli.calling import PROGRAM, call, refusal, start
from worlds.input_error import InputError

TIMEOUT = 60.0


@pytest.fixture
def room(tmp_path):
    """Writes the example's laboratory with another source, link and whatever else."""

    def written(**changes):
        text = EXAMPLE_FILE.read_text().replace("serial:/dev/ttyUSB0?baud=57600", "dry")
        for old, new in changes.items():
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "lab.toml"
        path.write_text(text)
        return path

    return written


def test_the_example_is_the_readings_room():
    lab = example()
    assert (lab.rule, lab.injected.radius, lab.injected.speed) == ("squashing", 2.0, 1.1)
    assert lab.addresses == {"red": 1, "blue": 2}


def test_a_laboratory_is_checked_by_its_file_alone(room):
    made = call("live", "check", room(), "--file-only")
    assert made.exit_code == 0
    assert "squashing-cars" in made.stdout
    assert "red at address 1, blue at address 2" in made.stdout


def standing(_seconds):
    return {
        "red car": Body((1.0, 0.05, -2.0), (0.0, 0.0, 0.0, 1.0)),
        "blue car": Body((-0.5, 0.05, 0.25), (0.0, 0.0, 0.0, 1.0)),
    }


def source_of(server):
    options = "&".join(f"{name}={value}" for name, value in server.options.items())
    return {"192.168.1.5?up=y": f"127.0.0.1?up=y&{options}"}


MORE = """
[sources]
"second room" = "optitrack:192.168.1.6?up=y"

[links]
radio = "serial:/dev/no-such-port"
"""


def with_choices(path, **changes):
    """The same file, with other sources and links to choose."""
    text = path.read_text().replace("[parameters]", MORE + "[parameters]")
    for old, new in changes.items():
        text = text.replace(old, new)
    path.write_text(text)
    return path


def test_a_check_lists_what_may_be_chosen(room):
    path = with_choices(room())
    made = call("live", "check", path, "--file-only")
    assert "sources: optitrack:192.168.1.5?up=y, second room, emulated cars" in made.stdout
    assert "links: dry run, radio" in made.stdout
    assert "rules: squashing, " in made.stdout
    found = json.loads(call("live", "check", path, "--file-only", "--json").stdout)
    assert found["choices"]["links"] == {"dry run": "dry", "radio": "serial:/dev/no-such-port"}


def test_sources_and_links_are_named_on_the_command_line(room):
    path = with_choices(room())
    port = refusal("live", "check", path, "--link", "radio", "--source", "second room")
    assert port.endswith("cannot open /dev/no-such-port: there is no such port")
    assert "unknown source 'third room'" in refusal(
        "live", "check", path, "--source", "third room", "--file-only"
    )
    assert "unknown link 'wire'" in refusal("live", "run", path, "--link", "wire", "--quiet")
    line = refusal("live", "run", path, "--link", "radio", "--dry", "--quiet")
    assert line == "flockscope: --dry and --link 'radio' exclude each other"
    line = refusal("live", "run", path, "--source", "emulated cars", "--link", "radio", "--quiet")
    assert "emulated cars have a link of their own" in line


@pytest.mark.parametrize("options", [(), ("--source", "emulated cars")])
def test_a_check_of_a_room_in_software_sees_its_cars(room, options):
    path = room()
    if not options:
        text = path.read_text().replace('link = "dry"', 'link = "simulated"')
        path.write_text(text.replace("optitrack:192.168.1.5?up=y", "simulated"))
    made = call("live", "check", path, "--json", "--within", TIMEOUT, *options)
    assert made.exit_code == 0, made.stderr
    found = json.loads(made.stdout)
    assert found["amiss"] == []
    assert found["link"] == {"text": "simulated", "shortage": ""}
    assert found["source"]["what"] == "emulated cars at 100 Hz"
    assert {at["called"] for at in found["source"]["bodies"].values()} == {"red", "blue"}


def driven(*words, record=None):
    """The summary of a run that armed: a busy machine takes its time to see both cars."""
    for seconds in (8, 20, TIMEOUT):
        to = () if record is None else ("--record", record / f"{seconds:g} s")
        made = call(*words, *to, "--arm", "--json", "--seconds", seconds)
        assert made.exit_code == 0
        *events, summary = map(json.loads, made.stdout.splitlines())
        if ("arm", "--arm") in [(event["kind"], event["cause"]) for event in events]:
            assert summary.get("recording") == (str(to[1]) if to else None)
            return summary
    return pytest.fail(f"never armed: {events}")


def test_a_room_in_software_is_run_as_any_other(room):
    summary = driven("live", "run", room(), "--source", "emulated cars")
    assert summary["ticks"] > 100


def test_a_check_tells_who_is_seen_and_sends_nothing(room):
    pytest.importorskip("motioncapture")
    with NatNetEmulator(standing) as server:
        made = call("live", "check", room(**source_of(server)), "--json")
    assert made.exit_code == 0
    found = json.loads(made.stdout)
    assert found["amiss"] == []
    assert found["link"] == {"text": "dry", "shortage": ""}
    # The emulator sends 100 a second; on a busy machine it has been seen to send 20.
    assert 0.0 < found["source"]["rate"] < 200.0
    assert found["source"]["bodies"]["red car"] == {"called": "red", "x": 1.0, "y": 2.0, "yaw": 0.0}


def test_a_check_names_what_is_amiss(room):
    pytest.importorskip("motioncapture")
    with NatNetEmulator(standing) as server:
        path = room(**source_of(server), **{'"blue car"': '"green car"', "[3.05,": "[1.4,"})
        path.write_text(path.read_text().replace("radius = 2.0", "radius = 0.5"))
        line = refusal("live", "check", path, "--quiet")
    assert line == (
        "flockscope: red is not within the fence; blue is not seen: no body 'green car', "
        "only 'blue car', 'red car'"
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({'rule = "squashing"': 'rule = "squash"'}, "unknown rule 'squash'"),
        ({"beta = 2.0": "bta = 2.0"}, "unknown parameter 'bta'"),
        ({"fence = 0.5": "fence = 0.1"}, "fence = 0.1 m is too little"),
    ],
)
@pytest.mark.parametrize("command", ["check", "run", "emulate"])
def test_what_is_wrong_is_told_in_one_line(room, command, changes, words):
    quiet = ["--quiet"] if command != "check" else []
    assert words in refusal("live", command, room(**changes), *quiet)


def test_options_out_of_range_are_refused(room, tmp_path):
    assert "--within 0 s is outside (0, 600]" in refusal("live", "check", room(), "--within", 0)
    line = refusal("live", "emulate", "--quiet", "--seconds", -1)
    assert line == "flockscope: --seconds -1 is outside [0, 1e6)"
    assert "cannot be read" in refusal("live", "run", tmp_path / "none.toml")
    assert "cannot be read" in refusal("live", "replay", tmp_path / "none")
    assert "holds nothing to recover" in refusal("live", "recover", tmp_path)
    assert "holds nothing to recover" in refusal("recover", tmp_path)


@pytest.mark.parametrize("command", [("recover",), ("live", "recover")])
def test_the_folder_of_a_killed_live_run_is_recovered(tmp_path, command):
    with RecordingWriter(tmp_path / "run", example().to_toml()):
        shutil.copytree(tmp_path / "run", tmp_path / "killed")
    made = call(*command, tmp_path / "killed", "--json")
    assert json.loads(made.stdout) == {
        "folder": str(tmp_path / "killed"),
        "rows": dict.fromkeys(TABLES, 0),
        "ending": None,
    }
    assert read(tmp_path / "killed").lab == example()


def test_a_recording_of_emulated_cars_replays_to_the_bit(tmp_path):
    port = free_port()
    summary = driven("live", "emulate", "--port", port, record=tmp_path)
    folder = Path(summary["recording"])
    lab = read(folder).lab
    assert (lab.source, lab.link) == ("simulated", f"simulated?port={port}")
    replayed = json.loads(call("live", "replay", folder, "--json").stdout)
    assert replayed["same"]
    assert replayed["ticks"] >= summary["ticks"] > 100
    assert replayed["commands"] == 2 * replayed["ticks"]
    assert "the same to the bit" in call("live", "replay", folder).stdout
    assert "exists already" in refusal("live", "emulate", "--quiet", "--record", folder)


class Screen:
    """A program that believes to be in a terminal."""

    def __init__(self, *args):
        self.end, other = pty.openpty()
        self.process = subprocess.Popen(
            [*PROGRAM, *map(str, args)],
            stdin=other,
            stdout=other,
            stderr=other,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )
        os.close(other)
        self.text = ""

    def reads(self, *words):
        """Read until it says one of these words; which."""
        ends = time.monotonic() + TIMEOUT
        while not any(one in self.text for one in words):
            assert time.monotonic() < ends, self.text[-500:]
            try:
                self.text += os.read(self.end, 4096).decode(errors="replace")
            except OSError:
                assert any(one in self.text for one in words), self.text[-500:]
        first = min((one for one in words if one in self.text), key=self.text.index)
        self.text = self.text[self.text.index(first) + len(first) :]
        return first

    def press(self, keys):
        os.write(self.end, keys.encode())


def test_keys_arm_stop_reset_and_leave():
    screen = Screen("live", "emulate")
    try:
        screen.reads("a arms, space or any other key: EMERGENCY STOP")
        screen.reads("no longer: blue was never seen")
        said = ""
        while said != "armed RUN | red":  # a busy machine may lose the cars out of sight again
            screen.press("a")
            said = screen.reads("armed RUN | red", "safe stop |", "cannot be armed")
        screen.press(" ")
        screen.reads("EMERGENCY STOP (terminal)")
        screen.press("a")
        screen.reads("cannot be armed: the emergency stop is latched")
        screen.press("r")
        screen.reads("emergency stop reset; not armed (terminal)")
        screen.press("q")
        screen.reads("ticks of")
        assert screen.process.wait(TIMEOUT) == 0
    finally:
        screen.process.kill()
        os.close(screen.end)


def test_a_signal_leaves_with_the_summary():
    process = start("live", "emulate", "--json", start_new_session=True)
    try:
        assert json.loads(process.stdout.readline())["kind"] == "unseen"
        process.send_signal(signal.SIGTERM)
        out, _ = process.communicate(timeout=TIMEOUT)
    finally:
        process.kill()
    assert process.returncode == 0
    assert json.loads(out.splitlines()[-1])["ticks"] > 0


PAGE = Path(__file__).parents[2] / "docs" / "live.md"
SHOWN = re.findall(r"^flockscope live (\w+)(.*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)


def test_the_page_shows_every_command():
    assert {name for name, _ in SHOWN} == {
        "check",
        "emulate",
        "lab",
        "recover",
        "replay",
        "run",
    }


@pytest.mark.parametrize(("name", "rest"), SHOWN)
def test_what_the_page_shows_is_there(name, rest):
    known = set(re.findall(r"--[\w-]+", call("live", name, "--help").stdout))
    assert set(re.findall(r"--[\w-]+", rest)) <= known


def test_the_laboratory_of_the_page_is_the_example():
    found = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    lab = lab_from_toml(max(found, key=len), "docs/live.md")
    plain = {"parameters": {}}
    assert lab.model_copy(update=plain) == example().model_copy(update=plain)
    assert FlockDriver(lab).parameters == FlockDriver(example()).parameters


def test_a_link_of_ones_own_lies_beside_the_laboratorys_file(room, tmp_path):
    (tmp_path / "mine.py").write_text("def open_link(place):\n    raise ValueError('here')\n")
    path = room()
    path.write_text(path.read_text().replace('link = "dry"', 'link = "mine.py:"'))
    assert laboratory(path).lab.link == f"{tmp_path.resolve() / 'mine.py'}:"
    with pytest.raises(ValueError, match="here"):
        open_link(laboratory(path).lab.link)


def test_the_links_that_may_be_chosen_lie_there_too(room, tmp_path):
    (tmp_path / "mine.py").write_text("raise ValueError('it must not be run')\n")
    path = with_choices(room(), **{"serial:/dev/no-such-port": "mine.py:a"})
    assert laboratory(path).lab.links == {"radio": f"{tmp_path.resolve() / 'mine.py'}:a"}
    assert laboratory(path, link="radio").lab.link == f"{tmp_path.resolve() / 'mine.py'}:a"
    (tmp_path / "mine.py").unlink()
    with pytest.raises(InputError, match=r"there is no file .*mine\.py \(link 'mine\.py:a'\)"):
        laboratory(path)
