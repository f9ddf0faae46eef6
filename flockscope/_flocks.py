"""What `flockscope` promises of flocks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from agents.flock import Flock as RunningFlock
from agents.mesa_interface import Member
from agents.run_records import MissionRecord, Series, fly, follow
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.viewer.notebook_view import NotebookView
    from app.viewer.pictures.flock_picture import FlockPicture

__all__ = [
    "Flock",
    "Member",
    "MissionRecord",
    "Series",
    "fly",
    "follow",
]


class Flock(RunningFlock):
    __doc__ = RunningFlock.__doc__

    def show(
        self,
        height: int = 640,
        *,
        running: bool = False,
        through: str = "auto",
        origin: str | None = None,
    ) -> NotebookView:
        """Open the laboratory on a copy of this flock: in a notebook's cell, or else in a window.

        The copy goes on from this tick; `show(...).flock` is a new flock, as the copy is by then.
        Shown again, from the same flock or the same cell, the laboratory of before is closed.

        height: of the frame, 240 to 4000 pixels. running: whether it runs at once, or waits for
        Go. through: `port`, for browsers of this machine; `proxy`, through the notebook's server,
        which takes jupyter-server-proxy; `auto`: the proxy on a hub, and where the server can be
        reached from elsewhere. origin: of the notebook's page, such as https://hub.example.org,
        where it cannot be found out. Raises InputError.
        """
        from app.viewer.notebook_view import show

        return show(self, height, running=running, through=through, origin=origin)

    def to_html(
        self,
        path: str | Path,
        *,
        live: Literal[True] = True,
        title: str = "",
        overwrite: bool = False,
    ) -> None:
        """Write this flock as one web page that runs it by itself, from the tick where it stands.

        path: ends in .html. live: the page runs the flock; a picture of it as it stands is what
        `picture` draws. title: of the page, by default the model's. overwrite: replace a file.
        Raises InputError for what no page can do, and OSError.
        """
        from app.viewer.lab.flock_page import write_flock_page

        if not live:
            raise InputError("live = False is not allowed: picture() draws a flock as it stands")
        write_flock_page(self, Path(path), title, overwrite)

    def picture(
        self,
        size: tuple[int, int] = (900, 560),
        *,
        colour: str | None = None,
        camera: str = "fixed",
        follow: int | None = None,
        renderer: str = "plain",
    ) -> FlockPicture:
        """Draw this flock as it is; a notebook shows the picture, `save` writes PNG, SVG or PDF.

        size: width and height, each 320 to 8000 pixels. colour: heading, layer, group, speed,
        plain, or what else `flockscope picture --colour` takes; None: as suits the flock. camera:
        fixed, top-down, perspective, side, or follow; follow: the identity of an agent to look at
        closely. renderer: `plain`, or `browser`, as the page shows it, by a Chromium, Chrome or
        Edge of this machine. Raises InputError.
        """
        from app.viewer.pictures.flock_picture import picture

        return picture(self, size, colour=colour, camera=camera, follow=follow, renderer=renderer)
