"""Tuples of any length in compiled code, for methods that take any number of coordinates."""

from __future__ import annotations

from typing import Any

from .numba_private import overload

_INLINED: Any = {"error_model": "numpy", "forceinline": True}


def scaled(factor, v):
    """Return the tuple of factor*v_i."""
    return tuple(factor * entry for entry in v)


def halves(z):
    """Return the first and the second half of a tuple."""
    return z[: len(z) // 2], z[len(z) // 2 :]


@overload(scaled, jit_options=_INLINED)
def _scaled(factor, v):
    if len(v) == 1:
        return lambda factor, v: (factor * v[0],)
    return lambda factor, v: (factor * v[0],) + scaled(factor, v[1:])  # noqa: RUF005 - Numba joins tuples by +


@overload(halves, jit_options=_INLINED)
def _halves(z):
    n = len(z) // 2
    return lambda z: (z[:n], z[n:])
