"""Make one compiled loop for each rule and body, and keep it on disk.

numba finds a kernel in its cache only if the kernel reaches the rule as a global of its module. So
each rule gets a module of its own, made from a template: a file of `ticks`, or `pairs/tick.py`,
whose sums are those of another, `pairs/pair_sums.py`.
"""

from __future__ import annotations

import importlib.util
import sys
import threading
import types
from collections import namedtuple
from collections.abc import Callable
from pathlib import Path

from numba.core.dispatcher import Dispatcher

from agents.engine import template
from agents.engine.cache import base_digest, fingerprint, is_kept, keep_on_disk
from agents.engine.own_parameters import own_functions

HERE = Path(__file__).parent
LOADING = threading.Lock()
TEMPLATES = {
    "sweep": HERE / "ticks" / "synchronous_tick.py",
    "pairs": HERE / "pairs" / "tick.py",
    "pair_sums": HERE / "pairs" / "pair_sums.py",
    "turns": HERE / "ticks" / "sequential_tick.py",
    "delayed": HERE / "ticks" / "delayed_tick.py",
}


def loop_module(kind: str, parts: dict[str, Callable | int | None], fields):
    """The module whose `advance` runs whole ticks of a rule: of a kind, `sweep` or `pairs`.

    `parts` gives the names of `agents.engine.template` their values; None takes the template's,
    which does nothing. `fields` are the names of the parameters; the module's `P` holds them.
    """
    filled = {
        part: getattr(template, part) if function is None else function
        for part, function in parts.items()
    }
    own = "own_of_row", "own_of_eight"
    filled |= {name: getattr(template, name) for name in own}
    if kind == "pairs":
        sums = vars(load("pair_sums", filled, fields))
        filled |= {name: sums[name] for name in ("is_any_lone", "nearest_sums", "pair_sums")}
    return load(kind, filled, fields)


def turns_module(sweep: types.ModuleType):
    """The module whose `advance` lets the agents of a rule act in turn; `sweep` is its sweep."""
    names = (
        "ASKS_SPEED",
        "CRASHES",
        "DEAFENS",
        "DIM",
        "KINDS",
        "MEASURES",
        "NEAREST",
        "PRIVATE",
        "SEES_POINTS",
        "SIGNALS",
        "act",
        "agent_of_slot",
        "holds",
        "judge",
        "lay",
        "nearby",
        "own_of_row",
        "pick_heeded",
        "pick_nearest",
        "ready",
        "see_points",
        "show",
    )
    return load("turns", {part: vars(sweep)[part] for part in names}, sweep.P._fields)


def delayed_module(sweep: types.ModuleType):
    """The module whose `advance` lets the agents of a rule know of each other by messages."""
    constants = "ASKS_SPEED", "CRASHES", "DIM", "KINDS", "MEASURES", "NEAREST", "PRIVATE", "SIGNALS"
    functions = "act_on_block", "link", "own_of_row", "row_of", "show_own_signals", "sort_flock"
    turns = turns_module(sweep)
    parts = {part: vars(sweep)[part] for part in (*constants, "holds")}
    parts |= {part: vars(turns)[part] for part in functions}
    return load("delayed", parts, sweep.P._fields)


def load(kind: str, globals_: dict, fields) -> types.ModuleType:
    """A template as a module of its own, with the given globals, compiled under its own cache."""
    digest = base_digest()
    digest.update(repr(tuple(fields)).encode())
    visited: set[int] = set()
    for part, value in sorted(globals_.items()):
        digest.update(part.encode())
        if isinstance(value, Dispatcher):
            fingerprint(value, digest, visited)
        else:
            digest.update(repr(value).encode())
    module_name = f"{__package__}.{kind}_{digest.hexdigest()[:16]}"
    # One thread at a time, so that a loop is one module with one class of parameters. This lock is
    # taken before that of `keep_on_disk`, never after it.
    with LOADING:
        if module_name not in sys.modules:
            module = execute_template(kind, module_name, globals_, fields)
            sys.modules[module_name] = module  # a kept kernel finds its parameters' class there
            if kind != "pair_sums":  # it has no entry: another template calls it
                fingerprint(module.advance, digest, visited)
                module.__dict__["cache_folder"] = keep_on_disk(module.advance, digest)
    return sys.modules[module_name]


def execute_template(kind: str, module_name: str, globals_: dict, fields) -> types.ModuleType:
    """The template `kind` executed as a module of that name."""
    spec = importlib.util.spec_from_file_location(module_name, TEMPLATES[kind])
    if spec is None or spec.loader is None:
        raise ImportError(f"no loader for the template {TEMPLATES[kind]}")
    module = importlib.util.module_from_spec(spec)
    parameters = parameter_tuple(module_name, fields)
    module.__dict__.update(globals_, P=parameters, **{parameters.__name__: parameters})
    if globals_.get("DIFFER"):
        module.__dict__.update(own_functions(parameters, globals_["DIFFER"], module_name))
    spec.loader.exec_module(module)
    return module


def parameter_tuple(module_name: str, fields) -> type:
    """A NamedTuple class of floats that pickles by its module, as numba's cache needs.

    It bears the module's name, the kind of loop with it: numba's calls tell tuples apart by the
    names of their class and fields alone, and take a slow way each time where two are alike.
    """
    return namedtuple(f"P_{module_name.rpartition('.')[2]}", fields, module=module_name)


def is_compiled(module: types.ModuleType) -> bool:
    """Whether the kernel is in the cache already, so that the first tick will not wait for it."""
    return bool(module.advance.signatures) or is_kept(module.advance)
