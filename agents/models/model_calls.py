"""Call a model's compiled functions, and report in one line what its author got wrong."""

from __future__ import annotations

import dis
import re
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType
from typing import Any

from numba.core.dispatcher import Dispatcher
from numba.core.errors import NumbaError

from agents.engine.block import BodyMove, Decision, Me, NeighbourBlock, PointBlock
from agents.engine.cache import global_values
from agents.models.declare import OF_BODIES, OF_RULES, Body, Rule
from agents.models.model import Model
from worlds.compilation import DISABLED, plain_python
from worlds.input_error import InputError, suggestion
from worlds.queries.surroundings import Surroundings

GIVEN: dict[str, tuple[str, Any]] = {
    "Me": ("me", Me),
    "NeighbourBlock": ("near", NeighbourBlock),
    "PointBlock": ("points", PointBlock),
    "Surroundings": ("surroundings", Surroundings),
}
"""What a rule is given, by its type's name."""
FAULTS = (
    ArithmeticError,
    AttributeError,
    LookupError,
    NameError,
    NumbaError,
    TypeError,
    ValueError,
    NotImplementedError,
)
UNKNOWN = (
    r"Unknown attribute '(?P<name>\w+)' of type (?P<kind>\w+)",
    r"'(?P<kind>\w+)' object has no attribute '(?P<name>\w+)'",
)
"""How numba and Python say that something has no such attribute."""
LONGEST = 200
"""Characters of a reason in the words of numba or of Python."""


class ModelCodeError(InputError):
    """A function of a rule or a body cannot be compiled, or raised an exception."""


def call(model: Model, interpret: bool, function: Callable, *arguments: Any) -> Any:
    """Call a function of a model, as plain Python if `interpret`.

    Raises Fault naming the rule or the body, the function and the line that are at fault.
    """
    try:
        if interpret or DISABLED:
            with plain_python():
                return function(*arguments)
        return function(*arguments)
    except InputError:
        raise
    except FAULTS as error:
        fault = fault_of(model, error)
        if fault is None and not (interpret or DISABLED):
            raise
        if fault is None:  # the engine met what it was given, such as a place that is no number
            message = f"{type(error).__name__}: {error}"
            fault = ModelCodeError(f"model {model.name!r}, as plain Python: {message[:LONGEST]}")
        raise fault from error


def fault_of(model: Model, error: Exception) -> ModelCodeError | None:
    """What a model's author got wrong; None if the error is not theirs."""
    if isinstance(error, NumbaError):
        return describe_wrong_answer(model) or describe_uncompiled(model, error)
    own = dict(codes(model))
    message = f"{type(error).__name__}: {error}"
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        if frame.f_code in own:
            return format_fault(
                own, frame.f_code, line, describe_error(message, model, frame.f_code)
            )
    code = getattr(getattr(error, "uncompiled", None), "__code__", None)
    if code in own:  # numba lets some exceptions pass as they are, without a line
        return format_fault(own, code, line_of(code, message), describe_error(message, model, code))
    return describe_wrong_answer(model)


def declared_functions(part: Rule | Body, kind: str) -> Iterator[tuple[str, Any]]:
    """The compiled functions that a rule or a body declares, by name: `rule 'vem', decide`."""
    for name in OF_RULES if kind == "rule" else OF_BODIES:
        function = getattr(part, name)
        if function is not None:
            yield f"{kind} {part.name!r}, {name}", function


def codes(model: Model) -> Iterator[tuple[CodeType, str]]:
    """The code of all functions that a model's rule and body reach, with their names."""
    visited: set[int] = set()
    for part, kind in ((model.body, "body"), (model.rule, "rule")):
        pending = [(function, title) for title, function in declared_functions(part, kind)]
        while pending:
            function, title = pending.pop()
            if id(function) not in visited:
                visited.add(id(function))
                yield function.py_func.__code__, title
                owner = title.split(",")[0]
                pending += [
                    (other, f"{owner}, {other.py_func.__name__}")
                    for other in global_values(function.py_func)
                    if isinstance(other, Dispatcher)
                ]


def format_fault(
    own: dict[CodeType, str], code: CodeType, line: int, reason: str
) -> ModelCodeError:
    """The one line: whose function, which line of which file, and the reason."""
    return ModelCodeError(f"{own[code]}, line {line}: {reason} ({Path(code.co_filename).name})")


