"""Whether errors of `frequency_map` cover where nothing is integrable: `python bench/frequency_longer.py`; with --write
the table of docs/benchmarks/validation.md.

Parameters, units and starts are drawn at random. The frequencies of orbits over T are held against those over LONGER
times T, where orbits are REGULAR over both: those of a chaotic orbit change with the time.
"""

from __future__ import annotations

import argparse

import numpy as np
from frequency_coverage import ratios
from pages import put

import fastaff as fa
from fastaff import Classification

LONGER, ORBITS, SEEDS = 8, 100, 10


def formula(text, coordinates, time, size, **parameters):
    """Return a drawer of models, starts around the origin and times, in units of length and time of its own."""

    def drawn(rng):
        l, w = 10.0 ** rng.uniform(-2, 2, 2)
        n = len(coordinates.split())
        values = {name: rng.uniform(*span) for name, span in parameters.items()}
        scaled = text
        for name in coordinates.split():
            scaled = scaled.replace(name, f"({name}/l)")
        model = fa.hamiltonian(f"u*({scaled})", coordinates=coordinates, l=l, u=(l * w) ** 2, **values)
        z0 = rng.normal(0, size, (2 * n, ORBITS)) * np.repeat([l, l * w], n)[:, None]
        return model, z0, time / w

    return drawn


def body(potential, rest, time):
    """Return a drawer of bodies with potential(rng), near their rest."""

    def drawn(rng):
        made = fa.Body(potential(rng))
        return made, np.array(rest)[:, None] + 0.1 * rng.standard_normal((8, ORBITS)), time

    return drawn


def turning_bar(rng):
    """Draw a logarithmic bar that turns, and starts over short times."""
    q, c, turning = (rng.uniform(*span) for span in ((0.6, 0.95), (0.05, 0.3), (0, 0.3)))
    model = fa.hamiltonian("log(x**2+y**2/q**2+c)/2", coordinates="x y", rotation=turning, q=q, c=c)
    return model, rng.normal(0, 0.5, (4, ORBITS)), rng.uniform(100, 600)


def double_pendulum(rng):
    """Draw a double pendulum, and starts over short times."""
    model = fa.models.DoublePendulum(*rng.uniform(0.5, 2, 5))
    size = np.array([1.0, 1.0, model.m_1 * model.l_1 * model.g**0.5, model.m_2 * model.l_2 * model.g**0.5])
    return model, rng.uniform(-0.6, 0.6, (4, ORBITS)) * size[:, None], rng.uniform(100, 600)


SYSTEMS = {
    "Hénon-Heiles": formula("(x**2+y**2)/2+x**2*y-y**3/3", "x y", 1000.0, 0.2),
    "logarithmic": formula("log(x**2+y**2/q**2+c)/2", "x y", 300.0, 0.5, q=(0.6, 0.95), c=(0.01, 0.3)),
    "oscillators": formula("(x**2+a*y**2)/2+b*x**2*y**2+y**4/4", "x y", 600.0, 0.5, a=(0.5, 3), b=(0.05, 0.5)),
    "barred": formula("-1/(1+sqrt(c+x**2+y**2))+b*x*y", "x y", 1500.0, 0.4, b=(0.005, 0.02), c=(0.9, 1.5)),
    "three oscillators": formula(
        "(x**2+a*y**2+b*z**2)/2+0.1*x*y+0.1*y**2*z+0.05*(x**4+z**4)", "x y z", 1000.0, 0.4, a=(1.2, 1.5), b=(1.6, 2)
    ),
    "three quartics": formula("(x**4+a*y**4+b*z**4)/4+0.1*x**2*y**2", "x y z", 800.0, 0.8, a=(1.5, 2), b=(2.1, 3)),
    "body, EQ2.2h": body(lambda rng: fa.Hyperelastic(rng.uniform(0.5, 2)), [1.5, 0, 0.3, 0, 0, 0, 0, 0], 400.0),
    "body, neo-Hookean": body(
        lambda rng: fa.NeoHookean(G=rng.uniform(0.5, 2), K=rng.uniform(1, 4)), [1, 1, 0, 0, 0, 0, 0, 0], 400.0
    ),
    "turning bar": turning_bar,
    "double pendulum": double_pendulum,
}


def compared(model, z0, time):
    """Return the ratios of the differences to the errors, of the orbits that are compared."""
    brief, longer = (fa.frequency_map(model, z0, time=t) for t in (time, LONGER * time))
    own = (brief.classification == Classification.REGULAR) & (longer.classification == Classification.REGULAR)
    nu, error, truth = (a[:, own] for a in (brief.nu, brief.error + longer.error, longer.nu))
    m = 2 if brief.names[-1] == "psi" else len(nu)  # the planes of a body have frequencies of their own
    return np.max([ratios(nu[:m], error[:m], truth[:m]), *(np.abs(nu - truth) / error)[m:]], axis=0)


def table():
    """Return the rows of the table."""
    lines = [
        "| system | orbits | compared | within error (%) | beyond three times | worst ratio |",
        "|---|---|---|---|---|---|",
    ]
    whole = []
    for name, drawn in SYSTEMS.items():
        found = [compared(*drawn(np.random.default_rng([seed, *name.encode()]))) for seed in range(SEEDS)]
        whole.append(np.concatenate(found))
        lines.append(_row(name, whole[-1], SEEDS * ORBITS))
    return "\n".join([*lines, _row("all", np.concatenate(whole), len(SYSTEMS) * SEEDS * ORBITS)]) + "\n"


def _row(name, ratio, orbits):
    share, far, worst = 100 * np.mean(ratio <= 1), int((ratio > 3).sum()), ratio.max()
    return f"| {name} | {orbits:,} | {ratio.size:,} | {share:.2f} | {far} | {worst:.3g} |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write the table into docs/benchmarks/validation.md")
    rows = table()
    print(rows)
    if parser.parse_args().write:
        put("docs/benchmarks/validation.md", "frequencies of longer times", rows)
