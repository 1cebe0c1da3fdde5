"""Small jobs of several systems, and how their results are compared bit by bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from own_models import HenonHeilesInUnits

import fastaff as fa
from fastaff.jobs import (
    ChaosOptions,
    EnergySurface,
    FrequencyOptions,
    InitialConditions,
    IntegrateOptions,
    Job,
    Model,
    PoincareOptions,
    RunOptions,
)
from fastaff.results.result import columns

RNG = np.random.default_rng(20263)
A, B, C = RNG.uniform(0.5, 1.5, 3).round(3).tolist()
TEXT = Model(hamiltonian="a*x**2/2 + b*y**2/2 + c*x**2*y**2", parameter=[f"a={A}", f"b={B}", f"c={C}"])
FIXED = RunOptions(step=0.1)
MOTION = IntegrateOptions(time=5.0, samples=2)
LARGE, SMALL = HenonHeilesInUnits(length=1e8), HenonHeilesInUnits(length=1e-8, time=1e-8)
ONES = 0.1 * RNG.standard_normal((4, 23))

CELLS = Job(
    model=Model(model="henon-heiles"),
    energy_surface=EnergySurface(energy=0.2, section="x=0.05"),
    initial_conditions=InitialConditions(grid="6x11", q_range="-0.75:1.2", p_range="-0.9:0.6"),
    options=FIXED,
    poincare=PoincareOptions(crossings=3, max_time=30.0),
    integrate=MOTION,
)
"""Orbits of which some escape, on a grid of which the energy reaches some cells only."""

SMALL_GRID = replace(
    CELLS, initial_conditions=InitialConditions(grid="3x5", q_range="-0.1:0.2", p_range="-0.1:0.1"), chunk=4
)
"""The same on fifteen points."""

JOBS = {
    "cells": CELLS,
    "neo-hookean": Job(
        energy_surface=EnergySurface(energy=1.5, p_eta=0.3),
        initial_conditions=InitialConditions(grid="4x5"),
        options=RunOptions(step=0.02),
        frequency_map=FrequencyOptions(time=20.0),
        chaos_map=ChaosOptions(time=10.0),
    ),
    "text": Job(
        model=TEXT,
        energy_surface=EnergySurface(energy=0.3),
        initial_conditions=InitialConditions(orbits=20, seed=5),
        frequency_map=FrequencyOptions(time=40.0),
        poincare=PoincareOptions(crossings=3, max_time=60.0),
    ),
    "library": Job(
        model=fa.HenonHeiles(A),
        energy_surface=EnergySurface(energy=0.05),
        initial_conditions=InitialConditions(orbits=11),
        options=RunOptions(accuracy=1e-9),
        integrate=MOTION,
    ),
    "own starts": Job(model=TEXT, initial_conditions=ONES, options=FIXED, integrate=MOTION),
    "1e8": Job(model=LARGE, initial_conditions=LARGE.rows(ONES), options=FIXED, integrate=MOTION),
    "1e-8": Job(model=SMALL, initial_conditions=SMALL.rows(ONES), integrate=IntegrateOptions(time=5e-8, samples=2)),
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


def pieces(path):
    """Bytes of every piece of a store, by name; what a killed writer left of one is none."""
    found = {}
    for file in sorted(path.rglob("*")):
        parts = file.relative_to(path).parts
        if file.is_file() and "c" in parts[:-1] and file.suffix != ".partial":
            found["/".join(parts)] = file.read_bytes()
    return found
