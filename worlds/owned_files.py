"""Read and write files that nobody else can have written: all code that is run from disk.

A file, or a folder on the way to it, counts as owned if it is this user's or the administrator's
(who may do anything anyway) and neither its group nor others may write to it. It is judged by its
open descriptor, and links are not followed below the base, so that nothing can be exchanged between
the check and the use. Windows has no such owner: there the folder of a user is kept by its own
access lists, and nothing is checked.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

HAS_OWNERS = os.name == "posix"
PRIVATE_FOLDER, PRIVATE_FILE = 0o700, 0o600
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
FOLDER = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0)


class NotOwned(PermissionError):
    """Somebody else owns a file or a folder, or may write to it; `strerror` says which and why."""

    def __init__(self, reason: str):
        super().__init__(errno.EPERM, reason)


def demand_owned(status: os.stat_result, path: Path) -> None:
    """Raise NotOwned for a file or folder that another user owns or may write to."""
    if status.st_uid not in (os.geteuid(), 0):
        raise NotOwned(f"{path} belongs to another user")
    if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise NotOwned(f"others may write to {path}")


@contextmanager
def owned_folder(base: Path, *parts: str, make: bool = False) -> Iterator[int | None]:
    """The descriptor of a folder below `base`, each on the way checked; None where no owners are.

    `make` makes what is not there, for this user alone. `base` itself may be a link: whoever names
    it chooses it. Raises OSError, NotOwned for a folder that others own or may write to.
    """
    if make:
        base.mkdir(PRIVATE_FOLDER, parents=True, exist_ok=True)
    if not HAS_OWNERS:
        if make:
            base.joinpath(*parts).mkdir(parents=True, exist_ok=True)
        yield None
        return
    path, folder = base, os.open(base, FOLDER)
    try:
        demand_owned(os.fstat(folder), path)
        for part in parts:
            path /= part
            if make:
                with suppress(FileExistsError):
                    os.mkdir(part, PRIVATE_FOLDER, dir_fd=folder)
            subfolder = open_in(folder, path, FOLDER)
            os.close(folder)
            folder = subfolder
            demand_owned(os.fstat(folder), path)
        yield folder
    finally:
        os.close(folder)


def open_in(folder: int | None, path: Path, flags: int, mode: int = PRIVATE_FILE) -> int:
    """Open what `path` names in an open folder. Raises NotOwned for a link."""
    if folder is None:
        return os.open(path, flags | getattr(os, "O_BINARY", 0), mode)
    try:
        return os.open(path.name, flags | NO_LINK, mode, dir_fd=folder)
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.ENOTDIR):  # Linux says the latter of links to folders
            raise NotOwned(f"{path} is a link or of another kind") from None
        raise


def read_owned(base: Path, *parts: str) -> bytes:
    """The content of a file below `base`. Raises OSError, NotOwned for what others may write to."""
    path = base.joinpath(*parts)
    # A pipe is opened without waiting for who writes to it, and then refused.
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)
    with (
        owned_folder(base, *parts[:-1]) as folder,
        open(open_in(folder, path, flags), "rb") as file,
    ):
        if folder is not None:
            status = os.fstat(file.fileno())
            demand_owned(status, path)
            if not stat.S_ISREG(status.st_mode):
                raise NotOwned(f"{path} is no file")
        return file.read()


def write_owned(content: bytes, base: Path, *parts: str) -> None:
    """Write a file below `base`, whole or not at all, for this user alone. Raises OSError."""
    path = base.joinpath(*parts)
    temporary = path.with_name(f"{path.name}.{secrets.token_hex(6)}.tmp")
    with owned_folder(base, *parts[:-1], make=True) as folder:
        names = (temporary, path) if folder is None else (temporary.name, path.name)
        try:
            descriptor = open_in(folder, temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
            with open(descriptor, "wb") as file:
                file.write(content)
            os.replace(*names, src_dir_fd=folder, dst_dir_fd=folder)
        except BaseException:
            with suppress(OSError):
                os.unlink(names[0], dir_fd=folder)
            raise
