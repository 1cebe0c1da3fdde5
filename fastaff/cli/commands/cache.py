"""`fastaff cache`: the compiled kernels that are kept on disk."""

from __future__ import annotations

from typing import Annotated

from ..options import HOW, Parameter


def cache(*, clear: Annotated[bool, Parameter(group=HOW)] = False) -> int:
    """Print the folder of compiled kernels, its size and its number of files.

    If the files take more than 2 GiB, those that were used longest ago are removed. A kernel without a file is compiled
    at its first use.

    Parameters
    ----------
    clear
        Remove the files, of all versions. Other files in the folder stay.
    """
    from ...engine import room
    from ...engine.code_folder import cache_root

    root = cache_root()
    if clear:
        gone = room.clear(root)
        print(f"removed {_told(gone)} from {root}")
    found = list(room.entries(root))
    versions = len({entry.path.relative_to(root).parts[0] for entry in found})
    print(f"{root}: {_told(found)} of {versions} {'version' if versions == 1 else 'versions'}")
    return 0


def _told(entries: list) -> str:
    """Return the number and size of entries."""
    size = sum(entry.size for entry in entries)
    return f"{len(entries)} files, {size / 2**20:.1f} MiB"
