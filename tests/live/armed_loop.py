"""A control loop that runs on a thread of its own, armed, whose cars need not move."""

from __future__ import annotations

import threading

from app.live.control.arm import OperatorRequest
from app.live.control.car_control import CarControl
from app.live.control.control_loop import Loop
from app.live.control.injected_target import InjectedTarget
from app.live.links.link import RUN, CarLink
from app.live.links.link_catalogue import DryLink
from tests.live.rooms import LAB, Steady, lab
from tests.live.waiting import until

WITHIN = 60.0
ROOM = LAB.replace('body = "blue body"\n', "")


class ArmedLoop:
    """The loop between a feed, or what stands for it, and a link; used with `with`, armed within.

    Its cars are told so little throttle that they need not move.
    """

    def __init__(self, feed, link: CarLink | None = None):
        room = lab(ROOM)
        self.link = link or DryLink()
        self.loop = Loop(
            CarControl(room.safety(), Steady((0.5, 0.1))),
            feed,
            self.link,
            room.addresses,
            InjectedTarget(room.injected, room.area),
        )
        self.thread = threading.Thread(target=self.loop.run)

    def __enter__(self) -> ArmedLoop:
        self.thread.start()
        self.arm()
        return self

    def __exit__(self, *_: object) -> None:
        self.loop.end("the test ends")
        self.thread.join()

    def arm(self) -> None:
        """Arm as soon as nothing is amiss; wait until the cars run."""
        until(self.armed, WITHIN)

    def armed(self) -> bool:
        """Whether the cars run; asks for it where they are not armed."""
        control = self.loop.control
        if control.safety.arm.state == "safe":
            self.loop.ask(OperatorRequest("arm", "test"))
        self.ticks(5)
        return self.runs

    @property
    def runs(self) -> bool:
        """Whether the newest status tells the cars to run."""
        status = self.loop.latest
        return status is not None and status.mode == RUN

    def is_safe(self) -> bool:
        """Whether they stand until a person arms them again."""
        return self.loop.control.safety.arm.state == "safe"

    def ticks(self, count: int) -> None:
        """Wait until the loop has gone on by so many ticks: it lives."""
        goal = self.loop.control.tick + count
        until(lambda: self.loop.control.tick >= goal, WITHIN)

    @property
    def poses(self):
        """The poses that are steered by, by car."""
        return {name: last.pose for name, last in self.loop.control.safety.seen.last.items()}
