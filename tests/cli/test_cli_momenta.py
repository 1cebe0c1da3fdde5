"""H(q, p) on the command line and in jobs: the library's own numbers, interrupted jobs, and what is refused."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.jobs.analyses import ChaosOptions
from fastaff.jobs.chunks import compute_chunk
from fastaff.jobs.job import Job
from fastaff.jobs.launch import InitialConditions
from fastaff.jobs.running import begin
from fastaff.jobs.system import SYSTEMS, EnergySurface, Model, described
from fastaff.systems.models.double_pendulum import DoublePendulum

pytest.importorskip("cyclopts")
pytest.importorskip("matplotlib")

from fastaff.cli.main import main
from fastaff.systems.models.mechanics import system_of

DOUBLE = "(p1**2 + 2*p2**2 - 2*p1*p2*cos(q1-q2))/(2*(1 + sin(q1-q2)**2)) - 2*g*cos(q1) - g*cos(q2)"
TEXT = [f"--hamiltonian={DOUBLE}", "--coordinates", "q1 q2", "--momenta", "p1 p2", "--parameter", "g=1"]
TEXT += ["--periodic", "q1=2*pi", "--periodic", "q2=2*pi"]
ENERGY = ["--energy", "-1.2", "--no-figure"]


def pendulum():
    turns = {"q1": "2*pi", "q2": "2*pi"}
    return fa.hamiltonian(DOUBLE, coordinates="q1 q2", momenta="p1 p2", periodic=turns, g=1.0)


@pytest.mark.parametrize("words", [TEXT, ["--model", "double-pendulum", "--parameter", "g=1"]], ids=["text", "named"])
def test_a_section_of_random_starts(here, words):
    how = ["--orbits", "5", "--seed", "3", "--crossings", "10", "--max-time", "200"]
    assert main(["poincare", *words, "--energy", "-1.2", *how]) == 0
    found = fa.load("fastaff-poincare.npz")
    model = pendulum() if words is TEXT else DoublePendulum()
    surface = EnergySurface(energy=-1.2)
    launch = InitialConditions(orbits=5, seed=3).launch(
        system_of(model), surface.build(system_of(model)), surface, "3x3"
    )
    truth = fa.poincare_map(model, launch.points(0)[0], section="q1=0", crossings=10, max_time=200.0)
    np.testing.assert_array_equal(found.points, truth.points)
    assert (found.counts == 10).all()
    np.testing.assert_allclose(model.energy(*found.points), -1.2, rtol=0, atol=1e-10)


def test_a_grid_of_named_rows_and_the_whole_surface(here):
    cells = {"q2": [-2 / 3, 0.0, 2 / 3], "p2": [-0.25, 0.25]}
    z0 = fa.energy_grid(pendulum(), energy=-1.2, axes=cells, solve="p1").z0
    truth = fa.chaos_map(pendulum(), z0, time=30.0)
    grid = ["--axes", "q2=-1:1:3", "--axes", "p2=-0.5:0.5:2", "--solve", "p1"]
    for starts in (grid, ["--orbits", "6", "--microcanonical"]):
        assert main(["chaos-map", *TEXT, *ENERGY, *starts, "--time", "30"]) == 0
        found = fa.load("fastaff-chaos-map.npz")
        assert len(found) == 6
        if starts is grid:
            np.testing.assert_allclose(found.megno, truth.megno, rtol=1e-6)


@pytest.mark.parametrize(
    "value",
    [
        pendulum(),
        DoublePendulum(m_1=2.0),
        fa.hamiltonian("p**2*(1 + x**2)/2 + x**2 + x*p*cos(t)", coordinates="x", momenta="p", drive_period="2*pi"),
        fa.hamiltonian("s**2/2 - k*cos(x)", coordinates="x", momenta="s", periodic={"x": "2*pi"}, k=0.5),
    ],
    ids=["text", "named", "driven", "separable"],
)
def test_models_are_described_as_options(value):
    found = described(system_of(value))
    assert found is not None
    assert found.build() == value
    assert type(found.build()) is type(value)


def test_a_job_that_was_stopped_has_the_bits_of_one_run(tmp_path):
    """Half of its units in another order, and the rest after that; in text form too."""
    job = Job(
        model=pendulum(),
        energy_surface=EnergySurface(energy=-0.5),
        initial_conditions=InitialConditions(grid="5x4"),
        chaos_map=ChaosOptions(time=20.0, indicators="megno"),
        chunk=3,
    )
    whole = fa.run(job, tmp_path / "whole")["chaos_map"]
    count = begin(job, tmp_path / "parts").chunks
    for number in range(count - 1, count // 2, -1):
        compute_chunk(str(tmp_path / "parts"), number, 1)
    parts = fa.resume(tmp_path / "parts")["chaos_map"]
    np.testing.assert_array_equal(whole.megno, parts.megno)
    assert len(whole) > 10


@pytest.mark.slow
@pytest.mark.parametrize("key", sorted(set(SYSTEMS) - {"double-pendulum", "kerr-geodesic"}))  # no text; a horizon
def test_named_systems_run_from_the_command_line(here, key):
    """A launch set on the energy of a point of theirs, by the library's own numbers."""
    model = Model(model=key).build()
    n, again = model.degrees_of_freedom, described(system_of(model))
    assert again is not None
    assert again.build() == model
    z = np.concatenate([np.linspace(1.1, 1.3, n), np.linspace(0.3, 0.5, n)])
    z = z.tolist()
    names, energy = (*model.coordinates, *model.momenta), float(model.energy(*z))
    words = ["chaos-map", "--model", key, f"--energy={energy!r}", "--solve", names[n], "--time", "5", "--no-figure"]
    words += ["--axes", f"{names[n + 1]}={z[n + 1] - 1e-3!r}:{z[n + 1] + 1e-3!r}:1"]
    for name, value in zip(names, z, strict=True):
        words += ["--fixed", f"{name}={value!r}"] if name not in names[n : n + 2] else []
    assert main(words) == 0
    assert len(fa.load("fastaff-chaos-map.npz")) == 1


