"""The colours of charts of runs, one table for all of them; `page_svg` turns them into the page's.

The first colour is that of what is measured, the others tell lines apart. No line has the colour of
a mark, so that a mark is never taken for a point of a line.
"""

from __future__ import annotations

COLOURS = ("#2166ac", "#b2182b", "#1b7837", "#762a83", "#0b7a75", "#8c510a", "#555555", "#d6604d")
"""Of lines, in this order."""
PALE = "#9ecae1"
"""Of what stands beside the first colour and matters less."""
CENSORED, FAILED = "#d97706", "#e03131"
"""Of marks: runs that gave up, runs that failed."""
EMPTY = "#e8e8e8"
"""The ground of a map where no run has a value."""
RULER = "#7a828c"
"""Of lines at a value that is not measured: zero, a crossing."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
"""With the colours, for who cannot tell them apart."""
