"""Every public callable with arguments that work, and the values that replace each of them in turn.

A new public name needs a row in CALLS, or one in CONTAINERS where it only holds what it is given. Calls are small: what
is tested is what they refuse, and that what they accept comes to an end.
"""

import os
import re
import signal
import threading
import time
import warnings
from decimal import Decimal
from fractions import Fraction
from functools import cache, partial
from inspect import Parameter, isclass, isfunction, signature

import numpy as np

import fastaff as fa
from fastaff.chaos.indicators import INDICATORS
from fastaff.engine.kernels.readings import first_length
from fastaff.systems.models.sections import OF_BODIES, Stroboscopic

SECONDS = 60.0
"""Seconds of the processor that an accepted input may take."""

HH, BODY, HARMONIC, WALLED = (
    fa.HenonHeiles(),
    fa.Body(fa.Hyperelastic()),
    fa.Body(fa.Harmonic()),
    fa.Body(fa.NeoHookean()),
)
ANGULAR = fa.models.StackelBody(fa.Harmonic(), fa.models.Cosine(0.5), fa.models.Zero())
LOGISTIC = fa.iterated_map("x1 = r*x*(1 - x)", r=3.9)
RNG = np.random.default_rng(16)
Z4 = np.array([[0.0, 0.0], [0.1, -0.1], [0.3, 0.28], [0.05, 0.1]])
Z8 = np.array([[1.2, 1.3], [0.1, 0.0], [0.4, 0.3], [0.0, 0.1], [0.1, 0.2], [0.6, 0.5], [0.1, 0.0], [0.2, 0.3]])
Z18 = np.concatenate([np.eye(3).ravel(), np.linspace(-0.2, 0.3, 9)])[:, None] * np.array([1.0, 1.1])
STAR = fa.models.Body3(fa.models.Sum3(fa.models.SelfGravity(), fa.models.GasCloud(k=0.2, gamma=2.0, C=0.0)))
X = fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
TURN = fa.AlphaTurning()
J, PHASE = np.array([0.5, 0.6, 0.3, 0.2]), np.array([0.1, 0.2, 0.3, 0.4])
RING = np.exp(0.7j * np.arange(64))
POINTS = np.array([RING.real + 2.0, RING.imag])
TURNED = np.array([RING.real, RING.imag])[:, None] * np.array([[1.0], [0.5]])
SLOW = np.array([np.cos(0.3 * np.arange(200)), -np.sin(0.3 * np.arange(200))])[:, None] * np.array([[1.0], [0.5]])
LONG = np.array([np.cos(0.3 * np.arange(400)), -np.sin(0.3 * np.arange(400))])
SERIES = np.cos(np.cumsum(np.sqrt(np.arange(700.0))))
LEVELS = np.cumsum(RNG.exponential(size=60))
FIXED = {"step": 0.1, "threads": 1}
MOTION = fa.jobs.IntegrateOptions(time=1.0)
REAL_TIME = {"time": 2.0, **FIXED}


def accumulated(samples):
    """Turns that an accumulator takes."""
    running = fa.TuneAccumulator()
    running.push(samples)
    return running.tunes()


def own_case(lam, *_):
    return fa.HenonHeiles(lam), Z4


def own_harmonic(C):
    return fa.Body(fa.Harmonic(C))


def gauss(alpha, beta):
    return np.exp(-((alpha - 1.0) ** 2) - (beta - 0.5) ** 2)


def staircase(E):
    return 0.5 * np.asarray(E)


def square(x):
    return x * x


def double(x):
    return 2.0 * x


def judged(make, **given):
    """An indicator at work: it is checked where it is used."""
    return fa.chaos_map(HH, Z4, indicators=(make(**given),), **{**REAL_TIME, "time": 10.0})


def cut_by(make, body=BODY, z0=Z8, **given):
    """A section at work."""
    return fa.poincare_map(body, z0, section=make(**given), crossings=1, max_time=3.0, **FIXED)


def strobed_by(**given):
    """A stroboscopic section at work."""
    model = fa.hamiltonian("x**2/2*(1.3 + 0.2*cos(t))", coordinates="x", drive_period="2*pi")
    return fa.poincare_map(model, [0.1, 0.2], section=Stroboscopic(**given), crossings=1, **FIXED)


def moved(make, z0=Z8, **given):
    """A model at work, alone or as the potential of a body."""
    model = make(**given)
    return fa.integrate(model if hasattr(model, "degrees_of_freedom") else fa.Body(model), z0, **REAL_TIME)


def bonded(make, **given):
    """A pair potential at work."""
    return fa.molecules.ring(6, pairs=make(**given)).body


def weighed(make, **given):
    """A potential of 3x3 matrices at work."""
    return fa.integrate(fa.models.Body3(make(**given)), Z18, **REAL_TIME)


def ran(job, threads=1, memory=None, overwrite=False, executor=None, callback=None, on_chunk=None):
    """A job at work, in memory: tests/jobs/test_jobs.py hands everything to what takes the path of a store."""
    return fa.run(
        job,
        threads=threads,
        memory=memory,
        overwrite=overwrite,
        executor=executor,
        callback=callback,
        on_chunk=on_chunk,
    )


def slowed(make, **given):
    """A rate of fictitious time at work."""
    return fa.integrate(WALLED, Z8, scheme=fa.TimeTransformed(rate=make(**given)), **REAL_TIME)


@cache
def result(name):
    """A result whose methods take arguments."""
    grid = {"energy": 0.1, "section": X, "axes": ([-0.2, 0.0, 0.1], [-0.1, 0.1])}
    makers = {
        "packet": lambda: fa.quantum.number_packet(HARMONIC, n=(3, 2), m=0, l=0, width=(1.0, 0.0)),
        "vibration": lambda: fa.quantum.spectrum(fa.hamiltonian("x**2/2", coordinates="x"), count=2).state(0),
        "state": lambda: fa.quantum.wavefunction(HARMONIC, m=1, l=1, n=(1, 0)),
        "cut": lambda: fa.poincare_map(BODY, Z8, section=TURN, crossings=2, max_time=30.0, **FIXED),
        "guessable": lambda: fa.poincare_map(HH, result("grid").z0, section=X, crossings=4, max_time=60.0, **FIXED),
        "grid": lambda: fa.energy_grid(HH, **grid),
        "all": lambda: fa.quantum.all_levels(HARMONIC, multiplets=5),
        "levels": lambda: fa.quantum.spectrum(HARMONIC, m=0, l=0, count=2),
        "multiplets": lambda: fa.quantum.exact_levels(HARMONIC, multiplets=4).multiplets(),
        "resonances": lambda: fa.resonances(frequencies(), max_order=4, threads=1),
        "families": lambda: fa.frequencies.orbit_families(fa.frequency_map(HH, Z4, time=20.0, **FIXED)),
        "fit": lambda: fa.fit_torus(HH, Z4[:, 0], time=60.0, step=0.1),
        "scan": lambda: fa.chaotic_fraction(own_case, ([1.0],), **REAL_TIME),
        "orbits": lambda: fa.periodic_orbits(HH, CLOSED, section=X, energy=0.1, max_time=20.0, **FIXED),
    }
    return makers[name]()


