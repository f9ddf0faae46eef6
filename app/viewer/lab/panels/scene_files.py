"""Scenes as files: saved under a name, and opened again."""

from __future__ import annotations

import re
from collections.abc import Callable

import viser

from app.viewer.gallery.saved_scene import TEXTS, SavedScene, read_scene
from worlds.refusal import Refusal


class SceneFiles:
    """A name, a button that saves, one that opens; `open` takes what was read, `tell` refusals."""

    def __init__(
        self,
        gui: viser.GuiApi,
        now: Callable[[str], SavedScene],
        open: Callable[[SavedScene], None],
        tell: Callable[[str], None],
    ):
        self.now, self.open, self.tell = now, open, tell
        gui.add_markdown(
            "**Scene**: the run with its view and plots. Open it here or by "
            "`flockscope lab FILE.toml`."
        )
        self.name = gui.add_text("Name", "", hint="What the scene is called")
        save = gui.add_button("Save scene (TOML)", icon=viser.Icon.DOWNLOAD, color="gray")
        opening = gui.add_upload_button(
            "Open scene or spec ...",
            icon=viser.Icon.UPLOAD,
            color="gray",
            mime_type=".toml",
            hint="TOML of up to 1 MB; replaces the run in all browsers",
        )
        save.on_click(self.save)

        @opening.on_upload
        def _(event: viser.GuiEvent) -> None:
            file = event.target.value
            try:
                self.open(read_scene(file.name, file.content))
            except Refusal as refusal:
                self.tell(str(refusal))

    async def save(self, event: viser.GuiEvent) -> None:
        """Send the scene to the browser that asked."""
        if event.client is not None:
            scene = self.now(self.name.value.strip()[: TEXTS["title"]])
            name = re.sub(r"\W+", "-", scene.title.lower()).strip("-") or "scene"
            event.client.send_file_download(
                f"{name}.toml", scene.to_toml().encode(), save_immediately=True
            )
