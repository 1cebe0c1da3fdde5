"""Tori without separability: the Fourier torus of one orbit of any model, its actions, and whether it exists."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..chaos.chaos_map import chaos_map
from ..core.classification import Classification
from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, Passes, positive, shown
from ..core.status import Status
from ..frequencies.integer_lattice import quotient, relations
from ..frequencies.orbit_frequencies import orbit_frequencies
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.progress import says_progress
from ..runs.given_orbits import ends, given_orbits
from ..runs.options import Options, Problem
from ..runs.requirements import checked_system, current_system, phase_points
from ..runs.schemes.catalogue import GAUSS16, SOFRONIOU_SPALETTA10, Scheme, scheme_of
from ..runs.starts import starts_of
from ..systems.models.contracts import Dynamics
from ..systems.models.mechanics import System
from .axis_tori import angle_names, axis_angles, check_momentum, momentum_drift, orbital_plane, with_own_cycles
from .lines import TorusSignals, axis_signals, signals
from .orbit_samples import OrbitSamples, samples_of_flow, samples_of_turns
from .series import LARGEST_ORDER, STEPS, Series, actions, canonical, errors, evaluate, fit, grow, window
from .torus import GRID, TorusFit, Unknown, area, classified, distance, nothing, residual, resting, turned

LEAST_SAMPLES = 384
"""Least number of samples for a fit of a given orbit: its first lines are sought in two thirds of them."""

FARTHEST = 1e150
"""Time whose square is still a number."""

LONGEST = 512
"""Largest order of the series of a curve of a map."""

ROUNDS = 4
"""Number of times that winding angles are reduced by a better value of their rate."""


@coerces_arguments(z0=starts_of, scheme=scheme_of)
@records_call
@inserts_parameters
def fit_torus(
    model: Dynamics,
    z0: Starts,
    *,
    time: float,
    angles: str | None = None,
    tolerance: float = 1e-6,
    step: float | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    callback: Callback | None = None,
) -> TorusFit:
    """Fit a Fourier torus to the orbit of any model.

    Parameters
    ----------
    model : model
        System with an energy, driven system or map. ODE systems are not supported.
    z0 : array_like, shape (2n,)
        Initial conditions of one orbit.
    time : float
        Length of the fit in units of time. Use 200 periods or more. For a map it is the number of iterates, and for a
        driven system the number of drive periods. Use 1000 or more, and many more in four dimensions. The test of the
        prediction takes half as long in addition.
    angles : str, optional
        ``"R z phi"`` for rows x, y, z and velocities, or ``"R phi"`` for x, y: angles about the z axis, about which the
        model must be symmetric. ``J / (2 * np.pi)`` is then J_R, J_z, L_z. An orbit that a resonance of R and z has
        trapped has the names theta 1 and theta 2 instead. Default: angles of the coordinates.
    tolerance : float, default 1e-6
        Largest residual and largest prediction error of a fit that counts as a torus. Both are relative.
    step : float, optional
        Largest fixed step size, in units of time. Default: chosen for the orbit.
    scheme : Scheme or str, optional
        Integration method or its name. Default: ``"SOFRONIOU_SPALETTA10"``, and ``"GAUSS16"`` for nonseparable
        Hamiltonians.
    {rtol}
    {atol}
    callback : callable, optional
        Function that is called with the completed fraction: a quarter each for the orbit, the orbit with half the step
        size, the fit and the classification.

    Returns
    -------
    TorusFit
        The torus. An orbit that escapes is ``IRREGULAR``, one that fails otherwise is ``UNDECIDED``; its status is in
        ``evidence``.

    Raises
    ------
    TypeError
        If an argument has the wrong type or the model does not support regular motion.
    ValueError
        If an argument has a wrong value or shape, for example more than one orbit.
    Interrupted
        On Ctrl-C. The result so far is in its attribute ``partial``.

    Notes
    -----
    - Method: `naff` lines are identified with integer combinations of fundamental frequencies, then all are fitted by
      windowed least squares.
    - Accuracy: errors fall exponentially with time and number of terms. For separable bodies over time 300, nu and J
      have relative errors of 2e-13.
    - Lines of low order whose frequencies differ by less than 1.5/`time` are left out (evidence "terms left out").
      Orbits with these lines, and runs below eight periods, can be ``UNDECIDED``.
    - ``IRREGULAR``: the prediction fails, and `MEGNO` and `SALI` find chaos over the same time. Chaos with an effect
      below `tolerance` is not detected. Flows without ``tangent_force`` are not tested for chaos.
    - Exact relations k . nu = 0 with ``|k_i| <= 8`` lower the dimension. With `angles`, only those of R and z do, and
      in a spherical potential none.
    - Cost: 0.1 to 3 s per orbit, 20 s for a thousand terms and more.

    References
    ----------
    Laskar 1999, Introduction to frequency map analysis, NATO ASI C 533, 134 (lines); Percival 1974, J. Phys. A 7, 794
    (Fourier tori, their actions and invariance equation); Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111
    (window).

    Examples
    --------
    >>> fit = fa.fit_torus(fa.models.StandardMap(0.5), [3.0, 0.3], time=1000)
    >>> fit.classification, fit.dimension
    (<Classification.REGULAR: 0>, 1)
    """
    problem = Problem(model, z0, Options(scheme=scheme, step=step, rtol=rtol, atol=atol, callback=callback))
    tolerance = positive("tolerance", tolerance)
    system = checked_system(problem.model, needs="regular motion")
    z = phase_points("z0", problem.z0, system)
    if z.shape[1] != 1:
        raise ValueError(f"z0 must be one phase point of shape ({len(z)},), got {z.shape[1]} orbits. Try z0[:, 0].")
    about_axis = axis_angles(angles, system, z)
    time = problem.iterates("time", time)
    done = callback or (lambda fraction: None)
    if scheme is None and not system.iterated:
        chosen = SOFRONIOU_SPALETTA10 if system.separable else GAUSS16
        problem = replace(problem, options=replace(problem.options, scheme=chosen))
    energy = math.nan if turned(system) else float(system.energies(z)[0])
    known = [nothing(system, energy, {"status": float(Status.INTERRUPTED)})]
    with partial_result_on_interrupt("fit_torus", lambda: known[-1]):
        found = (samples_of_turns if turned(system) else samples_of_flow)(problem, time, energy, done)
        if isinstance(found, OrbitSamples):
            with Passes(lambda fraction: done(0.5 + fraction / 4)) as passes:
                found = axis_fitted(system, found, passes) if about_axis else fitted(system, found, passes)
            if not max(found.residual, found.prediction_error) <= tolerance:
                known.append(as_undecided(found, {"suggested time": 4 * time}))
                found = check_for_chaos(system, known[-1], z, time, lambda fraction: done(0.75 + fraction / 4))
        done(1.0)
    return found


class _Fitted(NamedTuple):
    """Signals of samples and the series that fits them; errors of its frequencies and their diffusion; relations of
    these; comparable series: of two parts of the window, and of half the step size (None without).
    """

    signals: TorusSignals
    series: Series
    error: np.ndarray
    diffusion: float
    relations: np.ndarray
    parts: tuple[Series, ...]
    finer: Series | None


def _fit_series(
    system: System, orbit: OrbitSamples, passes: Passes, see: Callable[[np.ndarray, np.ndarray], TorusSignals]
) -> _Fitted:
    """Return the fit of the samples inside, with errors."""
    t = orbit.t[: orbit.inside]
    path = orbit.path[:, : orbit.inside]
    turns = turned(system)
    start = see(t, path)
    samples = window(t, start.values, start.carrier)
    curve = start.rank == 1 and (turns or start.about is not None)
    largest = min(LONGEST, len(t) // 4) if curve else LARGEST_ORDER
    series = grow(samples, start.nu, start.rank, largest, start.silent, passes)
    for _ in range(ROUNDS if start.winding.any() else 0):
        moved = np.abs(series.nu - start.nu).max() * (t[-1] - t[0] + t[1] - t[0])
        start = start.at(series.nu, samples.t, path)
        samples = window(t, start.values, start.carrier)
        series = fit(samples, start.nu, start.rank, series.orders)
        if moved < 1e-12:
            break
    callback = passes.take(2.0, 4.0)
    error, diffusion, parts = errors(samples, series, start.rank, 2 * orbit.evidence["energy error"], callback)
    for bar in start.bars:
        error = error + bar
    finer = None
    if orbit.finer is not None:
        same = samples._replace(signals=start.same(samples.t, orbit.finer[:, : len(t)]))
        callback = passes.take(3.0, 1.0)
        finer = fit(same, series.nu, start.rank, series.orders, iterations=3, callback=callback)
        error = error + STEPS * np.abs(finer.nu - series.nu)
    relative = error.max(initial=0.0) / np.abs(series.nu).max(initial=1 / samples.time)
    reach = 0 if turns else _reach(relative)
    known = len(series.nu) if start.about is None else start.rank
    found = relations(series.nu[:known], error[:known], reach)
    found = np.pad(found, ((0, 0), (0, len(series.nu) - known)))
    return _Fitted(start, series, error, diffusion, found, parts, finer)


def _terms(start: TorusSignals, series: Series, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the series of phase points: its terms k and coefficients z (2n, terms), about the signals' centre."""
    zero = np.zeros((1, R.shape[1]), int)
    carriers = np.vstack([R[start.rank :], zero])
    k = np.concatenate([zero, *[carriers[c] + series.k @ R[: start.rank] for c in start.carrier]])
    parts = [back[:, None] * c for back, c in zip(start.rows.T, series.c, strict=True)]
    return k, np.concatenate([np.zeros((len(start.rows), 1), complex), *parts], axis=1)


