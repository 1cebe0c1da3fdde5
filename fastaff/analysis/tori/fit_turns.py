"""Tori of maps, and of driven systems over their period: frequencies that are known modulo one turn."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ...base.numbers import fits
from ...base.status import Status
from ...flows.flow import Report
from ...flows.options import Options
from ...models.traits import traits_of
from ...schemes.catalogue import GAUSS16, SOFRONIOU_SPALETTA10
from ..frequencies.integer_lattice import first_basis, generators, inverse, reduced
from ..frequencies.naff import naff
from .fit_series import LARGEST_ORDER, STEPS, Samples, Series, errors, fit, grow, weights, window
from .fit_signals import LINES, TRUSTED
from .fourier import actions, canonical, evaluate
from .torus import TorusFit, Verdict, doubted, nothing, point, resting, unsure
from .turns import Turns, apart, area, image, periods_of, rows_of, turn_residual, turns_of, without_periods

LEAST = 256
"""Turns that a fit needs, of each of the pieces that an orbit lies on."""

PIECES, EXACT = 64, 1e-8
"""Most pieces that a torus is looked for on; error of a line that may tell them, in cycles per turn."""

FLAT = 1e-12
"""Part of its distance from the origin below which a row does not move."""

LONGEST = 512
"""Largest order of the series of a curve."""

ROUNDS = 4
"""How often angles that wind are freed of a better value of their rate."""


class Lattice(NamedTuple):
    """The frequencies of a torus modulo one turn: nu (d,) with names, w (winding rows, d), and how many lines they do
    not explain.
    """

    nu: np.ndarray
    names: tuple[str, ...]
    w: np.ndarray
    unknown: int


class Rates(NamedTuple):
    """How far rows with a period wind on in a turn, in periods: rows, rate, error, and whether it is a whole number."""

    rows: np.ndarray
    rate: np.ndarray
    error: np.ndarray
    whole: np.ndarray


def fit_turns(
    body: Any, z: np.ndarray, time: float, tolerance: float, options: Options, known: list[TorusFit], report: Report
) -> TorusFit:
    """Find the torus of the orbit of a map, or of a driven system's map over its period, from z (2n, 1); see
    `fit_torus`. Adds to `known` what is known on the way.
    """
    mapping, separable = traits_of(body).iterated, traits_of(body).separable
    if not mapping and options.scheme is None:
        options = replace(options, scheme=SOFRONIOU_SPALETTA10 if separable else GAUSS16)
    turns = turns_of(body, z, options)
    count = int(time / turns.interval + 1e-9)
    if count < LEAST:
        return nothing(
            body, math.nan, {"status": float(Status.OK), "longer": LEAST * turns.interval}, Verdict.UNDECIDED
        )
    fits("time", 3 * count, len(z))
    path, evidence = turns.path(z, 3 * count // 2)
    if evidence["status"] != Status.OK or not np.isfinite(path).all():
        gone = evidence["status"] in ((Status.LOST, Status.NONFINITE) if mapping else (Status.ESCAPED,))
        return nothing(body, math.nan, evidence, Verdict.NOT_A_TORUS if gone else Verdict.UNDECIDED)
    report(0.25)
    pieces = _pieces(body, path[:, :count])
    evidence |= {"islands": float(pieces)}
    if pieces > 1:
        path = _apart(path[:, ::pieces], periods_of(body))
    every = path[rows_of(body)]
    if resting(every - every.mean(axis=1, keepdims=True) + every[:, :1]) or (np.ptp(every, axis=1) == 0).all():
        away = without_periods(image(body, path[:, :1], pieces) - path[:, :1], periods_of(body))
        residual = float(np.abs(away[rows_of(body)]).max())
        return replace(point(body, path, evidence, residual=residual, rows=rows_of(body)), islands=pieces)
    inside = 2 * path.shape[1] // 3
    if inside < LEAST:
        longer = {"longer": pieces * LEAST * turns.interval}
        return nothing(body, math.nan, evidence | longer, Verdict.UNDECIDED)
    finer = None
    if not mapping:
        finer, state = Turns(turns.flow.finer(), turns.interval).path(z, pieces * inside)
        finer = finer[:, ::pieces] if state["status"] == Status.OK else None
    report(0.5)
    found = _fitted(body, path, finer, inside, pieces, evidence)
    report(0.75)
    if max(found.residual, found.prediction_error) <= tolerance:
        return found
    known.append(unsure(found, time))
    return doubted(known[-1], z, time)


def _apart(path: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Return rows without the whole periods that they wind on from one sample to the next, where these are the same."""
    path = path.copy()
    for row in np.flatnonzero(periods > 0):
        steps = (path[row, -1] - path[row, 0]) / periods[row] / (path.shape[1] - 1)
        if abs(steps - np.rint(steps)) * path.shape[1] < 1:
            path[row] -= np.rint(steps) * periods[row] * np.arange(path.shape[1])
    return path


