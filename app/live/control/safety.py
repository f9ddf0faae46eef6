"""Safety: a pure state machine between the rule and the link that decides what may be sent.

It has no clock, no thread and no device: it is told the time, the frames that came and what the
rule wants, and answers what may be sent. Every stop has its reason:

======== ================================================================ =====================
kind     when                                                             the cars
======== ================================================================ =====================
unseen   a car was not seen for longer than `stale`                       run on once it is seen
unseen   ... and old poses of it come again: somebody hands them out      wait to be armed again
asleep   a car was unseen, or the loop stood still, longer than long_gap  wait to be armed again
frozen   a car does not go where its commands take it                     wait to be armed again
leap     a car is seen where or as it cannot be, for longer than `stale`  wait to be armed again
yaw      a car goes against its nose for longer than `stale`              wait to be armed again
moves    a car moves though it is told to stand; judged armed or not      wait to be armed again
fence    a car is at the fence or beyond it                               wait to be armed again
rule     the rule failed                                                  wait to be armed again
======== ================================================================ =====================
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.live.control.arm import Arm, OperatorRequest
from app.live.control.pose import MocapFrame, Sighting, TrackingArea
from app.live.control.pose_tracker import PoseTracker
from app.live.control.safety_limits import CarLimits, SafetyLimits
from app.live.control.travel import Standstill, Travel
from app.live.links.link import EMERGENCY, RUN, STOP

LONGEST_STEP = 0.05
"""Seconds that the steering may change in at most between two commands."""
STEADY = 2.0
"""Seconds without a jump of any car that must have passed before the cars are armed."""
STILL = (0.0, 0.0)
Command = tuple[float, float]
"""Steering and throttle in [-1, 1]; left and forwards are positive."""


@dataclass(frozen=True)
class StopReason:
    """Why the cars do not run."""

    kind: str
    words: str
    car: str = ""
    """The car that it is about; empty: all."""
    holds: bool = True
    """Whether it takes the arming away."""


@dataclass(frozen=True)
class SafetyDecision:
    """What may be sent to the cars."""

    mode: int
    """0 stop, 1 run, 2 emergency stop."""
    commands: dict[str, Command]
    """By car, all cars; no throttle unless the mode is run."""
    reasons: tuple[StopReason, ...]
    """Why they do not run, or could not be armed."""
    held: bool = False
    """Whether this verdict took the arming away."""


class Safety:
    """Decides, tick by tick, what may be sent; `take_frames` comes before `judge` in each tick.

    `reached`: what is sent reaches the cars that are seen. Else, with a link that sends nothing or
    poses of a recording, nobody can tell a car to stand, and it may move.
    """

    def __init__(
        self,
        limits: SafetyLimits,
        area: TrackingArea,
        cars: Mapping[str, CarLimits],
        bodies: Mapping[str, str] | None = None,
        reached: bool = True,
    ):
        self.limits = limits
        self.area = area
        self.cars = dict(cars)
        self.arm = Arm()
        self.seen = PoseTracker(bodies or {name: name for name in cars}, self.cars, limits.leap)
        self.travels = {name: Travel(car, limits.frozen) for name, car in self.cars.items()}
        self.standstills = {name: Standstill(car) for name, car in self.cars.items() if reached}
        self.sent: dict[str, Command] = dict.fromkeys(self.cars, STILL)
        self.before: float | None = None
        """The time of the last verdict, s."""

    def take_frames(self, now: float, frames: Sequence[MocapFrame]) -> tuple[Sighting, ...]:
        """Take the frames that came; the last poses of all bodies seen within `stale` seconds.

        While unarmed every pose is accepted, also that of a car that is carried.
        """
        if self.seen.take(now, frames, believing=self.arm.state != "armed"):
            for name, pose in self.seen.fresh.items():
                if name in self.travels:
                    self.travels[name].add_pose(now, pose)
                if name in self.standstills:
                    self.standstills[name].add_pose(now, pose)
        return self.seen.sightings(now, self.limits.stale)

    def ask(self, now: float, request: OperatorRequest) -> bool:
        """Carry out a request; whether it changed anything. Raises InputError if it cannot arm."""
        faults = self.faults(now) + self.jump_reasons(now) if request.action == "arm" else []
        changed = self.arm.carry_out(request, [fault.words for fault in faults])
        if changed and request.action == "arm":
            for travel in self.travels.values():
                travel.forget(now)
            self.before = now
        return changed

    def faults(self, now: float) -> list[StopReason]:
        """Why the cars cannot run, as far as their poses show."""
        return [
            *self.moving_reasons(),
            *self.unseen_reasons(now),
            *self.leap_reasons(now),
            *self.fence_reasons(),
        ]

    def judge(
        self, now: float, commands: Mapping[str, Command], failed: str = ""
    ) -> SafetyDecision:
        """What may be sent at `now` (s), given the rule's (steer, throttle) by car.

        A car without a command gets no throttle. `failed` says how the rule failed, if it did.
        """
        reasons = self.faults(now)
        reasons += (
            [StopReason("rule", f"the rule failed: {failed}")]
            if failed
            else nonfinite_reasons(commands)
        )
        if self.arm.state == "armed":
            reasons += (
                self.asleep_reasons(now) + self.stuck_reasons(now) + self.reversed_reasons(now)
            )
        is_held = self.arm.state == "armed" and any(reason.holds for reason in reasons)
        if is_held:
            self.arm.carry_out(OperatorRequest("hold", "safety"))
        if self.arm.state == "emergency":
            mode = EMERGENCY
        else:
            mode = RUN if self.arm.state == "armed" and not reasons else STOP
        self.command(now, commands if mode == RUN else {})
        return SafetyDecision(mode, dict(self.sent), tuple(reasons), is_held)

    def command(self, now: float, commands: Mapping[str, Command]) -> None:
        """The commands to send, within the limits; without one the wheels stay as they are."""
        step = min(max(now - self.before, 0.0), LONGEST_STEP) if self.before is not None else 0.0
        self.before = now
        for name, car in self.cars.items():
            steered, _ = self.sent[name]
            self.sent[name] = limit_command(car, commands.get(name, (steered, 0.0)), steered, step)
            self.travels[name].drive(now, self.sent[name][1])
            if self.travels[name].throttle:
                self.seen.driven.add(name)
            if name in self.standstills:
                self.standstills[name].set_throttle(now, self.sent[name][1])

    def moving_reasons(self) -> list[StopReason]:
        """Cars that move though they are told to stand."""
        return [
            StopReason(
                "moves",
                f"{name} moves though it is told to stand: is it pushed, or does somebody else "
                "send to it?",
                name,
            )
            for name, standstill in self.standstills.items()
            if standstill.moves
        ]

    def unseen_reasons(self, now: float) -> list[StopReason]:
        """Cars that were not seen for too long; a short gap without poses passes by itself."""
        reasons = []
        for name in self.cars:
            age = self.seen.age(name, now)
            if age > self.limits.stale:
                since = "was never seen" if math.isinf(age) else f"was last seen {age:.2f} s ago"
                why = self.seen.why.get(name, "")
                since += f": {why}" if why else ""
                is_repeated = name in self.seen.repeated
                if is_repeated:
                    since += ": old poses of it come again"
                reasons.append(StopReason("unseen", f"{name} {since}", name, holds=is_repeated))
        return reasons

    def asleep_reasons(self, now: float) -> list[StopReason]:
        """Gaps so long that the cars must be armed again."""
        longest = self.limits.long_gap
        reasons = [
            StopReason("asleep", f"{name} was unseen for more than {longest:g} s", name)
            for name in self.cars
            if self.seen.age(name, now) > longest
        ]
        if self.before is not None and now - self.before > longest:
            reasons.append(
                StopReason("asleep", f"the loop stood still for {now - self.before:.2f} s")
            )
        return reasons

    def leap_reasons(self, now: float) -> list[StopReason]:
        """Cars whose body has for too long been seen where, or turned as, they cannot be."""
        reasons = [
            StopReason(
                "leap", f"{name} is seen {far:.2f} m from where it was: is it another car?", name
            )
            for name, far in self.seen.leaps.items()
        ] + [
            StopReason(
                "leap",
                f"{name} is seen turned by {math.degrees(turned):.0f} degrees at once: is its "
                "rigid body the wrong way round?",
                name,
            )
            for name, turned in self.seen.turns.items()
        ]
        return [reason for reason in reasons if self.seen.age(reason.car, now) > self.limits.stale]

    def reversed_reasons(self, now: float) -> list[StopReason]:
        """Cars that have for too long gone against their nose."""
        return [
            StopReason(
                "yaw",
                f"{name} goes against its nose: its rigid body is the wrong way round, or its "
                "motor turns backwards",
                name,
            )
            for name, travel in self.travels.items()
            if travel.against is not None and now - travel.against > self.limits.stale
        ]

    def jump_reasons(self, now: float) -> list[StopReason]:
        """Cars that have lately jumped as no car can, also while unarmed: what sees them errs."""
        return [
            StopReason(
                "leap", f"{name} jumped {far:.2f} m {now - at:.1f} s ago, as no car can", name
            )
            for name, (at, far) in self.seen.jumped.items()
            if now - at <= STEADY
        ]

    def fence_reasons(self) -> list[StopReason]:
        """Cars at the fence or beyond it."""
        reasons = []
        for name in self.cars:
            last = self.seen.last.get(name)
            if last is not None and self.area.distance_inside(last.pose.x, last.pose.y) <= 0.0:
                at = f"({last.pose.x:.2f}, {last.pose.y:.2f}) m"
                reasons.append(StopReason("fence", f"{name} is at the fence: {at}", name))
        return reasons

    def stuck_reasons(self, now: float) -> list[StopReason]:
        """Cars that do not move as commanded."""
        for travel in self.travels.values():
            travel.advance(now)
        still = [name for name, travel in self.travels.items() if travel.is_stuck()]
        if len(still) > 1 and len(still) == len(self.cars):
            return [
                StopReason(
                    "frozen", "no car goes where it is told: tracking is frozen or the link cut"
                )
            ]
        return [
            StopReason(
                "frozen",
                f"{name} does not go where it is told: it is stuck, its tracking frozen or its "
                "link cut",
                name,
            )
            for name in still
        ]


def nonfinite_reasons(commands: Mapping[str, Command]) -> list[StopReason]:
    """Commands that are no finite numbers."""
    return [
        StopReason("rule", f"the rule wants steer = {steer}, throttle = {throttle} of {name}", name)
        for name, (steer, throttle) in commands.items()
        if not (math.isfinite(steer) and math.isfinite(throttle))
    ]


def limit_command(car: CarLimits, command: Command, steered: float, step: float) -> Command:
    """A command within the limits of a car; its steering turns at most `steering_rate` step.

    >>> limit_command(CarLimits(throttle=0.5), (1.0, 2.0), 0.0, 0.01)
    (0.08, 0.5)
    """
    turn = car.steering_rate * step
    steer = min(max(command[0], steered - turn), steered + turn)
    throttle = min(max(command[1], -car.reverse), car.throttle)
    return min(max(steer, -car.steer), car.steer), throttle
