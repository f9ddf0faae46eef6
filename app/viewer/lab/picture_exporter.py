"""What a page gives to take along: what a browser sees, as a picture or a film, with what it means;
or the flock as a page that runs by itself.

A browser asks by HTTP, with a name that only its own connection was told; what is made for it comes
through that connection.
"""

from __future__ import annotations

import re
import secrets
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import parse_qs

import numpy as np
import viser
from aiohttp import web
from PIL import Image

from agents.catalogue import FILES, MODELS
from app.front.client_addresses import RateLimit
from app.front.http_server import Request, text_response
from app.front.renders import MOST, RenderCamera
from app.front.server import front_of, renders_of
from app.processes import ChildProcess
from app.viewer.lab.flock_page import PageWriter
from app.viewer.measuring.observable_format import format_thousands
from app.viewer.panels.sending import ExportPermit
from app.viewer.pictures import key
from app.viewer.pictures.browser import SeenSheet, as_png
from app.viewer.pictures.film_writer import CODECS, Encoder, demand_film
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.player import LIGHT, Player
from app.viewer.pictures.shot import Shot, WatchedFlock
from app.viewer.run.simulation import Simulation
from app.viewer.scene.draw.drawn_frame import picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.drawing import Drawing
from worlds.input_error import InputError

# Films of what one browser sees, from when it says so until it says stop: its own pictures, in its
# own time, encoded in a process of its own; or the frames themselves, for a page that plays them.

FPS = 20.0
"""Pictures a second: as many are drawn as the browser can, the rest are the last again."""
LONGEST = 180.0
"""Seconds of a film at most."""
LARGEST = 48_000_000
"""Bytes of a film at most: it is sent through the line that the page has."""
GAP = 5.0
"""Seconds at most that a picture stays where the browser draws no other."""
PAGE = ".html"
TIMEOUT = 600.0
"""Seconds that a page may take: on a busy machine it is compiled for minutes."""


class FilmSource(Protocol):
    """What a film is made of."""

    def shot(self) -> Shot: ...
    def aspect(self) -> float: ...
    def where(self) -> Any: ...
    def picture(self, sheet: SeenSheet, shot: Shot) -> np.ndarray: ...


