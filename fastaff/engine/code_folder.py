"""The folder of the compile cache, and the keys by which it knows the sources of its code."""

from __future__ import annotations

import functools
import hashlib
import os
import platform
import stat
import sys
import sysconfig
import warnings
from pathlib import Path
from typing import Any

import numba

from . import sources
from .cache import cache_root, others_write
from .numba_private import config as _config
from .numba_private import get_host_cpu_features, llvmlite
from .packs import FOLDER, Pack, best
from .sources import ROOT

config: Any = _config  # its options are set at run time, unknown to type checkers

GENERATED = ("blocks", "formulas")
"""Folders of generated source text in the cache."""


@functools.cache
def package_hash() -> str:
    """Hash of every source file of the package, and of the compiler and its options."""
    digest = hashlib.sha256()
    for path in sorted(ROOT.rglob("*.py")):
        digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return _hash(sys.version, digest.hexdigest())


def _hash(python: str, meaning: str | None) -> str:
    flags = f"{config.OPT} {config.BOUNDSCHECK}"  # of the environment, NUMBA_OPT and NUMBA_BOUNDSCHECK
    compilers = f"{numba.__version__} {llvmlite.__version__} {python}"
    return hashlib.sha256(f"{compilers} {platform.machine()} {flags} {meaning}".encode()).hexdigest()[:20]


@functools.cache
def code_hash(module: str) -> str:
    """Hash of what a module and all that it imports mean, and of the compiler."""
    return _hash(sys.version, sources.key((module, *sources.compiler())))


@functools.cache
def compiler_hash() -> str:
    """Hash of the compiler, with what the modules of `engine` mean: the name of the folder of code. Each file in it has
    a key of the sources of its kernel.
    """
    return _hash(sys.version, sources.key(sources.compiler()))


@functools.cache
def pack_key() -> str:
    """The same hash with EXT_SUFFIX for Python's version: the key of packs, which another build of this version of
    Python has compiled elsewhere.
    """
    return _hash(f"{sysconfig.get_config_var('EXT_SUFFIX')}", sources.key(sources.compiler()))


@functools.cache
def prebuilt() -> Pack | None:
    """Return the pack that came with the package for this compiler and this processor; None where there is none, and
    where the environment names a target processor (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES).
    """
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:
        return None
    known = [entry[1:] for entry in get_host_cpu_features().split(",") if entry.startswith("+")]
    return best(FOLDER, pack_key(), known)


@functools.cache
def cache_directory() -> Path | None:
    """Private cache folder of exactly this compiler; None, after one warning, where there is none and none can be made,
    and None of a package without its sources, by which code is known.

    Its files are executed, so it must belong to the user or to root, and neither it nor its parts may be writable by
    others. A folder that this process can only read is enough.
    """
    if sources.key(sources.compiler()) is None:
        return None
    folder = cache_root() / compiler_hash()
    parts = [cache_root(), folder, *(folder / name for name in GENERATED)]
    try:
        cache_root().parent.mkdir(parents=True, exist_ok=True)
        for part in parts:
            part.mkdir(mode=0o700, exist_ok=True)
        refused = next(filter(None, (who_else_writes(part, parent=part is parts[0]) for part in parts)), None)
    except OSError as problem:
        refused = f"fastaff cannot write its compile cache ({problem})", "Set FASTAFF_CACHE_DIR to a writable folder."
    if refused is not None:
        warnings.warn(
            f"{refused[0]}; kernels are compiled anew in every process. {refused[1]}", RuntimeWarning, stacklevel=2
        )
        return None
    return folder


def who_else_writes(folder: Path, *, parent: bool = False) -> tuple[str, str] | None:
    """Return the fault of a folder of code that somebody else could write to, and its remedy; None where only this user
    and root can write.

    parent: it holds no code itself, but the folders of code. Such a one may be shared like /tmp, where only owners may
    rename (sticky). A link is followed: the folder that it leads to counts. Windows keeps a user's folders private by
    itself.
    """
    if not hasattr(os, "geteuid"):
        return None
    status = folder.stat()
    own = status.st_uid in (0, os.geteuid())
    if not others_write(status) or (parent and own and status.st_mode & stat.S_ISVTX):
        return None
    said = f"fastaff does not use its compile cache, whose code it would run: the folder {folder}"
    if not own:
        return f"{said} belongs to another user (uid {status.st_uid})", "Set FASTAFF_CACHE_DIR to a folder of your own."
    mode = stat.S_IMODE(status.st_mode)
    return f"{said} can be written by others (mode {mode:o})", f"Empty it and run: chmod -R go-w '{folder}'"
