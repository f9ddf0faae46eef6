"""What the page asks of sweeps by HTTP: to sweep over a parameter, and to open a run."""

from __future__ import annotations

from http import HTTPStatus
from typing import Protocol
from urllib.parse import parse_qs

from websockets.http11 import Request, Response

from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.scene_requests import MARK, WORD, SceneRequests
from app.viewer.lab.sweeps.laboratory_sweeps import Sweeps
from app.viewer.lab.sweeps.stored_sweeps import scene_of
from app.viewer.web.serving.front import words
from worlds.input_error import InputError

OVER, RUN = "/sweep/over", "/sweep/run"
NONE = "a class makes no sweeps: `flockscope lab` on your own machine does"
LONGEST = 18
"""Figures of a seed."""


class SweepForm(Protocol):
    """What begins sweeps."""

    def sweep_over(self, name: str) -> None: ...


class SweepRequestHandler:
    """Answers them; a run opens as a scene of the gallery does."""

    def __init__(self, scenes: SceneRequests, sweeps: Sweeps, form: SweepForm):
        self.sweeps, self.form = sweeps, form
        scenes.front.route(OVER, self.over)
        scenes.opens(RUN, self.run)

    def over(self, request: Request) -> Response:
        """Have the form begin with a parameter."""
        if request.headers.get_all(MARK) != [WORD]:
            return words(HTTPStatus.FORBIDDEN, f"sweeps are asked for with {MARK}: {WORD}")
        asked = parse_qs(request.path.partition("?")[2])
        try:
            self.form.sweep_over(asked.get("name", [""])[0])
        except InputError as refusal:
            return words(HTTPStatus.BAD_REQUEST, str(refusal))
        return words(HTTPStatus.OK, "chosen")

    def run(self, asked: dict[str, list[str]]) -> SavedScene:
        """The run of a cell of a sweep that is listed. Raises InputError."""
        folder = self.sweeps.folder(asked.get("sweep", [""])[0])
        place = whole("cell", asked.get("cell", [""])[0])
        seed = whole("seed", asked["seed"][0]) if "seed" in asked else None
        return scene_of(folder, place, seed, self.sweeps.column)


def refuse_sweeps(scenes: SceneRequests) -> None:
    """Refuse what pages ask of sweeps where there are none."""
    for path in (OVER, RUN):
        scenes.front.route(path, lambda _: words(HTTPStatus.FORBIDDEN, NONE))


def whole(name: str, text: str) -> int:
    """A whole number of a query. Raises InputError."""
    if not (text.isascii() and text.isdigit() and len(text) <= LONGEST):
        raise InputError(f"{name} = {text[:40]!r} is no number")
    return int(text)
