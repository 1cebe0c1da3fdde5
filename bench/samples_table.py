"""Error of a frequency against the number of samples, beside other methods: a table of docs/benchmarks/validation.md.

Run: OPENBLAS_NUM_THREADS=1 python bench/samples_table.py [--write], 2 minutes; with --turns the tables of `tunes` of
maps nobody tuned for (`turn_tables.py`), 3 minutes. Each number is the median over ORBITS
orbits of the relative error of one frequency. All methods get the same samples of one complex signal, q - i p, or
exp(i x) for the map; `fastaff` gets all coordinates of the orbit, and for the map its initial condition.

The rows of nafflib need that program (make peers). SuperFreq 0.1.2 cannot be built for Python 3.11; its window is that
of nafflib's order 1.
"""

from __future__ import annotations

import argparse
import importlib.util
from collections.abc import Callable
from functools import partial
from time import process_time
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from pages import PROGRAMS, put, stamp, where
from scipy.linalg import lstsq
from scipy.special import ellipj, ellipk
from turn_tables import turn_tables

import fastaff as fa
from fastaff.frequencies.fundamental import lines_of

COUNTS = (100, 200, 400, 1000, 3000)
ORBITS = 15
LONGEST = 250
"""Longest half of a filter of the reduced rank extrapolation: larger ones cost seconds an orbit."""

BATCH, REPEATS = 20, 5
"""Copies of the orbits in one call of `orbit_frequencies` whose time is measured; measurements, of which the least
counts.
"""

ROUNDED = 2e-15
"""Relative error of rounding, below which errors count as equal."""


class Orbit(NamedTuple):
    """Samples of one orbit: f (samples,), the complex signal, about 0; rows (2n, samples) for `orbit_frequencies`; nu,
    the frequencies, in cycles per sample, of which a method may find any; start: initial conditions of a map.
    """

    f: np.ndarray
    rows: np.ndarray
    nu: np.ndarray
    start: np.ndarray | None = None


# Signals.


def pendulums(random: np.random.Generator) -> list[Orbit]:
    """Return librations of a pendulum, x - i p, one sample per unit time, with amplitudes of 0.3 to 2.8 radians."""
    orbits = []
    for k in np.sin(random.uniform(0.3, 2.8, ORBITS) / 2):
        quarter = ellipk(k * k)
        u = np.mod(np.arange(COUNTS[-1]) + random.uniform(0, 4 * quarter), 4 * quarter)
        sn, cn, *_ = ellipj(u, k * k)
        x, p = 2 * np.arcsin(k * sn), 2 * k * cn
        orbits.append(Orbit(x - 1j * p, np.array([x, p]), np.array([1 / (4 * quarter)])))
    return orbits


def combinations(random: np.random.Generator) -> list[Orbit]:
    """Return two loops of 144 lines k . nu, |k|_1 <= 8, of random phases, whose amplitudes fall with the square of the
    distance |k - k_0|_1 from their leading lines k_0 = (1, 0), (0, 1).
    """
    k = np.array([(i, j) for i in range(-8, 9) for j in range(-8, 9) if 0 < abs(i) + abs(j) <= 8])
    orbits = []
    for _ in range(ORBITS):
        nu = np.array([random.uniform(0.050, 0.059), random.uniform(0.030, 0.040)])
        turns = np.exp(2j * np.pi * np.mod(np.outer(k @ nu, np.arange(COUNTS[-1])), 1.0))
        loops = []
        for leading in np.eye(2, dtype=int):
            away = np.abs(k - leading).sum(axis=1)
            amplitude = np.where(away == 0, 1.0, 0.05 / np.maximum(away, 1) ** 2)
            loops.append((amplitude * np.exp(2j * np.pi * random.uniform(size=len(k)))) @ turns)
        f, g = loops
        orbits.append(Orbit(f, np.array([f.real, g.real, -f.imag, -g.imag]), nu))
    return orbits


def henon_heiles(random: np.random.Generator) -> list[Orbit]:
    """Return regular orbits of Henon and Heiles, E = 0.07, x - i p_x, one sample per unit time; the frequencies are
    those of 25000 units of time, some 4000 periods.
    """
    model = fa.HenonHeiles()
    starts = fa.energy_sample(model, energy=0.07, section="x=0", orbits=2 * ORBITS, seed=int(random.integers(99))).z0
    long = fa.frequency_map(model, starts, time=25000.0, accuracy=1e-13)
    good = np.flatnonzero((long.classification == fa.Classification.REGULAR) & (long.error < 1e-12).all(axis=0))
    good = good[:ORBITS]
    time = float(COUNTS[-1])
    path = fa.integrate(model, starts[:, good], time=time, samples=COUNTS[-1], accuracy=1e-13).samples
    rows = np.ascontiguousarray(path.transpose(2, 1, 0))
    return [Orbit(own[0] - 1j * own[2], own, long.nu[:, i]) for own, i in zip(rows, good, strict=True)]