def test_charges_in_a_vector_potential(here):
    """From the shell, and the same as a job's table, whose text keeps it."""
    B, k = np.random.default_rng(5).uniform(0.3, 0.9, 2).tolist()
    model = fa.hamiltonian("x**2 + y**2", vector_potential={"y": "B*x + k*x**2/2", "x": "-k*y"}, B=B, k=k)
    words = ["--hamiltonian", "x**2 + y**2", "--vector-potential", "y=B*x + k*x**2/2", "--vector-potential", "x=-k*y"]
    words += [f"--parameter=B={B!r}", f"--parameter=k={k!r}", "--energy", "0.4", "--orbits", "3", "--seed", "2"]
    assert main(["poincare", *words, "--section", "x=0", "--crossings", "4", "--max-time", "60", "--no-figure"]) == 0
    found = fa.load("fastaff-poincare.npz")
    starts = fa.energy_sample(model, energy=0.4, orbits=3, section="x=0", seed=2)
    truth = fa.poincare_map(model, starts, crossings=4, max_time=60.0)
    np.testing.assert_array_equal(found.points, truth.points)
    job = Job(
        model=Model(hamiltonian="x**2", coordinates="x y", vector_potential=["y=B*x"], parameter=["B=0.5"]),
        energy_surface=EnergySurface(energy=0.4),
        initial_conditions=InitialConditions(orbits=3),
        chaos_map=ChaosOptions(time=5.0),
    )
    again = Job.parsed(job.text())
    assert again.model == job.model
    assert again.model.build() == fa.hamiltonian("x**2", vector_potential={"y": "B*x"}, B=0.5)


