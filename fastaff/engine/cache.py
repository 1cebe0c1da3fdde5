"""Files of the compile cache: written whole or not at all, verified before use, left out where they cannot be written.

The first line is a checksum of the rest and of the file's name, after a comment sign, as some files are Python. A file
with a wrong checksum counts as missing.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import pickle
import re
import secrets
import stat
import sys
import time as clock
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..core.compilations import Compiling
from ..core.placing import sweep
from . import room
from .numba_private import CompileResult, NullCache, dumps

SUFFIX = ".code"
"""Ending of the names of files of machine code."""

HOUR = 3600.0
"""Seconds after which a use of a file is written down again."""

DRAFT = re.compile(r"\.[A-Za-z0-9_]+(-[0-9a-f]{24})?\.(code|py|json)-\d+-[0-9a-f]{8}\.tmp")
"""Names of files that are being written."""

_SAID: set[str] = set()


def cache_root() -> Path:
    """Folder of all compile caches: $FASTAFF_CACHE_DIR, else fastaff/ in the user's cache folder."""
    named = os.environ.get("FASTAFF_CACHE_DIR")
    if named:
        return _absolute(named)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData/Local")) / "fastaff"
    home = os.environ.get("XDG_CACHE_HOME", "")
    # By its specification one that is not absolute is none.
    return (Path(home) if os.path.isabs(home) else Path.home() / ".cache") / "fastaff"


@functools.cache
def _absolute(named: str) -> Path:
    """Return the path of a folder that was named before the process went elsewhere: the first time tells."""
    return Path(named).absolute()


def read(path: Path, *, own: bool = True) -> bytes | None:
    """Return the content of a file; None where there is none, or after one warning where it is damaged or, with `own`,
    where others than this user and root could have written it.
    """
    try:
        whole = _whole(path, own)
    except OSError:
        return None
    if whole is None:
        return None
    head, _, content = whole.partition(b"\n")
    if head == _checksum(path, content):
        return content
    _warn_once(
        "damaged",
        f"the compile cache has damaged files, {path} for one: what they held is compiled again. Where that happens "
        "again, look at the disk",
    )
    return None


def _whole(path: Path, own: bool) -> bytes | None:
    """Return all bytes of a file; None of what is no file or, with `own`, could be another's."""
    # A pipe is opened at once and refused: without O_NONBLOCK this would wait for its writer.
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            return None
        if own and others_write(found):
            _warn_once(
                "foreign",
                f"the compile cache has files that others could write, {path} for one: they are not run, but compiled "
                "again",
            )
            return None
        if own:
            _used(handle, found)
        with open(handle, "rb", closefd=False) as file:
            return file.read()
    finally:
        os.close(handle)


