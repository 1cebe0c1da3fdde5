"""Fourier series of tori, z(theta) = Re sum_k z_k exp(2 pi i k . theta): their canonical form, values and actions; and
the fit of the series of signals and of their frequencies, to rounding.

Signals are s(t) = e^{2 pi i nu_c t} sum_k c_k e^{2 pi i k . nu t}: a carrier nu_c of their own (or none) times a series
in the librations nu that all share. c and the frequencies are a stationary point of the weighted misfit

    sum_j w_j |s(t_j) - series(t_j)|^2,      w = exp(beta (sqrt(1 - x^2) - 1)),  x in (-1, 1) over the window.

The normal equations have the block-Toeplitz matrix G_{k l} = g((l - k) . nu), g the transform of the window, below
2e-12 for lines more than 9.6 cycles apart: nearly 1, and solved by conjugate gradients with Fourier convolutions. Right
sides, for all k of a box at once, are read off fast Fourier transforms of the signals.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..core.numbers import Callback, Passes, portion
from ..engine.kernels.birkhoff import SHARPNESS
from ..frequencies.integer_lattice import box, first_basis

KERNEL = 16
"""Values of a transform around a frequency of which its value there is a sum."""

BETA = 12 * np.pi
"""Shape of the weights of this sum: for twice as many values as samples BETA = 3/4 pi KERNEL, with which 16 values give
1e-15.
"""

NEAR = 14.0
"""Cycles over the window: lines further apart do not feel each other."""

APART = 1.5
"""Cycles over the window: of two lines that are closer, the one of higher order is left out."""

ROUNDING = 1e-13
"""Relative amplitude at the edge of a box that ends its growth."""

FIRST_ORDER = 6
"""Largest order of each angle in the first box of a Fourier series."""

LARGEST_ORDER = 72
"""Largest order of an angle in any box."""

LARGEST_BOX = 9000
"""Most terms of a box of orders."""

EARLY = 0.47
"""End of the first part of the window that is compared."""

LATE = 0.41
"""Start of the last part of the window that is compared."""

STEPS = 1.5
"""Factor of the change by half the step, which for a scheme of order 2 is 3/4 of the error."""

TERMS = 1e-16
"""Relative size of the coefficients that are kept."""

POINTS = 2**17
"""Numbers of a series' partial sums that are in memory at once."""


class WeightedSignals(NamedTuple):
    """Complex signals (signals, samples) of unit size at times t about the middle of the window, with weights w of sum
    1.

    carrier (signals,): number of each signal's carrier, -1 for none.
    """

    t: np.ndarray
    w: np.ndarray
    signals: np.ndarray
    carrier: np.ndarray

    @property
    def time(self) -> float:
        """Length of the window."""
        return float(self.t[-1] - self.t[0]) * len(self.t) / (len(self.t) - 1)


class Series(NamedTuple):
    """Frequencies nu = (librations, carriers), coefficients c (signals, terms) at the middle of the window on the box k
    (terms, rank).

    edge (rank,): largest coefficient in the outer quarter of the box in each direction; misfit: root of the weighted
    mean square of the rest, relative (resolved to 1e-8); left_out: terms of the box too close to lower ones; unsettled:
    the last change of the frequencies, in cycles over the window.
    """

    nu: np.ndarray
    c: np.ndarray
    k: np.ndarray
    orders: tuple[int, ...]
    edge: np.ndarray
    misfit: float
    left_out: int
    unsettled: float


def weights(count: int) -> np.ndarray:
    """Return the window's weights at `count` equidistant samples, of sum 1."""
    x = (2 * np.arange(count) + 1 - count) / count
    w = np.exp(SHARPNESS * (np.sqrt(1 - x * x) - 1))
    return w / w.sum()


def window(t: np.ndarray, signals: np.ndarray, carrier: np.ndarray) -> WeightedSignals:
    """Return equidistant samples with the weights of the window that spans them."""
    return WeightedSignals(t - (t[0] + t[-1]) / 2, weights(len(t)), signals, carrier)


