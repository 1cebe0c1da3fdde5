"""Input of a torus fit from samples of an orbit: signals, the lattice of their lines, first frequencies.

From turn to turn, of a map or over the period of a drive, frequencies are known modulo one turn, and rows with a period
wind on; the signals are then a path without its winding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..frequencies.fundamental import places
from ..frequencies.integer_lattice import box, first_basis, generators, inverse, reduced
from ..frequencies.naff import naff
from ..systems.models.mechanics import System
from .series import EARLY, LATE, weights
from .torus import periods_of, turned

LINES = (16, 48)
"""Lines of each signal from which the lattice of frequencies is found; the second number where the first leave it
incomplete.
"""

FLAT = 1e-11
"""Size of a signal, relative to the orbit, below which it counts as constant."""

STILL = 1e-12
"""Part of its distance from the origin below which a row does not move from turn to turn."""

STEADY = 1e-9
"""Size of a loop in R^2 or z, relative to the orbit, below which the orbit is circular or keeps to its plane."""

SMALL = 1e-3
"""Size of such a loop up to which it is made as large as the orbit: below, rounding would be."""

TRUSTED = 0.03
"""Error bar of a line, in cycles over the window, up to which it can add to the lattice or speak against it."""

PIECES = 64
"""Most pieces of a torus that are sought."""

EXACT = 1e-8
"""Largest error of a line that shows pieces, in cycles per turn."""


class TorusSignals(NamedTuple):
    """Complex signals of unit size (signals, samples), and the way back to phase points: z_k = rows @ c_k, rows (2n,
    signals).

    carrier (signals,): number of each signal's carrier frequency, -1 for none; nu: first values of `rank` libration
    frequencies, then of the carriers; names of both; unknown: lines that are no integer combination of the librations;
    about: the loops of an orbit about an axis of symmetry, where the carrier's relations lower no dimension.

    From turn to turn, signals are a path without its winding: winding (2n, d), the advance of a row in a cycle of an
    angle; steady (2n,), its further advance in a turn; centre (2n,) of the rest, about the middle of the window, and
    its size (2n,); bars (rates, d), errors of winding rates that are frequencies; silent: those that are in no line.
    """

    values: np.ndarray
    rows: np.ndarray
    carrier: np.ndarray
    rank: int
    nu: np.ndarray
    names: tuple[str, ...]
    unknown: int
    winding: np.ndarray
    steady: np.ndarray = np.zeros(0)
    centre: np.ndarray = np.zeros(0)
    size: np.ndarray = np.zeros(0)
    bars: np.ndarray = np.zeros((0, 0))
    silent: tuple[int, ...] = ()
    about: AxisLoops | None = None

    def at(self, nu: np.ndarray, t: np.ndarray, path: np.ndarray) -> TorusSignals:
        """Return the signals of a path (2n, samples) whose angles wind at those frequencies, at times t about the
        middle.
        """
        rest, centre = self._beside_winding(nu, t, path)
        size = np.abs(rest).max(axis=1)
        size = np.where(size > STILL * np.abs(path).max(axis=1), size, 0.0)
        q, p = np.split(size, 2)
        moving = self._replace(
            nu=nu, size=size, centre=centre, rows=np.vstack([np.diag(q), 1j * np.diag(p)])[:, q + p > 0]
        )
        values = moving._loops(rest)
        return moving._replace(values=values, carrier=np.full(len(values), -1))

    def same(self, t: np.ndarray, path: np.ndarray) -> np.ndarray:
        """Return the signals (signals, samples) of a path near this one, in the same units."""
        if self.about is not None:
            return self.about.values(path)
        if not self.size.size:
            parts = np.linalg.lstsq(np.hstack([self.rows.real, -self.rows.imag]), path, rcond=None)[0]
            return parts[: len(self.values)] + 1j * parts[len(self.values) :]
        return self._loops(self._beside_winding(self.nu, t, path)[0])

    def _beside_winding(self, nu: np.ndarray, t: np.ndarray, path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return a path without its winding, about its centre, and the centre."""
        rest = path - (self.winding @ nu + self.steady)[:, None] * t
        centre = rest @ weights(rest.shape[1])
        return rest - centre[:, None], centre

    def _loops(self, rest: np.ndarray) -> np.ndarray:
        """Return q - i p of the coordinates that move, in units of their own sizes."""
        n = len(rest) // 2
        size = self.size
        scaled = rest * (size / np.where(size > 0, size * size, 1.0))[:, None]
        return (scaled[:n] - 1j * scaled[n:])[size[:n] + size[n:] > 0]


