"""A tick of many flocks in one compiled call: steer, tick, reward and look, flock by flock.

Each flock's arrays and the arguments of its loop are read from memory, see
`agents.engine.stored_call`; so flocks of several models go through the same code, and the loop is
the one that ticks a flock alone.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from agents.engine import stored_call
from agents.engine.cache import compile_to_disk
from agents.engine.stored_call import call_stored, read_stored, write_word
from agents.motion.agent_view import see_agent, wish_of_action
from app.learning.reward import PlayerTick
from worlds.compilation import compiled
from worlds.queries.surroundings import set_goal

STEER, TICK, GAIN, LOOK = 1, 2, 4, 8
"""What is done with a flock, as bits: its players are steered, it ticks, what they gain is noted,
and what they see."""
DONE, IN_PYTHON, CATCHES, BAD, LOST = range(5)
"""How the tick of a flock has ended: well; it is to be run by Python; somebody may have been
caught, and the tick is to be ended by Python; a position is no number; the only player was caught,
for sure, and the flock ends here if nobody asks what else was."""
CALLER, WORDS, SURROUNDINGS, TICK_AT, NOW, BAD_ROW = range(6)
"""Columns of `BatchTables.codes`: the addresses of the loop's caller (0: there is none), of the
flock's words, of its surroundings and of the tick among them; the tick, and the row that is bad."""
HUNTER, PREY, CATCH, ENDS = range(4)
"""Columns of `BatchTables.catchers`: the kinds of hunters and of prey, how near they must come, and
whether it is over for who is caught."""
REACH, VIEW, LASTS = range(3)
"""Columns of `BatchTables.numbers`: length, deg, time in a tick."""
NEAR = 1e-9
"""Of a square of a distance: who is farther, or nearer, by so much is so after any rounding."""
AWAY, UNSURE, WITHIN = 0, 1, 2
"""How near two agents have come."""


class BatchTables(NamedTuple):
    """What is known of E flocks with M players each, and what a tick gives."""

    codes: np.ndarray
    """int64 (E, 6)."""
    numbers: np.ndarray
    """(E, 3)."""
    size: np.ndarray
    """Sides of each box, (E, 3)."""
    images: np.ndarray
    """Whether others are seen across its seam, bool (E, 3)."""
    is_heading: np.ndarray
    """Whether the flock's rule wishes a heading, bool (E,)."""
    ids: np.ndarray
    """Identities of the players, int64 (E, M)."""
    playing: np.ndarray
    """Which players were steered in the tick, bool (E, M)."""
    rows: np.ndarray
    """Their rows, -1 for who is gone, was caught or has crashed, int64 (E, M)."""
    caught: np.ndarray
    """How many each has caught in the tick, int64 (E, M)."""
    before: np.ndarray
    """Where agents were before the tick, (E, N, 3); (E, 0, 3) where nobody catches."""
    catchers: np.ndarray
    """Who catches whom, (C, 4)."""
    near: np.ndarray
    """Scratch, (k, 2)."""
    frame: np.ndarray
    """Scratch, (4, 3)."""
    seen: np.ndarray
    """float32 (E, M, width)."""
    gained: np.ndarray
    """(E, M)."""
    is_over: np.ndarray
    """Who was caught or has crashed, bool (E, M)."""
    ending: np.ndarray
    """How the tick of each flock has ended, int64 (E,)."""


@compiled
def find_player(flock, identity, guess):
    """The row of an identity, -1 for one that is gone, was caught or has crashed."""
    row = guess
    if row < 0 or row >= flock.ids.shape[0] or flock.ids[row] != identity:
        row = -1
        for i in range(flock.ids.shape[0]):
            if flock.ids[i] == identity:
                row = i
    if row >= 0 and (flock.kind[row] < 0.0 or has_crashed(flock, row)):
        row = -1
    return row


@compiled
def has_crashed(flock, row):
    """Whether the agent of a row has crashed."""
    return flock.crash_record.shape[0] > 0 and flock.crash_record[row, 0] >= 0.0


@compiled
def moved_along(flock, before, i, axis, size, images):
    """How far the agent of a row went in the tick along an axis, the near way round, length."""
    d = flock.position[i, axis] - before[i, axis]
    if images[axis]:
        d -= size[axis] * np.floor(d / size[axis] + 0.5)
    return d


