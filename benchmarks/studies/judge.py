"""How often words about runs are false, how wide their intervals are, and what they can decide.

Runs are drawn from laws whose mean is known, judged by `app/studies/judge/judge.py`, and
counted. Fixed seeds: the same numbers each time. An entry of p % has a standard error of
sqrt(p (100 - p) / M), with M the samples of a cell.

uv run python benchmarks/studies/judge.py [--samples 20000] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from app.studies.judge.judge import (  # noqa: E402
    CONFIDENCE,
    ConfidenceInterval,
    bounded_interval,
    confidence_of_look,
    estimate_mean,
    mean_interval,
    share_interval,
    subtract_means,
    subtract_published,
    typical_spread,
)

SAMPLES = 20_000
RUNS = (5, 7, 10, 20, 50, 100)
TABLE = 283
"""Answers of a table: those of all papers together."""
Law = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


def whole_number_law(deviation: float) -> Law:
    """Whole numbers near 12.23, less their mean."""
    from scipy.special import ndtr  # not scipy.stats: tests read this file, and it takes a second

    k = np.arange(-20, 60)
    p = ndtr((k + 0.5 - 12.23) / deviation) - ndtr((k - 0.5 - 12.23) / deviation)
    mean = float((k * p).sum())
    return lambda rng, shape: np.round(rng.normal(12.23, deviation, shape)) - mean


def crash_law(share: float, noise: float) -> Law:
    """Runs near +1 of which a share crashes far below; their mean is 0."""
    fall = -(1.0 - share) / share

    def draw(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
        crashed = rng.random(shape) < share
        return np.where(crashed, fall, 1.0) + rng.normal(0.0, noise, shape)

    return draw


def lognormal_law(s: float) -> Law:
    """exp of a normal law of deviation s, less its mean."""
    return lambda rng, shape: np.exp(rng.normal(0.0, s, shape)) - math.exp(0.5 * s * s)


MILD: dict[str, Law] = {
    "normal": lambda rng, shape: rng.normal(0.0, 1.0, shape),
    "t of 3": lambda rng, shape: rng.standard_t(3, shape),
    "uniform": lambda rng, shape: rng.uniform(-1.0, 1.0, shape),
    "whole, sd 0.5": whole_number_law(0.5),
    "whole, sd 1": whole_number_law(1.0),
    "whole, sd 1.8": whole_number_law(1.8),
    "Poisson(3)": lambda rng, shape: rng.poisson(3.0, shape) - 3.0,
}
"""Laws of which at most 1.5 % of the words may be false."""
SKEWED: dict[str, Law] = {
    "exponential": lambda rng, shape: rng.exponential(1.0, shape) - 1.0,
    "gamma(0.5)": lambda rng, shape: rng.gamma(0.5, 1.0, shape) - 0.5,
    "Weibull(0.7)": lambda rng, shape: rng.weibull(0.7, shape) - math.gamma(1.0 + 1.0 / 0.7),
    "lognormal(0.62)": lognormal_law(0.62),
    "lognormal(1)": lognormal_law(1.0),
}
"""Laws of which at most 2.5 % of the words may be false."""
LAWS = MILD | SKEWED
DEVIATION = {
    "normal": 1.0,
    "exponential": 1.0,
    "lognormal(1)": math.sqrt((math.e - 1.0) * math.e),
}
"""Standard deviations of the laws of which effects are to be seen."""


def draw(name: str, samples: int, runs: int, part: str = "") -> np.ndarray:
    """Runs (samples, runs) of a law, the same at each call."""
    rng = np.random.default_rng([2026, runs, zlib.crc32(f"{name}{part}".encode())])
    return np.asarray(LAWS[name](rng, (samples, runs)), float)


def student_interval(values: np.ndarray, confidence: float = CONFIDENCE) -> ConfidenceInterval:
    """Student's interval, to stand beside ours; no word of equal runs."""
    from scipy.special import stdtrit

    estimate = estimate_mean(values)
    half = stdtrit(estimate.freedom, 0.5 * (1.0 + confidence)) * estimate.error
    has_error = estimate.error > 0.0
    low = np.where(has_error, estimate.mean - half, -np.inf)
    return ConfidenceInterval(low, np.where(has_error, estimate.mean + half, np.inf))


