"""Frequencies of loops, in windows of the whole and of its halves, from demodulated lines, and mean rates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...kernels import demodulation
from ...kernels.fundamental import BLOCK
from .fundamental import Loops, adopt, run, taken
from .signals import Signals
from .windows import bump, tables_for, tabulated

HALVES = ((0.0, 1.0), (0.0, 0.5), (0.5, 1.0))
PAIRS = (0.7, 0.8)
"""Windows of lines: the whole and its halves, and the lengths of two parts of each that show its error."""

BOUND = 10.0
"""Factor of the error over the differences of the pairs: the error of one line from 1.5 cycles away on is within."""

RECENTRED = 0.5
"""Largest distance of a line from its first value, in cycles over the whole."""

PARTS = (
    *((0.0, 1.0), (0.0, 0.5), (0.5, 1.0), (0.0, 0.6), (0.4, 1.0)),
    *((0.0, 0.35), (0.15, 0.5), (0.5, 0.85), (0.65, 1.0)),
)
"""Windows of orbits in time: the whole, both halves, two that tell the error of the whole, and two for each half."""


class LineRates(NamedTuple):
    """Frequencies nu (orbits, loops) of lines with their errors, and those of both halves (orbits, loops, 2)."""

    nu: np.ndarray
    error: np.ndarray
    halves: np.ndarray
    halves_error: np.ndarray


def _spans(samples: int) -> list[tuple[int, int]]:
    """Return the first sample and the length of HALVES, then of the first and the last of PAIRS of each."""
    half = samples // 2
    halves = [(0, samples), (0, half), (samples - half, half)]
    spans = list(halves)
    for begin, whole in halves:
        for part in PAIRS:
            length = round(part * whole)
            spans += [(begin, length), (begin + whole - length, length)]
    return spans


@tabulated
def _windows(samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the weights of the sums over a loop, one after the other, and for each of the 18 sums (18, 3) the place of
    its weights, its first sample and its length.

    For the whole and each half a window and its change from sample to sample, then for each of them the windows over
    its first and last PAIRS of it.
    """
    made: dict[tuple[int, bool], int] = {}
    numbers, places, size = [], [], 0
    for k, (begin, length) in enumerate(_spans(samples)):
        for change in (False, True) if k < len(HALVES) else (False,):
            if (length, change) not in made:
                made[length, change], size = size, size + length
                window = np.append(bump(length - 1, 0.0, 1.0), 0.0) if k < len(HALVES) else bump(length, 0.0, 1.0)
                numbers.append(np.append(0.0, window[:-1]) - window if change else window)
            places.append((made[length, change], begin, length))
    return np.concatenate(numbers), np.array(places)


def _weights(samples: int) -> np.ndarray:
    return _windows(samples)[0]


def _places(samples: int) -> np.ndarray:
    return _windows(samples)[1]


def demodulated(
    signals: Signals, loops: Loops, nu: np.ndarray, threads: int, samples: np.ndarray | None = None
) -> LineRates:
    """Return the frequencies of the lines by nu (orbits, loops), 0 for none, of loops of the signals, or of their first
    samples (orbits,), then without errors.

    With sums S of a line times a window and D times the window's change, the turn from one sample to the next is that
    of 1 + D/S, exactly; another line of relative amplitude a and at a distance d adds a d W(d). The phases of two
    windows over parts of it bound that term for d beyond 1.5/time.
    """
    used = signals.samples if samples is None else samples
    rates = _demodulated(signals, loops, nu, threads, used, samples is None)
    off = np.abs(rates.nu - nu) * (signals.interval * used)[:, None]
    far = (np.isfinite(off) & (off > RECENTRED)).any(axis=1)
    if far.any():  # the windows see less of a line that far
        near, some = np.where((off < 3.0)[far], rates.nu[far], nu[far]), np.flatnonzero(far)
        again = _demodulated(signals.of(some), taken(loops, far), near, threads, used[far], samples is None)
        adopt(rates, far, again)
    return rates


def _demodulated(
    signals: Signals, loops: Loops, nu: np.ndarray, threads: int, samples: np.ndarray, errors: bool
) -> LineRates:
    tables, places = tables_for(_weights, samples), tables_for(_places, samples)
    parts = len(HALVES)
    sums = np.zeros((*nu.shape, 2 * parts * (1 + len(PAIRS) * errors)), complex)
    arguments = signals.ragged, samples, loops.complexes(), nu, signals.interval, tables, places, sums
    run(demodulation.demodulate, len(nu), arguments, threads)
    unit = 2 * np.pi * signals.interval[:, None]
    off, spread = np.zeros((2, *nu.shape, parts))
    with np.errstate(all="ignore"):
        for i in range(parts):
            whole = (samples if i == 0 else samples // 2)[:, None]
            off[:, :, i] = np.angle(1 + sums[:, :, 2 * i + 1] / sums[:, :, 2 * i])
            for j, part in enumerate(PAIRS * errors):
                at = 2 * (parts + len(PAIRS) * i + j)
                apart = whole - np.rint(part * whole)
                phase = sums[:, :, at + 1] * sums[:, :, at].conj() * np.exp(-1j * off[:, :, i] * apart)
                spread[:, :, i] = np.maximum(spread[:, :, i], np.abs(np.angle(phase)) / apart)
        error = BOUND * spread / unit[:, :, None]
        found = nu[:, :, None] + off / unit[:, :, None]
    none = ~np.isfinite(found) | ~np.isfinite(error)
    found, error = np.where(none, nu[:, :, None], found), np.where(none, np.inf, error)
    return LineRates(found[:, :, 0].copy(), error[:, :, 0].copy(), found[:, :, 1:].copy(), error[:, :, 1:].copy())


@tabulated
def parts(steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the weights (parts, steps) of PARTS, and where each begins and ends (parts, 2), in whole BLOCKs."""
    weights = np.array([bump(steps, *span) for span in PARTS])
    places = np.array(PARTS) * steps / BLOCK
    spans = BLOCK * np.stack([np.floor(places[:, 0]), np.ceil(places[:, 1])], axis=1).astype(np.int64)
    return weights, np.minimum(spans, steps)


def turning(
    signals: np.ndarray, loops: Loops, weights: np.ndarray, spans: np.ndarray, interval: float, threads: int
) -> np.ndarray:
    """Return weighted mean rates (orbits, loops, windows), in cycles per unit time, of loops of the first samples of
    the signals, with the weights of some of `parts`.
    """
    rates = np.zeros((*loops.offset.shape, len(weights)))
    run(demodulation.turn, len(signals), (signals, loops.complexes(), weights, spans, rates), threads)
    return rates / (2 * np.pi * interval)
