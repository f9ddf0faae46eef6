"""A laboratory in one small file: its area, cars, tracking, link and rule; an example of it."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import tomlkit
from pydantic import Field, ValidationError, model_validator

from app.live.control.control_loop import RATE
from app.live.control.injected_target import INJECTED, Injection
from app.live.control.pose import TrackingArea
from app.live.control.safety import Safety
from app.live.control.safety_limits import CarLimits, SafetyLimits
from app.live.device_kinds import (
    BUILT_IN_NAMES,
    DRY,
    FILE,
    RECORDED,
    SIMULATED,
    demand_name,
    kind_of,
    name_of,
    port_of,
)
from app.live.laboratory.recording_parts import RecordingLimits
from app.live.links.command_frame import LEAST_ADDRESS, MOST_ADDRESS, MOST_CARS
from app.live.links.link_catalogue import known_link
from app.live.sources.source_catalogue import known_source
from app.strict_table import StrictTable, Value
from worlds.input_error import InputError, needed, shorten, unknown
from worlds.text_file import read_text, toml

KeyPath = tuple[str, ...]


def find_line(text: str, keys: Sequence[str]) -> int | None:
    """The line (from 1) that sets a key, given the keys that lead to it.

    Where nothing sets it, the table that lacks it; None if that cannot be found either.

    >>> find_line("title = 'a'\\n[cars.red]\\naddress = 1", ["cars", "red", "address"])
    3
    >>> find_line("title = 'a'\\n[cars.red]\\nspeed = 1", ["cars", "red", "address"])
    2
    """
    best, last_line = 0, None
    for number, path in settings(text):
        if len(path) > best and tuple(keys[: len(path)]) == path:
            best, last_line = len(path), number
    return last_line


def settings(text: str) -> Iterator[tuple[int, KeyPath]]:
    """What each line sets, as the keys that lead to it; tables within braces too."""
    table: KeyPath = ()
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("["):
            paths = list(paths_of(parse_line(line)))
            if paths:
                table = paths[-1]
                yield number, table
            continue
        key, equals, _ = line.partition("=")
        if equals:
            # a value that goes on in the next lines cannot be parsed by itself; its key can
            for path in paths_of(parse_line(line) or parse_line(f"{key} = 0")):
                yield number, (*table, *path)


def parse_line(line: str) -> dict[str, Any]:
    """One line as TOML; empty if it is none by itself."""
    try:
        return tomllib.loads(line)
    except tomllib.TOMLDecodeError:
        return {}


def paths_of(values: dict[str, Any]) -> Iterator[KeyPath]:
    """All keys of nested tables, the outer ones first."""
    for key, value in values.items():
        yield (key,)
        if isinstance(value, dict):
            for path in paths_of(value):
                yield (key, *path)


# Checks that the sources and links of a laboratory's file fit together, by their texts alone.

KNOWN = {"sources": known_source, "links": known_link}


class LabFileConflict(ValueError):
    """Values of a laboratory's file that contradict each other, and the keys that lead to them."""

    def __init__(self, words: str, *keys: str):
        super().__init__(words)
        self.keys = keys


def check_text(demand: Callable[[str], object], text: str, *keys: str) -> None:
    """Demand something of a text at these keys. Raises Misfit where `demand` raises InputError."""
    try:
        demand(text)
    except InputError as refused:
        raise LabFileConflict(str(refused), *keys) from None


def demand_matching_ends(source: str, link: str, follows_body: bool) -> None:
    """Source and link are both simulated, or neither is; a simulated injected car has no body.

    Raises Misfit.
    """
    if kind_of(source) != SIMULATED:
        if kind_of(link) == SIMULATED:
            raise LabFileConflict(
                f"link = {link!r} needs source = {SIMULATED!r}, not {source!r}", "link"
            )
        return
    if source != SIMULATED:
        raise LabFileConflict(
            f"source = {source!r} is of software and has no place: {SIMULATED}", "source"
        )
    if kind_of(link) not in (SIMULATED, DRY):
        raise LabFileConflict(
            f"source = {SIMULATED!r} needs link = {SIMULATED!r} or {DRY!r}, not {link!r}", "link"
        )
    if kind_of(link) == SIMULATED:
        check_text(port_of, link, "link")
    if follows_body:
        raise LabFileConflict(
            'injected.path = "body" cannot be emulated: use "circle", "hand" or "none" there',
            "injected",
            "path",
        )


def demand_choices(table: str, own: str, others: Mapping[str, str]) -> None:
    """The names of what may be chosen differ, and their texts are those of sources or links.

    `table` is `sources` or `links`, `own` the one that the file begins with. Raises Misfit.
    """
    names = [name_of(own), *BUILT_IN_NAMES.values()]
    for name, text in others.items():
        check_text(partial(demand_name, others=names), name, table, name)
        names.append(name)
        if kind_of(text) == SIMULATED:
            words = f"{text!r} can be chosen anyway, as {BUILT_IN_NAMES[SIMULATED]!r}"
            raise LabFileConflict(words, table, name)
        check_text(KNOWN[table], text, table, name)


