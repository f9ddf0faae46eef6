"""The kinds of the properties of viser's controls and nodes, found once for each class.

viser finds them anew for every control and every node: a fifth of the start of a laboratory.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, get_type_hints

from viser._assignable_props_api import AssignablePropsBase

known: dict[type, dict[str, Any]] = {}


def kinds_of(handle: Any) -> dict[str, Any]:
    """The kinds of the properties of a control or a node."""
    of = type(handle._impl.props)
    if of not in known:
        known[of] = get_type_hints(of)
    return known[of]


def find_kinds_once() -> None:
    """Have viser do so from now on."""
    once = cached_property(kinds_of)
    once.__set_name__(AssignablePropsBase, "_prop_hints")
    AssignablePropsBase._prop_hints = once  # type: ignore[assignment]
