"""Who leads: after how long others take up an individual's heading."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.leadership import LEAST_PEAK, leadership
from app.studies.charts.array_charts import draw_ranking
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
)
from worlds.input_error import InputError
from worlds.number_text import counted


def leads(given: MeasureInput, progress: Progress) -> MeasureResult:
    """How far each individual is ahead of the others, s, beside tracks shifted in time."""
    step, wanted = given.motion.step, given.options.longest_delay
    if not 0.0 < wanted < math.inf:
        raise InputError(f"longest delay = {wanted:g} s is not allowed: a time > 0 is needed")
    longest = max(1, round(wanted / step))
    found = leadership(given.motion.heading, longest)
    progress(1.0)
    ids = np.array(given.tracks.ids, object)
    lead, error = found.lead * step, found.error * step
    order = np.argsort(-np.nan_to_num(lead, nan=-math.inf), kind="stable")
    has_lead = order[np.isfinite(lead[order])]
    pairs = int(np.isfinite(found.delay).sum()) // 2
    sure = int(found.resolved.sum())
    notes = [
        f"delays up to {longest * step:.3g} s; {counted(pairs, 'pair')} of "
        f"{len(ids) * (len(ids) - 1) // 2} have a correlation above {LEAST_PEAK:g} and above that "
        f"of tracks shifted in time ({found.null_peak:.2f})"
    ]
    if not sure:
        notes.insert(0, "not resolved: nobody's lead is told from chance")
    elif sure < len(has_lead):
        notes.append(f"not resolved: the lead of {len(has_lead) - sure} individuals, drawn pale")
    if not pairs:
        notes.append(
            "tracks that keep one heading agree whenever they are compared: a leader that never "
            "turns has no delay"
        )
    i, j = np.nonzero(np.isfinite(np.triu(found.peak, 1)) & ~np.tri(len(ids), dtype=bool))
    tables = {
        "": {
            "id": ids[order], "lead": lead[order], "error": error[order],
            "resolved": found.resolved[order],
        },
        "pairs": {
            "leader": ids[i], "follower": ids[j], "delay": found.delay[i, j] * step,
            "peak": found.peak[i, j],
        },
    }  # fmt: skip
    charts: tuple[MeasureChart, ...] = ()
    if len(has_lead):
        names = [str(one) for one in ids[has_lead]]
        charts = (
            MeasureChart(
                "ahead of the others (s)", "individual",
                lambda axes: draw_ranking(
                    axes, names, lead[has_lead], error[has_lead], found.resolved[has_lead]
                ),
            ),
        )  # fmt: skip
    largest = float(lead[has_lead[0]]) if len(has_lead) else math.nan
    return MeasureResult(
        {"largest lead (s)": largest, "resolved": sure, "pairs that count": pairs,
         "peak of tracks shifted in time": found.null_peak, "parts of the time": found.blocks},
        tables, charts, tuple(notes),
    )  # fmt: skip


def has_time(given: MeasureInput) -> str:
    """What is missing to see delays."""
    longest = max(1, round(given.options.longest_delay / given.motion.step))
    frames = len(given.tracks.frame)
    if len(given.tracks.ids) < 2:
        return "two individuals are needed"
    if 2 * longest >= frames:
        return (
            f"{frames} frames are too few for delays up to {given.options.longest_delay:g} s: "
            "--longest-delay chooses another"
        )
    return ""


MEASURES = (
    TrackMeasure(
        "leadership", "Who leads whom, by the delays of headings", "Nagy et al. 2010", leads,
        lambda frames, n: 4e-8 * frames * n * n, has_time,
    ),
)  # fmt: skip
