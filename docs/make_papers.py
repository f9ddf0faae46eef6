"""Writes the pages of the papers from stored results of full runs.

    flockscope paper --all --json > results/all.json
    uv run python docs/make_papers.py [results/all.json ...]

Each template `NAME.md.in` of docs/ and docs/papers/ becomes the page `NAME.md` beside it. A line
of a template that is a name in braces stands for

    {EXPERIMENT}  tables and claims of that experiment, stored as `docs/papers/EXPERIMENT.json`
    {counted}     how many rows of the tables of Liu et al. 2021 agree
    {index}       a line for each paper with how many verdicts of each kind it has
    {changed}     verdicts that are others than in `docs/papers/before.json`
    {judge}       what `benchmarks/studies/judge.py --json` prints, kept in `docs/papers/judge.json`

Files of results, of all papers or of one, are stored first, with the pictures that pages show. A
test compares the pages with the templates and the stored results.
"""

from __future__ import annotations

import functools
import json
import re
import shutil
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from textwrap import fill
from typing import Any

from app.studies.experiment_reader import read_experiment
from app.studies.measure import Measure

DOCS = Path(__file__).parent
RESULTS = DOCS / "papers"
PLACEHOLDER = re.compile(r"^\{([\w.-]+)\}$", re.MULTILINE)
STORED = ("name", "title", "source", "claims")
STORED_OF_ROW = (
    *("label", "agents", "parameter", "value", "against", "at", "way", "tick"),
    *("measure", "unit", "commonest", "runs", "absent", "limit", "mean", "least", "most"),
    "published_mean",
    *("verdict", "needed", "because", "difference_low99", "difference_high99"),
    *("z", "d", "expected", "why"),
)
WIDTH = 118
"""Characters of a line of text."""
MOST_ROWS = 40
"""Rows beyond which a table is left to the picture."""
GIVEN_UP = "≥: some runs were given up, and count as the time at which that was."
BOLD = ("differs", "does not hold")
"""Verdicts that a reader looks for first."""
COLUMNS = {
    "agree, hold": ("agrees", "holds"),
    "differ, do not hold": BOLD,
    "undecided": ("undecided",),
    "by construction": ("by construction",),
}
"""Columns of the index, and the verdicts that each counts."""
LEAST_IS_WORST = ("95 %", "effects", "differences", "true means")
"""How lines of the judge's table begin of which the least value is the worst."""
JUDGED_RUNS = (5, 7, 10, 20, 50, 100)


def main() -> None:
    """Store the results of the files that are named, and write all pages."""
    for path in sys.argv[1:]:
        value = json.loads(Path(path).read_text(encoding="utf-8"))
        for outcome in value.get("papers", [value]):
            store_outcome(outcome)
    for page, text in pages().items():
        page.write_text(text, encoding="utf-8")


def store_outcome(outcome: dict[str, Any]) -> None:
    """Store an outcome, and its picture if a page shows it."""
    stored = {key: outcome[key] for key in STORED}
    stored["rows"] = [
        {key: row[key] for key in STORED_OF_ROW if key in row} for row in outcome["rows"]
    ]
    path = RESULTS / f"{outcome['name']}.json"
    path.write_text(json.dumps(stored, separators=(",", ":")) + "\n", encoding="utf-8")
    picture = outcome["files"].get("png")
    if picture and any(f"]({Path(picture).name})" in read(file) for file in paper_templates()):
        shutil.copyfile(picture, RESULTS / Path(picture).name)


def read(path: Path) -> str:
    """The text of a file."""
    return path.read_text(encoding="utf-8")


def load_result(experiment: str) -> dict[str, Any]:
    """The stored result of an experiment."""
    return json.loads(read(RESULTS / f"{experiment}.json"))


def paper_templates() -> list[Path]:
    """The templates of the pages of papers, by title."""
    return sorted(RESULTS.glob("*.md.in"), key=lambda template: title_of(template).casefold())


