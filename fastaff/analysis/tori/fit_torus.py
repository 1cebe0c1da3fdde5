"""Tori without separability: the Fourier torus that one orbit of any model lies on, its actions, and whether there is
one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np

from ...base.axes import along
from ...base.interruption import keeping
from ...base.numbers import numbers, positive, shown, whole
from ...base.recipe import recorded
from ...base.results import Result
from ...base.short_forms import takes
from ...base.status import Status
from ...flows.checks import CONSERVATIVE, checked_model, energy_drift, phase_points
from ...flows.flow import Flow, Report, mark_drift
from ...flows.motion import motion
from ...flows.options import Options, plan
from ...models.contracts import Kind, Model, coordinate_names, kind_of
from ...models.mechanics import energies, kinetic_energies, slopes
from ...schemes.catalogue import SOFRONIOU_SPALETTA10, RungeKutta, Splitting, scheme_of
from ..chaos.chaos_map import chaos_map
from ..frequencies.integer_lattice import determinant, inverse, quotient, relations
from .fit_series import Samples, Series, fit, grow, weights, window
from .fit_signals import Unknown, signals
from .fourier import actions, canonical, evaluate

GRID = 512
"""Points of the torus where the invariance equation is tried, and of the orbit where the prediction is."""

MOST_SAMPLES = 2**17

END_OF_SPECTRUM = 1e-13
"""Relative height of the spectrum at the sampling limit that is dense enough."""

LARGEST_DRIFT = 1e-6
"""Relative energy error above which an orbit counts as failed."""

LEAST_PERIODS = 8.0
"""Natural periods below which nothing is fitted: the lines could not be told apart."""

EARLY, LATE, STEPS = 0.47, 0.41, 1.5
"""End of the first and start of the last part of the window that are compared; factor of the change that half the step
makes, of which a scheme of order 2 has 3/4 left."""


class Verdict(Enum):
    """Whether an orbit lies on a torus; the value is the sentence for people."""

    TORUS = "torus"
    RESONANT = "resonant torus of lower dimension"
    NOT_A_TORUS = "not a torus"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class TorusFit(Result, axis=None):
    """The torus of an orbit as a Fourier series: z(theta) = Re sum_k z_k exp(2 pi i k . theta), one k of each pair +-k.

    names (d,) of the angles; nu (d,) in cycles per unit time and nu_error (d,), inf where there is no torus; J (d,),
    the integrals of p dq over the cycles (`I` = J/2 pi); theta0 (d,), the angles of z0 in cycles, so that z(t) =
    evaluate(theta0 + nu t); k (terms, d) integer and coefficients (2n, terms) complex, the largest first; residual:
    largest |nu . dz/dtheta - X(z)| over points of the torus, relative to the largest |X|; prediction_error: largest
    distance between the orbit and evaluate(theta0 + nu t) after the fitted time, relative to the size of the orbit;
    verdict; dimension d of the torus; relations (n' - d, n'): integer vectors that the n' natural frequencies are
    annihilated by; evidence: numbers by name; energy of z0; body.
    """

    names: tuple[str, ...]
    nu: Annotated[np.ndarray, along("angle", unit="cycles/time", labels="names", plain=True)]
    nu_error: Annotated[np.ndarray, along("angle", unit="cycles/time", labels="names")]
    J: Annotated[np.ndarray, along("angle", unit="action", labels="names")]
    theta0: Annotated[np.ndarray, along("angle", unit="cycles", labels="names")]
    k: Annotated[np.ndarray, along("term", "angle")]
    coefficients: Annotated[np.ndarray, along("coordinate", "term")]
    residual: float
    prediction_error: float
    verdict: Verdict
    dimension: int
    relations: Annotated[np.ndarray, along("relation", "frequency")]
    evidence: Mapping[str, float]
    energy: float
    body: Any

    @property
    def I(self) -> np.ndarray:  # noqa: E743
        """Actions J/2 pi."""
        return self.J / (2 * np.pi)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu, in radians per unit time."""
        return 2 * np.pi * self.nu

    @property
    def order(self) -> int:
        """Largest sum |k_i| of the series."""
        return int(np.abs(self.k).sum(axis=1).max(initial=0))

    def evaluate(self, theta: Any) -> np.ndarray:
        """Return the phase points (2n, ...) at angles theta (d, ...) in cycles. Raises ValueError for another shape."""
        theta = numbers("theta", theta)
        if theta.ndim < 1 or len(theta) != self.dimension:
            raise ValueError(f"theta must have shape ({self.dimension}, ...), got {theta.shape}")
        if not np.isfinite(theta).all():
            raise ValueError(f"theta must be finite, got {shown(theta)}")
        flat = theta.reshape(self.dimension, int(np.prod(theta.shape[1:])))
        return evaluate(self.k, self.coefficients, flat).reshape(len(self.coefficients), *theta.shape[1:])

    def in_basis(self, M: Any) -> TorusFit:
        """Return the same torus with the angles M theta, M (d, d) integer of determinant +-1: nu' = M nu, J' = M^-T J.

        Raises ValueError for another matrix.
        """
        given = numbers("M", M)
        if (
            given.shape != (self.dimension,) * 2
            or not np.all(np.abs(given) < 2**53)
            or (given % 1).any()
            or abs(determinant(given)) != 1
        ):
            raise ValueError(f"M must be an integer matrix {(self.dimension,) * 2} of determinant +-1, got {M!r}")
        M = given.astype(int)
        back = inverse(M)
        names = tuple(_combination(row, self.names) for row in M)
        known = np.isfinite(self.nu_error).all()
        return replace(
            self,
            names=names,
            nu=M @ self.nu,
            nu_error=np.abs(M) @ self.nu_error if known else self.nu_error,
            J=back.T @ self.J,
            theta0=M @ self.theta0 % 1.0,
            k=self.k @ back,
        )

    def truncated(self, order: int) -> TorusFit:
        """Return the series cut at sum |k_i| <= order, with the actions and the residual that it has. Raises for order
        < 0.
        """
        kept = np.abs(self.k).sum(axis=1) <= whole("order", order, 0)
        k, z = self.k[kept], self.coefficients[:, kept]
        return replace(self, k=k, coefficients=z, J=actions(k, z), residual=_residual(self.body, k, z, self.nu))

    def summary(self) -> str:
        """Say in one line what was found."""
        pairs = ", ".join(f"{name} {value:.9g}" for name, value in zip(self.names, self.nu))
        text = (
            f"{self.verdict.value}, dimension {self.dimension}: nu {pairs or '-'}; {len(self.k)} terms, "
            f"residual {self.residual:.1e}, prediction error {self.prediction_error:.1e}"
        )
        if self.verdict is Verdict.UNDECIDED:
            outcome = Status(int(self.evidence["status"]))
            text += (
                f"; a time of {self.evidence['longer']:.3g} may decide"
                if "longer" in self.evidence
                else f"; {outcome.sentence}"
                if outcome == Status.INTERRUPTED
                else "; the orbit failed"
            )
        return text


