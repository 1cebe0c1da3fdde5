"""The analyses of each orbit and their options: the tables [options], [poincare], [frequency_map], ... of a job."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ..chaos.chaos_map import chaos_map
from ..chaos.indicators import INDICATORS, indicator_names
from ..core.docstrings import inserts_parameters
from ..core.names import named, spelled
from ..core.numbers import nonnegative, positive, whole
from ..frequencies.frequency_map import frequency_map
from ..runs.integrate import integrate, sample_times
from ..runs.scales import typical_rate
from ..runs.schemes.catalogue import SCHEMES, VERNER9
from ..sections.poincare_map import poincare_map
from ..systems.formulas.number import number
from ..systems.models.mechanics import System
from ..systems.models.sections import Stroboscopic
from ..tori.action_angles import action_angles
from .wording import OptionError, option


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How to integrate."""

    accuracy: float | None = None
    """Tolerance, relative to the size of the orbit. Not for chaos maps. [1e-10; 1e-11 for frequencies]"""
    scheme: str | None = None
    """LEAPFROG, YOSHIDA4, BLANES_MOAN6, BLANES_CASAS_ESCORIHUELA8, KAHAN_LI8, SOFRONIOU_SPALETTA8,
    SOFRONIOU_SPALETTA10, RKN12, RK4, GAUSS8, GAUSS16, DOP853 and VERNER9 (both adaptive). [the cheapest for the
    accuracy; KAHAN_LI8 with a step]
    """
    step: float | None = None
    """Fixed step. [chosen for each orbit by a short trial]"""
    threads: int | None = None
    """Threads. [all cores]"""

    def scheme_value(self) -> Any:
        """Return the integration method.

        Returns
        -------
        Scheme
            The method, or None if it is not given.
        """
        return None if self.scheme is None else SCHEMES[named(option("scheme"), self.scheme, SCHEMES)]

    def canonical(self) -> RunOptions:
        """Return the options with the canonical name of the method.

        Returns
        -------
        RunOptions
            The options.
        """
        if self.scheme is None:
            return self
        name = spelled(self.scheme, SCHEMES)
        if self.accuracy is not None and getattr(SCHEMES.get(name), "adaptive", False):
            raise OptionError.of("{accuracy} must be left out with the adaptive method {method}", method=name)
        return replace(self, scheme=name)

    def on(self, threads: int | None) -> RunOptions:
        """Return the options with another number of threads.

        Parameters
        ----------
        threads : int, optional
            Number of threads. None keeps the options.

        Returns
        -------
        RunOptions
            The options.
        """
        return self if threads is None else replace(self, threads=threads)

    def build(self, system: System | None = None) -> dict[str, Any]:
        """Return the options as arguments of the library functions.

        Parameters
        ----------
        system : object, optional
            System of the job. For a map only the threads are returned.

        Returns
        -------
        dict
            Arguments by name.
        """
        if system is not None and system.iterated:
            return {"threads": self.threads}
        accuracy = {} if self.accuracy is None else {"accuracy": positive("accuracy", self.accuracy)}
        return {**accuracy, "scheme": self.scheme_value(), "step": self.step, "threads": self.threads}


class AnalysedOrbits(NamedTuple):
    """Orbits to be analysed: those of a system that start at z0 (2n, orbits), with a section or None."""

    system: System
    section: Any
    z0: np.ndarray

    @property
    def model(self) -> Any:
        """The model."""
        return self.system.model


class Analysis(Protocol):
    """One table of a job: an analysis of each orbit."""

    title: ClassVar[str]
    """For people."""
    brief: ClassVar[dict[str, Any]]
    """Settled options of the smallest case, which compiles the kernels of the others."""

    def check(self, run: RunOptions) -> None:
        """Refuse values that are wrong for any orbits."""

    def resolve_defaults(self, few: AnalysedOrbits, run: RunOptions) -> dict[str, Any]:
        """Return the options of the library's function; a trial with a few orbits settles those that were left open."""

    def compute(self, orbits: AnalysedOrbits, resolved: dict[str, Any], run: RunOptions, callback: Any = None) -> Any:
        """Return the result of orbits."""


