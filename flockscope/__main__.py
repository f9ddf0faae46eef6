"""The command `flockscope`, also as `python -m flockscope`."""

from __future__ import annotations

import errno
import sys
from contextlib import suppress

try:
    import resource
except ImportError:  # Windows has no such limits
    resource = None  # type: ignore[assignment]

NO_MEMORY = (
    "annot allocate memory",
    "failed to map segment",
    "Could not find/load shared object",
    "can't start new thread",
)
"""What libraries say where the system gives them no memory for code or threads."""


def main() -> None:
    """Run the command line.

    A module that is in the way, or memory that does not reach for the libraries, is told in one
    line, with exit code 2.
    """
    try:
        from flockscope import _in_the_way  # noqa: F401 - looks when it is imported
    except ImportError as error:
        stop(str(error))
    try:
        if memory_limit():
            # Where others have taken the memory before it, OpenBLAS ends the process by itself.
            import scipy.linalg  # noqa: F401
        from app.cli.main import main as command

        command()
    except (ImportError, MemoryError, OSError, RuntimeError) as error:
        if lacks_memory(error):
            stop(f"there is not enough memory{memory_limit() or ': use fewer agents'}")
        if isinstance(error, OSError) and error.errno == errno.ENOSPC and error.filename is None:
            raise SystemExit(2) from None  # what is wrong with a call cannot be told
        raise


def lacks_memory(error: BaseException | None) -> bool:
    """Whether an error, or one that led to it, says that memory is missing."""
    while error is not None:
        if isinstance(error, MemoryError) or any(sign in str(error) for sign in NO_MEMORY):
            return True
        error = error.__cause__ or error.__context__
    return False


def memory_limit() -> str:
    """The limit of the address space, in words; nothing where there is none."""
    if resource is None:
        return ""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return ""
    return f": `ulimit -v` allows {limit // 1024} kB; allow more, or lift it"


def stop(message: str) -> None:
    """Tell why nothing can be done, in a line that commands no terminal, and end."""
    printable = "".join(
        letter if letter.isprintable() else ascii(letter)[1:-1] for letter in message
    )
    with suppress(OSError):
        print(f"flockscope: {printable}", file=sys.stderr)
    raise SystemExit(2) from None


if __name__ == "__main__":
    main()
