"""A laboratory's file and what may be chosen from it by name: sources, links and rules.

Whoever chooses, a browser too, gives one of these names and nothing else: the texts behind them are
those of the laboratory's file, and the two that are always there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from agents.catalogue import cars_for_rule, obedient_car_models
from app.live.device_kinds import BUILT_IN_NAMES, DRY, SIMULATED, kind_of, name_of
from app.live.laboratory.lab_file import Lab, example, read_lab
from app.live.operating.flock_driver import FlockDriver
from app.live.operating.loop_process import LoopComponents, open_ends
from worlds.input_error import InputError, unknown

# A laboratory driven by its rule; apart from `ends`, as importing rules takes long.


def open_driven(lab: Lab) -> LoopComponents:
    """Source and link of a laboratory, real or emulated, with its rule as driver.

    Raises InputError.
    """
    return open_ends(lab, FlockDriver(lab))


@dataclass(frozen=True)
class Choices:
    """What may be chosen in a laboratory, what is chosen, and the laboratory that this makes."""

    file: Lab
    """The laboratory as its file has it."""
    sources: Mapping[str, str]
    """The texts of the sources by name: the file's own first, emulated cars last."""
    links: Mapping[str, str]
    """The texts of the links by name: the file's own first, a dry run last."""
    rules: tuple[str, ...]
    """The file's rule, then the models of cars of the catalogue."""
    source: str
    """The name of the source that is chosen; so are the next two."""
    link: str
    rule: str
    lab: Lab
    """The laboratory as chosen."""

    @staticmethod
    def of(lab: Lab) -> Choices:
        """What may be chosen in a laboratory; what its file says is chosen."""
        sources = merge_devices(lab.source, lab.sources, SIMULATED)
        links = merge_devices(lab.link, lab.links, DRY)
        rules = tuple(dict.fromkeys([lab.rule, *obedient_car_models()]))
        return Choices(
            lab, sources, links, rules, next(iter(sources)), next(iter(links)), lab.rule, lab
        )

    @property
    def offered(self) -> dict[str, Collection[str]]:
        """The names that may be chosen, for each of `source`, `link` and `rule`."""
        return {"source": self.sources, "link": self.links, "rule": self.rules}

    def choosing(self, **names: str) -> Choices:
        """Another `source`, `link` or `rule` chosen by name; what is not named stays.

        With emulated cars the link is the one to them, whatever is chosen. Parameters of the file
        that another rule lacks are left out. Raises InputError for other names, or if what is
        chosen does not fit together.
        """
        for kind, name in names.items():
            if name not in self.offered[kind]:
                raise unknown(kind, name, self.offered[kind], "the laboratory")
        chosen = {"source": self.source, "link": self.link, "rule": self.rule} | names
        source, link, rule = (
            self.sources[chosen["source"]],
            self.links[chosen["link"]],
            chosen["rule"],
        )
        if source == SIMULATED:
            link = self.file.link if kind_of(self.file.link) == SIMULATED else SIMULATED
        lab = self.file.with_values(
            "the choice",
            source=source,
            link=link,
            rule=rule,
            parameters=shared_parameters(self.file, rule),
        )
        return replace(self, source=chosen["source"], link=chosen["link"], rule=rule, lab=lab)


def laboratory(
    file: Path | None = None, source: str | None = None, link: str | None = None
) -> Choices:
    """The laboratory of a file, by default the example, with the source and link that are named.

    Raises InputError.
    """
    choices = Choices.of(example() if file is None else read_lab(file))
    names = {"source": source, "link": link}
    chosen_names = {kind: name for kind, name in names.items() if name is not None}
    if not chosen_names:
        return choices
    selection = choices.choosing(**chosen_names)
    if link is not None and selection.lab.link != selection.links[link]:
        raise InputError(
            f"--link {link!r} is not allowed: emulated cars have a link of their own (--dry sends "
            "nothing)"
        )
    return selection


def merge_devices(own: str, others: Mapping[str, str], always: str) -> dict[str, str]:
    """Texts by name: the file's own, its others, and the one that is always there; each once."""
    devices = {name_of(own): own, **others}
    devices.setdefault(BUILT_IN_NAMES[always], always)
    return devices


def shared_parameters(lab: Lab, rule: str) -> dict:
    """Those of the file's parameters that a rule has too. Raises InputError."""
    if rule == lab.rule:
        return dict(lab.parameters)
    fields = cars_for_rule(rule).parameters.model_fields
    return {name: value for name, value in lab.parameters.items() if name in fields}