class TorusLines(NamedTuple):
    """Lines of loops, those that lead first: frequencies, errors, the loop of each, its strength, and whether it is
    sharp.
    """

    nu: np.ndarray
    error: np.ndarray
    loop: np.ndarray
    strength: np.ndarray
    sharp: np.ndarray


def _lines(loops: np.ndarray, dt: float, time: float, count: int, unit: float | None = None) -> TorusLines:
    """Return the lines of loops (loops, samples), `count` of each, that are strong and sharp, and the dominant ones;
    unit: the frequency that is known to rounding, by default the largest.
    """
    found = naff(loops, dt, lines=count, window_order=4)
    known = np.isfinite(found.error)
    strength = np.abs(found.amplitude) / np.abs(found.amplitude).max(axis=1, keepdims=True)
    strength = np.where(known & (np.abs(found.nu) * time > 3), strength, 0.0)
    error = np.where(known, 3 * found.error, np.inf) + 1e-12 * (unit or np.abs(found.nu).max())
    dominant = np.arange(count) == strength.argmax(axis=1)[:, None]
    sharp = error * time < TRUSTED
    order = np.argsort(-(strength + 2.0 * dominant), axis=None, kind="stable")
    order = order[(((strength > 1e-6) & sharp) | dominant).ravel()[order]]
    return TorusLines(*(rows.ravel()[order] for rows in (found.nu, error, np.indices(error.shape)[0], strength, sharp)))


def signals(system: System, t: np.ndarray, z: np.ndarray) -> TorusSignals:
    """Return the signals of samples z (2n, samples) at equidistant times t, and the first values of their frequencies.

    For a body the planes a and b and their momenta, whose carriers are the mean turning rates of eta and gamma;
    for other systems the loops q - i kappa p of the coordinates, without carriers; systems with winding angles have
    signals from sample to sample, as for a map.
    """
    if turned(system) or not _rates(system, z).whole.all():
        return _turn_signals(system, t, z)
    n = system.n
    size = [np.sqrt((part**2).sum(axis=0).mean()) or 1.0 for part in (z[:n], z[n:])]
    librations, names, unknown = _lattice(t, *_loops(system, z, size[0]), 2 if system.conserves_spins else n)
    if system.conserves_spins:
        found = _plane_signals(t, z, size, librations)
    else:
        loops = z[:n] / size[0] - 1j * z[n:] / size[1]
        found = loops, np.vstack([size[0] * np.eye(n), 1j * size[1] * np.eye(n)]), np.full(n, -1), [], ()
    values, rows, carrier, turning, planes = found
    return TorusSignals(
        values=values,
        rows=rows,
        carrier=carrier,
        rank=len(librations),
        nu=np.append(librations, turning),
        names=(*names, *planes),
        unknown=unknown,
        winding=np.zeros((2 * n, len(librations) + len(turning))),
    )


