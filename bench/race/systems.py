"""The systems of the race, each written once for all programs, and their truth in 80-bit arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from common import hyperelastic_orbits

from fastaff import AlphaTurning, Body, HenonHeiles, Hyperelastic, Hyperplane, NeoHookean

CHECKED = 64
"""Orbits whose truth is known: the first of the set."""


def hyperelastic(a1, a2, b1, b2):
    """Return the slopes of V of EQ2.2h, C = 1."""
    x = a1 * a1 + a2 * a2 - b1 * b1 - b2 * b2
    wall = 4.0 / (x * x)
    return (1.0 - wall) * a1, (1.0 - wall) * a2, (1.0 + wall) * b1, (1.0 + wall) * b2


def neo_hookean(a1, a2, b1, b2):
    """Return the slopes of V = G/2 (D1^2 + D2^2 - 2) - G log(D1 D2) + K/2 (D1 D2 - 1)^2, G = 1, K = 2."""
    x = 0.5 * (a1 * a1 + a2 * a2 - b1 * b1 - b2 * b2)
    y = 2.0 * (x - 1.0) - 1.0 / x
    return (1.0 + y) * a1, (1.0 + y) * a2, (1.0 - y) * b1, (1.0 - y) * b2


def henon_heiles(x, y):
    """Return the slopes of V of Henon and Heiles."""
    return x + 2.0 * x * y, y + x * x - y * y


def henon_heiles_orbits(orbits: int) -> np.ndarray:
    """Return z0 (4, orbits) around an orbit of energy 0.1 on x = 0, spread 0.01 (seed 2)."""
    one = np.array([[0.0], [0.1], [0.4], [0.2]])
    z0 = one + 0.01 * np.random.default_rng(2).standard_normal((4, orbits))
    z0[0] = 0.0
    return z0


def one_orbit(orbits: int = 1) -> np.ndarray:
    """Return z0 (4, 1), a quasi-periodic orbit of Hénon-Heiles that crosses x = 0 rising 306 times in T = 2000."""
    return np.array([[0.0], [0.1], [0.4], [0.14]])


class System(NamedTuple):
    """A system with unit masses: fastaff's model, the slopes of V for the others, its orbits and a section."""

    name: str
    model: Any
    slopes: Callable
    orbits: Callable[[int], np.ndarray]
    section: Any

    @property
    def degrees(self) -> int:
        """Degrees of freedom."""
        return self.model.degrees_of_freedom


SYSTEMS = {
    system.name: system
    for system in (
        System("EQ2.2h", Body(Hyperelastic(1.0), 1.0), hyperelastic, hyperelastic_orbits, AlphaTurning(+1)),
        System("neo-Hookean", Body(NeoHookean(1.0, 2.0), 1.0), neo_hookean, hyperelastic_orbits, AlphaTurning(+1)),
        System("Hénon-Heiles", HenonHeiles(), henon_heiles, henon_heiles_orbits, Hyperplane((1, 0, 0, 0))),
        System("Hénon-Heiles, one orbit", HenonHeiles(), henon_heiles, one_orbit, Hyperplane((1, 0, 0, 0))),
    )
}


def equations(hy, system: System):
    """Return the equations of a system for heyoka, and its variables."""
    n = system.degrees
    z = hy.make_vars(*(f"{kind}{i}" for kind in "qp" for i in range(n)))
    return [*zip(z[:n], z[n:]), *zip(z[n:], [-slope for slope in system.slopes(*z[:n])])], z


@cache
def peer_functions(system: System):
    """Return compiled grad_T(p, parameters) and grad_V(q, parameters), as pynamicalsys takes them."""
    slopes = numba.njit(system.slopes)
    if system.degrees == 2:

        @numba.njit
        def grad_v(q, parameters=None):
            return np.array(slopes(q[0], q[1]))
    else:

        @numba.njit
        def grad_v(q, parameters=None):
            return np.array(slopes(q[0], q[1], q[2], q[3]))

    @numba.njit
    def grad_t(p, parameters=None):
        return p.copy()

    return grad_t, grad_v


@cache
def true_states(name: str, orbits: int, time: float) -> np.ndarray:
    """Return the states (2n, CHECKED) at `time` from 80-bit arithmetic with tolerance 1e-19."""
    return _true(name, orbits, time, CHECKED)[0]


@cache
def true_crossings(name: str, orbits: int, time: float, checked: int = CHECKED) -> list[np.ndarray]:
    """Return the times at which the first `checked` orbits cross the system's section, from the same arithmetic."""
    return _true(name, orbits, time, checked)[1]


def _true(name: str, orbits: int, time: float, checked: int):
    import heyoka as hy

    extended, system = np.longdouble, SYSTEMS[name]
    z0 = system.orbits(orbits)[:, :checked]
    system_equations, z = equations(hy, system)
    found: list = []
    event = hy.nt_event(
        system.section.value(*z),
        lambda ta, when, sign: found.append(when),
        direction=hy.event_direction.positive,
        fp_type=extended,
    )
    start = [extended(1)] * len(z0)
    ta = hy.taylor_adaptive(system_equations, start, tol=extended(1e-19), fp_type=extended, nt_events=[event])
    ends, times = np.empty(z0.shape), []
    for i in range(z0.shape[1]):
        found.clear()
        ta.time = extended(0)
        ta.state[:] = z0[:, i]
        ta.reset_cooldowns()
        ta.propagate_until(extended(time))
        ends[:, i] = ta.state
        crossed = np.array(found, dtype=float)
        times.append(crossed[crossed > 1e-12])  # a start on the section is no crossing
    return ends, times
