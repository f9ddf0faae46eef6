"""The file of a laboratory, as the command line is given it."""

from __future__ import annotations

from pathlib import Path

from app.live.lab import Lab, read_lab


def laboratory(file: Path) -> Lab:
    """The laboratory of a file; a link of its own lies beside that. Raises Refusal.

    `my_radio.py:/dev/ttyACM0` names a Python file, which opening the link runs.
    """
    lab = read_lab(file)
    kind, colon, place = lab.link.partition(":")
    if not kind.endswith(".py"):
        return lab
    return lab.model_copy(update={"link": f"{file.parent.resolve() / kind}{colon}{place}"})
