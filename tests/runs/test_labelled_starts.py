"""Initial conditions with labels: rows are found by their names, and refused where their order is unknown."""

import importlib

import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff.runs.starts import in_rows, starts_of
from fastaff.systems.models.mechanics import system_of

HENON = fa.HenonHeiles()
ROWS = ("x", "y", "p_x", "p_y")
DRIVEN = fa.hamiltonian("x**2/2 - a*x*cos(t)", coordinates="x", drive_period="2*pi", a=0.1)
MODELS = (
    HENON,
    shared_systems.springs(np.eye(3)),
    fa.ode("x' = v; v' = -x; w' = 0"),
    DRIVEN,
)


def names_of(model):
    return fa.models.mechanics.system_of(model).row_names


def frames(package):
    return pytest.importorskip(package)


def labelled(rng, names, z):
    """All labelled forms of z (2n, orbits), rows in any order and axes in both."""
    pandas, xarray = frames("pandas"), frames("xarray")
    order = rng.permutation(len(names))
    mixed, said = z[order], [names[k] for k in order]
    orbits = rng.permutation(100)[: z.shape[1]]
    table = pandas.DataFrame(mixed, index=said, columns=orbits)
    row, orbit = rng.choice(["coordinate", "row", "whatever"]), rng.choice(["orbit", "particle", "anything"])
    array = xarray.DataArray(mixed, dims=(row, orbit), coords={row: said})
    yield from (table, table.T, table.T.rename(index="star {}".format), array, array.T)
    yield from (array.assign_coords({orbit: orbits}), array.to_pandas(), array.rename({row: "rows"}).sortby("rows"))
    yield xarray.Dataset({name: ("n", row) for name, row in zip(said, mixed, strict=True)})
    yield xarray.DataArray(z.T, dims=("orbit", "coordinate"))
    yield xarray.DataArray(z.T, dims=("orbit", "whatever"))
    yield from (pandas.DataFrame(z), xarray.DataArray(z), [array.sel({row: name}) for name in names])


@pytest.mark.parametrize("model", MODELS, ids=lambda model: "-".join(names_of(model)))
def test_rows_are_found_by_name(model):
    """Square arrays too, whose shape does not tell rows from orbits."""
    rng = np.random.default_rng(471)
    names = names_of(model)
    for orbits in (1, 2, len(names), len(names), 2 * len(names)):
        z = rng.uniform(-1, 1, (len(names), orbits))
        for value in labelled(rng, names, z):
            np.testing.assert_array_equal(in_rows("z0", value, system_of(model)), z)


def test_single_orbits_and_starts_without_the_time():
    pandas, xarray = frames("pandas"), frames("xarray")
    series = pandas.Series([1.0, 2.0, 3.0, 4.0], index=["p_y", "y", "x", "p_x"])
    for value in (series, series.to_xarray(), series.to_frame(), series.to_frame().T):
        np.testing.assert_array_equal(np.ravel(in_rows("z0", value, system_of(HENON))), [3.0, 2.0, 4.0, 1.0])
    scalars = xarray.Dataset(dict(series))
    np.testing.assert_array_equal(in_rows("z0", scalars, system_of(HENON)), [3.0, 2.0, 4.0, 1.0])
    turned = pandas.Series([1.0, 2.0], index=["p_x", "x"])
    np.testing.assert_array_equal(in_rows("z0", turned, system_of(DRIVEN)), [2.0, 1.0])


def test_polars_and_lists_of_its_columns():
    polars = frames("polars")
    z = np.arange(16.0).reshape(4, 4)
    table = polars.DataFrame({name: z[k] for name, k in (("p_y", 3), ("y", 1), ("x", 0), ("p_x", 2))})
    np.testing.assert_array_equal(in_rows("z0", table, system_of(HENON)), z)
    np.testing.assert_array_equal(in_rows("z0", [table[name] for name in ROWS], system_of(HENON)), z)
    for value in ([table[name] for name in ROWS[::-1]], table.rename({"x": "q"}), table.lazy()):
        with pytest.raises((TypeError, ValueError), match="z0 must"):
            in_rows("z0", value, system_of(HENON))


