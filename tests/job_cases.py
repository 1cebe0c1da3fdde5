"""Small jobs of several systems, and how their results are compared bit by bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from own_models import HenonHeilesInUnits

import fastaff as fa
from fastaff.jobs import Chaos, Frequencies, Job, Model, Motion, Poincare, Run, Starts, Surface
from fastaff.results.result import columns

RNG = np.random.default_rng(20263)
A, B, C = RNG.uniform(0.5, 1.5, 3).round(3).tolist()
TEXT = Model(hamiltonian="a*x**2/2 + b*y**2/2 + c*x**2*y**2", parameter=[f"a={A}", f"b={B}", f"c={C}"])
FIXED = Run(step=0.1)
MOTION = Motion(time=5.0, samples=2)
LARGE, SMALL = HenonHeilesInUnits(length=1e8), HenonHeilesInUnits(length=1e-8, time=1e-8)
ONES = 0.1 * RNG.standard_normal((4, 23))

CELLS = Job(
    model=Model(model="henon-heiles"),
    surface=Surface(energy=0.2, section="x=0.05"),
    starts=Starts(grid="6x11", range1="-0.75:1.2", range2="-0.9:0.6"),
    run=FIXED,
    poincare=Poincare(crossings=3, max_time=30.0),
    integrate=MOTION,
)
"""Orbits of which some escape, on a grid of which the energy reaches some cells only."""

SMALL_GRID = replace(CELLS, starts=Starts(grid="3x5", range1="-0.1:0.2", range2="-0.1:0.1"), unit=4)
"""The same on fifteen points."""

JOBS = {
    "cells": CELLS,
    "neo-hookean": Job(
        surface=Surface(energy=1.5, p_eta=0.3),
        starts=Starts(grid="4x5"),
        run=Run(step=0.02),
        frequency_map=Frequencies(time=20.0),
        chaos_map=Chaos(time=10.0),
    ),
    "text": Job(
        model=TEXT,
        surface=Surface(energy=0.3),
        starts=Starts(orbits=20, seed=5),
        frequency_map=Frequencies(time=40.0),
        poincare=Poincare(crossings=3, max_time=60.0),
    ),
    "library": Job(
        model=fa.HenonHeiles(A),
        surface=Surface(energy=0.05),
        starts=Starts(orbits=11),
        run=Run(accuracy=1e-9),
        integrate=MOTION,
    ),
    "own starts": Job(model=TEXT, starts=ONES, run=FIXED, integrate=MOTION),
    "1e8": Job(model=LARGE, starts=LARGE.rows(ONES), run=FIXED, integrate=MOTION),
    "1e-8": Job(model=SMALL, starts=SMALL.rows(ONES), integrate=Motion(time=5e-8, samples=2)),
}


def bits(results):
    """All arrays of all results by name: kinds, shapes and bytes."""
    found = {}
    for name in results:
        for entry in columns(results[name]):
            value = np.moveaxis(entry.value, entry.axes.index("orbit"), -1)
            if value.dtype.kind in "fc":  # the sign of a NaN says which operation it came from, no more
                value = np.where(np.isnan(value), np.nan, value)
            found[name, entry.name] = value.dtype.str, value.shape, value.tobytes()
    return found


def chunks(path):
    """Bytes of every chunk of a store, by name; what a killed writer left of one is none."""
    found = {}
    for file in sorted(path.rglob("*")):
        parts = file.relative_to(path).parts
        if file.is_file() and "c" in parts[:-1] and file.suffix != ".partial":
            found["/".join(parts)] = file.read_bytes()
    return found