def title_of(template: Path) -> str:
    """The heading of a template, as "PAPER: what is repeated"."""
    return read(template).partition("\n")[0].removeprefix("# ")


def experiments_of(template: Path) -> list[str]:
    """The experiments whose results stand on the page of a paper."""
    names = PLACEHOLDER.findall(read(template))
    return [name for name in names if (RESULTS / f"{name}.json").exists()]


@functools.cache
def paper_pages() -> dict[str, str]:
    """Experiment -> file name of the page with its results."""
    return {
        name: template.stem for template in paper_templates() for name in experiments_of(template)
    }


def pages() -> dict[Path, str]:
    """Page -> its text, of all templates."""
    templates = [*sorted(DOCS.glob("*.md.in")), *paper_templates()]
    return {template.with_suffix(""): fill_template(read(template)) for template in templates}


def fill_template(template: str) -> str:
    """The text of a page: a template with what its placeholders stand for."""
    writers = {
        "counted": count_agreeing_rows,
        "index": index_table,
        "changed": changed_table,
        "judge": judge_table,
    }
    explained: set[tuple[str, str]] = set()

    def replacement(placeholder: re.Match[str]) -> str:
        name = placeholder[1]
        return writers[name]() if name in writers else format_result(name, explained)

    return PLACEHOLDER.sub(replacement, template)


def count_agreeing_rows() -> str:
    """How many rows of the two tables of Liu et al. 2021 have each verdict, in sentences."""
    times, successes = (
        [
            row.get("verdict")
            for row in load_result(name)["rows"]
            if row["measure"] == measure and row.get("verdict")
        ]
        for name, measure in (("liu2021-table1", "k_con"), ("liu2021-table2", "success"))
    )
    return fill(
        f"Of the {len(times)} rows of table 1, {count_verdicts(times)}. Of the {len(successes)} "
        f"success rates of table 2, {count_verdicts(successes)}.",
        WIDTH,
    )


def count_verdicts(verdicts: list[str]) -> str:
    """How many of each verdict there are.

    >>> count_verdicts(["agrees", "differs", "agrees", "undecided"])
    '2 agree, 1 differs and 1 is undecided'
    """
    words = {
        "agrees": ("agrees", "agree"),
        "differs": ("differs", "differ"),
        "undecided": ("is undecided", "are undecided"),
    }
    parts = [
        f"{verdicts.count(verdict)} {forms[verdicts.count(verdict) > 1]}"
        for verdict, forms in words.items()
        if verdict in verdicts
    ]
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if parts[1:] else parts[0]


def index_table() -> str:
    """A line for each page: its paper, its experiments, and how many verdicts it has of each."""
    total: Counter[str] = Counter()
    lines = [
        f"| paper | what is repeated | {' | '.join(COLUMNS)} |",
        f"|---|---|{'---:|' * len(COLUMNS)}",
    ]
    for template in paper_templates():
        paper, _, topic = title_of(template).partition(": ")
        experiments = experiments_of(template)
        counts = Counter(
            row.get("verdict")
            for name in experiments
            for row in [*load_result(name)["rows"], *load_result(name)["claims"]]
        )
        total += counts
        names = ", ".join(f"`{name}`" for name in experiments)
        lines.append(
            f"| [{paper}](papers/{template.stem}) | {topic}: {names} | {columns(counts)} |"
        )
    return "\n".join([*lines, f"| **all** | | {columns(total)} |"])


def columns(counts: Counter[str]) -> str:
    """The numbers of a line of the index."""
    return " | ".join(str(sum(counts[word] for word in words)) for words in COLUMNS.values())


def changed_table() -> str:
    """Verdicts that are others than those of the runs before, a line each."""
    lines = ["| experiment | row or claim | before | now |", "|---|---|---|---|"]
    for name, before in json.loads(read(RESULTS / "before.json")).items():
        now = verdicts_of(load_result(name))
        lines += [
            f"| `{name}` | {subject.strip()} | {verdict} | {now[subject]} |"
            for subject, verdict in before.items()
            if now.get(subject, verdict) != verdict
        ]
    return "\n".join(lines)


