"""Chaos maps: indicators of many orbits in one pass, and the classification that they give together."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.classification import Classification
from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, Passes, flag, listed, portion, shown, whole
from ..core.status import Status, describe
from ..engine.kernels.readings import LN10
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.result import Result, along, put
from ..runs.flow import Flow, energy_error, mark_drift
from ..runs.options import Options, Problem, stable_plan
from ..runs.requirements import checked_system
from ..runs.schemes.catalogue import Scheme, scheme_of
from ..runs.starts import starts_of
from ..systems.models.contracts import Dynamics
from .indicator import MANY, Indicators, IndicatorStyle, checked_indicators, judged, refuse
from .indicators import MEGNO, SALI, indicators_of
from .shares import Shares
from .streamed import ChaosRun, own_rates


@dataclass(frozen=True)
class ChaosMap(Result):
    """Values of chaos indicators, and classification of orbits by them.

    Attributes
    ----------
    names : tuple of str
        Names of the indicators. ``result["megno"]`` and ``result.megno`` are the row of that name.
    values : ndarray, shape (indicators, orbits)
        Values of the indicators.
    thresholds : ndarray, shape (indicators, orbits)
        Thresholds of each orbit, by its natural frequency.
    classifications : ndarray of int, shape (indicators, orbits)
        `Classification` by each indicator: REGULAR, CHAOTIC or UNDECIDED.
    classification : ndarray of int, shape (orbits,)
        `Classification` by all decided indicators. UNDECIDED if they disagree, if none is decided, or for failed
        orbits.
    suggested_time : ndarray, shape (orbits,)
        Time that may decide UNDECIDED orbits, NaN for others.
    detection_time : ndarray, shape (indicators, orbits)
        Time at which an indicator of deviation vectors first passed its threshold, NaN if it did not.
    spectrum : ndarray, shape (2n, orbits), or None
        Lyapunov exponents per unit time, the largest first, if they were requested.
    spectrum_error : ndarray, shape (2n, orbits), or None
        Error estimates: 99 % of the exponents of infinite runs are within them.
    history : ndarray, shape (indicators, records, orbits)
        Values during the run; NaN after the end of an orbit and for indicators without history.
    history_times : ndarray, shape (records, orbits)
        Times of the records.
    t : ndarray, shape (orbits,)
        Time that each orbit reached.
    energy_error : ndarray, shape (orbits,)
        Largest energy error, relative to the largest kinetic energy.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit.
    time : float
        Length of the run.
    scheme : Scheme
        Integration method.
    step : float or ndarray, shape (orbits,)
        Step size, in units of time: one for each orbit if it was chosen, inf for an adaptive method.
    period : float or None
        Drive period of a driven system, the unit of `spectrum_per_period`.
    """

    names: tuple[str, ...]
    values: Annotated[np.ndarray, along("indicator", "orbit", labels="names", plain=True)]
    thresholds: Annotated[np.ndarray, along("indicator", "orbit", labels="names")]
    classifications: Annotated[np.ndarray, along("indicator", "orbit", labels="names")]
    classification: Annotated[np.ndarray, along("orbit")]
    suggested_time: Annotated[np.ndarray, along("orbit", unit="time")]
    detection_time: Annotated[np.ndarray, along("indicator", "orbit", unit="time", labels="names")]
    spectrum: Annotated[np.ndarray | None, along("exponent", "orbit", unit="1/time")]
    spectrum_error: Annotated[np.ndarray | None, along("exponent", "orbit", unit="1/time")]
    history: Annotated[np.ndarray, along("indicator", "record", "orbit", labels="names")]
    history_times: Annotated[np.ndarray, along("record", "orbit", unit="time")]
    t: Annotated[np.ndarray, along("orbit", unit="time")]
    energy_error: Annotated[np.ndarray, along("orbit", unit="largest kinetic energy")]
    status: Annotated[np.ndarray, along("orbit")]
    time: float
    scheme: Scheme
    step: Annotated[float | np.ndarray, along("orbit", unit="time")]
    period: float | None = None
    _styles: tuple[IndicatorStyle, ...] = ()

    def __getattr__(self, name: str) -> np.ndarray:
        """Return the values of the indicator of that name."""
        names = self.__dict__.get("names", ())
        if name in names:
            return self.values[names.index(name)]
        raise AttributeError(f"ChaosMap has no {shown(name)}; its indicators are {listed(names)}")

    @property
    def chaotic(self) -> np.ndarray:
        """Mask of the chaotic orbits, shape (orbits,)."""
        return self.classification == Classification.CHAOTIC

    @property
    def regular(self) -> np.ndarray:
        """Mask of the orbits that are regular as far as the run shows, shape (orbits,)."""
        return self.classification == Classification.REGULAR

    @property
    def undecided(self) -> np.ndarray:
        """Mask of the undecided orbits that did not fail, shape (orbits,)."""
        return (self.classification == Classification.UNDECIDED) & (self.status == Status.OK)

    @property
    def disagree(self) -> np.ndarray:
        """Mask of the orbits that are chaotic by one indicator and regular by another, shape (orbits,).

        Sticky orbits are an example.
        """
        chaotic = (self.classifications == Classification.CHAOTIC).any(axis=0)
        regular = (self.classifications == Classification.REGULAR).any(axis=0)
        return chaotic & regular & self.undecided

    @property
    def spectrum_per_period(self) -> np.ndarray | None:
        """Lyapunov exponents of the stroboscopic map, shape (2n, orbits), per drive period.

        They are ``spectrum`` times the drive period; None if either is missing.
        """
        return None if self.spectrum is None or self.period is None else self.spectrum * self.period

    @property
    def shares(self) -> Shares:
        """Numbers of orbits of each class that did not fail, with the chaotic fraction and its bounds, as `Shares`."""
        fine = self.status == Status.OK
        kinds = (self.chaotic, self.regular, self.undecided)
        return Shares(*(np.count_nonzero(kind & fine) for kind in kinds))  # type: ignore[arg-type]

    @property
    def fraction(self) -> float:
        """Fraction of chaotic orbits among the decided ones; NaN if there are none."""
        return float(self.shares.fraction)

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits and the numbers of each class.

        Returns
        -------
        str
            Summary.
        """
        kinds = {"regular": self.regular, "chaotic": self.chaotic, "undecided": self.undecided}
        parts = [describe(self.status, kinds)]
        if self.shares.completed > 1:
            parts.append(self.shares.fraction_text())
        if self.undecided.any():
            parts.append(f"time {np.nanmedian(self.suggested_time[self.undecided]):.3g} may decide")
        return "; ".join(parts)


