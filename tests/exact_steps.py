"""Twins of compiled steps: multiply-adds in exact arithmetic, and calls of blocks from compiled code."""

from __future__ import annotations

from fractions import Fraction

import numba


def fma_exact(a, b, c):
    """Return a*b + c, which fractions know, rounded once."""
    return float(Fraction(float(a)) * Fraction(float(b)) + Fraction(float(c)))


@numba.njit
def run_block(block, params, lanes, drift, kick, step, steps, z):
    """Call a compiled block of many lanes."""
    return block(params, lanes, drift, kick, step, steps, z)


@numba.njit
def run_single(block, params, drift, kick, step, steps, z):
    """Call a compiled loop for one orbit."""
    return block(params, drift, kick, step, steps, z, z[:0])