class FilmRecorder(threading.Thread):
    """One film in the making; `done` is given its kind and bytes, or `failed` why there is none."""

    def __init__(
        self,
        eyes: FilmSource,
        kind: str,
        size: tuple[int, int],
        done: Callable[[bytes], None],
        failed: Callable[[str], None],
    ):
        super().__init__(name="filming", daemon=True)
        self.eyes, self.kind, self.size = eyes, kind, size
        self.done, self.failed = done, failed
        self.ending = threading.Event()
        self.is_wanted = True
        self.begun = time.monotonic()
        self.bytes = 0
        self.cut = ""
        """What ended it before anybody did, in words."""

    @property
    def seconds(self) -> float:
        """How long it is by now."""
        return time.monotonic() - self.begun

    def stop(self, is_wanted: bool = True) -> None:
        """End it; unless it is wanted nothing comes of it."""
        self.is_wanted = self.is_wanted and is_wanted
        self.ending.set()

    def run(self) -> None:
        try:
            made = self.frames() if self.kind == PAGE else self.film()
            if self.is_wanted:
                self.done(made)
        except InputError as refusal:
            self.failed(str(refusal))
        except Exception as error:
            self.failed(f"the film cannot be made: {type(error).__name__}")

    def note_cut(self, why: str) -> None:
        """It ends now though nobody has stopped it."""
        self.cut = f"The film ends after {self.seconds:.0f} s: {why}."

    def goes_on(self, due: float) -> bool:
        """Wait for the next picture; whether there is to be one."""
        if self.seconds > LONGEST:
            self.note_cut(f"none is longer than {LONGEST:g} s")
        elif self.bytes > LARGEST:
            self.note_cut(f"none has more than {LARGEST // 10**6} MB")
        return not self.cut and not self.ending.wait(max(0.0, due - time.monotonic()))

    def film(self) -> bytes:
        """Pictures until the end, as a film. Raises InputError."""
        with tempfile.TemporaryDirectory(prefix="flockscope-page-film-") as folder:
            path = Path(folder) / f"film{self.kind}"
            with Encoder(path, self.size, FPS) as encoder:
                self.pictures(encoder)
                if not self.is_wanted:
                    raise InputError("the film is discarded")
            return path.read_bytes()

    def pictures(self, encoder: Encoder) -> None:
        """Have pictures drawn and written. Raises InputError."""
        sheet: SeenSheet | None = None
        picture: np.ndarray | None = None
        laid_out: Any = None
        shot, where, written = self.eyes.shot(), None, 0
        self.begun = time.monotonic()
        while self.goes_on(self.begun + written / FPS):
            before, shot = (shot.made.frame, where), self.eyes.shot()
            where, wanted = self.eyes.where(), layout(shot, self.eyes.aspect())
            is_new = sheet is None or wanted != laid_out or sheet.sheet.is_outgrown_by(shot)
            if sheet is None or is_new:
                sheet, laid_out = SeenSheet(shot, self.size, wanted[-1], None), wanted
            if picture is None or is_new or before[0] is not shot.made.frame or before[1] != where:
                picture = self.eyes.picture(sheet, shot)
            due = int(self.seconds * FPS) + 1
            for _ in range(min(max(due - written, 1), round(GAP * FPS))):
                encoder.add(picture)
            written = max(due, written + 1)
            self.bytes = encoder.made.stat().st_size if encoder.made.exists() else 0

    def frames(self) -> bytes:
        """Frames until the end, as a page that plays them. Raises InputError."""
        shot = self.eyes.shot()
        begun, first, last, taken, then = time.monotonic(), shot, None, 0, 0.0
        with Player(LIGHT) as player:
            due = begun
            while self.goes_on(due):
                if taken * len(shot.now.ids) >= LIGHT:
                    agents = format_thousands(len(shot.now.ids))
                    self.note_cut(f"as HTML {taken} pictures of {agents} agents fit")
                    break
                due = time.monotonic() + 1.0 / FPS
                shot = self.eyes.shot()
                if last is not None and shot.made.frame is last.made.frame:
                    continue
                now = self.seconds
                player.add(shot.made.frame, shot.made.look, now - then)
                last, then, taken = shot, now, taken + 1
            last = last or first
            words = [key.caption(first), key.changes(first)]
            words.append(f"ticks {first.now.tick} to {last.now.tick}")
            told = " · ".join(word for word in words if word)
            return player.page(key.title(first), told, max(self.seconds - then, 0.5))


def layout(shot: Shot, aspect: float) -> tuple[Any, ...]:
    """What a sheet is laid out for: another needs a new one."""
    look, frame = shot.made.look, shot.made.frame
    return frame.run, look.colour, look.measured, key.changes(shot), round(aspect, 1)


PATH = "/take.json"
MARK, WORD = "X-Flockscope", "scene"
"""A header that no foreign page can send."""
DOTS = ".png"
VECTORS = (".svg", ".pdf")
LEAST, MOST_DOTS, MOST_OF_FILM = 320, 3840 * 2160, 1920 * 1200
"""Pixels of a side of a picture at least, of a whole picture, and of a film."""
ASKS = (0.5, 4.0)
"""Pictures and films that one browser may ask for, a second and at once."""
AT_ONCE = 3
"""Pictures and films that are in the making at the same time, of all browsers."""
COARSEST = 0.5
"""How coarsely a browser draws at least, dots of its canvas to a dot of its page."""


class ExportedLaboratory(Protocol):
    """The laboratory that is seen."""

    server: viser.ViserServer
    simulation: Simulation
    drawing: Drawing


