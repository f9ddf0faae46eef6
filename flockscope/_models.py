"""What `flockscope` promises of models, and of runs as values."""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from agents.catalogue import MODELS, from_file, model
from agents.individuals import each, lognormal, normal, one_of, uniform
from agents.kinds import Kind, chase, flee
from agents.recordings.recording import Recording
from agents.spec import Spec

__all__ = [
    "MODELS",
    "Kind",
    "Recording",
    "Spec",
    "chase",
    "each",
    "flee",
    "from_file",
    "lognormal",
    "model",
    "normal",
    "one_of",
    "uniform",
]
