"""Equations of motion and friction on the command line and in jobs: the library's own numbers, and what is refused."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.jobs.analyses import ChaosOptions, IntegrateOptions, PoincareOptions
from fastaff.jobs.job import Job
from fastaff.jobs.launch import InitialConditions
from fastaff.jobs.system import EnergySurface, Model, described

pytest.importorskip("cyclopts")
pytest.importorskip("matplotlib")

from fastaff.cli.main import main
from fastaff.systems.models.mechanics import system_of

LORENZ = "x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z"
PARAMETERS = ["s=10", "r=28", "b=8/3"]
GIVEN = ["--ode", LORENZ, *(word for entry in PARAMETERS for word in ("--parameter", entry))]
PLACED = ["--axes", "x=1:9:3", "--fixed", "y=2", "--fixed", "z=20"]


def lorenz():
    return fa.ode(LORENZ, s=10.0, r=28.0, b=8 / 3)


def test_a_section_of_a_flow(here, capsys):
    assert main(["poincare", *GIVEN, *PLACED, "--section", "z=27", "--crossings", "12", "--max-time", "60"]) == 0
    found = fa.load("fastaff-poincare.npz")
    z0 = np.array([1 + 8 * (np.arange(3) + 0.5) / 3, [2.0] * 3, [20.0] * 3])
    truth = fa.poincare_map(lorenz(), z0, section="z=27", crossings=12, max_time=60.0)
    assert np.array_equal(found.times, truth.times, equal_nan=True)
    assert np.array_equal(found.points, truth.points, equal_nan=True)
    assert (found.counts == 12).all()


def test_a_spectrum_of_a_flow(here):
    assert main(["chaos-map", *GIVEN, *PLACED, "--time", "50", "--indicators", "spectrum", "--no-figure"]) == 0
    spectrum = fa.load("fastaff-chaos-map.npz").spectrum
    assert spectrum.shape == (3, 3)
    assert np.allclose(spectrum.sum(axis=0), -(10 + 1 + 8 / 3), rtol=0, atol=1e-8)  # the divergence


def test_friction(here):
    grid = ["--axes", "x=-1:1:2", "--axes", "p_x=0.5:1:2"]
    words = ["--hamiltonian=-cos(x)", "--coordinates", "x", "--friction", "g/2", "--parameter", "g=0.25"]
    how = ["--time", "30", "--indicators", "spectrum", "--no-figure"]
    assert main(["chaos-map", *words, *grid, *how]) == 0
    spectrum = fa.load("fastaff-chaos-map.npz").spectrum
    assert np.allclose(spectrum.sum(axis=0), -0.125, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "value",
    [
        lorenz(),
        fa.hamiltonian("x**2/2 + k*x**4", coordinates="x", friction=0.1, k=0.3),
        fa.hamiltonian("x**2/2 + k*x**4", coordinates="x", friction="k/3", k=0.3),
    ],
    ids=["flow", "friction", "formula of friction"],
)
def test_jobs_carry_them(value):
    options = described(system_of(value))
    assert options is not None
    assert options.build() == value
    rows = len(value.coordinates) + (value.degrees_of_freedom if hasattr(value, "momenta") or options.friction else 0)
    z0 = np.random.default_rng(3).normal(size=(rows, 5))
    job = Job(model=value, energy_surface=EnergySurface(), initial_conditions=z0, integrate=IntegrateOptions(time=5.0))
    found = fa.run(job)["integrate"]
    assert np.array_equal(found.z, fa.integrate(value, z0, time=5.0, samples=found.samples.shape[0]).z)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([*GIVEN, *PLACED, "--energy", "1"], "--energy is for systems that keep one"),
        (
            [*GIVEN, "--section", "z=27"],
            "--grid requires a section of a body or of a system of two coordinates. Use --axes NAME=LOW:HIGH:N.",
        ),
        ([*GIVEN, "--axes", "u=0:1:3"], "u"),
        ([*GIVEN, *PLACED, "--section", "w=1"], "section"),
        ([*GIVEN, *PLACED, "--coordinates", "x y z"], "--coordinates belongs to --hamiltonian"),
        ([*GIVEN, *PLACED, "--friction", "0.1"], "--friction belongs to --hamiltonian"),
        ([*GIVEN, *PLACED, "--map", "x1 = x"], "give one of"),
        (
            [*GIVEN, "--axes", "x=1:9:3", "--solve", "z"],
            "--solve is not supported for ODE systems, which have no energy, got 'z'",
        ),
        (["--ode", "x = y", *PLACED], "--ode"),
        (["--ode", "x' = k*x", "--axes", "x=1:2:3"], "unknown name 'k' at column 2"),
        (["--ode", "x' = k*x", "--axes", "x=1:2:3"], "Use --parameter k=VALUE."),
        (["--map", "x1 = x + q; p1 = p"], "--map, x1: unknown name 'q'"),
        (["--map", "x1 = a*x - x**3", "--axes", "x=0:1:3"], "Use --parameter a=VALUE."),
        (["--model", "henon-heiles", "--friction", "0.1"], "--friction belongs to"),
    ],
)
def test_what_is_refused(words, says, capsys, here):
    assert main(["poincare", *words]) == 2
    assert says in capsys.readouterr().err
    assert not list(here.iterdir())


def test_options_of_tables():
    asked = Job(
        model=Model(ode=LORENZ, parameter=PARAMETERS),
        energy_surface=EnergySurface(section="z=27"),
        initial_conditions=InitialConditions(axes=["x=1:9:3"], fixed=["y=2", "z=20"]),
        poincare=PoincareOptions(crossings=3, max_time=30.0),
        chaos_map=ChaosOptions(time=20.0, indicators="spectrum"),
    )
    found = fa.run(asked)
    assert found["poincare"].points.shape[0] == 3
    assert found["chaos_map"].spectrum.shape == (3, 3)
