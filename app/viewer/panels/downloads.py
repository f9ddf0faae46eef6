"""Taking the run home: its spec and its state."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future

import viser

from app.viewer.simulation import Simulation


class Downloads:
    """Files that a browser can ask for."""

    def __init__(self, gui: viser.GuiApi, simulation: Simulation):
        self.simulation = simulation
        gui.add_markdown(
            "**Spec**: model, parameters, world and seed. Run it again with "
            "`flockscope run FILE.toml`; it gives the same numbers."
        )
        spec = gui.add_button("Download spec (TOML)", icon=viser.Icon.FILE_TEXT, color="gray")
        gui.add_markdown("**State**: every agent as it is now. `Flock.load` goes on from it.")
        state = gui.add_button(
            "Download state (Parquet)", icon=viser.Icon.DATABASE_EXPORT, color="gray"
        )
        spec.on_click(self.send_spec)
        state.on_click(self.send_state)

    async def send_spec(self, event: viser.GuiEvent) -> None:
        text = await answered(self.simulation.spec())
        send(event.client, self.name("toml"), None if text is None else text.encode())

    async def send_state(self, event: viser.GuiEvent) -> None:
        send(event.client, self.name("parquet"), await answered(self.simulation.saved()))

    def name(self, suffix: str) -> str:
        """File name that says what is in it."""
        state, frame = self.simulation.state, self.simulation.frame
        tick = 0 if frame is None else frame.tick
        return f"{state.start.model}-seed{state.start.seed}-tick{tick}.{suffix}"


async def answered(answer: Future):
    """The answer of a command; None if it was refused, which has become a notice."""
    try:
        return await asyncio.wait_for(asyncio.wrap_future(answer), timeout=30)
    except Exception:
        return None


def send(client: viser.ClientHandle | None, name: str, content: bytes | None) -> None:
    """Send a file to the browser that asked for it."""
    if client is not None and content is not None:
        client.send_file_download(name, content, save_immediately=True)