def method(owner, name):
    """A method of such a result."""

    def call(**given):
        return getattr(result(owner), name)(**given)

    return call


def frequencies():
    return np.array([[0.31, 0.25, 0.2], [0.21, 0.125, 0.3]])


CLOSED = np.array([0.0, 0.0, 0.3, 0.31])
Q = {"m": 0, "l": 0}
NQ = {"n": (0, 0), **Q}

# name: (callable, arguments that work); arguments that are left out keep their defaults and are replaced in turn too
SPIRAL = fa.ode("x' = k*y; y' = -x; z' = x*y - z", k=1.0)

CALLS = {
    "AlphaEquals": (partial(cut_by, fa.AlphaEquals), {"constant": 1.2}),
    "AlphaTurning": (partial(cut_by, fa.AlphaTurning), {}),
    "AreaEquals": (partial(cut_by, fa.AreaEquals), {}),
    "BetaEquals": (partial(cut_by, fa.BetaEquals), {"constant": 0.5}),
    "BetaTurning": (partial(cut_by, fa.BetaTurning), {}),
    "Hyperplane": (partial(cut_by, fa.Hyperplane, HH, Z4), {"normal": (1.0, 0.0, 0.0, 0.0)}),
    "Stroboscopic": (strobed_by, {"phase": 0.3}),
    "Algebraic": (partial(slowed, fa.schemes.Algebraic), {"kappa": 1.0}),
    "Exponential": (partial(slowed, fa.schemes.Exponential), {"kappa": 1.0}),
    "Logistic": (partial(slowed, fa.schemes.Logistic), {"kappa": 1.0}),
    "Anharmonic": (partial(moved, fa.Anharmonic), {}),
    "Harmonic": (partial(moved, fa.Harmonic), {}),
    "HeavyTop": (partial(moved, fa.HeavyTop), {}),
    "HenonHeiles": (partial(moved, fa.HenonHeiles, Z4), {}),
    "Hyperelastic": (partial(moved, fa.Hyperelastic), {}),
    "NeoHookean": (partial(moved, fa.NeoHookean), {}),
    "Body": (partial(moved, fa.Body), {"potential": fa.Hyperelastic()}),
    "HarmonicBond": (partial(bonded, fa.molecules.HarmonicBond), {}),
    "LennardJones": (partial(bonded, fa.molecules.LennardJones), {}),
    "MorseBond": (partial(bonded, fa.molecules.MorseBond), {}),
    "molecule": (
        fa.molecules.molecule,
        {
            "masses": [1.0, 2.0, 1.5],
            "positions": [[0.0, 1.0, 0.2], [0.0, 0.1, 1.0]],
            "pairs": {(0, 1): fa.molecules.HarmonicBond(), (1, 2): fa.molecules.MorseBond()},
        },
    ),
    "ring": (fa.molecules.ring, {"atoms": 6, "pairs": [fa.molecules.HarmonicBond()]}),
    "BreathingBody": (partial(moved, fa.models.BreathingBody), {"potential": fa.Hyperelastic(), "c": 0.5}),
    "ReducedBody": (
        partial(moved, fa.models.ReducedBody, Z4 + np.array([[1.0], [0.5], [0], [0]])),
        {"potential": fa.Hyperelastic()},
    ),
    "Body3": (partial(moved, fa.models.Body3, Z18), {"potential": fa.models.GasCloud()}),
    "GasCloud": (partial(weighed, fa.models.GasCloud), {}),
    "MooneyRivlin3": (partial(weighed, fa.models.MooneyRivlin3), {}),
    "NeoHookean3": (partial(weighed, fa.models.NeoHookean3), {}),
    "Ogden3": (partial(weighed, fa.models.Ogden3), {}),
    "SelfGravity": (partial(weighed, fa.models.SelfGravity), {}),
    "formula3": (fa.models.formula3, {"text": "k*I1 + J", "k": 1.0}),
    "from_two_polar3": (
        fa.charts.from_two_polar3,
        {"L": np.eye(3), "D": [3.0, 2.0, 1.0], "R": np.eye(3), "p": [0.1, 0.2, 0.3], "spin": [0.0, 0.0, 1.0]},
    ),
    "reduced_body3": (fa.models.reduced_body3, {"model": STAR, "spin": 0.1, "vorticity": 0.2}),
    "relative_equilibrium": (
        fa.models.relative_equilibrium,
        {"model": STAR, "D": [1.0, 0.9, 0.8], "omega": [0.0, 0.0, 0.6]},
    ),
    "riemann_ellipsoid": (fa.models.riemann_ellipsoid, {"model": STAR, "a2": 0.8, "a3": 0.6}),
    "two_polar3": (fa.charts.two_polar3, {"z": Z18[:, 0]}),
    "SeparableAlphaBeta": (
        partial(moved, fa.SeparableAlphaBeta),
        {"V_alpha": fa.models.Zero(), "V_beta": fa.models.Zero()},
    ),
    "SeparableElliptic": (
        partial(moved, fa.SeparableElliptic),
        {"V_kappa": fa.models.Zero(), "V_lambda": fa.models.Zero()},
    ),
    "SeparableRVartheta": (
        partial(moved, fa.SeparableRVartheta),
        {"V_r": fa.models.Zero(), "V_vartheta": fa.models.Zero()},
    ),
    "StackelBody": (
        partial(moved, fa.models.StackelBody),
        {
            "potential": fa.SeparableAlphaBeta(fa.models.Zero(), fa.models.Zero()),
            "V_eta": fa.models.Zero(),
            "V_gamma": fa.models.Zero(),
        },
    ),
    "Zero": (partial(moved, lambda: fa.SeparableAlphaBeta(fa.models.Zero(), fa.models.Zero())), {}),
    "Automatic": (lambda **given: fa.integrate(HH, Z4, time=2.0, threads=1, scheme=fa.schemes.Automatic(**given)), {}),
    "BerryRobnik": (fa.quantum.BerryRobnik, {"chaotic": 0.5}),
    "BerryRobnik.cumulative": (fa.quantum.BerryRobnik(0.5).cumulative, {"s": [0.5, 1.0]}),
    "BerryRobnik.density": (fa.quantum.BerryRobnik(0.5).density, {"s": [0.5, 1.0]}),
    "Brody": (fa.quantum.Brody, {"repulsion": 0.5}),
    "Brody.cumulative": (fa.quantum.Brody(0.5).cumulative, {"s": [0.5, 1.0]}),
    "Brody.density": (fa.quantum.Brody(0.5).density, {"s": [0.5, 1.0]}),
    "GALI": (partial(judged, fa.GALI), {"count": 2}),
    "TangentIndicator": (
        partial(judged, fa.chaos.TangentIndicator),
        {"name": "own", "reading": first_length, "threshold": 4.0},
    ),
    "Job": (fa.Job, {"model": HH, "initial_conditions": Z4, "integrate": MOTION}),
    "run": (
        ran,
        {"job": fa.Job(model=HH, initial_conditions=Z4, integrate=MOTION, options=fa.jobs.RunOptions(step=0.1))},
    ),
    "RungeKutta": (
        fa.schemes.RungeKutta,
        {"name": "e", "order": 1, "source": "Euler 1768", "a": ((),), "b": (1.0,), "c": (0.0,)},
    ),
    "Splitting": (
        fa.schemes.Splitting,
        {"name": "s", "order": 2, "source": "Strang 1968", "drift": (0.5, 0.5), "kick": (1.0,)},
    ),
    "TimeTransformed": (lambda **given: fa.integrate(WALLED, Z8, scheme=fa.TimeTransformed(**given), **REAL_TIME), {}),
    "TuneAccumulator": (fa.TuneAccumulator, {}),
    "TuneAccumulator.push": (accumulated, {"samples": TURNED}),
    "all_levels": (fa.quantum.all_levels, {"model": HARMONIC, "multiplets": 5}),
    "basins": (fa.basins, {"model": LOGISTIC._replace(r=3.2), "z0": [[0.3, 0.4]], "time": 40}),
    "bifurcation_diagram": (
        fa.chaos.bifurcation_diagram,
        {"model": LOGISTIC, "parameter": "r", "values": [3.2, 3.9], "x0": 0.3, "transient": 20, "iterates": 20},
    ),
    "chaos_map": (fa.chaos_map, {"model": HH, "z0": Z4, **REAL_TIME}),
    "chaotic_fraction": (fa.chaotic_fraction, {"model": own_case, "axes": ([1.0],), **REAL_TIME}),
    "class_diagram": (fa.quantum.class_diagram, {"model": HARMONIC, "m": [0, 2], "l": 0, "count": 2}),
    "coherent_packet": (
        fa.quantum.coherent_packet,
        {"model": HARMONIC, "z0": Z8[:, 0], "width": 0.7, "count": 12, "missing": 0.5},
    ),
    "constants_of_motion": (fa.constants_of_motion, {"model": BODY, "z": Z8}),
    "continuation": (
        fa.continuation,
        {"model": HH, "z0": CLOSED, "section": X, "energy": 0.1, "max_steps": 1, "max_time": 20.0, "ds": 1e-3, **FIXED},
    ),
    "count_deviation": (fa.quantum.count_deviation, {"levels": LEVELS, "smooth": staircase}),
    "diffusion_histogram": (fa.frequencies.diffusion_histogram, {"diffusion": [-9.0, -3.0, np.nan]}),
    "energy_grid": (fa.energy_grid, {"model": HH, "energy": 0.1, "section": X, "axes": ([0.0, 0.1], [0.0, 0.1])}),
    "energy_grid.by_name": (
        fa.energy_grid,
        {"model": HH, "energy": 0.1, "axes": {"x": [0.0, 0.1]}, "solve": "p_y", "fixed": {"y": 0.1}, "sign": -1},
    ),
    "energy_grid.at_rest": (fa.energy_grid, {"model": HH, "energy": 0.1, "axes": {"phi": [0.3, 1.0]}, "at_rest": True}),
    "energy_of_actions": (fa.energy_of_actions, {"model": HARMONIC, "J": J, "threads": 1}),
    "energy_sample": (fa.energy_sample, {"model": HH, "energy": 0.1, "section": X, "orbits": 3}),
    "energy_sample.surface": (
        fa.energy_sample,
        {"model": HH, "energy": 0.1, "orbits": 3, "axes": {"x": (-0.1, 0.1), "y": (0.0, 0.1)}},
    ),
    "energy_sample.at_rest": (
        fa.energy_sample,
        {"model": HH, "energy": 0.1, "orbits": 3, "at_rest": True, "fixed": {"x": 0.1}},
    ),
    "exact_levels": (fa.quantum.exact_levels, {"model": HARMONIC, **NQ}),
    "exact_levels.max_energy": (fa.quantum.exact_levels, {"model": HARMONIC, "max_energy": 4.0}),
    "exact_levels.multiplets": (fa.quantum.exact_levels, {"model": HARMONIC, "multiplets": 4}),
    "affine_spectrum": (
        fa.quantum.affine_spectrum,
        {"model": fa.models.AffineBody("both", A=1.0), "m": 4, "l": -2, "count": 1, "hbar": 1.0, "tolerance": 1e-8},
    ),
    "shear_factor": (fa.quantum.shear_factor, {"b": [0.1, 1.0], "n": 0, "m": 2, "l": -2}),
    "unitary_levels": (fa.quantum.unitary_levels, {"k": 1, "j": 0.5, "inertia": 1.0, "c": 0.0, "hbar": 1.0}),
    "unitary_levels.max_energy": (fa.quantum.unitary_levels, {"max_energy": 4.0}),
    "unitary_levels.multiplets": (fa.quantum.unitary_levels, {"multiplets": 3}),
    "unitary_wave": (fa.quantum.unitary_wave, {"q": [0.1, 0.2, 0.3, 0.4], "k": 1, "j": 0.5, "m": 1, "l": -1}),
    "UnitaryBody": (fa.models.UnitaryBody, {"potential": "h*cos(Theta)", "inertia": 1.0, "c": 0.5, "h": 1.0}),
    "find_periodic_orbits": (
        fa.find_periodic_orbits,
        {"model": HH, "z0": Z4, "section": X, "max_crossings": 1, "scan_crossings": 8, "max_time": 60.0, **FIXED},
    ),
    "fit_spacings": (fa.quantum.fit_spacings, {"spacings": np.diff(LEVELS), "law": fa.quantum.Brody}),
    "fit_samples": (fa.tori.fit_samples, {"samples": LONG, "dt": 0.1}),
    "map_samples": (fa.sections.map_samples, {"samples": LONG, "dt": 0.1, "section": "q1=0"}),
    "series_exponent": (fa.chaos.series_exponent, {"series": SERIES}),
    "fit_torus": (fa.fit_torus, {"model": HH, "z0": Z4[:, 0], "time": 60.0, "step": 0.1}),
    "fit_torus.map": (fa.fit_torus, {"model": fa.models.maps.StandardMap(0.5), "z0": [0.2, 2.1], "time": 300.0}),
    "ode": (fa.ode, {"text": "x' = k*y; y' = -x; z' = x*y - z", "k": 1.0}),
    "affine_body": (fa.affine_body, {"text": "k*(D1**2 + D2**2)", "k": 1.0}),
    "frequency_map": (fa.frequency_map, {"model": HH, "z0": Z4, **REAL_TIME, "time": 20.0}),
    "from_action_angles": (fa.from_action_angles, {"model": HARMONIC, "J": J, "theta": PHASE, "threads": 1}),
    "from_matrix": (fa.charts.from_matrix, {"phi": np.eye(2), "momentum": np.eye(2)}),
    "hamiltonian": (fa.hamiltonian, {"text": "k*(x**2 + y**2)", "masses": (1.0, 2.0), "k": 1.0}),
    "damped hamiltonian": (fa.hamiltonian, {"text": "k*(x**2 + y**2)", "friction": 0.1, "k": 1.0}),
    "charged hamiltonian": (
        fa.hamiltonian,
        {"text": "k*x**2", "vector_potential": {"y": "k*x**2/2"}, "masses": (1.0, 2.0), "k": 1.0},
    ),
    "TwoPolarBody": (fa.models.TwoPolarBody, {"potential": "C*(D1**2 + D2**2)", "inertia": 1.0, "C": 1.0}),
    "AffineBody": (fa.models.AffineBody, {"invariance": "left", "I": 1.0, "A": 0.5, "potential": "C*det", "C": 1.0}),
    "driven hamiltonian": (
        fa.hamiltonian,
        {"text": "k*(x**2 + y**2)*cos(t)", "masses": (1.0, 2.0), "drive_period": "2*pi", "k": 1.0},
    ),
    "VibrationState.density": (method("vibration", "density"), {"q": [0.1]}),
    "VibrationState.quanta": (method("vibration", "quanta"), {"modes": "local"}),
    "husimi": (fa.quantum.husimi, {"state": lambda: result("state")}),
    "integrate.flow": (fa.integrate, {"model": SPIRAL, "z0": np.ones((3, 2)), "time": 1.0, "samples": 2, "threads": 1}),
    "integrate": (fa.integrate, {"model": HH, "z0": Z4, **REAL_TIME}),
    "integrate.times": (fa.integrate, {"model": HH, "z0": Z4, **REAL_TIME, "samples": np.array([0.3, 1.0, 1.7])}),
    "islands": (fa.islands, {"points": POINTS, "max_islands": 4}),
    "level_diagram": (fa.quantum.level_diagram, {"make": own_harmonic, "values": [1.0, 2.0], **Q, "count": 2}),
    "level_list": (fa.quantum.level_list, {"classes": lambda: [result("levels")]}),
    "iterated_map": (fa.iterated_map, {"text": "p1 = p + K*sin(x); x1 = x + p1", "periodic": {"x": "2*pi"}, "K": 1.0}),
    "mean_spacing_ratio": (fa.quantum.mean_spacing_ratio, {"spectra": [LEVELS]}),
    "naff": (fa.naff, {"signal": RING, "dt": 0.1, "lines": 2}),
    "number_packet": (fa.quantum.number_packet, {"model": HARMONIC, "n": (3, 2), **Q, "width": (1.0, 0.0)}),
    "number_variance": (fa.quantum.number_variance, {"unfolded": LEVELS, "lengths": [1.0, 2.0]}),
    "univariate": (fa.univariate, {"value": square, "slope": double}),
    "orbit_families": (
        fa.frequencies.orbit_families,
        {
            "frequency_map": lambda: fa.frequency_map(HH, Z4, time=20.0, **FIXED),
            "max_order": 4,
            "model": HH,
            "z0": Z4,
            "threads": 1,
        },
    ),
    "orbit_frequencies": (fa.orbit_frequencies, {"samples": SLOW, "dt": 0.1}),
    "periodic_guesses": (fa.periodic.periodic_guesses, {"section_map": lambda: result("guessable"), "crossings": 1}),
    "periodic_orbits": (
        fa.periodic_orbits,
        {"model": HH, "z0": CLOSED, "section": X, "energy": 0.1, "max_time": 20.0, **FIXED},
    ),
    "periodic_orbits.flow": (
        fa.periodic_orbits,
        {"model": SPIRAL, "z0": np.ones((3, 2)), "section": "y=0", "max_time": 20.0, "iterations": 3, "threads": 1},
    ),
    "poincare_map": (fa.poincare_map, {"model": HH, "z0": Z4, "section": X, "crossings": 2, "max_time": 30.0, **FIXED}),
    "polynomial_count": (fa.quantum.polynomial_count, {"levels": LEVELS}),
    "projected_packet": (
        fa.quantum.projected_packet,
        {"model": HARMONIC, "function": gauss, **Q, "count": 10, "missing": 0.9},
    ),
    "quantizations": (fa.quantum.quantizations, {"model": HARMONIC, **NQ}),
    "quasiclassical_levels": (fa.quantum.quasiclassical_levels, {"model": HARMONIC, **NQ}),
    "quasiclassical_levels.max_energy": (fa.quantum.quasiclassical_levels, {"model": HARMONIC, "max_energy": 4.0}),
    "ratio_web": (fa.frequencies.ratio_web, {"x": (0.5, 1.5), "y": (0.5, 1.5), "max_order": 3}),
    "reduced_body": (fa.reduced_body, {"model": BODY, "p_eta": 0.1, "p_gamma": 0.2}),
    "resonances": (fa.resonances, {"nu": frequencies(), "max_order": 4, "threads": 1}),
    "revivals": (fa.quantum.revivals, {"model": HARMONIC, "n": (3, 2), **Q}),
    "rotation_number": (fa.rotation_number, {"points": POINTS}),
    "scheme_named": (fa.schemes.scheme_named, {"name": "KAHAN_LI8"}),
    "spacing_ratios": (fa.quantum.spacing_ratios, {"levels": LEVELS}),
    "spectrum": (fa.quantum.spectrum, {"model": HARMONIC, **Q, "count": 2}),
    "spectrum.angular": (fa.quantum.spectrum, {"model": ANGULAR, "n_eta": 1, "n_gamma": 0, "count": 2}),
    "spectrum_table": (fa.quantum.spectrum_table, {"model": HARMONIC, "m": [0], "l": [0], "count": 2}),
    "tangent_map.flow": (fa.tangent_map, {"model": SPIRAL, "z0": np.ones((3, 2)), "time": 1.0, "threads": 1}),
    "tangent_map": (fa.tangent_map, {"model": HH, "z0": Z4, **REAL_TIME}),
    "to_matrix": (fa.charts.to_matrix, {"z": Z8}),
    "action_angles": (fa.action_angles, {"model": BODY, "z0": Z8, "threads": 1}),
    "tunes": (fa.tunes, {"samples": TURNED}),
    "unfold": (fa.quantum.unfold, {"levels": LEVELS, "smooth": staircase}),
    "wavefunction": (fa.quantum.wavefunction, {"model": HARMONIC, **Q, "n": (0, 0)}),
    "resonance_web": (
        fa.resonance_web,
        {"nu": np.array(np.meshgrid([0.2, 0.3, 0.4], [0.21, 0.33, 0.4])), "max_order": 3},
    ),
    "weyl_count": (fa.quantum.weyl_count, {"model": HARMONIC, "energy": [3.0], **Q}),
    "ChaoticFraction.interval": (method("scan", "interval"), {}),
    "EnergyGrid.to_grid": (method("grid", "to_grid"), {"values": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]}),
    "LevelTable.below": (method("all", "below"), {"energy": 4.5}),
    "LevelTable.multiplets": (method("all", "multiplets"), {}),
    "LevelTable.state": (method("levels", "state"), {"k": 0}),
    "LevelTable.take": (method("all", "take"), {"items": [0, 2]}),
    "LevelTable.upto": (method("all", "upto"), {"count": 2}),
    "Multiplets.labels": (method("multiplets", "labels"), {"k": 0}),
    "Multiplets.members": (method("multiplets", "members"), {"k": 0}),
    "Packet.amplitude": (method("packet", "amplitude"), {"x": [1.0], "y": [0.5]}),
    "Packet.at": (method("packet", "at"), {"q": [1.0, 0.5, 0.1, 0.2]}),
    "Packet.autocorrelation": (method("packet", "autocorrelation"), {"time": [0.0, 1.0]}),
    "Packet.density": (method("packet", "density"), {"x": [1.0], "y": [0.5]}),
    "Packet.evolved": (method("packet", "evolved"), {"time": 1.0}),
    "Packet.expectation": (method("packet", "expectation"), {"function": gauss}),
    "Packet.planes": (method("packet", "planes"), {"planes": [1.0, 0.5, 0.1, 0.2]}),
    "PeriodicOrbits.take": (method("orbits", "take"), {"items": [0]}),
    "SectionMap.take": (method("cut", "take"), {"items": [0]}),
    "OrbitFamilies.label": (method("families", "label"), {"orbit": 0}),
    "Resonances.label": (method("resonances", "label"), {"orbit": 0}),
    "SectionMap.coordinates": (method("cut", "coordinates"), {"chart": fa.charts.ALPHA_BETA}),
    "State.amplitude": (method("state", "amplitude"), {"x": [1.0], "y": [0.5]}),
    "State.at": (method("state", "at"), {"q": [1.0, 0.5, 0.1, 0.2]}),
    "State.density": (method("state", "density"), {"x": [1.0], "y": [0.5]}),
    "State.expectation": (method("state", "expectation"), {"function": gauss}),
    "State.norm": (method("state", "norm"), {}),
    "State.overlap": (method("state", "overlap"), {"other": lambda: result("state")}),
    "State.planes": (method("state", "planes"), {"planes": [1.0, 0.5, 0.1, 0.2]}),
    "TorusFit.evaluate": (method("fit", "evaluate"), {"theta": [[0.1], [0.2]]}),
    "TorusFit.in_basis": (method("fit", "in_basis"), {"M": np.eye(2, dtype=int)}),
    "TorusFit.truncated": (method("fit", "truncated"), {"order": 3}),
}
for _kind in OF_BODIES.values():
    CALLS.setdefault(_kind.__name__, (partial(cut_by, _kind), {"constant": 1.0}))
