"""The process of many laboratories is killed while twenty students look."""

from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import dataclass, field
from itertools import pairwise

import psutil
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from tests.classroom.running import BUSY, Person, roster, running
from tests.viewer.waiting import until

STUDENTS = 20
RETRY = 0.5
"""Seconds after which somebody who was cut off tries again."""


@dataclass
class Looking:
    """A student who looks, and connects again when their line breaks."""

    person: Person
    came: list[float] = field(default_factory=list)
    """When something came."""
    broke: list[float] = field(default_factory=list)
    """When the line broke."""

    def look(self, over: threading.Event) -> None:
        """Look until it is over."""
        while not over.is_set():
            try:
                with self.person.connect() as line:
                    while not over.is_set():
                        line.recv(timeout=BUSY)
                        self.came.append(time.monotonic())
            except (ConnectionClosed, InvalidHandshake, OSError):
                self.broke.append(time.monotonic())
                over.wait(RETRY)

    def broke_after(self, when: float) -> bool:
        """Whether the line broke after some time: before, somebody may have come too early."""
        return bool(self.broke) and self.broke[-1] > when

    def pause(self, since: float, until_: float) -> float:
        """The longest time without anything, s."""
        times = [since, *(one for one in self.came if since < one < until_), until_]
        return max(later - one for one, later in pairwise(times))


def process_of_many(ours) -> int:
    """The number of the process that serves most pages: one of those with students' flocks."""
    children = psutil.Process(ours.process.pid).children(recursive=True)
    return max(children, key=lambda one: len(one.net_connections("tcp"))).pid


def test_who_was_there_has_pictures_again_and_the_others_notice_nothing(tmp_path, capsys):
    with running(tmp_path, "--workers", "2") as ours:
        teacher = ours.teacher()
        teacher.do("role", role="own")
        all_ = [Looking(ours.student(f"Student {k}")) for k in range(STUDENTS)]
        over = threading.Event()
        threads = [threading.Thread(target=one.look, args=(over,)) for one in all_]
        for one in threads:
            one.start()
        try:
            until(lambda: all(len(one.came) > 50 for one in all_), 2 * BUSY)
            time.sleep(3.0)
            killed = time.monotonic()
            usual = max(one.pause(killed - 3.0, killed) for one in all_)
            os.kill(process_of_many(ours), signal.SIGKILL)
            until(lambda: sum(one.broke_after(killed) for one in all_) == STUDENTS / 2, BUSY)
            lost = [one for one in all_ if one.broke_after(killed)]
            until(lambda: all(one.came[-1] > one.broke[-1] for one in lost), BUSY)
            back = time.monotonic()
            time.sleep(1.0)
        finally:
            over.set()
            for one in threads:
                one.join()
        kept = [one for one in all_ if not one.broke_after(killed)]
        assert len(lost) == len(kept) == STUDENTS / 2
        took = [min(t for t in one.came if t > one.broke[-1]) - killed for one in lost]
        paused = max(one.pause(killed, back + 1.0) for one in kept)
        # Of a busy machine all wait: nobody who was not cut off as long as those who were.
        assert paused < max(5.0, 3 * usual, min(took))
        assert len(roster(teacher)["students"]) == STUDENTS
        with capsys.disabled():
            print(
                f"\n{len(lost)} students have pictures again after {min(took):.1f} to "
                f"{max(took):.1f} s; the other {len(kept)} waited {paused:.2f} s for one at most, "
                f"and {usual:.2f} s before"
            )