def our_interval(values: np.ndarray, confidence: float = CONFIDENCE) -> ConfidenceInterval:
    """Ours."""
    return mean_interval(estimate_mean(values), confidence)


def excluded_share(limits: ConfidenceInterval, value: float | np.ndarray = 0.0) -> float:
    """In how many per cent of samples an interval says that a value is not the mean."""
    return 100.0 * float(np.mean((limits.low > value) | (limits.high < value)))


def false_words(name: str, runs: int, samples: int = SAMPLES, interval=our_interval) -> float:
    """Per cent of samples of which more, or less, than the true mean is said."""
    return excluded_share(interval(draw(name, samples, runs)))


def coverage(name: str, runs: int, samples: int = SAMPLES, interval=our_interval) -> float:
    """Per cent of 95 % intervals that hold the true mean."""
    return 100.0 - excluded_share(interval(draw(name, samples, runs), 0.95))


def effects_seen(
    name: str, runs: int, effect: float, samples: int = SAMPLES, interval=our_interval
) -> float:
    """Per cent of samples that show an effect of so many deviations; of the two sides the less."""
    limits = interval(draw(name, samples, runs))
    shift = effect * DEVIATION[name]
    return 100.0 * float(min(np.mean(limits.low > -shift), np.mean(limits.high < shift)))


def effects_seen_between(name: str, runs: int, samples: int = SAMPLES) -> float:
    """The same of a difference of one deviation between two samples."""
    values, other_values = draw(name, samples, runs), draw(name, samples, runs, "other")
    limits = mean_interval(subtract_means(estimate_mean(values), estimate_mean(other_values)))
    shift = DEVIATION[name]
    return 100.0 * float(min(np.mean(limits.low > -shift), np.mean(limits.high < shift)))


def agreement_share(name: str, runs: int, samples: int = SAMPLES) -> float:
    """Per cent of samples of which it is said, rightly, that their mean is within a deviation."""
    limits, shift = our_interval(draw(name, samples, runs)), DEVIATION[name]
    return 100.0 * float(np.mean((limits.low > -shift) & (limits.high < shift)))


def false_between(name: str, runs: int, other: str, other_runs: int, samples: int) -> float:
    """Per cent of pairs of samples of equal means that are told apart."""
    a = estimate_mean(draw(name, samples, runs))
    b = estimate_mean(draw(other, samples, other_runs, "other"))
    return excluded_share(mean_interval(subtract_means(a, b)))


def false_published(
    name: str, runs: int, published: int, samples: int, *, with_spread: bool
) -> float:
    """Per cent of samples that are told from a published mean of the same law."""
    estimate = estimate_mean(draw(name, samples, runs))
    published_values = draw(name, samples, published, "published")
    spread = published_values.std(axis=-1, ddof=1) if with_spread else None
    return excluded_share(
        mean_interval(
            subtract_published(estimate, published_values.mean(axis=-1), spread, published)
        )
    )


def false_agreement(name: str, runs: int, published: int, samples: int) -> float:
    """Per cent of samples that "agree" with a published mean one deviation off; the worse side."""
    values = draw(name, samples, runs)
    published_means = draw(name, samples, published, "published").mean(axis=-1)
    tolerance, shares = typical_spread(values), []
    for shift in (DEVIATION[name], -DEVIATION[name]):
        limits = mean_interval(
            subtract_published(estimate_mean(values), published_means + shift, None, published)
        )
        shares.append(np.mean((limits.low > -tolerance) & (limits.high < tolerance)))
    return 100.0 * float(max(shares))


