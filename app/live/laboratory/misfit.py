"""What does not fit together in a laboratory's file, and where it stands there."""

from __future__ import annotations

from collections.abc import Callable

from worlds.refusal import Refusal


class Misfit(ValueError):
    """What does not fit together in a laboratory, and the keys that lead to it."""

    def __init__(self, words: str, *keys: str):
        super().__init__(words)
        self.keys = keys


def fitted(demand: Callable[[str], object], text: str, *keys: str) -> None:
    """Demand something of a text at these keys. Raises Misfit where `demand` raises Refusal."""
    try:
        demand(text)
    except Refusal as refused:
        raise Misfit(str(refused), *keys) from None