@takes(scheme=scheme_of)
@recorded
def fit_torus(
    body: Model,
    z0: Any,
    *,
    time: float,
    tolerance: float = 1e-6,
    step: float | None = None,
    scheme: Splitting | RungeKutta = SOFRONIOU_SPALETTA10,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    report: Report | None = None,
) -> TorusFit:
    """Find the Fourier torus that the orbit of `body` from `z0` lies on, separable or not.

    Parameters: z0 (2n,); time > 0 that is fitted, best 200 periods or more (half as much again is integrated for the
    prediction); tolerance: residual and prediction error up to which there is a torus; step, scheme, rtol, atol as in
    `integrate`; report: called with the fraction that is done, a quarter for each of the orbit, the same by half the
    steps, the fit and the verdict. Returns TorusFit. Raises ValueError or TypeError for wrong input; Interrupted on
    Ctrl-C, with what was known until then in `.partial`. An orbit that escapes is "not a torus", one that fails
    otherwise "undecided", with its status as evidence.

    The lines of NAFF in the natural signals of the librations (`body.angles`) are identified with integer combinations
    of as few frequencies as they need; a body's planes add eta and gamma, at their mean turning rates. Then all
    frequencies and the coefficients up to an order that grows until they are at rounding are fitted together by
    windowed least squares. Actions: I_i = 1/2 Re sum_k i k_i conj(p_k) . q_k, so I_eta = p_eta and I_gamma = p_gamma of
    a body come out as a check. Basis: for a body the librations and then eta, gamma; of the libration lattice the
    leading lines of the natural signals where they are one, with positive frequencies. Exact relations k . nu = 0,
    |k_i| <= 8, lower the dimension. The origin of the angles is where the largest coefficients that are a basis are
    real and positive.

    Accuracy: spectral in time and order, while the lines of low order are 1.5 cycles or more apart over `time`; closer
    ones are left out (evidence "terms left out"), which can cost the verdict: then it is "undecided", as below eight
    periods. Against quadrature on separable bodies, time 300: nu to 2e-13, J to 2e-13 relative
    (bench/test_torus_fit.py). nu_error: what unequal parts of the window, and half the step, change. "Not a torus" is
    an orbit whose prediction fails and that MEGNO and SALI call chaotic (`chaos_map`, over the same time; of a body
    that has `tangent_force`): weak chaos below `tolerance` passes.
    Cost: 16 flops per sample, term and signal for each of some 20 passes: 0.2 to 10 s an orbit.
    Source: Laskar 1999, Introduction to frequency map analysis, NATO ASI C 533, 134 (lines); Percival 1974, J. Phys. A
    7, 794 (Fourier tori, their actions and invariance equation); Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111
    (window).
    """
    time, tolerance = positive("time", time), positive("tolerance", tolerance)
    if kind_of(body) is Kind.MAP:
        raise TypeError(
            f"body {type(body).__name__} is a map: fit its iterates, "
            "fastaff.analysis.fit_samples(integrate(body, z0, time=4096, samples=4096).samples[..., 0].T, 1.0)"
        )
    z = phase_points("z0", z0, checked_model(body, kinds=CONSERVATIVE))
    if z.shape[1] != 1:
        raise ValueError(f"z0 must be one phase point of shape ({len(z)},), got {z.shape[1]} orbits")
    flow, z, _ = plan(body, z, Options(scheme, step, None, rtol, atol, report=report))
    energy = float(energies(body, z)[0])
    known = [nothing(body, energy, {"status": float(Status.INTERRUPTED)}, Verdict.UNDECIDED)]
    with keeping("fit_torus", lambda: known[-1]):
        found = _found(flow, body, z, time, tolerance, energy, known, report or (lambda fraction: None))
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
        return _point(body, path, energy, evidence)
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
    return _doubted(known[-1], z, time)


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


