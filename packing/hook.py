"""Puts one name, `flockscope`, into a wheel; see `one_name.py` beside this file."""

from __future__ import annotations

import runpy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class OneName(BuildHookInterface):
    """The package is gathered in a folder of its own; an editable install is the tree itself."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Gather the package before the wheel is made."""
        if version == "editable":
            return
        root = Path(self.root)
        one_name = runpy.run_path(str(root / "packing" / "one_name.py"))
        self.folder = TemporaryDirectory(prefix="flockscope-")
        one_name["gather"](root, Path(self.folder.name))
        for file in one_name["files"](Path(self.folder.name)):
            place = file.relative_to(self.folder.name).as_posix()
            build_data["force_include"][str(file)] = f"flockscope/{place}"

    def finalize(self, version: str, *_: object) -> None:
        """Take the folder away."""
        if version != "editable":
            self.folder.cleanup()
