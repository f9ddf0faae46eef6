"""Whether what the tracking says can be true of cars on a floor: judged for arming and in files.

What can be judged of a car that stands: its top points up, and it does not jump. What shows only
while it drives: its yaw agrees with the direction in which it moves. A quaternion that is written w
first and read w last fails both: it turns about the nose instead of about the top.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

UPRIGHT = 30.0
"""Degrees that the top of a car on a floor may be off the vertical."""
UPRIGHT_SHARE = 0.9
"""Share of the frames in which a car must be upright."""
STRIDE = 0.05
"""Metres after which a direction of motion is taken: a hundred times the noise of the tracking."""
LONGEST_STRIDE = 0.5
"""Seconds that a stride may take: in more, a car may have turned round."""
LEAST_STRIDES = 10
"""Strides from which yaw is judged."""
AGREES = 30.0
"""Degrees that yaw may be off the direction of motion; a slip of wheels makes up to 25."""
AGREEMENT_SHARE = 0.5
"""Share of the strides that must go forwards, and that must go forwards or backwards."""
STEADY = 2.0
"""Degrees of spread below which a yaw counts as constant; tracking has a noise of 0.3."""
ALL_ROUND = 45.0
"""Degrees of spread of the directions of motion from which yaw must have changed too."""
AXES = ("x", "y", "z")


class BodyTrack(NamedTuple):
    """One body of a recording, frame by frame, where it is tracked; n frames."""

    name: str
    number: np.ndarray
    """(n,): the numbers of the frames."""
    time: np.ndarray
    """(n,): s."""
    position: np.ndarray
    """(n, 2): m on the floor."""
    yaw: np.ndarray
    """(n,): rad."""
    up: np.ndarray
    """(m, 3): the room's up in the axes of the body, in all m frames that give an orientation, also
    where that makes the body not tracked; (0, 3) if the recording holds yaw alone."""


@dataclass(frozen=True)
class Vertical:
    """The axis of a body that points up."""

    axis: str
    """With its sign, as -z."""
    tilt: float
    """Its median angle from up, degrees."""
    upright: float
    """Share of the frames in which it is within `UPRIGHT` of up."""


@dataclass(frozen=True)
class YawAgreement:
    """How yaw goes together with the direction of motion, over strides of `STRIDE`."""

    strides: int
    difference: float
    """Circular mean of direction minus yaw, degrees in (-180, 180]."""
    forwards: float
    """Share of the strides whose direction is within `AGREES` of yaw."""
    backwards: float
    """Share of those within `AGREES` of the opposite."""
    yaw_spread: float
    """Circular standard deviation of yaw, degrees."""
    direction_spread: float
    """That of the directions of motion."""


class Jump(NamedTuple):
    """A body is further from where it was than a car can have come."""

    number: int
    """Of the frame in which it is there."""
    distance: float
    """From where it was, m."""


class Swap(NamedTuple):
    """Two bodies change places from one frame to the next."""

    number: int
    one: str
    other: str


@dataclass(frozen=True)
class BodyReport:
    """What there is to say of one body of a recording."""

    frames: int
    """In which it is tracked."""
    vertical: Vertical | None
    """None if the recording holds yaw alone."""
    yaw: YawAgreement | None
    """None if it moves too little to be judged."""
    jumps: tuple[Jump, ...]
    """Without those of two bodies that change places."""
    misread: str
    """Why its orientation cannot be right, in words; empty if it can."""

    @property
    def faults(self) -> list[str]:
        """All that is wrong with it, in words."""
        faults = [self.misread] if self.misread else []
        if self.jumps:
            worst = max(self.jumps, key=lambda jump: jump.distance)
            times = "once" if len(self.jumps) == 1 else f"{len(self.jumps)} times"
            faults.append(
                f"it jumps {times} as no car can, the furthest {worst.distance:.2f} m in frame "
                f"{worst.number}"
            )
        return faults


def reachable_distance[Seconds: (float, np.ndarray)](
    seconds: Seconds, fastest: float, leap: float
) -> Seconds:
    """How far (m) from where it was a car can be seen after a time >= 0, at twice its top speed.

    `fastest` is that speed, m/s; `leap` (m) is what noise and a short gap may add.

    >>> reachable_distance(0.1, fastest=1.0, leap=0.25)
    0.45
    """
    return leap + 2.0 * fastest * seconds


def judge_bodies(
    tracks: Sequence[BodyTrack], top: str, fastest: Mapping[str, float], leap: float
) -> tuple[dict[str, BodyReport], list[Swap]]:
    """A report on every body, by name, and the bodies that change places.

    `top` is the axis of the bodies that is declared to point up, empty if none is; `fastest` (m/s)
    is by name, `leap` as in `reachable_distance`.
    """
    jumps = {track.name: find_jumps(track, fastest[track.name], leap) for track in tracks}
    swaps = find_swaps(tracks, jumps, fastest, leap)
    swapped = {(swap.number, name) for swap in swaps for name in (swap.one, swap.other)}
    reports = {}
    for track in tracks:
        name = track.name
        agreement = compare_yaw(track, {jump.number for jump in jumps[name]})
        reports[name] = BodyReport(
            len(track.number),
            find_vertical(track.up) if len(track.up) else None,
            agreement,
            tuple(jump for jump in jumps[name] if (jump.number, name) not in swapped),
            describe_tilt(track.up, top) or describe_yaw(track, agreement),
        )
    return reports, swaps


def find_vertical(up: np.ndarray) -> Vertical:
    """The axis of a body that points up most, of the room's up (n, 3) in its axes."""
    mean = np.mean(up, axis=0)
    index = int(np.argmax(np.abs(mean)))
    axis = ("-" if mean[index] < 0.0 else "") + AXES[index]
    tilts = tilt_degrees(up, axis)
    return Vertical(axis, float(np.median(tilts)), float(np.mean(tilts <= UPRIGHT)))


