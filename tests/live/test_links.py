"""Every link carries whole frames, says in one line what is wrong, and never waits."""

from __future__ import annotations

import contextlib
import os
import pty
import select
import socket
import time
import tty

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.link_address import read_place
from app.live.links import link_catalogue, wire
from app.live.links.command_frame import CommandFrame, Decoder, encode
from app.live.links.link import EMERGENCY, RUN, STOP, LinkLost, shortage
from app.live.links.link_catalogue import encode_chain, open_link
from app.live.links.wire import MOST_IN_A_ROW
from live.chain_cars import chain_of
from worlds import plug_ins
from worlds.input_error import InputError

FOUR = {1: (0.5, 1.0), 2: (-1.0, 0.25), 3: (0.0, 0.0), 4: (1.0, -1.0)}


@pytest.fixture
def ends():
    """A pseudo-terminal: the file at one end and the name of the port at the other."""
    end, other = pty.openpty()
    tty.setraw(other)
    yield end, os.ttyname(other)
    for one in (end, other):
        with contextlib.suppress(OSError):  # a test may have pulled it out
            os.close(one)


def read_all(end, count):
    """So many bytes from a file, or what comes within a second."""
    data = b""
    while len(data) < count and select.select([end], [], [], 1.0)[0]:
        data += os.read(end, 65536)
    return data


def test_a_serial_port_carries_frames(ends):
    end, port = ends
    link = open_link(f"serial:{port}?baud=115200")
    link.send(1, RUN, FOUR)
    link.send(2, EMERGENCY, {})
    expected = encode(1, RUN, FOUR) + encode(2, EMERGENCY, {})
    assert read_all(end, len(expected)) == expected
    link.close()


def test_a_port_that_nobody_reads_is_not_waited_for_and_cuts_no_frame(ends):
    end, port = ends
    link = open_link(f"serial:{port}")
    taken = []
    while link.dropped < MOST_IN_A_ROW - 1:
        dropped = link.dropped
        link.send(len(taken), RUN, FOUR)
        taken += [len(taken)] if link.dropped == dropped else []
    with pytest.raises(LinkLost, match=f"has taken none of {MOST_IN_A_ROW} frames"):
        link.send(len(taken), RUN, FOUR)
    data = read_all(end, 20 * (len(taken) - 1))
    dropped = None
    while dropped != link.dropped:  # until there is room again
        dropped = link.dropped
        with contextlib.suppress(LinkLost):
            link.send(5000, RUN, FOUR)  # what is left of the last frame comes before it
    data += read_all(end, 20 * (len(taken) + 1) - len(data))
    decoder = Decoder()
    assert [command.seq for command in decoder.feed(data)] == [*taken, 5000]
    assert decoder.rejected == 0
    assert len(data) == 20 * (len(taken) + 1)
    link.close()


def test_a_port_that_is_pulled_out_is_told(ends):
    end, port = ends
    link = open_link(f"serial:{port}")
    os.close(end)
    with pytest.raises(LinkLost, match=f"the link 'serial:{port}' is lost: "):
        link.send(1, RUN, FOUR)
    link.close()


def test_a_port_has_one_owner(ends):
    _, port = ends
    link = open_link(f"serial:{port}")
    with pytest.raises(InputError, match="another program has it open"):
        open_link(f"chain:{port}")
    link.close()


def test_datagrams_carry_a_frame_each():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as car:
        car.bind(("127.0.0.1", 0))
        car.settimeout(2.0)
        link = open_link(f"udp:127.0.0.1:{car.getsockname()[1]}")
        link.send(1, RUN, FOUR)
        link.send(2, STOP, FOUR)
        assert [car.recv(999), car.recv(999)] == [encode(1, RUN, FOUR), encode(2, STOP, FOUR)]
        link.close()


def test_that_nobody_listens_to_datagrams_is_no_error():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    link = open_link(f"udp:127.0.0.1:{port}")
    for seq in range(5):
        link.send(seq, RUN, FOUR)
    link.close()


def test_a_dry_run_checks_and_keeps_and_sends_nothing(capsys):
    link = open_link("dry?every=2")
    for seq in range(3):
        link.send(seq, RUN, {1: (0.3, 0.4)})
    assert link.last == CommandFrame(2, RUN, {1: (0.3, 0.4)})
    lines = [f"dry?every=2: {encode(seq, RUN, {1: (0.3, 0.4)}).hex(' ')}" for seq in (0, 2)]
    assert capsys.readouterr().out.splitlines() == lines
    link.close()


def test_the_chain_hands_every_command_to_its_car(ends):
    end, port = ends
    link = open_link(f"chain:{port}")
    link.send(1, RUN, FOUR)
    cars = chain_of(4)
    cars[0].feed(read_all(end, 12))
    assert [car.taken for car in cars] == [[(64, 127)], [(-127, 32)], [(0, 0)], [(127, -127)]]
    link.send(2, STOP, FOUR)
    cars[0].feed(read_all(end, 12))
    assert [car.taken[1:] for car in cars] == [[(64, 0)], [(-127, 0)], [(0, 0)], [(127, 0)]]
    link.close()


def test_one_lost_byte_puts_the_chain_out_of_step_for_good():
    """The reading: why a chain cannot be trusted. The broadcast frame loses one frame only."""
    commands = {1: (2 / 127, 2 / 127), 2: (1 / 127, 1 / 127)}
    cars = chain_of(2)
    cars[0].feed(encode_chain(RUN, commands)[1:])
    for _ in range(200):
        cars[0].feed(encode_chain(RUN, commands))
    assert [set(car.taken) for car in cars] == [{(1, 1)}, {(2, 2)}]  # each what the other is told
    assert [len(car.taken) for car in cars] == [200, 201]


