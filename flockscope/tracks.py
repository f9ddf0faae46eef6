"""Tracks of real animals, people and robots: read from what common trackers write, and measured.

docs/tracks-measures.md says what each measure can tell.

>>> from flockscope.tracks import Tracks, measure_tracks, read
>>> read("no-such-file.csv")
Traceback (most recent call last):
    ...
worlds.input_error.InputError: no-such-file.csv cannot be read: No such file or directory
>>> import numpy as np
>>> place = np.cumsum(np.ones((9, 6, 2)), axis=0) + np.arange(6.0)[:, None]
>>> frame = np.arange(9)
>>> marching = Tracks(place, frame, frame / 10.0, tuple("abcdef"), unit="m")
>>> round(measure_tracks(marching, ["speed"]).results["speed"].numbers["mean"], 6)
14.142136
"""

from __future__ import annotations

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from app.tracks.fit.approximate_bayes import AbcResult
from app.tracks.fit.fit_api import fit
from app.tracks.fit.fit_request import FitRequest
from app.tracks.fit.fit_result import FitResult, ModelFit
from app.tracks.fit.vicsek_likelihood import LikelihoodResult
from app.tracks.measure_report import MeasureReport, describe_report, measure_tracks, write_report
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureOptions,
    MeasureResult,
    TrackMeasure,
    frame_series,
)
from app.tracks.motion import SmoothedMotion, smoothed_motion, velocity_noise
from app.tracks.read_tracks import read
from app.tracks.readers.track_reader import FileTracks, ReadingOptions, TrackReader
from app.tracks.tracks import DroppedRows, Tracks
from worlds.input_error import InputError

__all__ = [
    "AbcResult",
    "DroppedRows",
    "FileTracks",
    "FitRequest",
    "FitResult",
    "InputError",
    "LikelihoodResult",
    "MeasureChart",
    "MeasureInput",
    "MeasureOptions",
    "MeasureReport",
    "MeasureResult",
    "ModelFit",
    "ReadingOptions",
    "SmoothedMotion",
    "TrackMeasure",
    "TrackReader",
    "Tracks",
    "describe_report",
    "fit",
    "frame_series",
    "measure_tracks",
    "read",
    "smoothed_motion",
    "velocity_noise",
    "write_report",
]
