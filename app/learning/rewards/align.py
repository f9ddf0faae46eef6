"""Head where the others head: the mean cosine with the headings of all within reach."""

from __future__ import annotations

import math

from app.learning.reward import Reward
from worlds.compilation import compiled

REACH = 0
"""Its column of `BatchTables.numbers`."""


@compiled
def gain(player):
    """Mean cosine with those within the flock's reach that are no players, 0 for who has nobody."""
    flock, tables, e = player.flock, player.tables, player.e
    row, reach = tables.rows[e, player.m], tables.numbers[e, REACH]
    if row < 0:
        return 0.0
    total, count = 0.0, 0
    for j in range(flock.ids.shape[0]):
        is_other = flock.kind[j] >= 0.0
        if flock.crash_record.shape[0] > 0:
            is_other = is_other and flock.crash_record[j, 0] < 0.0
        for m in range(tables.ids.shape[1]):
            is_player = tables.playing[e, m] and tables.ids[e, m] == flock.ids[j]
            is_other = is_other and not is_player
        if not is_other:
            continue
        d2 = cosine = 0.0
        for axis in range(flock.position.shape[1]):
            d = flock.position[j, axis] - flock.position[row, axis]
            if tables.images[e, axis]:
                d -= tables.size[e, axis] * math.floor(d / tables.size[e, axis] + 0.5)
            d2 += d * d
            cosine += flock.heading[row, axis] * flock.heading[j, axis]
        if d2 <= reach * reach:
            total += cosine
            count += 1
    return total / count if count > 0 else 0.0


REWARD = Reward("align", "Head where those within reach head: the mean cosine.", gain)
