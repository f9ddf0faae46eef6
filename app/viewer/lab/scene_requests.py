"""What the gallery in a browser asks for by HTTP: the cards, their pictures, and to open one."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from dataclasses import asdict
from functools import lru_cache
from typing import Protocol
from urllib.parse import parse_qs, quote

from aiohttp import web

from app.front.http_server import Request, text_response
from app.front.page_front import Answering, Front
from app.viewer.gallery.saved_scene import SavedScene, command_line, pack_scene, python
from app.viewer.gallery.scene_collection import GalleryCard, cards, find_scene, pictures
from worlds.input_error import InputError

SCRIPTS = ("gallery.js", "take.js", "card.js", "steer.js", "sweep.js", "runs.js")
"""What the page needs to ask, to keep its card beside its agent, to steer that, for sweeps and for
runs."""
GALLERY, OPEN, TAKE = "/gallery.json", "/open", "/scene.json"
MARK, WORD = "X-Flockscope", "scene"
"""A header that no foreign page can send: a browser would ask first whether it may."""
JSON = "application/json"
Finding = Callable[[dict[str, list[str]]], SavedScene]
"""Finds the scene that is asked for, by what stands in the query. Raises InputError."""


class SceneOpener(Protocol):
    """What opens scenes."""

    def open(self, scene: SavedScene) -> None: ...
    def now(self, title: str = "") -> SavedScene: ...
    def browsers(self) -> int: ...


def pictured(picture: bytes) -> Answering:
    """What answers with a picture."""
    return lambda _: web.Response(body=picture, content_type="image/webp")


@lru_cache(maxsize=1)
def listed(shown: tuple[GalleryCard, ...]) -> bytes:
    """Cards as JSON."""
    return json.dumps([asdict(card) for card in shown]).encode()


class SceneRequests:
    """Answers them; opening replaces the run in all browsers, which the page asks about first."""

    def __init__(self, front: Front, laboratory: SceneOpener):
        self.laboratory = laboratory
        self.opening = threading.Lock()
        shown = listed(cards())
        front.route(GALLERY, lambda _: web.Response(body=shown, content_type=JSON))
        self.front = front
        self.opens(OPEN, lambda asked: find_scene(asked.get("scene", [""])[0]))
        front.route(TAKE, self.take)
        for name, picture in pictures().items():
            front.route(f"/gallery/{name}", pictured(picture))

    def opens(self, path: str, find: Finding) -> None:
        """Have requests of a path open the scene that is found for what they ask."""
        self.front.route(path, lambda request: self.open(request, find))

    def open(self, request: Request, find: Finding) -> web.Response:
        """Open the scene that is asked for, and only if it says `sure` where others watch too.

        `new`: it is asked by a page that has yet to connect.
        """
        if request.headers.getall(MARK, []) != [WORD]:
            return text_response(403, f"scenes are opened with the header {MARK}: {WORD}")
        asked = parse_qs(request.raw_path.partition("?")[2])
        if not self.opening.acquire(blocking=False):
            return text_response(429, "another scene is being opened")
        try:
            scene = find(asked)
            others = self.laboratory.browsers() > ("new" not in asked)
            if "sure" in asked or not others:
                self.laboratory.open(scene)
            asks = others and "sure" not in asked
            return web.json_response({"title": scene.title, "asks": asks})
        except InputError as refusal:
            return text_response(400, str(refusal))
        finally:
            self.opening.release()

    def take(self, _: Request) -> web.Response:
        """The run as it is now, in all the ways in which it can be taken along."""
        try:
            scene = self.laboratory.now()
        except InputError as refusal:
            said = {"title": "Tracks", "address": str(refusal), "python": f"# {refusal}"}
            return web.json_response(said | {"command": "flockscope lab --tracks FILE"})
        try:
            address = f"?scene={quote(pack_scene(scene))}"
        except InputError as refusal:
            address = str(refusal)
        said = {
            "title": scene.title,
            "address": address,
            "command": command_line(scene),
            "python": python(scene),
        }
        return web.json_response(said)
