"""Writes docs/papers.md from its text and from stored results of full runs.

    uv run flockscope paper --all --json > results/all.json
    uv run python docs/make_papers.py [results/all.json]

With a file, its results are stored beside the text first, as `docs/papers/NAME.json`, and the
pictures that it names with them. A line `{NAME}` of the text becomes the table and the claims of
that experiment. A test holds the page against both.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent / "papers"
TEXT, PAGE = HERE / "papers.md.in", HERE.parent / "papers.md"
KEPT = ("name", "title", "source", "claims")
ROW = (
    *("label", "agents", "parameter", "value", "against", "at", "way", "tick"),
    *("measure", "unit", "commonest", "runs", "absent", "mean", "least", "most", "published_mean"),
    *("verdict", "needed", "because", "difference_low99", "difference_high99"),
    *("z", "d", "expected", "why"),
)
"""What is kept of an outcome, and of its rows as far as they have it."""
MOST_ROWS = 40
"""Rows beyond which a table is left to the picture."""
SIGNS = {"holds": "holds", "does not hold": "**does not hold**", "differs": "**differs**"}


def main() -> None:
    """Store results if there are any, and write the page."""
    if len(sys.argv) > 1:
        for one in json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))["papers"]:
            store(one)
    PAGE.write_text(page(), encoding="utf-8")


def store(outcome: dict[str, Any]) -> None:
    """Keep an outcome, and its picture where the text shows it."""
    kept = {key: outcome[key] for key in KEPT}
    kept["rows"] = [{key: row[key] for key in ROW if key in row} for row in outcome["rows"]]
    path = HERE / f"{outcome['name']}.json"
    path.write_text(json.dumps(kept, separators=(",", ":")) + "\n", encoding="utf-8")
    picture = outcome["files"].get("png")
    if picture and f"papers/{Path(picture).name})" in TEXT.read_text(encoding="utf-8"):
        shutil.copyfile(picture, HERE / Path(picture).name)


def page() -> str:
    """The page: the text with tables and claims in the places of their names."""
    text = TEXT.read_text(encoding="utf-8")
    return re.sub(r"^\{([\w.-]+)\}$", lambda found: block(found[1]), text, flags=re.M)


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
        numbers = (row["mean"], row["published_mean"])
        cells = [n, of, row["measure"], str(row["runs"]), *(plain(one) for one in numbers), between]
        lines.append("| " + " | ".join([*cells, plain(row["z"]), plain(row["d"]), verdict]) + " |")
    return "\n".join(lines)


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
    return "\n".join(lines)


def mean_of(row: dict[str, Any] | None) -> str:
    """A mean with the least and the most."""
    if row is None or row["mean"] is None:
        return ""
    if row.get("commonest"):
        return str(row["commonest"])
    if row["least"] == row["most"]:
        return plain(row["mean"])
    return f"{plain(row['mean'])} ({plain(row['least'])} to {plain(row['most'])})"


def said(claim: dict[str, Any]) -> str:
    """A claim and its answer, a bullet."""
    answer = SIGNS.get(claim["verdict"], claim["verdict"])
    if claim["needed"]:
        answer += f" (about {claim['needed']} runs would decide)"
    why = f"; {claim['why']}" if claim["why"] else ""
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
