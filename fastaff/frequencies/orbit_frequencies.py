"""Fundamental frequencies of orbits computed by other programs, from their samples in time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, checked_callback, shown, whole
from ..core.status import Status
from ..engine.threads import checked_threads
from ..results.calls import coerces_arguments
from ..results.progress import says_progress
from ..runs.given_orbits import Given, GivenOrbits, ends, given_orbits, lengths
from ..runs.requirements import checked_model
from ..systems.models.contracts import Angles, Dynamics
from .angle_loops import Plain, SignalLayout, named_signals, suited
from .found_frequencies import FrequencyTable
from .frequencies import FrequencyMap
from .frequency_map import checked_signals
from .fundamental import fastest, values
from .kernels.loops import Loops
from .readings import SampledOrbits, read
from .signals import BUFFERS, ReusableBuffer, Signals, signals_of
from .windows import cosine_window

LEAST = 64
"""Least number of samples of an orbit."""

AT_ONCE = 256
"""Loops whose spectra show noise at once."""

BUDGET = 1 << 27
"""Bytes of samples in work at once."""

ENOUGH = 1024
"""Samples whose spectrum shows noise."""

QUARTER = 0.25
"""Share of the bins that are below the level of noise."""

NOISE = 4.6
"""Three standard deviations of a frequency, for the weight of averages, in units of
noise/(amplitude time sqrt(samples)).
"""

COARSE = 1.5
"""Root mean square of second over first differences of a coordinate, beyond which samples may pass for slower motion:
that of a line with three and a half samples a period.
"""


@coerces_arguments(signals=named_signals)
@says_progress
@inserts_parameters
def orbit_frequencies(
    samples: Given,
    dt: float | None = None,
    *,
    times: ArrayLike | None = None,
    coordinates: str | Sequence[str] | None = None,
    model: Dynamics | None = None,
    signals: Angles | str | None = None,
    lines: int | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> FrequencyMap:
    """Compute the fundamental frequencies of orbits that are given as samples in time.

    Parameters
    ----------
    samples : array_like, shape (2n, orbits, samples) or (2n, samples)
        Rows q1, ..., qn, p1, ..., pn, with 64 samples or more, NaN after the end of an orbit. Also accepted:

        - `Orbits` with samples, or their ``samples`` as they are;
        - an array of xarray, with dimensions in any order;
        - a data set of an HDF5 or Zarr file, read in parts;
        - with `coordinates`, arrays of shape (orbits, samples) by name (a mapping, a Dataset, a group of a file), or a
          table of pandas, polars or Astropy with a row for each sample;
        - an Orbit of gala or galpy, or a Simulationarchive of REBOUND.

        Quantities become numbers in kpc, Myr, solar masses and radians.
    dt : float, optional
        Positive interval between samples, in units of time.
    times : array_like, shape (samples,), optional
        Times of the samples instead of `dt`, equidistant to one part in a million. Default: those of the container.
    coordinates : str or sequence of str, optional
        Names of the 2n rows.
    model : model, optional
        Model whose natural angles are used.
    signals : Angles or str, optional
        Angles whose frequencies are computed: an object of `fastaff.models.angles`, or ``"R z phi"`` (cylindrical) or
        ``"R phi"`` (polar) for rows x, y (, z) and velocities. Default: the plane of each coordinate and its momentum
        or velocity.
    {lines}
    {threads}
    {callback}

    Returns
    -------
    `FrequencyMap`
        Frequencies in cycles per unit time, with error estimates, diffusion and classification of each orbit.

    Raises
    ------
    ValueError
        If a value is out of its range; the message names orbit and sample.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the orbits finished so far in ``.partial``.

    Notes
    -----
    - Method: that of `frequency_map`, with equal results for the same samples in any container.
    - Errors include the window, round-off and white noise (three standard deviations). They do not include the error of
      the program that made the samples.
    - Resolution: orbits with fewer than four samples in a period of their fastest line get the status NOT_CONVERGED.
      Use `tunes` for data once per turn.
    - Ended orbits: NONFINITE, or LOST if the samples stay at one point. Frequencies are those before the end, over one
      of eight lengths in a factor of 2.
    - Cost: one Fourier transform of each signal. Memory: 384 MiB beyond the samples, or three times one orbit.

    See the explanation page on frequencies.

    References
    ----------
    Laskar 1990, Icarus 88, 266 (frequency maps, diffusion); Wall & Neuhauser 1995, J. Chem. Phys. 102, 8011, and
    Mandelshtam & Taylor 1997, J. Chem. Phys. 107, 6756 (harmonic inversion).

    Examples
    --------
    >>> t = 0.1 * np.arange(400)
    >>> fa.orbit_frequencies([np.cos(3 * t), -np.sin(3 * t)], 0.1).omega.round(9)
    array([[3.]])
    """
    checked_callback(callback)
    given = given_orbits(samples, dt=dt, times=times, coordinates=coordinates, least=LEAST)
    if given.interval is None:
        raise ValueError("dt must be given, the time between samples. For turn-by-turn data use fa.tunes.")
    lines = None if lines is None else whole("lines", lines, 1)
    layout = SignalLayout(_signals(given, model, signals), given.shape[0] // 2)
    work = _Work(given, layout, lines, checked_threads(threads), callback)
    with partial_result_on_interrupt("orbit_frequencies", work.result):
        work.run()
    return work.result()


def _signals(given: GivenOrbits, model: Any, signals: Any) -> Any:
    """Return the angles of orbits."""
    n = given.shape[0] // 2
    if model is not None:
        if checked_model(model, needs="Hamilton's equations").degrees_of_freedom != n:
            raise ValueError(
                f"model must have {n} degrees of freedom for samples of {2 * n} rows, got {model.degrees_of_freedom}"
            )
        return checked_signals(signals, model)
    if signals is None:
        return Plain(given.angles)
    if not all(hasattr(signals, name) for name in ("signals", "names", "planes")):
        raise TypeError(
            f"signals must be a text such as 'R z phi', or a value of fastaff.models.angles, got {shown(signals)}"
        )
    suited(signals, n, f"samples of {2 * n} rows")
    return signals


def _portions(signals: Signals, loops: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield orbits and numbers of their loops, AT_ONCE or fewer, of equally many samples."""
    for own in signals.alike():
        orbits, number = (entry.ravel() for entry in np.mgrid[: own.size, :loops])
        for begin in range(0, orbits.size, AT_ONCE):
            part = slice(begin, begin + AT_ONCE)
            yield own[orbits[part]], number[part]


