"""The frame that goes to all cars: exact bytes, and a reader that nothing can mislead for long."""

from __future__ import annotations

import itertools
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.car_frames import crc16, read_stream, write_frame

from app.live.links.command_frame import MOST_CARS, CommandFrame, Decoder, encode, size
from worlds.input_error import InputError

FOUR = {1: (0.5, 1.0), 2: (-1.0, 0.25), 17: (0.0, 0.0), 254: (1.0, -1.0)}
UNIT = st.floats(-1.0, 1.0)
COMMANDS = st.dictionaries(st.integers(1, 254), st.tuples(UNIT, UNIT), max_size=MOST_CARS)
FRAMES = st.tuples(st.integers(0, 65535), st.integers(0, 2), COMMANDS)


def whole(commands):
    """Commands as whole numbers, as the oracle has them."""
    return [(a, round(127 * steer), round(127 * throttle)) for a, (steer, throttle) in commands]


def as_read(command):
    """A command of the decoder as the oracle says it."""
    return command.seq, command.mode, whole(command.commands.items())


def test_the_check_value_of_the_crc_is_that_of_the_catalogue():
    assert crc16(b"123456789") == 0x29B1


def test_a_frame_is_these_bytes():
    assert encode(0x1234, 1, {7: (1.0, -1.0)})[:9].hex(" ") == "80 80 06 34 12 01 07 7f 81"
    assert encode(0, 2, {}).hex(" ") == write_frame(0, 2, []).hex(" ")
    assert len(encode(0, 2, {})) == size(0) == 8
    assert len(encode(0, 1, dict.fromkeys(range(1, 31), (0.0, 0.0)))) == size(30) == 98


@given(FRAMES)
def test_a_frame_is_as_the_table_says_and_reads_back(frame):
    seq, mode, commands = frame
    cars = [(a, s, t if mode == 1 else 0) for a, s, t in whole(commands.items())]
    data = encode(seq, mode, commands)
    assert data == write_frame(seq, mode, cars)
    (read,) = Decoder().feed(data)
    assert as_read(read) == (seq, mode, cars)
    for address, (steer, throttle) in read.commands.items():
        assert abs(steer - commands[address][0]) <= 0.5 / 127 + 1e-12
        assert abs(throttle - (commands[address][1] if mode == 1 else 0.0)) <= 0.5 / 127 + 1e-12


@pytest.mark.parametrize("mode", [0, 2])
def test_only_run_sends_throttle(mode):
    (read,) = Decoder().feed(encode(5, mode, {3: (0.0, 1.0), 4: (1.0, -1.0)}))
    assert read == CommandFrame(5, mode, {3: (0.0, 0.0), 4: (1.0, 0.0)})


@pytest.mark.parametrize(
    ("mode", "commands", "words"),
    [
        (1, {1: (1.0 + 1e-9, 0.0)}, r"steer of car 1 = 1 is outside \[-1, 1\]"),
        (1, {1: (0.0, -2.0)}, r"throttle of car 1 = -2 is outside \[-1, 1\]"),
        (0, {9: (0.0, 7.0)}, "throttle of car 9 = 7 is outside"),
        (1, {1: (float("nan"), 0.0)}, "steer of car 1 = nan is outside"),
        (1, {1: (0.0, float("inf"))}, "throttle of car 1 = inf is outside"),
        (1, {0: (0.0, 0.0)}, r"address = 0 is outside \[1, 254\]"),
        (1, {255: (0.0, 0.0)}, "address = 255 is outside"),
        (1, {True: (0.0, 0.0)}, "address = True is no whole number"),
        (3, {}, "mode = 3 is none of 0"),
        (1, dict.fromkeys(range(1, 32), (0.0, 0.0)), "31 cars are more than the 30 of a frame"),
    ],
)
def test_what_no_car_may_be_told_is_refused(mode, commands, words):
    with pytest.raises(InputError, match=words):
        encode(1, mode, commands)


def test_sequence_numbers_start_again_after_65535():
    assert encode(65536 + 3, 1, FOUR) == encode(3, 1, FOUR)


def test_every_change_of_one_byte_is_noticed():
    frame = encode(300, 1, FOUR)
    for at, byte in itertools.product(range(len(frame)), range(256)):
        if byte != frame[at]:
            assert Decoder().feed(frame[:at] + bytes([byte]) + frame[at + 1 :]) == []


