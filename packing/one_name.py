"""What makes one name of three: the packages of the tree, their imports written for `flockscope`.

In the tree `app`, `agents` and `worlds` stand at the top. Installed they are `flockscope._app`,
`flockscope._agents` and `flockscope._worlds`, so that no module of anybody else's is replaced by
ours. Only import statements change; what changes keeps its line, so that tracebacks agree.
"""

from __future__ import annotations

import ast
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

FACE = "flockscope"
PARTS = ("app", "agents", "worlds")
"""Packages of the tree that have a private name inside `flockscope`."""
DATA = ("static", "experiments")
"""Folders of files that lie beside `app`, in the tree as inside `flockscope`."""
NAMES_A_MODULE = re.compile(rf"({'|'.join(PARTS)})\.(\w+\.)*\w*")


class ModuleInAString(ValueError):
    """A string names a module of the tree: it would not be found by that name when installed."""


class Edit(NamedTuple):
    """Bytes of a line, from one column to before another, and what comes in their place."""

    line: int
    begin: int
    end: int
    text: str


def inside(name: str) -> str | None:
    """The name inside `flockscope` of a module of the tree, None if it is none of ours.

    >>> inside("agents.rules.vicsek"), inside("agents_of_others")
    ('flockscope._agents.rules.vicsek', None)
    """
    part, dot, rest = name.partition(".")
    return f"{FACE}._{part}{dot}{rest}" if part in PARTS else None


def rewritten(source: str, file: str) -> str:
    """Python source with the imports of our packages written for their names in `flockscope`.

    Raises ModuleInAString, with file and line, where a string is nothing but the name of a module.
    """
    tree = ast.parse(source, file)
    demand_no_names(tree, file)
    lines = source.encode().splitlines(keepends=True)
    for edit in sorted(edits(tree, lines), reverse=True):
        line = lines[edit.line]
        lines[edit.line] = line[: edit.begin] + edit.text.encode() + line[edit.end :]
    return b"".join(lines).decode()


def edits(tree: ast.AST, lines: list[bytes]) -> Iterator[Edit]:
    """What changes in the import statements, wherever they stand."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from map(of_alias, node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level and inside(str(node.module)):
            yield of_module(node, lines)


def of_alias(alias: ast.alias) -> Edit:
    """One name of `import a, b as c`: what it binds stays bound."""
    made = inside(alias.name) or alias.name
    part = alias.name.partition(".")[0]
    if alias.asname is not None:
        made += f" as {alias.asname}"
    elif inside(part):
        whole = f"{inside(part)} as {part}"
        made = whole if alias.name == part else f"{made}, {whole}"
    return Edit(alias.lineno - 1, alias.col_offset, int(alias.end_col_offset or 0), made)


def of_module(node: ast.ImportFrom, lines: list[bytes]) -> Edit:
    """The module of `from a.b import c`; it may stand in the line below a backslash."""
    at, column = node.lineno - 1, node.col_offset + len("from")
    while not (found := re.compile(rb"[ \t\f]*([\w.]+)").match(lines[at], column)):
        at, column = at + 1, 0
    return Edit(at, found.start(1), found.end(1), str(inside(str(node.module))))


def demand_no_names(tree: ast.AST, file: str) -> None:
    """Refuse a string that is nothing but a module's name: an import that cannot be seen."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and NAMES_A_MODULE.fullmatch(str(node.value)):
            raise ModuleInAString(
                f"{file}, line {node.lineno}: {node.value!r} names a module in a string: import "
                "it, or make its name from __package__"
            )


def gather(root: Path, made: Path) -> None:
    """Write the package `flockscope`, whole, into the folder `made` from a checkout at `root`."""
    for name, place in [(FACE, "."), *((part, f"_{part}") for part in PARTS)]:
        for file in files(root / name):
            target = made / place / file.relative_to(root / name)
            target.parent.mkdir(parents=True, exist_ok=True)
            if file.suffix == ".py":
                source = file.read_text(encoding="utf-8")
                target.write_text(rewritten(source, str(file)), encoding="utf-8")
            else:
                shutil.copyfile(file, target)
    for name in DATA:
        for file in files(root / name):
            target = made / name / file.relative_to(root / name)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)


def files(folder: Path) -> list[Path]:
    """The files of a folder, but for what Python keeps of compiled ones."""
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return [path for path in found if "__pycache__" not in path.parts]