def resting(path: np.ndarray) -> bool:
    """Tell whether the orbit stays where it is, to rounding."""
    return bool((np.ptp(path, axis=1) <= 1e-12 * np.abs(path).max()).all())


def _point(body: Any, path: np.ndarray, energy: float, evidence: dict) -> TorusFit:
    """Return the torus of dimension 0 of a body at rest; its residual is absolute."""
    none, k, z = np.zeros(0), np.zeros((1, 0), int), path[:, :1] + 0j
    residual = float(np.abs(slopes(body, path[:, :1])).max())
    return TorusFit(
        (),
        none,
        none,
        none,
        none,
        k,
        z,
        residual,
        float(np.ptp(path, axis=1).max() / (np.abs(path).max() or 1.0)),
        Verdict.RESONANT,
        0,
        np.zeros((0, 0), int),
        MappingProxyType(evidence),
        energy,
        body,
    )


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
    error, diffusion = _errors(samples, series, start.rank, 2 * evidence["energy error"])
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
    residual = _residual(body, k, z, nu)
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
        tuple(_basis_name(unit, R, start.names) for unit in np.eye(len(nu), dtype=int)),
        nu,
        np.abs(C) @ error,
        actions(k, z),
        (angles - nu * (t[0] + t[-1]) / 2) % 1.0,
        k,
        z,
        residual,
        prediction,
        verdict,
        len(nu),
        relation,
        MappingProxyType(evidence),
        energy,
        body,
    )


def unsure(found: TorusFit, time: float) -> TorusFit:
    """Return a fit that is not good enough, undecided."""
    evidence, none = MappingProxyType({**found.evidence, "longer": 4 * time}), np.full_like(found.nu_error, np.inf)
    return replace(found, verdict=Verdict.UNDECIDED, nu_error=none, evidence=evidence)


