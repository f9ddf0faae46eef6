"""What a stranger on the channel can do to a radio, a serial port and the cars behind them."""

from __future__ import annotations

import os
import random
import threading

import pytest

from app.live.links.command_frame import MOST_CARS, encode
from app.live.links.firmware import WATCHDOG, Firmware
from app.live.links.link import EMERGENCY, RUN, STOP
from app.live.links.link_catalogue import open_link
from tests.live.chain_cars import chain_of
from tests.live.waiting import until
from tests.live.xbee_radio import Radio, api_frame

WITHIN = 60.0
CHANCE = random.Random(1)
SAID = {
    "random": CHANCE.randbytes(3000),
    "beginnings": b"\x7e" * 3000,
    "64 kB announced": b"\x7e\xff\xff" + b"\0" * 200,
    "empty packets": b"\x7e\x00\x00\xff" * 200,
    "wrong checksums": b"\x7e\x00\x05\x81\x00\x01\x28\x00\x00" * 200,
    "packets of strangers": api_frame(b"\x81\x00\x09\x28\x00" + b"x" * 90) * 200,
    "packets cut short": api_frame(b"\x81\x00") * 50,
    "another mode of the radio": api_frame(b"\x88\x01AP\x00\x00") * 50,
    "every type": b"".join(
        api_frame(bytes([kind]) + CHANCE.randbytes(n)) for kind in range(256) for n in (0, 1, 12)
    ),
}


@pytest.mark.parametrize("said", SAID)
def test_a_radio_that_says_anything_goes_on_sending(said, capfd):
    """200 packets of a stranger, or 50 of another mode, ended or blocked the library's reader."""
    heard = []
    with Radio(lambda to, data: heard.append((to, data))) as radio:
        link = open_link(f"xbee:{radio.port}?baud=115200")
        stranger = threading.Thread(target=os.write, args=(radio.end, SAID[said]), daemon=True)
        stranger.start()
        sent = 0

        def through():
            nonlocal sent
            link.send(sent, RUN, {1: (0.5, 0.5)})
            sent += 1
            return len(heard) >= 100 and not stranger.is_alive()

        until(through, WITHIN)
        link.close()
    frames = [encode(seq, RUN, {1: (0.5, 0.5)}) for seq in range(sent)]
    assert all(to == 0xFFFF and data in frames for to, data in heard)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", ["serial", "chain"])
def test_a_port_that_says_anything_is_never_waited_for(kind):
    end, other = os.openpty()
    try:
        link = open_link(f"{kind}:{os.ttyname(other)}?baud=115200")
        stranger = threading.Thread(target=os.write, args=(end, CHANCE.randbytes(200_000)))
        stranger.start()

        def through():
            link.send(1, RUN, {1: (0.5, 0.5)})
            os.read(end, 4096)
            return not stranger.is_alive()

        until(through, WITHIN)
        link.close()
    finally:
        os.close(end)
        os.close(other)


def driving(seq=1000):
    """Firmware of two cars that drives, at time 0.01, and the number of its newest command."""
    firmware = Firmware([1, 2])
    firmware.feed(encode(seq - 1, STOP, {}), 0.0)
    firmware.feed(encode(seq, RUN, {1: (0.5, 0.5), 2: (0.0, 0.25)}), 0.01)
    return firmware


def frame_with(length=None, mode=None, crc=0):
    """A frame to car 1 at full throttle with another length, mode or CRC."""
    frame = bytearray(encode(1001, RUN, {1: (1.0, 1.0)}))
    if length is not None:
        frame[2] = length
    if mode is not None:
        frame[5] = mode
    frame[-1] ^= crc
    return bytes(frame)


@pytest.mark.parametrize(
    "forged",
    [
        CHANCE.randbytes(20_000),
        b"\x80" * 20_000,
        frame_with(length=0x80),
        frame_with(length=255),
        frame_with(length=3 + 3 * MOST_CARS),
        frame_with(mode=7),
        frame_with(crc=1),
        encode(1001, RUN, {1: (1.0, 1.0)})[:-1],
        encode(1001, RUN, {9: (1.0, 1.0)}),
    ],
)
def test_what_is_no_frame_for_a_car_moves_none_and_holds_up_no_stop(forged):
    firmware = driving()
    before = firmware.drive(0.02)
    firmware.feed(forged, 0.02)
    assert firmware.drive(0.03) == before
    firmware.feed(encode(1002, STOP, {}), 0.04)
    firmware.feed(encode(1003, STOP, {}), 0.05)  # the rest of a frame that was begun may take one
    assert {throttle for _, throttle in firmware.drive(0.06).values()} == {0.0}


def test_frames_that_are_replayed_do_nothing_while_the_sender_lives():
    recorded = [encode(seq, RUN, {1: (1.0, 1.0)}) for seq in range(900, 1001)]
    firmware = driving()
    for k in range(50):
        now = 0.02 + 0.01 * k
        firmware.feed(encode(1001 + k, STOP, {}), now)
        firmware.feed(b"".join(recorded), now + 0.005)
        assert {throttle for _, throttle in firmware.drive(now + 0.006).values()} == {0.0}


def test_what_a_stranger_can_do_is_what_the_page_says():
    """Frames are not signed: who has the channel can drive cars, and undo a stop."""
    firmware = driving()
    firmware.feed(encode(1001, EMERGENCY, {}), 0.02)
    firmware.feed(encode(1002, RUN, {1: (1.0, 1.0)}), 0.03)
    assert firmware.drive(0.03)[1][1] == 0.0  # a run does not undo it
    firmware.feed(encode(1003, STOP, {}), 0.04)
    firmware.feed(encode(1004, RUN, {1: (1.0, 1.0)}), 0.05)
    assert firmware.drive(0.05)[1][1] == 1.0  # a forged stop and a forged run do
    late = 0.05 + WATCHDOG + 0.01
    assert firmware.drive(late)[1][1] == 0.0
    firmware.feed(encode(5, RUN, {1: (1.0, 1.0)}), late)
    assert firmware.drive(late)[1][1] == 1.0  # once the sender is silent, a recorded one does


def test_a_stranger_in_a_chain_shifts_all_that_follow():
    """The paper's chain has no check: one byte of a stranger, and every command is another's."""
    cars = chain_of(2)
    cars[0].feed(b"\x05")
    cars[0].feed(b"\x01\x00\x40\x02\x00\x40")
    assert (0, 64) not in cars[0].taken
