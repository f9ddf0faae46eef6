"""The command `flockscope`, also as `python -m flockscope`."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; a module that is in the way is named in one line, exit code 2."""
    try:
        from flockscope import _in_the_way  # noqa: F401 - looks when it is imported
    except ImportError as error:
        print(f"flockscope: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    from app.cli.main import main as command

    command()


if __name__ == "__main__":
    main()
