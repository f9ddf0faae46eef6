"""Begins and ends the recording of a control loop while it runs, on a thread of its own: neither a
tick nor an emergency stop ever waits for the disk."""

from __future__ import annotations

import queue
import shutil
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.live.control.control_loop import Loop
from app.live.control.loop_status import Event
from app.live.laboratory.recording_parts import MB, RESERVE, RecordingLimits
from app.live.recording.recording_writer import RecordingWriter
from worlds.input_error import InputError

SETTLES = 0.05
"""Seconds in which a tick that has begun is done with its recording."""


@dataclass(frozen=True)
class RecordRequest:
    """The operator wants a recording in a new folder; or none any more."""

    folder: Path | None
    cause: str


class LoopRecorder:
    """The recordings of one loop, one at a time; a context manager that finishes the last."""

    def __init__(self, laboratory: str, limits: RecordingLimits):
        self.laboratory = laboratory
        self.kept = limits
        self.loop: Loop | None = None
        self.journal: RecordingWriter | None = None
        self.asked: queue.SimpleQueue[RecordRequest | None] = queue.SimpleQueue()
        self.thread = threading.Thread(target=self.serve, name="recorder", daemon=True)

    def __enter__(self) -> LoopRecorder:
        self.thread.start()
        return self

    def __exit__(self, *_: Any) -> None:
        """Finish what is recorded; if it cannot be finished, the terminal says so."""
        self.asked.put(None)
        self.thread.join()
        try:
            self.end()
        except InputError as refusal:
            print(f"flockscope: {refusal}", file=sys.stderr)

    def begin(self, folder: Path) -> RecordingWriter:
        """Begin a recording. Raises InputError, also where there is no room for one."""
        if self.journal is not None:
            raise InputError(f"it is recorded already, in {self.journal.folder}")
        journal = RecordingWriter(folder, self.laboratory, self.kept).__enter__()
        self.journal = journal
        return journal

    def end(self) -> None:
        """End the recording, if there is one. Raises InputError if it cannot be finished."""
        journal, self.journal = self.journal, None
        if journal is not None:
            journal.__exit__(None, None, None)

    def ask(self, request: RecordRequest) -> None:
        """Have a recording begin or end, soon; events say what came of it."""
        self.asked.put(request)

    def serve(self) -> None:
        """The thread: carry out what is asked."""
        while (request := self.asked.get()) is not None:
            loop = self.loop
            if loop is None:  # it has not begun: there is nothing to record
                continue
            try:
                if request.folder is None:
                    self.stop(loop, request.cause)
                else:
                    self.start(loop, request.folder, request.cause)
            except Exception as error:  # whatever a disk does, the loop goes on and says so
                words = " ".join(str(error).split()) or type(error).__name__
                self.add_event(loop, "recording", words, request.cause)

    def start(self, loop: Loop, folder: Path, cause: str) -> None:
        """Begin to record a loop that runs. Raises InputError or OSError."""
        folder.parent.mkdir(parents=True, exist_ok=True)
        free, needed = shutil.disk_usage(folder.parent).free, MB * RESERVE * self.kept.part
        if free < needed:
            raise InputError(
                f"nothing is recorded: {free / MB:.0f} MB are free in {folder.parent}, and "
                f"{needed / MB:.0f} MB are needed"
            )
        loop.journal = self.begin(folder)
        self.add_event(loop, "record", f"recording in {folder}", cause, str(folder))

    def stop(self, loop: Loop, cause: str) -> None:
        """End the recording of a loop that runs on. Raises InputError if it cannot be finished."""
        if self.journal is None:
            raise InputError("nothing is recorded")
        folder, loop.journal = self.journal.folder, None
        self.add_event(loop, "record", f"the recording in {folder} ends", cause)
        time.sleep(SETTLES)
        self.end()

    def add_event(self, loop: Loop, kind: str, words: str, cause: str, folder: str = "") -> None:
        """Add an event of the recording itself, which is in no table."""
        loop.events.add(
            Event(loop.control.tick, loop.clock(), kind, words, cause=cause, note=folder)
        )