def false_within(name: str, runs: int, samples: int, width: float = 0.3) -> float:
    """Per cent of samples said to be within +-width deviations, with the mean on the edge."""
    values = draw(name, samples, runs) / DEVIATION[name]
    limits = our_interval(values)
    inside = [
        (limits.low >= low) & (limits.high <= low + 2.0 * width) for low in (-2.0 * width, 0.0)
    ]
    return 100.0 * float(max(np.mean(inside[0]), np.mean(inside[1])))


def false_shares(share: float, runs: int) -> float:
    """Per cent of samples of successes whose exact interval excludes the true share: no drawing."""
    from scipy.stats import binom

    good = np.arange(runs + 1)
    limits = share_interval(good, runs)
    wrong = (limits.low > share) | (limits.high < share)
    return 100.0 * float(binom.pmf(good, runs, share)[wrong].sum())


def false_censored(name: str, runs: int, samples: int, given_up: float = 0.3) -> float:
    """Per cent of samples, 30 % of their runs given up, of which a false word is said."""
    values = draw(name, samples, runs)
    limit = float(np.quantile(draw(name, 200_000, 1, "limit"), 1.0 - given_up))
    open_ = values > limit
    least, most = np.where(open_, limit, values), np.where(open_, np.inf, values)
    return excluded_share(bounded_interval(least, most))


def false_rare(share: float, runs: int, samples: int, *, is_known: bool) -> float:
    """Per cent of samples with rare crashes called above their mean; `is_known`: their bound."""
    name, fall = f"crash {share:g}", -(1.0 - share) / share
    rng = np.random.default_rng([2026, runs, zlib.crc32(name.encode())])
    values = crash_law(share, 0.3)(rng, (samples, runs))
    bounds = (fall - 1.5, math.inf) if is_known else (-math.inf, math.inf)
    low = bounded_interval(values, values, bounds, rare=is_known).low
    return 100.0 * float(np.mean(low > 0.0))


def false_looks(name: str, samples: int, most: int = 160) -> float:
    """Per cent of samples of which a false word is said at 10, 20, 40 ... runs."""
    values, told = draw(name, samples, most), np.zeros(samples, bool)
    for runs in (10, 20, 40, 80, 160):
        limits = our_interval(values[:, :runs], confidence_of_look(10, most))
        told |= (limits.low > 0.0) | (limits.high < 0.0)
    return 100.0 * float(told.mean())


def false_tables(name: str, runs: int, tables: int = 400) -> float:
    """Per cent of tables of true nothings with a word that survives Holm at 1 %.

    Holm's first step is Bonferroni's, and a table has a false word if and only if it passes.
    """
    rng = np.random.default_rng([2026, runs, zlib.crc32(f"{name}table".encode())])
    values = np.asarray(LAWS[name](rng, (tables * TABLE, runs)), float)
    limits = our_interval(values, 1.0 - (1.0 - CONFIDENCE) / TABLE)
    false = (limits.low > 0.0) | (limits.high < 0.0)
    return 100.0 * float(false.reshape(tables, TABLE).any(axis=1).mean())


