"""Tori without separability: the Fourier torus that one orbit of any model lies on, its actions, and whether there is
one.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ...base.interruption import keeping
from ...base.numbers import positive
from ...base.recipe import recorded
from ...base.short_forms import takes
from ...base.status import Status
from ...flows.checks import checked_model, energy_drift, phase_points
from ...flows.flow import Flow, Report, mark_drift
from ...flows.motion import motion
from ...flows.options import Options, iterates, plan
from ...models.contracts import Model
from ...models.mechanics import energies, kinetic_energies, slopes
from ...models.traits import traits_of
from ...schemes.catalogue import GAUSS16, SOFRONIOU_SPALETTA10, Scheme, scheme_of
from ..frequencies.integer_lattice import quotient, relations
from .fit_series import STEPS, errors, fit, grow, weights, window
from .fit_signals import signals
from .fit_turns import fit_turns
from .fourier import actions, canonical, evaluate
from .torus import TorusFit, Verdict, basis_name, doubted, flow_residual, nothing, point, resting, unsure
from .turns import turned

GRID = 512
"""Points of the torus where the invariance equation is tried, and of the orbit where the prediction is."""

MOST_SAMPLES = 2**17

END_OF_SPECTRUM = 1e-13
"""Relative height of the spectrum at the sampling limit that is dense enough."""

LARGEST_DRIFT = 1e-6
"""Relative energy error above which an orbit counts as failed."""

LEAST_PERIODS = 8.0
"""Natural periods below which nothing is fitted: the lines could not be told apart."""


@takes(scheme=scheme_of)
@recorded
def fit_torus(
    body: Model,
    z0: Any,
    *,
    time: float,
    tolerance: float = 1e-6,
    step: float | None = None,
    scheme: Scheme | None = None,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    report: Report | None = None,
) -> TorusFit:
    """Find the Fourier torus that the orbit of `body` from `z0` lies on, separable or not.

    Parameters
    ----------
    body : model
        With an energy, a map, or driven.
    z0 : array (2n,)
        Phase point at the start.
    time : float > 0, time
        Length of the fit, best 200 periods or more, of a map and of periods of a drive 1000 or more, many more in four
        dimensions. Half as much again is integrated for the prediction.
    tolerance : float, default 1e-6
        Largest residual and prediction error of a torus.
    step, scheme, rtol, atol : as in `integrate`
        Default scheme: SOFRONIOU_SPALETTA10, GAUSS16 for H(q, p).
    report : callable, optional
        Called with the fraction done, a quarter for each of the orbit, the same by half the steps, the fit and the
        verdict.

    Returns
    -------
    `TorusFit`
        An orbit that escapes is "not a torus", one that fails otherwise "undecided", with its status as evidence.

    Raises
    ------
    ValueError, TypeError, Interrupted
        As in `integrate`.

    Notes
    -----
    The lines of NAFF in the natural signals of the librations (`body.angles`) are identified with integer combinations
    of as few frequencies as they need; a body's planes add eta and gamma, at their mean turning rates. Then all
    frequencies and the coefficients up to an order that grows until they are at rounding are fitted together by
    windowed least squares. Actions: I_i = 1/2 Re sum_k i k_i conj(p_k) . q_k, so I_eta = p_eta and I_gamma = p_gamma of
    a body come out as a check. Basis: for a body the librations and then eta, gamma; of the libration lattice the
    leading lines of the natural signals where they are one, with positive frequencies. Exact relations k . nu = 0,
    ``|k_i| <= 8``, lower the dimension. The origin of the angles is where the largest coefficients that are a basis are
    real and positive.

    Of a map, and of a driven system's map over its period from the phase of z0, the torus has n angles; its lines are
    combinations of its frequencies and of one turn, which is no frequency of it. Where lines are fractions of a turn
    the orbit lies on that many pieces, and one of them is fitted. Rows with a period are fitted beside their winding,
    at their weighted mean rate. J of an angle without winding is positive, the area within the curve of a plane: this
    decides between nu and 1 - nu. J of one that winds is the area under the curve.

    Accuracy: spectral in time and order, while the lines of low order are 1.5 cycles or more apart over `time`; closer
    ones are left out (evidence "terms left out"), which can cost the verdict: then it is "undecided", as below eight
    periods. Against quadrature on separable bodies, time 300: nu to 2e-13, J to 2e-13 relative
    (bench/test_torus_fit.py). nu_error is the change between unequal parts of the window, and with half the step. "Not
    a torus" is an orbit whose prediction fails and that MEGNO and SALI call chaotic (`chaos_map`, over the same time;
    of a body that has `tangent_force`, or a map): weak chaos below `tolerance` passes. Cost: 16 flops per sample, term
    and signal for each of some 20 passes: 0.2 to 10 s an orbit.

    References
    ----------
    Laskar 1999, Introduction to frequency map analysis, NATO ASI C 533, 134 (lines); Percival 1974, J. Phys. A 7, 794
    (Fourier tori, their actions and invariance equation); Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111
    (window).

    Examples
    --------
    >>> fit = fa.fit_torus(fa.models.StandardMap(0.5), [3.0, 0.3], time=1000)
    >>> fit.verdict, fit.dimension
    (<Verdict.TORUS: 'torus'>, 1)
    """
    time, tolerance = positive("time", time), positive("tolerance", tolerance)
    z = phase_points("z0", z0, checked_model(body, needs="regular motion"))
    if z.shape[1] != 1:
        raise ValueError(f"z0 must be one phase point of shape ({len(z)},), got {z.shape[1]} orbits")
    time, done = iterates(body, "time", time), report or (lambda fraction: None)
    options = Options(scheme=scheme, step=step, rtol=rtol, atol=atol, report=report)
    energy = math.nan if turned(body) else float(energies(body, z)[0])
    known = [nothing(body, energy, {"status": float(Status.INTERRUPTED)}, Verdict.UNDECIDED)]
    with keeping("fit_torus", lambda: known[-1]):
        if turned(body):
            found = fit_turns(body, z, time, tolerance, options, known, done)
        else:
            usual = SOFRONIOU_SPALETTA10 if traits_of(body).separable else GAUSS16
            options = replace(options, scheme=usual if scheme is None else scheme)
            flow, z, _ = plan(body, z, options)
            found = _found(flow, body, z, time, tolerance, energy, known, done)
        if report is not None:
            report(1.0)
    return found


def _found(
    flow: Flow,
    body: Any,
    z: np.ndarray,
    time: float,
    tolerance: float,
    energy: float,
    known: list[TorusFit],
    report: Report,
) -> TorusFit:
    """Return the torus of the orbit from z (2n, 1), if there is one; add to `known` what is known on the way."""
    own = motion(body, z)
    least = LEAST_PERIODS * 2 * np.pi / float(own.rate[0])
    short = time < least and own.kinetic[0] > 0
    times, inside, (path, evidence) = np.zeros(0), 0, _path(flow, z, time, 64) if short else (z, {})
    if not short:
        times, path, inside, evidence = _sampled(flow, z, time)
    tiny = not resting(path) and not (kinetic_energies(body, path) > 0).any()  # its energy is below the smallest number
    if short or tiny or evidence["status"] != Status.OK:
        evidence |= {"longer": least} if evidence["status"] == Status.OK else {}
        return nothing(
            body, energy, evidence, Verdict.NOT_A_TORUS if evidence["status"] == Status.ESCAPED else Verdict.UNDECIDED
        )
    if resting(path):
        residual = float(np.abs(slopes(body, path[:, :1])).max())
        return point(body, path, evidence, residual=residual, energy=energy)
    report(0.25)
    taken = flow.fitted(1.5 * time / (len(times) - 1))  # the steps that it took between samples
    finer, state = _path(taken.finer(), z, time, inside)
    finer = finer if state["status"] == Status.OK else path
    report(0.5)
    found = fitted(body, times, path, finer, inside, energy, evidence)
    report(0.75)
    if max(found.residual, found.prediction_error) <= tolerance:
        return found
    known.append(unsure(found, time))
    return doubted(known[-1], z, time)


def _sampled(flow: Flow, z0: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray, int, dict]:
    """Return times, states (2n, samples) over 3/2 of the time, how many of them lie inside it, and what became of the
    orbit.

    They are made so dense that the spectrum falls to rounding before its end, judged from its exponential fall.
    """
    inside = 4096
    while True:
        path, state = _path(flow, z0, time, inside)
        spectrum = np.abs(np.fft.rfft(path[:, :inside] * weights(inside)))
        end = spectrum[:, -inside // 8 :].max() / (spectrum.max() or 1.0)
        if state["status"] != Status.OK or end <= END_OF_SPECTRUM or 2 * inside > MOST_SAMPLES:
            return 1.5 * time / (path.shape[1] - 1) * np.arange(path.shape[1]), path, inside, state
        factor = np.log(END_OF_SPECTRUM) / min(np.log(end), -0.5)
        inside = int(min(MOST_SAMPLES, inside * 2 ** np.ceil(np.log2(max(factor, 2.0)))))


def _path(flow: Flow, z0: np.ndarray, time: float, inside: int) -> tuple[np.ndarray, dict]:
    """Return the states (2n, samples) over 3/2 of the time, `inside` of them in it, and what became of the orbit."""
    ensemble = flow.ensemble(z0.copy())
    states = flow.sampled(ensemble, 3 * inside // 2, time=1.5 * time)
    path = np.column_stack([z0, states[0].T])
    error = 0.0 if resting(path) else energy_drift(flow.model, path, ensemble.energy, ensemble.scale).max()
    mark_drift(ensemble, np.array([error]), LARGEST_DRIFT)
    return path, {"status": float(ensemble.status[0]), "energy error": float(error), "samples": float(inside)}


def fitted(
    body: Any, times: np.ndarray, path: np.ndarray, finer: np.ndarray, inside: int, energy: float, evidence: dict
) -> TorusFit:
    """Fit `inside` samples of path (2n, samples) and compare with the equations of motion, the later samples, and finer
    steps.
    """
    t = times[:inside]
    start = signals(body, t, path[:, :inside])
    samples = window(t, start.values, start.carrier)
    series = grow(samples, start.nu, start.rank)
    parts = np.linalg.lstsq(np.hstack([start.rows.real, -start.rows.imag]), finer[:, :inside], rcond=None)[0]
    same = window(t, parts[: len(start.values)] + 1j * parts[len(start.values) :], start.carrier)
    error, diffusion = errors(samples, series, start.rank, 2 * evidence["energy error"])
    error = error + STEPS * np.abs(fit(same, series.nu, start.rank, series.orders, iterations=3).nu - series.nu)
    relation = relations(
        series.nu, error, _reach(error.max(initial=0.0) / np.abs(series.nu).max(initial=1 / samples.time))
    )
    R, C = quotient(relation, len(series.nu))
    carriers = np.vstack([R[start.rank :], np.zeros((1, R.shape[1]), int)])
    k = np.concatenate([carriers[c] + series.k @ R[: start.rank] for c in start.carrier])
    z = np.concatenate([back[:, None] * c for back, c in zip(start.rows.T, series.c, strict=True)], axis=1)
    k, z, angles = canonical(k, z)
    nu = C @ series.nu
    prediction = _distance(body, times[inside:], path[:, inside:], k, z, angles, nu, (t[0] + t[-1]) / 2)
    residual = flow_residual(body, k, z, nu)
    evidence |= {
        "residual": residual,
        "prediction error": prediction,
        "misfit": series.misfit,
        "diffusion": diffusion,
        "edge of the series": float(series.edge.max(initial=0.0)),
        "terms left out": float(series.left_out),
        "unexplained lines": float(start.unknown),
    }
    verdict = Verdict.TORUS if body.degrees_of_freedom == len(nu) else Verdict.RESONANT
    return TorusFit(
        names=tuple(basis_name(unit, R, start.names) for unit in np.eye(len(nu), dtype=int)),
        nu=nu,
        nu_error=np.abs(C) @ error,
        J=actions(k, z),
        theta0=(angles - nu * (t[0] + t[-1]) / 2) % 1.0,
        k=k,
        coefficients=z,
        residual=residual,
        prediction_error=prediction,
        verdict=verdict,
        dimension=len(nu),
        relations=relation,
        evidence=MappingProxyType(evidence),
        energy=energy,
        body=body,
    )


def _reach(error: float) -> int:
    """Return how large integers a relation may have so that chance ones stay unlikely, for frequencies of that relative
    error.
    """
    return 8 if error < 1e-9 else 4 if error < 1e-7 else 2 if error < 1e-5 else 0


def _distance(
    body: Model,
    times: np.ndarray,
    path: np.ndarray,
    k: np.ndarray,
    z: np.ndarray,
    angles: np.ndarray,
    nu: np.ndarray,
    middle: float,
) -> float:
    """Return the largest distance of the orbit from the torus at the predicted angles, relative to the orbit's size."""
    every = max(1, len(times) // GRID)
    times, path, n = times[::every], path[:, ::every], len(z) // 2
    apart = path - evaluate(k, z, angles[:, None] + nu[:, None] * (times - middle))
    return float(max(np.abs(apart[s]).max() / (np.abs(path[s]).max() or 1.0) for s in (slice(n), slice(n, 2 * n))))