@dataclass
class ExportClient:
    """One browser's, as long as it is there."""

    client: viser.ClientHandle
    asks: RateLimit = field(default_factory=lambda: RateLimit(*ASKS))
    is_busy: bool = False
    """Whether a picture or a page is being made for it."""
    filming: FilmRecorder | None = None
    dark: bool = False
    dots: float = 1.0
    said: str = ""
    """What has gone wrong last, until it is told."""
    cut: str = ""
    """Why the last film is shorter than was asked for, until it is told."""


class PictureExporter:
    """Answers what pages ask for."""

    def __init__(self, laboratory: ExportedLaboratory, allowed: ExportPermit | None = None):
        self.laboratory = laboratory
        self.allowed = allowed or ExportPermit()
        self.visits: dict[str, ExportClient] = {}
        server = laboratory.server
        front_of(server).route(PATH, self.answer)
        server.on_client_connect(self.welcome)
        server.on_client_disconnect(self.farewell)

    async def welcome(self, client: viser.ClientHandle) -> None:
        """Tell a browser the name by which it may ask."""
        name = secrets.token_urlsafe(16)
        self.visits[name] = ExportClient(client)
        client.gui.add_html(f'<i data-fs-me="{name}"></i>', visible=False)

    async def farewell(self, client: viser.ClientHandle) -> None:
        """Make nothing more for a browser that is gone."""
        for name, visit in list(self.visits.items()):
            if visit.client.client_id == client.client_id:
                del self.visits[name]
                if visit.filming is not None:
                    visit.filming.stop(is_wanted=False)

    def answer(self, request: Request) -> web.Response:
        """Do what is asked, and say how it stands."""
        if request.headers.getall(MARK, []) != [WORD]:
            return text_response(403, f"pictures are asked for with {MARK}: {WORD}")
        asked = {name: one[0] for name, one in parse_qs(request.raw_path.partition("?")[2]).items()}
        visit = self.visits.get(asked.get("me", ""))
        if visit is None:
            return text_response(403, "this page is not connected")
        try:
            self.do(visit, asked)
        except InputError as refusal:
            return text_response(400, str(refusal))
        return web.json_response(self.told(visit))

    def do(self, visit: ExportClient, asked: dict[str, str]) -> None:
        """What a page asks for. Raises InputError."""
        visit.dark = asked.get("theme") == "dark"
        visit.dots = coarseness(asked.get("dots", "1"))
        what = asked.get("do", "")
        if what in ("stop", "discard"):
            if visit.filming is not None:
                visit.filming.stop(is_wanted=what == "stop")
        elif what in ("picture", "film"):
            self.begin(visit, what, asked)
        elif what == "page":
            self.begin_page(visit)
        elif what:
            raise InputError(f"do = {what[:20]!r} is not one of picture, film, page, stop, discard")

    def begin(self, visit: ExportClient, what: str, asked: dict[str, str]) -> None:
        """Begin to make a picture or a film. Raises InputError."""
        kinds = (DOTS, *VECTORS) if what == "picture" else (*CODECS, PAGE)
        kind = f".{asked.get('kind', '')}"
        if kind not in kinds:
            raise InputError(
                f"kind = {kind[1:20]!r} is not one of {', '.join(k[1:] for k in kinds)}"
            )
        if what == "film":
            self.allowed.demand_film()
        size = pixels(asked.get("size", ""), MOST_DOTS if what == "picture" else MOST_OF_FILM)
        self.demand_free(visit)
        eyes = BrowserCapture(self.laboratory, visit)
        shot = eyes.shot()
        if kind in VECTORS:
            demand_plan(shot, kind)
        visit.said = ""
        if what == "film":
            if kind in CODECS:
                demand_film("a film")
            self.film(visit, eyes, kind, size)
        else:
            visit.is_busy = True
            threading.Thread(
                target=self.take, args=(visit, eyes, shot, kind, size), name="picture", daemon=True
            ).start()

    def demand_free(self, visit: ExportClient) -> None:
        """Refuse what comes too often, or too much at once. Raises InputError."""
        if visit.is_busy or visit.filming is not None:
            raise InputError("one thing at a time: it is being made")
        busy = sum(one.is_busy or one.filming is not None for one in list(self.visits.values()))
        if busy >= AT_ONCE or not visit.asks.take():
            raise InputError("others are being made: try again in a few seconds")
        self.allowed.demand_file()

    def begin_page(self, visit: ExportClient) -> None:
        """Begin to write the page of the flock. Raises InputError."""
        self.allowed.demand_page()
        self.demand_free(visit)
        visit.said, visit.is_busy = "", True
        threading.Thread(target=self.take_page, args=(visit,), name="page", daemon=True).start()

    def take_page(self, visit: ExportClient) -> None:
        """Write the page of the flock, or of both, and send it."""
        with self.delivering(visit, "page"):
            simulation, tick = self.laboratory.simulation, 0
            request: tuple[Any, ...]
            if simulation.state.models[1] is None:
                request = "write", simulation.spec().result(TIMEOUT).decode()
            else:
                flocks = simulation.flocks().result(TIMEOUT)
                request, tick = ("write_pair", *flocks), flocks[0].tick
            name, files = self.name(PAGE, tick), [str(file) for file in FILES.values()]
            with ChildProcess(PageWriter, files, stderr=subprocess.DEVNULL) as child:
                page: str = child.ask(*request, timeout=TIMEOUT).result()
            visit.client.send_file_download(name, page.encode(), save_immediately=True)

    @contextmanager
    def delivering(self, visit: ExportClient, what: str) -> Iterator[None]:
        """Within it a file is made for a browser, which is told why where there is none."""
        try:
            yield
        except InputError as refusal:
            visit.said = str(refusal)
        except Exception as error:
            visit.said = f"the {what} cannot be made: {type(error).__name__}"
        finally:
            visit.is_busy = False

    def film(
        self, visit: ExportClient, eyes: BrowserCapture, kind: str, size: tuple[int, int]
    ) -> None:
        """Film what a browser sees from now on."""

        def done(made: bytes) -> None:
            visit.client.send_file_download(self.name(kind), made, save_immediately=True)
            visit.cut = visit.filming.cut if visit.filming else ""
            visit.filming = None

        def failed(why: str) -> None:
            visit.said, visit.filming = (
                why if visit.filming and visit.filming.is_wanted else "",
                None,
            )

        visit.filming = FilmRecorder(eyes, kind, size, done, failed)
        visit.filming.start()

    def take(
        self,
        visit: ExportClient,
        eyes: BrowserCapture,
        shot: Shot,
        kind: str,
        size: tuple[int, int],
    ) -> None:
        """Make a picture and send it."""
        with self.delivering(visit, "picture"):
            with self.allowed.take_turn():
                if kind in VECTORS:
                    made = Sheet(shot, size).as_bytes(kind)
                else:
                    eye = RenderCamera.of(visit.client.camera)
                    sheet = SeenSheet(shot, size, eyes.aspect(), eye)
                    made = as_png(eyes.picture(sheet, shot))
            visit.client.send_file_download(
                self.name(kind, shot.now.tick), made, save_immediately=True
            )

    def told(self, visit: ExportClient) -> dict[str, Any]:
        """How it stands with a browser."""
        filming, said, cut = visit.filming, visit.said, visit.cut
        visit.said = visit.cut = ""
        drawn = self.laboratory.drawing.drawn
        agents = max(1, len(drawn[0].ids)) if drawn else 1
        return {
            "busy": visit.is_busy,
            "filming": filming is not None,
            "ending": filming is not None and filming.ending.is_set(),
            "seconds": 0.0 if filming is None else filming.seconds,
            "bytes": 0 if filming is None else filming.bytes,
            "said": said,
            "cut": cut,
            "html_seconds": min(LONGEST, LIGHT / agents / FPS),
            "flat": drawn is not None and drawn[0].dim == 2 and drawn[0].beside is None,
            "pair": self.laboratory.simulation.state.models[1] is not None,
            "missing": missing(),
        }

    def name(self, kind: str, tick: int | None = None) -> str:
        """File name that says what is in it; without a tick, of what is drawn."""
        state, drawn = self.laboratory.simulation.state, self.laboratory.drawing.drawn
        if tick is None:
            tick = drawn[0].tick if drawn else 0
        return (
            f"{'-beside-'.join(filter(None, state.models))}-seed{state.spec.seed}-tick{tick}{kind}"
        )