def test_parameters_may_be_words():
    words = {"affine-body": "invariance=right", "kerr-geodesic": "time=mino", "asymmetric-top": "chart=quaternion"}
    made = (
        fa.models.AffineBody("right"),
        fa.models.KerrGeodesic(time="mino"),
        fa.models.AsymmetricTop(chart="quaternion"),
    )
    for (key, word), model in zip(words.items(), made):
        assert Model(model=key, parameter=[word]).build() == model


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([*TEXT[:3], "--momenta", "p1", "--energy", "1"], "--momenta must be 2 names"),
        (["--formula", "D1*D2", "--momenta", "p1 p2", "--energy", "1"], "--momenta belongs to --hamiltonian"),
        (["--formula", "D1*D2", "--vector-potential", "x=y", "--energy", "1"], "--vector-potential belongs to --ham"),
        (["--model", "double-pendulum", "--vector-potential", "x=y"], "--vector-potential belongs to --formula"),
        (
            ["--hamiltonian", "x**2", "--vector-potential", "y", "--energy", "1"],
            "--vector-potential must be NAME=FORMULA",
        ),
        (["--hamiltonian", "x**2", "--vector-potential", "z=x", "--energy", "1"], "--vector-potential must be of x, y"),
        (["--hamiltonian", "x**2", "--vector-potential", "y=B*x"], "--vector-potential['y']: unknown name 'B'"),
        (["--hamiltonian", "x**2", "--vector-potential", "y=x", "--magnetic", "1"], "magnetic does not go with"),
        (["--model", "double-pendulum", "--momenta", "p1 p2"], "--momenta belongs to --formula, --hamiltonian"),
        (["--model", "double-pendulum", "--parameter", "h=1"], "--parameter h is none of double-pendulum"),
        (["--model", "double-pendulum", "--mu", "2"], "--mu belongs to bodies"),
        (["--model", "double-pendulum"], "--energy is required"),
        (["--model", "double-pendulum", "--energy", "-4"], "the least energy there is -3"),
        (
            [*TEXT[:7], "--periodic", "q1=1", "--energy", "1"],
            "--periodic['q1'] must be a period of the system, got 1, over which",
        ),
        ([*TEXT, "--friction", "0.1", "--energy", "1"], "--friction must be given without momenta"),
        (
            [
                *("--hamiltonian=p**2*x**2 - s**2 + y**2", "--momenta", "p s", "--energy", "1", "--orbits", "3"),
                "--microcanonical",
            ],
            "give ranges of the rows, --axes x=LOW:HIGH --axes y=LOW:HIGH --axes p=LOW:HIGH --axes s=LOW:HIGH",
        ),
    ],
)
def test_what_is_wrong_is_said_of_flags(words, said, capsys):
    assert main(["chaos-map", *words, "--no-figure"]) == 2
    assert said in capsys.readouterr().err


def test_rods_of_a_double_pendulum_carry_its_energy():
    """T and V of the two masses where the rods put them, against H; and an animation of it."""
    rng = np.random.default_rng(8)
    model, z = DoublePendulum(*10 ** rng.uniform(-0.4, 0.4, 5)), rng.uniform(-2, 2, 4)
    v = model.rates(*z)[:2]
    here, ahead, behind = (
        np.array(model.joints(*(q + s * w for q, w in zip(z, v, strict=False)))) for s in (0.0, 1e-5, -1e-5)
    )
    speed = (ahead - behind) / 2e-5
    masses = np.array([0.0, model.m_1, model.m_2])
    energy = (masses * (speed**2).sum(axis=0)).sum() / 2 + model.g * (masses * here[1]).sum()
    assert energy == pytest.approx(model.energy(*z), rel=1e-9)
    film = fa.plot.animate(model, z, time=2.0, frames=4)
    film.draw(3)
    rods = film.figure.axes[0].lines[1].get_xydata()
    end = fa.integrate(model, z, time=2.0, samples=24, accuracy=1e-8).samples[-1, :2, 0]
    np.testing.assert_allclose(rods.T, model.joints(*end), rtol=0, atol=1e-12)


def test_a_point_of_another_h_moves_over_its_least_energies(here):
    text = ["--hamiltonian=(p + y)**2*(1 + x**2)/2 + s**2/2 + x**2/2 + y**2", "--momenta", "p s", "--energy", "0.4"]
    assert main(["animate", *text, "--time", "2", "--frames", "3", "--out", "film.gif"]) == 0
    assert (here / "film.gif").stat().st_size > 1000
    model = fa.hamiltonian(text[0].partition("=")[2], coordinates="x y", momenta="p s")
    film = fa.plot.animate(model, [0.1, 0.1, 0.3, 0.2], time=2.0, frames=3)
    lines = film.figure.axes[0].collections[-1].get_paths()[0].vertices
    energy = model.energy(0.1, 0.1, 0.3, 0.2)
    np.testing.assert_allclose(lines[:, 0] ** 2 / 2 + lines[:, 1] ** 2, energy, rtol=2e-3)  # at rest p = -y
