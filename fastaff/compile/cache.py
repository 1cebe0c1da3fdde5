"""Files of the compile cache: written at once and whole, verified before use, given up where they cannot be written.

The first line is a checksum of the rest and of the file's name, behind the sign of a comment, for some files are
Python. What does not verify is as if it was not there.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import pickle
import re
import secrets
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from ..base.placing import sweep
from ..base.progress import Compiling

SUFFIX = ".code"
"""Of the files of machine code."""

_SAID: set[str] = set()


def read(path: Path) -> bytes | None:
    """Return what was written to a file; None where there is none, or after one warning where it is damaged."""
    try:
        head, _, content = path.read_bytes().partition(b"\n")
    except OSError:
        return None
    if head == _checksum(path, content):
        return content
    _warn_once(
        "damaged",
        f"the compile cache has damaged files, {path} for one: what they held is compiled again. Where that happens "
        "again, look at the disk",
    )
    return None


def write(path: Path, content: bytes) -> bool:
    """Write a file, and tell whether that went well; after the first one that did not, warn."""
    _swept(path.parent)
    draft = path.with_name(f".{path.name}-{os.getpid()}-{secrets.token_hex(4)}.tmp")
    try:
        try:
            # A new file of its own: a link that somebody put there is not followed.
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
    return True


@functools.cache
def _swept(folder: Path) -> None:
    """Remove, once in a process, the drafts that killed ones left."""
    sweep(folder, ".*.tmp")


def _checksum(path: Path, content: bytes) -> bytes:
    return b"# " + hashlib.sha256(path.name.encode() + b"\0" + content).hexdigest().encode()


def _warn_once(subject: str, message: str) -> None:
    if subject not in _SAID:
        _SAID.add(subject)
        warnings.warn(message, RuntimeWarning, stacklevel=3)


class CodeCache(NullCache):
    """Machine code of a function in a folder, a file for each signature; in place of Numba's own cache, which runs
    whatever its files have become, and stamps them by the content of one source file.
    """

    misses = 0
    """How often this process found no code and had to compile."""

    prebuilt = 0
    """How often it found code in a pack."""

    def __init__(self, function: Callable, folder: Path, pack: Callable[[], Any] = lambda: None):
        self._function, self._folder, self._pack = function, folder, pack

    @property
    def cache_path(self):
        """The folder."""
        return str(self._folder)

    def load_overload(self, sig, target_context):
        """Return the code for a signature: from the folder, else from the pack, if there is one; else None."""
        target_context.refresh()
        target = target_context.codegen().magic_tuple()
        key = self._key(sig, target)
        code = _code(read(self._path(key)), key)
        if code is None and (pack := self._pack()) is not None:
            key = self._key(sig, (target[0], pack.level.name, pack.level.features))
            code = _code(pack.code(self._path(key).name), key)
            CodeCache.prebuilt += code is not None
        if code is not None:
            return CompileResult._rebuild(target_context, *code)
        CodeCache.misses += 1
        Compiling.kernels.append(self._function.__qualname__)
        return None

    def save_overload(self, sig, data):
        """Keep the code for a signature, unless it holds addresses of this process."""
        if data.library.has_dynamic_globals or any(not part.can_cache for part in data.lifted):
            return
        key = self._key(sig, data.codegen.magic_tuple())
        unannotated = data._replace(type_annotation="")  # by types, for people: a tenth of the file
        write(self._path(key), dumps((key, unannotated._reduce())))

    def _key(self, sig: Any, target: tuple) -> tuple:
        """Return what code depends on, beyond the sources that the folder is named by."""
        code, cells = self._function.__code__, self._function.__closure__ or ()
        name = self._function.__module__, self._function.__qualname__, code.co_firstlineno
        return name, sig, target, code.co_code, dumps(tuple(cell.cell_contents for cell in cells))

    def _path(self, key: tuple) -> Path:
        """Return the file of a key: others may have the same, of classes of the same name, and lose their turn."""
        (_, name, _), sig, *rest = key
        digest = hashlib.sha256(repr((key[0], str(sig), rest)).encode()).hexdigest()[:24]
        return self._folder / f"{re.sub('[^A-Za-z0-9_]+', '_', name)[:60]}-{digest}{SUFFIX}"


def _code(content: bytes | None, key: tuple) -> tuple | None:
    """Return the code that a file holds, where it is of that key."""
    kept, code = (None, None) if content is None else pickle.loads(content)
    return code if kept == key else None