for _kind in map(type, INDICATORS.values()):
    CALLS.setdefault(_kind.__name__, (partial(judged, _kind), {}))
for _name, _make in fa.formulas.systems.SYSTEMS.items():
    _given = {name: p.default for name, p in signature(_make).parameters.items()}
    CALLS.setdefault(_name, (_make, {name: value for name, value in _given.items() if isinstance(value, float | str)}))

FILES = {"explore", "load", "rerun", "resume", "save", "show_progress"}
"""Functions that accept a file name, tested in results/test_recipe.py, jobs/test_jobs.py and explorer/test_engine.py,
and the one that silences calls.
"""

CONTAINERS = {
    *(
        "Bifurcation",
        "AttractorKind",
        "Basins",
        "BifurcationDiagram",
        "Branch",
        "ChaosMap",
        "ChaoticFraction",
        "EnergyOfActions",
        "FrequencyMap",
        "EnergyGrid",
    ),
    *("Husimi", "Islands", "LevelDiagram", "LevelTable", "FrequencyLines", "MeanRatio", "Multiplets"),
    *(
        "OrbitFamilies",
        "OrbitFamily",
        "Orbits",
        "Packet",
        "PeriodicOrbits",
        "Quantizations",
        "Resonances",
        "Revivals",
        "Rotation",
        "EnergySample",
    ),
    *(
        "SectionMap",
        "SeriesExponent",
        "SpacingFit",
        "State",
        "TangentMap",
        "TimeScales",
        "VibrationHusimi",
        "VibrationState",
    ),
    *(
        "ActionAngles",
        "AffineSpectrum",
        "TorusFit",
        "AngleLines",
        "TuneSums",
        "Tunes",
        "ResonanceLine",
        "Classification",
        "Shares",
    ),
    *("Event", "Interrupted", "NoGroundState", "NotReached", "OrbitError", "Stability", "Status"),
}
"""Results, which hold what a function put there, enumerations and exceptions."""

