"""Packs: machine code that comes with a wheel, compiled for a level of x86-64 instead of one processor.

A pack is one file like those of the compile cache, with a checksum, that holds the compressed files of such a cache.
Its name has its level and a hash of the sources and the compiler, so that a pack of others is not found. Whoever can
write a pack can write the package's own code beside it, so nobody asks whose file it is.
"""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from .cache import SUFFIX, read, write


class InstructionLevel(NamedTuple):
    """A level of instruction sets that many processors share: LLVM's name, and LLVM's names of all the sets."""

    name: str
    instructions: tuple[str, ...]

    @property
    def features(self) -> str:
        """The instruction sets as one text, in Numba's form."""
        return ",".join(f"+{name}" for name in self.instructions)


_V2 = ("crc32", "cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3")
_V3 = (*_V2, "avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
_V4 = (*_V3, "avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl")

LEVELS = {name: InstructionLevel(name, sets) for name, sets in (("x86-64-v4", _V4), ("x86-64-v3", _V3))}
"""The levels by name, the highest first. All have fused multiply-adds, without which results have other bits."""

FOLDER = Path(__file__).with_name("prebuilt")
"""Folder of a wheel's packs."""


class Pack(NamedTuple):
    """Compressed machine code by the names of its files, and the level for which it is compiled."""

    level: InstructionLevel
    files: dict[str, bytes]

    def code(self, name: str) -> bytes | None:
        """Return the content of the file of that name, None where there is none."""
        return zlib.decompress(self.files[name]) if name in self.files else None


def best(folder: Path, key: str, features: Iterable[str]) -> Pack | None:
    """Return the pack of that key and of the highest level whose instruction sets are all among `features`; None where
    there is none, or only a damaged one.
    """
    for level in LEVELS.values():
        path = _path(folder, level, key)
        if (
            set(level.instructions) <= set(features)
            and path.is_file()
            and (content := read(path, own=False)) is not None
        ):
            return Pack(level, pickle.loads(content))
    return None


def build(code: Path, level: InstructionLevel, key: str, folder: Path) -> Path:
    """Make a pack of all machine code in a cache folder, compiled for that level; return its file."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {path.name: read(path, own=False) for path in sorted(code.glob(f"*{SUFFIX}"))}
    whole = {name: zlib.compress(content, 9) for name, content in files.items() if content is not None}
    if not whole or len(whole) < len(files):
        raise ValueError(f"{code} must be a folder of undamaged machine code")
    if not write(_path(folder, level, key), pickle.dumps(whole)):
        raise OSError(f"{folder} cannot be written")
    return _path(folder, level, key)


def _path(folder: Path, level: InstructionLevel, key: str) -> Path:
    return folder / f"{level.name}-{key}.pack"