@compiled
def closeness(flock, before, i, j, size, images, reach):
    """Whether rows i and j, which went straight on in the tick, came within reach of each other."""
    approach = length2 = apart2 = 0.0
    for axis in range(flock.position.shape[1]):
        now = flock.position[j, axis] - flock.position[i, axis]
        if images[axis]:
            now -= size[axis] * np.floor(now / size[axis] + 0.5)
        moved = moved_along(flock, before, j, axis, size, images)
        moved -= moved_along(flock, before, i, axis, size, images)
        approach += now * moved
        length2 += moved * moved
        apart2 += now * now
    back = min(max(approach / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    least2 = apart2 - 2.0 * back * approach + back * back * length2
    # The terms cancel to a few units in the last place of the largest of them.
    margin = NEAR * reach * reach + 1e-12 * (apart2 + length2)
    if least2 > reach * reach + margin:
        return AWAY
    return WITHIN if least2 < reach * reach - margin else UNSURE


@compiled
def end_of_hunt(flock, before, catchers, size, images, lone):
    """DONE where no hunter came near its prey; LOST where `lone`, the row of the only player of a
    flock or -1, was caught and nothing else can have been; else CATCHES: `Flock` is to be asked.

    Relations take their turns, so only what happens by the first one in which something does is
    sure. The player is the only agent of its kind, so whoever catches that kind catches it.
    """
    n = flock.ids.shape[0]
    for c in range(catchers.shape[0]):
        is_near = False
        for i in range(n):
            if flock.kind[i] != catchers[c, HUNTER] or has_crashed(flock, i):
                continue
            for j in range(n):
                if flock.kind[j] != catchers[c, PREY] or j == i or has_crashed(flock, j):
                    continue
                near = closeness(flock, before, i, j, size, images, catchers[c, CATCH])
                if near == WITHIN and j == lone and catchers[c, ENDS] > 0.0:
                    return LOST
                is_near = is_near or near != AWAY
        if is_near:
            return CATCHES
    return DONE


@compiled
def steer_players(flock, tables, e, actions, scale):
    """Tell the players of a flock what their actions (M, A) wish; note who plays in this tick."""
    for m in range(tables.ids.shape[1]):
        if not tables.playing[e, m]:
            continue
        row = find_player(flock, tables.ids[e, m], tables.rows[e, m])
        tables.rows[e, m] = row
        if row < 0:
            continue
        wish_of_action(
            flock.heading,
            row,
            actions[m],
            tables.is_heading[e],
            scale,
            tables.frame,
            flock.wish[row],
        )


@compiled
def run_tick(flock, tables, e, codes, is_alone):
    """Run the loop of a flock for one tick; how it has ended.

    `is_alone`: whether nobody but its player asks for the flock.
    """
    if codes[CALLER] == 0:
        return IN_PYTHON
    is_hunt = tables.catchers.shape[0] > 0
    if is_hunt:
        for i in range(flock.position.shape[0]):
            for axis in range(flock.position.shape[1]):
                tables.before[e, i, axis] = flock.position[i, axis]
    write_word(codes[TICK_AT], codes[NOW])
    bad_row = call_stored(codes[CALLER], codes[WORDS])
    if bad_row != -1:
        codes[BAD_ROW] = bad_row
        return BAD
    if is_hunt:
        lone = tables.rows[e, 0] if is_alone and tables.ids.shape[1] == 1 else -1
        size, images = tables.size[e], tables.images[e]
        ending = end_of_hunt(flock, tables.before[e], tables.catchers, size, images, lone)
        codes[NOW] += ending != CATCHES
        return ending
    codes[NOW] += 1
    return DONE


@compiled
def find_players(flock, tables, e):
    """Note who of the players of a tick is where, and for whom it is over."""
    for m in range(tables.ids.shape[1]):
        tables.rows[e, m] = (
            -1
            if not tables.playing[e, m]
            else find_player(flock, tables.ids[e, m], tables.rows[e, m])
        )
        tables.is_over[e, m] = tables.playing[e, m] and tables.rows[e, m] < 0


@compiled
def look_around(flock, surroundings, tables, e):
    """Note what the players of a flock see; those that are gone see nothing: zeros."""
    numbers = tables.numbers[e]
    for m in range(tables.ids.shape[1]):
        seen = tables.seen[e, m]
        row = tables.rows[e, m]
        if row < 0:
            for at in range(seen.shape[0]):
                seen[at] = 0.0
            continue
        see_agent(
            flock,
            row,
            tables.size[e],
            tables.images[e],
            numbers[REACH],
            numbers[VIEW],
            surroundings,
            tables.near,
            tables.frame,
            seen,
        )


@cache
def batch_step(gain: Any) -> Callable[..., None]:
    """The compiled function that takes flocks through a tick, with a reward compiled into it.

    (flocks, place, tables, which, actions, scale, phases, is_alone): `flocks` and `place` are the
    arrays and the surroundings of any flock, for their types; `which` (F,) says which flocks;
    `actions` (E, M, A); `phases` is a sum of STEER, TICK, GAIN and LOOK; `is_alone`: whether nobody
    but the players asks for the flocks. A flock whose tick Python has to end goes no further.
    """

    def step_flocks(flocks, place, tables, which, actions, scale, phases, is_alone):
        for at in range(which.shape[0]):
            e = which[at]
            ending = DONE
            codes = tables.codes[e]
            flock = read_stored(flocks, codes[WORDS])
            surroundings = read_stored(place, codes[SURROUNDINGS])
            if phases & STEER:
                steer_players(flock, tables, e, actions[e], scale)
            if phases & TICK:
                for m in range(tables.ids.shape[1]):
                    tables.caught[e, m] = 0
                ending = tables.ending[e] = run_tick(flock, tables, e, codes, is_alone)
                if ending != DONE and ending != LOST:
                    continue
            set_goal(surroundings, codes[NOW] * tables.numbers[e, LASTS])
            if ending == LOST:
                tables.rows[e, 0], tables.is_over[e, 0] = -1, True
            else:
                find_players(flock, tables, e)
            if phases & GAIN:
                for m in range(tables.ids.shape[1]):
                    tables.gained[e, m] = 0.0
                    if tables.playing[e, m]:
                        tables.gained[e, m] = gain(PlayerTick(flock, surroundings, tables, e, m))
            if phases & LOOK:
                look_around(flock, surroundings, tables, e)

    return compile_to_disk(step_flocks, Path(stored_call.__file__))
