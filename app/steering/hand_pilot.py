"""Agents that people steer by hand: who steers which, and what that wishes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.motion.agent_view import frames_of, turned_headings
from agents.motion.motion import Motion
from worlds.input_error import InputError

SILENCE = 1.0
"""Seconds without a word after which an agent is its rule's again: a dead man's switch."""
MOST_HANDS = 32
"""People who steer at once."""
TURN = 0.05
"""What a hand turns in a tick, half turns: 9 degrees; the body may turn less."""
PUSH = 0.25
"""How much faster a hand wishes to be in a tick, over the flock's middle speed."""


class HandMotion(NamedTuple):
    """What a hand does, each in [-1, 1]."""

    turn: float = 0.0
    """To the left."""
    push: float = 0.0
    """Faster."""
    climb: float = 0.0
    """Up, in space."""


@dataclass(frozen=True)
class Hand:
    """One person at one agent."""

    token: str
    """What the person's page is known by, and nobody else knows."""
    motion: HandMotion
    number: int
    """Of its last message: older ones that come late count no more."""
    heard: float
    """When that came, s."""


def ways_of(wish: str, dim: int) -> tuple[str, ...]:
    """What a hand can do where a rule wishes a heading, a velocity or an acceleration."""
    ways = ("turn",) if wish == "heading" else ("turn", "push")
    return (*ways, "climb") if dim == 3 else ways


class HandPilot:
    """Steers agents as people say, by their identities; any thread may call all but `steer`.

    One person steers an agent. Who is silent for `SILENCE` seconds lets go of it, whatever the
    reason: a window that somebody else is in front of, a connection that is gone.
    """

    fault = ""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self.clock = clock
        self.lock = threading.Lock()
        self.hands: dict[int, Hand] = {}
        """Who steers, by the agent's identity."""
        self.released: set[int] = set()
        """Agents whose rule has yet to be told that they are its again."""
        self.last: dict[str, int] = {}
        """The number of the last message of a token that let go."""

    @property
    def is_active(self) -> bool:
        """Whether a flock is to ask it."""
        return bool(self.hands or self.released)

    @property
    def steered(self) -> frozenset[int]:
        """The identities of agents that somebody steers now."""
        self.let_go_of_silent()
        return frozenset(self.hands)

    def hold(self, token: str, agent: int, motion: HandMotion, number: int) -> None:
        """Steer an agent, or go on with it. Raises InputError if somebody else does."""
        self.let_go_of_silent()
        with self.lock:
            hand = self.hands.get(agent)
            if hand is not None and hand.token != token:
                raise InputError(f"somebody else steers agent {agent}")
            if number <= (hand.number if hand is not None else self.last.get(token, -1)):
                return  # it was sent before what has come already
            if hand is None and len(self.hands) >= MOST_HANDS:
                raise InputError(f"{MOST_HANDS} people steer already: no more can")
            others = [one for one, held in self.hands.items() if held.token == token]
            self.hands[agent] = Hand(token, motion, number, self.clock())
            self.released.discard(agent)
        for other in others:
            if other != agent:
                self.release(other)

    def let_go(self, token: str, number: int) -> None:
        """Give back what a person steers."""
        with self.lock:
            mine = [agent for agent, hand in self.hands.items() if hand.token == token]
            if len(self.last) > 10 * MOST_HANDS:
                self.last.clear()
            self.last[token] = max(number, self.last.get(token, -1))
        for agent in mine:
            self.release(agent)

    def let_go_of_silent(self) -> None:
        """Give back what those steer who have said nothing for too long."""
        now = self.clock()
        with self.lock:
            silent = [agent for agent, hand in self.hands.items() if now - hand.heard > SILENCE]
        for agent in silent:
            self.release(agent)

    def release(self, agent: int) -> None:
        """Give an agent back to its rule."""
        with self.lock:
            hand = self.hands.pop(agent, None)
            if hand is not None:
                self.released.add(agent)
                self.last[hand.token] = max(hand.number, self.last.get(hand.token, -1))

    def begin(self) -> None:
        """Another run begins: nobody steers in it yet."""
        with self.lock:
            self.hands.clear()
            self.released.clear()

    def end_run(self, flock: Motion) -> None:
        """Nothing is left to tell: people see what they steer."""

    def steer(self, flock: Motion) -> None:
        """Write what the steered agents wish in the coming tick; those that are gone are let go."""
        self.let_go_of_silent()
        with self.lock:
            hands, released = dict(self.hands), sorted(self.released)
            self.released.clear()
        rows = {int(one): row for row, one in enumerate(flock.ids.tolist())}
        free = [rows[one] for one in released if one in rows and one not in hands]
        if free:
            flock.steer_rows(np.array(free), np.full((len(free), flock.world.dim), np.nan))
        for gone in [one for one in hands if one not in rows or not flock.active[rows[one]]]:
            del hands[gone]
            self.release(gone)
        if hands:
            mine = np.array([rows[one] for one in hands])
            motions = np.array([hand.motion for hand in hands.values()])
            flock.steer_rows(mine, wishes_of_hands(flock, mine, motions))


def wishes_of_hands(flock: Motion, rows: np.ndarray, motions: np.ndarray) -> np.ndarray:
    """The wishes (M, dim) of hands (M, 3) at the agents of rows, for `Flock.steer_rows`.

    A hand that does nothing wishes to go on as its agent goes.
    """
    turn, push, climb = np.clip(motions, -1.0, 1.0).T
    wish, dim, dt = flock.model.rule.wish, flock.world.dim, flock.dt
    pace = flock.speed[rows] / dt
    moving = flock.speed[flock.speed > 0.0]
    middle = float(np.median(moving)) / dt if len(moving) else 1.0
    angles = np.column_stack([TURN * turn, TURN * climb][: dim - 1])
    if wish == "acceleration":
        axes = frames_of(flock.heading[rows])
        across = np.maximum(pace, PUSH * middle)[:, None] * np.pi * angles / dt
        parts = np.column_stack([PUSH * middle * push / dt, across])
        wishes: np.ndarray = np.einsum("ma,mad->md", parts, axes)
        return wishes
    ahead = turned_headings(flock.heading[rows], np.pi * angles)
    if wish == "heading":
        return ahead
    faster: np.ndarray = np.maximum(0.0, pace + PUSH * middle * push)
    return faster[:, None] * ahead
