"""What `flockscope` promises of sweeps and of what is found from them."""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from app.classroom.runs_frame import runs_frame
from app.studies.optimisation.optimisation_api import optimise
from app.studies.sensitivity.sensitivity_api import sensitivity
from app.studies.sweeps.batch_run import batch_run
from app.studies.sweeps.sweep_api import sweep

__all__ = ["batch_run", "optimise", "runs_frame", "sensitivity", "sweep"]
