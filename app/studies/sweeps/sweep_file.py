"""A sweep's TOML file: the run, when it stops, the designs, the replicates, what is observed."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any, Literal, NamedTuple

import tomlkit
from pydantic import AliasChoices, ConfigDict, Field, field_validator, model_validator

from agents.spec import LARGEST_SEED, Options
from app.strict_table import Line, ParameterValue, StrictTable, Value
from app.studies.cluster.cluster_options import Cluster
from app.studies.experiment_file import WithKinds
from app.studies.run_axes import ByAxis
from worlds.input_error import InputError, unknown

# Comparisons that a file may make: between axes, and of an observable with a number; no code.

LONGEST = 500
"""Characters of a condition."""
COMPARED: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
RECKONED: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
WORDS = "axes and numbers with < <= > >= == != + - * / ( ), joined by and, or, not"


class Condition:
    """A condition between axes, such as `dr_a > dr_o and eta <= 2`. Raises InputError.

    >>> Condition("dr_a > dr_o + 1", ["dr_a", "dr_o"]).holds({"dr_a": 3, "dr_o": 1})
    True
    >>> Condition("big-fish.agents < 3", ["big-fish.agents"]).holds({"big-fish.agents": 2})
    True
    """

    def __init__(self, text: str, axes: Collection[str]):
        self.text = text
        if len(text) > LONGEST:
            raise InputError(f"a condition has at most {LONGEST} characters")
        try:
            source = text.strip()
            for axis in sorted(axes, key=len, reverse=True):
                if "-" in axis:  # of a kind of such a name: it would be read as a difference
                    source = source.replace(axis, axis.replace("-", DASH))
            self.tree = ast.parse(source, mode="eval").body
            check(self.tree, text, axes)
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            if isinstance(error, InputError):
                raise
            raise condition_error(text) from None
        if not isinstance(self.tree, ast.Compare | ast.BoolOp | ast.UnaryOp):
            raise condition_error(text)

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether it holds for the axes of a cell. Raises InputError where they cannot be
        compared."""
        try:
            return bool(value(self.tree, values))
        except (TypeError, ArithmeticError):
            point_text = ", ".join(f"{name} = {value!r}" for name, value in values.items())
            raise InputError(f"{self.text!r} cannot be said of {point_text}") from None


DASH = "\u02c9"
"""Stands for the dash of an axis in what Python parses: a letter that no axis has."""


def axis_at(node: ast.expr) -> str:
    """The axis that a name of a condition is."""
    return ast.unparse(node).replace(DASH, "-")


def condition_error(text: str) -> InputError:
    """The refusal of what is no condition."""
    return InputError(f"{text!r} is not a condition: {WORDS}")


def check(node: ast.AST, text: str, axes: Collection[str]) -> None:
    """Refuse whatever is not a comparison of axes and numbers. Raises InputError."""
    match node:
        case ast.BoolOp(values=parts):
            pass
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=one):
            parts = [one]
        case ast.BinOp(left=left, op=op, right=right) if type(op) in RECKONED:
            parts = [left, right]
        case ast.Compare(left=left, ops=ops, comparators=others) if all(
            type(operator) in COMPARED for operator in ops
        ):
            parts = [left, *others]
        case ast.Constant(value=bool() | int() | float() | str()):
            return
        case ast.Name() | ast.Attribute():
            name = axis_at(node)
            if name not in axes:
                raise unknown("axis", name, axes, repr(text))
            return
        case _:
            raise condition_error(text)
    for one in parts:
        check(one, text, axes)


def value(node: ast.AST, values: Mapping[str, Any]) -> Any:
    """What a part of a condition comes to."""
    match node:
        case ast.BoolOp(op=ast.And(), values=parts):
            return all(value(part, values) for part in parts)
        case ast.BoolOp(values=parts):
            return any(value(part, values) for part in parts)
        case ast.UnaryOp(op=ast.Not(), operand=one):
            return not value(one, values)
        case ast.UnaryOp(operand=one):
            return -value(one, values)
        case ast.BinOp(left=left, op=op, right=right):
            return RECKONED[type(op)](value(left, values), value(right, values))
        case ast.Compare(left=left, ops=ops, comparators=others):
            operands = [value(operand, values) for operand in (left, *others)]
            pairs = zip(operands, ops, operands[1:], strict=False)
            return all(COMPARED[type(op)](pair, other) for pair, op, other in pairs)
        case ast.Constant(value=one):
            return one
        case ast.Name() | ast.Attribute():  # of `s.spread`, `shark.flock.weight`
            return values[axis_at(node)]
    raise AssertionError(node)


class ObservableBound(NamedTuple):
    """An observable and the bound that it is to keep to."""

    name: str
    sign: str
    bound: float

    def holds(self, measured: float) -> bool:
        """Whether a value keeps to it; nan does not."""
        return bool(SIGNS[self.sign](measured, self.bound))


SIGNS = {
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
    "==": operator.eq,
    "!=": operator.ne,
}
COMPARISON = re.compile(r"\s*([\w.:/-]+)\s*(>=|<=|==|!=|>|<)\s*([-+.\w]+)\s*")


