"""The real digi-xbee library and an emulated radio."""

from __future__ import annotations

import time

import pytest

from app.live.links import xbee
from app.live.links.command_frame import encode, size
from app.live.links.firmware import Firmware
from app.live.links.link import RUN, STOP, LinkLost, shortage
from app.live.links.link_catalogue import open_link
from live.xbee_radio import Radio, api_frame
from worlds.input_error import InputError

EVERYONE = 0xFFFF


def until(condition, longest=3.0):
    end = time.monotonic() + longest
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    return condition()


def test_the_frames_of_the_radio_are_those_of_its_manual():
    # the example of the 802.15.4 manual: ask for the value of DL, frame id 0x52
    assert api_frame(b"\x08\x52DL").hex() == "7e00040852444c15"


def test_frames_reach_everyone_as_they_were_encoded():
    heard = []
    with Radio(lambda to, data: heard.append((to, data))) as radio:
        link = open_link(f"xbee:{radio.port}?baud=115200")
        taken = []
        for n in range(20):
            frame = (n, n % 2, {1: (0.5, -0.25), 9: (-1.0, 1.0)})
            dropped = link.dropped
            link.send(*frame)
            taken += [encode(*frame)] if link.dropped == dropped else []
            time.sleep(0.01)
        until(lambda: len(heard) >= len(taken))
        link.close()
    assert {"AP", "HV", "VR", "MY"} <= set(radio.asked)
    assert set(radio.sizes[-len(taken) :]) == {9 + size(2)}
    assert len(taken) > 10
    assert heard == [(EVERYONE, frame) for frame in taken]


def test_cars_behind_the_radio_do_as_they_are_told():
    firmware = Firmware([3, 4])
    with Radio(lambda _, data: firmware.feed(data, time.monotonic())) as radio:
        link = open_link(f"xbee:{radio.port}")
        seq = 0

        def driven():
            nonlocal seq
            link.send(seq, STOP if seq < 5 else RUN, {3: (1.0, 1.0)})
            seq += 1
            now = time.monotonic()
            return firmware.drive(now)[3] == (1.0, 1.0) and firmware.cars[4].state(now) != "running"

        assert until(driven)
        assert until(lambda: firmware.cars[3].state(time.monotonic()) == "lost")
        assert firmware.drive(time.monotonic())[3] == (1.0, 0.0)
        link.close()


def test_a_radio_that_stalls_is_not_waited_for():
    with Radio() as radio:
        link = open_link(f"xbee:{radio.port}")
        radio.stall()
        while link.dropped < 24:
            link.send(1, RUN, {1: (0.0, 0.0)})
        with pytest.raises(LinkLost, match="has taken none of 25 frames"):
            link.send(1, RUN, {1: (0.0, 0.0)})
        link.close()


def test_what_the_radio_puts_around_a_frame_counts_as_well():
    with Radio() as radio:
        fast, slow = f"xbee:{radio.port}", f"xbee:{radio.port}?baud=9600"
        link = open_link(fast)
        assert link.occupies(4) == 10 * (9 + 20) / 57600
        assert shortage(link, 12) == ""
        assert shortage(link, 14)
        link.close()
        link = open_link(slow)
        assert shortage(link, 1).startswith(f"{slow} is busy for 20.8 ms with every frame to 1")
        link.close()


def test_a_radio_that_is_gone_is_told(capfd):
    with Radio() as radio:
        link = open_link(f"xbee:{radio.port}")
        link.send(1, RUN, {1: (0.0, 0.0)})
    time.sleep(0.1)
    with pytest.raises(LinkLost, match="is lost"):
        link.send(2, RUN, {1: (0.0, 0.0)})
    link.close()
    assert capfd.readouterr() == ("", "")


def test_a_radio_of_another_family_is_refused():
    zigbee = {"VR": b"\x40\x60"}
    with Radio(**zigbee) as radio, pytest.raises(InputError, match=r"no XBee for IEEE 802\.15\.4"):
        open_link(f"xbee:{radio.port}")


def test_a_radio_that_does_not_answer_is_refused(monkeypatch):
    monkeypatch.setattr(xbee, "ANSWER", 0.1)
    with Radio(answers=False) as radio, pytest.raises(InputError, match="in API mode at 9600 baud"):
        open_link(f"xbee:{radio.port}?baud=9600")


def test_a_port_that_is_not_there_is_refused():
    with pytest.raises(InputError, match="cannot open /dev/nowhere: there is no such port"):
        open_link("xbee:/dev/nowhere")


def test_what_no_car_may_be_told_never_reaches_the_radio():
    heard = []
    with Radio(lambda *one: heard.append(one)) as radio:
        link = open_link(f"xbee:{radio.port}")
        with pytest.raises(InputError, match=r"steer of car 1 = 1.01 is outside \[-1, 1\]"):
            link.send(1, RUN, {1: (1.01, 0.0)})
        link.close()
    assert heard == []
