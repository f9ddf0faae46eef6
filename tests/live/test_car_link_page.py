"""What the pages of car links show works as printed: the link, the node, the C, the figures."""

from __future__ import annotations

import os
import pty
import random
import re
import select
import shutil
import socket
import subprocess
import sys
import time
import tty
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from app.live.links.command_frame import encode, size
from app.live.links.firmware import Firmware
from app.live.links.link import EMERGENCY, RUN, STOP
from app.live.links.link_catalogue import open_link
from worlds.input_error import InputError

TEXT = "\n".join(
    (Path(__file__).parents[2] / "docs" / f"{name}.md").read_text(encoding="utf-8")
    for name in ("car-link", "car-firmware")
)


def block(language, words):
    """The one block of code in a language that has these words."""
    found = re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    (code,) = [code for code in found if words in code]
    return code


def test_the_times_of_the_table_are_those_of_the_links():
    rows = re.findall(r"^\| (\d+) \| (\d+) \|(.*) \|$", TEXT, re.MULTILINE)
    assert [int(cars) for cars, _, _ in rows] == [1, 4, 8, 16, 30]
    for cars, count, times in rows:
        n = int(cars)
        assert int(count) == size(n) == 8 + 3 * n
        bits = [size(n), size(n), size(n), 9 + size(n), 3 * n]
        bauds = [9600, 57600, 115200, 57600, 9600]
        said = [f"{10000 * b / baud:.1f} ms" for b, baud in zip(bits, bauds, strict=True)]
        assert [one.strip() for one in times.split("|")] == said


def test_the_link_of_ones_own_sends_its_lines(tmp_path):
    (tmp_path / "text_radio.py").write_text(block("python", "class TextRadio"))
    end, other = pty.openpty()
    tty.setraw(other)
    link = open_link(f"text_radio.py:{os.ttyname(other)}?baud=57600", tmp_path)
    link.send(1, RUN, {7: (0.5, -0.25), 9: (-1.0, 1.0)})
    link.send(2, STOP, {7: (0.5, 1.0)})
    said = b""
    while said.count(b"\n") < 3 and select.select([end], [], [], 1.0)[0]:
        said += os.read(end, 1000)
    assert said.decode().splitlines() == ["7 50 -25", "9 -100 100", "7 50 0"]
    with pytest.raises(InputError, match="throttle of car 7 = 2 is outside"):
        link.send(3, RUN, {7: (0.0, 2.0)})
    assert link.occupies(4) == 600 / 57600
    link.close()
    os.close(other)
    os.close(end)


def test_the_emulated_cars_of_the_page_are_told_something():
    names = {}
    exec(block("python", "EmulatedCars(Firmware([1, 2])"), names)
    assert names["moves"]
    assert set(names["moves"][0]) == {1, 2}


class Publisher:
    """Keeps what is published."""

    def __init__(self):
        self.said = []

    def publish(self, message):
        self.said.append((message.drive.steering_angle, message.drive.speed))


class StubNode:
    """As much of a ROS node as the bridge uses."""

    def __init__(self, name):
        self.name = name

    def create_publisher(self, *_):
        return Publisher()

    def create_timer(self, period, call):
        self.period, self.call = period, call

    def get_clock(self):
        return SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: "now"))


@pytest.fixture
def bridge(monkeypatch):
    """The node of the page, on a port that is free."""
    modules = {name: ModuleType(name) for name in ("rclpy", "rclpy.node", "ackermann_msgs.msg")}
    modules["ackermann_msgs"] = ModuleType("ackermann_msgs")
    modules["rclpy.node"].Node = StubNode
    modules["ackermann_msgs.msg"].AckermannDriveStamped = lambda: SimpleNamespace(
        header=SimpleNamespace(), drive=SimpleNamespace()
    )
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    names = {"__name__": "bridge"}
    exec(block("python", "class Bridge(Node)"), names)
    names["PORT"] = 0
    node = names["Bridge"]()
    yield node
    node.socket.close()


def test_the_ros_node_publishes_angles_and_speeds_and_stops_in_silence(bridge):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        to = ("127.0.0.1", bridge.socket.getsockname()[1])
        sender.sendto(encode(1, STOP, {}), to)
        sender.sendto(encode(2, RUN, {1: (1.0, 1.0), 2: (-1.0, 0.0)}), to)
        time.sleep(0.05)
        bridge.call()
        assert bridge.outlets[1].said == [(pytest.approx(0.785398), 1.0)]
        assert bridge.outlets[2].said == [(pytest.approx(-0.785398), 0.0)]
        time.sleep(0.3)
        bridge.call()
        assert bridge.outlets[1].said[1:] == [(pytest.approx(0.785398), 0.0)]
        sender.sendto(encode(3, EMERGENCY, {}), to)
        sender.sendto(encode(4, RUN, {1: (0.0, 1.0)}), to)
        time.sleep(0.05)
        bridge.call()
        assert bridge.outlets[1].said[2:] == [(0.0, 0.0)]


MAIN = """
#include <stdio.h>
int main(void) {
    unsigned now, byte;
    char what;
    while (scanf(" %c %u", &what, &now) == 2) {
        if (what == 'b' && scanf("%u", &byte) == 1) car_take((uint8_t)byte, now);
        if (what == 'a') printf("%d %d\\n", car_steer(), car_throttle(now));
    }
    return 0;
}
"""


def drive(rng, ticks):
    """(ms, bytes) every 10 ms: frames as a laboratory sends them, some late, spoilt or lost."""
    seq, mode = 0, STOP
    for n in range(ticks):
        if rng.random() < 0.02:
            mode = rng.choice([STOP, RUN, RUN, RUN, EMERGENCY])
        seq += rng.choice([1, 1, 1, 1, 1, 0, 2, -3, 40_000]) if rng.random() < 0.2 else 1
        pair = (rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0))
        cars = {address: pair for address in (1, 2, 3) if rng.random() < 0.9}
        data = bytearray(encode(seq, mode, cars))
        if rng.random() < 0.1:
            data[rng.randrange(len(data))] = rng.randrange(256)
        if rng.random() < 0.1:
            del data[rng.randrange(len(data))]
        silent = n % 400 > 360 or rng.random() < 0.1
        yield 10 * n, b"" if silent else bytes(data)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_firmware_in_c_does_what_the_emulated_one_does(tmp_path):
    (tmp_path / "car.c").write_text(block("c", "car_take") + MAIN)
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsanitize=undefined"]
    command = ["cc", *flags, "car.c", "-o", "car"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    lines, expected, firmware = [], [], Firmware([1])
    for now, data in drive(random.Random(11), 6000):
        lines += [f"b {now} {byte}" for byte in data] + [f"a {now + 5}"]
        firmware.feed(data, now / 1000.0)
        steer, throttle = firmware.drive((now + 5) / 1000.0)[1]
        expected.append(f"{round(127 * steer)} {round(127 * throttle)}")
    ran = subprocess.run(
        [tmp_path / "car"], input="\n".join(lines), capture_output=True, text=True, timeout=60
    )
    assert ran.stderr == ""
    said = ran.stdout.splitlines()
    assert said == expected
    still = sum(one.endswith(" 0") for one in expected)
    assert 1000 < still < 5000