def _plane_signals(
    t: np.ndarray, z: np.ndarray, size: list[float], librations: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[float], tuple[str, ...]]:
    """Return the signals of the planes that move, the way back, the carriers, and rates and names of these."""
    values: list[np.ndarray] = []
    rows: list[np.ndarray] = []
    carrier: list[int] = []
    turning: list[float] = []
    names: tuple[str, ...] = ()
    for name, q, p in (("eta", 0, 4), ("gamma", 2, 6)):
        planes = [z[q] + 1j * z[q + 1], z[p] + 1j * z[p + 1]]
        if all(np.abs(plane).max() <= FLAT * s for plane, s in zip(planes, size, strict=True)):
            continue
        for plane, s, row in zip(planes, size, (q, p), strict=True):
            back = np.zeros(8, complex)
            back[row : row + 2] = s, -1j * s  # Re of the plane, and Im
            values.append(plane / s)
            rows.append(back)
            carrier.append(len(turning))
        turning.append(_turning(values[-2], values[-1], t[1] - t[0], librations))
        names = (*names, name)
    return np.array(values), np.array(rows).T, np.array(carrier), turning, names


class AxisLoops(NamedTuple):
    """Signals of an orbit about an axis: the planes x + i y and p_x + i p_y in units of the sizes of position and
    momentum, then loops in R^2 and in z; of these the centre of R^2 and factors that make small loops large.
    """

    position: float
    momentum: float
    centre: float
    factors: tuple[float, ...]

    def values(self, z: np.ndarray) -> np.ndarray:
        """Return the signals (signals, samples) of states z (2n, samples)."""
        n = len(z) // 2
        q, p = z[:n] / self.position, z[n:] / self.momentum
        loops = [q[0] ** 2 + q[1] ** 2 - self.centre - 1j * (q[0] * p[0] + q[1] * p[1]), *(q[2:] - 1j * p[2:])]
        return np.array([q[0] + 1j * q[1], p[0] + 1j * p[1], *(f * loop for f, loop in zip(self.factors, loops))])

    def rows(self, n: int) -> np.ndarray:
        """Return the way back (2n, signals) to states: that of the planes and of z, because R is no further row."""
        rows = np.zeros((2 * n, n + 1), complex)
        rows[:2, 0] = self.position, -1j * self.position
        rows[n : n + 2, 1] = self.momentum, -1j * self.momentum
        if n > 2:
            rows[2, 3] = self.position / self.factors[1]
            rows[n + 2, 3] = 1j * self.momentum / self.factors[1]
        return rows


def axis_signals(t: np.ndarray, z: np.ndarray) -> TorusSignals:
    """Return the signals of samples z (2n, samples) of an orbit whose angular momentum about the z axis is conserved;
    its librations are those of R^2 and z, which stay smooth where the orbit comes near the axis.
    """
    n = len(z) // 2
    position, momentum = (float(np.sqrt((part**2).sum(axis=0).mean())) for part in (z[:n], z[n:]))
    q, p = z[:n] / position, z[n:] / momentum
    square = q[0] ** 2 + q[1] ** 2
    pairs = [(square, q[0] * p[0] + q[1] * p[1]), *zip(q[2:], p[2:])]
    loops, moving = _moving_loops(pairs, ["R", "z"][: n - 1], 1.0, z.shape[1], flat=STEADY)
    librations, names, unknown = _lattice(t, loops, moving, len(loops))
    centres = [(a.max() + a.min()) / 2 for a, _ in pairs]
    sizes = [np.hypot(a - c, b).max() for (a, b), c in zip(pairs, centres)]
    about = AxisLoops(position, momentum, float(centres[0]), tuple(1 / max(float(size), SMALL) for size in sizes))
    values = about.values(z)
    return TorusSignals(
        values=values,
        rows=about.rows(n),
        carrier=np.array([0, 0, *[-1] * (n - 1)]),
        rank=len(librations),
        nu=np.append(librations, _turning(values[0], values[1], t[1] - t[0], librations)),
        names=(*names, "phi"),
        unknown=unknown,
        winding=np.zeros((2 * n, len(librations) + 1)),
        about=about,
    )


