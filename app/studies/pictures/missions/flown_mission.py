"""One run of an experiment flown again for a picture, with all of its positions."""

from __future__ import annotations

from typing import NamedTuple

from agents import Flock
from agents.mission_record import MissionRecord, fly
from app.studies.experiment import Case, Experiment
from app.studies.kinds.mission import MissionSettings
from app.studies.trial import flock_of

FRAMES = 1500
"""Positions kept of a run, about."""


class FlownMission(NamedTuple):
    """A flock at the end of its mission, and how it went."""

    flock: Flock
    record: MissionRecord


def flown(experiment: Experiment, case: Case, seed: int, every: int | None = None) -> FlownMission:
    """Fly the run of a case with that seed; keep every so many ticks, or about FRAMES in all."""
    settings = experiment.settings
    assert isinstance(settings, MissionSettings)
    flock = flock_of(case, seed)
    ticks = round(settings.limit / flock.dt)
    return FlownMission(flock, fly(flock, ticks, every=every or max(1, ticks // FRAMES)))
