"""Parameters that differ from agent to agent: distributions, what is drawn of them, and by hand.

Each agent's number follows from the run's seed, the parameter's name and the agent's identity: one
agent more changes nobody else's, and another mean or spread moves all numbers smoothly.
"""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from agents.engine.noise import BEYOND, uniform_numbers
from worlds.input_error import InputError, shorten, unknown

DRAWN = 5 * BEYOND
"""The first of the ticks of these draws, one for each name and attempt: see
`agents.engine.noise.BEYOND`."""
ATTEMPTS = 1000
"""How often a number is drawn until it is in the parameter's range."""
MOST_DRAWS = 50
"""How often numbers are drawn again on average at most, so that a fiftieth of them is inside."""


@dataclass(frozen=True)
class Distribution:
    """What agents' numbers of one parameter are drawn from; made by `normal` and its like.

    `each` without numbers stands for numbers that were given by hand, agent by agent.
    """

    kind: str
    numbers: tuple[float, ...]

    def __str__(self) -> str:
        """As it is written on a command line; of numbers given agent by agent how many there are.

        >>> str(normal(3, 0.5))
        'normal(3, 0.5)'
        """
        if self.kind == "each":
            return f"each of {len(self.numbers)} agents" if self.numbers else "by hand"
        return self.to_text()

    def to_text(self) -> str:
        """As `as_distribution` reads it back to the bit.

        >>> each([0.5, 1 / 3]).to_text()
        'each(0.5, 0.3333333333333333)'
        """
        short = [f"{number:g}" for number in self.numbers]
        numbers = zip(short, self.numbers, strict=True)
        exact = [text if float(text) == number else repr(number) for text, number in numbers]
        return f"{self.kind}({', '.join(exact)})"

    def to_value(self) -> dict[str, list[float]]:
        """As TOML and JSON have it.

        >>> uniform(1, 2).to_value()
        {'uniform': [1.0, 2.0]}
        """
        return {self.kind: list(self.numbers)}

    @property
    def is_by_hand(self) -> bool:
        """Whether the numbers were given agent by agent, so that only the flock knows them."""
        return self.kind == "each" and not self.numbers

    @property
    def centre(self) -> float:
        """Its mean; of numbers given agent by agent their median."""
        if self.kind in ("normal", "lognormal"):
            return self.numbers[0]
        return float(np.median(self.numbers) if self.kind == "each" else np.mean(self.numbers))

    @property
    def spread(self) -> float:
        """Its standard deviation; of `uniform` half its width."""
        if self.kind in ("normal", "lognormal"):
            return self.numbers[1]
        if self.kind == "uniform":
            return 0.5 * (self.numbers[1] - self.numbers[0])
        return float(np.std(self.numbers))

    def with_moments(self, mean: float | None = None, spread: float | None = None) -> Distribution:
        """The same kind of distribution with another mean, another spread, or both.

        `spread`, >= 0, is as the property has it: of `uniform` half its width. Raises InputError
        for values that are listed one by one, `one_of` and `each`, and for what is not allowed.

        >>> str(uniform(1, 3).with_moments(spread=0.5)), str(normal(3, 1).with_moments(mean=4))
        ('uniform(1.5, 2.5)', 'normal(4, 1)')
        """
        if self.kind not in ("normal", "lognormal", "uniform"):
            raise InputError(
                f"{self} has no mean and no spread to set: normal, lognormal and uniform have"
            )
        mean = self.centre if mean is None else mean
        spread = self.spread if spread is None else spread
        if self.kind == "uniform":
            return distribution(self.kind, (mean - spread, mean + spread))
        return distribution(self.kind, (mean, spread))

    def draw(self, seed: int, name: str, ids: np.ndarray, attempt: int = 0) -> np.ndarray:
        """A number for each identity (N,); those of `each` are given in this order."""
        if self.kind == "each":
            return np.array(self.numbers)
        tick = DRAWN + (attempt << 32) + zlib.crc32(name.encode())
        chance = uniform_numbers(seed, tick, ids, 1)[:, 0]
        return DISTRIBUTIONS[self.kind](chance, *self.numbers)

    def about(self, centre: float) -> Distribution:
        """The same spread about another centre: a slider that moves all agents does so.

        >>> str(normal(3, 0.5).about(2)), str(uniform(1, 2).about(3))
        ('normal(2, 0.5)', 'uniform(2.5, 3.5)')

        Raises InputError for a `lognormal` about 0 or less.
        """
        if self.kind in ("normal", "lognormal"):
            return distribution(self.kind, (centre, self.numbers[1]))
        shift = centre - self.centre
        return Distribution(self.kind, tuple(number + shift for number in self.numbers))