FORMULAS = {
    *("value", "slopes", "radii", "leaning", "curvatures", "margin", "poles", "slope", "curvature", "at"),
    *("velocity", "force", "tangent_force", "kinetic_energy", "potential_energy", "squares", "from_planes"),
    *("to_planes", "interval", "of", "changes", "integrals", "constants", "cofactors", "mixed_cofactors"),
    *("matrix_value", "matrix_slopes", "matrix_changes", "matrix_margin", "matrix_invariants", "in_space"),
    *("stretch_value", "stretch_slopes", "stretch_changes", "stretch_margin", "turned_columns", "singular_columns"),
    *("divided_slopes", "energy", "rates", "tangent_rates"),
}
"""Methods of models and sections: arithmetic that kernels compile, without checks; and of shares, which the battery
calls through their results.
"""


fa_parts = (fa.runs, fa.frequencies, fa.sections, fa.chaos, fa.periodic, fa.tori)
"""Parts of the package with results of their own."""

PUBLIC = {name: getattr(home, name) for home in (fa, *fa_parts, fa.quantum) for name in home.__all__}
PUBLIC |= {name: getattr(fa.charts, name) for name in ("from_matrix", "to_matrix", "from_two_polar3", "two_polar3")}
PUBLIC |= {name: getattr(fa.models, name) for name in ("BreathingBody", "ReducedBody", "StackelBody", "Zero")}
PUBLIC |= {name: getattr(fa.molecules, name) for name in ("HarmonicBond", "LennardJones", "MorseBond")}
PUBLIC |= {name: getattr(fa.molecules, name) for name in ("molecule", "ring")}
PUBLIC |= {
    name: getattr(fa.models, name)
    for name in (
        *("Body3", "GasCloud", "MooneyRivlin3", "NeoHookean3", "Ogden3", "SelfGravity", "formula3", "reduced_body3"),
        *("relative_equilibrium", "riemann_ellipsoid"),
    )
}
PUBLIC |= fa.formulas.systems.SYSTEMS
PUBLIC |= {kind.__name__: kind for kind in OF_BODIES.values()}
PUBLIC |= {
    name: getattr(fa.schemes, name) for name in ("Automatic", "Algebraic", "Exponential", "Logistic", "RungeKutta")
}
PUBLIC |= {name: getattr(fa.schemes, name) for name in ("Splitting", "scheme_named")}

