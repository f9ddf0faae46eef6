"""What steered agents see, and what their actions wish.

They see the nearest agents, their own speed, the goal and what is solid. All of it, and their
actions, are in an agent's own frame: ahead, to the left and, in space, up. Numbers are in [-1, 1].
"""

from __future__ import annotations

import math

import numpy as np

from agents.engine.cache import compile_to_disk
from agents.engine.heeding import edge_of_view
from agents.engine.noise import cos_sin
from agents.inspection import field_of_view
from agents.motion.motion import Motion
from worlds.compilation import compiled
from worlds.queries.surroundings import set_goal, signed_distance

KINDS = 9.0
"""By which the number of a kind is divided, so that it is below 1."""


@compiled
def own_frame(heading, i, frame):
    """Write the axes of the agent of row i into `frame` (dim, dim): ahead, left, up."""
    dim = heading.shape[1]
    for axis in range(dim):
        frame[0, axis] = heading[i, axis]
    if dim == 2:
        frame[1, 0], frame[1, 1] = -heading[i, 1], heading[i, 0]
        return
    x, y = -heading[i, 1], heading[i, 0]
    length = math.sqrt(x * x + y * y)
    if length < 1e-9:  # straight up or down: any side will do
        x, y, length = 0.0, 1.0, 1.0
    frame[1, 0], frame[1, 1], frame[1, 2] = x / length, y / length, 0.0
    frame[2, 0] = frame[0, 1] * frame[1, 2] - frame[0, 2] * frame[1, 1]
    frame[2, 1] = frame[0, 2] * frame[1, 0] - frame[0, 0] * frame[1, 2]
    frame[2, 2] = frame[0, 0] * frame[1, 1] - frame[0, 1] * frame[1, 0]


@compiled
def clipped(value):
    """The value within [-1, 1]."""
    return min(max(value, -1.0), 1.0)


@compiled
def solid_at(surroundings, position, i, frame, axis, step, reach):
    """The distance to what is solid from a step along an axis of an agent's frame, over reach."""
    dim = position.shape[1]
    x = position[i, 0] + step * frame[axis, 0]
    y = position[i, 1] + step * frame[axis, 1]
    z = position[i, 2] + step * frame[axis, 2] if dim == 3 else 0.0
    return clipped(signed_distance(surroundings, x, y, z) / reach)


@compiled
def offset_along(flock, i, j, axis, size, images):
    """How far the nearest image of row j is from row i along an axis, length."""
    d = flock.position[j, axis] - flock.position[i, axis]
    if images[axis]:
        d -= size[axis] * math.floor(d / size[axis] + 0.5)
    return d


@compiled
def see_nearest(flock, i, size, images, reach, edge, near, frame):
    """Write the squares of the distances and the rows of the nearest that row i sees into `near`
    (k, 2); how many."""
    dim, k, count = flock.position.shape[1], near.shape[0], 0
    for j in range(flock.position.shape[0]):
        if j == i or (flock.kind.shape[0] > 0 and flock.kind[j] < 0.0):
            continue
        d2 = ahead = 0.0
        for axis in range(dim):
            d = offset_along(flock, i, j, axis, size, images)
            d2 += d * d
            ahead += d * frame[0, axis]
        if d2 > reach * reach or ahead < edge * math.sqrt(d2):
            continue
        if count == k and d2 >= near[k - 1, 0]:
            continue
        place = count if count < k else k - 1
        while place > 0 and near[place - 1, 0] > d2:
            near[place, 0], near[place, 1] = near[place - 1, 0], near[place - 1, 1]
            place -= 1
        near[place, 0], near[place, 1] = d2, j
        count = min(count + 1, k)
    return count


@compiled
def see_agent(flock, i, size, images, reach, view, surroundings, near, frame, seen):
    """Fill `seen` (width,) with what the agent of row i sees.

    `near` (k, 2) and `frame` (4, 3) are scratch: of the k nearest the squares of the distances and
    the rows; the axes of the agent's frame, and a vector. The goal is where `surroundings` has it.
    Those beyond `reach` (length), outside of the field of view (deg) or with a kind below 0 are not
    seen.
    """
    dim, k = flock.position.shape[1], near.shape[0]
    away = frame[3]
    own_frame(flock.heading, i, frame)
    count = see_nearest(flock, i, size, images, reach, edge_of_view(view), near, frame)
    at = 0
    for n in range(k):
        for axis in range(2 * dim + 2):
            seen[at + axis] = 0.0
        if n < count:
            j = int(near[n, 1])
            for axis in range(dim):
                away[axis] = offset_along(flock, i, j, axis, size, images)
            for row in range(dim):
                place = facing = 0.0
                for axis in range(dim):
                    place += away[axis] * frame[row, axis]
                    facing += flock.heading[j, axis] * frame[row, axis]
                seen[at + row] = clipped(place / reach)
                seen[at + dim + row] = clipped(facing)
            seen[at + 2 * dim] = (flock.kind[j] if flock.kind.shape[0] > 0 else 0.0) / KINDS
            seen[at + 2 * dim + 1] = 1.0
        at += 2 * dim + 2
    seen[at] = clipped(flock.speed[i] / reach)
    at += 1
    for row in range(dim):
        place = 0.0
        if surroundings.route.shape[0] > 0:
            for axis in range(dim):
                place += (surroundings.goal[0, axis] - flock.position[i, axis]) * frame[row, axis]
        seen[at + row] = clipped(place / reach)
    at += dim
    seen[at] = solid_at(surroundings, flock.position, i, frame, 0, 0.0, reach)
    at += 1
    for row in range(dim):
        for side in range(2):
            step = 0.5 * reach * (1.0 - 2.0 * side)
            seen[at] = solid_at(surroundings, flock.position, i, frame, row, step, reach)
            at += 1


