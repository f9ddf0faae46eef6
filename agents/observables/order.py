"""How far a flock agrees on a heading."""

from __future__ import annotations

import numpy as np


def polarisation(heading: np.ndarray) -> float:
    """Polarisation: the length of the mean heading (Vicsek et al. 1995, v_a).

    Parameters
    ----------
    heading: (N, dim) unit vectors.

    Returns
    -------
    A number in [0, 1]: 1 all alike, near 0 for random headings; 0 for an empty flock.

    >>> polarisation(np.array([[1.0, 0.0], [-1.0, 0.0]]))
    0.0
    """
    if len(heading) == 0:
        return 0.0
    return min(1.0, float(np.linalg.norm(np.mean(heading, axis=0))))
