"""Sizes of memory in bytes, as numbers or as texts with a unit."""

from __future__ import annotations

import math
from typing import Any

from .numbers import positive, shown

UNITS = {"": 1, "B": 1, "KB": 1000, **{f"{p}B": 1000**k for k, p in enumerate("kMGT", 1)}}
UNITS |= {f"{p}iB": 1024**k for k, p in enumerate("KMGT", 1)}


def bytes_of(name: str, value: Any) -> float:
    """Return the bytes of a number, or of a text such as 500MB, 2GiB or 1e9; ValueError or TypeError for others."""
    if not isinstance(value, str):
        return positive(name, value)
    number = value.strip().rstrip("BKMGTikbmgt")
    unit = {text.lower(): size for text, size in UNITS.items()}.get(value.strip()[len(number) :].strip().lower())
    try:
        size = float(number) * (unit or math.nan)
        if not 0 < size < math.inf:
            raise ValueError
    except ValueError:
        raise ValueError(f"{name} must be a number of bytes, for example 500MB or 2GiB, got {shown(value)}") from None
    return size