BY_HAND = Distribution("each", ())
"""Numbers that were given agent by agent, of which the flock's arrays alone know."""


def quantiles(chance: np.ndarray) -> np.ndarray:
    """The quantiles (N,) of the normal distribution at probabilities in [0, 1)."""
    # A number in [0, 1) is a multiple of 2^-53: half of one more is never 0.
    inverse = NormalDist().inv_cdf
    return np.array([inverse(u) for u in (chance + 2.0**-54).tolist()], float)


def draw_normal(chance: np.ndarray, mean: float, deviation: float) -> np.ndarray:
    """Numbers (N,) of a normal distribution."""
    return mean + deviation * quantiles(chance)


def draw_lognormal(chance: np.ndarray, mean: float, deviation: float) -> np.ndarray:
    """Numbers (N,) whose logarithms are normal, with a mean and a deviation of their own."""
    variance = math.log1p((deviation / mean) ** 2)
    exponent = math.log(mean) - 0.5 * variance + math.sqrt(variance) * quantiles(chance)
    return np.array([math.exp(one) for one in exponent.tolist()], float)


def draw_uniform(chance: np.ndarray, low: float, high: float) -> np.ndarray:
    """Numbers (N,) spread evenly between two."""
    return low + (high - low) * chance


def draw_one_of(chance: np.ndarray, *values: float) -> np.ndarray:
    """One (N,) of some values, each as likely."""
    return np.asarray(values)[(chance * len(values)).astype(int)]


DISTRIBUTIONS: dict[str, Callable[..., np.ndarray]] = {
    "normal": draw_normal,
    "lognormal": draw_lognormal,
    "uniform": draw_uniform,
    "one_of": draw_one_of,
}
KINDS = (*DISTRIBUTIONS, "each")


def normal(mean: float, deviation: float) -> Distribution:
    """Numbers of a normal distribution with a mean and a standard deviation >= 0.

    Numbers outside of the parameter's range are drawn again. Raises InputError.

    >>> from flockscope import Flock, normal
    >>> flock = Flock("couzin", agents=50, s=normal(3, 0.5), rng=1)
    >>> flock.own["s"].shape
    (50,)
    """
    return distribution("normal", (mean, deviation))


def lognormal(mean: float, deviation: float) -> Distribution:
    """Numbers above 0 whose logarithms are normal; their own mean and deviation. Or InputError."""
    return distribution("lognormal", (mean, deviation))


def uniform(low: float, high: float) -> Distribution:
    """Numbers that are as likely anywhere between two. Raises InputError."""
    return distribution("uniform", (low, high))


def one_of(*values: float) -> Distribution:
    """Each agent has one of these values, each as likely. Raises InputError."""
    return distribution("one_of", values)


def each(values: Any) -> Distribution:
    """The value of each agent, in the order of the flock's rows. Raises InputError."""
    return distribution("each", values)


def distribution(kind: str, numbers: Any, origin: str = "") -> Distribution:
    """A distribution of a kind with its numbers. Raises InputError naming what is wrong."""
    location = f" ({origin})" if origin else ""
    if kind not in KINDS:
        raise unknown("distribution", kind, KINDS, origin)
    try:
        array = np.asarray([numbers] if np.ndim(numbers) == 0 else list(numbers), float)
        is_bool = any(isinstance(number, bool) for number in np.ravel(numbers).tolist())
    except (TypeError, ValueError):
        array, is_bool = np.empty(0), False
    whole = f"{kind}({shorten(numbers).strip('[]()')})"
    if array.ndim != 1 or not len(array) or is_bool or not np.isfinite(array).all():
        raise InputError(f"{whole} is not allowed: finite numbers are needed{location}")
    if kind in ("normal", "lognormal", "uniform") and len(array) != 2:
        needs = "a low and a high" if kind == "uniform" else "a mean and a standard deviation"
        raise InputError(f"{whole} is not allowed: {needs} are needed{location}")
    if kind in ("normal", "lognormal") and array[1] < 0.0:
        raise InputError(f"{whole} is not allowed: a standard deviation is >= 0{location}")
    if kind == "lognormal" and array[0] <= 0.0:
        raise InputError(f"{whole} is not allowed: the mean of a lognormal is > 0{location}")
    if kind == "uniform" and array[0] > array[1]:
        raise InputError(f"{whole} is not allowed: the low comes first{location}")
    return Distribution(kind, tuple(array.tolist()))


