"""Taking the run home: its spec and its state."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable
from concurrent.futures import Future

import viser

from app.results_folder import RUNS_BEGIN
from app.viewer.editing.layout_file import plain_name
from app.viewer.gallery.file_opener import open_file
from app.viewer.gallery.saved_scene import TEXTS, SavedScene
from app.viewer.gallery.tracks_opener import are_tracks
from app.viewer.lab.runs_file import ReadRuns, read_runs
from app.viewer.run.allowance import Allowance
from app.viewer.run.simulation import Simulation
from app.viewer.run.stored_flock import LARGEST, PARQUET, StoredFlock
from worlds.input_error import InputError


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
        await self.send(event, "parquet", self.simulation.save)

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


# Files: a scene is saved under a name; scenes, specs, states and recordings are opened.


class SceneFiles:
    """A name, a button that saves, one that opens; `open` takes what was read, `tell` refusals."""

    def __init__(
        self,
        gui: viser.GuiApi,
        now: Callable[[str], SavedScene],
        open: Callable[[SavedScene | StoredFlock | ReadRuns], None],
        tell: Callable[[str], None],
        open_tracks: Callable[[str, bytes], None],
        allowance: Allowance | None = None,
    ):
        self.allowance = allowance
        self.now, self.open, self.tell, self.open_tracks = now, open, tell, open_tracks
        gui.add_markdown(
            "**Scene**: the run with its view and plots. A scene, a spec, a saved state or a "
            "recording is opened here or by `flockscope lab FILE`, and run without a page by "
            "`flockscope run FILE`. Tracks are opened here, too."
        )
        self.name = gui.add_text("Name", "", hint="What the scene is called")
        save = gui.add_button("Save scene (TOML)", icon=viser.Icon.DOWNLOAD, color="gray")
        opening = gui.add_upload_button(
            "Open a file ...",
            icon=viser.Icon.UPLOAD,
            color="gray",
            hint="A scene or a spec (TOML), a saved state or a recording (Parquet), or tracks, of "
            f"up to {LARGEST // 10**6} MB: replaces the run in all browsers. Runs (JSONL): become "
            "rows of the tab Runs",
        )
        save.on_click(self.save)

        @opening.on_upload
        def _(event: viser.GuiEvent) -> None:
            file = event.target.value
            try:
                if self.allowance is not None and file.content.startswith(PARQUET):
                    self.allowance.demand_recordings(file.name)
                if file.content.startswith(RUNS_BEGIN):
                    self.open(read_runs(plain_name(file.name), file.content))
                elif are_tracks(file.name, file.content):
                    self.open_tracks(file.name, file.content)
                else:
                    self.open(open_file(file.name, file.content))
            except InputError as refusal:
                self.tell(str(refusal))

    async def save(self, event: viser.GuiEvent) -> None:
        """Send the scene to the browser that asked."""
        if event.client is not None:
            try:
                scene = self.now(self.name.value.strip()[: TEXTS["title"]])
            except InputError as refusal:
                self.tell(str(refusal))
                return
            name = re.sub(r"\W+", "-", scene.title.lower()).strip("-") or "scene"
            event.client.send_file_download(
                f"{name}.toml", scene.to_toml().encode(), save_immediately=True
            )