def test_which_links_can_carry_a_hundred_frames_per_second(ends):
    _, port = ends
    chain = open_link(f"chain:{port}")
    assert chain.occupies(4) == 0.0125  # 12 bytes of 10 bits at 9600 baud
    assert shortage(chain, 3) == ""
    assert shortage(chain, 4) == (
        f"chain:{port} is busy for 12.5 ms with every frame to 4 cars, but one is due every "
        "10.0 ms: about 80 of 100 frames per second get through"
    )
    chain.close()
    slow = open_link(f"serial:{port}?baud=9600")
    assert slow.occupies(4) == 20 * 10 / 9600
    assert shortage(slow, 4)
    assert shortage(slow, 4, rate=40.0) == ""
    slow.close()
    fast = open_link(f"serial:{port}")
    assert fast.occupies(16) == 56 * 10 / 57600
    assert shortage(fast, 16) == ""
    assert shortage(fast, 17)
    fast.close()
    assert shortage(open_link("dry"), 30) == ""


class NoFreeSpace:
    """A port whose buffer still holds what was written before."""

    in_waiting = 0
    out_waiting = 3

    def read(self, count):
        return bytes(count)


def test_a_frame_is_dropped_while_the_one_before_is_on_its_way(ends, monkeypatch):
    end, port = ends
    link = open_link(f"serial:{port}")
    monkeypatch.setattr(link.wire, "port", NoFreeSpace())
    link.send(1, RUN, FOUR)
    monkeypatch.undo()
    link.send(2, RUN, FOUR)
    assert link.dropped == 1
    assert read_all(end, 20) == encode(2, RUN, FOUR)
    link.close()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("serial", r"the link 'serial' does not say which port: for example serial:/dev/ttyUSB0"),
        ("chain:", r"does not say which port: for example chain:/dev/ttyUSB0"),
        ("serial:/dev/nowhere", r"cannot open /dev/nowhere: there is no such port"),
        ("serial:/dev/null", r"cannot open /dev/null: "),
        ("serial:/dev/x?baud=fast", r"baud = 'fast' is no whole number"),
        ("serial:/dev/x?baud=100", r"baud = 100 is outside \[300, 4000000\]"),
        ("serial:/dev/x?buad=9600", r"unknown option 'buad': did you mean 'baud'\?"),
        ("serial:/dev/x?baud", r"'baud' is no option=value"),
        ("serial:/dev/x?baud=300&baud=600", r"baud is given twice"),
        ("seriel:/dev/x", r"unknown link 'seriel': did you mean 'serial'\?"),
        ("udp", r"does not say to which address: for example udp:192\.168\.1\.20:5005"),
        ("udp:car", r"has no port"),
        ("udp:127.0.0.1:0", r"port = 0 is outside \[1, 65535\]"),
        ("udp:127.0.0.1:http", r"port = 'http' is no whole number"),
        ("udp:127.0.0.1:5005?ttl=3", r"has no options, but 'ttl' is given"),
        ("udp:no.such.host.invalid:5005", r"no\.such\.host\.invalid cannot be found"),
        ("dry:/dev/x", r"leads nowhere"),
        ("", r"unknown link ''"),
    ],
)
def test_a_link_that_cannot_be_is_refused_in_one_line(text, words):
    with pytest.raises(InputError, match=words) as refusal:
        open_link(text)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("kind", ["serial", "xbee"])
def test_what_is_not_installed_is_named(kind, monkeypatch):
    import builtins

    found = builtins.__import__

    def missing(name, *rest):
        if name.split(".")[0] in ("serial", "digi"):
            raise ImportError(name)
        return found(name, *rest)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(
        InputError, match=r"needs (pyserial|digi-xbee): install the extra live: `uv"
    ):
        open_link(f"{kind}:/dev/x")


@given(st.text(max_size=40))
def test_any_text_is_taken_apart_or_refused(text):
    try:
        place = read_place(text)
    except InputError:
        return
    assert place.text == text
    assert text.startswith(place.kind)


def test_a_link_may_be_a_file_of_ones_own(tmp_path):
    (tmp_path / "mine.py").write_text(
        "from flockscope.live import CarLink\n"
        "class Mine(CarLink):\n    def __init__(self, name):\n        self.name = name\n"
        "def open_link(place):\n    return Mine(place.where)\n"
    )
    assert open_link("mine.py:/dev/thing", tmp_path).name == "/dev/thing"
    with pytest.raises(InputError, match=r"there is no file .*yours\.py"):
        open_link("yours.py:/dev/thing", tmp_path)
    (tmp_path / "empty.py").write_text("")
    with pytest.raises(InputError, match=r"has no function open_link\(place\)"):
        open_link("empty.py", tmp_path)
    (tmp_path / "wrong.py").write_text("1 / 0")
    with pytest.raises(InputError, match="cannot be run: ZeroDivisionError"):
        open_link("wrong.py", tmp_path)


def test_a_link_of_another_package_enters_by_its_name(monkeypatch):
    class Entry:
        name = "smoke"

        def load(self):
            return link_catalogue.open_dry

    monkeypatch.setattr(plug_ins, "entry_points", lambda group: [Entry()] * (group[-5:] == "links"))
    assert set(link_catalogue.collect()) == {"serial", "xbee", "udp", "chain", "dry", "smoke"}


def test_closing_does_not_wait_for_a_port_that_nobody_reads(ends):
    _, port = ends
    link = open_link(f"serial:{port}")
    link.wire.left = b"x" * 100_000
    begun = time.monotonic()
    link.close()
    assert time.monotonic() - begun < 50 * wire.DRAIN