class _Work:
    """Frequencies in the making."""

    def __init__(
        self,
        given: GivenOrbits,
        layout: SignalLayout,
        lines: int | None,
        threads: int,
        callback: Callback | None,
    ):
        self.given = given
        self.layout = layout
        self.threads = threads
        self.callback = callback
        self.found = FrequencyTable(layout, given.shape[1], lines)
        self.interval, self.states = float(given.interval or 0.0), ReusableBuffer()
        self.status = np.full(given.shape[1], int(Status.INTERRUPTED))
        self.read, self.t = np.zeros((2, given.shape[1]))

    def run(self) -> None:
        """Find the frequencies of all orbits, as many at a time as memory allows."""
        rows, orbits, samples = self.given.shape
        portion = max(1, BUDGET // (8 * rows * samples))
        for begin in range(0, orbits, portion):
            end = min(begin + portion, orbits)
            z = self.given.read(begin, end)
            counts, status = ends(z, begin)
            self.t[begin:end] = np.maximum(counts - 1, 0) * self.interval
            for length, own in lengths(counts, samples, LEAST):
                states = self.states.array(own.size, length + 1, rows)
                np.copyto(states, z[:, own, : length + 1].transpose(1, 2, 0))
                coarse = self._adopt(begin + own, states, length)
                status[own[coarse]] = Status.NOT_CONVERGED
            self.status[begin:end] = status
            if self.callback is not None:
                self.callback(end / orbits)

    def _adopt(self, orbits: np.ndarray, states: np.ndarray, length: int) -> np.ndarray:
        """Fill in the results from states (orbits, samples, 2n); return a mask of orbits with samples too far apart."""
        signals = self.layout.signals(states, self.threads, BUFFERS.signals)
        fine = fastest(signals, 1.0, self.threads) <= COARSE
        kept = orbits[fine]
        own = signals_of(signals, self.interval).of(np.flatnonzero(fine))
        self.read[kept] = length * self.interval
        if kept.size:
            reading = read(self.layout, SampledOrbits(own, None, 0), self.threads)
            noise = self._noise(own)
            errors = {name: np.maximum(getattr(reading, name), noise) for name in ("error", "dominant_error")}
            if self.found.lines is not None:  # before the orbits count as finished
                self.found.lines.adopt(kept, self.layout, own, 0.0)
            self.found.adopt(kept, reading._replace(**errors))
        return ~fine

    def _noise(self, own: Signals) -> np.ndarray:
        """Return the errors (orbits, n) of frequencies by white noise, such as that of samples in single precision.

        Its level is that of the lowest quarter of the bins; lines take only a few bins.
        """
        from scipy.fft import fft  # not at import, which it would make slow

        coefficients, offset = self.layout.own(own, self.threads)
        loops = Loops(coefficients, offset, np.zeros_like(offset))
        found = np.zeros(offset.shape)
        window = cosine_window(min(int(own.samples[0]), ENOUGH))
        quarter = int(QUARTER * window.size)
        for o, k in _portions(own, offset.shape[1]):
            bins = fft(values(own, loops, o, k, self.threads)[:, : window.size] * window, overwrite_x=True)
            power = bins.real**2 + bins.imag**2
            level = np.partition(power, quarter)[:, quarter] / (-math.log1p(-QUARTER) * (window**2).sum())
            line = power.max(axis=1)
            found[o, k] = np.sqrt(np.divide(level, line, out=np.zeros_like(line), where=line > 0))
        return NOISE * found / (own.time * np.sqrt(own.samples))[:, None]

    def result(self) -> FrequencyMap:
        """Assemble the map."""
        time = (self.given.shape[2] - 1) * self.interval
        found = self.found
        return found.assembled(
            found.nu, found.error, self.status.copy(), t=self.t.copy(), time=time, step=self.interval, read=self.read
        )
