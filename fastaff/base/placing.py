"""Files that are whole or not there: written beside their place, then moved; each name is taken by one run only."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path


def free_stem(stem: Path, suffixes: Iterable[str]) -> Path:
    """Return `stem`, or `stem-2`, `stem-3`, ... so that none of stem + suffix exists."""
    suffixes = tuple(suffixes)
    candidate, number = stem, 1
    while any(os.path.lexists(candidate.with_name(candidate.name + suffix)) for suffix in suffixes):
        number += 1
        candidate = stem.with_name(f"{stem.name}-{number}")
    return candidate


def umask() -> int:
    """Return the permissions that new files of this process do not get."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def placed(
    stem: Path, ending: str, write: Callable[[Path], object], *, beside: Iterable[str] = (), force: bool = False
) -> Path:
    """Write the file stem + ending and return its path.

    Parameters: write(path): writes the file, under another name in the same folder; beside: endings of files that will
    have the same stem; force: replace an existing file, which otherwise stays: the stem gets the first number at which
    neither it nor those beside it exist. Whatever `write` raises is passed on and leaves nothing behind. Of two
    processes that want the same name one has it, the other the next.
    """
    if not stem.parent.is_dir():
        raise FileNotFoundError(f"the folder {stem.parent} does not exist")
    handle, name = tempfile.mkstemp(prefix=".fastaff-", suffix=ending, dir=stem.parent)
    os.close(handle)
    try:
        write(Path(name))
        os.chmod(name, 0o666 & ~umask())
        if not force:
            return _moved(name, stem, ending, (ending, *beside))
        target = stem.with_name(stem.name + ending)
        os.replace(name, target)
        return target
    finally:
        Path(name).unlink(missing_ok=True)


def _moved(name: str, stem: Path, ending: str, endings: tuple[str, ...]) -> Path:
    """Move a file to the first free name: a link fails where another process took the name first."""
    while True:
        free = free_stem(stem, endings)
        target = free.with_name(free.name + ending)
        try:
            os.link(name, target)
        except FileExistsError:
            continue
        except OSError:  # a file system without links
            try:
                target.touch(exist_ok=False)
            except FileExistsError:
                continue
            os.replace(name, target)
        return target