def measure(samples: int = SAMPLES) -> dict[str, dict[str, list[float]]]:
    """All tables: by title and row, an entry for each of `RUNS`."""
    fewer = samples // 2

    def rows(names, entry: Callable[[str, int], float]) -> dict[str, list[float]]:
        return {name: [entry(name, runs) for runs in RUNS] for name in names}

    tables = {
        "false words, Student's t": rows(
            LAWS, lambda n, r: false_words(n, r, samples, student_interval)
        ),
        "false words": rows(LAWS, lambda n, r: false_words(n, r, samples)),
        "95 % intervals that hold the mean, Student's t": rows(
            LAWS, lambda n, r: coverage(n, r, samples, student_interval)
        ),
        "95 % intervals that hold the mean": rows(LAWS, lambda n, r: coverage(n, r, samples)),
    }
    for effect in (0.5, 1.0, 2.0):
        tables[f"effects of {effect:g} sd that are seen"] = rows(
            DEVIATION, lambda n, r, e=effect: effects_seen(n, r, e, samples)
        )
    tables["differences of 1 sd between two samples that are seen"] = rows(
        DEVIATION, lambda n, r: effects_seen_between(n, r, fewer)
    )
    tables["true means that are said to be within 1 sd"] = rows(
        DEVIATION, lambda n, r: agreement_share(n, r, fewer)
    )
    tables["false words, two samples of equal size"] = rows(
        LAWS, lambda n, r: false_between(n, r, n, r, fewer)
    )
    tables["false words, lognormal(1) and normal"] = {
        f"{a}, {b}": [false_between("lognormal(1)", x, "normal", y, fewer) for x, y in sizes]
        for a, b, sizes in (
            ("n runs", "n runs", [(r, r) for r in RUNS]),
            ("5 runs", "n runs", [(5, r) for r in RUNS]),
            ("n runs", "5 runs", [(r, 5) for r in RUNS]),
        )
    }
    tables["false words, 5 and n runs of one law"] = rows(
        LAWS, lambda n, r: false_between(n, 5, n, r, fewer)
    )
    tables["false words, published mean of 100 runs alone"] = rows(
        LAWS, lambda n, r: false_published(n, r, 100, fewer, with_spread=False)
    )
    for published in (5, 20, 100):
        tables[f"false words, published mean and sd of {published} runs"] = rows(
            LAWS, lambda n, r, p=published: false_published(n, r, p, fewer, with_spread=True)
        )
    tables["false agreement, published mean of 100 runs 1 sd off"] = rows(
        DEVIATION, lambda n, r: false_agreement(n, r, 100, fewer)
    )
    tables["false words, the mean on the edge of +-0.3 sd"] = rows(
        DEVIATION, lambda n, r: false_within(n, r, fewer)
    )
    tables["false words, successes counted"] = {
        f"share {share:g}": [false_shares(share, runs) for runs in RUNS]
        for share in (0.02, 0.3, 0.5, 0.9)
    }
    tables["false words, 30 % of the runs given up"] = rows(
        ("normal", "exponential", "lognormal(0.62)", "lognormal(1)"),
        lambda n, r: false_censored(n, r, fewer),
    )
    for share in (0.1, 0.02):
        unseen = [100.0 * (1.0 - share) ** runs for runs in RUNS]
        tables[f"rare crashes of {share:g}, with noise: said to be above the mean"] = {
            "samples without a crash": unseen,
            "least value not known": [false_rare(share, r, fewer, is_known=False) for r in RUNS],
            "least value declared": [false_rare(share, r, fewer, is_known=True) for r in RUNS],
        }
    tables["false words, looks at 10, 20 ... 160 runs (first column)"] = {
        name: [false_looks(name, fewer)]
        for name in ("normal", "exponential", "lognormal(1)", "whole, sd 1")
    }
    tables[f"tables of {TABLE} true nothings with a false headline (10, 20, 50, 100 runs)"] = {
        name: [false_tables(name, runs) for runs in (10, 20, 50, 100)] for name in DEVIATION
    }
    return tables


def show(tables: dict[str, dict[str, list[float]]]) -> None:
    """Print the tables, in per cent."""
    for title, rows in tables.items():
        print(f"\n{title}, %\n{'runs':26}" + "".join(f"{runs:8}" for runs in RUNS))
        for name, entries in rows.items():
            print(f"{name:26}" + "".join(f"{entry:8.2f}" for entry in entries))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=SAMPLES, help="samples of a cell")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    options = parser.parse_args()
    tables = measure(options.samples)
    print(json.dumps(tables, indent=1)) if options.json else show(tables)


if __name__ == "__main__":
    main()