def verdicts_of(outcome: dict[str, Any]) -> dict[str, str]:
    """Row or claim -> verdict; the text of a claim without its measured numbers."""
    verdicts = {
        f"N = {row['agents']}, {case_of(row)[1]}, {row['measure']}": row["verdict"]
        for row in outcome["rows"]
        if row.get("verdict")
    }
    for claim in outcome["claims"]:
        text = re.split(r"[;(]| the mean changes by |, 99 %", claim["text"])[0]
        text = re.sub(r"(?<=[a-zA-Z])(?<! of) [-+]?[\d.]+(?=( <|\s*$| and|,))", "", text)
        verdicts[text] = claim["verdict"]
    return verdicts


def judge_table() -> str:
    """How often verdicts are false, or runs decide: of all laws that were drawn from, the worst."""
    lines = [
        f"| % of samples; runs: | {' | '.join(map(str, JUDGED_RUNS))} |",
        f"|---|{'---:|' * len(JUDGED_RUNS)}",
    ]
    for title, laws in json.loads(read(RESULTS / "judge.json")).items():
        heading = title.replace("words", "verdicts")
        worst = min if title.startswith(LEAST_IS_WORST) else max
        if "rare" in title:
            lines += [judge_line(f"{heading}, {law}", laws[law]) for law in laws]
        else:
            lines.append(judge_line(heading, map(worst, zip(*laws.values(), strict=True))))
    return "\n".join(lines)


def judge_line(heading: str, values: Iterable[float]) -> str:
    """A line of the judge's table; where there are fewer values they begin at 10 runs."""
    cells = [plain(value) for value in values]
    missing = len(JUDGED_RUNS) - len(cells)
    cells = [*cells, *[""] * missing] if len(cells) == 1 else [*[""] * missing, *cells]
    return f"| {heading} | {' | '.join(cells)} |"


def format_result(name: str, explained: set[tuple[str, str]]) -> str:
    """The tables and claims of an experiment, as Markdown; `explained`: measures so far."""
    outcome = load_result(name)
    measures = {measure.name: measure for measure in read_experiment(name).measures}
    compared = [row for row in outcome["rows"] if row.get("verdict")]
    others = [row for row in outcome["rows"] if not row.get("verdict")]
    ticks = [row["tick"] for row in others if row.get("tick") is not None]
    last = [row for row in others if row.get("tick") in (None, max(ticks, default=None))]
    is_shown = len({case_of(row) for row in last}) <= MOST_ROWS
    parts = [
        compared_table(compared, measures) if compared else "",
        measured_table(last, measures) if last and is_shown else "",
        explain_measures(measures.values(), explained),
        "\n".join(claim_line(claim) for claim in outcome["claims"]),
        known_reasons(compared, measures),
    ]
    return "\n\n".join(part for part in parts if part)


def case_of(row: dict[str, Any]) -> tuple[str, str]:
    """What a row is about: N and what tells it from other rows of that size."""
    text = row["label"]
    if row.get("parameter"):
        text += f", {row['parameter']} = {plain(row['value'])}"
    if row.get("at") is not None:
        text += f", {row['against']} = {plain(row['at'])}"
    if row.get("way"):
        text += f", {row['way']}"
    return str(row["agents"]), text