def transform(t: np.ndarray, signals: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Return sum_j signals_j e^{-2 pi i nu t_j}, (signals, frequencies), at equidistant times t, to rounding.

    Each is a weighted sum of KERNEL values around its frequency of the fast Fourier transform of twice as many samples,
    the signals divided by the transform of these weights, Kaiser's window, and zeros.
    """
    count = len(t)
    size = _smooth(2 * len(t))
    cycles = nu * ((t[-1] - t[0]) / (count - 1))
    m = np.arange(count) - count // 2
    root = np.sqrt(BETA**2 - (np.pi * KERNEL * m / size) ** 2)
    spread = np.zeros((len(signals), size), complex)
    spread[:, m] = signals * (root * np.i0(BETA) / (KERNEL * np.sinh(root)))
    lines = np.fft.fft(spread)
    at = cycles * size
    first = np.ceil(at - KERNEL / 2).astype(np.int64)
    total = np.zeros((len(signals), len(nu)), complex)
    for place in range(KERNEL):
        x = 2 * (at - first - place) / KERNEL
        weight = np.i0(BETA * np.sqrt(np.maximum(1 - x * x, 0.0))) / np.i0(BETA)
        total += weight * lines[:, (first + place) % size]
    return total * np.exp(2j * np.pi * cycles * ((count - 1) / 2 - count // 2))  # t is 0 half a sample from m


class _Gram:
    """The normal equations of lines nu on a box: application by Fourier convolution."""

    def __init__(self, samples: WeightedSignals, nu: np.ndarray, orders: tuple[int, ...]):
        self.orders = orders
        self.shape = tuple(2 * order + 1 for order in orders)
        self.axes = tuple(range(1, 1 + len(orders)))
        differences = box([2 * order for order in orders])
        dt = samples.time / len(samples.t)
        cycles = differences @ nu * dt if len(orders) else np.zeros(1)
        turns = np.rint(cycles)
        cycles -= turns  # lines apart by a multiple of the sampling rate are one, up to a sign
        sign = 1.0 - 2.0 * (turns * (len(samples.t) - 1) % 2)
        near = np.flatnonzero(np.abs(cycles) * len(samples.t) < NEAR)
        self.size = tuple(_smooth(4 * order + 1) for order in orders)
        kernels = np.zeros((2, *self.size))
        if orders:
            even, odd = transform(samples.t, np.array([samples.w, samples.w * samples.t]), cycles[near] / dt)
            place = tuple(differences[near].T)  # negative differences count from the end
            kernels[0][place] = sign[near] * even.real
            kernels[1][place] = sign[near] * odd.imag
        else:
            kernels[0] = 1.0
        self.even, self.odd = [np.fft.fftn(kernel) if orders else kernel for kernel in kernels]
        self.odd = 1j * self.odd
        self.mask = self._mask(differences[near[np.abs(cycles[near]) * len(samples.t) < APART]])

    def _mask(self, close: np.ndarray) -> np.ndarray:
        """Return 0 where a term's line is that of a lower term within the resolution of the window, else 1."""
        k = box(self.orders)
        rank = np.abs(k).sum(axis=1) * float(4 * len(k)) + np.arange(len(k))  # order first, then position
        rank = rank.reshape(self.shape)
        mask = np.ones(self.shape)
        for m in close:
            if not m.any() or (np.abs(m) >= np.array(self.shape)).any():
                continue
            mine = tuple(slice(max(0, j), min(s, s + j)) for j, s in zip(m, self.shape, strict=True))
            other = tuple(slice(max(0, -j), min(s, s - j)) for j, s in zip(m, self.shape, strict=True))
            mask[mine] *= np.where(rank[other] < rank[mine], 0.0, 1.0)
        return mask

    def apply(self, c: np.ndarray, transform: np.ndarray) -> np.ndarray:
        """Return sum over l of kernel(k - l) c_l on the box."""
        if not self.orders:
            return transform * c
        full = np.fft.fftn(c, self.size, self.axes)
        full *= transform
        for axis in self.axes[::-1]:  # the order of ifftn: the same bits, of what is kept alone
            full = np.fft.ifft(full, axis=axis)[(slice(None),) * axis + (slice(0, self.shape[axis - 1]),)]
        return full

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return c with G c = b on the terms that the window resolves, by conjugate gradients, all signals together."""
        b = b * self.mask
        c = b.copy()
        r = b - self.mask * self.apply(c, self.even)
        p = r.copy()
        rho = _norm2(r)
        goal = 1e-31 * _norm2(b)
        for _ in range(300):
            if not (rho > goal):
                break
            q = self.mask * self.apply(p, self.even)
            step = rho / float((p.conj() * q).real.sum())
            c = c + step * p
            r = r - step * q
            before = rho
            rho = _norm2(r)
            p = r + rho / before * p
        return c


def _smooth(least: int) -> int:
    """Return the smallest product of 2, 3 and 5 that is at least `least`: a fast length of Fourier transforms."""
    return min(2**a * 3**b * 5**c for a in range(12) for b in range(8) for c in range(5) if 2**a * 3**b * 5**c >= least)


def _norm2(x: np.ndarray) -> float:
    return float((x.real**2 + x.imag**2).sum())


def fit(
    samples: WeightedSignals,
    nu: np.ndarray,
    rank: int,
    orders: tuple[int, ...],
    *,
    iterations: int = 12,
    callback: Callback | None = None,
) -> Series:
    """Fit the series on a box of `orders` and the frequencies nu (rank librations, then the carriers), starting from
    nu.

    Gauss-Newton on the frequencies: delta nu = H^-1 Re sum_k conj(2 pi i kappa c_k) u_k, where u are the averages of t
    times the residual and H = (2 pi)^2 <t^2> sum kappa kappa^T |c_k|^2, kappa = (k, unit vector of the carrier).
    Converges for starts much closer than 1/time. Cost of an iteration: a fast Fourier transform a signal.
    """
    t = samples.t
    w = samples.w
    nu = np.array(nu, dtype=float)
    if not len(samples.signals):
        none = np.zeros((0, 1), complex), np.zeros((1, rank), int), (0,) * rank, np.zeros(rank)
        return Series(nu, *none, misfit=0.0, left_out=0, unsettled=0.0)
    k = box(orders)
    units = np.vstack([np.eye(len(nu) - rank), np.zeros((1, len(nu) - rank))])[samples.carrier]
    directions = [np.hstack([k, np.broadcast_to(unit, (len(k), len(unit)))]) for unit in units]
    second = float(w @ t**2)
    unsettled = 1.0
    for iteration in range(iterations):
        if callback is not None:
            callback(iteration / iterations)
        gram = _Gram(samples, nu[:rank], orders)
        carriers = np.append(nu[rank:], 0.0)[samples.carrier]
        weighted = w * samples.signals * np.exp(-2j * np.pi * carriers[:, None] * t)
        both = transform(t, np.vstack([weighted, t * weighted]), k @ nu[:rank]).reshape(-1, *gram.shape)
        b = both[: len(weighted)]
        c = gram.solve(b)
        power = float((w * np.abs(samples.signals) ** 2).sum())
        misfit = 1.0 - float((c.conj() * b).real.sum()) / power if power > 0.0 else 0.0
        if iteration + 1 == iterations or unsettled < 1e-13:
            break
        u = gram.mask * (both[len(weighted) :] - gram.apply(c, gram.odd))
        gradient = np.zeros(len(nu))
        hessian = np.zeros((len(nu), len(nu)))
        for kappa, ck, uk in zip(directions, c.reshape(len(c), -1), u.reshape(len(c), -1), strict=True):
            gradient += 2 * np.pi * (kappa.T @ (-1j * ck.conj() * uk).real)
            hessian += (2 * np.pi) ** 2 * second * (kappa.T * np.abs(ck) ** 2) @ kappa
        change = np.linalg.lstsq(hessian, gradient, rcond=1e-13)[0] if len(nu) else gradient
        largest = float(np.abs(change).max(initial=0.0)) * samples.time
        if not largest < 0.5:
            unsettled = 1.0
            break
        if 0.9 * unsettled <= largest < 1e-9:
            break  # rounding
        nu = nu + change
        unsettled = largest
    flat = c.reshape(len(c), -1)
    size = np.abs(flat).max(axis=0)
    edge = np.array([size[4 * np.abs(k[:, i]) > 3 * orders[i]].max(initial=0.0) for i in range(rank)]) / (
        size.max() or 1.0
    )
    left_out = int(gram.mask.size - gram.mask.sum())
    return Series(nu, flat, k, orders, edge, float(np.sqrt(max(misfit, 0.0))), left_out, unsettled)


def grow(
    samples: WeightedSignals, nu: np.ndarray, rank: int, largest: int, silent: Sequence[int], passes: Passes
) -> Series:
    """Fit on boxes that grow until their edge is at rounding, by the decay of coefficients, while that lessens the
    misfit, to the largest order; silent: frequencies that are in no line.
    """
    orders = tuple(0 if i in silent else FIRST_ORDER for i in range(rank))
    before = np.inf
    while True:
        series = fit(samples, nu, rank, orders, iterations=2, callback=passes.take(GROWING, GROWING + REST))
        nu = series.nu
        wanted = tuple(_enough(order, edge, largest) for order, edge in zip(orders, series.edge, strict=True))
        while np.prod([2.0 * order + 1 for order in wanted]) > LARGEST_BOX and wanted != orders:
            wanted = tuple(max(order, larger - 1) for order, larger in zip(orders, wanted, strict=True))
        stalled = series.misfit > 1e-7 and series.misfit > 0.7 * before
        if wanted == orders or stalled:
            return fit(samples, nu, rank, orders, callback=passes.take(GROWING, REST - GROWING))
        orders = wanted
        before = series.misfit


GROWING = 2.0
"""Work of a fit on a growing box, in iterations, as far as it is known: for the reported progress."""

REST = 8.0
"""Work of the later fits, in iterations."""


def _enough(order: int, edge: float, largest: int) -> int:
    """Return the order at which coefficients that fall exponentially to `edge` at `order` are at rounding."""
    if edge <= ROUNDING:
        return order
    wanted = order * np.log(ROUNDING) / np.log(min(edge, 0.9))
    return int(min(largest, np.clip(np.ceil(wanted), order + 2, 2 * order)))


def errors(
    samples: WeightedSignals, series: Series, rank: int, drift: float, callback: Callback | None
) -> tuple[np.ndarray, float, tuple[Series, ...]]:
    """Return the error estimates of the frequencies, the largest relative difference of those of two parts of the
    window, and the series of these parts.

    The parts are unequal: where the motion returns to its phase after half the window, halves would agree on wrong
    frequencies.
    """
    if not len(samples.signals):
        return np.zeros(len(series.nu)), 0.0, ()
    size = len(samples.t)
    orders = tuple(-(-2 * order // 3) for order in series.orders)
    ends = [slice(0, int(EARLY * size)), slice(int(LATE * size), size)]
    windows = [window(samples.t[part], samples.signals[:, part], samples.carrier) for part in ends]
    parts = [
        fit(part, series.nu, rank, orders, iterations=3, callback=portion(callback, k, 2))
        for k, part in enumerate(windows)
    ]
    largest = np.abs(series.nu).max(initial=1 / samples.time)
    unsettled = max(part.unsettled for part in parts) / (samples.time / 2)
    difference = np.maximum(np.abs(parts[0].nu - parts[1].nu), unsettled)
    error = 3 * difference + series.unsettled / samples.time + (1e-13 + drift) * largest
    return error, float(difference.max(initial=0.0) / largest), tuple(parts)


def canonical(k: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return k, z with one of each pair +-k, the largest first, and the angles at the middle, their origin made
    canonical.
    """
    d = k.shape[1]
    for i in range(d):  # the last component that is not 0 is positive
        negative = (k[:, i] < 0) & (k[:, i + 1 :] == 0).all(axis=1)
        k = np.where(negative[:, None], -k, k)
        z = np.where(negative, z.conj(), z)
    k, place = np.unique(k, axis=0, return_inverse=True) if d else (k[:1], np.zeros(len(k), int))
    summed = np.zeros((len(z), len(k)), complex)
    np.add.at(summed.T, place.ravel(), z.T)
    summed[:, ~k.any(axis=1)] = summed[:, ~k.any(axis=1)].real
    n = len(z) // 2
    scale = np.repeat([np.sqrt((np.abs(part) ** 2).sum()) or 1.0 for part in (summed[:n], summed[n:])], n)[:, None]
    size = np.abs(summed / scale).max(axis=0)
    order = np.argsort(-np.round(np.log(np.maximum(size, 1e-300)), 6), kind="stable")  # equal sizes in the order of k
    order = order[size[order] > TERMS * size.max()]
    k = k[order]
    z = summed[:, order]
    leading = np.flatnonzero(k.any(axis=1))[:60]
    chosen = leading[first_basis(k[leading])]
    large = np.abs(z[:n, chosen])
    coordinate = (large > (1 - 1e-6) * large.max(axis=0)).argmax(axis=0)  # the first of equals
    phases = np.angle(z[coordinate, chosen]) / (2 * np.pi)
    angles = np.linalg.lstsq(k[chosen].astype(float), phases, rcond=None)[0] if len(chosen) else np.zeros(d)
    return k, z * np.exp(-2j * np.pi * (k @ angles)), angles


def actions(k: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return J = 2 pi I, I_i = 1/2 Re sum_k i k_i conj(p_k) . q_k."""
    n = len(z) // 2
    return np.pi * k.T @ (1j * (z[n:].conj() * z[:n]).sum(axis=0)).real


def evaluate(k: np.ndarray, z: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Return Re sum_k z_k exp(2 pi i k . theta) at theta (d, points): the sum over one component of k for all values of
    the others is a matrix product.
    """
    if not k.shape[1]:
        return np.repeat(z.sum(axis=1).real[:, None], theta.shape[1], axis=1)
    reach = np.abs(k).max(axis=0)
    inner = int(np.argmax(reach))
    others, place = np.unique(np.delete(k, inner, axis=1), axis=0, return_inverse=True)
    dense = np.zeros((len(others), 2 * reach[inner] + 1, len(z)), complex)
    np.add.at(dense, (place.ravel(), k[:, inner] + reach[inner]), z.T)
    matrix = np.ascontiguousarray(dense.transpose(2, 0, 1)).reshape(-1, dense.shape[1])
    out = np.empty((len(z), theta.shape[1]))
    size = max(1, POINTS // len(matrix))
    for start in range(0, theta.shape[1], size):
        angles = theta[:, start : start + size] % 1.0
        tables = [np.exp(2j * np.pi * np.arange(-n, n + 1)[:, None] * angle) for n, angle in zip(reach, angles)]
        waves = np.ones((len(others), angles.shape[1]), complex)
        outer = (table for i, table in enumerate(tables) if i != inner)
        for component, largest, table in zip(others.T, np.delete(reach, inner), outer, strict=True):
            waves *= table[component + largest]
        sums = (matrix @ tables[inner]).reshape(len(z), *waves.shape)
        out[:, start : start + size] = (sums * waves).sum(axis=1).real
    return out
