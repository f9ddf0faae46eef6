"""Check that arguments which lie in memory are read as they are, and only as what they are."""

from __future__ import annotations

import numpy as np
import pytest
from numba import typeof

from agents.engine.stored_call import read_stored, store_value, words_of, write_word
from agents.flock import Flock
from worlds.compilation import entry


@entry
def read_back(example, address, out):
    """What lies at an address, written out."""
    value = read_stored(example, address)
    for i in range(value[0].shape[0]):
        for j in range(value[0].shape[1]):
            out[i, j] = value[0][i, j]
    return value[1], value[2][1]


@entry
def overwrite(address, word):
    """Write a word at an address."""
    write_word(address, word)


def test_what_is_stored_is_read_as_it_was():
    table = np.arange(6.0).reshape(3, 2)
    value = table, 2.5, (7, -3)
    words, out = store_value(value), np.zeros((3, 2))
    assert read_back(value, words.ctypes.data, out) == (2.5, -3)
    assert np.array_equal(out, table)
    overwrite(words.ctypes.data + 8 * (len(words) - 1), 11)
    assert read_back(value, words.ctypes.data, out) == (2.5, 11)


@pytest.mark.parametrize(
    "other", [np.zeros((2, 2), np.float32), np.zeros(4), np.zeros((2, 4))[:, ::2]]
)
def test_an_array_of_another_type_is_refused(other):
    with pytest.raises(TypeError, match=r"is no array|is not contiguous"):
        list(words_of(typeof(np.zeros((2, 2))), other))


def test_a_stored_tick_takes_arrays_of_its_own_shapes_alone():
    flock, more = (Flock("vem", agents=n, size=4.0, rng=1) for n in (10, 11))
    flock.restart(1)
    stored = flock.store_tick(1)
    other = flock.arrays._replace(position=flock.position.copy())
    assert stored.takes(other, 5)
    assert stored.words[stored.seed_at] == 5
    assert other.position.ctypes.data in stored.words.tolist()
    assert not stored.takes(more.arrays, 5)
    assert stored.arguments[0] is other


def test_where_python_has_a_part_in_a_tick_there_is_none_to_store():
    words = {"agents": 10, "size": 4.0, "rng": 1}
    assert Flock("vem", **words).store_tick(1) is None  # Mesa may have events
    for more in ({"activation": "random"}, {"delay": 2.0}, {"interpret": True}):
        flock = Flock("vem", **words, **more)
        flock.restart(1)
        assert flock.store_tick(1) is None


def test_a_number_of_another_type_is_refused():
    for kind, value in ((2.5, 2), (2, 2.5), (2, None)):
        with pytest.raises(TypeError, match=r"is no (float|int)64"):
            list(words_of(typeof(kind), value))
