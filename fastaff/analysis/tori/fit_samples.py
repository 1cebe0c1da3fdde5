"""The Fourier torus of an orbit that was computed elsewhere, from its samples alone."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ...base.numbers import positive
from ...base.status import Status
from ..frequencies.frequencies import FrequencyKind
from ..frequencies.orbit_frequencies import orbit_frequencies
from ..orbits.given_orbits import ends, given_orbits
from .fit_signals import Unknown
from .fit_torus import fitted
from .torus import TorusFit, Verdict, nothing, resting, unsure

LEAST = 384
"""Samples that a fit needs: its first lines are looked for in two thirds of them."""

FARTHEST = 1e150
"""Time whose square is still a number."""


def fit_samples(
    samples: Any, dt: float | None = None, *, times: Any = None, coordinates: Any = None, tolerance: float = 1e-6
) -> TorusFit:
    """Fit a Fourier torus to the samples of one orbit of another program.

    :Parameters: samples (2n, samples) or (2n, 1, samples), dt, times, coordinates as in `orbit_frequencies`, 384
        samples or more of an orbit that does not end, dense enough for all harmonics; tolerance: largest prediction
        error of a torus.
    :Returns: TorusFit, whose residual and energy are NaN and body None: no equations of motion are known.
    :Raises: ValueError or TypeError naming the wrong argument.

    The first two thirds of the samples are fitted as `fit_torus` does its own; the fit predicts the last third. Where
    the prediction fails, the orbit is "not a torus" if its frequencies change from half to half (`orbit_frequencies`),
    else undecided. nu_error knows nothing of the scheme that made the samples. theta0 are the angles of the first one.
    Actions J are those of the rows as they are: canonical where these are.

    :Cost: as `fit_torus`, without its runs.
    :Source: as `fit_torus`.
    """
    tolerance = positive("tolerance", tolerance)
    given = given_orbits("samples", samples, dt=dt, times=times, coordinates=coordinates, least=LEAST)
    if given.shape[1] != 1:
        raise ValueError(f"samples must be of one orbit, (2n, samples), got {given.shape[1]} orbits")
    if given.interval is None:
        raise ValueError("dt must be given, the time between samples: these do not tell")
    if not 1.0 / FARTHEST < given.interval * LEAST < given.interval * given.shape[2] < FARTHEST:
        raise ValueError(f"dt must be neither so small nor so large that squares of times are none, got {dt!r}")
    z = given.read(0, 1)
    known = int(ends("samples", z)[0][0])
    path = np.ascontiguousarray(z[:, 0])
    if known < path.shape[1]:
        raise ValueError(
            f"samples must be finite and move to the last one, got {path[:, known]} from sample {known} on"
        )
    if resting(path):
        raise ValueError("samples must be of an orbit that moves")
    body: Any = Unknown(given.angles)
    inside = 2 * path.shape[1] // 3
    evidence = {"status": float(Status.OK), "energy error": 0.0, "samples": float(inside)}
    t = given.interval * np.arange(path.shape[1])
    try:
        found = fitted(body, t, path, path, inside, np.nan, evidence)
    except np.linalg.LinAlgError:
        found = nothing(body, np.nan, evidence, Verdict.UNDECIDED)
    if not found.prediction_error <= tolerance:
        seen = orbit_frequencies(path, given.interval)
        found = unsure(found, t[inside])
        verdict = Verdict.NOT_A_TORUS if seen.kind[0] == FrequencyKind.IRREGULAR else found.verdict
        change = MappingProxyType({**found.evidence, "frequency diffusion": float(seen.diffusion[0])})
        found = replace(found, verdict=verdict, evidence=change)
    return replace(found, body=None)
