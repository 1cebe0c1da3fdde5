"""Files that are whole or not there: written beside their place, then moved; each name is taken by one run only.

A *draft* is a folder `.fastaff-<12 hexadecimal digits>.draft` with a marker and the new file or folder. Its process
holds a lock on the marker while it lives, whatever clocks say. What a killed process left is removed by a later one:
only a folder of exactly such a name, of this user, that has the marker, which nobody holds.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
import stat
import sys
import time as clock
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from ..core.numbers import shown

try:
    import fcntl
except ImportError:  # no such locks: nobody can tell whether a draft is in use, so all stay
    locks: Any = None
else:
    locks = fcntl

DRAFT = re.compile(r"\.fastaff-[0-9a-f]{12}\.draft")
"""Names of the folders of unfinished files."""

MARKER = "made-by-fastaff"
"""File in such a folder that says what the folder is, and whose lock says that it is in use."""

SAID = "unfinished files of fastaff: this folder is removed when its process has ended; made on the machine "
"""Text of the marker, before the name of the machine: locks of other machines cannot be seen on all file systems."""

LEFT = 86400.0
"""Seconds without a change after which a draft counts as left by a process that was killed."""


def free_stem(stem: Path, suffixes: Iterable[str]) -> Path:
    """Return `stem`, or `stem-2`, `stem-3`, ... so that none of stem + suffix exists."""
    suffixes = tuple(suffixes)
    candidate = stem
    number = 1
    while any(os.path.lexists(candidate.with_name(candidate.name + suffix)) for suffix in suffixes):
        number += 1
        candidate = stem.with_name(f"{stem.name}-{number}")
    return candidate


@contextlib.contextmanager
def draft(folder: Path, ending: str = "", *, of_files: bool = False) -> Iterator[Path]:
    """Yield a new file, or a new folder (`of_files`), of the same file system as a folder. At the end it is removed
    unless it was moved away. First remove the drafts that killed processes left in the folder.
    """
    sweep_drafts(folder)
    home = folder / f".fastaff-{secrets.token_hex(6)}.draft"
    home.mkdir(mode=0o700)
    handle = None
    try:
        handle = _marked(home)
        path = home / f"new{ending}"
        path.mkdir() if of_files else path.touch(exist_ok=False)
        yield path
    finally:
        _removed(home)
        if handle is not None:
            os.close(handle)


def _marked(home: Path) -> int:
    """Mark a folder as a draft and return the open marker. It is locked before it has its text: an empty marker is
    none.
    """
    handle = os.open(home / MARKER, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600)
    if locks is not None:
        with contextlib.suppress(OSError):  # a file system without locks, on which no draft is ever removed
            locks.flock(handle, locks.LOCK_EX)
    os.write(handle, f"{SAID}{_machine()}\n".encode())
    return handle


def sweep_drafts(folder: Path) -> None:
    """Remove the drafts in a folder that killed processes of this user and machine left there a day ago."""
    if locks is None:
        return
    with contextlib.suppress(OSError):
        names = [name for name in os.listdir(folder) if DRAFT.fullmatch(name)]
        for name in names:
            with contextlib.suppress(OSError):
                _swept(folder / name)


def _swept(home: Path) -> None:
    """Remove a draft if it was left: its marker is this user's, tells of this machine, and nobody holds it."""
    told = home.lstat()
    if not stat.S_ISDIR(told.st_mode) or told.st_uid != os.geteuid():
        return
    handle = os.open(home / MARKER, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        marker = os.fstat(handle)
        if not stat.S_ISREG(marker.st_mode) or marker.st_uid != os.geteuid():
            return
        locks.flock(handle, locks.LOCK_EX | locks.LOCK_NB)  # BlockingIOError, an OSError, where it is in use
        last = max(told.st_mtime, *(entry.lstat().st_mtime for entry in home.iterdir()))
        if os.read(handle, 4096) == f"{SAID}{_machine()}\n".encode() and clock.time() - last > LEFT:
            _removed(home)
    finally:
        os.close(handle)


def _machine() -> str:
    """Return the name of this machine."""
    return os.uname().nodename if hasattr(os, "uname") else ""


def sweep(paths: Iterable[Path], name: re.Pattern[str]) -> None:
    """Remove those of some paths that are files of this user, of exactly such names, unchanged for a day: left by
    killed processes in folders that are the package's own.
    """
    for path in paths:
        if name.fullmatch(path.name):
            with contextlib.suppress(OSError):
                found = path.lstat()
                old = clock.time() - found.st_mtime > LEFT
                if old and stat.S_ISREG(found.st_mode) and is_of_this_user(found):
                    path.unlink()


def is_of_this_user(found: os.stat_result) -> bool:
    """Tell whether a file belongs to the user of this process. Windows keeps no such numbers: True."""
    return sys.platform == "win32" or found.st_uid == os.geteuid()


def checked_file(path: Any, name: str = "") -> None:
    """Refuse a path of something else than a file, such as a pipe, which would be waited for without an end; name: of
    the argument. A folder is an IsADirectoryError. A path of nothing is not refused: to open it says so.
    """
    try:
        mode = os.stat(path).st_mode
    except OSError:
        return
    except ValueError as problem:  # a null character
        raise ValueError(f"{name or 'path'} must be the path of a file, got {shown(path)}") from problem
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        raise ValueError(f"{name or 'path'} must be a file, got the pipe or device {path}")


def text_of(path: Any, name: str = "") -> str:
    """Return the text of a file in UTF-8, with or without a byte-order mark; name: of the argument."""
    checked_file(path, name)
    return Path(path).read_text(encoding="utf-8-sig")


def _removed(path: Path) -> None:
    """Remove a file or folder; try again, as other threads of a failed write may still write into it."""
    for _ in range(20):
        with contextlib.suppress(FileNotFoundError):
            if not stat.S_ISDIR(path.lstat().st_mode):
                return path.unlink()
        shutil.rmtree(path, ignore_errors=True)
        if not path.exists():
            return
        clock.sleep(0.02)


def write_atomically(
    stem: Path, ending: str, write: Callable[[Path], object], *, beside: Iterable[str] = (), overwrite: bool = False
) -> Path:
    """Write the file stem + ending and return its path.

    Parameters: write(path): writes the file, under another name in the same folder; beside: endings of files that will
    have the same stem; overwrite: replace an existing file, which otherwise stays: the stem gets the first number at
    which neither it nor those beside it exist. An exception of `write` is passed on and leaves no file behind. If two
    processes want the same name, one gets it and the other the next.
    """
    if not stem.parent.is_dir():
        raise FileNotFoundError(f"the folder {stem.parent} does not exist")
    with draft(stem.parent, ending) as path:
        write(path)
        if not overwrite:
            return _moved(path, stem, ending, (ending, *beside))
        target = stem.with_name(stem.name + ending)
        like(path, target)
        os.replace(path, target)
        return target


def like(path: Path, other: Path) -> None:
    """Give a new file or folder the permissions of the one that it will replace, if there is one."""
    with contextlib.suppress(FileNotFoundError):
        path.chmod(stat.S_IMODE(other.stat().st_mode) & 0o777)


def _moved(draft: Path, stem: Path, ending: str, endings: tuple[str, ...]) -> Path:
    """Move a file to the first free name; a link fails where another process took the name first."""
    while True:
        free = free_stem(stem, endings)
        target = free.with_name(free.name + ending)
        try:
            os.link(draft, target)
        except FileExistsError:
            continue
        except OSError:  # a file system without links
            try:
                target.touch(exist_ok=False)
            except FileExistsError:
                continue
            try:
                os.replace(draft, target)
            except BaseException:
                target.unlink(missing_ok=True)  # empty
                raise
        return target
