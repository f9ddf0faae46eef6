"""Taking the run home: its spec and its state."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future

import viser

from app.viewer.run.simulation import Simulation


class Downloads:
    """Files that a browser can ask for."""

    def __init__(self, gui: viser.GuiApi, simulation: Simulation):
        self.simulation = simulation
        self.sending = False
        gui.add_markdown("**Picture, film, page that plays**: *Take*, on the picture.")
        gui.add_markdown(
            "**Spec**: model, parameters, world and seed. Run it again with "
            "`flockscope run FILE.toml`. It gives the same numbers if nothing was changed while it "
            "ran; if something was, the file says so."
        )
        spec = gui.add_button("Download spec (TOML)", icon=viser.Icon.FILE_TEXT, color="gray")
        gui.add_markdown(
            "**State**: every agent as it is now. `flockscope run FILE.parquet` and `Flock.load` "
            "go on from it. Of two models side by side both files come as one ZIP."
        )
        state = gui.add_button(
            "Download state (Parquet)", icon=viser.Icon.DATABASE_EXPORT, color="gray"
        )
        spec.on_click(self.send_spec)
        state.on_click(self.send_state)

    async def send_spec(self, event: viser.GuiEvent) -> None:
        await self.send(event, "toml", self.simulation.spec)

    async def send_state(self, event: viser.GuiEvent) -> None:
        await self.send(event, "parquet", self.simulation.saved)

    async def send(self, event: viser.GuiEvent, suffix: str, ask: Callable[[], Future]) -> None:
        """Send what the simulation answers to the browser that asked; one file at a time."""
        if event.client is None or self.sending:
            return
        self.sending = True
        try:
            content = await asyncio.wait_for(asyncio.wrap_future(ask()), timeout=60)
        except Exception:
            return  # What was refused has become a notice.
        finally:
            self.sending = False
        event.client.send_file_download(self.name(suffix), content, save_immediately=True)

    def name(self, suffix: str) -> str:
        """File name that says what is in it."""
        state, frame = self.simulation.state, self.simulation.frame
        tick = 0 if frame is None else frame.tick
        model, beside = state.models
        if beside is not None:
            models = f"{model}-beside-{beside}"
            kind = "specs" if suffix == "toml" else "states"
            return f"{models}-seed{state.spec.seed}-tick{tick}-{kind}.zip"
        return f"{model}-seed{state.spec.seed}-tick{tick}.{suffix}"
