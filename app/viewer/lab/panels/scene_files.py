"""Files: a scene is saved under a name; scenes, specs, states and recordings are opened."""

from __future__ import annotations

import re
from collections.abc import Callable

import viser

from app.viewer.gallery.file_opener import ENDINGS, opened
from app.viewer.gallery.saved_scene import TEXTS, SavedScene
from app.viewer.run.allowance import Allowance
from app.viewer.run.past.stored_flock import LARGEST, PARQUET, StoredFlock
from worlds.input_error import InputError


class SceneFiles:
    """A name, a button that saves, one that opens; `open` takes what was read, `tell` refusals."""

    def __init__(
        self,
        gui: viser.GuiApi,
        now: Callable[[str], SavedScene],
        open: Callable[[SavedScene | StoredFlock], None],
        tell: Callable[[str], None],
        allowance: Allowance | None = None,
    ):
        self.allowance = allowance
        self.now, self.open, self.tell = now, open, tell
        gui.add_markdown(
            "**Scene**: the run with its view and plots. A scene, a spec, a saved state or a "
            "recording is opened here or by `flockscope lab FILE`, and run without a page by "
            "`flockscope run FILE`."
        )
        self.name = gui.add_text("Name", "", hint="What the scene is called")
        save = gui.add_button("Save scene (TOML)", icon=viser.Icon.DOWNLOAD, color="gray")
        opening = gui.add_upload_button(
            "Open a file ...",
            icon=viser.Icon.UPLOAD,
            color="gray",
            mime_type=",".join(ENDINGS),
            hint="A scene or a spec (TOML), a saved state or a recording (Parquet) of up to "
            f"{LARGEST // 10**6} MB; replaces the run in all browsers",
        )
        save.on_click(self.save)

        @opening.on_upload
        def _(event: viser.GuiEvent) -> None:
            file = event.target.value
            try:
                if self.allowance is not None and file.content.startswith(PARQUET):
                    self.allowance.demand_recordings(file.name)
                self.open(opened(file.name, file.content))
            except InputError as refusal:
                self.tell(str(refusal))

    async def save(self, event: viser.GuiEvent) -> None:
        """Send the scene to the browser that asked."""
        if event.client is not None:
            scene = self.now(self.name.value.strip()[: TEXTS["title"]])
            name = re.sub(r"\W+", "-", scene.title.lower()).strip("-") or "scene"
            event.client.send_file_download(
                f"{name}.toml", scene.to_toml().encode(), save_immediately=True
            )