def standard_map(random: np.random.Generator) -> list[Orbit]:
    """Return rotational circles of Chirikov's standard map, K = 0.6, exp(i x); their rotation numbers are weighted
    averages of 20000 iterates in extended precision.
    """
    K, iterates = 0.6, 20000
    x, p = np.full(ORBITS, np.pi), random.uniform(2.2, 2.7, ORBITS)
    starts = np.array([x, p])
    t = np.arange(1, iterates, dtype=np.longdouble) / iterates
    weight = np.exp(-1 / (t * (1 - t)))
    mean, angles = np.zeros(ORBITS, np.longdouble), np.empty((iterates, ORBITS), np.longdouble)
    angles[0], p = x, p.astype(np.longdouble)
    for i in range(1, iterates):
        p = p + K * np.sin(angles[i - 1])
        angles[i] = angles[i - 1] + p
        mean += weight[i - 1] * p
    nu = (mean / weight.sum() / (2 * np.arccos(np.longdouble(-1)))).astype(float)
    f = np.exp(1j * angles[: COUNTS[-1]].astype(complex)).T
    return [Orbit(f[i], np.empty(0), nu[i : i + 1], starts[:, i]) for i in range(ORBITS)]


SIGNALS: dict[str, Callable[[np.random.Generator], list[Orbit]]] = {
    "pendulum": pendulums,
    "144 lines": combinations,
    "Hénon-Heiles": henon_heiles,
    "standard map": standard_map,
}


# Methods: each returns a frequency in cycles per sample.


def leading(f: np.ndarray) -> float:
    """Return the largest line of the windowed transform, by the parabola through the logarithms of its bins."""
    size = np.log(np.abs(np.fft.fft(f * np.hanning(f.size))) + 1e-300)
    top = int(size.argmax())
    below, middle, above = size[top - 1], size[top], size[(top + 1) % f.size]
    place = (top + (below - above) / (2 * (below - 2 * middle + above))) / f.size
    return place - np.round(place)


def package(orbit: Orbit, count: int) -> float:
    """Return the frequency of the first coordinate by `orbit_frequencies`; of a map, by `frequency_map`."""
    if orbit.start is not None:
        return fa.frequency_map(fa.models.StandardMap(0.6), orbit.start, time=count - 1).nu[0, 0]
    return fa.orbit_frequencies(orbit.rows[:, :count], 1.0).nu[0, 0]


def inverted(orbit: Orbit, count: int) -> float:
    """Return the largest line by harmonic inversion of the complex signal alone."""
    return float(lines_of(orbit.f[None, :count], 1, 1).value[0, 0]) / count


def fitted(orbit: Orbit, count: int) -> float:
    """Return the largest of eight lines, fitted together."""
    return float(fa.naff(orbit.f[:count], 1.0, lines=8).nu[0])


def birkhoff(orbit: Orbit, count: int) -> float:
    """Return the weighted Birkhoff average of the angle from sample to sample (Das et al. 2017)."""
    f = orbit.f[:count]
    steps = np.angle(f[1:] / f[:-1])
    t = np.arange(1, count) / count
    weight = np.exp(-1 / (t * (1 - t)))
    return float(weight @ steps / weight.sum() / (2 * np.pi))


