"""The phases of a tick, to be asked of a loop one by one or together."""

PLAN, COUNT, SHARE, PLACE, FILL, PREPARE, SWEEP = 1, 2, 4, 8, 16, 32, 64
ALL = PLAN | COUNT | SHARE | PLACE | FILL | PREPARE | SWEEP
OPEN = ALL & ~SWEEP
"""Everything before the first decision."""
