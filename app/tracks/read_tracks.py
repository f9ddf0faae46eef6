"""Read tracks: from files of any known format, with what their user adds, to `Tracks`.

A file says some of rate, unit and origin, its format others, its user the rest: nothing of it is
guessed, and nothing is interpolated unless asked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.tracks.readers.reader_catalogue import choose_reader
from app.tracks.readers.track_reader import TOP_LEFT, FileTracks, ReadingOptions, TrackReader
from app.tracks.tracks import MOST_PLACES, PIXELS, Tracks, tracks_of_rows
from worlds.input_error import InputError, shorten

ON_GRID = 0.02
"""By which share of a frame's time a time may lie beside an even rate, and be on it."""
MOST_EMPTY = 2
"""Frames with nobody in them are put in if there are at most so many times as many frames then."""


def read(
    path: str | Path | Sequence[str | Path],
    *,
    rate: float | None = None,
    unit: str | None = None,
    origin: str | None = None,
    scale: float | None = None,
    up: str | None = None,
    node: str | None = None,
    least_confidence: float | None = None,
    columns: Mapping[str, str] | None = None,
    format: str | None = None,
    frames: tuple[int, int] | None = None,
    every: int = 1,
    fill: int = 0,
    flat: bool = False,
) -> Tracks:
    """Tracks of a file, of a folder, or of several files of one animal each.

    The format is told by what is in the file. What the file does not say and the format does not
    settle is asked for in one line.

    Parameters
    ----------
    rate: frames per second. Of a file of times alone: how many frames these are put into.
    unit: of the file's numbers: m, km, cm, mm, ft, in or px. scale: metres in a pixel, which makes
        pixels metres.
    origin: "top-left" where y points down, as in pictures, or "bottom-left".
    up: the axis that points up of places in space, "z" or "y".
    node: which part of a body stands for an individual.
    least_confidence: places of which the tracker is less sure are left out; by default 0.6 for
        DeepLabCut and `movement`, which leave no place blank.
    columns: of a plain table, what a column holds: {"x": "pos x", ...} (frame, time, id, x, y, z,
        angle, confidence).
    format: the name of a format, instead of looking.
    frames: (first, end), by their numbers; every: only each so-many-th frame.
    fill: gaps of at most so many frames are filled with a straight line, and flagged.
    flat: leave out heights.

    Raises InputError in one line: what is missing, damaged, or too large.
    """
    options = ReadingOptions(
        rate=rate, unit=unit, origin=origin, scale=scale, up=up, node=node,
        least_confidence=least_confidence, columns=dict(columns or {}), frames=frames,
        every=every, fill=fill, flat=flat,
    )  # fmt: skip
    paths = [path] if isinstance(path, str | Path) else list(path)
    if not paths:
        raise InputError("no file of tracks is given")
    return read_files([Path(one) for one in paths], options, format)


def read_files(paths: Sequence[Path], options: ReadingOptions, format: str | None = None) -> Tracks:
    """The same, with options made. Raises InputError."""
    reader, files, left_out = choose_reader(paths, format, bool(options.columns) and not format)
    name = paths[0].name if len(files) > 1 or paths[0].is_dir() else files[0].name
    tracks = finished(read_safely(reader, files, options), options, name or "tracks", reader)
    if left_out:
        count = "1 other file was" if len(left_out) == 1 else f"{len(left_out)} other files were"
        tracks = replace(tracks, notes=(*tracks.notes, f"{count} left out of the folder"))
    return tracks


