"""The table of runs that are looked at several times: a line for each row and look."""

from __future__ import annotations

from typing import Any

from app.studies.reports.verdict_style import styled
from app.studies.verdicts.verdict import Verdict


def gathering_table(made: list[Verdict]) -> Any:
    """The means of all measures at each look; below a row's last look what was published."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    symbols = list(dict.fromkeys(one.measure.symbol for one in made))
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for column in ("N", "model", "tick", *symbols):
        left = "left" if column == "model" else "right"
        table.add_column(column, justify=left, no_wrap=True)  # type: ignore[arg-type]
    before = None
    for look in looks(made):
        case = look[0].case
        head = ("", "") if case.row is before else (str(case.agents), case.label)
        before = case.row
        means = (shown(one.summary.mean) if one.summary.runs else "-" for one in look)
        table.add_row(*head, str(case.tick), *means, end_section=case.last and not paper(look))
        if case.last and paper(look):
            table.add_row("", "published", "", *(printed(one) for one in look))
            table.add_row("", "", "", *(styled(one.comparison) for one in look), end_section=True)
    return table


def looks(made: list[Verdict]) -> list[list[Verdict]]:
    """The verdicts of each look."""
    found: dict[int, list[Verdict]] = {}
    for one in made:
        found.setdefault(id(one.case), []).append(one)
    return list(found.values())


def paper(look: list[Verdict]) -> bool:
    """Whether anything was published of it."""
    return any(one.published for one in look)


def printed(one: Verdict) -> str:
    """A published mean."""
    if one.published is None or one.published.average is None:
        return ""
    return shown(one.published.average)


def shown(value: float) -> str:
    """A mean with as many digits as are of use."""
    return f"{value:.2f}" if abs(value) < 10.0 else f"{value:.1f}"
