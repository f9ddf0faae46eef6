"""The last runs before the one that goes on, to be laid under it."""

from __future__ import annotations

from collections.abc import Sequence

from agents.models.model import Model
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_history import ObservableHistory

KEPT = 3
"""Runs of one model that are kept."""
MODELS = 2
"""Models of which runs are kept: as many as there are side by side."""


class EarlierRuns:
    """Keeps runs that are over, the latest first.

    A run like one that is kept already, in seed, parameters and all that was changed, takes its
    place.
    """

    def __init__(self) -> None:
        self.going: tuple[FlockReadings, ...] = ()
        self.kept: list[ObservableHistory] = []

    def follow(self, runs: Sequence[FlockReadings]) -> None:
        """Keep those that went on until now and do so no more; `runs` do."""
        for run in self.going:
            if all(run is not now for now in runs):
                self.keep(ObservableHistory.of(run))
        self.going = tuple(runs)

    def keep(self, run: ObservableHistory) -> None:
        """Keep a run, if there is anything to be seen of it."""
        if not any(len(at) > 1 for at, _ in run.curves.values()):
            return
        run, model = run.ended(), run.conditions.model
        same = [one for one in self.of(model) if one.history != run.history][: KEPT - 1]
        others = [one for one in self.kept if one.conditions.model is not model]
        self.kept = [run, *same, *others][: KEPT * MODELS]

    def of(self, model: Model) -> list[ObservableHistory]:
        """The kept runs of a model, the latest first."""
        return [one for one in self.kept if one.conditions.model is model]

    def clear(self) -> None:
        """Keep none of them any more."""
        self.kept = []