def extrapolated(orbit: Orbit, count: int) -> float:
    """Return the line next to the largest one among the roots of the filter of Birkhoff reduced rank extrapolation.

    The filter sum_j c_|j| f_(n + j), of sum 1, takes all lines but the mean from real and imaginary part as well as
    it can (Ruth & Bindel 2024). Its roots exp(+-2 pi i nu) are those of a Chebyshev series in cos(2 pi nu).
    """
    u = np.diff(orbit.f[:count])
    half = min((count - 1) // 4, LONGEST)
    rows = np.lib.stride_tricks.sliding_window_view(u, 2 * half + 1)
    middle = rows[:, half]
    pairs = rows[:, half + 1 :] + rows[:, half - 1 :: -1] - 2 * middle[:, None]
    parts = np.concatenate([pairs.real, pairs.imag]), -np.concatenate([middle.real, middle.imag])
    c = lstsq(*parts, cond=1e-15, lapack_driver="gelsy", check_finite=False)[0]
    roots = chebyshev.chebroots(np.concatenate([[1 - 2 * c.sum()], 2 * c]))
    guess = leading(orbit.f[:count])
    nu = np.arccos(roots.astype(complex)) / (2 * np.pi)
    return float(nu[np.abs(nu - abs(guess)).argmin()].real)


def nafflib_line(orbit: Orbit, count: int) -> list[float]:
    """Return nafflib's leading line by windows of order 1, 2 and 4."""
    nafflib = importlib.import_module("nafflib")
    orders = (1, 2, 4)
    return [float(np.real(nafflib.naff(orbit.f[:count], num_harmonics=1, window_order=p)[1][0])) for p in orders]


METHODS: dict[str, Callable[[Orbit, int], float]] = {
    "fastaff": package,
    "harmonic inversion, one line": inverted,
    "`fastaff.naff`, 8 lines": fitted,
    "weighted Birkhoff average": birkhoff,
    "Birkhoff-RRE": extrapolated,
}


def programs() -> dict[str, Callable[[Orbit, int], float]]:
    """Return the methods of other programs that can be imported."""
    found: dict[str, Callable[[Orbit, int], float]] = {}
    if importlib.util.find_spec("nafflib"):
        for i, order in enumerate((1, 2, 4)):
            found[f"nafflib, window order {order}"] = lambda orbit, count, i=i: nafflib_line(orbit, count)[i]
    return found


def error(nu: float, orbit: Orbit) -> float:
    """Return the relative error of a frequency: its distance from the nearest one of the orbit."""
    nu, known = abs(nu), np.abs(orbit.nu)
    if orbit.start is not None:  # a signal of a map shows frequencies modulo 1, of either sign
        nu, known = abs(nu - round(nu)), np.abs(known - np.round(known))
    return float((np.abs(nu - known) / known).min()) if np.isfinite(nu) else np.inf


def errors() -> dict[str, dict[str, np.ndarray]]:
    """Return the median errors (counts,) by signal and method."""
    result: dict[str, dict[str, np.ndarray]] = {}
    for signal, make in SIGNALS.items():
        orbits = make(np.random.default_rng(2))
        result[signal] = {}
        for method, run in (METHODS | programs()).items():
            found = [[error(run(orbit, count), orbit) for orbit in orbits] for count in COUNTS]
            result[signal][method] = np.median(found, axis=1)
            print(signal, len(orbits), method, *(f"{x:.1e}" for x in result[signal][method]), flush=True)
    return result


def costs() -> str:
    """Return the table of milliseconds of CPU time of one thread for an orbit of Henon and Heiles."""
    orbits = henon_heiles(np.random.default_rng(2))
    counts = (100, 400, 1000)
    lines = [f"| method | {' | '.join(map(str, counts))} |", "|---|" + "---|" * len(counts)]
    together = np.array([orbit.rows for orbit in orbits] * BATCH).transpose(1, 0, 2)
    for method, run in (METHODS | programs()).items():
        cells = []
        for count in counts:
            size = len(orbits)
            if run is package:  # all orbits in one call, as an ensemble is analysed
                samples, size = np.ascontiguousarray(together[:, :, :count]), together.shape[1]
                call = partial(fa.orbit_frequencies, samples, 1.0, threads=1)
            else:
                call = partial(each, run, orbits, count)
            call()
            times = []
            for _ in range(REPEATS):
                begin = process_time()
                call()
                times.append(process_time() - begin)
            cells.append(f"{1e3 * min(times) / size:.2g}")
        lines.append(f"| {method} | {' | '.join(cells)} |")
    return "\n".join(lines)


def each(run: Callable[[Orbit, int], float], orbits: list[Orbit], count: int) -> list[float]:
    """Return the frequencies of orbits, one call for each."""
    return [run(orbit, count) for orbit in orbits]


def printed(value: float, least: float) -> str:
    """Return an error as text, in bold if it is at most 1.5 times the least one."""
    text = "< 1e-15" if value < 1e-15 else f"{value:.0e}".replace("e-0", "e-")
    return f"**{text}**" if value <= 1.5 * least else text


def table(found: dict[str, dict[str, np.ndarray]]) -> str:
    """Return the table, the smallest error of each signal and number of samples in bold."""
    lines = [f"| signal | method | {' | '.join(map(str, COUNTS))} |", "|---|---|" + "---|" * len(COUNTS)]
    for signal, methods in found.items():
        best = np.maximum(np.min(list(methods.values()), axis=0), ROUNDED)
        for i, (method, values) in enumerate(methods.items()):
            cells = [printed(value, least) for value, least in zip(values, best, strict=True)]
            lines.append(f"| {signal if i == 0 else ''} | {method} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, print, and write the table if that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", action="store_true", help="into docs/benchmarks/validation.md")
    parser.add_argument("--turns", action="store_true", help="`tunes` of maps instead")
    given = parser.parse_args()
    if given.turns:
        print(turn_tables())
        return
    made_on, text, cost = stamp(), table(errors()), costs()
    print(text, cost, sep="\n\n")
    if given.write:
        used = tuple(name for name in PROGRAMS if name in ("fastaff", "numpy", "scipy", "nafflib"))
        put("docs/benchmarks/validation.md", "error against samples", text)
        put("docs/benchmarks/validation.md", "cost of a frequency", f"{cost}\n\n{where(made_on, used)}")


if __name__ == "__main__":
    main()
