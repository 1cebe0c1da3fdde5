"""Back to other tools: tables, NetCDF, MATLAB and source text; results as SciPy's; rng beside seed."""

import csv
import ctypes
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
from comparison import same
from scipy.integrate import solve_ivp
from scipy.io import loadmat

import fastaff as fa
from fastaff.exchange.sources import source

RNG = np.random.default_rng(33)
HH = fa.HenonHeiles()
STARTS = RNG.uniform(-0.2, 0.2, (4, 5))


@cache
def frequencies():
    return fa.frequency_map(HH, STARTS, time=200.0)


@cache
def orbits():
    return fa.integrate(HH, STARTS[:, :3], time=5.0, samples=10)


def test_a_table_has_a_row_for_each_orbit(tmp_path):
    path = fa.save(tmp_path / "nu.csv", frequencies())
    assert path.name == "nu.csv"
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 5
    for name in ("nu_x", "nu_y", "error_x"):
        np.testing.assert_array_equal([float(row[name]) for row in rows], frequencies()[name])
    np.testing.assert_array_equal([int(row["status"]) for row in rows], frequencies().status)
    assert orbits().save(tmp_path / "nu.csv").name == "nu-2.csv"
    assert frequencies().save(tmp_path / "nu.csv", overwrite=True).name == "nu.csv"
    with pytest.raises(ValueError, match=r"energy is kept in \.npz files alone"):
        fa.save(tmp_path / "nu.csv", frequencies(), energy=0.1)
    with pytest.raises(TypeError, match="result must be a result"):
        fa.save(tmp_path / "nu.csv", 3)


@pytest.mark.parametrize("name", ["o.h5", "o.xlsx", "o.CSV", "o.NPZ"])
def test_unknown_endings_are_refused(tmp_path, name):
    found = fa.integrate(HH, [0.1, 0.0, 0.0, 0.1], time=1.0)
    with pytest.raises(ValueError, match=r"must end in .npz, .csv, .mat, .nc, .parquet, or have no ending, got 'o\."):
        found.save(tmp_path / name)
    assert not list(tmp_path.iterdir())
    assert found.save(tmp_path / "energy_0.12").name == "energy_0.12.npz"


def test_parquet_has_the_same_bits(tmp_path):
    frames = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    table = frames.read_parquet(fa.save(tmp_path / "orbits.parquet", orbits()))
    for name in ("z_x", "z_p_y", "error_y", "energy_error"):
        same(table[name].to_numpy(), np.ascontiguousarray(orbits()[name]))


def test_pandas_has_the_table_of_csv():
    pytest.importorskip("pandas")
    table = orbits().to_pandas()
    for name in ("z_x", "z_p_y", "error_y", "energy_error", "status"):
        same(table[name].to_numpy(), np.ascontiguousarray(orbits()[name]))


def test_netcdf_and_matlab_have_all_arrays(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    with xarray.open_dataset(fa.save(tmp_path / "orbits.nc", orbits()), engine="h5netcdf") as data:
        np.testing.assert_array_equal(data["samples"].values, orbits().samples)
        assert list(data["coordinate"].values) == list(orbits().names)
    content = loadmat(fa.save(tmp_path / "orbits.mat", orbits()))
    np.testing.assert_array_equal(content["samples"], orbits().samples)
    assert content["facts"]["result"][0, 0] == "Orbits"


def test_results_say_success_and_message():
    assert orbits().success is True
    assert orbits().message == orbits().summary()
    runaway = fa.hamiltonian("-x**4", coordinates="x")
    both = fa.integrate(runaway, [[1.0, 1e-3], [1.0, 0.0]], time=20.0)
    assert both.success is False
    assert both[1].success is True
    assert both[1].message.startswith("1 orbit: 1 OK")


def test_rng_beside_seed():
    surface = {"energy": 0.1, "section": "x=0", "orbits": 6}
    same(fa.energy_sample(HH, **surface, rng=7).z0, fa.energy_sample(HH, **surface, seed=7).z0)
    first = fa.energy_sample(HH, **surface, rng=np.random.default_rng(7)).z0
    same(first, fa.energy_sample(HH, **surface, seed=7).z0)
    with pytest.raises(ValueError, match="rng must not be given beside seed"):
        fa.energy_sample(HH, **surface, rng=7, seed=8)
    with pytest.raises(ValueError, match="rng must be one of"):
        fa.energy_sample(HH, **surface, rng=-1)


MODELS = [
    fa.hamiltonian("(x**2 + y**2)/2 + lam*(x**2*y - y**3/3) + exp(-x*y)/pi", lam=0.9),
    fa.hamiltonian("sqrt(1 + x**2) + a*cos(y)", rotation=0.3, masses=[2.0, 2.0], a=0.4),
    fa.hamiltonian("x**2/2 + (y - 1)**4/4", magnetic="2*b", b=0.35),
    fa.hamiltonian("cosh(x)", coordinates="x", friction=0.2),
    fa.hamiltonian("x**4/4 - f*x*cos(w*t)", coordinates="x", drive_period="2*pi/w", f=0.3, w=1.2),
    fa.hamiltonian("a*p1**2/2 + p2**2*(1 + x**2) + x**2*y**2 + y**4", coordinates="x y", momenta="p1 p2", a=0.8),
    fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3),
    fa.HenonHeiles(lam=0.7),
]


