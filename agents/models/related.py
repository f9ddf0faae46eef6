"""Which models are related to a model, from what they declare: its papers, its rule, its tags."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from agents.models.declare import TOPICS
from agents.models.model import Model
from agents.models.sources import papers_in

MOST = 3
SAME_RULE, SAME_PAPER, LEAST = 4.0, 3.0, 1.0
"""What one rule, and a paper, count beside tags; what two models have in common at least."""


def related_models(model: Model, models: Sequence[Model]) -> list[Model]:
    """The models that have most in common with one of `models`, the nearest first, three at most.

    Papers of their rules, one rule with another body, and tags count: a tag the more, the fewer
    models have it. One model of each rule is named, so that three do not say the same.
    """
    spread = Counter(tag for other in models for tag in set(other.rule.tags))

    def likeness(other: Model) -> float:
        papers = set(papers_in([model.rule.source])) & set(papers_in([other.rule.source]))
        tags = (set(model.rule.tags) & set(other.rule.tags)) - set(TOPICS)
        rare = sum(math.log(len(models) / spread[tag]) for tag in tags)
        return rare + SAME_PAPER * len(papers) + SAME_RULE * (model.rule is other.rule)

    likenesses = [(likeness(other), other) for other in models if other is not model]
    nearest = sorted(likenesses, key=lambda pair: -pair[0])
    chosen: dict[str, Model] = {}
    for value, other in nearest:
        if value >= LEAST:
            chosen.setdefault(other.rule.name, other)
    return list(chosen.values())[:MOST]