WRITTEN = re.compile(rf"\s*({'|'.join(KINDS)})\s*(?:\((.*)\)|:(.*))\s*")
"""A distribution as a person types it: `normal(3, .5)`, or `normal:3:0.5`, which needs no quotes in
a shell."""


def as_distribution(value: Any, origin: str = "") -> Distribution | None:
    """The distribution that a value is or describes, None for one number or word.

    >>> as_distribution("normal(3, .5)") == as_distribution({"normal": [3, 0.5]}) == normal(3, 0.5)
    True
    >>> as_distribution(3.0) is None and as_distribution("nearest") is None
    True

    A list or an array is what `each` takes. Raises InputError.
    """
    if isinstance(value, Distribution):
        return value
    if isinstance(value, Mapping):
        if len(value) != 1:
            raise InputError(
                f"{shorten(dict(value))} is not a distribution: one of {', '.join(KINDS)} with its "
                f"numbers is needed{f' ({origin})' if origin else ''}"
            )
        kind, numbers = next(iter(value.items()))
        return distribution(str(kind), numbers, origin)
    if isinstance(value, list | tuple | np.ndarray) and np.ndim(value) > 0:
        return distribution("each", value, origin)
    match = WRITTEN.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return None
    kind, inside, behind = match.groups()
    parts = inside.split(",") if inside is not None else behind.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise InputError(
            f"{value.strip()} is not allowed: finite numbers are needed"
            f"{f' ({origin})' if origin else ''}"
        ) from None
    return distribution(kind, numbers, origin)


def moved(before: Any, value: Any) -> Any:
    """A value that a slider gives a parameter: about it where agents differ, so that the spread
    stays. Raises InputError."""
    return before.about(float(value)) if isinstance(before, Distribution) else value


def split_individuals(
    values: Mapping[str, Any], origin: str = ""
) -> tuple[dict[str, Any], dict[str, Distribution]]:
    """Parameters that all agents share, and those that differ, which all share by their mean."""
    individuals = {}
    shared = dict(values)
    for name, value in values.items():
        try:
            found = as_distribution(value)
        except InputError as error:
            raise InputError(f"{name}: {error}{f' ({origin})' if origin else ''}") from None
        if found is not None:
            individuals[name] = found
            shared[name] = found.centre
    return shared, individuals


def draw_values(
    drawn_from: Distribution,
    seed: int,
    name: str,
    ids: np.ndarray,
    bounds: tuple[float, float],
) -> tuple[np.ndarray, int]:
    """A number (N,) within bounds for each identity, and how many were drawn again for that.

    Raises InputError for numbers of `each` that are outside, naming the first, and for a
    distribution of which next to nothing is inside.
    """
    low, high = bounds
    if drawn_from.kind == "each" and len(drawn_from.numbers) != len(ids):
        raise InputError(
            f"{name} has {len(drawn_from.numbers)} values for {len(ids)} agents: one each is needed"
        )
    values = drawn_from.draw(seed, name, ids)
    outside = np.flatnonzero((values < low) | (values > high))
    if drawn_from.kind == "each" and len(outside):
        row = int(outside[0])
        raise InputError(f"{name} = {values[row]:g} in row {row} is outside [{low:g}, {high:g}]")
    redrawn = len(outside)
    most = ATTEMPTS + MOST_DRAWS * len(ids)  # else a large flock is drawn for minutes in vain
    for attempt in range(1, ATTEMPTS + 1):
        if not len(outside):
            return values, redrawn
        most -= len(outside)
        if most < 0:
            break
        values[outside] = drawn_from.draw(seed, name, ids[outside], attempt)
        outside = outside[(values[outside] < low) | (values[outside] > high)]
    raise InputError(
        f"{name} = {drawn_from} is not allowed: next to nothing of it is in [{low:g}, {high:g}]"
    )
