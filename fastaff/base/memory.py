"""Memory that was let go of: what the C library does with it."""

from __future__ import annotations

import contextlib
import ctypes
import os
from collections.abc import Mapping

KEPT, OWN = 2**27, 2**25
"""Bytes of freed memory that stay with the process: what a call takes beside its result; those of an array from which
on it has pages of its own, the most that glibc takes.
"""
TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""Numbers of parameters of glibc's mallopt."""
SETTINGS = ("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_", "GLIBC_TUNABLES")
"""Variables of the environment by which a user says the same."""


def keep_freed(environment: Mapping[str, str] = os.environ) -> bool:
    """Have the C library keep KEPT bytes of freed memory, unless the environment says something of it; return whether
    it does.

    Else arrays of each call are new pages, which the system clears at a microsecond or two each, of all threads one
    after the other: a tenth of a section with its errors. Nothing happens where the library is not glibc.
    """
    if any(name in environment for name in SETTINGS):
        return False
    with contextlib.suppress(OSError, AttributeError, TypeError):
        set_to = ctypes.CDLL(None).mallopt
        return bool(set_to(TRIM_THRESHOLD, KEPT) and set_to(MMAP_THRESHOLD, OWN))
    return False
