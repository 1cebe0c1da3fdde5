"""Orbits that overflow in a step: those that run away to infinity have escaped."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.status import Status
from . import observers
from .ensemble import Ensemble, energy_error, no_memory
from .reaches import FARTHEST
from .schemes.catalogue import DOP853

# tests/test_leaving.py has orbits that run away, by every scheme.

BACK = 16
"""Steps before the overflow from which an orbit is followed again, as the last ones are spoilt."""

AHEAD = 64.0
"""Time for which it is followed, in steps."""

SOUND = 0.05
"""Energy error there, over the largest kinetic energy, above which the step was unstable and the orbit tells nothing.
"""


def mark_escapes(flow: Any, ensemble: Ensemble, begun: Ensemble, sizes: Callable[[], np.ndarray]) -> None:
    """Give orbits that overflowed on their way to infinity the status ESCAPED in the place of NONFINITE.

    begun: the orbits before the run; sizes: returns their steps (orbits,). In a potential that falls ever more steeply
    an orbit reaches infinity in a finite time, and a fixed step passes from ordinary numbers to an overflow. Such
    orbits run again to some steps before, and from there with an adaptive scheme, which meets the escape radius first.
    """
    lost = overflowed(ensemble, begun) & (ensemble.count > begun.count + 1)
    if not lost.any():
        return
    which = np.flatnonzero(lost)
    last = _alone(begun.of(which))
    size = sizes()[which]
    alone = replace(flow, vectors=0, step=size)
    # One step at least: its energy error tells whether steps are stable.
    until = np.maximum(ensemble.count[which] - BACK, last.count + 1)
    _run(alone, last, until * size)
    with np.errstate(all="ignore"):
        sound = np.isfinite(last.z).all(axis=0) & (energy_error(flow.system, last) < SOUND)
    sound &= (last.status == Status.OK) & (last.count == until)
    which = which[sound]
    size = size[sound]
    if not which.size:
        return
    start = last.z[:, sound]
    beyond = replace(flow, vectors=0, scheme=DOP853, step=np.inf, rtol=1e-9, atol=1e-300)
    ahead = beyond.ensemble(start.copy(), radius=ensemble.radius[which])
    ahead.ahead[:] = size / 64
    _run(beyond, ahead, AHEAD * size)
    ensemble.status[which[ahead.status == Status.ESCAPED]] = Status.ESCAPED


def overflowed(ensemble: Ensemble, begun: Ensemble) -> np.ndarray:
    """Return a mask (orbits,) of the orbits that overflowed in a run, on whatever way."""
    return (ensemble.status == Status.NONFINITE) & (begun.status == Status.OK) & (ensemble.radius < FARTHEST)


def leave_open(ensemble: Ensemble, begun: Ensemble) -> None:
    """Give orbits that overflowed in a run that was interrupted the status INTERRUPTED: how they ended is not told."""
    ensemble.status[overflowed(ensemble, begun) & (ensemble.count > begun.count + 1)] = Status.INTERRUPTED


def _alone(ensemble: Ensemble) -> Ensemble:
    """Return the orbits of an ensemble without tangent vectors."""
    if not ensemble.vectors:
        return ensemble
    bare = Ensemble(np.ascontiguousarray(ensemble.points), ensemble.energy, ensemble.kinetic)
    for name in ("status", "count", "time", "ahead", "ticks", "radius"):
        setattr(bare, name, getattr(ensemble, name))
    return bare


def _run(flow: Any, ensemble: Ensemble, time: np.ndarray) -> None:
    """Run orbits to times of their own."""
    flow.run(ensemble, observers.nothing(), *no_memory(ensemble), time=time)