def _loops(system: System, z: np.ndarray, size: float) -> tuple[np.ndarray, list[str]]:
    """Return the loops Q - c - i kappa P of the librations that move, (loops, samples), and their names."""
    n = system.n
    angles = getattr(system.model, "angles", None)
    if angles is None or (any(angles.planes) and not system.conserves_spins):
        pairs = [(z[i], z[n + i]) for i in range(n)]
        names = list(system.model.coordinates)
    else:
        s = np.array([np.broadcast_to(row, z[0].shape) for row in angles.signals(*z)]).reshape(-1, 4, z.shape[1])
        kept = [i for i, plane in enumerate(angles.planes) if not plane]
        pairs = [(s[i, 0], s[i, 2]) for i in kept]
        names = [angles.names[i] for i in kept]
    return _moving_loops(pairs, names, size, z.shape[1])


def _moving_loops(
    pairs: list[tuple[np.ndarray, np.ndarray]], names: list[str], size: float, count: int, flat: float = FLAT
) -> tuple[np.ndarray, list[str]]:
    """Return the loops Q - c - i kappa P (loops, count) of the pairs Q, P that move, by that part of their size or of
    the size of the orbit, and their names.
    """
    loops = []
    moving = []
    for (q, p), name in zip(pairs, names, strict=True):
        width, height = np.ptp(q), np.ptp(p)
        if width > flat * max(np.abs(q).max(), size) and height > 0:
            loops.append(q - (q.max() + q.min()) / 2 - 1j * width / height * p)
            moving.append(name)
    return np.array(loops).reshape(-1, count), moving


def _lattice(t: np.ndarray, loops: np.ndarray, names: list[str], rank: int) -> tuple[np.ndarray, tuple[str, ...], int]:
    """Return a basis of at most `rank` frequencies of loops with names, and the number of lines it does not explain.

    They are the dominant lines of the natural signals where these can be part of a basis, then the stronger ones; all
    positive, and each has the name of the loop of whose motion it has most.
    """
    if not len(loops):
        return np.zeros(0), (), 0
    for lines in LINES:  # many multiples of one strong frequency can hide the second one
        found = _lines(loops, t[1] - t[0], t[-1], lines)
        lattice = generators(found.nu, found.error, rank)
        if len(lattice.nu) == rank:
            break
    unknown = int((~lattice.known & found.sharp).sum())
    k = lattice.k[lattice.known]
    chosen = first_basis(k)
    if len(chosen) < len(lattice.nu):  # no lines are a basis: take the generators themselves
        return np.abs(lattice.nu), tuple(names[: len(lattice.nu)]), unknown
    basis = np.abs(k[chosen] @ lattice.nu)
    own = np.flatnonzero((place := _place(found, basis, len(names))) < len(basis))
    return basis[place[own]], tuple(names[i] for i in own), unknown


def _place(found: TorusLines, basis: np.ndarray, loops: int) -> np.ndarray:
    """Return the number of the frequency (loops,) that each loop gives its name to, as in a frequency map."""
    share = np.zeros((1, loops, loops))
    for nu, error, loop, strength in zip(*found[:4], strict=True):
        here = np.abs(np.abs(nu) - basis) <= error + 1e-9 * basis
        share[0, : len(basis), loop] += here * math.copysign(strength**2, nu)  # q and p of amplitudes a, b have a b
    rates = np.zeros((1, loops))
    rates[0, : len(basis)] = basis
    return places(np.abs(share), rates, np.array([len(basis)]), np.ones((1, loops), bool))[0]


def _turning(a: np.ndarray, p: np.ndarray, dt: float, librations: np.ndarray) -> float:
    """Return the mean turning rate of a plane: a line of its loop a - i kappa p, less the librations' combination that
    brings it to the mean rate.

    The loop never vanishes where kappa has the sign of Im(conj(a) p), so the mean rate of its argument is that of arg
    a; its weighted average chooses among the lines' classes, the line itself is sharper.
    """
    sense = -1.0 if np.mean(np.imag(a.conj() * p)) < -1e-13 else 1.0
    loop = a - 1j * sense * np.sqrt(np.mean(np.abs(a) ** 2) / (np.mean(np.abs(p) ** 2) or np.inf)) * p
    steps = np.angle(loop[1:] * loop[:-1].conj()) / (2 * np.pi * dt)
    half = len(steps) // 2
    rate, first, second = (float(weights(len(s)) @ s) for s in (steps, steps[:half], steps[half:]))
    line = naff(loop, dt, lines=LINES[0], window_order=4).nu[0]
    k = box([12] * len(librations))
    candidates = line - k @ librations
    miss = np.abs(candidates - rate)
    near = np.flatnonzero(miss <= max(3 * abs(first - second) + 1e-9 * abs(rate), miss.min()))
    return float(candidates[near[np.argmin(np.abs(k[near]).sum(axis=1))]])