def describe_wrong_answer(model: Model) -> ModelCodeError | None:
    """The rule's wish or the body's answer, if it is not of the kind that the engine takes."""
    answers: tuple[tuple[Any, type], ...] = (
        (model.rule.decide, Decision),
        (model.body.move, BodyMove),
    )
    for function, answer_kind in answers:
        code = function.py_func.__code__
        for compiled in function.overloads.values():
            kind = compiled.signature.return_type
            if getattr(kind, "instance_class", None) is not answer_kind:
                last = max(lines(code))
                reason = f"it returns {kind}, but a {answer_kind.__name__} is needed"
                return format_fault(dict(codes(model)), code, last, reason)
    return None


def describe_uncompiled(model: Model, error: NumbaError) -> ModelCodeError:
    """The innermost function of a model that numba could not compile, the line and the reason."""
    report = str(error)
    reasons = re.sub(r"Failed in \w+ mode pipeline.*", "", report)
    message = re.split(r'\nDuring: |\nFile "|\nThere are |\nReturn of: ', reasons.strip())[0]
    message = " ".join(message.split())
    own = dict(codes(model))
    at = re.search(r"\nDuring: .* at (.+) \((\d+)\)", report)
    callee = re.search(r"<function (\w+) at", report)
    for code in own:
        if at is not None and code.co_filename == at[1] and int(at[2]) in lines(code):
            return format_fault(own, code, int(at[2]), describe_error(message, model, code))
    for code in own:
        if callee is not None and code.co_name == callee[1]:
            return format_fault(
                own, code, line_of(code, message), describe_error(message, model, code)
            )
    if (match := re.search(r">>> add_terms\(UniTuple\(\w+ x (\d+)\)", message)) and model.rule.term:
        code = model.rule.term.py_func.__code__  # type: ignore[attr-defined]
        reason = f"it has to have as many numbers as its rule says, {match[1]}"
        return format_fault(own, code, max(lines(code)), reason)
    return ModelCodeError(f"model {model.name!r} cannot be compiled: {message[:LONGEST]}")


def lines(code: CodeType) -> set[int]:
    """The numbers of the lines of a function that hold code."""
    return {line for _, _, line in code.co_lines() if line}


def line_of(code: CodeType, message: str) -> int:
    """The first line of a function with the longest name of a message, the last of several."""
    lines: dict[str, int] = {}
    for instruction in dis.get_instructions(code):
        if (
            instruction.opname.startswith("LOAD_")
            and instruction.positions
            and instruction.positions.lineno
        ):
            lines.setdefault(str(instruction.argval), instruction.positions.lineno)
    names = [name for name in re.findall(r"\w+", message) if name in lines]
    return lines[max(reversed(names), key=len)] if names else code.co_firstlineno


def describe_error(message: str, model: Model, code: CodeType) -> str:
    """A message of numba or of Python, in the words of a rule."""
    for pattern in UNKNOWN:
        if match := re.search(pattern, message):
            kind, name = match["kind"], match["name"]
            if kind.startswith("P_"):
                return f"no parameter {name!r}{nearest(name, model.parameters.model_fields)}"
            if kind in GIVEN:
                kind_given, kind_made = GIVEN[kind]
                return f"{kind_given} has no {name!r}{nearest(name, kind_made._fields)}"
    if match := re.search(r"name '(\w+)' is not defined", message):
        names = {*code.co_varnames, *code.co_names} - {match[1]}
        return f"no name {match[1]!r}{nearest(match[1], sorted(names))}"
    if global_match := re.search(r"Untyped global name '(\w+)': .* of <class '(\w+)'>", message):
        reason = (
            "is not @compiled" if global_match[2] == "function" else "works in plain Python only"
        )
        return f"{global_match[1]!r} {reason}"
    if "Truths" in message and "bool" in message:
        return "`if` cannot ask about eight agents at once: use where(condition, this, other)"
    if "NRT required" in message:
        return "a compiled function cannot make a list, an array or anything else of its own"
    return message[:LONGEST]


def nearest(name: str, names: Any) -> str:
    """The nearest known name, as the end of a sentence."""
    return suggestion(name, names).replace(":", ",", 1)