def test_labels_that_do_not_match_are_refused():
    pandas, xarray = frames("pandas"), frames("xarray")
    z = np.arange(16.0).reshape(4, 4)
    table = pandas.DataFrame(z, index=ROWS)
    array = xarray.DataArray(z, dims=("coordinate", "orbit"), coords={"coordinate": list(ROWS)})
    wrong = [
        table.rename(index={"x": "q"}),
        table.rename(index={"x": "y"}),
        pandas.DataFrame(z, columns=list("abcd")),
        pandas.DataFrame(z, index=ROWS, columns=ROWS),
        pandas.DataFrame(z, index=[3, 0, 1, 2]),
        pandas.concat([table, table]),
        table.T.assign(energy=1.0),
        table.stack(),
        table.drop("x"),
        array.sel(coordinate="x"),
        array.sel(coordinate=["x", "y"]),
        array.drop_vars("coordinate").rename(coordinate="a", orbit="b"),
        array.expand_dims("time"),
        array.to_dataset(name="z0"),
        xarray.Dataset(dict.fromkeys(ROWS, (("a", "b"), z))),
        [array.sel(coordinate=name) for name in ROWS[::-1]],
        [array[:, k] for k in range(4)],
        [table.loc[name] for name in ROWS[::-1]],
        [table.loc["x"], table.loc["y"].iloc[::-1], table.loc["p_x"], table.loc["p_y"]],
        fa.integrate(HENON, [0.1, 0.0, 0.0, 0.2], time=1.0).to_xarray(),
    ]
    for value in wrong:
        with pytest.raises((TypeError, ValueError), match="z0") as error:
            fa.integrate(HENON, value, time=1.0)
        assert len(str(error.value)) <= 160


def test_a_round_trip_in_any_order_gives_the_same_orbits():
    """It gave others, without a word."""
    frames("xarray")
    run = fa.integrate(HENON, np.random.default_rng(7).uniform(-0.2, 0.2, (4, 4)), time=2.0, samples=3)
    again = fa.integrate(HENON, run.z, time=2.0).z
    data = run.to_xarray()
    last = data.samples.isel(sample=-1).transpose("orbit", "coordinate")
    for value in (data.z, data.z.sortby("coordinate"), data.z.sel(coordinate=["p_y", "y", "x", "p_x"]), data.z.T, last):
        found = fa.integrate(HENON, value, time=2.0)
        np.testing.assert_array_equal(found.z, again)
        np.testing.assert_array_equal(found.call.arguments["z0"], run.z)
    one = fa.integrate(HENON, data.z.sel(orbit=2).sortby("coordinate"), time=2.0)
    np.testing.assert_array_equal(one.z[:, 0], again[:, 2])


VERBS = {
    "poincare_map": lambda z: fa.poincare_map(HENON, z, section="x=0", crossings=2, max_time=50.0).points,
    "chaos_map": lambda z: fa.chaos_map(HENON, z, time=50.0).values,
    "frequency_map": lambda z: fa.frequency_map(HENON, z, time=100.0).nu,
    "tangent_map": lambda z: fa.tangent_map(HENON, z, time=1.0).z,
    "periodic_orbits": lambda z: fa.periodic_orbits(HENON, z, section="x=0", max_time=50.0).z,
    "run": lambda z: fa.run(
        fa.Job(model=HENON, initial_conditions=z, integrate=fa.jobs.IntegrateOptions(time=1.0))
    )["integrate"].z,
    "a job of a text": lambda z: fa.run(
        fa.Job(model=fa.jobs.Model(hamiltonian="(x**2 + y**2)/2 + x**2*y - y**3/3", coordinates="x y"),
               initial_conditions=z, integrate=fa.jobs.IntegrateOptions(time=1.0))
    )["integrate"].z,
}  # fmt: skip


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_reads_names(verb):
    pandas = frames("pandas")
    z = np.random.default_rng(8).uniform(0.05, 0.2, (4, 4))
    table = pandas.DataFrame(z, index=ROWS).loc[["p_y", "x", "p_x", "y"]]
    truth = VERBS[verb](z)
    for value in (table, table.T):
        np.testing.assert_array_equal(VERBS[verb](value), truth)
    with pytest.raises(ValueError, match="must have rows named x, y, p_x, p_y, got"):
        VERBS[verb](table.rename(index={"x": "q"}))


class OnADevice:
    """An array of another device, or one that keeps gradients."""

    shape, dtype = (4,), float

    def __init__(self, problem):
        self.problem = problem

    def __array__(self, *_, **__):
        raise self.problem


def test_arrays_that_are_none_are_refused_by_name():
    for problem in (RuntimeError("requires grad"), TypeError("Implicit conversion to a NumPy array is not allowed")):
        with pytest.raises(
            TypeError,
            match=rf"z0 must be an array of numbers, got a OnADevice \({type(problem).__name__}: {str(problem)[:40]}",
        ):
            fa.integrate(HENON, OnADevice(problem), time=1.0)


def test_starts_without_labels_are_as_they_were():
    z = [[0.1, 0.2], [0.0, 0.0], (0.0, 0.1), np.array([0.2, 0.1])]
    assert starts_of(z, HENON) is z
    array = np.zeros((4, 2))
    assert starts_of(array, HENON) is array
    assert importlib.import_module("fastaff.runs.starts").in_rows("z0", 3, HENON) == 3
