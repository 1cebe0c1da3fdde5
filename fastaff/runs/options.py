"""From options to a running flow: options are checked once, an open scheme or step is chosen, with the reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import Callback, numbers, positive, shown
from ..engine.threads import checked_threads
from ..systems.models.mechanics import System
from .accuracy import chosen_steps, round_down_to_grid
from .flow import Flow
from .requirements import (
    check_derivatives,
    check_given,
    check_needs,
    checked_scheme,
    checked_system,
    checked_tangent_system,
    current_system,
    phase_points,
    suited_scheme,
)
from .scales import MotionScales, motion, vector_rates
from .schemes.automatic import Automatic, CandidateTrial
from .schemes.catalogue import (
    BLANES_CASAS_ESCORIHUELA8,
    BLANES_MOAN6,
    DOP853,
    GAUSS8,
    GAUSS16,
    ITERATION,
    KAHAN_LI8,
    RKN12,
    Collocation,
    Nystrom,
    RungeKutta,
    Splitting,
)
from .schemes.time_transformed import TimeTransformed
from .time_transformed import prepared
from .trials import trials_in_time

ACCURACY = 1e-10
"""Accuracy of states where the user gives neither a step nor an accuracy."""

FINEST = 1e-15
"""Smallest accuracy that can be requested: several roundings of a double."""

STEP_ERROR = 1e-10
"""Error of states over 16 radians of the motion, in its amplitudes, for which functions without an accuracy choose
steps.
"""

BRIEFEST = 1e-290
"""Shortest time of a run, in units of the system: below it the inverse of a step may overflow."""

DRIFT = 1e-6
"""Energy error, over the largest kinetic energy met, above which an orbit drifts."""

DRIFTING = 10.0
"""Least multiple of the accuracy above which an orbit drifts: orbits within their accuracy have errors up to twice
that, at steep walls.
"""

COARSE = 1e-7
"""Error of states above which order 6 needs the fewest forces, also over hundreds of periods."""

DRIVEN = 1e-11
"""Accuracy for driven systems from which on RKN12 is taken if a second run determines the error at the end."""

NATURAL = 1e-12
"""The same for other systems. RKN12 is faster than a splitting from 1e-9 (driven) and 1e-12 (others) on, but takes some
seconds to compile for a model: it is not the default without an accuracy.
"""

FINE = 1e-11
"""Error of states down to which GAUSS8 is faster than GAUSS16, by the race of bench/nonseparable.py."""


@dataclass(frozen=True)
@inserts_parameters
class Options:
    """Check the options that all functions of orbits share.

    Parameters
    ----------
    scheme : Scheme, TimeTransformed or Automatic, optional
        Integration method. Default: the method that needs the fewest force evaluations for the accuracy; KAHAN_LI8, or
        GAUSS16 for H(q, p), with a step.
    step : float or ndarray, shape (orbits,), optional
        Largest fixed step size, one for all orbits or one for each; the first step of an adaptive method.
    accuracy : float, optional
        Requested error of the results, relative to the amplitudes of the motion, instead of a step.
    {rtol}
    {atol}
    {energy_tolerance}
    {threads}
    callback : callable, optional
        Function that is called with the completed fraction, about ten times a second.

    Raises
    ------
    TypeError
        If a value has a wrong type.
    ValueError
        If a value is out of range, or if both an accuracy and a step are given. Also if the scheme has no fixed steps
        for an accuracy.

    Examples
    --------
    >>> from fastaff.runs.options import Options, plan
    >>> options = Options(step=0.1, scheme=fa.LEAPFROG)
    >>> plan(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], options).flow.step
    0.1
    """

    scheme: Any = None
    step: float | np.ndarray | None = None
    accuracy: float | None = None
    rtol: float = 1e-12
    atol: float = 1e-12
    energy_tolerance: float | None = None
    threads: int | None = None
    callback: Callback | None = None

    def __post_init__(self) -> None:
        for name in ("rtol", "atol", "energy_tolerance"):
            if name != "energy_tolerance" or self.energy_tolerance is not None:
                object.__setattr__(self, name, positive(name, getattr(self, name)))
        object.__setattr__(self, "threads", checked_threads(self.threads))
        if isinstance(self.scheme, Automatic):
            if self.step is not None:
                raise ValueError(
                    f"step must be None with an automatic scheme, which chooses it; got {shown(self.step)}"
                )
        elif self.scheme is not None and not isinstance(self.scheme, TimeTransformed):
            checked_scheme(self.scheme)
        if self.accuracy is not None:
            object.__setattr__(self, "accuracy", self._checked_accuracy())

    @property
    def fixed(self) -> bool:
        """Whether the scheme takes equal steps in time, whose length may follow from an accuracy."""
        return not isinstance(self.scheme, TimeTransformed) and not getattr(self.scheme, "adaptive", False)

    @property
    def drift(self) -> float:
        """The energy error above which an orbit drifts."""
        return max(DRIFT, DRIFTING * (self.accuracy or 0.0)) if self.energy_tolerance is None else self.energy_tolerance

    def _checked_accuracy(self) -> float:
        value = positive("accuracy", self.accuracy)
        if value >= 1:
            raise ValueError(
                f"accuracy must be below 1, relative to the amplitudes of the motion, got {shown(self.accuracy)}"
            )
        if value < FINEST:
            raise ValueError(
                f"accuracy must be at least {FINEST:g}, as numbers have 16 digits, got {shown(self.accuracy)}"
            )
        if self.step is not None:
            raise ValueError(
                f"accuracy and step must not be given together, got accuracy={shown(self.accuracy, 24)} and "
                f"step={shown(self.step, 24)}"
            )
        if not self.fixed:
            name = getattr(self.scheme, "name", self.scheme)
            raise ValueError(
                f"accuracy must be None with the adaptive method {name}, got {shown(self.accuracy)}. Use rtol and atol."
            )
        return value

    def goal(self, default: float = ACCURACY) -> float | None:
        """Return the accuracy to reach by halving steps.

        Parameters
        ----------
        default : float, default 1e-10
            Accuracy if neither a step nor an accuracy is given.

        Returns
        -------
        float or None
            Accuracy. None if the user chose a step or a scheme that controls its steps.
        """
        if self.accuracy is None:
            return default if self.step is None and self.fixed else None
        return self.accuracy


def suited(options: Options, system: System) -> Options:
    """Return the options with the scheme that a kind of model needs; raises ValueError where they have another."""
    scheme = options.scheme
    got = "AUTO" if isinstance(scheme, Automatic) else str(getattr(scheme, "name", scheme))
    if isinstance(scheme, (Automatic, TimeTransformed)):
        check_needs(system, "a scheme by energy", got=got)
    if not (scheme is None or isinstance(scheme, (RungeKutta, Collocation))):
        check_needs(system, "a splitting", got=got)
    if system.canonical or system.iterated:
        return options
    scheme = DOP853 if scheme is None else scheme
    check_given(system, "an accuracy", accuracy=options.accuracy)
    options = replace(options, scheme=scheme)
    if options.fixed and options.step is None:
        check_needs(system, "a step of its own", got=scheme.name)
    return options


@dataclass(frozen=True)
class Problem:
    """The problem to run: a model, the starts of its orbits, and the options. A function of orbits makes it from its
    arguments and passes on this one value; it is checked in its `plan`, not before.
    """

    model: Any
    z0: Any
    options: Options
    system: System = field(init=False, repr=False, compare=False)
    """The model with its traits and mechanics, made here once."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "system", current_system(self.model))

    def iterates(self, name: str, count: Any) -> float:
        """Return a time: for a map a whole number of iterates, else any positive number."""
        number = positive(name, count)
        if self.system.iterated and number != math.floor(number):
            raise ValueError(f"{name} of a map must be a whole number of iterates, got {shown(count)}")
        if number < BRIEFEST:
            raise ValueError(f"{name} must be at least {BRIEFEST:g}, got {shown(count)}")
        return number

    def suited(self) -> Problem:
        """Return the same with the scheme that the kind of model needs."""
        return replace(self, options=suited(self.options, self.system))

    def plan(self, **how: Any) -> Plan:
        """Return the flow and states of the run, see `plan`."""
        return plan(self.model, self.z0, self.options, **how)


