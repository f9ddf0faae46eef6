"""What a process with laboratories does.

Every laboratory is bound to the loopback, at a port that the system chooses, and behind a secret
that others who use the machine do not know.
"""

from __future__ import annotations

import secrets
from dataclasses import replace
from typing import Any

from app.classroom.workers.laboratory_status import LaboratoryStatus, laboratory_status
from app.front.client_addresses import BEHIND_A_FRONT
from app.front.page_front import Front
from app.front.server import open_server
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.step_progress import LessonLead
from app.viewer.lab.scene_requests import SCRIPTS
from app.viewer.run.allowance import Allowance
from app.viewer.watching.watch_page import WatchPage

HOST = "127.0.0.1"
NICENESS = 10
"""Of processes with students' flocks, which run without end: what somebody waits for, such as a
result or a page, comes first where processors are busy."""
ORIGIN = "the class"
"""Where the scenes come from that it is given."""


class Laboratories:
    """The laboratories of one process, by the number of whose they are.

    `allowance`: what each may take; None: everything.
    """

    def __init__(self, allowance: Allowance | None = None) -> None:
        self.allowance = allowance
        self.secret = secrets.token_hex(16)
        self.all: dict[int, Laboratory] = {}
        self.told: dict[int, Any] = {}
        """Of which state of each the scene was told last."""

    def at(self, port: int) -> str:
        """Where the front of the class finds a port."""
        return f"http://{HOST}:{port}/{self.secret}"

    def open(self, whose: int, scene: str, played: str = "") -> str:
        """Open one on a scene, or have it begin with that if it is open; where it is.

        `played`: the kind of agents that its owner plays; empty: all.
        """
        opened = SavedScene.from_toml(scene, ORIGIN)
        if whose in self.all:
            self.all[whose].open_played(opened, played)
        else:
            front = Front(SCRIPTS, secret=self.secret)
            server = open_server(HOST, 0, front, limits=BEHIND_A_FRONT)
            self.all[whose] = Laboratory(
                host=HOST,
                server=server,
                opened=opened,
                waits=True,
                allowance=self.allowance,
                played=played,
            )
        return self.at(self.all[whose].port)

    def watch(self, whose: int) -> str:
        """Open the page of those who watch one; where it is."""
        self.watching = WatchPage(
            self.all[whose], "the teacher", HOST, secret=self.secret, limits=BEHIND_A_FRONT
        )
        return self.at(self.watching.port)

    def close(self, whose: int) -> None:
        """Close one."""
        laboratory = self.all.pop(whose, None)
        if laboratory is not None:
            laboratory.close()

    def scene(self, whose: int) -> str:
        """What one runs now, TOML."""
        return self.all[whose].now().to_toml()

    def changed(self) -> dict[int, str]:
        """The scenes of those that run something else than when this was asked last."""
        found = {}
        for whose, one in self.all.items():
            state = one.simulation.state
            now = state.run, state.spec, state.values, state.beside_values
            if not state.busy and self.told.get(whose) != now:
                self.told[whose] = now
                found[whose] = one.now().to_toml()
        return found

    def seen(self) -> dict[int, LaboratoryStatus]:
        """How all of them stand."""
        return {whose: laboratory_status(one) for whose, one in self.all.items()}

    def draw_at(self, pictures: float) -> None:
        """Draw each so often a second at most."""
        if self.allowance is not None:
            self.allowance = replace(self.allowance, pictures=pictures)
        for one in self.all.values():
            one.drawing.rates = replace(one.drawing.rates, fastest=1.0 / pictures)

    def pause(self, whose: int) -> None:
        """Let one stand."""
        self.all[whose].simulation.pause()

    def lead(self, whose: int, lead: LessonLead) -> None:
        """Show one the step of the class's lesson, or let it go its own way."""
        self.all[whose].lead(lead)

    def go(self, whose: int) -> None:
        """Let one run."""
        self.all[whose].simulation.go()