def tilt_degrees(up: np.ndarray, axis: str) -> np.ndarray:
    """Angles (n,) of a body's axis, as -z, from the room's up (n, 3) in the body's axes."""
    sign = -1.0 if axis.startswith("-") else 1.0
    return np.degrees(np.arccos(np.clip(sign * up[:, AXES.index(axis[-1])], -1.0, 1.0)))


def describe_tilt(up: np.ndarray, top: str) -> str:
    """Why these orientations (n, 3) are not those of a car with this top; empty if they are."""
    if not len(up):
        return ""
    vertical = find_vertical(up)
    axis = top or vertical.axis
    upright = float(np.mean(tilt_degrees(up, axis) <= UPRIGHT))
    if upright >= UPRIGHT_SHARE:
        return ""
    if vertical.upright >= UPRIGHT_SHARE:
        return f"its axis {vertical.axis} points up, not {axis}"
    return (
        f"its axis {axis} points up in {100 * upright:.0f} % of its frames, and no other axis "
        f"stays vertical"
    )


def describe_yaw(track: BodyTrack, agreement: YawAgreement | None) -> str:
    """Why the yaw of a body is not that of a car that drives; empty if it may be."""
    if agreement is None:
        return ""
    if agreement.yaw_spread < STEADY and agreement.direction_spread > ALL_ROUND:
        yaw = math.degrees(math.atan2(np.sin(track.yaw).mean(), np.cos(track.yaw).mean()))
        return f"its yaw stays {yaw:z.0f} degrees while it moves in many directions"
    forwards, backwards = agreement.forwards, agreement.backwards
    if forwards + backwards < AGREEMENT_SHARE:
        return (
            f"its yaw agrees with its direction of motion in {100 * forwards:.0f} % of its way, "
            f"off by {agreement.difference:z.0f} degrees in the mean"
        )
    if forwards < AGREEMENT_SHARE and backwards > forwards:
        return f"it drives backwards in {100 * backwards:.0f} % of its way"
    return ""


def find_jumps(track: BodyTrack, fastest: float, leap: float) -> list[Jump]:
    """Where a body is seen further from where it was last seen than a car can have come."""
    far = np.hypot(*np.diff(track.position, axis=0).T)
    reach = reachable_distance(np.diff(track.time), fastest, leap)
    return [Jump(int(track.number[k + 1]), float(far[k])) for k in np.flatnonzero(far > reach)]


def find_swaps(
    tracks: Sequence[BodyTrack],
    jumps: Mapping[str, Sequence[Jump]],
    fastest: Mapping[str, float],
    leap: float,
) -> list[Swap]:
    """Pairs of bodies that jump in one frame, each to where the other was."""
    swaps = []
    numbers = {track.name: {jump.number for jump in jumps[track.name]} for track in tracks}
    for track, other in combinations(tracks, 2):
        for number in sorted(numbers[track.name] & numbers[other.name]):
            k, m = (int(np.searchsorted(part.number, number)) for part in (track, other))
            crossed = all(
                math.dist(came.position[to], left.position[at])
                <= reachable_distance(
                    float(came.time[to] - left.time[at]), fastest[came.name], leap
                )
                for came, to, left, at in ((track, k, other, m - 1), (other, m, track, k - 1))
            )
            if crossed:
                swaps.append(Swap(number, track.name, other.name))
    return sorted(swaps)


def compare_yaw(track: BodyTrack, breaks: set[int]) -> YawAgreement | None:
    """How yaw goes together with the direction of motion; None if the body moves too little.

    A stride leads from a frame to the first that is `STRIDE` away; its yaw is the circular mean
    between, which for a car on an arc is the direction of the chord. No stride passes over a frame
    of `breaks`, in which the body jumps.
    """
    directions, yaws = [], []
    x, y, time = track.position[:, 0].tolist(), track.position[:, 1].tolist(), track.time.tolist()
    ahead = np.concatenate([[0.0], np.cumsum(np.cos(track.yaw))])
    aside = np.concatenate([[0.0], np.cumsum(np.sin(track.yaw))])
    start = 0
    for k, number in enumerate(track.number.tolist()):
        if number in breaks or time[k] - time[start] > LONGEST_STRIDE:
            start = k
            continue
        if math.hypot(x[k] - x[start], y[k] - y[start]) < STRIDE:
            continue
        directions.append(math.atan2(y[k] - y[start], x[k] - x[start]))
        yaws.append(math.atan2(aside[k + 1] - aside[start], ahead[k + 1] - ahead[start]))
        start = k
    if len(directions) < LEAST_STRIDES:
        return None
    off = np.array(directions) - np.array(yaws)
    difference = math.degrees(math.atan2(np.sin(off).mean(), np.cos(off).mean()))
    apart = np.abs(np.degrees(np.arctan2(np.sin(off), np.cos(off))))
    return YawAgreement(
        len(directions),
        difference,
        float(np.mean(apart <= AGREES)),
        float(np.mean(apart >= 180.0 - AGREES)),
        circular_spread(np.array(yaws)),
        circular_spread(np.array(directions)),
    )


def circular_spread(angles: np.ndarray) -> float:
    """Circular standard deviation of angles (n,) in rad, in degrees; infinite if all round.

    >>> circular_spread(np.zeros(3)), round(circular_spread(np.array([-0.1, 0.1])), 2)
    (0.0, 5.73)
    """
    length = math.hypot(np.cos(angles).mean(), np.sin(angles).mean())
    return math.degrees(math.sqrt(abs(2.0 * math.log(length)))) if length > 0 else math.inf
