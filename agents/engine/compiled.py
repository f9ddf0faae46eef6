"""How every compiled function of flockscope is compiled.

Sums may be reordered (`reassoc`), so that a loop over a neighbourhood block becomes vector
instructions; NaN and infinity keep their meaning, so that a bad number can be found and named.
"""

from __future__ import annotations

import numba

FAST = {"reassoc", "nsz", "contract", "arcp"}


def compiled(function):
    """Compile a rule, a body or a part of the engine; it runs without the GIL.

    Such a function is never cached by itself: the loop that uses it is, under a name made from
    the sources of everything it reaches (see `agents.engine.loop`).
    """
    return numba.njit(
        nogil=True, fastmath=FAST, error_model="numpy", forceinline=True, _nrt=False
    )(function)
