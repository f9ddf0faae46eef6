"""Forged Qualisys, VRPN and Vicon streams, on loopback, while cars are armed.

Whatever a stranger sends may end or hang the library, which lives in a process of its own. It ends
neither the loop nor this process, no pose that is no number is steered by, and cars whose tracking
is gone stop.
"""

import math
import random
import socket
import struct
import threading

import pytest

from app.live.control.pose import Pose
from app.live.sources.feed import Feed
from app.live.sources.mocap import MotionCapture
from tests.live import vicon_emulator as vicon
from tests.live import vrpn_emulator as vrpn
from tests.live.armed_loop import WITHIN, ArmedLoop
from tests.live.qualisys_emulator import (
    COMMAND,
    DATA,
    EULER,
    EVENT,
    XML,
    QualisysEmulator,
    frame,
    frame_of,
    packet,
    turned,
)
from tests.live.vicon_emulator import ViconEmulator
from tests.live.vrpn_emulator import NAMES_SENDER, NAMES_TYPE, VrpnEmulator, message, naming, pose
from tests.live.waiting import until

pytest.importorskip("motioncapture")

CHANCE = random.Random(1)
RED, BLUE = Pose(1.0, 1.5, 0.5), Pose(0.0, 1.0, -1.0)
NAN = math.nan


def component(size, kind, count):
    """The head of a component of a Qualisys frame, and nothing after it."""
    return struct.pack("<IIIHH", size, kind, count, 0, 0)


QUALISYS = {
    "empty": b"",
    "7 bytes": b"\0" * 7,
    "a head alone": struct.pack("<II", 8, DATA),
    "random": CHANCE.randbytes(200),
    "longer than it is": struct.pack("<II", 1 << 30, DATA) + b"\0" * 40,
    "shorter than it is": struct.pack("<II", 4, DATA) + frame(1, [turned(1, 1, 0)])[8:],
    "components without end": packet(
        DATA, struct.pack("<QII", 0, 1, 0xFFFFFFFF) + component(0, EULER, 0)
    ),
    "a component of 2 GB": packet(
        DATA, struct.pack("<QII", 0, 1, 3) + component(0x7FFFFFFF, EULER, 0)
    ),
    "a million cameras": frame_of(component(16, 7, 1_000_000)),
    "another component": frame_of(component(16, 99, 1)),
    "more bodies than names": frame(1, [turned(1, 1, 0)] * 3),
    "bodies without end": frame(1, [turned(1, 1, 0)], 0xFFFFFFFF),
    "no number": frame(1, [(NAN, NAN, NAN, NAN)] * 2),
    "no angle": frame(1, [(0.0, 0.0, 0.0, NAN)] * 2),
    "infinite": frame(1, [(math.inf, 0.0, 0.0, 0.0)] * 2),
    "a command": packet(COMMAND, b"x" * 100),
    "names": packet(XML, b"<a>" * 30),
    "an event": packet(EVENT, b"\xff"),
    "another type": packet(99, b"x" * 50),
}

HERE = (0.0, 0.0, 0.0, 1.0)
VRPN = {
    "random": CHANCE.randbytes(2000),
    "zeros": b"\0" * 240,
    "2 GB long": message(0, 0, b"\0" * 64, 0x7FFFFFFF),
    "of length -1": message(0, 0, b"\0" * 64, -1),
    "an unknown sender": pose(1_000_000, ((0.0, 0.0, 0.0), HERE)),
    "sender -1": pose(-1, ((0.0, 0.0, 0.0), HERE)),
    "an unknown type": message(1_000_000, 0, b"\0" * 64),
    "an own type": message(-100, 0, b"\0" * 64),
    "a short pose": message(0, 0, b"\0" * 8),
    "a long pose": message(0, 0, b"\0" * 4000),
    "no number": pose(0, ((NAN, NAN, NAN), HERE)),
    "no quaternion": pose(0, ((0.0, 0.0, 0.0), (NAN, NAN, NAN, NAN))),
    "infinite": pose(0, ((math.inf, 0.0, 0.0), HERE)),
    "a name of 2 GB": message(NAMES_SENDER, 2, struct.pack(">i", 0x7FFFFFFF) + b"x\0"),
    "a name of length -1": message(NAMES_SENDER, 2, struct.pack(">i", -1) + b"x\0"),
    "a long name": naming(NAMES_SENDER, 2, "x" * 5000),
    "sender 1000000": naming(NAMES_SENDER, 1_000_000, "x"),
    "names sender -1": naming(NAMES_SENDER, -1, "x"),
    "type 1000000": naming(NAMES_TYPE, 1_000_000, "x"),
    "2100 names": b"".join(naming(NAMES_SENDER, 2 + k, f"n{k}") for k in range(2100)),
    "a text that is none": message(NAMES_SENDER, 2, struct.pack(">i", 3) + b"\xff\xfe\0"),
    "a log": message(-4, 3, b"/dev/null\0/dev/null\0"),
    "a disconnection": message(-5, 0, b""),
}

