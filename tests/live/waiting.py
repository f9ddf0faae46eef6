"""Waiting for what other processes and threads do, and clocks that tests turn by hand."""

import time


def until(happens, within=60.0):
    """Wait until `happens()` is true; fail if that takes more than `within` seconds."""
    give_up = time.monotonic() + within
    while not happens():
        assert time.monotonic() < give_up, "it did not happen"
        time.sleep(0.005)


class HandClock:
    """A clock and an event in one: waiting for the event only turns the clock."""

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now

    def wait(self, seconds):
        self.now += seconds
        return False

    def is_set(self):
        return False