class WindingRates(NamedTuple):
    """The winding of rows with a period in a turn, in periods: rows, rate, error, and whether it is a whole number."""

    rows: np.ndarray
    rate: np.ndarray
    error: np.ndarray
    whole: np.ndarray


def _rates(system: System, path: np.ndarray) -> WindingRates:
    """Return the mean rates of winding rows: weighted averages, with the difference of two parts of the window."""
    periods = periods_of(system)
    rows = np.flatnonzero(periods > 0)
    steps = np.diff(path[rows], axis=1) / periods[rows, None]
    size = steps.shape[1]
    parts = [steps[:, : int(EARLY * size)], steps[:, int(LATE * size) :]]
    rate = steps @ weights(size)
    error = 3 * np.abs(parts[0] @ weights(parts[0].shape[1]) - parts[1] @ weights(parts[1].shape[1]))
    error = error + 1e-15 * np.maximum(np.abs(rate), 1.0) + 1e-16 * np.abs(path[rows]).max(axis=1) / periods[rows]
    off = path[rows] - periods[rows, None] * np.rint(rate)[:, None] * np.arange(path.shape[1])
    bounded = np.ptp(off, axis=1) < periods[rows]
    return WindingRates(rows, rate, error, bounded | (np.abs(rate - np.rint(rate)) <= error))


def _turn_lines(system: System, path: np.ndarray, rates: WindingRates) -> tuple[TorusLines, list[str]]:
    """Return the lines of the loops of a path, in cycles per sample, and the coordinate of each."""
    n = system.n
    flat = path.copy()
    periods = periods_of(system)
    length = path.shape[1]
    flat[rates.rows] -= (periods[rates.rows] * rates.rate)[:, None] * np.arange(length)
    flat -= flat.mean(axis=1, keepdims=True)
    size = np.abs(flat).max(axis=1)
    moves = size > STILL * np.maximum(np.abs(path).max(axis=1), periods)
    kept = np.flatnonzero((moves[:n] | moves[n:])[: system.moving])
    if not kept.size:
        return TorusLines(*(np.zeros(0, kind) for kind in (float, float, int, float, bool))), []
    q, p = (flat[r] / np.where(size[r] > 0, size[r], 1.0)[:, None] * moves[r, None] for r in (kept, n + kept))
    unit = 1.0 if turned(system) else None
    found = _lines(q - 1j * p, 1.0, length, LINES[1] if n > 1 else LINES[0], unit=unit)
    found = TorusLines(*(rows[found.strength > 0] for rows in found))
    return found, [system.names[kept[j]] for j in found.loop]


def pieces_of(system: System, path: np.ndarray) -> int:
    """Return the number of pieces of an orbit that are images of each other: the least common denominator of its lines
    that are fractions of a turn.
    """
    rates = _rates(system, path)
    lines, _ = _turn_lines(system, path, rates)
    rate = np.concatenate([rates.rate, lines.nu])
    bars = np.concatenate([rates.error, lines.error])
    pieces = 1
    q = np.arange(1, PIECES + 1)
    for value, bar in zip(rate[bars < EXACT], bars[bars < EXACT], strict=True):
        near = np.flatnonzero(np.abs(q * value - np.rint(q * value)) <= q * bar)
        if near.size and math.lcm(pieces, int(q[near[0]])) <= PIECES:
            pieces = math.lcm(pieces, int(q[near[0]]))
    return pieces


