"""Files that are whole or not there: written beside their place, then moved; each name is taken by one run only."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import stat
import time as clock
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

DRAFT = ".fastaff-"
"""Beginning of the names of unfinished files."""

LEFT = 86400.0
"""Seconds without a change after which a draft counts as left by a process that was killed."""


def free_stem(stem: Path, suffixes: Iterable[str]) -> Path:
    """Return `stem`, or `stem-2`, `stem-3`, ... so that none of stem + suffix exists."""
    suffixes = tuple(suffixes)
    candidate, number = stem, 1
    while any(os.path.lexists(candidate.with_name(candidate.name + suffix)) for suffix in suffixes):
        number += 1
        candidate = stem.with_name(f"{stem.name}-{number}")
    return candidate


@contextlib.contextmanager
def draft(folder: Path, ending: str = "", *, of_files: bool = False) -> Iterator[Path]:
    """Yield a new file in a folder, or a folder in it (`of_files`), which is removed at the end unless it was moved
    away; first remove the drafts that killed processes left in the folder.
    """
    sweep(folder, f"{DRAFT}*")
    path = folder / f"{DRAFT}{secrets.token_hex(6)}{ending}"
    path.mkdir() if of_files else path.touch(exist_ok=False)
    try:
        yield path
    finally:
        _removed(path)


def sweep(folder: Path, pattern: str) -> None:
    """Remove the files and folders in a folder that match a pattern and have not changed for a day."""
    for path in folder.glob(pattern):
        with contextlib.suppress(OSError):
            if clock.time() - path.lstat().st_mtime > LEFT:
                _removed(path)


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


def placed(
    stem: Path, ending: str, write: Callable[[Path], object], *, beside: Iterable[str] = (), force: bool = False
) -> Path:
    """Write the file stem + ending and return its path.

    Parameters: write(path): writes the file, under another name in the same folder; beside: endings of files that will
    have the same stem; force: replace an existing file, which otherwise stays: the stem gets the first number at which
    neither it nor those beside it exist. An exception of `write` is passed on and leaves no file behind. If two
    processes want the same name, one gets it and the other the next.
    """
    if not stem.parent.is_dir():
        raise FileNotFoundError(f"the folder {stem.parent} does not exist")
    with draft(stem.parent, ending) as path:
        write(path)
        if not force:
            return _moved(path, stem, ending, (ending, *beside))
        target = stem.with_name(stem.name + ending)
        os.replace(path, target)
        return target


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