def test_every_change_of_two_bits_is_noticed():
    frame = encode(300, 1, {1: (0.5, 1.0), 2: (-1.0, 0.25)})
    for one, two in itertools.combinations(range(8 * len(frame)), 2):
        changed = bytearray(frame)
        changed[one // 8] ^= 1 << one % 8
        changed[two // 8] ^= 1 << two % 8
        assert Decoder().feed(changed) == []


def test_a_lost_byte_costs_its_own_frame_only():
    three = [encode(n, 1, FOUR) for n in range(3)]
    for at in range(len(three[1])):
        stream = three[0] + three[1][:at] + three[1][at + 1 :] + three[2]
        assert [command.seq for command in Decoder().feed(stream)] == [0, 2]


def test_an_added_byte_costs_at_most_its_own_frame():
    three = [encode(n, 1, FOUR) for n in range(3)]
    for at, byte in itertools.product(range(len(three[1]) + 1), (0x00, 0x06, 0x80, 0xFF)):
        middle = three[1][:at] + bytes([byte]) + three[1][at:]
        read = [command.seq for command in Decoder().feed(three[0] + middle + three[2])]
        assert read == ([0, 1, 2] if three[1] in middle else [0, 2])


def test_a_sync_that_is_none_does_not_hold_up_the_next_frame():
    decoder = Decoder()
    assert decoder.feed(bytes([0x80, 0x80, 93])) == []  # announces a frame of 98 bytes
    assert [command.seq for command in decoder.feed(encode(4, 1, {1: (0.0, 0.0)}))] == [4]


PIECES = st.one_of(
    FRAMES.map(lambda frame: encode(*frame)),
    FRAMES.map(lambda frame: encode(*frame)[:-1]),
    FRAMES.map(lambda frame: encode(*frame)[1:]),
    st.binary(max_size=40),
    st.lists(st.sampled_from([0x80, 0, 3, 6, 9, 93]), max_size=12).map(bytes),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(PIECES, max_size=5).map(b"".join), st.lists(st.integers(1, 30), min_size=1))
def test_the_decoder_reads_what_every_substring_holds_however_the_bytes_are_cut(stream, cuts):
    decoder, read, rest, sizes = Decoder(), [], stream, itertools.cycle(cuts)
    while rest:
        cut = next(sizes)
        read += decoder.feed(rest[:cut])
        rest = rest[cut:]
        assert len(decoder.waiting) <= 98
    assert [as_read(command) for command in read] == read_stream(stream)
    assert read == Decoder().feed(stream)


@given(st.binary(max_size=300), FRAMES)
def test_whatever_came_before_a_whole_frame_is_heard(garbage, frame):
    assert Decoder().feed(garbage + encode(*frame))[-1].seq == frame[0]


def spoilt(stream, changed, lost, rng):
    """A stream of which shares of the bytes are changed at random and lost."""
    kept = (byte for byte in stream if rng.random() >= lost)
    return bytes(rng.randrange(256) if rng.random() < changed else byte for byte in kept)


@pytest.mark.parametrize(
    ("changed", "lost", "least", "most"),
    [
        (0.01, 0.0, 0.78, 0.86),
        (0.0, 0.01, 0.78, 0.86),
        (0.5, 0.0, 0.0, 1e-3),
        (0.0, 0.5, 0.0, 1e-3),
    ],
)
def test_no_wrong_command_gets_through_a_bad_radio(changed, lost, least, most):
    """20 bytes of which 1 % are spoilt: 0.99^20 = 82 % come through; of 50 %: none."""
    rng = random.Random(5)
    sent = {
        n: CommandFrame(n, 1, {a: (rng.randint(-127, 127) / 127, 1.0) for a in (1, 2, 3, 4)})
        for n in range(4000)
    }
    stream = b"".join(encode(*command) for command in sent.values())
    read = Decoder().feed(spoilt(stream, changed, lost, rng))
    assert all(command == sent.get(command.seq) for command in read)
    assert [command.seq for command in read] == sorted({command.seq for command in read})
    assert least <= len(read) / len(sent) <= most
    decoder = Decoder()
    decoder.feed(spoilt(stream, changed, lost, rng))
    assert decoder.feed(encode(9, 2, {}))[-1] == CommandFrame(9, 2, {})


def test_noise_says_nothing():
    noise = random.Random(3).randbytes(300_000)
    assert Decoder().feed(noise) == []
