"""A car drives only on a fresh command to run, and stops by itself; emulated cars in real time."""

from __future__ import annotations

import random
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.emulation.emulated_cars import Datagrams, EmulatedCars, Terminal
from app.live.links.command_frame import CommandFrame, encode
from app.live.links.firmware import WATCHDOG, CarFirmware, Firmware
from app.live.links.link import EMERGENCY, RUN, STOP
from app.live.links.link_catalogue import open_link
from worlds.input_error import InputError

AHEAD = (1.0, 1.0)


def car_at_rest():
    """Car 7, told to stop by frame 0 at time 0."""
    car = CarFirmware(7)
    car.take_frame(CommandFrame(0, STOP, {}), 0.0)
    return car


def running_car():
    """Car 7, told to run by frame 1 at time 0."""
    car = car_at_rest()
    car.take_frame(CommandFrame(1, RUN, {7: AHEAD}), 0.0)
    return car


def test_a_car_that_is_switched_on_waits_for_a_stop():
    car = CarFirmware(7)
    assert car.state(0.0) == "waiting"
    car.take_frame(CommandFrame(1, RUN, {7: AHEAD}), 0.0)
    assert car.state(0.0) == "waiting"
    assert car.drive(0.0) == (1.0, 0.0)
    car.take_frame(CommandFrame(2, STOP, {}), 0.01)
    assert car.state(0.01) == "stopped"
    car.take_frame(CommandFrame(3, RUN, {7: AHEAD}), 0.02)
    assert car.drive(0.02) == AHEAD


def test_the_watchdog_stops_after_a_quarter_of_a_second_and_keeps_the_steering():
    car = running_car()
    assert WATCHDOG == 0.25
    assert car.drive(0.25) == (1.0, 1.0)
    assert car.drive(0.2500001) == (1.0, 0.0)
    assert car.state(0.2500001) == "lost"
    car.take_frame(CommandFrame(2, RUN, {7: (-1.0, 0.5)}), 5.0)
    assert car.drive(5.0) == (-1.0, 0.5)


def test_frames_for_others_do_not_keep_a_car_going():
    car = running_car()
    for n in range(2, 40):
        car.take_frame(CommandFrame(n, RUN, {8: AHEAD}), 0.01 * n)
    assert car.state(0.4) == "lost"


def test_a_frame_that_is_repeated_does_not_keep_a_car_going():
    car = running_car()
    for n in range(2, 200):
        car.take_frame(CommandFrame(1, RUN, {7: AHEAD}), 0.01 * n)
        assert car.state(0.01 * n) == ("running" if 0.01 * n <= 0.25 else "lost")


def test_older_frames_are_left_aside_until_the_watchdog_has_run_out():
    car = running_car()
    car.take_frame(CommandFrame(65530, RUN, {7: (0.0, 0.5)}), 0.1)
    assert car.drive(0.1) == AHEAD
    car.take_frame(CommandFrame(65530, RUN, {7: (0.0, 0.5)}), 0.3)
    assert car.drive(0.3) == (0.0, 0.5)
    car.take_frame(CommandFrame(2, RUN, {7: (0.0, 0.25)}), 0.31)  # 65530, ..., 65535, 0, 1, 2
    assert car.drive(0.31) == (0.0, 0.25)


def test_an_emergency_stop_stays_until_a_stop_clears_it():
    car = running_car()
    car.take_frame(CommandFrame(2, EMERGENCY, {}), 0.01)
    for n in range(3, 10):
        car.take_frame(CommandFrame(n, RUN, {7: AHEAD}), 0.01 * n)
        assert car.state(0.01 * n) == "emergency"
        assert car.drive(0.01 * n)[1] == 0.0
    car.take_frame(CommandFrame(1, STOP, {}), 0.1)  # an older stop does not clear it
    assert car.state(0.1) == "emergency"
    car.take_frame(CommandFrame(10, STOP, {}), 0.1)
    car.take_frame(CommandFrame(11, RUN, {7: AHEAD}), 0.11)
    assert car.state(0.11) == "running"


def test_an_emergency_stop_is_obeyed_however_old_it_is():
    car = running_car()
    car.take_frame(CommandFrame(0, EMERGENCY, {}), 0.01)
    assert car.state(0.01) == "emergency"


