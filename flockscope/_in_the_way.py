"""Looks, when it is imported, whether a module of somebody else's hides a package of this checkout.

A checkout has its packages at its top, by the plain names `app`, `agents` and `worlds`; a file
`agents.py` where Python is started comes before them. Installed they are inside `flockscope`, where
nothing can hide them, and there is nothing to look for. Raises ImportError, in one line.
"""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).parent
PARTS = ("app", "agents", "worlds")


def origin_of(name: str) -> str | None:
    """The file that `import name` takes or has taken, None if there is none."""
    loaded = sys.modules.get(name)
    if loaded is not None:
        return getattr(loaded, "__file__", None)
    spec = find_spec(name)
    return spec.origin if spec else None


def demand_own_parts(checkout: Path) -> None:
    """Raise ImportError if a package of the checkout is not what is imported by its name."""
    for name in PARTS:
        own, origin = checkout / name / "__init__.py", origin_of(name)
        if origin is None or Path(origin).resolve() != own.resolve():
            cause = f"the module {origin}" if origin else f"a folder {name!r} without {own}"
            raise ImportError(
                f"{cause} is in the way of flockscope's own {name!r} in the checkout {checkout}: "
                "rename it, start Python elsewhere, or install flockscope (docs/installing.md), "
                "where nothing is in its way",
                name=name,
            )


if not (HERE / "_agents").is_dir():
    demand_own_parts(HERE.parent)