INDICATOR = {"vectors", "default", "calm", "check", "watch", "compute", "reads"}
"""Methods of indicators that `chaos_map` and figures call: tests/chaos/test_own_indicators.py."""


def discovered():
    """Names of the public functions and classes, and of their methods that take arguments."""
    for name, entry in PUBLIC.items():
        if not (isfunction(entry) or isclass(entry)):
            continue
        if name not in CONTAINERS | FILES:
            yield name
        if isclass(entry):
            hidden = FORMULAS if hasattr(entry, "_fields") else {"choose", "suited", *INDICATOR}
            for method, function in vars(entry).items():
                public = isfunction(function) and not method.startswith("_") and method not in hidden
                if public and len(signature(function).parameters) > 1:
                    yield f"{name}.{method}"


def arguments(name):
    """Names of the arguments of a call."""
    return list(dict.fromkeys([*(p.name for p in _parameters(name)), *CALLS[name][1]]))


def defaults(name):
    """Values that the arguments of a call have by themselves."""
    return {p.name: p.default for p in _parameters(name) if p.default is not Parameter.empty}


def _parameters(name):
    taken = CALLS[name][0]
    while isinstance(taken, partial):
        taken = taken.args[0]
    if getattr(taken, "__name__", "") == "call":
        owner, _, method = name.partition(".")
        taken = getattr(PUBLIC[owner], method)
    elif getattr(taken, "__name__", "") == "<lambda>":
        taken = PUBLIC[name]
    kinds = (Parameter.VAR_KEYWORD, Parameter.VAR_POSITIONAL)
    return [p for p in signature(taken).parameters.values() if p.kind not in kinds and p.name != "self"]


