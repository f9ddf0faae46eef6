"""Writes docs/papers.md from stored results of full runs.

    flockscope paper --all --json > results/all.json
    uv run python docs/make_papers.py [results/all.json ...]

With files, of all papers or of one, their results are stored beside the text first, as
`docs/papers/NAME.json`, and the pictures that they name with them. A line `{NAME}` of the text
becomes the table and the claims of that experiment, `{counted}` how many rows of Liu et al. 2021
agree, `{changed}` the words that are others than in `docs/papers/before.json`, `{judge}` what
`benchmarks/studies/judge.py --json` has printed into `docs/papers/judge.json`. A test holds the
page against all of them.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path
from textwrap import fill
from typing import Any

HERE = Path(__file__).parent / "papers"
TEXT, PAGE = HERE / "papers.md.in", HERE.parent / "papers.md"
BEFORE = HERE / "before.json"
"""The words of the runs with random numbers 1, by experiment and by what they were said of."""
KEPT = ("name", "title", "source", "claims")
ROW = (
    *("label", "agents", "parameter", "value", "against", "at", "way", "tick"),
    *("measure", "unit", "commonest", "runs", "absent", "limit", "mean", "least", "most"),
    "published_mean",
    *("verdict", "needed", "because", "difference_low99", "difference_high99"),
    *("z", "d", "expected", "why"),
)
"""What is kept of an outcome, and of its rows as far as they have it."""
WIDTH = 118
"""Of a line of text."""
MOST_ROWS = 40
"""Rows beyond which a table is left to the picture."""
GIVEN_UP = "≥: some runs were given up, and count as the time at which that was."
SIGNS = {"holds": "holds", "does not hold": "**does not hold**", "differs": "**differs**"}


def main() -> None:
    """Store results if there are any, and write the page."""
    for path in sys.argv[1:]:
        read = json.loads(Path(path).read_text(encoding="utf-8"))
        for one in read.get("papers", [read]):
            store(one)
    PAGE.write_text(page(), encoding="utf-8")


def store(outcome: dict[str, Any]) -> None:
    """Keep an outcome, and its picture where it is shown."""
    kept = {key: outcome[key] for key in KEPT}
    kept["rows"] = [{key: row[key] for key in ROW if key in row} for row in outcome["rows"]]
    path = HERE / f"{outcome['name']}.json"
    path.write_text(json.dumps(kept, separators=(",", ":")) + "\n", encoding="utf-8")
    picture = outcome["files"].get("png")
    if picture and f"papers/{Path(picture).name})" in TEXT.read_text(encoding="utf-8"):
        shutil.copyfile(picture, HERE / Path(picture).name)


def words_of(outcome: dict[str, Any]) -> dict[str, str]:
    """The words that an experiment gives, by what they are said of: rows, and claims as far as
    their text is no measured number."""
    rows = [row for row in outcome["rows"] if row.get("verdict")]
    found = {f"N = {row['agents']}, {row_of(row)[1]}, {row['measure']}": row for row in rows}
    for claim in outcome["claims"]:
        text = re.split(r"[;(]| the mean changes by |, 99 %", claim["text"])[0]
        found[re.sub(r"(?<=[a-zA-Z])(?<! of) [-+]?[\d.]+(?=( <|\s*$| and|,))", "", text)] = claim
    return {what: one["verdict"] for what, one in found.items()}


def page() -> str:
    """The page: the text with tables and claims in the places of their names."""
    text = TEXT.read_text(encoding="utf-8")
    made = {"counted": count_agreeing_rows, "judge": judge_table, "changed": changed_list}
    return re.sub(
        r"^\{([\w.-]+)\}$",
        lambda found: made[found[1]]() if found[1] in made else block(found[1]),
        text,
        flags=re.M,
    )


def count_agreeing_rows() -> str:
    """How many rows of the two tables of Liu et al. 2021 have each verdict."""
    one, other = (
        stored(f"liu2021-table{k}", measure) for k, measure in ((1, "k_con"), (2, "success"))
    )
    said = (
        f"Of the {len(one)} rows of table 1 of Liu et al. 2021, {count_words(one)}. "
        f"Of the {len(other)} success rates of table 2, whose scene is known from a picture only, "
        f"{count_words(other)}."
    )
    return fill(said, WIDTH)


def stored(name: str, measure: str) -> list[dict[str, Any]]:
    """The rows of a stored result that are compared by a measure."""
    rows = json.loads((HERE / f"{name}.json").read_text(encoding="utf-8"))["rows"]
    return [row for row in rows if row["measure"] == measure and row.get("verdict")]


def count_words(rows: list[dict[str, Any]]) -> str:
    """How many rows have each word.

    >>> count_words([{"verdict": "agrees"}, {"verdict": "differs"}, {"verdict": "agrees"}])
    '2 agree and 1 differs'
    """
    words = {"agrees": "agree", "differs": "differ", "undecided": "undecided"}
    counts = {word: sum(row["verdict"] == word for row in rows) for word in words}
    said = [f"{n} {word if n == 1 else words[word]}" for word, n in counts.items() if n]
    return " and ".join([", ".join(said[:-1]), said[-1]]) if said[1:] else said[0]


def changed_list() -> str:
    """The words that are others than of the runs before, by experiment."""
    lines = []
    for name, before in json.loads(BEFORE.read_text(encoding="utf-8")).items():
        now = words_of(json.loads((HERE / f"{name}.json").read_text(encoding="utf-8")))
        lines += [
            f"- `{name}`: {what}: {word} before, now {now[what]}"
            for what, word in before.items()
            if now.get(what, word) != word
        ]
    return "\n".join(lines)


def judge_table() -> str:
    """False words, coverage and power: of all laws that were drawn from, the worst."""
    lines = ["| % of samples; runs: | 5 | 7 | 10 | 20 | 50 | 100 |", "|---|" + "---:|" * 6]
    for what, laws in json.loads((HERE / "judge.json").read_text(encoding="utf-8")).items():
        good = what.startswith(("95 %", "effects", "differences", "true means"))
        shown = {f"{what}, {law}": [law] for law in laws} if "rare" in what else {what: list(laws)}
        for line, of in shown.items():
            columns = zip(*(laws[law] for law in of), strict=True)
            cells = [plain((min if good else max)(column)) for column in columns]
            before = [""] * (6 - len(cells) if len(cells) > 1 else 0)  # tables begin at 10 runs
            cells = [*before, *cells, *[""] * 5][:6]
            lines.append(f"| {line} | {' | '.join(cells)} |")
    return "\n".join(lines)


def block(name: str) -> str:
    """The tables and claims of an experiment, as Markdown."""
    outcome = json.loads((HERE / f"{name}.json").read_text(encoding="utf-8"))
    rows = outcome["rows"]
    compared = [row for row in rows if row.get("verdict")]
    parts = [compared_table(compared)] if compared else []
    others = [row for row in rows if not row.get("verdict")]
    last = [row for row in others if row.get("tick") in (None, latest(others))]
    if last and len({row_of(row) for row in last}) <= MOST_ROWS:
        parts.append(measured_table(last))
    if outcome["claims"]:
        parts.append("\n".join(said(one) for one in outcome["claims"]))
    known = dict.fromkeys(expected(row) for row in compared)
    parts.append("\n".join(line for line in known if line))
    return "\n\n".join(part for part in parts if part)


def latest(rows: list[dict[str, Any]]) -> int | None:
    """The last tick at which runs were measured."""
    return max((row["tick"] for row in rows if row.get("tick") is not None), default=None)


def row_of(row: dict[str, Any]) -> tuple[str, str]:
    """What a row is of: N and what tells it apart."""
    of = row["label"]
    if row.get("parameter"):
        of += f", {row['parameter']} = {plain(row['value'])}"
    if row.get("at") is not None:
        of += f", {row['against']} = {plain(row['at'])}"
    if row.get("way"):
        of += f", {row['way']}"
    return str(row["agents"]), of


def compared_table(rows: list[dict[str, Any]]) -> str:
    """Measured beside published, a line each."""
    lines = [
        "| N | | measure | runs | mean | paper | difference, 99 % | z | d | |",
        "|---:|---|---|---:|---:|---:|---:|---:|---:|---|",
    ]
    for row in rows:
        n, of = row_of(row)
        low, high = row["difference_low99"], row["difference_high99"]
        between = "" if low is None else f"{plain(low)} to {plain(high)}"
        verdict = SIGNS.get(row["verdict"], row["verdict"])
        if row["needed"]:
            verdict += f", about {row['needed']} runs would decide"
        elif row.get("because"):
            verdict += f": {row['because']}"
        mean = at_least(row) + plain(row["mean"])
        cells = [
            n,
            of,
            row["measure"],
            str(row["runs"]),
            mean,
            plain(row["published_mean"]),
            between,
        ]
        lines.append("| " + " | ".join([*cells, plain(row["z"]), plain(row["d"]), verdict]) + " |")
    return with_sign("\n".join(lines))


def measured_table(rows: list[dict[str, Any]]) -> str:
    """What was measured, a line for each row and a column for each measure; least and most."""
    measures = list(dict.fromkeys((row["measure"], row["unit"]) for row in rows))
    heads = [name if unit == "1" else f"{name} / {unit}" for name, unit in measures]
    lines = [f"| N | | runs | {' | '.join(heads)} |", f"|---:|---|---:|{'---:|' * len(heads)}"]
    table: dict[tuple[str, str], dict[str, dict[str, Any]]] = {}
    for row in rows:
        table.setdefault(row_of(row), {})[row["measure"]] = row
    for (n, of), found in table.items():
        runs = max(row["runs"] + row["absent"] for row in found.values())
        cells = [mean_of(found.get(name)) for name, _ in measures]
        lines.append(f"| {n} | {of} | {runs} | {' | '.join(cells)} |")
    return with_sign("\n".join(lines))


def at_least(row: dict[str, Any]) -> str:
    """The sign before a mean of which runs that were given up are a part."""
    return "≥ " if row.get("limit") is not None else ""


def with_sign(table: str) -> str:
    """A table, and what the sign in it means."""
    return f"{table}\n\n{GIVEN_UP}" if "≥" in table else table


def mean_of(row: dict[str, Any] | None) -> str:
    """A mean with the least and the most."""
    if row is None or row["mean"] is None:
        return ""
    if row.get("commonest"):
        return str(row["commonest"])
    sign = at_least(row)
    if row["least"] == row["most"]:
        return sign + plain(row["mean"])
    return f"{sign}{plain(row['mean'])} ({plain(row['least'])} to {sign}{plain(row['most'])})"


def said(claim: dict[str, Any]) -> str:
    """A claim and its answer, a bullet."""
    answer = SIGNS.get(claim["verdict"], claim["verdict"])
    if claim["needed"]:
        answer += f" (about {claim['needed']} runs would decide)"
    why = f"; {claim['why']}" if claim["why"] else ""
    if claim.get("because") and not claim["needed"]:
        answer += f" ({claim['because']})"
    return f"- {answer}: {claim['text']}{why}"


def expected(row: dict[str, Any]) -> str:
    """What is known of a row that differs, a bullet."""
    if not row["expected"]:
        return ""
    return (
        f"- {row['label']}, N = {row['agents']}, {row['measure']}: {row['verdict']}; {row['why']}"
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