def view_width(k: int, dim: int) -> int:
    """How many numbers an agent sees.

    For each of the k nearest its place over the reach and its heading (dim each), the number of its
    kind over 9, and 1 where there is one; then the own speed over the reach in a tick, the place of
    the goal (dim), and the distances to what is solid from the own place and half a reach along
    each axis both ways, over the reach.
    """
    return k * (2 * dim + 2) + 1 + dim + 1 + 2 * dim


@compiled
def wish_of_action(heading, i, action, is_heading, scale, frame, wish):
    """Write what an action (A,) of the agent of row i wishes into `wish` (3,).

    Where the rule wishes a heading an action is how far to turn to the left, in half turns, and in
    space how far up, in quarter turns; else it is the wish over `scale`: ahead, to the left, up.
    Numbers beyond [-1, 1] are cut off. `frame` (4, 3) is scratch.
    """
    dim = heading.shape[1]
    own_frame(heading, i, frame)
    parts = frame[3]
    if is_heading:
        parts[0], parts[1] = cos_sin(math.pi * clipped(action[0]))
        if dim == 3:
            along, up = cos_sin(0.5 * math.pi * clipped(action[1]))
            parts[0], parts[1], parts[2] = along * parts[0], along * parts[1], up
    else:
        for axis in range(dim):
            parts[axis] = scale * clipped(action[axis])
    wish[2] = 0.0
    for axis in range(dim):
        total = 0.0
        for row in range(dim):
            total += parts[row] * frame[row, axis]
        wish[axis] = total


@compile_to_disk
def view_agents(flock, rows, size, images, reach, view, surroundings, time, near, frame, seen):
    """Fill `seen` (S, width) with what the agents of rows (S,) see at a time."""
    set_goal(surroundings, time)
    for s in range(rows.shape[0]):
        see_agent(
            flock, rows[s], size, images, reach, view, surroundings, near, frame, seen[s]
        )  # fmt: skip


@compile_to_disk
def fill_wishes(heading, rows, actions, is_heading, scale, frame, wishes):
    """Fill `wishes` (S, 3) with what actions (S, A) of the agents of rows (S,) wish."""
    for s in range(rows.shape[0]):
        wish_of_action(heading, rows[s], actions[s], is_heading, scale, frame, wishes[s])


class AgentView:
    """What some agents of a flock see of the k nearest and of the world: see `view_width`."""

    def __init__(self, flock: Motion, k: int, agents: int):
        dim = flock.world.dim
        self.flock, self.reach, self.width = flock, flock.reach, view_width(k, dim)
        self.near, self.frame = np.zeros((k, 2)), np.zeros((4, 3))
        self.seen = np.zeros((agents, self.width), np.float32)
        self.size = np.array(flock.world.size, float)
        self.images = np.array(flock.world.images, bool)
        self.view = field_of_view(flock)

    def look(self, rows: np.ndarray) -> np.ndarray:
        """What the agents of rows (S,) see, float32 (S, width)."""
        flock = self.flock
        view_agents(
            flock.arrays,
            np.ascontiguousarray(rows, np.int64),
            self.size,
            self.images,
            self.reach,
            self.view,
            flock.engine.surroundings,
            flock.tick * flock.dt,
            self.near,
            self.frame,
            self.seen,
        )
        return self.seen[: len(rows)].copy()


def numbers_of_action(flock: Motion) -> int:
    """How many numbers an action has: a turn in each way where the rule wishes a heading, else the
    parts of an acceleration or a velocity."""
    dim = flock.world.dim
    return dim - 1 if flock.model.rule.wish == "heading" else dim


def wishes_of_actions(
    flock: Motion, rows: np.ndarray, actions: np.ndarray, scale: float
) -> np.ndarray:
    """The wishes (M, dim) of actions (M, A) of the agents of rows, for `Flock.steer`: see
    `wish_of_action`."""
    wishes = np.zeros((len(rows), 3))
    fill_wishes(
        flock.heading,
        np.ascontiguousarray(rows, np.int64),
        np.ascontiguousarray(actions, float),
        flock.model.rule.wish == "heading",
        scale,
        np.zeros((4, 3)),
        wishes,
    )
    return wishes[:, : flock.world.dim]


def turned_headings(headings: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Headings (M, dim) turned by angles (M, dim - 1), rad: to the left, and in space up."""
    axes = frames_of(headings)
    turn = angles[:, :1]
    turned: np.ndarray = np.cos(turn) * axes[:, 0] + np.sin(turn) * axes[:, 1]
    if axes.shape[1] == 3:
        climb = angles[:, 1:]
        turned = np.cos(climb) * turned + np.sin(climb) * axes[:, 2]
    return turned


def frames_of(headings: np.ndarray) -> np.ndarray:
    """The axes (M, dim, dim) of agents with headings (M, dim): ahead, left, up."""
    left = np.zeros_like(headings)
    left[:, 0], left[:, 1] = -headings[:, 1], headings[:, 0]
    if headings.shape[1] == 2:
        return np.stack([headings, left], axis=1)
    length = np.linalg.norm(left, axis=1, keepdims=True)
    is_upright = length < 1e-9
    left = np.where(is_upright, [0.0, 1.0, 0.0], left / np.where(is_upright, 1.0, length))
    return np.stack([headings, left, np.cross(headings, left)], axis=1)