# --- values -------------------------------------------------------------------------------------------------------


class Thing:
    """Nothing in particular."""

    def __repr__(self):
        return "Thing()"


class Quantity(np.ndarray):
    """Numbers with a unit, as Astropy's are: NumPy strips the unit in silence, and a single one of no unit alone is a
    float.
    """

    def __new__(cls, value, unit):
        found = np.asarray(value).view(cls)
        found.unit = unit
        return found

    def __array_finalize__(self, source):
        self.unit = getattr(source, "unit", "")

    def __getitem__(self, key):
        return Quantity(np.asarray(self)[key], self.unit)

    def __repr__(self):
        return f"<Quantity {np.asarray(self)} {self.unit}>"

    def __float__(self):
        if self.unit not in ("", "%"):
            raise TypeError("only dimensionless scalar quantities can be converted to Python scalars")
        return float(np.asarray(self)) / (100 if self.unit else 1)


def _nested(depth):
    found = (1.0,)
    for _ in range(depth):
        found = (found,)
    return found


VALUES = {
    "none": None,
    "empty text": "",
    "text": "x",
    "nan text": "nan",
    "bytes": b"1",
    "object": Thing(),
    "class": int,
    "function": square,
    "builtin": len,
    "complex": 1j,
    "true": True,
    "false": False,
    "nan": np.nan,
    "inf": np.inf,
    "-inf": -np.inf,
    "0": 0,
    "-1": -1,
    "1": 1,
    "7": 7,
    "0.0": 0.0,
    "2.7": 2.7,
    "-2.7": -2.7,
    "1e-300": 1e-300,
    "1e-18": 1e-18,
    "1e18": 1e18,
    "1e300": 1e300,
    "-1e300": -1e300,
    "10**6": 10**6,
    "10**12": 10**12,
    "10**18": 10**18,
    "-10**18": -(10**18),
    "2**63": 2**63,
    "2**64": 2**64,
    "10**400": 10**400,
    "float16": np.float16(0.5),
    "longdouble": np.longdouble(1) / 3,
    "fraction": Fraction(1, 3),
    "decimal": Decimal("0.3"),
    "date": np.datetime64("2020-01-01"),
    "[]": [],
    "()": (),
    "{}": {},
    "set": {1.0, 2.0},
    "range": range(3),
    "pair": (1.0, 2.0),
    "nested pair": ((1.0, 2.0), (3.0, 4.0)),
    "ragged": [[1.0, 2.0], [3.0]],
    "deep": _nested(40),
    "deeper": _nested(100),
    "list of text": ["a", "b"],
    "list of none": [None, None],
    "list of big": [10**400, 1],
    "dictionary": {"x": 1.0},
    "empty array": np.zeros(0),
    "no orbits": np.zeros((8, 0)),
    "no rows": np.zeros((0, 8)),
    "cube": np.ones((3, 3, 3)),
    "many dimensions": np.ones((1,) * 12),
    "objects": np.array([1, None, "a"], object),
    "masked": np.ma.masked_array([1.0, 2.0], [True, False]),
    "structured": np.zeros(2, [("a", float)]),
    "array of text": np.array(["a", "b"]),
    "scalar array": np.array(0.5),
    "generator": (i for i in ()),
    "body": BODY,
    "bare potential": fa.Hyperelastic(),
    "ball": HH,
    "body of nan": fa.Body(fa.Hyperelastic(np.nan)),
    "body of text": fa.Body(fa.Hyperelastic("x")),
    "body of none": fa.Body(None),
    "body of a number": fa.Body(1.0),
    "body of big": fa.Body(fa.Hyperelastic(10**400)),
    "body of a tuple": fa.Body(fa.Hyperelastic((1.0, 2.0))),
    "body of mu 0": fa.Body(fa.Hyperelastic(), 0.0),
    "body of mu 1e300": fa.Body(fa.Hyperelastic(), 1e300),
    "body class": fa.Body,
    "body of 1e300": fa.Body(fa.Hyperelastic(1e300)),
    "scheme": fa.RK4,
    "transformed": fa.TimeTransformed(),
    "automatic": fa.AUTO,
    "section": TURN,
    "nested section": fa.Hyperplane(((1.0, 0.0), 0.0, 0.0, 0.0)),
    "tuple section": fa.AlphaEquals((1.0, 2.0)),
    "section of text": fa.AlphaEquals("1"),
    "section of a wrong direction": fa.Hyperplane((1.0, 0, 0, 0), 0.0, "up"),
    "section of a tuple direction": fa.AlphaTurning((1, 2)),
    "indicator": fa.MEGNO(),
    "indicators": (fa.MEGNO("x"),),
    "indicator twice": (fa.SALI(), fa.SALI()),
    "chart": fa.charts.ALPHA_BETA,
    "status": fa.Status.OK,
}
"""What may take the place of any argument."""


