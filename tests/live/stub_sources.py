"""Sources that behave, hang, fail or die, for the tests of the feed."""

import ctypes
import math
import os
import signal
import time
from dataclasses import dataclass

from app.live.control.pose import MocapFrame, Pose, seen, unseen
from app.live.sources.feed import MEMORY
from worlds.input_error import InputError


@dataclass(frozen=True)
class Stub:
    """`how`: what it does; `frames` frames, 100 a second."""

    how: str = "steady"
    count: int = 1_000_000
    name: str = "stub"
    longest_gap: float = math.inf

    def describe(self):
        return f"stub that is {self.how}"

    def frames(self, stop):
        match self.how:
            case "hung before it connects":
                time.sleep(600.0)
            case "holding the interpreter":
                ctypes.PyDLL(None).sleep(600)
            case "refusing":
                raise InputError("no such host\nas lab")
            case "mistaken":
                raise KeyError("car1")
            case "printing":
                print("hello from the library")
                os.write(1, b"and from its C part\n")
                os.write(2, b"\x1b[31mand its errors\n")
        return self._frames(stop)

    def _frames(self, stop):
        for number in range(self.count):
            if number == 3:
                match self.how:
                    case "hung between frames":
                        time.sleep(600.0)
                    case "holding the interpreter between frames":
                        ctypes.PyDLL(None).sleep(600)
                    case "broken":
                        raise RuntimeError("the camera is gone")
                    case "killed":
                        os.kill(os.getpid(), signal.SIGKILL)
                    case "greedy":
                        bytearray(2 * MEMORY)
                    case "leaving":
                        os._exit(3)
            if stop.wait(0.0 if self.how == "fast" else 0.01):
                return
            car2 = seen("car2", Pose(0.0, 1.0, 0.5)) if number < 2 else unseen("car2")
            car1 = seen("car1", Pose(float(number), 0.0, 0.0))
            yield MocapFrame(number, time.monotonic(), (car1, car2), 0.01 * number)


class LateStub(Stub):
    """Its process begins late: it takes 2 s to be unpacked there."""

    def __reduce__(self):
        return late_stub, ()


def late_stub():
    time.sleep(2.0)
    return LateStub()


class StubSimulator:
    """One car that is as far along x as seconds have passed; `work(seconds)` is done at a step."""

    def __init__(self, work=lambda _: None):
        self.work = work
        self.seconds = 0.0
        self.closed = False

    def advance(self, seconds):
        assert seconds >= self.seconds
        self.work(seconds)
        self.seconds = seconds

    def sightings(self):
        return (seen("car1", Pose(self.seconds, 0.0, 0.0)),)

    def close(self):
        self.closed = True


class Undeclared:
    """A plug-in's source of before `longest_gap`; its frames stop."""

    name = "undeclared"

    def describe(self):
        return "undeclared"

    def frames(self, stop):
        return Stub("hung between frames").frames(stop)
