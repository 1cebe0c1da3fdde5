"""Tangent maps: the derivative of a numerical flow, along any number of tangent vectors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, numbers
from ..core.status import Status
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.result import Result, along
from ..systems.models.contracts import Dynamics
from . import observers
from .coordinates import chart_row
from .flow import Ensemble, Flow, energy_error, mark_drift, no_memory
from .options import Options, Problem, stable_plan
from .requirements import carried
from .schemes.catalogue import Scheme, scheme_of
from .starts import starts_of


@dataclass(frozen=True)
class TangentMap(Result):
    """Hold end states of orbits and of their deviation vectors.

    Attributes
    ----------
    z : ndarray, shape (2n, orbits)
        States at the time `t`: coordinates, then momenta.
    vectors : ndarray, shape (count, 2n, orbits)
        Images of the deviation vectors under the derivative of the map.
    t : ndarray, shape (orbits,), time
        Time reached.
    energy_error : ndarray, shape (orbits,), relative
        Energy error divided by the largest kinetic energy of the orbit.
    status : ndarray, shape (orbits,), of `Status`
        Outcome of each orbit.
    scheme : Scheme
        Scheme that was used.
    step : float or ndarray, shape (orbits,), time
        Fixed step size, infinite for an adaptive scheme.
    names : tuple of str, 2n entries
        Names of the rows of z.
    """

    z: Annotated[np.ndarray, along("coordinate", "orbit", labels="names", plain=True)]
    vectors: Annotated[np.ndarray, along("vector", "coordinate", "orbit")]
    t: Annotated[np.ndarray, along("orbit", unit="time")]
    energy_error: Annotated[np.ndarray, along("orbit", unit="largest kinetic energy")]
    status: Annotated[np.ndarray, along("orbit")]
    scheme: Scheme
    step: Annotated[float | np.ndarray, along("orbit", unit="time")]
    names: tuple[str, ...]

    @property
    def matrix(self) -> np.ndarray:
        """Deviation vectors as columns, (2n, count, orbits): the monodromy matrix of unit vectors."""
        return self.vectors.transpose(1, 0, 2)

    def _row(self, name: str) -> np.ndarray | None:
        return chart_row(self.z, name)


@coerces_arguments(z0=starts_of, scheme=scheme_of)
@records_call
@inserts_parameters
def tangent_map(
    model: Dynamics,
    z0: Starts,
    *,
    time: float,
    deviation_vectors: ArrayLike | None = None,
    step: float | np.ndarray | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    energy_tolerance: float | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> TangentMap:
    """Integrate orbits of `model` from `z0` over `time` with deviation vectors.

    Parameters
    ----------
    {model}
    {z0}
    time : float
        Length of the run, positive. A map is iterated `time` times, a whole number.
    deviation_vectors : array_like, shape (count, 2n) or (count, 2n, orbits), optional
        Deviation vectors at the start, for all orbits or for each. Default: the 2n unit vectors.
    step : float or array_like, shape (orbits,), optional
        Largest fixed step size, in units of time. For an adaptive method it is the first step. Default: each orbit gets
        its own, for an error of 1e-10 of its amplitudes over 16 radians.
    {tangent_scheme}
    {rtol}
    {atol}
    {plain_energy_tolerance}
    {threads}
    {callback}

    Returns
    -------
    `TangentMap`
        End states and deviation vectors.

    Raises
    ------
    TypeError
        If an argument has a wrong type, or if the model has no derivatives.
    ValueError
        If a value is out of range, or if the model does not support an option.
    Interrupted
        On Ctrl-C. The result so far is in ``.partial``.

    Notes
    -----
    * Splittings: the vectors move by the derivative of the map that moves the orbit. The matrix M is symplectic to
      round-off.
    * Runge-Kutta schemes: the vectors move by the variational equations and count in the step control.
    * Vectors are not renormalised: those of a chaotic orbit grow as exp(lambda t).
    * Cost: about one more orbit for each vector, less the terms that they share.

    References
    ----------
    Skokos & Gerlach 2010, Phys. Rev. E 82, 036704 (tangent maps of splittings).

    Examples
    --------
    >>> tangent = fa.tangent_map(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=5.0, step=0.1)
    >>> np.linalg.det(tangent.matrix[:, :, 0]).round(9)
    np.float64(1.0)
    """
    options = Options(
        scheme, step, rtol=rtol, atol=atol, energy_tolerance=energy_tolerance, threads=threads, callback=callback
    )
    problem = Problem(model, z0, options)
    time = problem.iterates("time", time)
    flow, z, *_ = stable_plan(problem)
    start = carried(checked_deviations(deviation_vectors, flow.states(z)), flow.system, 1)
    flow = replace(flow, vectors=len(start))
    ensemble = flow.ensemble(z, start)
    with partial_result_on_interrupt("tangent_map", lambda: _assembled(flow, ensemble, time, options.drift)):
        flow.advance(ensemble, observers.nothing(), *no_memory(ensemble), time=time, observations=1, callback=callback)
    return _assembled(flow, ensemble, time, options.drift)


def _assembled(flow: Flow, ensemble: Ensemble, time: float, tolerance: float) -> TangentMap:
    """Return the orbits and vectors so far."""
    ensemble.status[(ensemble.status == Status.OK) & (ensemble.time < time * (1 - 1e-12))] = Status.INTERRUPTED
    error = energy_error(flow.system, ensemble)
    mark_drift(ensemble, error, tolerance)
    return TangentMap(
        z=flow.states(ensemble.points),
        vectors=ensemble.deviations[:, : flow.system.rows],
        t=ensemble.time,
        energy_error=error,
        status=ensemble.status,
        scheme=flow.scheme,
        step=flow.step,
        names=flow.system.row_names,
    )


def checked_deviations(deviation_vectors: Any, z: np.ndarray) -> np.ndarray:
    """Return tangent vectors (count, 2n, orbits) for the orbits z (2n, orbits): the unit vectors for None."""
    rows, orbits = z.shape
    given = np.eye(rows) if deviation_vectors is None else numbers("deviation_vectors", deviation_vectors)
    shapes = f"(count, {rows}) or (count, {rows}, {orbits})"
    if (
        given.ndim not in (2, 3)
        or given.shape[0] == 0
        or given.shape[1] != rows
        or given.shape[2:] not in ((), (orbits,))
    ):
        raise ValueError(f"deviation_vectors must have shape {shapes}, got {given.shape}")
    if not np.isfinite(given).all():
        raise ValueError("deviation_vectors must be finite")
    return np.array(np.broadcast_to(given.reshape(*given.shape[:2], -1), (given.shape[0], rows, orbits)))