def _action_errors(system: System, found: _Fitted, R: np.ndarray, drift: float) -> np.ndarray:
    """Return the error estimates (d,) of the actions, as those of the frequencies: from the series of two parts of the
    window and of half the step size; drift: relative errors of the energy and of the predicted states.
    """
    start = found.signals
    winding = start.winding @ R

    def J(series: Series) -> np.ndarray:
        k, z, _ = canonical(*_terms(start, series, R))
        if winding.any():
            k, z = _about(start.centre, k, z)
        return area(system, k, z, winding if winding.any() else None)

    here = J(found.series)
    error = (1e-13 + drift) * np.abs(here).max(initial=0.0) + np.zeros(here.shape)
    if found.parts:
        error = error + 3 * np.abs(J(found.parts[0]) - J(found.parts[1]))
    if found.finer is not None:
        error = error + STEPS * np.abs(J(found.finer) - here)
    return error


def fitted(
    system: System,
    orbit: OrbitSamples,
    passes: Passes,
    see: Callable[[np.ndarray, np.ndarray], TorusSignals] | None = None,
) -> TorusFit:
    """Fit the samples inside; compare with the equations of motion or the map, the later samples, and finer steps; see:
    the signals of samples at times, by default those of the system.
    """
    t = orbit.t
    turns = turned(system)
    middle = (orbit.t[0] + orbit.t[orbit.inside - 1]) / 2
    found = _fit_series(system, orbit, passes, see or partial(signals, system))
    start, series, error = found.signals, found.series, found.error
    R, C = quotient(found.relations, len(error))
    nu = C @ series.nu
    winding = start.winding @ R
    k, z = _terms(start, series, R)
    free = turns & ~winding.any(axis=0)
    if free.any():  # they have the sense of a positive action
        sign = np.where(free & (actions(*canonical(k, z)[:2]) < 0), -1, 1)
        nu = sign * nu
        winding = winding * sign
        k = k * sign
    k, z, angles = canonical(k, z)
    theta0 = (angles - nu * middle) % 1.0  # before a whole turn is taken off: the middle may be half a sample
    if turns:
        k, z = _about(start.centre - start.steady * middle - winding @ angles, k, z)
    elif winding.any():
        k, z = _about(start.centre - winding @ (theta0 + nu * middle), k, z)
    nu = np.where(free, nu % 1.0, nu)
    wound = winding if winding.any() else None
    left = residual(system, k, z, nu, wound, orbit.pieces)
    count = len(t) // 3 if turns else len(t) - orbit.inside
    later = np.arange(orbit.inside, len(t), max(1, count // GRID))
    origin, time = (theta0, 0.0) if turns or winding.any() else (angles, middle)
    theta = origin[:, None] + nu[:, None] * (t[later] - time)
    ahead = winding @ theta
    if turns:
        prediction = distance(system, evaluate(k, z, theta) + ahead, orbit.path[:, later])
    else:  # relative to the size of the path without its winding
        prediction = distance(system, evaluate(k, z, theta), orbit.path[:, later] - ahead)
    tried = {"residual": left, "prediction error": prediction}
    fit_of = {
        "misfit": series.misfit,
        "diffusion": found.diffusion,
        "edge of the series": float(series.edge.max(initial=0.0)),
        "terms left out": float(series.left_out),
        "unexplained lines": float(start.unknown),
    }
    return TorusFit(
        names=tuple(basis_name(unit, R, start.names) for unit in np.eye(len(nu), dtype=int)),
        nu=nu / orbit.pieces,
        nu_error=np.abs(C) @ error / orbit.pieces,
        J=area(system, k, z, wound),
        J_error=_action_errors(system, found, R, 2 * orbit.evidence["energy error"] + prediction),
        theta0=theta0,
        k=k,
        coefficients=z,
        residual=left,
        prediction_error=prediction,
        classification=classified(system, len(nu)),
        dimension=len(nu),
        relations=found.relations,
        evidence=MappingProxyType(orbit.evidence | (fit_of | tried if turns else tried | fit_of)),
        energy=orbit.energy,
        model=system.model,
        winding=wound,
        islands=orbit.pieces,
    )


def axis_fitted(system: System, orbit: OrbitSamples, passes: Passes) -> TorusFit:
    """Fit the torus of an orbit about the z axis, in the orbit's plane if it has one."""
    plane = orbital_plane(orbit.path)
    if plane is None:
        found = with_own_cycles(fitted(system, orbit, passes, axis_signals))
    else:
        finer = None if orbit.finer is None else plane.inside(orbit.finer)
        inside = orbit._replace(path=plane.inside(orbit.path), finer=finer)
        found = plane.lifted(fitted(current_system(Unknown(("u", "v"))), inside, passes, axis_signals), system)
    return replace(found, J_error=found.J_error + 2 * np.pi * momentum_drift(orbit.path))


def _reach(error: float) -> int:
    """Return the largest integers of a relation for which accidental ones are unlikely, for frequencies of that
    relative error.
    """
    if error < 1e-9:
        return 8
    if error < 1e-7:
        return 4
    if error < 1e-5:
        return 2
    return 0


def _about(centre: np.ndarray, k: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a series (terms), z (2n, terms) about another centre (2n,)."""
    if k.any(axis=1).all():
        k = np.vstack([k, np.zeros((1, k.shape[1]), int)])
        z = np.column_stack([z, np.zeros(len(z), complex)])
    z[:, ~k.any(axis=1)] += centre[:, None]
    return k, z


def as_undecided(found: TorusFit, evidence: dict, *, chaotic: bool = False) -> TorusFit:
    """Return a fit that is not good enough, undecided or no torus, with more evidence."""
    classification = Classification.IRREGULAR if chaotic else Classification.UNDECIDED
    none = np.full_like(found.nu_error, np.inf)
    return replace(
        found,
        classification=classification,
        nu_error=none,
        J_error=np.full_like(found.nu_error, np.inf),
        evidence=MappingProxyType({**found.evidence, **evidence}),
    )


def check_for_chaos(system: System, found: TorusFit, z: np.ndarray, time: float, callback: Callback) -> TorusFit:
    """Return an undecided fit made IRREGULAR if a chaos map shows chaos."""
    if not system.iterated and not hasattr(system.model, "tangent_force"):
        return found
    seen = chaos_map(system.model, z, time=1.5 * time, callback=callback)
    values = {name: float(value[0]) for name, value in zip(seen.names, seen.values, strict=True)}
    return as_undecided(found, values, chaotic=bool(seen.chaotic[0]))


def basis_name(unit: np.ndarray, R: np.ndarray, names: tuple[str, ...]) -> str:
    """Return the name of the frequency whose row of R is that unit vector, else a number."""
    return next(
        (name for row, name in zip(R, names, strict=True) if np.array_equal(row, unit)),
        f"theta {int(unit.argmax()) + 1}",
    )


@says_progress
def fit_samples(
    samples: object,
    dt: float | None = None,
    *,
    times: ArrayLike | None = None,
    coordinates: Sequence[str] | None = None,
    angles: str | None = None,
    tolerance: float = 1e-6,
) -> TorusFit:
    """Fit a Fourier torus to samples of one orbit from another program.

    Parameters
    ----------
    samples : array_like, shape (2n, samples) or (2n, 1, samples)
        Coordinates, then momenta, of an orbit that does not end: 384 samples or more, dense enough for all harmonics.
    dt : float, optional
        Time between samples.
    times : array_like, shape (samples,), optional
        Times of the samples instead of `dt`, equally spaced to a millionth. Default: the times of an `Orbits` or a
        labelled array.
    coordinates : sequence of str, optional
        Names of the 2n rows.
    angles : str, optional
        ``"R z phi"`` for rows x, y, z and velocities, or ``"R phi"`` for x, y: angles about the z axis of an orbit
        whose angular momentum about it is constant. Default: angles of the coordinates.
    tolerance : float, default 1e-6
        Largest prediction error of a torus.

    Returns
    -------
    TorusFit
        The torus. The equations of motion are unknown, so the residual and the energy are NaN and the model is None.
        The angles theta0 belong to the first sample.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If an argument has a wrong value or shape, or the times are not equally spaced.

    Notes
    -----
    - Method: the first two thirds of the samples are fitted as in `fit_torus`. The fit predicts the last third.
    - If the prediction fails, the orbit is ``IRREGULAR`` if its frequencies change between the halves of the run
      (`orbit_frequencies`), else ``UNDECIDED``.
    - Accuracy: nu_error does not include the errors of the integrator that made the samples. J are the actions of the
      given rows, and canonical if these are.
    - Cost: as `fit_torus` without the integration.

    References
    ----------
    Laskar 1999, Introduction to frequency map analysis, NATO ASI C 533, 134; Percival 1974, J. Phys. A 7, 794; Das,
    Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111.

    Examples
    --------
    >>> t = 0.1 * np.arange(400)
    >>> fit = fa.tori.fit_samples([np.cos(3 * t), -np.sin(3 * t)], 0.1)
    >>> fit.omega.round(9), fit.J.round(9)
    (array([3.]), array([3.14159265]))
    """
    tolerance = positive("tolerance", tolerance)
    given = given_orbits(samples, dt=dt, times=times, coordinates=coordinates, least=LEAST_SAMPLES)
    if given.shape[1] != 1:
        raise ValueError(f"samples must be of one orbit, (2n, samples), got {given.shape[1]} orbits")
    if given.interval is None:
        raise ValueError("dt must be given, the time between samples: these do not tell")
    if not 1.0 / FARTHEST < given.interval * LEAST_SAMPLES < given.interval * given.shape[2] < FARTHEST:
        raise ValueError(f"dt must have a finite, non-zero square, got {shown(dt)}")
    z = given.read(0, 1)
    known = int(ends(z)[0][0])
    path = np.ascontiguousarray(z[:, 0])
    if known < path.shape[1]:
        raise ValueError(
            f"samples must be finite and move to the last one, got {shown(path[:, known].tolist())} from sample "
            f"{known} on"
        )
    if resting(path):
        raise ValueError("samples must be of an orbit that moves")
    fit_orbit: Callable[[System, OrbitSamples, Passes], TorusFit] = fitted
    if angles is not None:
        angle_names(angles, len(path) // 2)
        check_momentum(path, "samples")
        fit_orbit = axis_fitted
    system = current_system(Unknown(given.angles))
    inside = 2 * path.shape[1] // 3
    evidence = {"status": float(Status.OK), "energy error": 0.0, "samples": float(inside)}
    t = given.interval * np.arange(path.shape[1])
    try:
        found = fit_orbit(system, OrbitSamples(t, path, inside, path, evidence), Passes(None))
    except np.linalg.LinAlgError:
        found = nothing(system, np.nan, evidence)
    if not found.prediction_error <= tolerance:
        seen = orbit_frequencies(path, given.interval)
        change = {"suggested time": 4 * t[inside], "frequency diffusion": float(seen.diffusion[0])}
        found = as_undecided(found, change, chaotic=seen.classification[0] == Classification.IRREGULAR)
    return replace(found, model=None)