def comparison(text: str) -> ObservableBound:
    """A comparison of an observable with a number. Raises InputError.

    >>> comparison("mean-neighbours >= 3")
    ObservableBound(name='mean-neighbours', sign='>=', bound=3.0)
    """
    match = COMPARISON.fullmatch(text[:LONGEST])
    try:
        if match and len(text) <= LONGEST:
            return ObservableBound(match[1], match[2], float(match[3]))
    except ValueError:
        pass
    raise InputError(
        f"{text[:100]!r} is not allowed: one comparison of an observable with a number is needed, "
        "such as 'polarisation >= 0.9'"
    )


# The text of a file that says what a command line or a script asks for.

BY_NAME = ("axes", "at", "parameters")
"""Tables whose keys are names of axes and parameters."""


def file_text(values: Mapping[str, Any]) -> str:
    """Values as a TOML file, names in their order: the order of axes is that of the cells.

    >>> print(file_text({"axes": {"s.spread": {"from": 0, "to": 1}, "r": [1, 2]}}), end="")
    [axes]
    "s.spread" = {from = 0, to = 1}
    r = [1, 2]
    """
    return tomlkit.dumps(with_inline_tables(values))


def with_inline_tables(value: Any) -> Any:
    """Values in which what stands under a name is one line, as a table it would come after all
    others."""
    if isinstance(value, list):
        return [with_inline_tables(item) for item in value]
    if not isinstance(value, Mapping):
        return value
    tables: dict[str, Any] = {}
    for key, item in value.items():
        if key in BY_NAME and isinstance(item, Mapping):
            table = tomlkit.table()
            for name, entry in item.items():
                table.add(name, inline(entry) if isinstance(entry, Mapping) else entry)
            tables[key] = table
        else:
            tables[key] = with_inline_tables(item)
    return tables


def inline(values: Mapping[str, Any]) -> Any:
    """Values as a table in one line."""
    table = tomlkit.inline_table()
    table.update(values)
    return table


MOST_CELLS = 1_000_000
MOST_TICKS = 10**9
EVERY = re.compile(r"every ([1-9][0-9]{0,8})")


class RunOptions(WithKinds, Options):
    """What all runs share; axes set what differs."""

    model: str
    """A model, or a file of a rule."""
    agents: int | None = Field(default=None, ge=1)
    size: float | tuple[float, ...] | None = None
    dim: Literal[2, 3] | None = None
    world: str | None = None
    ticks: int = Field(ge=1, le=MOST_TICKS)
    """Ticks of a run; with [stop] the most."""
    timeout: float | None = Field(
        default=None, gt=0.0, validation_alias=AliasChoices("timeout", "seconds")
    )
    """Seconds of the clock after which a run is killed; None: as long as it takes. Files of earlier
    versions say `seconds`."""
    parameters: dict[str, ParameterValue] = Field(default_factory=dict)


class Stop(StrictTable):
    """When a run is over before its last tick."""

    when: str
    hold: int = Field(default=1, ge=1)
    """Ticks for which it has to hold; `k` is the tick from which it did."""
    every: int = Field(default=1, ge=1)
    """Ticks between two looks."""


class Span(StrictTable):
    """Values of an axis between two bounds; a grid says how many, or how far apart."""

    model_config = ConfigDict(populate_by_name=True)

    from_: float = Field(alias="from")
    to: float
    count: int | None = Field(default=None, ge=2, le=MOST_CELLS)
    step: float | None = Field(default=None, gt=0.0)
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _fits(self) -> Span:
        if self.scale == "log" and min(self.from_, self.to) <= 0.0:
            raise ValueError("a scale of log needs from and to above 0")
        if self.scale == "log" and self.step is not None:
            raise ValueError("a scale of log has no step: give count")
        if self.count is not None and self.step is not None:
            raise ValueError("count and step are two ways to say the same: give one")
        if self.from_ == self.to:
            raise ValueError("from and to are the same")
        return self


type Axis = Annotated[list[Value], Field(min_length=1, max_length=MOST_CELLS)] | Span


class Design(StrictTable):
    """What all designs have."""

    where: str = ""
    """A condition between axes: only cells for which it holds are run."""


class GridDesign(Design):
    """Every value of an axis with every value of the others."""

    kind: Literal["grid"] = "grid"
    axes: ByAxis[Axis] = Field(min_length=1)


class ListDesign(Design):
    """Cells one by one: rows of the file, or of a CSV beside it."""

    kind: Literal["list", "csv"]
    rows: list[ByAxis[Value]] = Field(default_factory=list)
    file: str = ""
    """A CSV whose first line names the axes."""

    @model_validator(mode="after")
    def _has_one_source(self) -> ListDesign:
        if bool(self.rows) == bool(self.file):
            raise ValueError("either rows or file is needed")
        return self