def compared_table(rows: list[dict[str, Any]], measures: dict[str, Measure]) -> str:
    """Measured beside published means, a line each."""
    lines = [
        "| N | row | measure | runs | mean | paper | difference, 99 % | z | d | verdict |",
        "|---:|---|---|---:|---:|---:|---:|---:|---:|---|",
    ]
    for row in rows:
        low, high = row["difference_low99"], row["difference_high99"]
        cells = [
            *case_of(row),
            measures[row["measure"]].symbol,
            str(row["runs"]),
            at_least(row) + plain(row["mean"]),
            plain(row["published_mean"]),
            "" if low is None else f"{plain(low)} to {plain(high)}",
            plain(row["z"]),
            plain(row["d"]),
            verdict_of(row),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return with_note("\n".join(lines))


def verdict_of(row: dict[str, Any]) -> str:
    """The verdict on a row or a claim, with what keeps it undecided."""
    verdict = f"**{row['verdict']}**" if row["verdict"] in BOLD else row["verdict"]
    if row["needed"]:
        return f"{verdict} (about {row['needed']} runs would decide)"
    return f"{verdict} ({row['because']})" if row.get("because") else verdict


def measured_table(rows: list[dict[str, Any]], measures: dict[str, Measure]) -> str:
    """Means with the least and the most: a line for each case, a column for each measure."""
    units = {row["measure"]: row["unit"] for row in rows}
    heads = [
        measures[name].symbol.replace("|", "\\|") + ("" if unit == "1" else f" / {unit}")
        for name, unit in units.items()
    ]
    lines = [f"| N | row | runs | {' | '.join(heads)} |", f"|---:|---|---:|{'---:|' * len(heads)}"]
    table: dict[tuple[str, str], dict[str, dict[str, Any]]] = {}
    for row in rows:
        table.setdefault(case_of(row), {})[row["measure"]] = row
    for (agents, case), by_measure in table.items():
        runs = max(row["runs"] + row["absent"] for row in by_measure.values())
        cells = [format_mean(by_measure.get(name)) for name in units]
        lines.append(f"| {agents} | {case} | {runs} | {' | '.join(cells)} |")
    return with_note("\n".join(lines))


def at_least(row: dict[str, Any]) -> str:
    """The sign before a mean of which runs that were given up are a part."""
    return "≥ " if row.get("limit") is not None else ""


def with_note(table: str) -> str:
    """A table, and what the sign in it means."""
    return f"{table}\n\n{GIVEN_UP}" if "≥" in table else table


def format_mean(row: dict[str, Any] | None) -> str:
    """A mean with the least and the most."""
    if row is None or row["mean"] is None:
        return ""
    if row.get("commonest"):
        return str(row["commonest"])
    sign = at_least(row)
    if row["least"] == row["most"]:
        return sign + plain(row["mean"])
    return f"{sign}{plain(row['mean'])} ({plain(row['least'])} to {sign}{plain(row['most'])})"


def explain_measures(measures: Iterable[Measure], explained: set[tuple[str, str]]) -> str:
    """What each measure is that the page has not explained so far."""
    new = [measure for measure in measures if (measure.symbol, measure.title) not in explained]
    explained.update((measure.symbol, measure.title) for measure in new)
    text = " ".join(f"*{measure.symbol}*: {measure.title}." for measure in new)
    return fill(text, WIDTH, break_long_words=False, break_on_hyphens=False)


def claim_line(claim: dict[str, Any]) -> str:
    """A claim and its verdict, a bullet."""
    why = f"; {claim['why']}" if claim["why"] else ""
    return f"- {verdict_of(claim)}: {claim['text']}{why}"


def known_reasons(rows: list[dict[str, Any]], measures: dict[str, Measure]) -> str:
    """Why rows are not as published, as far as it is known: a bullet for each reason."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row["expected"]:
            key = measures[row["measure"]].symbol, row["why"]
            reasons.setdefault(key, []).append(f"{row['label']} (N = {row['agents']})")
    return "\n".join(
        f"- {symbol} of {', '.join(cases)}: {why}" for (symbol, why), cases in reasons.items()
    )


def plain(value: float | str | bool | None) -> str:
    """A value with as many digits as are of use."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, str):
        return value
    return f"{value:.1f}" if abs(value) >= 100 else f"{value:.3g}"


if __name__ == "__main__":
    main()