RED_NAMED = vicon.subject(0, b"red")
VICON = {
    "random": CHANCE.randbytes(4096),
    "zeros": b"\0" * 4096,
    "4 GB long": vicon.block(vicon.OBJECTS, b"x" * 64, 0xFFFFFFFF),
    "2 GB long": vicon.block(vicon.OBJECTS, b"x" * 64, 0x7FFFFFFF),
    "of another type": vicon.block(99, b"x" * 64),
    "of no block": vicon.block(vicon.OBJECTS, b""),
    "half a block": vicon.block(vicon.OBJECTS, b"\5\0\0"),
    "a block longer than it is": vicon.frame(1, vicon.block(vicon.FRAME_INFO, b"", 0x7FFFFFFF)),
    "a block of length 4 GB": vicon.frame(1, vicon.block(vicon.FRAME_INFO, b"", 0xFFFFFFFF)),
    "subjects without end": vicon.frame(1, vicon.block(vicon.SUBJECT_INFO, b"\xff" * 64)),
    "a name of 4 GB": vicon.frame(
        1, vicon.block(vicon.SUBJECT_INFO, b"\0" * 4 + vicon.string(b"x", 0xFFFFFFFF))
    ),
    "segments without end": vicon.frame(1, vicon.subject(0, b"red", vicon.vector([], 0xFFFFFFFF))),
    "poses without end": vicon.frame(
        1, RED_NAMED, vicon.pose(0, (0.0, 0.0, 0.0, 0.0), vicon.vector([], 0xFFFFFFFF))
    ),
    "no segment": vicon.frame(1, vicon.subject(0, b"red", vicon.vector([]))),
    "hidden": vicon.frame(1, RED_NAMED),
    "of nobody": vicon.frame(1, vicon.pose(7, (0.0, 0.0, 0.0, 0.0))),
    "twice the same name": vicon.frame(
        1, RED_NAMED, vicon.subject(1, b"red"), vicon.pose(1, (9.0, 9.0, 0.0, 0.0))
    ),
    "10000 names": vicon.frame(1, *(vicon.subject(k, b"n%d" % k) for k in range(10_000))),
    "a name that is no text": vicon.frame(
        1, vicon.subject(5, b"\xff\xfe\0"), vicon.pose(5, (0.0, 0.0, 0.0, 0.0))
    ),
    "a name for the terminal": vicon.frame(
        1, vicon.subject(5, b"\x1b]0;evil\x07"), vicon.pose(5, (0.0, 0.0, 0.0, 0.0))
    ),
    "no number": vicon.frame(1, RED_NAMED, vicon.pose(0, (NAN, NAN, NAN, NAN))),
    "no angle": vicon.frame(1, RED_NAMED, vicon.pose(0, (0.0, 0.0, 0.0, NAN))),
    "infinite": vicon.frame(1, RED_NAMED, vicon.pose(0, (math.inf, 0.0, 0.0, 0.0))),
    "unchanged, of nothing": vicon.block(
        vicon.OBJECTS,
        vicon.block(
            vicon.CONTENTS,
            vicon.vector([]) + vicon.vector([struct.pack("<I", k) for k in (2, 5, 9, 43)]),
        )
        + vicon.block(vicon.FRAME_INFO, b"\1\0\0\0"),
    ),
}


def server_of_vicon():
    return ViconEmulator(
        {"red": (RED.x, RED.y, 0.05, RED.yaw), "blue": (BLUE.x, BLUE.y, 0.05, BLUE.yaw)}
    )