def like(value):
    """What may take the place of an array: its shape or kind or numbers wrong, or right in an unusual form."""
    if callable(value):
        return {}
    try:
        array = np.asarray(value, float) if not np.iscomplexobj(value) else np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return {}
    if array.ndim == 0 or array.size == 0:
        return {}
    changed = {
        "a nan": np.where(np.arange(array.size).reshape(array.shape) == 0, np.nan, array),
        "infinite": np.full(array.shape, np.inf),
        "1e300 each": np.full(array.shape, 1e300),
        "1e-300 each": np.full(array.shape, 1e-300),
        "zeros": np.zeros(array.shape),
        "negative": -array,
        "complex each": array * 1j,
        "booleans": array != 0,
        "texts": array.astype(str),
        "objects each": array.astype(object),
        "one less": array[:-1],
        "twice": np.concatenate([array, array]),
        "doubled": np.stack([array, array]),
        "single": array.astype(np.complex64 if np.iscomplexobj(array) else np.float32),
        "as list": array.tolist(),
        "masked array": np.ma.masked_array(array, array == array.max(initial=0.5)),
        "backwards": array[::-1],
        "big integers": np.full(array.shape, 2**62),
        "in columns": np.asfortranarray(array),
        "bytes each": array.astype("S8"),
        "10**400 each": np.full(array.shape, 10**400, object).tolist(),
    }
    if array.ndim > 1:
        changed["transposed"] = array.T
    return {f"argument with {name}" if not name.startswith("as") else name: entry for name, entry in changed.items()}


OTHERS = {("EnergyGrid.to_grid", "values"), ("PeriodicOrbits.take", "items"), ("SectionMap.take", "items")}
"""Arguments that take other things than real numbers too: values of any kind, masks."""


def astray(value):
    """What looks like a number or an array of them, and is it only if a part of it is thrown away."""
    if isinstance(value, (bool, np.bool_)) or callable(value):
        return {}
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return {}
    if array.dtype.kind not in "iufc" or not array.size:
        return {}
    rows = list(array) if array.ndim else []
    hidden = np.ma.masked_array(array, np.arange(array.size).reshape(array.shape) == 0)
    found = {
        "in degrees": Quantity(array, "deg"),
        "in percent": Quantity(100 * array, "%"),
        "in a list, in degrees": [Quantity(row, "deg") for row in rows],
        "in a tuple, in percent": tuple(Quantity(row, "%") for row in rows),
        "in a list, masked": [hidden[k] for k in range(len(rows))],
        "in a list, one of them true": [bool(rows[0].all()), *array[1:].tolist()] if array.ndim == 1 else [],
        "in a list, all of them true": np.ones(array.shape, bool).tolist() if rows else [],
    }
    if array.dtype.kind != "c":
        found |= {
            "complex64": array.astype(np.complex64)[()] + np.complex64(1j),
            "clongdouble": array.astype(np.clongdouble)[()] + np.clongdouble(1j),
            "complex list": (array + 1j).tolist(),
        }
    if not array.ndim:
        found |= {
            "complex of no dimensions": np.array(complex(array, 1.0)),
            "true of no dimensions": np.array(True),
            "text of no dimensions": np.array(str(value)),
            "seconds": np.timedelta64(5, "s"),
            "masked": hidden,
        }
    return {name: entry for name, entry in found.items() if not isinstance(entry, (list, tuple)) or entry}


