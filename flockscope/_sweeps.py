"""What `flockscope` promises of sweeps and of what is found from them."""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from app.experiments.optimisation.in_python import optimise
from app.experiments.sensitivity.in_python import sensitivity
from app.experiments.sweeps.in_python import sweep

__all__ = ["optimise", "sensitivity", "sweep"]