def qualisys():
    return QualisysEmulator(
        {"red": turned(RED.x, RED.y, RED.yaw), "blue": turned(BLUE.x, BLUE.y, BLUE.yaw)}
    )


def about_z(yaw):
    return 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)


def server_of_vrpn():
    return VrpnEmulator(
        {
            "red": ((RED.x, RED.y, 0.05), about_z(RED.yaw)),
            "blue": ((BLUE.x, BLUE.y, 0.05), about_z(BLUE.yaw)),
        }
    )


def demand_unharmed(armed, feed):
    """The loop goes on; the cars are where they are, or stand since they are not seen."""
    armed.ticks(30)
    assert armed.thread.is_alive()
    for name, true in (("red", RED), ("blue", BLUE)):
        at = armed.poses[name]
        assert math.dist((at.x, at.y), (true.x, true.y)) < 0.01
        assert abs(math.remainder(at.yaw - true.yaw, math.tau)) < 0.02
    assert "\n" not in feed.trouble
    newest = feed.latest()
    age = armed.loop.control.safety.seen.age("red", armed.loop.clock())
    if age > 1.0 or newest is None:  # the tracking is gone, and the loop has known it for long
        assert not armed.runs


@pytest.mark.parametrize("attack", QUALISYS)
def test_a_forged_qualisys_stream_harms_nothing_but_its_own_process(attack):
    with (
        qualisys() as server,
        Feed(MotionCapture("qualisys", "127.0.0.1", options=server.options)) as feed,
        ArmedLoop(feed) as armed,
    ):
        for _ in range(5):
            server.forge(QUALISYS[attack])
            armed.ticks(3)
        demand_unharmed(armed, feed)
        server.flowing.clear()  # the honest stream ends: the cars stop, whatever the library does
        until(armed.is_safe, WITHIN)  # for good: what the library has yet to read comes before
        armed.ticks(5)
        assert not armed.runs


@pytest.mark.parametrize("attack", VRPN)
def test_a_forged_vrpn_stream_harms_nothing_but_its_own_process(attack, capfd):
    with (
        server_of_vrpn() as server,
        Feed(MotionCapture("vrpn", server.host)) as feed,
        ArmedLoop(feed) as armed,
    ):
        server.say(VRPN[attack])
        armed.ticks(10)
        demand_unharmed(armed, feed)
        server.flowing.clear()
        until(lambda: not armed.runs, WITHIN)
    shown = capfd.readouterr()
    assert (shown.out, shown.err) == ("", "")


@pytest.mark.parametrize("attack", VICON)
def test_a_forged_vicon_stream_harms_nothing_but_its_own_process(attack, capfd):
    with (
        server_of_vicon() as server,
        Feed(MotionCapture("vicon", server.host)) as feed,
        ArmedLoop(feed) as armed,
    ):
        for _ in range(5):
            server.forge(VICON[attack])
            armed.ticks(3)
        demand_unharmed(armed, feed)
        server.flowing.clear()
        until(armed.is_safe, WITHIN)
        armed.ticks(5)
        assert not armed.runs
    shown = capfd.readouterr()
    assert (shown.out, shown.err) == ("", "")


def test_a_vicon_server_that_hangs_up_stops_the_cars_and_is_asked_again():
    with (
        server_of_vicon() as server,
        Feed(MotionCapture("vicon", server.host, longest_gap=1.0)) as feed,
        ArmedLoop(feed) as armed,
    ):
        server.hang_up()
        until(lambda: "no frame for 1 s; it is opened again in 1 s" in feed.trouble, WITHIN)
        assert not armed.runs
        until(lambda: not feed.trouble, WITHIN)  # its frames come again
        armed.ticks(5)
        assert not armed.runs  # until somebody arms


def test_a_stranger_in_between_is_passed_over_and_its_name_reaches_no_terminal(capfd):
    with (
        server_of_vrpn() as server,
        Feed(MotionCapture("vrpn", server.host)) as feed,
        ArmedLoop(feed) as armed,
    ):
        server.say(naming(NAMES_SENDER, 2, "\x1b]0;evil\x07"))
        for _ in range(20):
            server.say(pose(2, ((9.0, 9.0, 0.0), HERE)))
            armed.ticks(2)
        assert set(armed.poses) == {"red", "blue"}
        demand_unharmed(armed, feed)
        armed.arm()  # a machine that is very busy may have held them
    assert "evil" not in "".join(capfd.readouterr())