def _doubted(found: TorusFit, z: np.ndarray, time: float) -> TorusFit:
    """Return an undecided fit with the verdict that chaos gives, or that there is none to be seen."""
    if not hasattr(found.body, "tangent_force"):
        return found
    seen = chaos_map(found.body, z, time=1.5 * time)
    values = {name: float(value[0]) for name, value in zip(seen.names, seen.values, strict=True)}
    verdict = Verdict.NOT_A_TORUS if seen.chaotic[0] else found.verdict
    return replace(found, verdict=verdict, evidence=MappingProxyType({**found.evidence, **values}))


def _errors(samples: Samples, series: Series, rank: int, drift: float) -> tuple[np.ndarray, float]:
    """Return the error estimates of the frequencies, and the largest relative difference of those of two parts of the
    window.

    The parts are unequal: where the motion returns to its phase after half the window, halves would agree on wrong
    frequencies.
    """
    size, orders = len(samples.t), tuple(-(-2 * order // 3) for order in series.orders)
    ends = [slice(0, int(EARLY * size)), slice(int(LATE * size), size)]
    parts = [
        fit(window(samples.t[part], samples.signals[:, part], samples.carrier), series.nu, rank, orders, iterations=3)
        for part in ends
    ]
    largest = np.abs(series.nu).max(initial=1 / samples.time)
    unsettled = max(part.unsettled for part in parts) / (samples.time / 2)
    difference = np.maximum(np.abs(parts[0].nu - parts[1].nu), unsettled)
    error = 3 * difference + series.unsettled / samples.time + (1e-13 + drift) * largest
    return error, float(difference.max(initial=0.0) / largest)


def _reach(error: float) -> int:
    """Return how large integers a relation may have so that chance ones stay unlikely, for frequencies of that relative
    error.
    """
    return 8 if error < 1e-9 else 4 if error < 1e-7 else 2 if error < 1e-5 else 0


def _residual(body: Any, k: np.ndarray, z: np.ndarray, nu: np.ndarray) -> float:
    """Return the largest |nu . dz/dtheta - X(z)| on the torus over the largest |X|, for coordinates and momenta apart;
    NaN where no equations of motion are known.
    """
    if body is None or isinstance(body, Unknown):
        return float("nan")
    n, d = len(z) // 2, k.shape[1]
    ratio = np.roots([1.0, *[0.0] * (d - 1), -1.0, -1.0]).real.max() if d else 1.0  # evenly spread points (Roberts)
    theta = np.arange(GRID) * ratio ** -np.arange(1.0, d + 1)[:, None] % 1.0
    point, slope = np.split(evaluate(k, np.vstack([z, 2j * np.pi * (k @ nu) * z]), theta), 2)
    with np.errstate(all="ignore"):
        speed = slopes(body, point)
        parts = [
            np.abs(slope[s] - speed[s]).max() / (np.abs(speed[s]).max() or 1.0) for s in (slice(n), slice(n, 2 * n))
        ]
    return float(max(parts)) if np.isfinite(parts).all() else np.inf


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


def nothing(body: Any, energy: float, evidence: dict, verdict: Verdict) -> TorusFit:
    """Return what there is to say of an orbit that failed, or is too short: its status."""
    n = body.degrees_of_freedom
    unknown, one = np.full(n, np.nan), np.full((2 * n, 1), np.nan + 0j)
    return TorusFit(
        coordinate_names(body),
        unknown,
        np.full(n, np.inf),
        unknown,
        unknown,
        np.zeros((1, n), int),
        one,
        np.inf,
        np.inf,
        verdict,
        n,
        np.zeros((0, n), int),
        MappingProxyType(evidence),
        energy,
        body,
    )


def _basis_name(unit: np.ndarray, R: np.ndarray, names: tuple[str, ...]) -> str:
    """Return the name of the frequency whose row of R is that unit vector, else a number."""
    return next(
        (name for row, name in zip(R, names, strict=True) if np.array_equal(row, unit)),
        f"theta {int(unit.argmax()) + 1}",
    )


def _combination(row: np.ndarray, names: tuple[str, ...]) -> str:
    """Return an integer combination of names, like r-2*gamma."""
    text = "".join(
        f"{'+' if c > 0 else '-'}{'' if abs(c) == 1 else f'{abs(c)}*'}{name}" for c, name in zip(row, names) if c
    )
    return text.removeprefix("+")