def read_safely(reader: TrackReader, files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """What a reader makes of files; whatever the libraries under it raise becomes one line."""
    try:
        return reader.read(files, options)
    except InputError:
        raise
    except MemoryError:
        raise InputError(f"{files[0].name} needs more memory than there is") from None
    except Exception as error:
        # A damaged file makes each library fail in ways of its own, and so does a plug-in's.
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(
            f"{files[0].name} cannot be read as {reader.title}: {shorten(reason, 120)}"
        ) from error


def finished(told: FileTracks, options: ReadingOptions, name: str, reader: TrackReader) -> Tracks:
    """Tracks of what a file and its user say. Raises InputError for what neither does."""
    told = with_sound_places(told, options, name)
    unit, metres = unit_of(told, options, name)
    told = turned(told, options, name)
    frame, time, told = framed(told, options, name)
    told, frame, time = chosen_frames(told, frame, time, options, name)
    if told.is_table:
        tracks = table_tracks(told, frame, time, unit, name)
    else:
        tracks = row_tracks(told, frame, time, unit, name)
    if metres != 1.0:
        tracks = replace(
            tracks,
            position=tracks.position * metres,
            unit="m",
            period=tuple(side * metres for side in tracks.period),
        )
    tracks = replace(tracks, format=reader.name, dropped=tuple(told.dropped))
    return fill_gaps(tracks, options.fill) if options.fill else tracks


def with_sound_places(told: FileTracks, options: ReadingOptions, name: str) -> FileTracks:
    """The same with NaN for places that are none, and for those of which a tracker is not sure."""
    dim = told.position.shape[-1]
    if told.position.ndim not in (2, 3) or dim not in (2, 3):
        raise InputError(f"{name}: its places have the shape {told.position.shape}")
    told.position = np.array(told.position, float)  # ours to change
    if options.flat and dim == 3:
        if (options.up or told.up or "z") == "y":
            told.position = np.stack([told.position[..., 0], -told.position[..., 2]], axis=-1)
        else:
            told.position = told.position[..., :2]
        told.heading, told.period = None, told.period[:2]
        told.origin = told.origin or "bottom-left"
        told.position = np.ascontiguousarray(told.position)
    infinite = np.isinf(told.position).any(axis=-1)
    if infinite.any():
        told.drop(infinite.sum(), "the place is infinite")
        told.position[infinite] = np.nan
    least = options.least_confidence
    least = told.least_confidence if least is None else least
    if least > 0.0 and told.confidence is not None:
        unsure = (told.confidence < least) & np.isfinite(told.position).all(axis=-1)
        told.drop(unsure.sum(), f"the tracker is less sure of the place than {least:g}")
        told.position[unsure] = np.nan
    elif options.least_confidence:
        raise InputError(f"--least-confidence {least:g}: {name} does not say how sure it is")
    told.position[~np.isfinite(told.position).all(axis=-1)] = np.nan
    if told.heading is not None:
        length = np.linalg.norm(told.heading, axis=-1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            told.heading = np.where(length > 1e-9, told.heading / length, np.nan)
    if told.filled is not None:
        told.filled = told.filled & np.isfinite(told.position).all(axis=-1)
    return told


def unit_of(told: FileTracks, options: ReadingOptions, name: str) -> tuple[str, float]:
    """The unit of places, and metres in it if pixels become metres, else 1. Raises InputError."""
    unit = options.unit or told.unit
    if not unit:
        raise InputError(f"{name} says no unit of length: give --unit (m, cm, mm, px, ...)")
    if options.unit and told.unit and options.unit != told.unit:
        told.notes.append(f"its format says {told.unit}; {unit} is taken, as given")
    if options.scale is None:
        return unit, 1.0
    if unit != PIXELS:
        raise InputError(f"--scale is metres in a pixel, but {name} is in {unit}")
    told.notes.append(f"a pixel is {options.scale:g} m, as given")
    return unit, options.scale


def turned(told: FileTracks, options: ReadingOptions, name: str) -> FileTracks:
    """The same with y up in the plane and z up in space. Raises InputError."""
    if told.position.shape[-1] == 3:
        up = options.up or told.up
        if not up:
            up = "z"
            told.notes.append("z is taken to point up: give --up y if y does")
        if up == "y":  # (x, y, z) with y up is (x, -z, y) with z up
            told.position = np.stack(
                [told.position[..., 0], -told.position[..., 2], told.position[..., 1]], axis=-1
            )
            told.notes.append("y points up in the file: its (x, y, z) is (x, z, -y) here")
            told.heading = None
        return told
    origin = options.origin or told.origin
    if not origin:
        raise InputError(
            f"{name} does not say where its origin is: give --origin top-left (y points down, as "
            "in pictures) or bottom-left"
        )
    if origin == TOP_LEFT:
        told.position[..., 1] *= -1.0
        if told.heading is not None:
            told.heading[..., 1] *= -1.0
        told.notes.append("y points down in the file: y is -y here")
    return told


def framed(
    told: FileTracks, options: ReadingOptions, name: str
) -> tuple[np.ndarray, np.ndarray | None, FileTracks]:
    """Numbers of frames, and times where no rate tells them. Raises InputError."""
    rate = options.rate or told.rate
    if options.rate and told.rate and not math.isclose(options.rate, told.rate, rel_tol=1e-3):
        told.notes.append(
            f"the file says {told.rate:.6g} frames per second; {rate:g} is taken, as given"
        )
    if told.frame is not None:
        if rate is not None:
            return told.frame, told.frame / rate, told
        if told.time is not None:
            return told.frame, told.time, told
        raise InputError(f"{name} says no frames per second: give --rate")
    if told.time is None:
        raise InputError(f"{name} has neither frames nor times")
    for k in np.flatnonzero(~np.isfinite(told.time))[:1]:
        raise InputError(f"{name}: the time of row {k + 1} is no number")
    if told.is_table:
        return np.arange(len(told.time)), told.time, told
    if options.rate is not None:
        return on_frames(told, options.rate)
    return frames_of_times(told)


def frames_of_times(told: FileTracks) -> tuple[np.ndarray, np.ndarray | None, FileTracks]:
    """Frames of times that are all there is: of an even rate if they fit one, else in order."""
    assert told.time is not None
    moments, at = np.unique(np.round(told.time, 6), return_inverse=True)
    if len(moments) > 1:
        step = float(np.median(np.diff(moments)))
        steps = moments / step
        if (np.abs(steps - np.round(steps)) <= ON_GRID).all() and steps.max() < 2**53:
            number = np.round(steps).astype(np.int64)
            if len(np.unique(number)) == len(number):
                return number[at], told.time, told
    return at, moments[at], told


def on_frames(told: FileTracks, rate: float) -> tuple[np.ndarray, np.ndarray | None, FileTracks]:
    """Rows of uneven times put into frames: of each individual the row that is nearest to each."""
    assert told.time is not None
    exact = told.time * rate
    frame = np.round(exact).astype(np.int64)
    off = np.abs(exact - frame)
    _, who = np.unique(np.asarray(told.ids).astype(str), return_inverse=True)
    order = np.lexsort((off, frame, who))
    first = np.ones(len(order), bool)
    first[1:] = (np.diff(who[order]) != 0) | (np.diff(frame[order]) != 0)
    kept = np.sort(order[first])
    if off[kept].max(initial=0.0) > ON_GRID:
        told.notes.append(f"times are put into frames, at most {off[kept].max() / rate:.3g} s off")
    told.drop(len(frame) - len(kept), "another row of the individual is nearer to the frame")
    return frame[kept], frame[kept] / rate, taken_rows(told, kept)


def taken_rows(told: FileTracks, kept: np.ndarray) -> FileTracks:
    """Some rows (or frames of a table), by their places."""
    parts: dict[str, Any] = {
        name: None if (array := getattr(told, name)) is None else array[kept]
        for name in ("position", "heading", "confidence", "filled")
    }
    ids = told.ids if told.is_table else np.asarray(told.ids)[kept]
    return replace(told, ids=ids, **parts)


def chosen_frames(
    told: FileTracks, frame: np.ndarray, time: np.ndarray | None, options: ReadingOptions, name: str
) -> tuple[FileTracks, np.ndarray, np.ndarray | None]:
    """Only the frames that are asked for. Raises InputError if none is left."""
    kept = np.ones(len(frame), bool)
    if options.frames is not None:
        kept &= (frame >= options.frames[0]) & (frame < options.frames[1])
    if options.every > 1:
        at = np.unique(frame[kept], return_inverse=True)[1]
        kept[kept] = at % options.every == 0
    if not kept.any():
        raise InputError(f"{name} has none of the frames that are asked for")
    if kept.all():
        return told, frame, time
    return taken_rows(told, np.flatnonzero(kept)), frame[kept], None if time is None else time[kept]


def table_tracks(
    told: FileTracks, frame: np.ndarray, time: np.ndarray | None, unit: str, name: str
) -> Tracks:
    """Tracks of a table (T, N, dim), those who are never seen left out."""
    assert time is not None
    order = np.argsort(frame, kind="stable")
    for k in np.flatnonzero(np.diff(frame[order]) == 0)[:1]:
        raise InputError(f"{name}: frame {frame[order][k]} is twice in it")
    told = taken_rows(told, order) if (order[1:] < order[:-1]).any() else told
    rows = np.flatnonzero(np.isfinite(told.position[..., 0]).any(axis=0))
    tracks = Tracks(
        position=told.position,
        frame=frame[order],
        time=np.asarray(time, float)[order],
        ids=tuple(map(str, told.ids)),
        unit=unit,
        name=name,
        period=told.period,
        boundary=told.boundary,
        heading=told.heading,
        confidence=told.confidence,
        filled=told.filled,
    )
    unseen = len(tracks.ids) - len(rows)
    if unseen:
        told.notes.append(f"{unseen} individuals are never seen and left out")
        tracks = tracks.individuals(rows)
    return replace(tracks, notes=tuple(told.notes))


def row_tracks(
    told: FileTracks, frame: np.ndarray, time: np.ndarray | None, unit: str, name: str
) -> Tracks:
    """Tracks of rows, of which those with no place only say that there was a frame."""
    seen = np.isfinite(told.position[..., 0])
    if not seen.any():
        raise InputError(f"{name} has no individual that is seen")
    numbers, first = np.unique(frame, return_index=True)
    seconds = None if time is None else time[first]
    if not seen.all():
        kept = np.flatnonzero(seen)
        told = taken_rows(told, kept)
        frame, time = frame[kept], None if time is None else time[kept]
    told.position = np.ascontiguousarray(told.position)
    tracks = tracks_of_rows(
        frame,
        np.asarray(told.ids),
        told.position,
        name=name,
        unit=unit,
        time=time,
        heading=told.heading,
        confidence=told.confidence,
        filled=told.filled,
        period=told.period,
        boundary=told.boundary,
        notes=tuple(told.notes),
    )
    if len(numbers) > len(tracks.frame) and seconds is not None:
        tracks = with_frames(tracks, numbers, seconds)
    return with_empty_frames(tracks)


def with_empty_frames(tracks: Tracks) -> Tracks:
    """The same with the frames in which nobody is seen, where frames are evenly numbered.

    Without them a second in which nobody is there would look like a step of a frame. Numbers that
    fit no grid, or one that is almost empty, are left as they are.
    """
    gaps = np.diff(tracks.frame)
    if len(gaps) < 2:
        return tracks
    step = int(np.gcd.reduce(gaps))
    count = int((tracks.frame[-1] - tracks.frame[0]) // step) + 1
    if count == len(tracks.frame) or count > MOST_EMPTY * len(tracks.frame):
        return tracks
    seconds = np.diff(tracks.time) / gaps
    if np.ptp(seconds) > ON_GRID * np.median(seconds):
        return tracks
    frame = tracks.frame[0] + step * np.arange(count)
    made = with_frames(tracks, frame, np.interp(frame, tracks.frame, tracks.time))
    if made is tracks:
        return tracks
    missing = count - len(tracks.frame)
    note = f"{missing} frames are not in the file, and nobody is seen in them"
    return replace(made, notes=(*tracks.notes, note))


def with_frames(tracks: Tracks, frame: np.ndarray, time: np.ndarray) -> Tracks:
    """The same with more frames, nobody seen in those that are new; as it is if these are many."""
    if len(frame) * len(tracks.ids) * tracks.dim > MOST_PLACES:
        return tracks
    at = np.searchsorted(frame, tracks.frame)

    def spread(array: np.ndarray | None, empty: float) -> np.ndarray | None:
        if array is None:
            return None
        table = np.full((len(frame), *array.shape[1:]), empty, array.dtype)
        table[at] = array
        return table

    position = spread(tracks.position, np.nan)
    assert position is not None
    return replace(
        tracks,
        position=position,
        frame=frame,
        time=time,
        heading=spread(tracks.heading, np.nan),
        confidence=spread(tracks.confidence, np.nan),
        filled=spread(tracks.filled, False),
    )


def fill_gaps(tracks: Tracks, most: int) -> Tracks:
    """The same with gaps of at most `most` frames filled along a straight line, and flagged.

    Along an axis that wraps the line goes the short way. Headings stay unknown there.
    """
    seen = tracks.seen
    places = np.arange(len(seen))[:, None]
    before = np.maximum.accumulate(np.where(seen, places, -1), axis=0)
    after = np.minimum.accumulate(np.where(seen, places, len(seen))[::-1], axis=0)[::-1]
    gap = ~seen & (before >= 0) & (after < len(seen)) & (after - before - 1 <= most)
    at, row = np.nonzero(gap)
    first, last = before[at, row], after[at, row]
    start, end = tracks.position[first, row], tracks.position[last, row]
    way = end - start
    period = np.array(tracks.period or (0.0,) * tracks.dim)
    wraps = period > 0.0
    way[:, wraps] -= period[wraps] * np.round(way[:, wraps] / period[wraps])
    share = (tracks.time[at] - tracks.time[first]) / (tracks.time[last] - tracks.time[first])
    position = tracks.position.copy()
    position[at, row] = start + share[:, None] * way
    position[..., wraps] %= period[wraps]
    filled = np.zeros(seen.shape, bool) if tracks.filled is None else tracks.filled.copy()
    filled[at, row] = True
    return replace(
        tracks,
        position=position,
        filled=filled,
        notes=(*tracks.notes, f"{len(at)} places in gaps of at most {most} frames are filled"),
    )
