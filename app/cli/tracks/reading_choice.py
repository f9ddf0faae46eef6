"""Which tracks are meant, and what their file does not say: options of all `flockscope tracks`."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.tracks.tracks import Tracks

Files = Annotated[
    list[Path],
    typer.Argument(metavar="FILE...", help="A file, a folder, or several files of one set."),
]
LOOK_EVERY = 0.2
"""Seconds between two looks at whether a file is read."""


@dataclass(frozen=True)
class ReadingChoice:
    """What a user says of files of tracks that these do not say, and what to take of them."""

    rate: Annotated[
        float | None,
        typer.Option(help="Frames per second, where the file has no rate."),
    ] = None
    unit: Annotated[
        str | None,
        typer.Option(help="Of the file's numbers: m, km, cm, mm, ft, in or px."),
    ] = None
    origin: Annotated[
        str | None,
        typer.Option(help="top-left: y points down, as in pictures; or bottom-left."),
    ] = None
    scale: Annotated[float | None, typer.Option(help="Metres in a pixel; makes pixels metres.")] = (
        None
    )
    up: Annotated[
        str | None, typer.Option(help="The axis that points up of places in space: z or y.")
    ] = None
    flat: Annotated[bool, typer.Option("--flat", help="Leave out heights.")] = False
    node: Annotated[
        str | None, typer.Option(help="The part of a body that stands for an individual.")
    ] = None
    least_confidence: Annotated[
        float | None,
        typer.Option(
            help="Leave out places of which the tracker is less sure. "
            "\\[default: 0.6 for DeepLabCut and movement]"
        ),
    ] = None
    column: Annotated[
        list[str] | None,
        typer.Option(
            help="Of a plain table, WHAT=NAME: frame, time, id, x, y, z, angle or confidence; may "
            "be repeated."
        ),
    ] = None
    format: Annotated[
        str | None, typer.Option(help="A name of `flockscope tracks formats`, instead of looking.")
    ] = None
    frames: Annotated[
        str | None, typer.Option(help="FIRST:END, the frames that are read, by their numbers.")
    ] = None
    every: Annotated[int, typer.Option(help="Read only each so-many-th frame.")] = 1
    fill: Annotated[
        int, typer.Option(help="Fill gaps of at most so many frames with a straight line.")
    ] = 0

    def read(self, files: list[Path], quiet: bool = False) -> Tracks:
        """The tracks, with a bar once reading takes more than two seconds. Raises InputError."""
        from app.cli.terminal.progress import Progress
        from app.tracks.read_tracks import read

        result: list[Tracks] = []
        errors: list[BaseException] = []

        def work() -> None:
            try:
                result.append(
                    read(
                        files,
                        rate=self.rate, unit=self.unit, origin=self.origin, scale=self.scale,
                        up=self.up, flat=self.flat, node=self.node,
                        least_confidence=self.least_confidence, columns=self.columns(),
                        format=self.format, frames=self.span(), every=self.every, fill=self.fill,
                    )
                )  # fmt: skip
            except BaseException as error:
                errors.append(error)

        # Libraries in C do not heed Ctrl-C while they parse: this thread does.
        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        with Progress("reading", quiet) as progress:
            while thread.is_alive():
                thread.join(LOOK_EVERY)
                progress.update(0.5)
        if errors:
            raise errors[0]
        return result[0]

    def columns(self) -> dict[str, str]:
        """What the columns of a plain table hold. Raises InputError."""
        held = {}
        for text in self.column or ():
            what, equals, name = text.partition("=")
            if not (what and equals and name):
                raise InputError(f"--column {text} is not of the form WHAT=NAME")
            if what in held:
                raise InputError(f"--column {what}= is given twice")
            held[what] = name
        return held

    def span(self) -> tuple[int, int] | None:
        """The first frame and the one after the last. Raises InputError."""
        if self.frames is None:
            return None
        try:
            first, end = self.frames.split(":")
            return int(first), int(end)
        except ValueError:
            raise InputError(
                f"--frames {self.frames} is not of the form FIRST:END, two whole numbers"
            ) from None