@dataclass
class BrowserCapture:
    """What one browser sees."""

    laboratory: ExportedLaboratory
    visit: ExportClient

    def shot(self) -> Shot:
        """The flock as it was drawn last. Raises InputError if nothing was."""
        drawn = self.laboratory.drawing.drawn
        if drawn is None:
            raise InputError("nothing has been drawn yet")
        frame, look = drawn
        state = self.laboratory.simulation.state
        model = MODELS[state.spec.model]
        known = {
            name: one for name, one in state.values.items() if name in model.parameters.model_fields
        }
        now = WatchedFlock(model, known, state.spec.seed, frame)
        return Shot(now, picture(frame, look, Stage.of(frame)))

    def aspect(self) -> float:
        """Width over height of its canvas."""
        camera = self.visit.client.camera
        return float(np.clip(camera.image_width / max(camera.image_height, 1), 0.4, 3.0))

    def where(self) -> tuple[Any, ...]:
        """Where its camera is, and how it looks."""
        camera = self.visit.client.camera
        return tuple(camera.position), tuple(camera.wxyz), camera.fov, self.visit.dark

    def picture(self, sheet: SeenSheet, shot: Shot) -> np.ndarray:
        """What it draws, on a sheet. Raises InputError."""
        return sheet.picture(shot, self.render, self.visit.dark)

    def render(self, size: tuple[int, int]) -> np.ndarray:
        """What it draws; where it draws coarsely, a larger picture made smaller. Raises
        InputError."""
        finer = min(1.0 / self.visit.dots, MOST / max(size))
        asked = tuple(round(side * max(finer, 1.0)) for side in size)
        seen = renders_of(self.laboratory.server).ask(
            self.visit.client, (asked[0], asked[1]), exact=self.visit.filming is None
        )
        if asked == size:
            return seen
        return np.asarray(Image.fromarray(seen).resize(size, Image.Resampling.LANCZOS))


