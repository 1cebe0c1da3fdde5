"""Equidistant samples of one orbit, as dense as its torus needs, and facts about the orbit."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import Callback, fits
from ..core.status import Status
from ..engine.values import at_points
from ..runs.flow import Flow, mark_drift
from ..runs.options import Problem
from ..runs.requirements import energy_drift
from ..runs.scales import motion
from .lines import pieces_of
from .series import weights
from .torus import TorusFit, flow_of_turns, image, nothing, periods_of, point, resting, rows_of, without_periods

MOST_SAMPLES = 2**17
"""Most samples of an orbit."""

END_OF_SPECTRUM = 1e-13
"""Relative height of the spectrum at the sampling limit that is dense enough."""
LARGEST_DRIFT = 1e-6
"""Relative energy error above which an orbit counts as failed."""
LEAST_PERIODS = 8.0
"""Natural periods below which nothing is fitted: the lines could not be told apart."""
LEAST_TURNS = 256
"""Turns that a fit needs, of each of the pieces that an orbit lies on."""


class OrbitSamples(NamedTuple):
    """Equidistant samples of an orbit: times (samples,), states (2n, samples), the number of fitted ones; the later
    ones are predicted.

    finer: the same with half the step, or None; pieces: turns from one sample to the next, the number of images that
    the torus consists of; evidence: facts about the orbit, as in `TorusFit`.
    """

    t: np.ndarray
    path: np.ndarray
    inside: int
    finer: np.ndarray | None
    evidence: dict
    energy: float = math.nan
    pieces: int = 1


def samples_of_flow(problem: Problem, time: float, energy: float, callback: Callback) -> OrbitSamples | TorusFit:
    """Return samples of the orbit over 3/2 of the time, or the result without a fit.

    They are made so dense that the spectrum falls to rounding before its end, judged from its exponential fall.
    """
    system = problem.system
    flow, z, *_ = problem.plan()
    own = motion(system, z)
    least = LEAST_PERIODS * 2 * np.pi / float(own.rate[0])
    short = time < least and own.kinetic[0] > 0
    inside = 64 if short else 4096
    while True:
        path, evidence = _path(flow, z, 1.5 * time, 3 * inside // 2)
        evidence["samples"] = float(inside)
        if short or evidence["status"] != Status.OK or 2 * inside > MOST_SAMPLES:
            break
        spectrum = np.abs(np.fft.rfft(path[:, :inside] * weights(inside)))
        end = spectrum[:, -inside // 8 :].max() / (spectrum.max() or 1.0)
        if end <= END_OF_SPECTRUM:
            break
        factor = np.log(END_OF_SPECTRUM) / min(np.log(end), -0.5)
        inside = int(min(MOST_SAMPLES, inside * 2 ** np.ceil(np.log2(max(factor, 2.0)))))
    if evidence["status"] != Status.OK:
        return nothing(system, energy, evidence, gone=evidence["status"] == Status.ESCAPED)
    still = resting(path)
    moves = still or (system.kinetic_energies(path) > 0).any()
    if short or not moves:  # or the kinetic energy underflows
        return nothing(system, energy, evidence | {"suggested time": least})
    if still:
        left = float(np.abs(system.slopes(path[:, :1])).max())
        return point(system, path, energy, evidence, residual=left)
    callback(0.25)
    interval = 1.5 * time / (path.shape[1] - 1)
    finer, state = _path(flow.fitted(interval).finer(), z, 1.5 * time, path.shape[1] - 1)  # half the steps that it took
    callback(0.5)
    finer = finer if state["status"] == Status.OK else path
    return OrbitSamples(interval * np.arange(path.shape[1]), path, inside, finer, evidence, energy)


def samples_of_turns(problem: Problem, time: float, energy: float, callback: Callback) -> OrbitSamples | TorusFit:
    """Return samples of the orbit of a map, or of a driven system's map over its period, over 3/2 of the time, or the
    result without a fit.
    """
    system = problem.system
    mapping = system.iterated
    periods = periods_of(system)
    rows = rows_of(system)
    flow, z, interval = flow_of_turns(problem)
    count = int(time / interval + 1e-9)
    if count < LEAST_TURNS:
        return nothing(system, energy, {"status": float(Status.OK), "suggested time": LEAST_TURNS * interval})
    fits("time", 3 * count, len(z))
    path, evidence = _path(flow, z, (3 * count // 2) * interval, 3 * count // 2)
    evidence["samples"] = float(3 * count // 2)
    if evidence["status"] != Status.OK or not np.isfinite(path).all():
        gone = evidence["status"] in ((Status.LOST, Status.NONFINITE) if mapping else (Status.ESCAPED,))
        return nothing(system, energy, evidence, gone=gone)
    callback(0.25)
    pieces = pieces_of(system, path[:, :count])
    evidence["islands"] = float(pieces)
    if pieces > 1:
        path = _without_steps(path[:, ::pieces], periods)
    every = path[rows]
    if resting(every - every.mean(axis=1, keepdims=True) + every[:, :1]) or (np.ptp(every, axis=1) == 0).all():
        away = without_periods(image(system, path[:, :1], pieces) - path[:, :1], periods)[rows]
        return point(system, path, energy, evidence, residual=float(np.abs(away).max()), islands=pieces)
    inside = 2 * path.shape[1] // 3
    finer = None
    if inside < LEAST_TURNS:
        return nothing(system, energy, evidence | {"suggested time": pieces * LEAST_TURNS * interval})
    if not mapping:
        finer, state = _path(flow.finer(), z, pieces * inside * interval, pieces * inside)
        finer = finer[:, ::pieces] if state["status"] == Status.OK else None
    callback(0.5)
    return OrbitSamples(np.arange(float(path.shape[1])), path, inside, finer, evidence, energy, pieces)


def _path(flow: Flow, z: np.ndarray, time: float, count: int) -> tuple[np.ndarray, dict[str, float]]:
    """Return the states (2n, count + 1) of the orbit from z (2n, 1) up to a time, angles of a map unwrapped, and the
    outcome of the orbit.
    """
    ensemble = flow.ensemble(z.copy())
    system = flow.system
    error = 0.0
    states = flow.sampled(ensemble, count, time=time)
    path = np.column_stack([z, states[0].T])
    if system.iterated:
        path = _unwound(flow.model, path)
    else:
        if system.driven:
            path[system.moving] = z[system.moving]
        if system.driven or not resting(path):
            with np.errstate(all="ignore"):
                error = float(energy_drift(flow.system, path, ensemble.energy, ensemble.scale).max())
        if not system.driven:
            mark_drift(ensemble, np.array([error]), LARGEST_DRIFT)
    return path, {"status": float(ensemble.status[0]), "energy error": error}


def _unwound(model: Any, path: np.ndarray) -> np.ndarray:
    """Return the iterates (2n, samples) of a map with angles unwrapped by whole periods."""
    with np.errstate(all="ignore"):
        ahead = np.array(np.broadcast_arrays(*at_points(model, "iterate", *path[:, :-1])))
        for row, period in enumerate(model.periods()):
            if period > 0:
                path[row, 1:] += period * np.cumsum(np.rint((ahead[row] - path[row, 1:]) / period))
    return path


def _without_steps(path: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Return rows without the whole periods that they wind on from one sample to the next, where these are the same."""
    path = path.copy()
    for row in np.flatnonzero(periods > 0):
        steps = (path[row, -1] - path[row, 0]) / periods[row] / (path.shape[1] - 1)
        if abs(steps - np.rint(steps)) * path.shape[1] < 1:
            path[row] -= np.rint(steps) * periods[row] * np.arange(path.shape[1])
    return path