def numeric(name):
    """Arguments of a call that are numbers or arrays of them, given or by default, or nothing."""
    values = {key: usual(name, key) for key in arguments(name) if (name, key) not in OTHERS}
    return {key: value for key, value in values.items() if astray(value)}


def usual(name, argument):
    """What an argument of a call is, given or by default; a number where that is nothing."""
    value = CALLS[name][1].get(argument, defaults(name).get(argument))
    return 1.0 if value is None else value


def inputs():
    """Every input: (name of the call, argument, name of the value)."""
    for name, (_, given) in CALLS.items():
        for argument in arguments(name):
            for value in (*VALUES, *like(given.get(argument))):
                yield name, argument, value


def base(name):
    """The arguments that work; results among them are made when they are needed."""
    return {
        key: value() if getattr(value, "__name__", "") == "<lambda>" else value for key, value in CALLS[name][1].items()
    }


# --- judgement ----------------------------------------------------------------------------------------------------

LONG = {
    *(
        "time",
        "max_time",
        "step",
        "max_steps",
        "samples",
        "history",
        "crossings",
        "scan_crossings",
        "orbits",
        "levels",
        "count",
    ),
    *(
        "multiplets",
        "max_energy",
        "energy",
        "n",
        "period",
        "max_crossings",
        "max_islands",
        "axes",
        "accuracy",
        "tolerance",
        "order",
    ),
    "deviation_vectors",
}
"""Arguments that a user may make as long as he likes: such a run must only stop when it is told to."""
FUNCTIONS = {"callback", "judge", "make", "model", "law", "smooth", "function", "time", "value", "slope", "curvature"}
"""Arguments that are functions: what a given one raises is its own."""


class TooLong(BaseException):
    """The call took longer than it may."""


def _ring(_, frame):
    """Raise TooLong, but not while something is compiled, which is not the input's doing, nor in callbacks, which
    swallow exceptions, nor where a file may be open that nobody has yet.
    """
    signal.setitimer(signal.ITIMER_PROF, 0.5)
    while frame is not None:
        code = frame.f_code
        compiled = any(f"{os.sep}{compiler}{os.sep}" in code.co_filename for compiler in ("numba", "llvmlite"))
        callback = code.co_name == "__del__" or f"{os.sep}weakref" in code.co_filename
        if compiled or callback or f"{os.sep}pathlib" in code.co_filename:
            return
        frame = frame.f_back
    raise TooLong


OF_TEXTS = (
    *("ode", "affine_body", "hamiltonian", "charged hamiltonian", "damped hamiltonian", "driven hamiltonian"),
    *("iterated_map", "formula3"),
)
"""Callables that take a text first, by its place."""


def call(name, given):
    """The result of a callable with these arguments."""
    first = [given.pop("text")] if name in OF_TEXTS else []
    return CALLS[name][0](*first, **given)


def _fields(value):
    """Return the names of all parameters of a model, those of its parts too, by which a refusal may call them."""
    if isinstance(value, type) or not isinstance(value, tuple) or not hasattr(value, "_fields"):
        return []
    return [*value._fields, *(name for part in value for name in _fields(part))]


def outcome(name, *replaced):
    """Call with arguments replaced, each by the name of a value; return "accepted", "refused", or what is wrong in
    words.

    A refusal names one of these arguments, or another one of the call that it does not go with, and says so once.
    """
    given, wanted = base(name), [argument for argument, _ in replaced]
    for argument, value in replaced:
        if value in VALUES:
            given[argument] = VALUES[value]
        elif argument in given and value in (others := like(given[argument])):
            given[argument] = others[value]
        else:
            given[argument] = astray(usual(name, argument))[value]
    known = {*arguments(name), *wanted, *(field for argument in wanted for field in _fields(given[argument]))}
    names = "|".join(re.escape(other.rstrip("s")) for other in known)
    own = any(argument in FUNCTIONS and callable(given[argument]) for argument in wanted)
    long = any(argument in LONG for argument in wanted)
    timed = threading.current_thread() is threading.main_thread() and hasattr(signal, "setitimer")
    before = signal.signal(signal.SIGPROF, _ring) if timed else None
    if timed:
        signal.setitimer(signal.ITIMER_PROF, 0.5 if long else SECONDS)
    began = time.process_time()
    try:
        with warnings.catch_warnings(), np.errstate(**np.geterr()):  # the clock may ring in another's that then stays
            warnings.simplefilter("error")
            try:
                repr(call(name, given))
            finally:  # else it may ring while the outcome is judged, after a call that was compiled
                if timed:
                    signal.setitimer(signal.ITIMER_PROF, 0)
        return "accepted"
    except TooLong:
        took = time.process_time() - began
        return "accepted" if long and took < SECONDS else f"took more than {SECONDS:g} s"
    except (TypeError, ValueError, IndexError) as problem:
        text = str(problem)
        if not re.search(rf"(?<![a-zA-Z])({names})(?![a-rt-zA-Z])", text) and not own:
            return f"{type(problem).__name__} without the name {' or '.join(map(repr, wanted))}: {text[:200]}"
        if again := re.search(r"(\b\w+ (?:must|takes) ).*\1", text):
            return f"says twice {again[1]!r}: {text[:200]}"
        return "refused" if len(text) < 3000 else f"a message of {len(text)} characters"
    except Exception as problem:
        return "refused" if own else f"{type(problem).__name__}: {str(problem)[:200]}"
    finally:
        if timed:
            signal.signal(signal.SIGPROF, before)
