"""Crossings at steps where the section function is zero, touching ones, and ends of runs, against closed forms."""

from typing import NamedTuple

import numpy as np
import pytest
import shared_systems

import fastaff as fa

FAR = 1e3


class Roots(NamedTuple):
    """The section (x - a)(x - b)(x - c)(x - d) = 0."""

    a: float = FAR
    b: float = FAR
    c: float = FAR
    d: float = FAR
    direction: int = 0

    def value(self, x, p):
        return (x - self.a) * (x - self.b) * (x - self.c) * (x - self.d)


FREE = fa.hamiltonian("0*x", coordinates="x")


def crossings(model, start, section, time, step=None):
    found = fa.poincare_map(model, start, section=section, crossings=60, max_time=time, step=step).times.ravel()
    return found[np.isfinite(found)]


@pytest.mark.parametrize("time", [0.8, 1.0, 2.0, 3.0, np.pi])
def test_crossings_at_two_successive_steps(time):
    """x = t: at 0.5 and 0.75, whatever max_time makes of the steps."""
    assert crossings(FREE, [0.0, 1.0], Roots(0.5, 0.75), time, 0.25) == pytest.approx([0.5, 0.75], abs=1e-12)
    assert crossings(FREE, [0.0, 1.0], Roots(0.5, 0.75), time) == pytest.approx([0.5, 0.75], abs=1e-12)
    for direction, there in ((1, 0.75), (-1, 0.5)):
        assert crossings(FREE, [0.0, 1.0], Roots(0.5, 0.75, direction=direction), time) == pytest.approx([there])


def free_times(x, p, roots, direction, time):
    """Times at which x + p t passes a root of odd order in that direction."""
    found = []
    for root in sorted(set(roots), key=lambda root: (root - x) / p):
        t, order = (root - x) / p, roots.count(root)
        rises = np.prod([np.sign(root - other) for other in roots if other != root]) * np.sign(p)
        if 1e-14 < t <= time * (1 + 1e-14) and order % 2 and rises * direction >= 0:
            found.append(t)
    return found


def test_free_motion_through_roots_on_steps_and_between():
    """Simple, double and triple roots, most of them at steps; any end; both directions."""
    rng = np.random.default_rng(47)
    for _ in range(150):
        h, p = 2.0 ** -rng.integers(1, 4), float(rng.choice([1, -1, 2, 0.5]))
        x = rng.integers(-8, 8) * h if rng.random() < 0.7 else rng.uniform(-2, 2)
        places = [
            rng.integers(1, 9) if rng.random() < 0.7 else rng.integers(0, 9) + rng.uniform(0.1, 0.9) for _ in "ab"
        ]
        roots = [float(x + p * h * place) for place in places for _ in range(rng.choice([1, 1, 2]))]
        triple = rng.random() < 0.3
        if triple:
            roots[1:] = [roots[0]] * 2
        roots += [FAR * p] * (4 - len(roots))
        direction, time = int(rng.choice([0, 1, -1])), h * rng.choice([rng.integers(1, 20), rng.uniform(0.1, 20)])
        time += h / 3 if triple and time == (roots[0] - x) / p else 0.0  # whose place is known to the cube root alone
        true = free_times(x, p, roots, direction, time)
        assert crossings(FREE, [x, p], Roots(*roots, direction), time, h) == pytest.approx(true, abs=1e-4 * h), (
            roots,
            direction,
            time,
        )


def test_harmonic_motion_through_roots_on_steps_and_between():
    """A sin(t + a), of steps that divide the period: simple roots, one or two of them, seldom more within two steps."""
    rng, oscillator, tried = np.random.default_rng(48), shared_systems.well(), 0
    while tried < 60:
        m = int(rng.choice([16, 24, 32]))
        h, A = 2 * np.pi / m, rng.uniform(0.5, 2)
        a = h * rng.integers(m) if rng.random() < 0.7 else rng.uniform(0, 6)
        count, direction = rng.integers(1, 3), int(rng.choice([0, 1, -1]))
        roots = [
            A * np.sin(a + h * rng.integers(m)) if rng.random() < 0.6 else A * rng.uniform(-0.98, 0.98)
            for _ in range(count)
        ]
        time = h * (rng.integers(m // 2, 3 * m) + rng.uniform(0.1, 0.9))
        bases = np.array(
            [
                base
                for r in roots
                for base in (np.arcsin(min(max(r / A, -1), 1)), np.pi - np.arcsin(min(max(r / A, -1), 1)))
            ]
        )
        t = np.sort((bases[:, None] - a + 2 * np.pi * np.arange(-2, 8)).ravel())
        if (np.diff(t) < 0.1 * h).any() or (t[2:] - t[:-2] < 2 * h).any() or np.abs(np.abs(roots) - A).min() < 1e-6:
            continue
        section = Roots(*roots, *[FAR] * (4 - count), direction)
        rises = np.sign(section.value(A * np.sin(t + 1e-3 * h + a), 0.0))
        true = t[(t > 1e-9) & (t < time) & (rises * direction >= 0)]
        found = crossings(oscillator, [A * np.sin(a), A * np.cos(a)], section, time, h)
        assert found == pytest.approx(true, abs=1e-3 * h), (roots, direction)
        tried += 1


def test_an_orbit_in_the_section_has_no_crossings():
    found = fa.poincare_map(
        shared_systems.plane(1, 1), [1.0, 0.0, 0.0, 0.0], section="y=0", crossings=5, max_time=200.0
    )
    assert not found.counts.any()
