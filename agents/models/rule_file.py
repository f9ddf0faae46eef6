"""Load the rule, the model or the policy of an author's own Python file, which needs no package."""

from __future__ import annotations

import hashlib
import linecache
import sys
import traceback
from dataclasses import replace
from pathlib import Path
from types import ModuleType

from agents.policies import Policy
from worlds.input_error import InputError
from worlds.text_file import read_text

NAMES = ("MODEL", "RULE")
"""Names that a file is searched for, in this order."""


def declaration_in_file(path: str | Path) -> object:
    """The `MODEL`, or else the `RULE`, or the policy of a Python file, which is run for it.

    Modules beside it can be imported. Raises InputError naming the file, and the line, for one that
    cannot be read, has a fault in it, or has none of these, or several policies.
    """
    file = Path(path)
    text = read_text(repr(str(path)), file)
    digest = hashlib.sha256(f"{file.resolve()}\0{text}".encode()).hexdigest()[:16]
    module = sys.modules.get(name := f"rule_file_{digest}") or run(file, text, name)
    for wanted_name in NAMES:
        if wanted_name in vars(module):
            return vars(module)[wanted_name]
    policies = {id(value): value for value in vars(module).values() if isinstance(value, Policy)}
    if not policies:
        raise InputError(f"{file.name} has neither a RULE nor a MODEL nor a policy ({path})")
    if len(policies) > 1:
        names = ", ".join(sorted(one.name for one in policies.values()))
        raise InputError(f"{file.name} has several policies, {names}: one is needed ({path})")
    (policy,) = policies.values()
    return replace(policy, file=str(file.resolve()), digest=digest)


def run(file: Path, text: str, name: str) -> ModuleType:
    """Run the file as a module. Raises InputError."""
    full_path = str(file.resolve())
    module = ModuleType(name)
    module.__file__ = full_path
    linecache.checkcache(full_path)  # the file may have been edited since: messages quote its lines
    sys.modules[name] = module  # where its classes look up the names in their annotations
    sys.path.insert(0, str(file.resolve().parent))
    try:
        exec(compile(text, full_path, "exec"), module.__dict__)
    except (Exception, SystemExit) as error:  # a script may end in sys.exit()
        del sys.modules[name]
        raise describe_fault(file, full_path, error) from error
    finally:
        sys.path.pop(0)
    return module


def describe_fault(file: Path, full_path: str, error: BaseException) -> InputError:
    """What is wrong with a file that could not be run: file, line and reason."""
    frames = [
        frame
        for one in (error.__cause__, error)
        if one is not None
        for frame in traceback.extract_tb(one.__traceback__)
    ]
    lines = [frame.lineno for frame in frames if frame.filename == full_path]
    line, reason = (lines[-1] if lines else None), f"{type(error).__name__}: {error}"
    if isinstance(error, SyntaxError) and error.filename == full_path:
        line, reason = error.lineno, f"{error.msg}"
    elif isinstance(error, InputError):
        reason = str(error)
    place = f"{file}" if line is None else f"{file}, line {line}"
    return InputError(f"{place}: {' '.join(reason.split())[:300]}")
