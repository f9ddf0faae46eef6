"""A fit in a process of its own, and how far it is."""

from __future__ import annotations

import hashlib
import queue
import re
import subprocess
import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agents.catalogue import FILES, from_file
from app.processes import ChildError, ChildProcess, ProcessLostError
from app.tracks.tracks import Tracks
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.tracks.fit.fit_request import FitRequest
    from app.tracks.fit.fit_result import FitResult

NICE = 10
"""How much its process stands back: the page is played meanwhile."""
PROGRESS, RESULT, REFUSED = "progress", "result", "refused"


class FitWorker:
    """In the process that fits: knows files of rules, and tells how far it is."""

    def __init__(self, files: list[str]):
        for path in files:
            from_file(path)

    def fit(self, tracks: Tracks, request: FitRequest, folder: Path) -> Iterator[tuple[str, Any]]:
        """Fit by one-step prediction: how far it is, again and again, then what it has come to."""
        from app.tracks.fit.fit_study import RunnerSettings
        from app.tracks.fit.one_step_fit import fit_by_one_step

        told: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()

        def work() -> None:
            try:
                settings = RunnerSettings(
                    nice=NICE, at=lambda share, _, words: told.put((PROGRESS, (share, words)))
                )
                told.put((RESULT, fit_by_one_step(tracks, request, folder, settings)))
            except InputError as refusal:
                told.put((REFUSED, str(refusal)))
            except Exception as error:
                told.put((REFUSED, f"the fit has failed: {type(error).__name__}: {error}"))

        threading.Thread(target=work, name="fit", daemon=True).start()
        kind = PROGRESS
        while kind == PROGRESS:
            kind, value = told.get()
            yield kind, value


@dataclass(frozen=True)
class FitState:
    """How a fit stands; replaced as a whole, never changed."""

    running: bool = False
    share: float = 0.0
    """Of its cells that are done."""
    words: str = ""
    refusal: str = ""
    """Why there is no result, in one line."""
    result: FitResult | None = None
    tracks: Tracks | None = None
    """What it is a fit to."""
    request: FitRequest | None = None


class TracksFit:
    """One fit at a time; begun again after it was stopped, it goes on where it was."""

    def __init__(self, results: Path, changed: Any):
        self.results, self.changed = results, changed
        self.state = FitState()
        self.child: ChildProcess | None = None
        self.lock = threading.Lock()
        """Guards the child: one browser may stop what another begins."""

    def begin(self, tracks: Tracks, request: FitRequest) -> None:
        """Begin a fit. Raises InputError while there is another."""
        with self.lock:
            if self.state.running:
                raise InputError("one fit at a time: stop the one that runs first")
            self.state = FitState(True, words="preparing", tracks=tracks, request=request)
            files = [str(file) for file in FILES.values()]
            child = self.child = ChildProcess(FitWorker, files, stderr=subprocess.DEVNULL)
        folder = fit_folder(self.results, tracks, request)
        future = child.ask("fit", tracks, request, folder, receive=lambda said: self.take(*said))
        future.add_done_callback(lambda done: self.end(child, done.exception()))
        self.changed()

    def take(self, kind: str, value: Any) -> None:
        """On a thread of the child's: what the fit says."""
        if kind == PROGRESS:
            self.state = replace(self.state, share=float(value[0]), words=str(value[1]))
        elif kind == RESULT:
            self.state = replace(self.state, result=value, share=1.0)
        else:
            self.state = replace(self.state, refusal=str(value))
        self.changed()

    def end(self, child: ChildProcess, error: BaseException | None) -> None:
        """The fit is over, or was stopped."""
        refusal = self.state.refusal
        if isinstance(error, ProcessLostError | ChildError | InputError) and not refusal:
            refusal = "stopped; begun again, it goes on where it was"
        self.state = replace(self.state, running=False, refusal=refusal)
        threading.Thread(target=lambda: child.end(0.0), daemon=True).start()
        self.changed()

    def stop(self) -> None:
        """Stop the fit; what it has evaluated is kept."""
        with self.lock:
            child = self.child
        if child is not None and self.state.running:
            child.end(0.0)

    def close(self) -> None:
        """Stop it for good."""
        self.stop()


def fit_folder(results: Path, tracks: Tracks, request: FitRequest) -> Path:
    """Where the evaluations of a fit are kept: another folder for other tracks or models."""
    stem = re.sub(r"\W+", "-", Path(tracks.name).stem.lower()).strip("-")[:40] or "tracks"
    digest = hashlib.sha256(tracks.position.tobytes() + repr(request).encode()).hexdigest()[:8]
    return results / f"fit-{stem}-{request.models[0]}-{digest}"