def others_write(found: os.stat_result) -> bool:
    """Tell whether others than this user and root could write a file or folder: root can write all anyway. Windows
    keeps a user's folders private by itself.
    """
    if not hasattr(os, "geteuid"):
        return False
    return found.st_uid not in (0, os.geteuid()) or bool(found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


def _used(handle: int, found: os.stat_result) -> None:
    """Keep the hour of the last use, by which `room` removes files: the time of access, which file systems do not keep
    by themselves.
    """
    if clock.time() - found.st_atime > HOUR and os.utime in os.supports_fd:
        with contextlib.suppress(OSError):  # a folder that can only be read
            os.utime(handle, ns=(clock.time_ns(), found.st_mtime_ns))


def write(path: Path, content: bytes) -> bool:
    """Write a file and return whether that succeeded; warn after the first failure."""
    _swept(path.parent)
    draft = path.with_name(f".{path.name}-{os.getpid()}-{secrets.token_hex(4)}.tmp")
    try:
        try:
            # A new file: a link that somebody put there is not followed.
            handle = os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
            with open(handle, "wb") as file:
                file.write(_checksum(path, content) + b"\n" + content)
            os.replace(draft, path)
        except BaseException:
            with contextlib.suppress(OSError):
                draft.unlink()
            raise
    except OSError as problem:
        _warn_once(
            "unwritten",
            f"fastaff cannot write its compile cache ({problem}); what is not in it is compiled anew in every process. "
            "Make room, or set FASTAFF_CACHE_DIR to a writable folder",
        )
        return False
    room.wrote(path, len(content))
    return True


@functools.cache
def _swept(folder: Path) -> None:
    """Remove, once in a process, the drafts that killed processes left."""
    with contextlib.suppress(OSError):
        sweep([*folder.iterdir()], DRAFT)


def _checksum(path: Path, content: bytes) -> bytes:
    return b"# " + hashlib.sha256(path.name.encode() + b"\0" + content).hexdigest().encode()


def _warn_once(subject: str, message: str) -> None:
    if subject not in _SAID:
        _SAID.add(subject)
        warnings.warn(message, RuntimeWarning, stacklevel=3)


class CodeCache(NullCache):
    """Machine code of a function in a folder, a file for each signature. It replaces Numba's own cache, which runs its
    files unchecked and stamps them by the content of one source file.
    """

    misses = 0
    """Number of times that this process found no code and had to compile."""

    prebuilt = 0
    """Number of times that it found code in a pack."""

    def __init__(
        self,
        function: Callable,
        folder: Path,
        content: Callable[[], str | None],
        pack: Callable[[], Any] = lambda: None,
    ):
        """content: returns the key of what the function reads, which somebody may have changed in this process, or
        None: its code is not kept.
        """
        self._function = function
        self._folder = folder
        self._pack = pack
        self._content = content

    @property
    def cache_path(self):
        """The folder."""
        return str(self._folder)

    def load_overload(self, sig, target_context):
        """Return the code for a signature: from the folder, else from the pack, if there is one; else None."""
        target_context.refresh()
        target = target_context.codegen().magic_tuple()
        content = self._content()
        code = None
        if content is not None:
            key = self._key(sig, target, content)
            code = _code(read(self._path(key)), key)
        if code is None and content is not None and (pack := self._pack()) is not None:
            key = self._key(sig, (target[0], pack.level.name, pack.level.features), content)
            code = _code(pack.code(self._path(key).name), key)
            CodeCache.prebuilt += code is not None
        if code is not None:
            return CompileResult._rebuild(target_context, *code)
        CodeCache.misses += 1
        Compiling.kernels += 1
        return None

    def save_overload(self, sig, data):
        """Keep the code for a signature, unless it holds addresses of this process or values of unknown content."""
        content = self._content()
        if content is None or data.library.has_dynamic_globals or any(not part.can_cache for part in data.lifted):
            return
        key = self._key(sig, data.codegen.magic_tuple(), content)
        unannotated = data._replace(type_annotation="")  # for people only: a tenth of the file
        write(self._path(key), dumps((key, unannotated._reduce())))

    def _key(self, sig: Any, target: tuple, content: str) -> tuple:
        """Return the key of code beside the compiler, by which the folder is named. Lines are no part of it: they
        differ after an edit above the function.
        """
        code = self._function.__code__
        cells = self._function.__closure__ or ()
        name = self._function.__module__, self._function.__qualname__
        return name, sig, target, code.co_code, dumps(tuple(cell.cell_contents for cell in cells)), content

    def _path(self, key: tuple) -> Path:
        """Return the file of a key; keys of different classes of one name may share it, and replace one another."""
        (_, name), sig, *rest = key
        digest = hashlib.sha256(repr((key[0], str(sig), rest)).encode()).hexdigest()[:24]
        return self._folder / f"{re.sub('[^A-Za-z0-9_]+', '_', name)[:60]}-{digest}{SUFFIX}"


def _code(content: bytes | None, key: tuple) -> tuple | None:
    """Return the code in a file if it has that key."""
    kept, code = (None, None) if content is None else pickle.loads(content)
    return code if kept == key else None
