"""The colour that each agent has as its own: by identity, the same wherever it is told of."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from app.viewer.scene.shown import palette
from app.viewer.scene.shown.frame import Frame

COLOURS = np.array(list(palette.OWN.values()))
OTHER_WORDS = {"yellow": "gold", "purple": "plum", "cyan": "sky", "gray": "grey", "magenta": "pink"}
"""Words for colours that go by another name here."""


def by_identity(ids: np.ndarray) -> np.ndarray:
    """Identities (N,), which begin at 1 -> colours (N, 3); from the thirteenth on they come again.

    >>> len(np.unique(by_identity(np.arange(1, 14)), axis=0))
    12
    """
    return COLOURS[(np.asarray(ids, int) - 1) % len(COLOURS)]


def by_name(names: Sequence[str]) -> dict[str, np.ndarray]:
    """The colours of cars by their names, which keep their order: one that is called by a colour
    has that, the others have those that are left, in turn.

    >>> [palette.css(one) for one in by_name(["car 2", "red"]).values()]
    ['#016cff', '#e30010']
    """
    asked: dict[str, str] = {}
    for name in names:
        words = (OTHER_WORDS.get(word, word) for word in re.findall("[a-z]+", name.lower()))
        colour = next((word for word in words if word in palette.OWN), None)
        if colour is not None and colour not in asked.values():
            asked[name] = colour
    left = [colour for colour in palette.OWN if colour not in asked.values()] or list(palette.OWN)
    others = [name for name in names if name not in asked]
    taken = asked | {name: left[k % len(left)] for k, name in enumerate(others)}
    return {name: palette.OWN[taken[name]] for name in names}


def of_frame(frame: Frame) -> np.ndarray:
    """The own colours (N, 3) of the agents of a frame."""
    if frame.live is None:
        return by_identity(frame.ids)
    known = by_name(frame.live.roster)
    return np.array([known[name] for name in frame.live.names]).reshape(-1, 3)
