"""Treatment of freed memory by the C library."""

from __future__ import annotations

import contextlib
import ctypes
import os
from collections.abc import Mapping

KEPT = 2**27
"""Bytes of freed memory that stay with the process, enough for the work arrays of a call."""

OWN = 2**25
"""Bytes above which an array has pages of its own, the most that glibc allows."""

TRIM_THRESHOLD = -1
"""Number of the parameter M_TRIM_THRESHOLD of glibc's mallopt."""

MMAP_THRESHOLD = -3
"""Number of the parameter M_MMAP_THRESHOLD of glibc's mallopt."""

SETTINGS = ("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_", "GLIBC_TUNABLES")
"""Variables of the environment by which a user says the same."""


def keep_freed(environment: Mapping[str, str] = os.environ) -> bool:
    """Make the C library keep KEPT bytes of freed memory, unless the environment sets this; return whether it does.

    Otherwise the arrays of each call are new pages. The system clears each in a microsecond or two, for one thread
    after the other: a tenth of the time of a section with its errors. Without glibc nothing happens.
    """
    if any(name in environment for name in SETTINGS):
        return False
    with contextlib.suppress(OSError, AttributeError, TypeError):
        set_to = ctypes.CDLL(None).mallopt
        return bool(set_to(TRIM_THRESHOLD, KEPT) and set_to(MMAP_THRESHOLD, OWN))
    return False