@dataclass(frozen=True, kw_only=True)
class PoincareOptions:
    """Crossings of the section."""

    title: ClassVar[str] = "section"
    brief: ClassVar[dict[str, Any]] = {"crossings": 1, "max_time": 20.0}

    crossings: int = 500
    """Crossings wanted from each orbit. [500]"""
    max_time: float | None = None
    """Time at which an orbit ends at the latest. [four times that of the crossings in a trial]"""

    @inserts_parameters
    def check(self, run: RunOptions) -> None:
        """Check the values that do not depend on the orbits.

        {job_check}
        """
        whole("crossings", self.crossings, 1)
        if self.max_time is not None:
            positive("max_time", self.max_time)

    @inserts_parameters
    def resolve_defaults(self, few: AnalysedOrbits, run: RunOptions) -> dict[str, Any]:
        """Return the options of the library function, with defaults from a trial.

        {job_trial}

        Returns
        -------
        dict
            Options ``crossings`` and ``max_time``.
        """
        self.check(run)
        time = self.max_time
        if isinstance(few.section, Stroboscopic) and time is not None:
            raise OptionError.of("{max_time} must be left out with a section of constant t")
        if isinstance(few.section, Stroboscopic) or few.system.iterated:
            return {"crossings": self.crossings}
        if time is None:
            pace = return_times(*few, run.build())
            if np.isnan(pace).all():  # for example with a long step
                pace = return_times(*few, {"scheme": VERNER9, "threads": run.threads})
            time = enough_time(pace, few.section, self.crossings)
        return {"crossings": self.crossings, "max_time": float(time)}

    @inserts_parameters
    def compute(self, orbits: AnalysedOrbits, resolved: dict[str, Any], run: RunOptions, callback: Any = None) -> Any:
        """Compute the analysis of orbits.

        {job_orbits}

        Returns
        -------
        SectionMap
            Result of the orbits.
        """
        if isinstance(orbits.section, Stroboscopic) or orbits.system.iterated:  # these need no time
            resolved = {"crossings": resolved["crossings"]}
        how = {**resolved, **run.build(orbits.system)}
        return poincare_map(orbits.model, orbits.z0, section=orbits.section, callback=callback, **how)


@dataclass(frozen=True, kw_only=True)
class FrequencyOptions:
    """Fundamental frequencies."""

    title: ClassVar[str] = "frequencies"
    brief: ClassVar[dict[str, Any]] = {"time": 64.0}

    time: float | None = None
    """Time over which frequencies are averaged, best 100 periods or more. [1000]"""
    returns: float | None = None
    """That time in median times of return to the section, instead of --time."""

    @inserts_parameters
    def check(self, run: RunOptions) -> None:
        """Check the values that do not depend on the orbits.

        {job_check}
        """
        _one_time(self.time, self.returns)

    @inserts_parameters
    def resolve_defaults(self, few: AnalysedOrbits, run: RunOptions) -> dict[str, Any]:
        """Return the options of the library function, with defaults from a trial.

        {job_trial}

        Returns
        -------
        dict
            Options ``time``.
        """
        self.check(run)
        if self.returns is None:
            return {"time": 1000.0 if self.time is None else float(self.time)}
        return {"time": self.returns * median_return(few, run.build())}

    @inserts_parameters
    def compute(self, orbits: AnalysedOrbits, resolved: dict[str, Any], run: RunOptions, callback: Any = None) -> Any:
        """Compute the analysis of orbits.

        {job_orbits}

        Returns
        -------
        FrequencyMap
            Result of the orbits.
        """
        return frequency_map(orbits.model, orbits.z0, callback=callback, **resolved, **run.build(orbits.system))