def _turn_signals(system: System, t: np.ndarray, path: np.ndarray) -> TorusSignals:
    """Return the signals of a path from turn to turn, or sample to sample of a flow: those of the coordinates that
    move, beside their winding.
    """
    periods = periods_of(system)
    rates = _rates(system, path)
    unit = 1.0 if turned(system) else t[1] - t[0]
    nu, names, w, unknown, silent = _turn_lattice(system, path, rates)
    nu = nu / unit
    winding = np.zeros((len(path), len(nu)))
    steady = np.zeros(len(path))
    winding[rates.rows] = periods[rates.rows, None] * w
    steady[rates.rows] = np.where(rates.whole, np.rint(rates.rate), 0.0) * periods[rates.rows]
    alone = ~rates.whole & (np.abs(w).sum(axis=1) == 1)
    none = np.zeros((0, 0))
    found = TorusSignals(
        values=none,
        rows=none,
        carrier=none,
        rank=len(nu),
        nu=nu,
        names=names,
        unknown=unknown,
        winding=winding,
        steady=steady,
        bars=rates.error[alone, None] / unit * np.abs(w[alone]),
        silent=silent,
    )
    return found.at(nu, t - (t[0] + t[-1]) / 2, path)


def _turn_lattice(
    system: System, path: np.ndarray, rates: WindingRates
) -> tuple[np.ndarray, tuple[str, ...], np.ndarray, int, tuple[int, ...]]:
    """Return a basis of the frequencies beside the turn, with names: rates of angles that wind and dominant lines
    first; the windings of rows in a cycle of each, the number of lines that the basis does not explain, and its
    frequencies that are in no line of a flow. Those of a flow are not modulo a turn; they are positive where no angle
    winds in them.
    """
    n = system.n
    names = system.names
    winds = ~rates.whole
    turn = int(turned(system))
    lines, owners = _turn_lines(system, path, rates)
    values = np.concatenate([[1.0] * turn, rates.rate[winds], lines.nu])
    bars = np.concatenate([[0.0] * turn, rates.error[winds], lines.error])
    own = [*[""] * turn, *(names[r % n] for r in rates.rows[winds]), *owners]
    found = generators(values, bars, system.moving + turn)
    unknown = int((~found.known[turn + winds.sum() :] & lines.sharp).sum())
    k = found.k[found.known]
    chosen = first_basis(k)
    if len(chosen) == len(found.nu) and (not turn or (found.known[0] and chosen[0] == 0)):
        basis = k[chosen]
        nu = values[found.known][chosen][turn:]
        called = [own[c] for c in np.flatnonzero(found.known)[chosen[turn:]]]
    else:  # no lines are a basis: complete the turn to one
        basis = inverse(reduced(k[:1])[1]) if turn else np.eye(len(found.nu), dtype=int)
        nu = (basis @ found.nu)[turn:]
        called = [""] * len(nu)
    spare = [name for name in names if name not in called]
    for j, name in enumerate(called):
        if name == "" or name in called[:j]:
            called[j] = spare.pop(0) if spare else f"theta {j + 1}"
    w = np.zeros((len(rates.rows), len(nu)), int)
    for at, j in enumerate(map(int, np.flatnonzero(winds)), turn):
        if found.known[at]:
            w[j] = np.rint(found.k[at] @ np.linalg.inv(basis))[turn:]
    heard = np.ones(len(nu), bool)
    if not turn:
        nu = np.where(w.any(axis=0), nu, np.abs(nu))
        heard = (np.rint(found.k[winds.sum() :] @ np.linalg.inv(basis)) != 0).any(axis=0)
    order = sorted(range(len(nu)), key=lambda i: (*names, *called).index(called[i]))
    silent = tuple(int(j) for j in np.flatnonzero(~heard[order]))
    return nu[order], tuple(called[i] for i in order), w[:, order], unknown, silent