MOST_SIMULATED = 32
"""Simulated cars beside real ones: with more, a tick would not be done in time."""


class LabCar(CarLimits):
    """A car: its address on the link, its body in the tracking, and its limits."""

    address: int = Field(ge=LEAST_ADDRESS, le=MOST_ADDRESS)
    body: str = ""
    """The name of its rigid body; empty: its own name."""


class SimulatedCars(StrictTable):
    """Simulated cars beside the real ones: same rule, same world, hearing each other."""

    cars: int = Field(default=0, ge=0, le=MOST_SIMULATED)
    """How many there are at first."""
    most: int = Field(default=8, ge=0, le=MOST_SIMULATED)
    """How many a browser may ask for."""
    seed: int = Field(default=1, ge=0)
    """Seed of where they begin."""

    @model_validator(mode="after")
    def _are_in_order(self) -> SimulatedCars:
        if self.cars > self.most:
            raise ValueError(f"cars must not be more than most, {self.most}")
        return self


class Lab(StrictTable):
    """A laboratory. See `docs/live-file.md` for an example of the file."""

    title: str = ""
    source: str = Field(min_length=1)
    """Where poses come from, such as `optitrack:192.168.1.5?up=y`."""
    link: str = Field(min_length=1)
    """How commands reach the cars, such as `serial:/dev/ttyUSB0?baud=57600`."""
    sources: dict[str, str] = Field(default_factory=dict)
    """Other sources that may be chosen in the laboratory, by what they are called there."""
    links: dict[str, str] = Field(default_factory=dict)
    """Other links that may be chosen in the laboratory, by what they are called there."""
    rule: str = Field(min_length=1)
    """What drives the cars."""
    parameters: dict[str, Value] = Field(default_factory=dict)
    """Those of the rule that are not its defaults."""
    rate: float = Field(default=RATE, ge=10.0, le=500.0)
    """Commands per second."""
    area: TrackingArea
    limits: SafetyLimits = SafetyLimits()
    injected: Injection = Injection()
    simulated: SimulatedCars = SimulatedCars()
    recording: RecordingLimits = RecordingLimits()
    cars: dict[str, LabCar] = Field(min_length=1, max_length=MOST_CARS)

    @model_validator(mode="after")
    def _fits_together(self) -> Lab:
        demand_matching_ends(self.source, self.link, self.injected.path == "body")
        demand_choices("sources", self.source, self.sources)
        demand_choices("links", self.link, self.links)
        self.demand_distinct()
        self.demand_stops_in_time()
        self.demand_target_within()
        if 1.0 / self.rate > self.limits.stale:
            raise LabFileConflict(
                f"stale must be longer than a tick of {1.0 / self.rate:g} s", "limits"
            )
        return self

    def demand_distinct(self) -> None:
        """No two cars have one address or one body. Raises Misfit."""
        addresses: dict[int, str] = {}
        bodies: dict[str, str] = {}
        for name, car in self.cars.items():
            if not name.strip() or name == INJECTED:
                raise LabFileConflict(f"a car cannot be called {name!r}", "cars", name)
            other = addresses.setdefault(car.address, name)
            if other != name:
                raise LabFileConflict(
                    f"{other} and {name} have one address, {car.address}", "cars", name, "address"
                )
            body = car.body or name
            if bodies.setdefault(body, name) != name:
                raise LabFileConflict(
                    f"{bodies[body]} and {name} have one body, {body!r}", "cars", name, "body"
                )
        if self.injected.path == "body" and not self.injected.body:
            raise LabFileConflict("the injected car has no body", "injected", "body")
        if self.injected.path != "body" and self.injected.body:
            raise LabFileConflict(
                'a body of the injected car needs path = "body"', "injected", "body"
            )
        if self.injected.body in bodies:
            raise LabFileConflict(
                f"the injected car and {bodies[self.injected.body]} have one body, "
                f"{self.injected.body!r}",
                "injected",
                "body",
            )

    def demand_stops_in_time(self) -> None:
        """Every car can stop between fence and edge, whatever fails. Raises Misfit."""
        for name, car in self.cars.items():
            far = car.runs_on(self.limits)
            if far > self.area.fence + 1e-9:
                raise LabFileConflict(
                    f"fence = {self.area.fence:g} m is too little: {name} may run on for "
                    f"{far:.2f} m (its speed, its lag and limits.frozen make that)",
                    "area",
                    "fence",
                )

    def demand_target_within(self) -> None:
        """The injected car stays within the fence. Raises Misfit."""
        plan = self.injected
        for x, y in plan.corners():
            if self.area.distance_inside(x, y) < 0.0:
                raise LabFileConflict(
                    f"the injected car's path reaches ({x:g}, {y:g}), which is not within the "
                    f"fence, {self.area.fence:g} m inside the area",
                    "injected",
                    {"hand": "centre", "route": "route"}.get(plan.path, "radius"),
                )

    @property
    def addresses(self) -> dict[str, int]:
        """The addresses of the cars, by name."""
        return {name: car.address for name, car in self.cars.items()}

    @property
    def bodies(self) -> dict[str, str]:
        """The tracked bodies that are followed: body -> the name of its car here."""
        names_by_body = {car.body or name: name for name, car in self.cars.items()}
        if self.injected.path == "body":
            names_by_body[self.injected.body] = INJECTED
        return names_by_body

    def safety(self) -> Safety:
        """The safety of this laboratory, unarmed."""
        reached = kind_of(self.link) != DRY and kind_of(self.source) != RECORDED
        return Safety(self.limits, self.area, self.cars, self.bodies, reached)

    def with_values(self, origin: str, **values: Any) -> Lab:
        """The laboratory with other values, which are checked as those of a file are.

        Raises InputError naming `origin`.
        """
        try:
            return validate_lab(self.model_dump(mode="json") | values)
        except ValidationError as error:
            raise refusal(error, "", origin) from None

    def to_toml(self) -> str:
        """The laboratory as a file; numbers keep every bit."""
        return tomlkit.dumps(self.model_dump(mode="json"))


