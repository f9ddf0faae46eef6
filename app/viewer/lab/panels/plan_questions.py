"""Asks in the browser that has opened a drawing what it means, where it may mean two things."""

from __future__ import annotations

import asyncio
import html
from collections.abc import Callable, Mapping
from typing import Any

import viser

from app.front.viser_internals import GuiModalHandle
from app.viewer.panels.shell import block
from app.viewer.run.simulation import Simulation
from worlds.readers.drawing_contents import PlanChoice, PlanQuestion
from worlds.readers.join import THICK

Ask = Callable[[PlanQuestion], None]
THINNEST, THICKEST = 0.01, 5.0
"""Walls that can be asked for in the page, m."""


class PlanQuestions:
    """A window with a button for each answer; an answer opens the drawing again, with it.

    There is at most one in each browser, as each holds its file: the last question counts.
    """

    def __init__(self, server: viser.ViserServer, simulation: Simulation):
        self.simulation = simulation
        self.open: dict[int, GuiModalHandle] = {}
        """By browser."""
        server.on_client_disconnect(self.forget_client)

    async def forget_client(self, client: viser.ClientHandle) -> None:
        """A browser has gone, and its question with it."""
        self.open.pop(client.client_id, None)

    def close(self, client: viser.ClientHandle) -> None:
        """Close the question of a browser, if it has one."""
        modal = self.open.pop(client.client_id, None)
        if modal is not None:
            modal.close()

    def open_layout(
        self,
        client: viser.ClientHandle | None,
        name: str,
        content: bytes,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        """Set up the flock in the world of a file, and ask in this browser if it is not clear."""
        options = options or {}
        if client is None:
            self.simulation.edits.open_layout(name, content, options)
            return
        loop = asyncio.get_running_loop()

        def ask(question: PlanQuestion) -> None:
            loop.call_soon_threadsafe(self.ask, client, name, content, options, question)

        self.simulation.edits.open_layout(name, content, options, ask)

    def ask(
        self,
        client: viser.ClientHandle,
        name: str,
        content: bytes,
        options: Mapping[str, Any],
        question: PlanQuestion,
    ) -> None:
        """Open the window."""
        self.close(client)
        modal = client.gui.add_modal("What does this drawing mean?")
        self.open[client.client_id] = modal
        thickness: viser.GuiNumberHandle | None = None
        with modal:
            words = html.escape(str(question).partition(": give ")[0])
            client.gui.add_html(block(f'<div class="fs-question">{words}.</div>'))
            if any(choice.thickness for choice in question.choices):
                thickness = client.gui.add_number(
                    "Thickness of walls, m", THICK, min=THINNEST, max=THICKEST, step=THINNEST
                )
            buttons = [(client.gui.add_button(choice.label), choice) for choice in question.choices]
            cancel = client.gui.add_button("Cancel", color="gray")

        def answer(choice: PlanChoice) -> Callable[[viser.GuiEvent], Any]:
            async def answered(_event: viser.GuiEvent) -> None:
                self.close(client)
                wide = thickness.value if thickness is not None and choice.thickness else None
                self.open_layout(client, name, content, add_answer(options, choice, wide))

            return answered

        async def cancelled(_event: viser.GuiEvent) -> None:
            self.close(client)

        for button, choice in buttons:
            button.on_click(answer(choice))
        cancel.on_click(cancelled)


def add_answer(
    options: Mapping[str, Any], choice: PlanChoice, thickness: float | None
) -> dict[str, Any]:
    """The options of a reading with an answer more.

    >>> add_answer({"unit": "mm"}, PlanChoice("Walls", {"roles": {"wall": ["A"]}}), 0.2)
    {'unit': 'mm', 'roles': {'wall': ['A']}, 'thickness': 0.2}
    """
    roles: dict[str, list[str]] = {
        role: list(layers) for role, layers in options.get("roles", {}).items()
    }
    for role, layers in choice.options.get("roles", {}).items():
        roles.setdefault(role, []).extend(layers)
    merged = {**options, **choice.options, "roles": roles}
    if thickness is not None:
        merged["thickness"] = min(max(float(thickness), THINNEST), THICKEST)
    return merged
