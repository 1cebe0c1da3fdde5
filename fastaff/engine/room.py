"""The room that the compile cache takes on disk: its entries, their removal, and its bound.

An entry is a file that the cache writes, known by the name of its folder, by its own and by its first line, which is a
checksum: whatever else lies in the folder of the user's choice stays. What was used longest ago goes first; it would be
compiled again.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ..core.placing import is_of_this_user

MOST = 2 * 2**30
"""Bytes that the cache takes at most: the kernels of one version with a few models take 5 to 15 MB, a model 0.3 MB."""

KEPT = 0.75
"""Share of MOST that is kept where it is passed, so that the next files have room."""

OFTEN = 16
"""The entries are counted when a process has written the first file, and again after each share 1/OFTEN of MOST."""

FOLDER = re.compile(r"[0-9a-f]{20}")
"""Names of the folders of one version of the compiler, with `engine`."""

FILES = {
    ".": re.compile(r"\w+-[0-9a-f]{24}\.code", re.ASCII),
    "blocks": re.compile(r"\w+_[0-9a-f]{20}\.py", re.ASCII),
    "formulas": re.compile(r"[0-9a-f]{24}\.py", re.ASCII),
}
"""Names of files by the folder in it."""

INDEX = "sources.json"
"""Name of the file of what is known of sources, beside those folders: see `sources`."""

HEAD = re.compile(rb"# [0-9a-f]{64}\n")
"""First line of each."""


class Entry(NamedTuple):
    """A file of the cache: its path, its bytes and when it was last used (seconds since 1970)."""

    path: Path
    size: int
    used: float


class _Written:
    """Bytes that this process has written since it counted the entries; none counted yet."""

    since: int | None = None


def entries(root: Path) -> Iterator[Entry]:
    """Yield the entries of a cache in no order."""
    for folder in _folders(root):
        for inner, name in FILES.items():
            with contextlib.suppress(OSError):
                for path in (folder / inner).iterdir():
                    with contextlib.suppress(OSError):
                        found = path.lstat()
                        if name.fullmatch(path.name) and stat.S_ISREG(found.st_mode) and is_of_this_user(found):
                            yield Entry(path, found.st_size, max(found.st_atime, found.st_mtime))


def _folders(root: Path) -> list[Path]:
    """Return the folders of a cache."""
    with contextlib.suppress(OSError):
        return [path for path in root.iterdir() if FOLDER.fullmatch(path.name) and not path.is_symlink()]
    return []


def wrote(path: Path, size: int) -> None:
    """Say that this process has written a file of the cache; at times this removes what was used longest ago."""
    folder = path.parent.parent if path.parent.name in FILES else path.parent
    if not FOLDER.fullmatch(folder.name):
        return
    counted = _Written.since is not None
    _Written.since = (_Written.since or 0) + size
    if not counted or _Written.since > MOST / OFTEN:
        _Written.since = 0
        bound(folder.parent, MOST)


def bound(root: Path, most: float) -> list[Entry]:
    """Remove what was used longest ago where a cache takes more than that many bytes; return the entries removed."""
    found = sorted(entries(root), key=lambda entry: entry.used)
    total = sum(entry.size for entry in found)
    gone = []
    if total > most:
        for entry in found:
            if total <= KEPT * most:
                break
            if _removed(entry.path):
                gone.append(entry)
                total -= entry.size
        _emptied(root)
    return gone


def clear(root: Path) -> list[Entry]:
    """Remove all entries of a cache, and its folders where nothing else is in them; return the entries removed."""
    gone = [entry for entry in list(entries(root)) if _removed(entry.path)]
    _removed(root / INDEX)
    _emptied(root)
    return gone


def _removed(path: Path) -> bool:
    """Remove a file if its first line is that of an entry; tell whether that was so."""
    with contextlib.suppress(OSError):
        with open(path, "rb") as file:
            whole = HEAD.fullmatch(file.read(67)) is not None
        if whole:
            path.unlink()
        return whole
    return False


def _emptied(root: Path) -> None:
    """Remove folders of the cache that are empty."""
    for folder in _folders(root):
        for part in (*(folder / name for name in FILES if name != "."), folder):
            with contextlib.suppress(OSError):
                os.rmdir(part)
