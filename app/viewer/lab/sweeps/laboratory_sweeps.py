"""The sweeps of a laboratory: begun, stopped, gone on with, and looked at while they run.

A thread of its own reads the stores, so that neither the flock nor the picture ever waits, and no
more often than it can afford: what the page shows is replaced as a whole.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol
from urllib.parse import parse_qs

from aiohttp import web

from agents.catalogue import FILES, MODELS
from agents.observables.catalogue import OBSERVABLES
from app.front.http_server import Request, text_response
from app.studies.key_lines import KeyLocations
from app.studies.runs.database import FILE
from app.studies.runs.store import is_locked
from app.studies.runs.store_reader import StoreReader
from app.studies.study_runner import SPEC, STOP
from app.studies.sweeps.checked_sweep import check_file
from app.studies.sweeps.sweep_file import SweepFile
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.scene_requests import MARK, WORD, SceneRequests
from app.viewer.lab.sweeps.stored_sweeps import (
    DrawnSweep,
    ListedSweep,
    listed,
    named_in,
    read_drawn_sweep,
    scene_of,
)
from app.viewer.lab.sweeps.sweep_chart import picture
from app.viewer.lab.sweeps.sweep_request import (
    MOST_BEGUN,
    NICE,
    WORLD,
    SweepSource,
    demand,
    workers,
)
from worlds.file_writer import write_text
from worlds.input_error import InputError
from worlds.layout import layout_names
from worlds.text_file import read_text, toml

# The process that makes the runs: the same command as on the command line, apart from the page.
#
# It has a session of its own, so that neither Ctrl-C in the laboratory's terminal nor the end of
# the laboratory ends it: `flockscope sweep stop`, the page, or another laboratory does.

MESSAGES = "messages.txt"
"""What the command has to say, beside the runs."""
ENDS = (0, 3)
"""Exit codes of a sweep that came to its end: whole, and with runs that failed."""
OF_LINES = 2_000
"""Bytes of its messages that are looked at."""


@dataclass
class SweepSubprocess:
    """One such process, and the folder that it fills."""

    folder: Path
    process: subprocess.Popen[bytes]

    @classmethod
    def begin(cls, folder: Path, what: Path) -> SweepSubprocess:
        """Begin a sweep, or go on with one: `what` is its file or its folder. Raises InputError."""
        command = [sys.executable, "-P", "-m", "flockscope", "sweep", "run", str(what)]
        command += ["--out", str(folder), "--workers", str(workers())]
        # As a whole it gives way, threads too: with --nice its runs would have to have processes.
        is_niced = hasattr(os, "setpriority")
        command += [] if is_niced else ["--nice", str(NICE)]
        try:
            with open(folder / MESSAGES, "wb") as said:
                process = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=said,
                    start_new_session=True,
                )
            if is_niced:
                give_way(process.pid)
        except OSError as error:
            raise InputError(
                f"the sweep {folder.name} cannot be begun: {error.strerror or error}"
            ) from None
        return cls(folder, process)

    @property
    def runs(self) -> bool:
        """Whether it is there."""
        return self.process.poll() is None

    @property
    def has_failed(self) -> bool:
        """Whether it has ended, but not as a sweep does or because it was stopped."""
        code = self.process.poll()
        return code is not None and code > 0 and code not in (*ENDS, 130)

    def stop(self) -> None:
        """Ask it to stop; what is finished is kept."""
        self.process.terminate()

    def said(self) -> str:
        """The last line that it has said."""
        try:
            with open(self.folder / MESSAGES, "rb") as file:
                file.seek(max(0, file.seek(0, 2) - OF_LINES))
                lines = file.read().decode("utf-8", "replace").split("\n")
        except OSError:
            return ""
        last = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return last.removeprefix("flockscope: ")


def give_way(pid: int) -> None:
    """Have a process that has just begun, and all that it begins, give way to this one."""
    nice = min(19, os.getpriority(os.PRIO_PROCESS, 0) + NICE)
    with suppress(ProcessLookupError):
        os.setpriority(os.PRIO_PROCESS, pid, nice)


EVERY, SELDOM = 1.0, 4.0
"""Seconds between two looks while something runs, and while nothing does."""
TABLES = {"title", "run", "stop", "design", "replicates", "observe"}
"""Of a file, those with which the page goes on: no cluster, no recordings."""
SHARE = 0.05
"""Of a core, that looking takes at most."""


@dataclass(frozen=True)
class SweepPanelState:
    """What the page shows."""

    sweeps: tuple[ListedSweep, ...] = ()
    """The newest first."""
    shown: DrawnSweep | None = None
    picture: str = ""
    """HTML of the sweep that is shown."""
    fault: str = ""
    """Why a sweep could not be begun, or is not drawn."""
    said: str = ""
    """What the command said last, of a sweep that begins."""
    unread: tuple[str, ...] = ()
    """Of each folder whose store cannot be read, its name and why."""

    def of(self, name: str) -> ListedSweep | None:
        """How far a sweep is."""
        return next((one for one in self.sweeps if one.name == name), None)


class Sweeps:
    """Those in the folder `results`. `watched` says whether anybody looks."""

    def __init__(self, results: Path, watched: Callable[[], bool] = lambda: True):
        self.results = results.absolute()
        self.watched = watched
        self.seen = SweepPanelState()
        self.chosen = ""
        """The sweep that is drawn."""
        self.column: str | None = None
        self.making: SweepSubprocess | None = None
        self.begun = 0
        self.fault = ""
        self.beginning = threading.Lock()
        self.kept: dict[str, tuple[tuple[float, ...], ListedSweep | None]] = {}
        """Of what does not change, how far it is, by when it was written last."""
        self.unread: dict[str, str] = {}
        """Why a sweep is not listed."""
        self.drawn: tuple[object, DrawnSweep | None, str, str] = (None, None, "", "")
        """What was read last: of which sweep when, what is drawn of it, its picture, and why there
        is none."""
        self.now = threading.Event()
        self.closing = threading.Event()
        self.thread = threading.Thread(target=self.live, name="sweeps", daemon=True)
        self.thread.start()

    def close(self) -> str:
        """Look no more; the name of a sweep of its own that goes on, if there is one."""
        self.closing.set()
        self.now.set()
        self.thread.join(2.0)
        return self.making.folder.name if self.making is not None and self.making.runs else ""

    # What browsers ask for.

    def begin(self, asked: SweepSource) -> str:
        """Begin a sweep; its name. Raises InputError, having left nothing."""
        with self.beginning:
            text, world = asked.to_toml(), asked.world()
            self.demand_idle()
            folder = self.new_folder(asked.name)
            try:
                write_text("sweep", folder / SPEC, text)
                if world:
                    write_text("world", folder / WORLD, world)
                self.making = SweepSubprocess.begin(folder, folder / SPEC)
            except BaseException:
                shutil.rmtree(folder, ignore_errors=True)
                raise
            self.begun += 1
            self.fault = ""
        self.choose(folder.name)
        return folder.name

    def go_on(self, name: str) -> None:
        """Make the runs that a sweep lacks. Raises InputError."""
        with self.beginning:
            folder = self.folder(name)
            demand_from_page(folder)
            self.demand_idle()
            self.making = SweepSubprocess.begin(folder, folder)
            self.begun += 1
            self.fault = ""
        self.now.set()

    def stop(self, name: str) -> None:
        """Have the process that makes a sweep stop, whoever began it. Raises InputError."""
        making = self.making
        if making is not None and making.folder.name == name and making.runs:
            making.stop()
        else:
            (self.folder(name) / STOP).touch()
        self.now.set()

    def choose(self, name: str, column: str | None = None) -> None:
        """Have a sweep drawn, by one of its columns."""
        self.chosen, self.column = name, column
        self.now.set()

    def folder(self, name: str) -> Path:
        """The folder of a sweep that is listed. Raises InputError."""
        if self.seen.of(name) is None or not (self.results / name / FILE).is_file():
            raise InputError(f"there is no sweep {name[:80]!r}")
        return self.results / name

    def demand_idle(self) -> None:
        """Refuse a second sweep while one runs. Raises InputError."""
        running = [name for name in named_in(self.results) if is_locked(self.results / name)]
        if self.making is not None and self.making.runs:
            running = [self.making.folder.name]
        if running:
            raise InputError(f"{running[0]} runs: one sweep at a time, stop it or wait for its end")
        if self.begun >= MOST_BEGUN:
            raise InputError(
                f"{MOST_BEGUN} sweeps have been begun: start the laboratory anew for more, or use "
                "flockscope sweep run"
            )

    def new_folder(self, name: str) -> Path:
        """A folder that is not there yet. Raises InputError."""
        for number in range(1, 10_000):
            folder = self.results / (name if number == 1 else f"{name}-{number}")
            try:
                folder.mkdir(parents=True)
            except FileExistsError:
                continue
            except OSError as error:
                raise InputError(
                    f"{str(folder)!r} cannot be made: {error.strerror or error}"
                ) from None
            return folder
        raise InputError(f"there are too many sweeps called {name} in {str(self.results)!r}")

    # What its thread does.

    def live(self) -> None:
        """Look, until closed; what goes wrong is printed and tried again."""
        while not self.closing.is_set():
            began, busy = time.monotonic(), False
            try:
                if self.watched():
                    self.look()
                    busy = any(one.runs for one in self.seen.sweeps)
            except Exception as error:
                traceback.print_exception(error)
                busy = False
            spent = time.monotonic() - began
            self.now.wait(max(EVERY if busy else SELDOM, spent / SHARE))
            self.now.clear()

    def look(self) -> None:
        """Read how far sweeps are, and what there is to draw of one."""
        self.bury()
        making = self.making
        names = named_in(self.results)
        found = [one for name in names if (one := self.listed(name))]
        self.unread = {name: why for name, why in self.unread.items() if name in names}
        said = ""
        if making is not None and making.runs:
            name = making.folder.name
            before = next((one for one in found if one.name == name), None)
            if before is None or before.state == "stopped":
                found = [one for one in found if one is not before]
                found.insert(0, replace(before or ListedSweep(name, ""), state="begins"))
            if before is None or before.done == 0:
                said = making.said()
        self.follow(found)
        drawn, chart, fault = self.draw(found)
        unread = tuple(f"{name} is not shown: {why}" for name, why in self.unread.items())
        self.seen = SweepPanelState(tuple(found), drawn, chart, self.fault or fault, said, unread)

    def listed(self, name: str) -> ListedSweep | None:
        """How far a sweep is; what nobody writes is read once."""
        folder = self.results / name
        stamps = tuple(
            path.stat().st_mtime if path.exists() else 0.0
            for path in (folder / FILE, folder / f"{FILE}-wal")
        )
        before = self.kept.get(name)
        if before is not None and before[0] == stamps and not is_locked(folder):
            return before[1]
        self.unread.pop(name, None)
        try:
            made = listed(folder)
        except Exception as error:  # whatever one store holds, the others are shown
            made = None
            if self.making is None or self.making.folder != folder:  # its tables are being made
                self.unread[name] = " ".join(str(error).split())[:300]
        if made is None or not made.runs:
            self.kept[name] = stamps, made
        return made

    def follow(self, found: list[ListedSweep]) -> None:
        """Draw what runs, or the newest, as long as nobody has chosen another that is there."""
        if any(one.name == self.chosen for one in found):
            return
        first = next((one for one in found if one.runs), found[0] if found else None)
        self.chosen, self.column = (first.name if first else ""), None

    def draw(self, found: list[ListedSweep]) -> tuple[DrawnSweep | None, str, str]:
        """What is drawn and its picture, made anew only if there is more of it; or why not.

        A picture takes up to 0.3 s: here, where `live` keeps looking rare, and not in the thread
        that the panels are refreshed in.
        """
        one = next((one for one in found if one.name == self.chosen), None)
        if one is None or not (self.results / one.name / FILE).is_file():
            return None, "", ""
        key = one.name, self.column, one.state == "done", *one.counts.values()
        if key != self.drawn[0]:
            try:
                read = read_drawn_sweep(self.results / one.name, self.column)
                self.drawn = key, read, picture(read), ""
            except Exception as error:  # whatever its store holds, the others are listed
                said = str(error) if isinstance(error, InputError) else f"it is broken ({error!r})"
                self.drawn = key, None, "", "" if one.state == "begins" else said[:300]
        return self.drawn[1:]

    def bury(self) -> None:
        """A process of its own that has ended: what it refused is said, and leaves nothing."""
        making = self.making
        if making is None or making.runs:
            return
        self.making = None
        if making.has_failed:
            self.fault = making.said() or f"the sweep {making.folder.name} has ended unasked"
        if not (making.folder / FILE).exists():
            shutil.rmtree(making.folder, ignore_errors=True)


def demand_from_page(folder: Path) -> None:
    """Refuse to go on with what the page could not have begun. Raises InputError."""
    path = folder / SPEC
    text = read_text(f"sweep {str(path)!r}", path)
    file = check_file(SweepFile, toml(text, str(path)), KeyLocations(str(path), text))
    told = f"go on with `flockscope sweep run {folder.name}`"
    models = [file.run.model, *(kind.model for kind in file.run.kinds if kind.model)]
    known = all(name in MODELS and name not in FILES for name in models)
    known = known and not any(kind.policy for kind in file.run.kinds)
    if not known or not all(one.name in OBSERVABLES for one in file.observe):
        raise InputError(f"{folder.name} has code of its own: {told}")
    reads = file.run.world not in (None, WORLD, *layout_names()) or any(
        getattr(one, "file", "") or {"world", "model"} & set(getattr(one, "axes", ()))
        for one in file.design
    )
    others = file.model_fields_set - TABLES
    if reads or others or file.replicates.precision:
        raise InputError(f"{folder.name} is not of the page's kind: {told}")
    kept = StoreReader(folder)
    cells = kept.cells
    try:
        specs = [cell["identity"]["spec"] for cell in cells.values()]
        agents = max(
            int(one["agents"])
            + int(one["informed"] or 0)
            + sum(int(kind["agents"]) for kind in one.get("kinds", ()))
            for one in specs
        )
        runs, limit = int(kept.state["runs"]), int(kept.state["limit"])
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{folder.name} does not say what its runs are: {told}") from None
    demand(len(cells), -(-runs // max(1, len(cells))), agents, limit)


# What the page asks of sweeps by HTTP: to sweep over a parameter, and to open a run.

OVER, RUN, SHOW = "/sweep/over", "/sweep/run", "/sweep/show"
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
        scenes.front.route(SHOW, self.show)

    def show(self, request: Request) -> web.Response:
        """Have a sweep drawn that is listed."""
        if request.headers.getall(MARK, []) != [WORD]:
            return text_response(403, f"sweeps are asked for with {MARK}: {WORD}")
        name = parse_qs(request.raw_path.partition("?")[2]).get("name", [""])[0]
        try:
            self.sweeps.folder(name)
        except InputError as refusal:
            return text_response(400, str(refusal))
        self.sweeps.choose(name)
        return text_response(200, "chosen")

    def over(self, request: Request) -> web.Response:
        """Have the form begin with a parameter."""
        if request.headers.getall(MARK, []) != [WORD]:
            return text_response(403, f"sweeps are asked for with {MARK}: {WORD}")
        asked = parse_qs(request.raw_path.partition("?")[2])
        try:
            self.form.sweep_over(asked.get("name", [""])[0])
        except InputError as refusal:
            return text_response(400, str(refusal))
        return text_response(200, "chosen")

    def run(self, asked: dict[str, list[str]]) -> SavedScene:
        """The run of a cell of a sweep that is listed. Raises InputError."""
        folder = self.sweeps.folder(asked.get("sweep", [""])[0])
        place = whole_number("cell", asked.get("cell", [""])[0])
        seed = whole_number("seed", asked["seed"][0]) if "seed" in asked else None
        return scene_of(folder, place, seed, self.sweeps.column)


def refuse_sweeps(scenes: SceneRequests) -> None:
    """Refuse what pages ask of sweeps where there are none."""
    for path in (OVER, RUN, SHOW):
        scenes.front.route(path, lambda _: text_response(403, NONE))


def whole_number(name: str, text: str) -> int:
    """A whole number of a query. Raises InputError."""
    if not (text.isascii() and text.isdigit() and len(text) <= LONGEST):
        raise InputError(f"{name} = {text[:40]!r} is no number")
    return int(text)