def coarseness(text: str) -> float:
    """Dots of a canvas to a dot of the page, of what a page says; 1 for what is none."""
    try:
        value = float(text)
    except ValueError:
        return 1.0
    return min(max(value, COARSEST), 1.0) if value == value else 1.0


def pixels(text: str, most: int) -> tuple[int, int]:
    """Width and height of WIDTHxHEIGHT. Raises InputError."""
    found = re.fullmatch(r"(\d{2,5})x(\d{2,5})", text)
    size = (int(found[1]), int(found[2])) if found else (0, 0)
    if min(size) < LEAST or max(size) > MOST or size[0] * size[1] > most:
        raise InputError(
            f"size = {text[:20]!r} is not allowed: WIDTHxHEIGHT of {LEAST} to {MOST} pixels, "
            f"{format_thousands(most)} in all"
        )
    return size


def demand_plan(shot: Shot, kind: str) -> None:
    """Refuse a vector picture of what is no plan. Raises InputError."""
    frame = shot.made.frame
    if frame.dim == 3 or frame.beside is not None:
        what = "a world in space" if frame.dim == 3 else "two flocks beside each other"
        raise InputError(f"{kind[1:].upper()} of {what} is not drawn: take PNG")


def missing() -> str:
    """What is to be installed before there can be films; empty: nothing."""
    try:
        demand_film("a film")
    except InputError as refusal:
        return str(refusal)
    return ""
