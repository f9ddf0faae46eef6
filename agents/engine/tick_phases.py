"""The phases of a tick as bits: a loop runs one of them or several in a call."""

PLAN, COUNT, SHARE, PLACE, FILL, PREPARE, SWEEP = 1, 2, 4, 8, 16, 32, 64
ALL = PLAN | COUNT | SHARE | PLACE | FILL | PREPARE | SWEEP
OPEN = ALL & ~SWEEP
"""Everything before the first decision."""
