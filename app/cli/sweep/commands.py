"""`flockscope sweep`: many runs, over what one chooses."""

from __future__ import annotations

from app.cli.sweep.check import check
from app.cli.sweep.export import export
from app.cli.sweep.list_sweeps import list_sweeps
from app.cli.sweep.plot import plot
from app.cli.sweep.run import run
from app.cli.sweep.show import show
from app.cli.sweep.status import status
from app.cli.sweep.stop import stop
from app.cli.usage import grouped

sweep = grouped(
    "Sweeps: many runs over parameters, kept whatever happens; look at them at any time.",
    {
        "run": run,
        "check": check,
        "status": status,
        "show": show,
        "plot": plot,
        "export": export,
        "stop": stop,
        "list": list_sweeps,
    },
)