DEFAULT = (MEGNO(), SALI())
"""Indicators of `chaos_map`; a map of one variable has a single deviation vector, hence the first alone."""


@coerces_arguments(z0=starts_of, scheme=scheme_of, indicators=indicators_of)
@records_call
@inserts_parameters
def chaos_map(
    model: Dynamics,
    z0: Starts,
    *,
    time: float,
    indicators: Indicators = DEFAULT,
    history: int = 0,
    early_stop: bool = False,
    deviation_vectors: ArrayLike | None = None,
    step: float | np.ndarray | None = None,
    scheme: Scheme | str | None = None,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    energy_tolerance: float | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> ChaosMap:
    """Classify orbits as regular or chaotic by one or more indicators.

    Parameters
    ----------
    {model}
    {z0}
    time : float
        Length of the run, in units of time; for a map the number of iterates. Orbits shorter than 100 natural periods
        are never classified as regular.
    {indicators}
    history : int, default 0
        Number of equally spaced times at which the indicators of deviation vectors are recorded. With an adaptive
        method, each record is at the first step after its time.
    {early_stop}
    deviation_vectors : array_like, shape (count, 2n) or (count, 2n, orbits), optional
        Initial deviation vectors, linearly independent, of any length. Default: columns of a fixed random matrix that
        is symplectic and orthogonal.
    step : float or array_like, shape (orbits,), optional
        Fixed step size, in units of time, reduced to a whole fraction of the run. Default: chosen for each orbit, and
        halved up to twice if its energy error exceeds `energy_tolerance`. For an adaptive method it is the first
        step.
    {tangent_scheme}
    {rtol}
    {atol}
    {plain_energy_tolerance}
    {threads}
    {callback}

    Returns
    -------
    `ChaosMap`
        Values and thresholds of the indicators, and the classification of each orbit.

    Raises
    ------
    ValueError
        If a value is out of its range, or an indicator is not supported for the model.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the orbits finished so far in ``.partial``.

    Notes
    -----
    - Method: one run with deviation vectors that all indicators share. The derivative of the integration method moves
      them. They are made orthonormal about once per radian of the motion. Results do not depend on units.
    - Classification: deviation vectors prove chaos only if the growth is lasting. Without the three eighths of the run
      with most growth, the longest vector must still grow tenfold.
    - Never chaotic: orbits at rest, and autonomous systems of one degree of freedom.
    - Maps: one iterate counts as one radian. OFLI and ReversibilityError are not supported. For one variable
      the default is MEGNO alone.
    - Cost, in integrations without vectors: :math:`1.3 (1 + k)` for k vectors, 1 more for averages, 15 for
      FrequencyDiffusion.
    - Memory: :math:`2(k^2 + nk + n)` numbers an orbit.

    See the explanation page on classification.

    References
    ----------
    Skokos & Manos 2016, Lect. Notes Phys. 915, 129 (review); each indicator names its own.

    Examples
    --------
    >>> chaos = fa.chaos_map(fa.models.StandardMap(1.3), [[3.1, 0.1], [0.2, 0.0]], time=2000)
    >>> chaos.regular, chaos.chaotic
    (array([ True, False]), array([False,  True]))
    """
    options = Options(
        scheme, step, rtol=rtol, atol=atol, energy_tolerance=energy_tolerance, threads=threads, callback=callback
    )
    problem = Problem(model, z0, options)
    time = problem.iterates("time", time)
    system = checked_system(model)
    usual = DEFAULT[:1] if system.rows == 1 and indicators == DEFAULT else indicators
    chosen = checked_indicators(usual, system)
    slots = whole("history", history, 0)
    tangent = [entry for entry in chosen if entry.vectors(system.moving)]
    if flag("early_stop", early_stop) and len(tangent) < len(chosen):
        rest = listed([entry.name for entry in chosen if entry not in tangent])
        raise ValueError(f"early_stop must be False with {rest}, got True. Use 'megno,sali', GALI or FLI.")
    plan = stable_plan(problem) if tangent else problem.plan()
    flow = plan.flow
    z = plan.z
    rates = own_rates(plan, time)
    for k, entry in enumerate(chosen):  # a scheme may be chosen by trial
        refuse(f"indicators[{k}]", entry, system, flow)

    def mapped(flow: Flow, orbits: Any, deviation_vectors: Any, callback: Callback | None) -> ChaosMap:
        start = z[:, orbits]
        own = rates[orbits]
        work = ChaosRun(
            flow, start, own, time, chosen, slots=slots, early_stop=early_stop, deviation_vectors=deviation_vectors
        )
        with partial_result_on_interrupt("chaos_map", lambda: _result(work, options.drift, True)):
            for number, run in enumerate(work.passes):
                run(portion(callback, number, len(work.passes)))
        return _result(work, options.drift, False)

    with Passes(callback) as passes:
        found = mapped(flow, slice(None), deviation_vectors, passes.take(1.0, DRIFTING))
        for halving in range(1, 1 + (HALVINGS if step is None and flow.fixed else 0)):
            drifted = np.flatnonzero(found.status == Status.ENERGY_DRIFT)
            if drifted.size:
                shorter = flow.of(drifted)
                shorter = replace(shorter, step=shorter.step / 2**halving)
                told = passes.take(1.0, 0.5)
                with partial_result_on_interrupt("chaos_map", functools.partial(_unfinished, found, drifted)):
                    put(found, drifted, mapped(shorter, drifted, _of_orbits(deviation_vectors, drifted), told))
        return found


DRIFTING = 0.02
"""Work of orbits whose energy drifts, relative to that of all."""

HALVINGS = 2
"""Number of halvings of a step that a trial chose if the orbit's energy still drifts, as the orbit came later to
steeper forces.
"""


def _unfinished(found: ChaosMap, orbits: np.ndarray) -> ChaosMap:
    """Return the map with these orbits marked as unfinished."""
    status = found.status.copy()
    status[orbits] = Status.INTERRUPTED
    return replace(found, status=status)


def _of_orbits(deviation_vectors: Any, orbits: np.ndarray) -> Any:
    """Return the tangent vectors at the start of some orbits, where each has its own."""
    given = None if deviation_vectors is None else np.asarray(deviation_vectors, float)
    return given[..., orbits] if given is not None and given.ndim == 3 and given.shape[2] > 1 else given


def _result(work: ChaosRun, tolerance: float, unfinished: bool) -> ChaosMap:
    """Assemble the map, where `unfinished` of the passes that were done."""
    ensemble = work.ensemble
    if unfinished:
        ensemble.status[(ensemble.status == Status.OK) & ~np.isfinite(work.values).all(axis=0)] = Status.INTERRUPTED
    reached = ensemble.time if work.streams else np.where(ensemble.status == Status.OK, work.time, 0.0)
    error = energy_error(work.flow.system, ensemble)
    mark_drift(ensemble, error, tolerance)
    detection_time, history, times = work.records()
    by_detection = work.early_stop & np.isfinite(detection_time).all(axis=0)
    ensemble.status[(reached < work.time * (1 - 1e-12)) & (ensemble.status == Status.OK) & ~by_detection] = (
        Status.INTERRUPTED
    )
    sound = np.isin(ensemble.status, (Status.OK, Status.INTERRUPTED))
    phase = work.rates * reached
    classifications = np.array(
        [
            judged(*each, phase, work.n)
            for each in zip(work.chosen, work.values, work.before, work.thresholds, strict=True)
        ]
    )
    classifications[:, by_detection] = Classification.CHAOTIC
    chaotic = classifications == Classification.CHAOTIC
    followed = np.array([bool(entry.vectors(work.n)) for entry in work.chosen])
    unproved = followed[:, None] & ~(work.lasting() | by_detection) | work.rests()
    classifications[chaotic & unproved] = Classification.UNDECIDED
    if work.planar:
        classifications[chaotic & (phase >= 2 * np.pi * MANY)] = Classification.REGULAR
        classifications[chaotic & (phase < 2 * np.pi * MANY)] = Classification.UNDECIDED
    classifications[:, ~sound] = Classification.UNDECIDED
    classification = _together(classifications)
    needed = np.max([2 * np.pi * max(MANY, entry.least) for entry in work.chosen]) / work.rates
    suggested_time = np.where(
        (classification == Classification.UNDECIDED) & sound, np.maximum(needed, 4 * work.time), np.nan
    )
    spectrum, spectrum_error = work.exponents()
    # Exponents are read as decades of growth.
    rates = np.array([entry.rate for entry in work.chosen])[:, None]
    with np.errstate(all="ignore"):
        values = np.where(rates, work.values * (LN10 / reached), work.values)
        history = np.where(rates[:, :, None], history * (LN10 / times), history)
    return ChaosMap(
        names=tuple(entry.name for entry in work.chosen),
        values=values,
        thresholds=np.where(rates, work.thresholds * LN10 / work.time, work.thresholds),
        classifications=classifications,
        classification=classification,
        suggested_time=suggested_time,
        detection_time=detection_time,
        spectrum=spectrum,
        spectrum_error=spectrum_error,
        history=history,
        history_times=times,
        t=work.lived if work.streams else reached,
        energy_error=error,
        status=ensemble.status,
        time=work.time,
        scheme=work.flow.scheme,
        step=work.flow.step,
        period=float(work.flow.model.period) if work.flow.system.driven else None,
        _styles=tuple(IndicatorStyle.of(entry) for entry in work.chosen),
    )


def _together(classifications: np.ndarray) -> np.ndarray:
    """Return the common classification of the decided ones among classifications (indicators, orbits), else
    UNDECIDED.
    """
    chaotic = (classifications == Classification.CHAOTIC).any(axis=0)
    regular = (classifications == Classification.REGULAR).any(axis=0)
    return np.where(
        chaotic == regular, Classification.UNDECIDED, np.where(chaotic, Classification.CHAOTIC, Classification.REGULAR)
    )