@pytest.mark.parametrize("system", ["qualisys", "vrpn", "vicon"])
def test_cars_that_are_forged_elsewhere_are_not_believed_and_alone_they_stop_all(system):
    server = {"qualisys": qualisys, "vrpn": server_of_vrpn, "vicon": server_of_vicon}[system]()

    def forge():
        if isinstance(server, QualisysEmulator):
            server.forge(frame(1, [turned(-2.0, -2.0, 0.0), turned(2.0, 2.0, 0.0)]))
        elif isinstance(server, ViconEmulator):
            here, there = (-2.0, -2.0, 0.05, 0.0), (2.0, 2.0, 0.05, 0.0)
            named = (RED_NAMED, vicon.subject(1, b"blue"))
            server.forge(vicon.frame(1, *named, vicon.pose(0, here), vicon.pose(1, there)))
        else:
            for sender in (0, 1):
                server.say(pose(sender, ((-2.0, -2.0 + sender, 0.0), HERE)))

    def stopped():
        forge()
        return not armed.runs

    with server:
        if isinstance(server, QualisysEmulator):
            source = MotionCapture("qualisys", "127.0.0.1", options=server.options)
        else:
            source = MotionCapture(system, server.host)
        with Feed(source) as feed, ArmedLoop(feed) as armed:
            for _ in range(20):
                forge()
                armed.ticks(2)
            if armed.loop.control.safety.arm.state == "armed":
                demand_unharmed(armed, feed)
            server.flowing.clear()
            until(stopped, WITHIN)
            until(lambda: armed.loop.control.safety.arm.state == "safe", WITHIN)
            events = list(armed.loop.events)
            assert any("seen" in one.words and one.kind in ("leap", "unseen") for one in events)


class Babbler:
    """A TCP server that greets whoever comes with the same bytes, and then hears on."""

    def __init__(self, greeting):
        self.greeting = greeting
        self.met = threading.Event()
        self.door = socket.create_server(("127.0.0.1", 0))
        self.port = self.door.getsockname()[1]
        self.lines = []
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while True:
            try:
                line, _ = self.door.accept()
                self.lines.append(line)
                self.met.set()
                line.sendall(self.greeting)
                line.shutdown(socket.SHUT_WR)
            except OSError:
                if self.door.fileno() < 0:
                    return

    def close(self):
        self.door.shutdown(socket.SHUT_RDWR)
        self.door.close()
        for line in self.lines:
            line.close()


GREETINGS = {
    "nothing": b"",
    "random": CHANCE.randbytes(4096),
    "2 GB announced": struct.pack("<II", 0x7FFFFFFF, 1) + b"\xff" * 64,
    "zeros": b"\0" * 4096,
    "a web server": b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n",
}


@pytest.mark.parametrize("greeting", GREETINGS)
@pytest.mark.parametrize("system", ["vicon", "qualisys"])
def test_a_server_that_is_none_is_given_up_in_one_line(system, greeting):
    server = Babbler(GREETINGS[greeting])
    try:
        source = (
            MotionCapture("vicon", f"127.0.0.1:{server.port}")
            if system == "vicon"
            else MotionCapture("qualisys", "127.0.0.1", options={"port": str(server.port - 1)})
        )
        with Feed(source, timeout=6.0) as feed:
            until(server.met.is_set, WITHIN)
            until(lambda: feed.trouble or feed.state == "waiting", WITHIN)
            assert feed.latest() is None
            assert "\n" not in feed.trouble
            assert feed.trouble.startswith(f"{system} at 127.0.0.1") or not feed.trouble
    finally:
        server.close()


@pytest.mark.parametrize("greeting", [b"", CHANCE.randbytes(4096), b"vrpn: ver. 99.99  9" * 20])
def test_a_vrpn_server_that_is_none_gives_no_body(greeting):
    with (
        VrpnEmulator({}, greeting or vrpn.COOKIE[:7]) as server,
        Feed(MotionCapture("vrpn", server.host), timeout=6.0) as feed,
    ):
        until(lambda: feed.trouble or feed.since(20), WITHIN)
        assert feed.last_seen() == {}
        assert "\n" not in feed.trouble
