"""The folder of a store: its name, and one process that writes it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..core.numbers import shown
from .store import Store, is_store
from .wording import OptionError


def as_path(store: Any) -> Path:
    """Return the path that names a store."""
    try:
        path = Path(store)
        os.fsencode(path)
        if "\0" in str(path):
            raise ValueError
    except (TypeError, ValueError):
        raise TypeError(f"store must be the path of a folder, got {shown(store)} ({type(store).__name__})") from None
    return path


@contextlib.contextmanager
def exclusive_lock(path: Path) -> Iterator[None]:
    """Hold a store for this process; refuse one that another process holds."""
    if not is_store(path):
        Store(path)  # raises the error
    try:
        import fcntl
    except ImportError:  # no such locks: two processes would write the same bytes
        yield
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OptionError(f"{path} is being written by another process; wait for it or stop it") from None
        except OSError:  # a file system without locks
            pass
        if os.stat(path).st_ino != os.fstat(handle).st_ino:
            raise OptionError(f"{path} was replaced by another process in this moment")
        yield
    finally:
        os.close(handle)
