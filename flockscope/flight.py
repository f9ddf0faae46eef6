"""One flapping-wing aircraft: its measures, and the trim at which it flies level.

>>> from flockscope.flight import Aircraft
>>> Aircraft(span=1.4).span
1.4
"""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from agents.flight.aircraft import Aircraft
from agents.flight.trim import Trim, trim

__all__ = ["Aircraft", "Trim", "trim"]