TABLES: dict[str, type[StrictTable]] = {
    "area": TrackingArea,
    "limits": SafetyLimits,
    "injected": Injection,
    "simulated": SimulatedCars,
    "recording": RecordingLimits,
    "cars": LabCar,
}


def read_lab(path: str | Path) -> Lab:
    """The laboratory of a file; links that are Python files lie beside it and get its folder.

    Such a link is run when it is opened, not here. Raises InputError naming the line that is wrong.
    """
    lab = lab_from_toml(read_text(f"laboratory {str(path)!r}", path), str(path))
    folder = Path(path).parent.resolve()
    links = {name: resolve_link(folder, text) for name, text in lab.links.items()}
    return lab.model_copy(update={"link": resolve_link(folder, lab.link), "links": links})


def resolve_link(folder: Path, link: str) -> str:
    """The text of a link; if it is a Python file, that in a folder. Raises InputError."""
    kind = kind_of(link)
    if not kind.endswith(FILE):
        return link
    if not (folder / kind).is_file():
        raise InputError(f"there is no file {folder / kind} (link {link!r})")
    return f"{folder / kind}{link.removeprefix(kind)}"


def lab_from_toml(text: str, origin: str) -> Lab:
    """The laboratory that a text describes. Raises InputError naming the line that is wrong."""
    values = toml(text, origin)
    try:
        return validate_lab(values)
    except ValidationError as error:
        raise refusal(error, text, origin) from None


def validate_lab(values: Mapping[str, Any]) -> Lab:
    """The laboratory of these values. Raises ValidationError."""
    # as JSON, strict: a number in quotes is no number, but a list is a pair
    return Lab.model_validate_json(json.dumps(values, default=replace_dates), strict=True)


def replace_dates(date: object) -> dict[str, str]:
    """Dates, which TOML knows and JSON does not: no key has one."""
    return {"a date": str(date)}


def refusal(error: ValidationError, text: str, origin: str) -> InputError:
    """The first thing that is wrong with a laboratory: what, its value, what is allowed, where."""
    first: Mapping[str, Any] = error.errors()[0]
    cause = first.get("ctx", {}).get("error")
    keys = [str(key) for key in first["loc"] if isinstance(key, str)]
    if isinstance(cause, LabFileConflict):
        keys = list(cause.keys)
    line = find_line(text, keys)
    where = f"{origin}, line {line}" if line else origin
    if first["type"] == "extra_forbidden":
        return unknown("key", keys[-1], known_keys(keys[:-1]), where)
    if first["type"] == "missing" and first["loc"][-1] == keys[-1]:
        return InputError(f"{table_of(keys)} has no {keys[-1]} ({where})")
    if isinstance(cause, ValueError):
        return InputError(f"{needed(first)} ({where})")
    value = first["input"]
    value_text = (
        f"{value:g}" if isinstance(value, float) and math.isfinite(value) else shorten(value)
    )
    return InputError(f"{'.'.join(keys)} = {value_text} is not allowed: {needed(first)} ({where})")


def known_keys(table: Sequence[str]) -> list[str]:
    """The keys that a table may have."""
    return list((TABLES[table[0]] if table else Lab).model_fields)


def table_of(keys: Sequence[str]) -> str:
    """The table that a key belongs to, in words."""
    return f"[{'.'.join(keys[:-1])}]" if len(keys) > 1 else "the laboratory"


# The laboratory of the example: two cars that follow an injected one, as in the reading.


EXAMPLE_FILE = Path(__file__).with_name("example.toml")
"""A file to begin from."""


def example() -> Lab:
    """The laboratory of that file."""
    return read_lab(EXAMPLE_FILE)