def cheapest(error: float, quadratic: bool) -> Splitting:
    """Return the splitting with the fewest forces for an error of states, for T quadratic in the momenta or not.

    Source: the race of bench/test_schemes.py, docs/explanation/schemes.md.
    """
    if not quadratic:
        return KAHAN_LI8
    return BLANES_MOAN6 if error >= COARSE else BLANES_CASAS_ESCORIHUELA8


def quickest(accuracy: float, driven: bool) -> Splitting | Nystrom:
    """Return the scheme that takes the least time for an accuracy of states at the end of a run, confirmed by a second
    run, for accelerations that depend on the coordinates, and on time, alone.

    Source: the race of bench/test_schemes.py, docs/explanation/schemes.md.
    """
    return RKN12 if accuracy <= (DRIVEN if driven else NATURAL) else cheapest(accuracy, quadratic=True)


def fastest(error: float) -> Collocation:
    """Return the collocation that takes the least time for an error of states, of H(q, p).

    Source: the race of bench/nonseparable.py.
    """
    return GAUSS8 if error >= FINE else GAUSS16


class Plan(NamedTuple):
    """Hold the flow and the initial states of a run.

    Attributes
    ----------
    flow : Flow
        Model with scheme and steps.
    z : ndarray, shape (2n, orbits)
        Initial states, a fresh array.
    why : str
        Reason for the scheme and the steps.
    motion : MotionScales or None
        Scales of the orbits, if their steps follow from these.
    """

    flow: Any
    z: np.ndarray
    why: str
    motion: MotionScales | None = None


