"""The bounds that a claim sets to a measure."""

from __future__ import annotations

from app.studies.experiment_file import EnduranceClaim, EveryRunClaim


def bounds_in_words(one: EveryRunClaim | EnduranceClaim) -> str:
    """The bounds that are given."""
    bounds = {
        "above": one.above,
        "below": one.below,
        "at least": one.at_least,
        "at most": one.at_most,
    }
    return " and ".join(f"{word} {x:g}" for word, x in bounds.items() if x is not None)


def is_within(one: EveryRunClaim | EnduranceClaim, value: float) -> bool:
    """Whether a value is within all of the bounds that are given."""
    return (
        (one.above is None or value > one.above)
        and (one.below is None or value < one.below)
        and (one.at_least is None or value >= one.at_least)
        and (one.at_most is None or value <= one.at_most)
    )
