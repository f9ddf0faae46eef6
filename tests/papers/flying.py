"""Experiments about missions in small, for the tests of the papers' claims."""

from dataclasses import replace

from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment


def flown(name, folder, runs, agents=(), **settings):
    """An experiment carried out with few runs, as (experiment, verdicts)."""
    whole = read_experiment(name).select([], list(agents))
    experiment = replace(whole, settings=whole.settings.model_copy(update=settings))
    done = run_experiment(
        experiment, folder, runs=runs, seed=1, workers=2, tell=None, at=lambda *_: None
    )
    return experiment, verdicts(experiment, done.measured)


def borne_out(experiment, made):
    """Whether something is claimed, and no run speaks against it; few runs decide little."""
    words = {claim.word for claim in claims(made, experiment.said)}
    return bool(words) and "does not hold" not in words


def values(made, measure):
    """The values of a measure by label and size."""
    return {
        (one.case.label, one.case.agents): one.values for one in made if one.measure.name == measure
    }
