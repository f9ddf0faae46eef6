"""Ends of a room whose cars are tracked by datagrams and drive round; some go wrong."""

from __future__ import annotations

import json
import resource
import socket
import time
from itertools import count

from app.live.control.pose import MocapFrame, Pose, seen
from app.live.laboratory.lab_file import Lab
from app.live.links.link_catalogue import open_link
from app.live.operating.loop_process import LoopComponents
from live.rooms import ROUND, Steady

MOST_BYTES = 100_000
"""Of a file, where the disk is full."""
HOUR = 3600.0


class Told:
    """A feed of poses that come in datagrams, with the time at which they were seen."""

    trouble = ""

    def __init__(self, port):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.number = -1

    def since(self, _number):
        frames = []
        while True:
            try:
                received, poses = json.loads(self.socket.recv(4096))
            except BlockingIOError:
                return frames
            self.number += 1
            cars = tuple(seen(name, Pose(*at)) for name, at in poses.items())
            frames.append(MocapFrame(self.number, received, cars))


def circling(lab: Lab) -> LoopComponents:
    """Nothing goes wrong."""
    port = int(lab.source.partition(":")[2])
    return LoopComponents(Told(port), open_link(lab.link), Steady(ROUND))


def crowded(lab: Lab) -> LoopComponents:
    """No file of this process can become long: the disk is soon full."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_BYTES, MOST_BYTES))
    return circling(lab)


def jumping(lab: Lab) -> LoopComponents:
    """The time of day jumps an hour back and forth whenever this process asks for it."""
    asked, told = count(), time.time

    def jumpy():
        return told() + (HOUR if next(asked) % 2 else -HOUR)

    time.time = jumpy
    return circling(lab)
