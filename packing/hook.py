"""Puts one name, `flockscope`, into a wheel; see `one_name.py` beside this file.

The environment variable FLOCKSCOPE_KERNELS names a folder of compiled kernels, which come with it.
Such a wheel is for the Python and the system of FLOCKSCOPE_WHEEL_TAG; `release.py` sets both.
"""

from __future__ import annotations

import os
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
        kernels = os.environ.get("FLOCKSCOPE_KERNELS")
        if kernels:
            build_data["tag"] = os.environ["FLOCKSCOPE_WHEEL_TAG"]
            for file in Path(kernels).glob("*/*.kernel"):
                place = f"flockscope/_agents/kernels/{file.parent.name}/{file.name}"
                build_data["force_include"][str(file)] = place

    def finalize(self, version: str, *_: object) -> None:
        """Take the folder away."""
        if version != "editable":
            self.folder.cleanup()