def starts(model):
    """A point with the rows that the text names."""
    return RNG.uniform(-0.5, 0.5, source(model).split("* z: ")[1].split("\n")[0].count(",") + 1)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_c_has_the_same_orbits(tmp_path):
    pointer = ctypes.POINTER(ctypes.c_double)
    for k, model in enumerate(MODELS):
        code, library = tmp_path / f"m{k}.c", tmp_path / f"m{k}.so"
        code.write_text(source(model))
        command = ["cc", "-O1", "-Wall", "-Wno-unused", "-Werror", "-shared", "-fPIC", code, "-o", library, "-lm"]
        subprocess.run(command, check=True)
        function, constants = ctypes.CDLL(str(library)).rates, np.array([*map(float, model)])
        function.argtypes, function.restype = [ctypes.c_double, pointer, pointer, pointer], None

        def rates(t, z, function=function, constants=constants):
            z, out = np.ascontiguousarray(z), np.empty(z.size)
            function(t, *(array.ctypes.data_as(pointer) for array in (z, constants, out)))
            return out

        z0 = starts(model)
        truth = solve_ivp(rates, (0.0, 1.0), z0, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        rows = [0, 2] if model.coordinates == ("x", "t") else slice(None)
        np.testing.assert_allclose(fa.integrate(model, z0, time=1.0).z[rows, 0], truth, rtol=1e-9, atol=1e-10)


def test_heyoka_has_the_same_orbits():
    heyoka = pytest.importorskip("heyoka")
    for model in MODELS:
        names = {}
        exec(source(model, "heyoka"), names)
        z0 = starts(model)
        truth = heyoka.taylor_adaptive(names["system"], list(z0), pars=names["parameters"])
        truth.propagate_until(1.0)
        rows = [0, 2] if model.coordinates == ("x", "t") else slice(None)
        np.testing.assert_allclose(fa.integrate(model, z0, time=1.0).z[rows, 0], truth.state, rtol=1e-9, atol=1e-10)


def test_source_of_what_is_no_formula_is_refused():
    with pytest.raises(
        TypeError, match=r"model must be one of fa.hamiltonian\(...\) or fa.ode\(...\), got StandardMap$"
    ):
        source(fa.models.StandardMap(K=0.3))
    with pytest.raises(TypeError, match="got FormulaMap"):
        source(fa.iterated_map("p1 = p + K*sin(x); x1 = x + p1", K=0.3))
    for body in (fa.affine_body("gent", G=1.0, Jm=10.0, K=2.0), fa.Body(fa.NeoHookean(G=1.0, K=2.0))):
        with pytest.raises(TypeError, match=r"got Body: of its equations, source\(fa.ode\(model, forces={}\)\)$"):
            source(body)
        assert "z: D1, D2, p_D1, p_D2" in source(fa.ode(body, forces={}))
    with pytest.raises(ValueError, match="language must be one of c, heyoka, got 'fortran'"):
        source(MODELS[0], "fortran")
