"""Work and precision of the splittings: forces per unit time for the accuracy asked, on seven systems.

Run: pytest bench/test_schemes.py -s (the table, 3 minutes), or python bench/test_schemes.py PATH (the figure of
docs/explanation/schemes.md too, with increments where they help).
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pytest
from numpy.typing import NDArray

import fastaff as fa
from fastaff.runs.schemes import SCHEMES, Splitting

GOALS = (1e-6, 1e-9, 1e-12, 1e-14)
RACERS: tuple[Splitting, ...] = tuple(s for s in SCHEMES.values() if isinstance(s, Splitting) and s.order > 2)
ORBITS, TIME = 16, 20.0
WORK = np.geomspace(12.0, 6000.0, 37)
"""Forces per unit time that are tried."""


class Logarithmic(NamedTuple):
    """A flattened galaxy with a core: V = log(core^2 + x^2 + (y/q)^2)/2 (Binney & Tremaine 2008, eq. 2.71a)."""

    core: float = 0.14
    flattening: float = 0.9
    degrees_of_freedom = 2
    coordinates = ("x", "y")

    def velocity(self, px, py):
        return px, py

    def force(self, x, y):
        y = y / (self.flattening * self.flattening)
        s = -1.0 / (self.core * self.core + x * x + y * y * self.flattening * self.flattening)
        return s * x, s * y

    def kinetic_energy(self, px, py):
        return (px * px + py * py) / 2

    def potential_energy(self, x, y):
        y = y / self.flattening
        return np.log(self.core * self.core + x * x + y * y) / 2

    def margin(self, x, y):
        return 1.0 + 0.0 * x


class Kepler(NamedTuple):
    """V = -1/r in the plane."""

    degrees_of_freedom = 2
    coordinates = ("x", "y")

    def velocity(self, px, py):
        return px, py

    def force(self, x, y):
        s = 1.0 / (x * x + y * y)
        s = -s * np.sqrt(s)
        return s * x, s * y

    def kinetic_energy(self, px, py):
        return (px * px + py * py) / 2

    def potential_energy(self, x, y):
        return -1.0 / np.sqrt(x * x + y * y)

    def margin(self, x, y):
        return x * x + y * y


class System(NamedTuple):
    """A model and its starts (2n, orbits)."""

    name: str
    model: Any
    z0: NDArray[np.float64]


def kepler_starts() -> NDArray[np.float64]:
    """Return orbits of semiaxis 1 that begin in the pericentre, eccentricities 0.1 to 0.6."""
    e = np.linspace(0.1, 0.6, ORBITS)
    return np.array([1 - e, 0 * e, 0 * e, np.sqrt((1 + e) / (1 - e))])


def systems() -> list[System]:
    """Return the systems of the race, 16 orbits each (seeds 1 and 2)."""
    neo, rng = fa.Body(fa.NeoHookean(1.0), 1.0), np.random.default_rng(1)
    eq = np.zeros((8, ORBITS))
    eq[0], eq[2] = 1.5, 0.3
    found = [System("EQ2.2h", fa.Body(fa.Hyperelastic(1.0), 1.0), eq + 0.1 * rng.standard_normal(eq.shape))]
    for energy in (0.6, 1.5, 3.0):
        sample = fa.energy_sample(neo, energy=energy, section=fa.AlphaTurning(+1), orbits=ORBITS, seed=2)
        found.append(System(f"neo-Hookean, E = {energy}", neo, sample.z0))
    hh = rng.uniform(-0.25, 0.25, (4, ORBITS))
    log = np.array([0.7, 0.0, 0.0, 0.5])[:, None] + 0.2 * rng.uniform(-1, 1, (4, ORBITS))
    return [
        *found,
        System("Hénon-Heiles", fa.HenonHeiles(), hh),
        System("Kepler, e = 0.1 ... 0.6", Kepler(), kepler_starts()),
        System("logarithmic potential", Logarithmic(), log),
    ]


def splitting_step(model: Any, scheme: Splitting, q: NDArray, p: NDArray, h: Any) -> tuple[NDArray, NDArray]:
    """Return a step in the arithmetic of q and p, with coefficients whose sum is 1 in it."""
    drift, kick = (np.array(c, dtype=q.dtype) for c in (scheme.drift, scheme.kick))
    drift, kick = drift / drift.sum(), kick / kick.sum()
    for a, b in zip(drift, kick):
        q = q + a * h * np.array(model.velocity(*p))
        p = p + b * h * np.array(model.force(*q))
    return q + drift[-1] * h * np.array(model.velocity(*p)), p


def truth(system: System) -> NDArray[np.longdouble]:
    """Return the states at TIME: Kepler's equation, or SOFRONIOU_SPALETTA10 in 80-bit arithmetic, 6400 forces per unit
    time.
    """
    if isinstance(system.model, Kepler):
        e = 1 - system.z0[0].astype(np.longdouble)
        M, E = np.longdouble(TIME), np.full(ORBITS, TIME, np.longdouble)
        # The pericentre is at 1 - e of the semiaxis 1 that the rounded velocity gives: a = 1/(2/r - v^2).
        r, v = system.z0[0].astype(np.longdouble), system.z0[3].astype(np.longdouble)
        a = 1 / (2 / r - v * v)
        e, rate = 1 - r / a, a ** np.longdouble(-1.5)
        for _ in range(30):
            E = E - (E - e * np.sin(E) - rate * M) / (1 - e * np.cos(E))
        b, dE = np.sqrt(1 - e * e), rate / (1 - e * np.cos(E))
        return np.array([a * (np.cos(E) - e), a * b * np.sin(E), -a * np.sin(E) * dE, a * b * np.cos(E) * dE])
    n = len(system.z0) // 2
    steps = round(TIME * 6400 / 35)
    q, p = system.z0[:n].astype(np.longdouble), system.z0[n:].astype(np.longdouble)
    for _ in range(steps):
        q, p = splitting_step(system.model, fa.SOFRONIOU_SPALETTA10, q, p, np.longdouble(TIME) / steps)
    return np.concatenate([q, p])


def errors_of(system: System, scheme: Splitting, end: NDArray[np.longdouble]) -> tuple[NDArray, NDArray]:
    """Return the work (steps,), forces per unit time, and the errors (steps, orbits) of states relative to their
    norm.
    """
    counts = np.unique(np.maximum(1, np.round(WORK * TIME / scheme.stages).astype(int)))
    errors = np.empty((len(counts), ORBITS))
    for row, count in zip(errors, counts):
        run = fa.integrate(
            system.model, system.z0, time=TIME, step=TIME / count, scheme=scheme, energy_tolerance=1e9, threads=1
        )
        with np.errstate(all="ignore"):
            row[:] = np.linalg.norm((run.z - end).astype(float), axis=0) / np.linalg.norm(run.z, axis=0)
    return counts * scheme.stages / TIME, np.where(np.isfinite(errors), errors, np.inf)


def needed(work: NDArray, errors: NDArray, goal: float) -> float:
    """Return the forces per unit time that reach the goal, in the mean over orbits of the logarithm; inf where half of
    them do not.

    For each orbit by itself, as its step is chosen: where its error comes down through the goal for good, between the
    two tries on the logarithms. Rounding errors go up and down: an error counts as the largest of it and the next two.
    """
    found = np.full(errors.shape[1], np.inf)
    padded = np.concatenate([errors, errors[-1:], errors[-1:]])
    steady = np.maximum(padded[:-2], np.maximum(padded[1:-1], padded[2:]))
    for k, column in enumerate(steady.T):
        good = np.flatnonzero(column <= goal)
        if not good.size:
            continue
        i = good[0]
        if i == 0 or not np.isfinite(column[i - 1]):
            found[k] = work[i]
            continue
        share = np.log(column[i - 1] / goal) / np.log(column[i - 1] / column[i])
        found[k] = work[i - 1] * (work[i] / work[i - 1]) ** share
    reached = np.isfinite(found)
    return float(np.exp(np.log(found[reached]).mean())) if reached.mean() > 0.5 else np.inf


def seconds_per_force(system: System, racers: tuple[Splitting, ...], rounds: int = 5) -> list[float]:
    """Return CPU seconds of one thread for a force of one orbit: 128 orbits, the least of alternating runs."""
    z0 = np.tile(system.z0, (1, 128 // ORBITS))
    least = np.full(len(racers), np.inf)
    for _ in range(rounds):
        for k, scheme in enumerate(racers):
            count = 60_000 // scheme.stages
            start = time.process_time()
            fa.integrate(system.model, z0, time=count * 1e-3, step=1e-3, scheme=scheme, energy_tolerance=1e9, threads=1)
            least[k] = min(least[k], (time.process_time() - start) / (count * scheme.stages * 128))
    return list(least)


class Race(NamedTuple):
    """Work of the racers: curves of work and errors, forces per unit time for each goal, seconds per force."""

    system: System
    curves: list[tuple[NDArray, NDArray]]
    forces: NDArray[np.float64]
    seconds: list[float]


def race(system: System, racers: tuple[Splitting, ...] = RACERS) -> Race:
    """Run the race on a system."""
    end = truth(system)
    curves = [errors_of(system, scheme, end) for scheme in racers]
    forces = np.array([[needed(*curve, goal) for curve in curves] for goal in GOALS])
    return Race(system, curves, forces, seconds_per_force(system, racers))


def table(races: list[Race], racers: tuple[Splitting, ...] = RACERS) -> str:
    """Return the Markdown table: forces per unit time (CPU microseconds of one orbit per unit time), the winners."""
    head = ["system", "error", *(s.name for s in racers), "fewest forces", "least time"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for found in races:
        for goal, row in zip(GOALS, found.forces):
            times = row * np.array(found.seconds)
            cells = [f"{f:.0f} ({1e6 * t:.2f})" if np.isfinite(f) else "-" for f, t in zip(row, times)]
            won = [racers[int(np.argmin(r))].name if np.isfinite(r).any() else "-" for r in (row, times)]
            lines.append("| " + " | ".join([found.system.name, f"{goal:.0e}", *cells, *won]) + " |")
    return "\n".join(lines)


def _base(scheme: Splitting) -> str:
    """Return the name of a scheme without its changes."""
    return scheme.name.split(",")[0]


def figure(races: list[Race], racers: tuple[Splitting, ...] = RACERS) -> plt.Figure:
    """Return the work-precision figure, one panel a system: geometric means of the errors of its orbits."""
    fig, axes = plt.subplots(2, 4, figsize=(13, 6.4), sharex=True, sharey=True, layout="constrained")
    colours = {name: f"C{k}" for k, name in enumerate(dict.fromkeys(_base(s) for s in racers))}
    for ax, found in zip(axes.flat, races):
        for scheme, (work, errors) in zip(racers, found.curves):
            with np.errstate(all="ignore"):
                mean = np.exp(np.log(np.maximum(errors, 1e-17)).mean(axis=1))
            kept = np.isfinite(mean) & (mean < 0.1)
            style = ":" if scheme.name != _base(scheme) else "-" if scheme.nystrom else "--"
            ax.loglog(work[kept], mean[kept], lw=1.5, label=scheme.name, ls=style, c=colours[_base(scheme)])
        for goal in GOALS:
            ax.axhline(goal, color="0.85", lw=0.8, zorder=0)
        ax.set(title=found.system.name, xlim=(10, 7000), ylim=(1e-16, 0.1))
    for ax in axes[:, 0]:
        ax.set_ylabel(f"relative error of states at t = {TIME:g}")
    for ax in (*axes[1], axes[0, 3]):
        ax.set_xlabel("forces per unit time")
        ax.tick_params(labelbottom=True)
    axes[1, 3].axis("off")
    axes[1, 3].legend(*axes[0, 0].get_legend_handles_labels(), loc="center", frameon=False)
    return fig


@pytest.mark.parametrize("k", range(7))
def test_race(k):
    """The table of one system; BLANES_CASAS_ESCORIHUELA8 reaches the errors of KAHAN_LI8 with fewer forces."""
    found = race(systems()[k])
    print(f"\n{table([found])}")
    ours, kahan = (RACERS.index(SCHEMES[name]) for name in ("BLANES_CASAS_ESCORIHUELA8", "KAHAN_LI8"))
    assert (found.forces[:3, ours] < found.forces[:3, kahan]).all()


if __name__ == "__main__":
    carried = tuple(
        replace(SCHEMES[name], name=f"{name}, increments", increments=True)
        for name in ("BLANES_CASAS_ESCORIHUELA8", "KAHAN_LI8")
    )
    every = [race(system, RACERS + carried) for system in systems()]
    print(table(every, RACERS + carried))
    if len(sys.argv) > 1:
        figure(every, RACERS + carried).savefig(Path(sys.argv[1]), dpi=110)