class SampleDesign(Design):
    """What samples have: bounds of axes, and a seed of their own."""

    axes: ByAxis[Axis] = Field(min_length=1)
    seed: int = Field(default=1, ge=0, le=2**32 - 1)

    @field_validator("axes")
    @classmethod
    def _are_bounds(cls, axes: dict[str, Any]) -> dict[str, Any]:
        for name, axis in axes.items():
            if isinstance(axis, Span) and (axis.count is not None or axis.step is not None):
                raise ValueError(f"{name}: a sample draws its own values: leave count and step out")
        return axes


class Latin(SampleDesign):
    """A Latin hypercube."""

    kind: Literal["latin-hypercube"]
    points: int = Field(ge=1, le=MOST_CELLS)


def power_of_two(value: int) -> int:
    """A power of two. Raises ValueError for any other number."""
    if value & (value - 1):
        raise ValueError(f"{value} is not a power of two")
    return value


class Sobol(SampleDesign):
    """Points of a scrambled Sobol sequence."""

    kind: Literal["sobol"]
    points: int = Field(ge=1, le=MOST_CELLS)
    _balanced = field_validator("points")(power_of_two)


class Saltelli(SampleDesign):
    """Saltelli's points for Sobol indices: points (D + 2) cells, or points (2 D + 2)."""

    kind: Literal["saltelli"]
    points: int = Field(ge=2, le=MOST_CELLS)
    second_order: bool = False
    _balanced = field_validator("points")(power_of_two)


class Morris(SampleDesign):
    """Morris' trajectories of elementary effects: trajectories (D + 1) cells."""

    kind: Literal["morris"]
    trajectories: int = Field(ge=2, le=MOST_CELLS)
    levels: int = Field(default=4, ge=2, le=1000)

    @field_validator("levels")
    @classmethod
    def _even(cls, value: int) -> int:
        if value % 2:
            raise ValueError(f"{value} levels are not even")
        return value


type AnyDesign = Annotated[
    GridDesign | ListDesign | Latin | Sobol | Saltelli | Morris, Field(discriminator="kind")
]


class Precision(StrictTable):
    """More replicates where the interval of a mean is wide, until it is narrow enough."""

    observable: str
    within: float = Field(gt=0.0)
    """Half of the interval of the mean, at most."""
    relative: bool = False
    """Whether `within` is a share of the mean."""
    confidence: float = Field(default=0.95, gt=0.5, lt=1.0)
    most: int = Field(ge=2, le=1_000_000)
    """Replicates of a cell, at most."""
    step: int = Field(5, ge=1)
    """Replicates that are added at a time."""
    budget: int | None = Field(default=None, ge=1)
    """Runs of the whole sweep, at most."""


class Replicates(StrictTable):
    """How often each cell is run, and from which seeds."""

    count: int = Field(default=10, ge=1, le=1_000_000)
    seeds: Literal["common", "distinct"] = "common"
    """`common`: first, first + 1, ... in every cell. `distinct`: no seed twice."""
    first: int = Field(default=1, ge=0, le=LARGEST_SEED // 2)
    precision: Precision | None = None

    @model_validator(mode="after")
    def _fits(self) -> Replicates:
        more = self.precision
        if more is not None and (self.count < 2 or more.most < self.count):
            raise ValueError("a precision needs count of 2 or more, and most no less than count")
        return self


class Observe(StrictTable):
    """What is measured of a run: an observable by name, or a function of one's own."""

    name: str = ""
    measure: str = ""
    """FILE.py:FUNCTION, which takes a snapshot and returns a number."""
    when: str = "final"
    """`final`, or `every K` ticks along the run, or `each` tick."""
    over: int | None = Field(default=None, ge=1)
    """Ticks at the end of the run over which the mean is taken."""
    column: str = Field(default="", max_length=60)
    """Its name in tables; by default its own."""

    @model_validator(mode="after")
    def _names_one_thing(self) -> Observe:
        if bool(self.name) == bool(self.measure):
            raise ValueError("either name or measure is needed")
        if self.when not in ("final", "each") and not EVERY.fullmatch(self.when):
            raise ValueError("when is 'final', 'each' or 'every K'")
        if self.over is not None and self.when != "final":
            raise ValueError("a mean over the last ticks is of the end: leave when out")
        return self

    @property
    def every(self) -> int | None:
        """Ticks between two looks along the run; None where there is one at the end only."""
        match = EVERY.fullmatch(self.when)
        return int(match[1]) if match else {"final": None, "each": 1}[self.when]


class Record(StrictTable):
    """Which runs are kept as recordings."""

    where: str = ""
    """A condition between axes; empty: every cell."""
    replicates: int = Field(default=1, ge=1)
    """The first so many of each."""
    every: int = Field(default=1, ge=1)
    """Ticks between two frames."""


class SweepFile(StrictTable):
    """A whole file."""

    title: Line = Field(default="", max_length=200)
    run: RunOptions
    stop: Stop | None = None
    design: list[AnyDesign] = Field(default_factory=list)
    replicates: Replicates = Replicates()
    observe: list[Observe] = Field(default_factory=list)
    record: list[Record] = Field(default_factory=list)
    cluster: Cluster = Cluster()
