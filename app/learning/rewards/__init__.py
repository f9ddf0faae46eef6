"""What steered agents are to learn: rewards, one file each, found by their names.

A file here has REWARD, a `Reward`; a file of one's own gives its function to `env` instead.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from app.learning.reward import Reward
from worlds.compilation import compiled


@cache
def rewards() -> dict[str, Reward]:
    """All rewards by name."""
    files = [import_module(f"{__name__}.{entry.name}") for entry in iter_modules(__path__)]
    return {file.REWARD.name: file.REWARD for file in files}


@compiled
def no_gain(player):  # noqa: ARG001 - as all rewards
    """Nothing: a function of one's own is asked instead."""
    return 0.0
