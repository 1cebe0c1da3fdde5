"""Distances of two runs of the same orbits, and the errors that follow from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compile.jit import jit

PORTION = 32
"""Orbits in a unit."""


@jit
def largest(a, b):
    """Return the larger number, NaN if one is."""
    return a if a > b or a != a else b


def distances(unit, stop, progress, fine, coarse, size, winding, result):
    """Set result (moments, orbits) to the largest |fine - coarse| over the rows of phase points (moments, rows, orbits)
    in units of size (rows, orbits); rows with a finite period winding (n, orbits) are angles.
    """
    moments, rows, orbits = fine.shape
    for o in range(unit * PORTION, min((unit + 1) * PORTION, orbits)):
        for k in range(moments):
            most = 0.0
            for r in range(rows):
                away = (fine[k, r, o] - coarse[k, r, o]) / size[r, o]
                if r < winding.shape[0] and np.isfinite(winding[r, o]):
                    turn = winding[r, o] / size[r, o]
                    away -= turn * np.rint(away / turn)
                most = largest(most, abs(away))
            result[k, o] = most
    progress[unit] = 1


def straightened(unit, stop, progress, times, others, rate, parted, slant, phase, apart):
    """Turn distances of states at crossings into those across the flow (crossings, orbits), 0 where there is no
    crossing, inf from the first on that is missing in the other run or `parted`; set the radians up to crossings.

    times, others: those of both runs; slant: ratios of errors of crossings to those of states, 1 where there is none.
    """
    crossings, orbits = times.shape
    for o in range(unit * PORTION, min((unit + 1) * PORTION, orbits)):
        known = True
        for k in range(crossings):
            there = np.isfinite(times[k, o])
            if there:
                both = largest(apart[k, o], abs(times[k, o] - others[k, o]) * rate[o])
                known &= both < parted
                apart[k, o], phase[k, o] = both / slant[k, o], times[k, o] * rate[o]
            else:
                apart[k, o], phase[k, o], slant[k, o] = 0.0, 0.0, 1.0
            if not known:
                apart[k, o] = np.inf
    progress[unit] = 1


class Expected(NamedTuple):
    """Numbers of orbits (orbits,) from which errors follow: the angular frequency, the ratio of the error to the
    distance of two runs, the order of the error, rounding errors over `span` radians and of a frame's turn in a
    radian, the scheme's error over that span and in a step, both NaN where unknown.
    """

    rate: np.ndarray
    share: np.ndarray
    order: np.ndarray
    noise: np.ndarray
    turned: np.ndarray
    local: np.ndarray
    single: np.ndarray


class Factors(NamedTuple):
    """The constants of `flows.accuracy`, and whether the caller chose the steps of all orbits (1) or not (0)."""

    span: float
    rough: float
    lost: float
    least: float
    grown: float
    witness: float
    stepped: float
    alike: float


@jit
def counted(apart, part, rough, lost):
    """Return a distance times `part` up to `rough`, the whole distance from `lost` on, and a power law between."""
    if not apart > rough:
        return part * apart
    if apart >= lost:
        return apart
    return part ** (1.0 - np.log(apart / rough) / np.log(lost / rough)) * apart


def errors(unit, stop, progress, apart, phase, worn, expected, factors, error, rounding):
    """Set error and rounding (moments, orbits) as `flows.accuracy.estimated` says; worn (0, orbits) where there is
    none.
    """
    moments, orbits = apart.shape
    span, alike = factors.span, factors.alike > 0.0
    for o in range(unit * PORTION, min((unit + 1) * PORTION, orbits)):
        share, most, much = expected.share[o], 0.0, 0.0
        for k in range(moments):
            away, spans = apart[k, o], max(phase[k, o] / span, 1.0)
            # After few steps errors need not fall by the order yet, as where they lead through a core.
            part = share if phase[k, o] >= span else share ** (phase[k, o] / span)
            noise = expected.noise[o] * np.sqrt(spans) + expected.turned[o] * phase[k, o]
            local = expected.local[o]
            if np.isnan(local):
                local = away / (spans * 2.0 ** expected.order[o])
            if alike:
                rounded = away * min(noise / max(local * 2.0 ** expected.order[o], 1e-300), 2.0) + noise
            else:
                rounded = noise
                if worn.shape[0] > 0:
                    rounded += counted(worn[k, o], part, factors.rough, factors.lost)
            whole = counted(away, part, factors.rough, factors.lost) + rounded + local * expected.single[o]
            if not alike:
                # The trial's error is a lower bound: by chance the difference of two runs is too small for some orbits.
                low = local * spans
                whole = largest(whole, away if np.isnan(away) else min(max(away, low), factors.least * low))
            if worn.shape[0] > 0:
                grown = factors.grown * local * spans * counted(worn[k, o], part, factors.rough, factors.lost)
                grown /= max(noise, 1e-300)
                limit = away / part
                whole = largest(whole, grown if grown < limit or np.isnan(grown) else limit)
                witness = factors.witness * rounded
                witness = away if away < witness or np.isnan(away) else witness
                whole, rounded = whole + witness, rounded + witness
            more = factors.stepped * phase[k, o]
            most = max(most, whole + more if np.isfinite(whole) else np.inf)
            much = max(much, rounded + more if np.isfinite(rounded) else np.inf)
            error[k, o], rounding[k, o] = most, much
    progress[unit] = 1


@jit
def all_counted(apart, part, rough, lost):
    """Return `counted` of all distances (moments, orbits)."""
    result = np.empty(apart.shape)
    for k in range(apart.shape[0]):
        for o in range(apart.shape[1]):
            result[k, o] = counted(apart[k, o], part, rough, lost)
    return result
