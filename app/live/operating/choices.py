"""What may be chosen while a laboratory is shown: its sources, its links and its rules, by words.

Whoever chooses, a browser too, names one of these words and nothing else: the texts behind them are
those of the laboratory's file and the two that are always there.
"""

from __future__ import annotations

from collections.abc import Iterable

from agents.catalogue import cars_by, obedient
from app.live.kinds import CALLED, DRY, SIMULATED, kind_of, words_of
from app.live.laboratory.lab import Lab
from worlds.refusal import unknown


def sources(lab: Lab) -> dict[str, str]:
    """The texts of the sources by their words: the file's own first, emulated cars last."""
    return offered(lab.source, lab.sources, SIMULATED)


def links(lab: Lab) -> dict[str, str]:
    """The texts of the links by their words: the file's own first, a dry run last."""
    return offered(lab.link, lab.links, DRY)


def offered(own: str, others: dict[str, str], always: str) -> dict[str, str]:
    """Texts by their words; the file's own stands there once, even if it is the last one too."""
    found = {words_of(own): own} | others
    found.setdefault(CALLED[always], always)
    return found


def rules(lab: Lab) -> tuple[str, ...]:
    """The file's rule, then the models of cars of the catalogue."""
    return tuple(dict.fromkeys([lab.rule, *obedient()]))


def chosen(lab: Lab, source: str, link: str, rule: str) -> Lab:
    """The laboratory with another source, link and rule, by the words above.

    With emulated cars the link is the one to them, whatever was chosen. Parameters of the file
    that another rule lacks are left out. Raises Refusal for words that are none of these, or if
    what was chosen does not fit together.
    """
    poses = sources(lab)[known("source", source, sources(lab))]
    commands = links(lab)[known("link", link, links(lab))]
    known("rule", rule, rules(lab))
    if poses == SIMULATED:
        commands = lab.link if kind_of(lab.link) == SIMULATED else SIMULATED
    return lab.altered(
        "the choice", source=poses, link=commands, rule=rule, parameters=kept(lab, rule)
    )


def known(kind: str, words: str, allowed: Iterable[str]) -> str:
    """The words, if they are among those allowed. Raises Refusal."""
    if words not in allowed:
        raise unknown(kind, words, allowed, "the laboratory")
    return words


def kept(lab: Lab, rule: str) -> dict:
    """Those of the file's parameters that a rule has too. Raises Refusal."""
    if rule == lab.rule:
        return dict(lab.parameters)
    fields = cars_by(rule).parameters.model_fields
    return {name: value for name, value in lab.parameters.items() if name in fields}