def _rates(body: Any, path: np.ndarray) -> Rates:
    """Return the mean rates at which rows wind: weighted averages, with what two parts of the window differ by."""
    periods = periods_of(body)
    rows = np.flatnonzero(periods > 0)
    steps = np.diff(path[rows], axis=1) / periods[rows, None]
    size = steps.shape[1]
    parts = [steps[:, : int(0.47 * size)], steps[:, int(0.41 * size) :]]
    rate = steps @ weights(size)
    error = 3 * np.abs(parts[0] @ weights(parts[0].shape[1]) - parts[1] @ weights(parts[1].shape[1]))
    error = error + 1e-15 * np.maximum(np.abs(rate), 1.0) + 1e-16 * np.abs(path[rows]).max(axis=1) / periods[rows]
    off = path[rows] - periods[rows, None] * np.rint(rate)[:, None] * np.arange(path.shape[1])
    bounded = np.ptp(off, axis=1) < periods[rows]
    return Rates(rows, rate, error, bounded | (np.abs(rate - np.rint(rate)) <= error))


def _lines(body: Any, path: np.ndarray, rates: Rates) -> tuple[np.ndarray, np.ndarray, list[str], np.ndarray]:
    """Return the lines of the loops of a path, in cycles per sample, with errors, the coordinate of each, and which of
    them are strong and sharp; those that lead come first.
    """
    n, flat = body.degrees_of_freedom, path.copy()
    periods = periods_of(body)
    for row, rate in zip(rates.rows, rates.rate, strict=True):
        flat[row] -= periods[row] * rate * np.arange(path.shape[1])
    flat -= flat.mean(axis=1, keepdims=True)
    size = np.abs(flat).max(axis=1)
    moves = size > FLAT * np.maximum(np.abs(path).max(axis=1), periods)
    loops, owners = [], []
    traits = traits_of(body)
    for i, name in enumerate(traits.names[: traits.moving]):
        if moves[i] or moves[n + i]:
            q, p = (flat[r] / (size[r] or 1.0) * moves[r] for r in (i, n + i))
            loops.append(q - 1j * p)
            owners.append(name)
    if not loops:
        return np.zeros(0), np.zeros(0), [], np.zeros(0, bool)
    lines, length = LINES[1] if n > 1 else LINES[0], path.shape[1]
    found = naff(np.array(loops), 1.0, lines=lines, window_order=4)
    fine = np.isfinite(found.error)
    strength = np.abs(found.amplitude) / np.abs(found.amplitude).max(axis=1, keepdims=True)
    strength = np.where(fine & (np.abs(found.nu) * length > 3), strength, 0.0)
    error = np.where(fine, 3 * found.error, np.inf) + 1e-12
    leading = np.arange(lines) == strength.argmax(axis=1)[:, None]
    order = np.argsort(-(strength + 2.0 * leading), axis=None, kind="stable")
    order = order[(((strength > 1e-6) & (error * length < TRUSTED)) | (leading & (strength > 0))).ravel()[order]]
    sharp = (error * length < TRUSTED).ravel()[order]
    return found.nu.ravel()[order], error.ravel()[order], [owners[j // lines] for j in order], sharp


def _pieces(body: Any, path: np.ndarray) -> int:
    """Return on how many pieces an orbit lies that are images of each other: the least common denominator of its lines
    that are fractions of a turn.
    """
    rates = _rates(body, path)
    lines, error, _, _ = _lines(body, path, rates)
    rate, bars = np.concatenate([rates.rate, lines]), np.concatenate([rates.error, error])
    pieces, q = 1, np.arange(1, PIECES + 1)
    for value, bar in zip(rate[bars < EXACT], bars[bars < EXACT], strict=True):
        near = np.flatnonzero(np.abs(q * value - np.rint(q * value)) <= q * bar)
        if near.size and math.lcm(pieces, int(q[near[0]])) <= PIECES:
            pieces = math.lcm(pieces, int(q[near[0]]))
    return pieces


def _lattice(body: Any, path: np.ndarray) -> tuple[Lattice, Rates]:
    """Return a basis of the frequencies beside the turn: rates of angles that wind and leading lines first."""
    n, names = body.degrees_of_freedom, traits_of(body).names
    rates = _rates(body, path)
    winds = ~rates.whole
    lines, error, owners, sharp = _lines(body, path, rates)
    values = np.concatenate([[1.0], rates.rate[winds], lines])
    bars = np.concatenate([[0.0], rates.error[winds], error])
    own = ["", *(names[r % n] for r in rates.rows[winds]), *owners]
    found = generators(values, bars, traits_of(body).moving + 1)
    ranks = len(found.nu)
    unknown = int((~found.known[1 + winds.sum() :] & sharp).sum())
    k = found.k[found.known]
    chosen = first_basis(k)
    if len(chosen) == ranks and found.known[0] and chosen[0] == 0:
        basis = k[chosen]
        nu = values[found.known][chosen][1:]
        called = [own[c] for c in np.flatnonzero(found.known)[chosen[1:]]]
    else:  # no lines are a basis: complete the turn to one
        _, V = reduced(k[:1])
        basis = inverse(V)
        nu, called = (basis @ found.nu)[1:], [""] * (ranks - 1)
    spare = [name for name in names if name not in called]
    for j, name in enumerate(called):
        if name == "" or name in called[:j]:
            called[j] = spare.pop(0) if spare else f"theta {j + 1}"
    w = np.zeros((len(rates.rows), len(nu)), int)
    for j in map(int, np.flatnonzero(winds)):
        at = 1 + int(winds[:j].sum())
        if found.known[at]:
            w[j] = np.rint(found.k[at] @ np.linalg.inv(basis))[1:]
    order = sorted(range(len(nu)), key=lambda i: (*names, *called).index(called[i]))
    return Lattice(nu[order], tuple(called[i] for i in order), w[:, order], unknown), rates


def _fitted(
    body: Any, path: np.ndarray, finer: np.ndarray | None, inside: int, pieces: int, evidence: dict
) -> TorusFit:
    """Fit `inside` samples of a path, one in so many turns as there are pieces, and try what follows from it."""
    n, periods, t = body.degrees_of_freedom, periods_of(body), np.arange(float(inside))
    lattice, rates = _lattice(body, path[:, :inside])
    wound = np.zeros((2 * n, len(lattice.nu)))
    wound[rates.rows] = periods[rates.rows, None] * lattice.w
    steady = np.zeros(2 * n)
    steady[rates.rows] = np.where(rates.whole, np.rint(rates.rate), 0.0) * periods[rates.rows]
    middle, nu = (inside - 1) / 2, lattice.nu
    series, way_back, samples, centre = _series(path[:, :inside], t - middle, wound, steady, nu, None)
    for _ in range(ROUNDS if wound.any() else 0):
        moved, nu = np.abs(series.nu - nu).max() * inside, series.nu
        series, way_back, samples, centre = _series(path[:, :inside], t - middle, wound, steady, nu, series)
        if moved < 1e-12:
            break
    nu = series.nu
    centre = centre - steady * middle
    error, diffusion = np.zeros(len(nu)), 0.0
    if len(series.c):
        error, diffusion = errors(samples, series, len(nu), 2 * evidence["energy error"])
    for row, bar, whole in zip(lattice.w, rates.error, rates.whole, strict=True):
        if not whole and np.abs(row).sum() == 1:
            error = error + bar * np.abs(row)
    if finer is not None and len(series.c):
        other = _signals(finer[:, :inside], t - middle, wound, steady, nu, way_back)[0]
        same = window(t, other, samples.carrier)
        error = error + STEPS * np.abs(fit(same, nu, len(nu), series.orders, iterations=3).nu - nu)
    k = np.concatenate([np.zeros((1, len(nu)), int), *[series.k for _ in series.c]])
    parts = [back[:, None] * c for back, c in zip(way_back.T, series.c, strict=True)]
    z = np.concatenate([np.zeros((2 * n, 1), complex), *parts], axis=1)
    J = actions(*canonical(k, z)[:2])
    free = ~wound.any(axis=0)
    sign = np.where(free & (J < 0), -1, 1)
    nu, wound = sign * nu, wound * sign
    k, z, angles = canonical(k * sign, z)
    zero = ~k.any(axis=1)
    if not zero.any():
        k, z = np.vstack([k, np.zeros((1, len(nu)), int)]), np.column_stack([z, np.zeros(2 * n, complex)])
        zero = ~k.any(axis=1)
    z[:, zero] += (centre - wound @ angles)[:, None]
    winding = wound if wound.any() else None
    theta0 = (angles - nu * middle) % 1.0  # before a whole turn is taken off: the middle is half a sample
    nu = np.where(free, nu % 1.0, nu)
    later = np.arange(inside, path.shape[1], max(1, path.shape[1] // 1536))
    theta = theta0[:, None] + nu[:, None] * later
    ahead = evaluate(k, z, theta) + wound @ theta
    evidence = evidence | {
        "misfit": series.misfit,
        "diffusion": diffusion,
        "edge of the series": float(series.edge.max(initial=0.0)),
        "terms left out": float(series.left_out),
        "unexplained lines": float(lattice.unknown),
    }
    residual = turn_residual(body, k, z, nu, winding, pieces)
    prediction = apart(body, ahead, path[:, later])
    evidence |= {"residual": residual, "prediction error": prediction}
    return TorusFit(
        names=lattice.names,
        nu=nu / pieces,
        nu_error=error / pieces,
        J=area(body, k, z, winding),
        theta0=theta0,
        k=k,
        coefficients=z,
        residual=residual,
        prediction_error=prediction,
        verdict=Verdict.TORUS if len(rows_of(body)) == 2 * len(nu) else Verdict.RESONANT,
        dimension=len(nu),
        relations=np.zeros((0, len(nu)), int),
        evidence=MappingProxyType(evidence),
        energy=math.nan,
        body=body,
        winding=winding,
        islands=pieces,
    )


def _signals(
    path: np.ndarray, t: np.ndarray, wound: np.ndarray, steady: np.ndarray, nu: np.ndarray, way_back: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the complex signals (signals, samples) of what a path does beside winding, the way back to its rows (2n,
    signals) and its centre (2n,).
    """
    n = len(path) // 2
    u = path - (wound @ nu + steady)[:, None] * t
    centre = u @ weights(u.shape[1])
    u = u - centre[:, None]
    if way_back is None:
        size = np.abs(u).max(axis=1)
        size = np.where(size > FLAT * np.abs(path).max(axis=1), size, 0.0)
        kept = (size[:n] > 0) | (size[n:] > 0)
        way_back = np.vstack([np.diag(size[:n]), 1j * np.diag(size[n:])])[:, kept]
    loops = np.array([_loop(u, back) for back in way_back.T]).reshape(-1, u.shape[1])
    return loops, way_back, centre


def _loop(u: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Return q - i p in units of their own, of the row of q and that of p that a way back leads to."""
    q, p = (np.einsum("i,ij->j", part / (part.sum() ** 2 or 1.0), u) for part in (back.real, back.imag))
    return q - 1j * p


def _series(
    path: np.ndarray, t: np.ndarray, wound: np.ndarray, steady: np.ndarray, nu: np.ndarray, known: Series | None
) -> tuple[Series, np.ndarray, Samples, np.ndarray]:
    """Return the series that fits a path whose angles wind at the rates wound @ nu, the way back, samples, centre."""
    loops, way_back, centre = _signals(path, t, wound, steady, nu, None)
    samples = window(t, loops, np.full(len(loops), -1))
    if not len(loops):
        d = len(nu)
        none = np.zeros((0, 1), complex), np.zeros((1, d), int), (0,) * d, np.zeros(d)
        return Series(nu, *none, 0.0, 0, 0.0), way_back, samples, centre
    if known is None:
        largest = min(LONGEST, len(t) // 4) if len(nu) == 1 else LARGEST_ORDER
        return grow(samples, nu, len(nu), largest), way_back, samples, centre
    return fit(samples, nu, len(nu), known.orders), way_back, samples, centre