COMMANDS = st.builds(
    CommandFrame,
    st.integers(0, 40),
    st.sampled_from([STOP, RUN, RUN, RUN, EMERGENCY]),
    st.dictionaries(st.sampled_from([7, 8]), st.just(AHEAD)),
)


@given(st.lists(st.tuples(COMMANDS, st.floats(0.0, 0.4)), max_size=40), st.floats(0.0, 0.5))
def test_a_car_drives_only_on_a_fresh_command_to_run_after_a_stop(history, wait):
    car, now, cleared = CarFirmware(7), 0.0, False
    fresh = None
    for command, pause in history:
        now += pause
        seq = car.seq
        car.take_frame(command, now)
        if command.mode == EMERGENCY:
            cleared = False
        if command.mode == STOP and car.seq != seq:
            cleared = True
        if command.mode == RUN and 7 in command.commands and car.seq != seq:
            fresh = now
        if car.drive(now)[1] != 0.0:
            assert cleared
            assert fresh is not None
            assert now - fresh <= WATCHDOG
    assert car.drive(now + WATCHDOG + 1e-6 + wait)[1] == 0.0


def drive_through(air, seconds=10.0):
    """Share of the time that a car runs, told so 100 times a second through the air."""
    firmware, running = Firmware([7]), 0
    firmware.feed(encode(0, STOP, {}), 0.0)
    ticks = int(100 * seconds)
    for n in range(1, ticks + 1):
        firmware.feed(air(encode(n, RUN, {7: AHEAD})), 0.01 * n)
        running += firmware.drive(0.01 * n)[7] == AHEAD
    return running / ticks


def test_losing_half_of_the_frames_does_no_harm():
    rng = random.Random(1)
    assert drive_through(lambda frame: frame if rng.random() < 0.5 else b"") == 1.0


def test_losing_one_byte_in_a_hundred_does_no_harm():
    rng = random.Random(2)
    assert drive_through(lambda frame: bytes(b for b in frame if rng.random() > 0.01)) == 1.0


def test_spoiling_half_of_the_bytes_stops_the_cars():
    rng = random.Random(3)

    def air(frame):
        return bytes(rng.randrange(256) if rng.random() < 0.5 else b for b in frame)

    assert drive_through(air) < 0.01


def test_cutting_the_radio_stops_the_cars():
    sent = iter(range(10_000))
    assert drive_through(lambda frame: frame if next(sent) < 500 else b"") == 0.525


class Plant:
    """Keeps what it is moved with."""

    def __init__(self):
        self.moves = []

    def __call__(self, now, driven):
        self.moves.append((now, driven))


def until(condition, longest=5.0):
    end = time.monotonic() + longest
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    return condition()


@pytest.mark.parametrize("stream", [Terminal, Datagrams])
def test_emulated_cars_do_as_a_link_tells_them(stream):
    plant = Plant()
    with EmulatedCars(Firmware([1, 2]), plant, stream()) as cars:
        link = open_link(cars.link)
        told = {1: (0.5, 1.0), 2: (-0.5, 0.25)}
        heard = {1: (64 / 127, 1.0), 2: (-64 / 127, 32 / 127)}
        seq = 0

        def driven():
            nonlocal seq
            link.send(seq, RUN if seq > 5 else STOP, told)
            seq += 1
            return bool(plant.moves) and plant.moves[-1][1] == heard

        assert until(driven)
        link.close()
        assert until(lambda: plant.moves[-1][1] == {1: (64 / 127, 0.0), 2: (-64 / 127, 0.0)})
        times = [now for now, _ in plant.moves]
        assert times == sorted(times)


def spoil(data):
    """Every byte changed: what is read at once may be several frames, or part of one."""
    return bytes(b ^ 1 for b in data)


def test_emulated_cars_hear_through_bad_air():
    plant = Plant()
    with EmulatedCars(Firmware([1]), plant, Terminal(), air=spoil) as cars:
        link = open_link(cars.link)
        for seq in range(10):
            link.send(seq, STOP, {})
            time.sleep(0.01)
        assert until(lambda: len(plant.moves) > 20)
        assert cars.firmware.cars[1].state(time.monotonic()) == "waiting"
        link.close()


def test_a_port_that_is_taken_is_refused():
    taken = Datagrams()
    with pytest.raises(InputError, match=r"udp port \d+ cannot be listened to"):
        Datagrams(int(taken.link.rpartition(":")[2]))
    taken.close()