@dataclass(frozen=True, kw_only=True)
class ChaosOptions:
    """Indicators of chaos."""

    title: ClassVar[str] = "chaos"
    brief: ClassVar[dict[str, Any]] = {"time": 1.0}

    time: float | None = None
    """Time of every orbit."""
    returns: float | None = None
    """Time of every orbit in median times of return to the section, instead of --time; fewer call weak chaos regular.
    [500]
    """
    indicators: str = "megno,sali"
    """Names, with commas: megno, sali, gali_2 ... gali_8, fli, ofli, lyapunov, spectrum, weighted_birkhoff,
    frequency_diffusion, zero_one_test, reversibility_error. [megno,sali]
    """
    early_stop: bool = False
    """End an orbit when all indicators have called it chaotic."""

    def values(self) -> tuple[Any, ...]:
        """Return the indicators.

        Returns
        -------
        tuple
            Indicators of chaos.
        """
        return tuple(INDICATORS[name] for name in indicator_names(self.indicators, option("indicators")))

    def canonical(self) -> ChaosOptions:
        """Return the options with canonical names of the indicators.

        Returns
        -------
        ChaosOptions
            The options.
        """
        names = (spelled(name.strip(), INDICATORS) for name in self.indicators.split(","))
        return replace(self, indicators=",".join(names))

    def in_returns(self) -> float | None:
        """Return the length of an orbit in return times.

        Returns
        -------
        float
            Length, or None if the time is given.
        """
        if self.time is not None:
            return None
        if self.returns is None:
            return 500.0
        return float(self.returns)

    @inserts_parameters
    def check(self, run: RunOptions) -> None:
        """Check the values that do not depend on the orbits.

        {job_check}
        """
        self.values()
        _one_time(self.time, self.returns)
        if run.accuracy is not None:
            raise OptionError.of("{accuracy} does not belong to chaos maps, which take {step} or choose one")

    @inserts_parameters
    def resolve_defaults(self, few: AnalysedOrbits, run: RunOptions) -> dict[str, Any]:
        """Return the options of the library function, with defaults from a trial.

        {job_trial}

        Returns
        -------
        dict
            Options ``time`` and indicators.
        """
        self.check(run)
        number = self.in_returns()
        if number is None:
            return {"time": float(self.time)}  # type: ignore[arg-type]
        # Step control gets through steep walls.
        return {"time": number * median_return(few, {"scheme": VERNER9, "threads": run.threads})}

    @inserts_parameters
    def compute(self, orbits: AnalysedOrbits, resolved: dict[str, Any], run: RunOptions, callback: Any = None) -> Any:
        """Compute the analysis of orbits.

        {job_orbits}

        Returns
        -------
        ChaosMap
            Result of the orbits.
        """
        how: dict[str, Any] = {"indicators": self.values(), "early_stop": self.early_stop}
        return chaos_map(orbits.model, orbits.z0, callback=callback, **how, **resolved, **run.build(orbits.system))


@dataclass(frozen=True, kw_only=True)
class ActionAngleOptions:
    """Actions and angles of a separable system."""

    title: ClassVar[str] = "actions"
    brief: ClassVar[dict[str, Any]] = {}

    def check(self, run: RunOptions) -> None:
        """Check nothing: there are no options.

        Parameters
        ----------
        run : RunOptions
            Options of the integration.
        """

    @inserts_parameters
    def resolve_defaults(self, few: AnalysedOrbits, run: RunOptions) -> dict[str, Any]:
        """Return the options of the library function, with defaults from a trial.

        {job_trial}

        Returns
        -------
        dict
            Empty, because there are no options.
        """
        return {}

    @inserts_parameters
    def compute(self, orbits: AnalysedOrbits, resolved: dict[str, Any], run: RunOptions, callback: Any = None) -> Any:
        """Compute the analysis of orbits.

        {job_orbits}

        Returns
        -------
        ActionAngles
            Result of the orbits.
        """
        return action_angles(orbits.model, orbits.z0, threads=run.threads, callback=callback)