@inserts_parameters
def plan(
    model: Any,
    z0: Any,
    options: Options,
    *,
    time: float | None = None,
    error: float | None = STEP_ERROR,
    transformed: bool = False,
) -> Plan:
    """Choose scheme and steps if the options leave them open, and return the flow.

    Parameters
    ----------
    {model}
    {z0}
    options : Options
        Options of the run.
    time : float, optional
        Length of the run. Chosen steps divide it; it affects the choice of a scheme.
    error : float or None, default 1e-10
        Error of states over 16 radians, for which the step of each orbit is chosen. None leaves the steps (infinite) to
        you.
    transformed : bool, default False
        True if the run supports a flow in a fictitious time; then give its `time`.

    Returns
    -------
    `Plan`
        Flow, initial states and the reason for the choice.

    Raises
    ------
    TypeError
        If an argument has a wrong type.
    ValueError
        If a value is out of range, or if the model does not support an option.

    Notes
    -----
    * A scheme, and the step in s of `TimeTransformed`, are chosen on about 64 orbits, evenly spaced in their order.
      They depend on the set of orbits.
    * A step in time depends on its orbit alone.

    Examples
    --------
    >>> from fastaff.runs.options import Options, plan
    >>> made = plan(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], Options(step=0.1, scheme=fa.LEAPFROG))
    >>> made.flow.scheme.name, made.z.shape
    ('LEAPFROG', (4, 1))
    """
    system = checked_system(model)
    z = phase_points("z0", z0, system)
    check_derivatives("model", system, z)
    if system.iterated:
        return _iterated(system, z, options)
    options = suited(options, system)
    scheme = options.scheme
    step = options.step
    threads = checked_threads(options.threads)
    why = []
    if isinstance(scheme, TimeTransformed):
        check_needs(system, "a fictitious time", got=scheme.name)
    if scheme is None:
        wanted = options.accuracy or error or ACCURACY
        scheme = KAHAN_LI8 if system.separable else GAUSS16
        if step is None:
            split = system.quadratic and "kicks" not in system.words
            scheme = cheapest(wanted, split) if system.separable else fastest(wanted)
            if error is None and system.separable and split and system.substep is None:
                scheme = quickest(wanted, system.driven)
            why.append(f"{scheme.name} for an accuracy of {wanted:.1e}")
    if isinstance(scheme, Automatic):
        every = transformed and system.substep is None and not system.driven
        chosen = _chosen(system, z, scheme if every else scheme.in_time, options, threads, time)
        scheme = chosen.scheme
        step = chosen.step if isinstance(chosen.scheme, TimeTransformed) else None
        why.append(f"{scheme.name} by trial: energy error {chosen.error:.1e}, {chosen.cost:.3g} forces per unit time")
    if transformed and isinstance(scheme, TimeTransformed):
        size = None if step is None else positive("step", step)
        timed, worst, _ = prepared(math.inf if time is None else time, system, z, scheme, size, threads)
        why.append(
            f"step {timed.step:.3g} in s" + ("" if math.isnan(worst) else f": energy error {worst:.1e} in a trial")
        )
        return Plan(timed, z, "; ".join(why))
    found = None
    fixed = math.inf if step is None else checked_step(step, z.shape[1])
    flow = Flow(system, suited_scheme(checked_scheme(scheme), system), fixed, options.rtol, options.atol, threads)
    if flow.adaptive:
        why.append(f"steps controlled by rtol {flow.rtol:g}, atol {flow.atol:g}")
    elif step is not None:
        why.append("the step given")
    elif error is None:
        why.append("each orbit's own step, for the accuracy")
    else:
        found = motion(system, z, flow.threads)
        steps = chosen_steps(flow, z, found, np.full(z.shape[1], error)).step
        flow = replace(flow, step=steps if time is None else round_down_to_grid(steps, time))
        why.append(f"each orbit's own step, for an error of {error:.1e} of its amplitudes over 16 radians")
    return Plan(flow, z, "; ".join(why), found)


