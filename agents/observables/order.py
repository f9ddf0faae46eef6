"""How far a flock agrees on a heading."""

from __future__ import annotations

import math

import numpy as np

from agents.observables.array_checks import headings


def polarisation(heading: np.ndarray) -> float:
    """Polarisation: the length of the mean heading (Vicsek et al. 1995, v_a).

    Parameters
    ----------
    heading: (N, dim) unit vectors, dim 2 or 3; rows that are no numbers are left out.

    Returns
    -------
    A number in [0, 1]: 1 all alike, near 0 for random headings; 0 for an empty flock.

    Raises InputError for what are no unit vectors, and warns of rows left out
    (`agents.observables.array_checks`, as all that measures arrays).

    >>> polarisation(np.array([[1.0, 0.0], [-1.0, 0.0]]))
    0.0
    """
    heading = headings(heading)
    if len(heading) == 0:
        return 0.0
    mean = np.add.reduce(heading) / len(heading)
    return min(1.0, math.sqrt(mean.dot(mean)))