@dataclass(frozen=True, kw_only=True)
class IntegrateOptions:
    """Orbits up to a time, with samples of them."""

    title: ClassVar[str] = "orbits"
    brief: ClassVar[dict[str, Any]] = {"time": 1.0, "samples": 0}

    time: float
    """Time of every orbit."""
    samples: int | str = 0
    """States that are kept: their number at equal times, or their times, such as 0:0.1:1:10. [0: the last one only]"""

    @inserts_parameters
    def check(self, run: RunOptions) -> None:
        """Check the values that do not depend on the orbits.

        {job_check}
        """
        nonnegative("time", self.time)
        sample_times(_given_samples(self.samples), self.time)

    @inserts_parameters
    def resolve_defaults(self, few: AnalysedOrbits, run: RunOptions) -> dict[str, Any]:
        """Return the options of the library function, with defaults from a trial.

        {job_trial}

        Returns
        -------
        dict
            Options ``time`` and, unless the job has their times, ``samples``.
        """
        self.check(run)
        sample_times(_given_samples(self.samples), self.time, few.system.iterated)
        settled: dict[str, Any] = {"time": float(self.time)}
        return settled if isinstance(self.samples, str) else {**settled, "samples": self.samples}

    @inserts_parameters
    def compute(self, orbits: AnalysedOrbits, resolved: dict[str, Any], run: RunOptions, callback: Any = None) -> Any:
        """Compute the analysis of orbits.

        {job_orbits}

        Returns
        -------
        Orbits
            Result of the orbits.
        """
        how = {"samples": _given_samples(self.samples), **resolved, **run.build(orbits.system)}
        return integrate(orbits.model, orbits.z0, callback=callback, **how)


def _given_samples(samples: int | str) -> int | list[float]:
    """Return a number of samples, or their times."""
    return [number("samples", entry) for entry in samples.split(":")] if isinstance(samples, str) else samples


ANALYSES: dict[str, type[Any]] = {
    "poincare": PoincareOptions,
    "frequency_map": FrequencyOptions,
    "chaos_map": ChaosOptions,
    "action_angles": ActionAngleOptions,
    "integrate": IntegrateOptions,
}
"""Tables of a job that name its analyses, in the order of their computation."""

TRIAL = 64
"""Orbits of a trial, which settles the options that are left open."""


def return_times(system: System, section: Any, z0: np.ndarray, choices: dict[str, Any]) -> np.ndarray:
    """Return the mean time between crossings of each of a few orbits, NaN where there are none."""
    few = np.ascontiguousarray(z0[:, :: -(-z0.shape[1] // TRIAL)])
    if isinstance(section, Stroboscopic) or system.iterated:
        return np.full(few.shape[1], 1.0 if section is None else float(system.model.period))
    loose = {name: value for name, value in choices.items() if name != "accuracy"}
    found = poincare_map(
        system.model, few, section=section, crossings=16, max_time=300.0 / typical_rate(system, few), **loose
    )
    return np.array([t[n - 1] / n if n else np.nan for t, n in zip(found.times.T, found.counts)])


def enough_time(pace: np.ndarray, section: Any, crossings: int) -> float:
    """Return four times the time that the median orbit needs for the crossings."""
    if np.isnan(pace).all():
        text = "no orbit of a trial crosses {section!r}; give {max_time}, or another section or direction"
        raise OptionError.of(text, section=section)
    return float(4.0 * np.nanmedian(pace) * (crossings + 4))


def median_return(few: AnalysedOrbits, choices: dict[str, Any]) -> float:
    """Return the median time of return to the section."""
    if few.section is None and not few.system.iterated:
        raise OptionError.of("{returns} needs a section; give {time}")
    pace = return_times(*few, choices)
    if np.isnan(pace).all():
        text = "no orbit of a trial returns to {section!r}; give {time}, or another section or direction"
        raise OptionError.of(text, section=few.section)
    return float(np.nanmedian(pace))


def _one_time(time: float | None, returns: float | None) -> None:
    """Refuse a time and returns together, and values that are not positive."""
    if time is not None and returns is not None:
        raise OptionError.of("give {time} or {returns}, not both")
    for name, value in (("time", time), ("returns", returns)):
        if value is not None:
            positive(name, value)
