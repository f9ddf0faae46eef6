"""What a page asks for whose person steers an agent by hand, several times a second."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import parse_qs

import numpy as np
from aiohttp import web

from app.front.client_addresses import RateLimit
from app.front.http_server import Request, text_response
from app.steering.hand_pilot import MOST_HANDS, HandMotion
from app.viewer.lab.scene_requests import MARK, WORD, SceneRequests
from app.viewer.run.simulation import Simulation
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

STEER, LET_GO = "/steer", "/steer/end"
RATE, AT_ONCE = 20.0, 40.0
"""Messages of one page, a second and at once; the page sends eight and each change."""
TOKEN = re.compile(r"[0-9a-f]{32}")
NUMBER = re.compile(r"[0-9]{1,15}")
SHARE = re.compile(r"-?(0(\.[0-9]{1,6})?|1(\.0{1,6})?)")
"""A number in [-1, 1]."""


class SteerRequests:
    """Answers them: each names its page by a token, the run, the agent and what the hand does."""

    def __init__(self, scenes: SceneRequests, simulation: Simulation):
        self.simulation = simulation
        self.limits: dict[str, RateLimit] = {}
        """How often a page may ask, by its token."""
        scenes.front.route(STEER, lambda request: self.answer(request, self.steer))
        scenes.front.route(LET_GO, lambda request: self.answer(request, self.let_go))

    def answer(self, request: Request, act: Any) -> web.Response:
        """Do what is asked, if it may be."""
        if request.headers.getall(MARK, []) != [WORD]:
            return text_response(403, f"agents are steered with the header {MARK}: {WORD}")
        try:
            asked = parse_qs(request.raw_path.partition("?")[2], max_num_fields=8)
        except ValueError:
            return text_response(400, "more than 8 parameters")
        try:
            token = one_of("who", asked, TOKEN)
            if not self.limit(token).take():
                return text_response(429, f"more than {RATE:g} messages a second")
            act(token, asked)
        except InputError as refusal:
            return text_response(400, str(refusal))
        return text_response(200, "taken")

    def limit(self, token: str) -> RateLimit:
        """How often a page may ask; those that have long been quiet are forgotten."""
        if token not in self.limits and len(self.limits) >= 10 * MOST_HANDS:
            self.limits = {
                one: limit for one, limit in self.limits.items() if limit.fill() < AT_ONCE
            }
        if token not in self.limits and len(self.limits) >= 10 * MOST_HANDS:
            raise InputError("too many pages steer")
        return self.limits.setdefault(token, RateLimit(RATE, AT_ONCE))

    def steer(self, token: str, asked: dict[str, list[str]]) -> None:
        """Steer an agent. Raises InputError."""
        number = int(one_of("n", asked, NUMBER))
        agent = int(one_of("agent", asked, NUMBER))
        run = int(one_of("run", asked, NUMBER))
        motion = HandMotion(*(float(one_of(name, asked, SHARE)) for name in HandMotion._fields))
        demand_steered(self.simulation, run, agent)
        self.simulation.hands.hold(token, agent, motion, number)

    def let_go(self, token: str, asked: dict[str, list[str]]) -> None:
        """Let go of an agent. Raises InputError."""
        self.simulation.hands.let_go(token, int(one_of("n", asked, NUMBER)))


def one_of(name: str, asked: dict[str, list[str]], form: re.Pattern[str]) -> str:
    """The one value of a parameter. Raises InputError."""
    values = asked.get(name, [])
    if len(values) != 1 or not form.fullmatch(values[0]):
        raise InputError(f"{name} is not as it must be")
    return values[0]


def demand_steered(simulation: Simulation, run: int, agent: int) -> None:
    """Raise InputError for an agent that nobody can steer now."""
    frame, state = simulation.frame, simulation.state
    if frame is None or frame.run != run:
        raise InputError("another run has begun")
    if state.preview or state.compiling is not None:
        raise InputError("this is a preview: steer once the model is compiled")
    if state.line is not None and (state.line.recording or state.line.looks_back):
        raise InputError("this is a tick of the past: nobody steers there")
    rows = np.flatnonzero(frame.ids == agent)
    kind = steered_kind(frame, int(rows[0])) if len(rows) else ""
    if not kind:
        raise InputError(f"agent {agent} cannot be steered: its kind is not, or it is gone")
    if simulation.played is not None:
        simulation.played.demand_steering(kind)


def steered_kind(frame: Frame, row: int) -> str:
    """The kind of the agent of a row; empty where that is not steered, or the agent flies no
    more."""
    if frame.kind is None or frame.is_down[row]:
        return ""
    number = int(frame.kind[row])
    kind = frame.kinds.kinds[number - 1] if number > 0 else None
    return kind.name if kind is not None and kind.steered else ""