def stable_plan(problem: Problem) -> Plan:
    """Return the plan of a run with tangent vectors, its flow as yet without them.

    A step that is chosen is stable for vectors in all directions, also those in which the orbits don't move.
    """
    system = checked_tangent_system(problem.model)
    found = problem.plan()
    if problem.options.step is None and found.flow.fixed:
        steps = np.minimum(found.flow.step, 1 / vector_rates(system, found.z))
        found = found._replace(flow=replace(found.flow, step=steps))
    return found


def _iterated(system: System, z: np.ndarray, options: Options) -> Plan:
    """Return the plan of a map, which has neither scheme nor step."""
    scheme = None if options.scheme is ITERATION else options.scheme
    given = {"scheme": scheme, "step": options.step, "accuracy": options.accuracy}
    check_given(system, "a time", "a map is iterated as it is", **given)
    threads = checked_threads(options.threads)
    flow = Flow(system, ITERATION, 1.0, options.rtol, options.atol, threads)
    return Plan(flow, z, "a map, iterated as it is")


def _chosen(
    system: System, z: np.ndarray, scheme: Automatic, options: Options, threads: int, time: float | None
) -> CandidateTrial:
    """Return the trial that an automatic scheme chooses for a run over `time`."""
    scheme = scheme.suited(system.quadratic)
    tried = trials_in_time(system, z, scheme, options.rtol, options.atol, threads, time)
    for candidate in scheme.candidates:
        if isinstance(candidate, TimeTransformed):
            flow, error, cost = prepared(
                math.inf if time is None else time, system, z, candidate, None, threads, scheme.bound
            )
            tried.append(CandidateTrial(flow.scheme, flow.step, error, cost))
    return scheme.choose(tried)


def checked_step(step: Any, orbits: int) -> float | np.ndarray:
    """Return `step` as a positive number, or as a fresh array of one for each orbit."""
    if not isinstance(step, (list, tuple, np.ndarray)) or (isinstance(step, np.ndarray) and step.ndim == 0):
        return positive("step", step)
    try:
        steps = np.array(numbers("step", step))
    except (TypeError, ValueError):
        raise TypeError(f"step must be a number or an array of numbers, got {type(step).__name__}") from None
    if steps.shape != (orbits,) or not (np.isfinite(steps) & (steps > 0)).all():
        raise ValueError(
            f"step must be a positive number or one for each of {orbits} orbits, got {shown(step)} of shape "
            f"{steps.shape}"
        )
    return steps
