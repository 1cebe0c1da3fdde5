"""Launch sets of any number of degrees of freedom: energies, measures against closed forms, grids against brute force,
words for what is wrong.
"""

import numpy as np
import pytest
from scipy import optimize, stats

import fastaff as fa
from fastaff.jobs.launch import BLOCK, between
from fastaff.sections import NotReached
from fastaff.sections.energy_shell import EnergyShell
from fastaff.sections.invariant_measure import measure_of
from fastaff.systems.models.mechanics import system_of

HH = fa.HenonHeiles()
NAMES = ("x", "y", "z", "u", "v", "w")


def energies(model, z):
    n = model.degrees_of_freedom
    return model.kinetic_energy(*z[n:]) + model.potential_energy(*z[:n])


def oscillator(n, seed):
    """An oscillator with random masses, stiffnesses, centre, and constant: its model, and what makes of its phase
    points those of the isotropic oscillator |z|^2 = 1 at the energy that comes with it.
    """
    rng = np.random.default_rng([n, seed])
    k, m = 10.0 ** rng.uniform(-4, 4, n), 10.0 ** rng.uniform(-3, 3, n)
    centre, V0, room = rng.normal(size=n) * 5, rng.normal() * 3, 10.0 ** rng.uniform(-2, 2)
    centre = centre * np.sqrt(room / k)
    text = " + ".join(f"k{i}*({name} - c{i})**2/2" for i, name in enumerate(NAMES[:n]))
    given = {f"k{i}": k[i] for i in range(n)} | {f"c{i}": centre[i] for i in range(n)}
    model = fa.hamiltonian(f"{text} + V0", coordinates=" ".join(NAMES[:n]), masses=m, V0=V0, **given)
    size = np.concatenate([np.sqrt(2 * room / k), np.sqrt(2 * room * m)])
    middle = np.concatenate([centre, np.zeros(n)])
    return model, V0 + room, lambda z: (z - middle[:, None]) / size[:, None], centre


def galaxy(**more):
    return fa.hamiltonian(
        "v**2*log(r**2 + x**2 + y**2/b**2 + z**2/c**2)/2", coordinates="x y z", v=1.0, r=0.1, b=0.9, c=0.8, **more
    )


# --- random points --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [2, 3, 4, 6])
def test_points_of_an_energy_surface_are_uniform_on_the_sphere_of_an_oscillator(n):
    """A coordinate of a point of the unit sphere in 2n dimensions has a square that is Beta(1/2, n - 1/2); any two
    have an angle that is uniform.
    """
    model, energy, unit, _ = oscillator(n, 1)
    sample = fa.energy_sample(model, energy=energy, orbits=2000, seed=5)
    z = unit(sample.z0)
    np.testing.assert_allclose((z**2).sum(axis=0), 1, rtol=1e-9)
    assert sample.names == (*NAMES[:n], *(f"p_{name}" for name in NAMES[:n]))
    assert min(stats.kstest(row**2, stats.beta(0.5, n - 0.5).cdf).pvalue for row in z) > 1e-4
    assert min(stats.kstest(np.arctan2(z[0], row) / np.pi, "uniform", (-1, 2)).pvalue for row in z[1:]) > 1e-4


@pytest.mark.parametrize("n", [3, 4])
@pytest.mark.parametrize("direction", [1, -1, 0])
def test_points_of_a_section_are_uniform_in_the_ball_of_an_oscillator(n, direction):
    """The other coordinates and momenta fill the ball in 2n - 2 dimensions: squares are Beta(1/2, n - 1/2)."""
    model, energy, unit, centre = oscillator(n, 2)
    normal = np.zeros(2 * n)
    normal[1] = -2.0
    section = fa.Hyperplane(tuple(normal), -2.0 * centre[1], direction)
    sample = fa.energy_sample(model, energy=energy, section=section, orbits=2000, seed=6)
    z = unit(sample.z0)
    rest = np.delete(z, [1, 1 + n], axis=0)
    np.testing.assert_allclose(z[1], 0, atol=1e-12)
    np.testing.assert_allclose((z**2).sum(axis=0), 1, rtol=1e-9)
    assert (z[1 + n] * (-1 if direction == 1 else 1) >= 0).all()
    assert min(stats.kstest(row**2, stats.beta(0.5, n - 0.5).cdf).pvalue for row in rest) > 1e-4
    np.testing.assert_array_equal(sample.points, np.delete(sample.z0, [1, 1 + n], axis=0))


@pytest.mark.slow
def test_the_flow_keeps_the_measure_of_an_energy_surface_and_the_return_map_that_of_a_section():
    """Two-sample tests before and after, in a triaxial logarithmic potential with its mixed orbits."""
    model = galaxy()
    whole = fa.energy_sample(model, energy=-0.4, orbits=1500, seed=1)
    after = fa.integrate(model, whole.z0, time=7.0, accuracy=1e-8).z
    cut = fa.energy_sample(model, energy=-0.4, section="y=0.1", orbits=1500, seed=2)
    image = fa.poincare_map(model, cut.z0, section="y=0.1", crossings=1, max_time=100.0, scheme=fa.DOP853)
    assert (image.counts == 1).all()
    np.testing.assert_allclose([energies(model, whole.z0), energies(model, cut.z0)], -0.4, rtol=1e-13)
    for one, other in ((whole.z0, after), (cut.z0, image.points[:, 0])):
        for row in (0, 2, 3, 4, 5):
            assert stats.ks_2samp(one[row], other[row]).pvalue > 1e-3, row
        assert stats.ks_2samp(np.abs(one[0] * one[5]), np.abs(other[0] * other[5])).pvalue > 1e-3


@pytest.mark.parametrize("energy", [0.02, 1 / 8, 0.16, 1 / 6])
def test_points_of_henon_heiles_fill_the_triangle_and_nothing_beyond(energy):
    """n = 2: uniform over the area that the energy allows inside the triangle, also at the energy of its saddles."""
    sample = fa.energy_sample(HH, energy=energy, orbits=4000, seed=3)
    x, y = sample.z0[:2]
    np.testing.assert_allclose(energies(HH, sample.z0), energy, rtol=1e-12)
    assert (y > -0.5).all()
    assert (np.sqrt(3) * np.abs(x) + y < 1).all()
    side = np.linspace(-1, 1, 1201)
    u, v = (axis.ravel() for axis in np.meshgrid(side, side))
    inside = (HH.potential_energy(u, v) < energy) & (v > -0.5) & (np.sqrt(3) * np.abs(u) + v < 1)
    for mine, grid in ((x, u), (y, v), (x * x + y * y, u * u + v * v)):
        # Cells of a fine grid stand for the distribution.
        exact = np.sort(grid[inside])
        share = np.searchsorted(exact, np.sort(mine)) / exact.size
        assert stats.kstest(share, "uniform").pvalue > 1e-4
    assert stats.kstest(np.arctan2(*sample.z0[2:]) / np.pi, "uniform", (-1, 2)).pvalue > 1e-4


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1e-5, 2e-4), (1e6, -3e6)])
def test_all_wells_share_the_volume_of_an_energy_surface(scale, shift):
    """Two wells below their barrier, and a dumbbell above it: the share of each side, by quadrature of the area."""
    x = "((x - c)/s)"
    model = fa.hamiltonian(f"({x}**2 - 1)**2 + {x}/5 + (y/s)**2/2", c=shift, s=scale)
    for energy in (0.6, 1.3):
        drawn = fa.energy_sample(model, energy=energy, orbits=4000, seed=5)
        s = np.linspace(-3, 3, 400_001)
        width = np.sqrt(np.maximum(energy - (s**2 - 1) ** 2 - s / 5, 0))
        share = width[s > 0].sum() / width.sum()
        right = (drawn.z0[0] > shift).mean()
        assert abs(right - share) < 4.5 * np.sqrt(share * (1 - share) / 4000)


def test_kinetic_energies_that_mix_momenta():
    """A body with two inertias: T couples p_a and p_b. Energies, and the measure of the momenta over each point."""
    body = fa.affine_body("(D1**2 + D2**2)/2 + c*(D1 - D2)**4", mu=(0.5, 3.0), c=0.01)
    ranges = {"a1": (1.0, 1.2), "a2": (-0.1, 0.1), "b1": (-0.1, 0.1), "b2": (-0.1, 0.1)}
    sample = fa.energy_sample(body, energy=4.0, axes=ranges, orbits=1500, seed=1)
    np.testing.assert_allclose(energies(body, sample.z0), 4.0, rtol=1e-13)
    velocity = np.array(body.velocity(*sample.z0[4:]))
    material = np.array([velocity[0] + velocity[2], velocity[0] - velocity[2]]) / np.sqrt(2)  # x', u'
    room = 4.0 - body.potential_energy(*sample.z0[:4])
    for speed, mass in zip(material, (0.5, 3.0)):  # a sphere in 4 dimensions
        assert stats.kstest(mass * speed**2 / (2 * room), stats.beta(0.5, 1.5).cdf).pvalue > 1e-4


def test_the_first_points_do_not_depend_on_how_many_are_drawn():
    model = galaxy()
    for how in ({}, {"section": "x=0"}, {"at_rest": True}, {"solve": "p_y", "axes": {"x": (-0.2, 0.2), "z": (0, 0.1)}}):
        some, many = (fa.energy_sample(model, energy=-0.4, orbits=count, seed=9, **how).z0 for count in (40, 3000))
        assert np.ascontiguousarray(many[:, :40]).tobytes() == some.tobytes()
        other = fa.energy_sample(model, energy=-0.4, orbits=40, seed=10, **how).z0
        assert (other != some).any()


def test_draws_from_ranges_of_rows_are_even():
    """x and p_x of a section of the galaxy's, z fixed, p_y from the energy."""
    model = galaxy()
    how = {"axes": {"x": (-0.2, 0.3), "p_x": (-0.2, 0.1)}, "fixed": {"z": 0.1, "p_z": 0.05}, "solve": "p_y", "sign": -1}
    sample = fa.energy_sample(model, energy=-0.4, orbits=2000, seed=4, **how)
    x, y, z, p_x, p_y, p_z = sample.z0
    np.testing.assert_allclose(energies(model, sample.z0), -0.4, rtol=1e-13)
    assert (p_y < 0).all()
    assert (z == 0.1).all()
    assert (p_z == 0.05).all()
    assert not y.any()
    assert stats.kstest(x, "uniform", (-0.2, 0.5)).pvalue > 1e-4
    assert stats.kstest(p_x, "uniform", (-0.2, 0.3)).pvalue > 1e-4
    assert sample.names == ("x", "p_x")


# --- grids ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1, -1])
def test_grids_by_name_are_those_of_brute_force(sign):
    rng = np.random.default_rng(7)
    model, energy, unit, centre = oscillator(3, 4)
    size = 1 / (unit(np.eye(6)) - unit(np.zeros((6, 6)))).diagonal()
    axes = {"x": centre[0] + size[0] * np.linspace(-1.1, 1.1, 7), "p_z": size[5] * np.linspace(-1.1, 1.1, 6)}
    fixed = {"y": centre[1] + 0.1 * size[1], "z": centre[2], "p_x": 0.2 * size[3] * rng.normal()}
    grid = fa.energy_grid(model, energy=energy, axes=axes, fixed=fixed, solve="p_y", sign=sign)
    assert grid.names == ("x", "p_z")
    assert grid.inaccessible.shape == (7, 6)
    cell = 0
    for i, x in enumerate(axes["x"]):
        for j, p_z in enumerate(axes["p_z"]):
            z = np.array([x, fixed["y"], fixed["z"], fixed["p_x"], 0.0, p_z])
            rest = 1 - (unit(z[:, None]) ** 2).sum()
            assert grid.inaccessible[i, j] == (rest < 0)
            if rest >= 0:
                z[4] = sign * size[4] * np.sqrt(rest)
                np.testing.assert_allclose(grid.z0[:, cell], z, rtol=1e-8, atol=1e-8 * np.abs(size).max())
                cell += 1
    assert cell == len(grid)
    np.testing.assert_allclose(energies(model, grid.z0), energy, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(grid["p_z"], grid.z0[5])
    assert grid.to_grid(grid["x"]).shape == (7, 6)


def test_three_axes_and_one():
    one = fa.energy_grid(galaxy(), energy=-0.4, axes={"z": np.linspace(0, 0.3, 5)}, solve="p_x", fixed={"p_y": 0.1})
    assert one.z0.shape == (6, 5)
    assert one.to_grid(np.arange(5)).shape == (5,)
    cube = {"x": np.linspace(0, 0.3, 3), "y": np.linspace(0, 0.2, 4), "p_x": np.linspace(-2, 2, 5)}
    three = fa.energy_grid(galaxy(), energy=-0.4, axes=cube, solve="p_z")
    assert three.inaccessible.shape == (3, 4, 5)
    assert 0 < three.inaccessible.sum() == 60 - len(three)
    u = np.meshgrid(*cube.values(), indexing="ij")
    for name, axis in zip(cube, u):
        np.testing.assert_array_equal(three[name], axis.ravel()[three.cell_index])


def test_a_section_by_name_is_that_of_two_arrays_to_the_bit():
    axes = np.linspace(-0.4, 0.5, 10), np.linspace(-0.4, 0.4, 9)
    for section in (
        fa.Hyperplane((1.0, 0, 0, 0), 0.02, -1),
        fa.Hyperplane((0, -2.0, 0, 0), 0.1, 1),
        fa.Hyperplane((1.0, 0, 0, 0)),
    ):
        other = "xy"[int(section.normal[0] != 0)]
        plain = fa.energy_grid(HH, energy=0.12, section=section, axes=axes)
        named = fa.energy_grid(HH, energy=0.12, section=section, axes={other: axes[0], f"p_{other}": axes[1]})
        assert plain.z0.tobytes() == named.z0.tobytes()
        np.testing.assert_array_equal(plain.inaccessible, named.inaccessible)


def test_a_coordinate_from_the_energy():
    """The last root in the direction of the sign: of a double well, by polynomials."""
    model = fa.hamiltonian("(x**2 - 1)**2 + x/5 + y**2/2")
    momenta = np.linspace(-0.9, 0.9, 7)
    for sign in (1, -1):
        grid = fa.energy_grid(model, energy=0.6, axes={"p_x": momenta}, fixed={"y": 0.1}, solve="x", sign=sign)
        for x, p in zip(grid["p_x"], grid.z0[0]):
            roots = np.roots([1, 0, -2, 0.2, 1 + 0.005 + x * x / 2 - 0.6])
            real = roots.real[np.abs(roots.imag) < 1e-9]
            assert p == pytest.approx(real.max() if sign > 0 else real.min(), rel=1e-12)
        np.testing.assert_allclose(energies(model, grid.z0), 0.6, rtol=1e-12)


# --- at rest --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("energy", [-0.4, 0.0, 1e-17])
def test_starts_at_rest_lie_on_the_equipotential_in_the_directions_asked_for(energy):
    """Also at V = 0, where no energy measures its rounding."""
    model = galaxy()
    axes = {"theta": np.linspace(0.1, 3.0, 7), "phi": np.linspace(-3.0, 3.0, 9)}
    grid = fa.energy_grid(model, energy=energy, axes=axes, at_rest=True)
    theta, phi = grid["theta"], grid["phi"]
    assert not grid.inaccessible.any()
    assert not grid.z0[3:].any()
    unit = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    scale = np.sqrt((unit**2 / np.array([1, 0.81, 0.64])[:, None]).sum(axis=0))  # log(r^2 + s^2) = 2 E
    np.testing.assert_allclose(grid.z0[:3], unit * np.sqrt(np.exp(2 * energy) - 0.01) / scale, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_random_directions_at_rest_are_uniform(n):
    """Of an isotropic oscillator: q uniform on a sphere in n dimensions about the point where rays begin."""
    text = " + ".join(f"(({name} - c)/s)**2/2" for name in NAMES[:n])
    model = fa.hamiltonian(text, coordinates=" ".join(NAMES[:n]), c=30.0, s=4.0)
    centre = dict.fromkeys(NAMES[:n], 30.0)
    sample = fa.energy_sample(model, energy=0.5, orbits=2000, seed=1, at_rest=True, fixed=centre)
    unit = (sample.z0[:n] - 30.0) / 4.0
    np.testing.assert_allclose((unit**2).sum(axis=0), 1, rtol=1e-12)
    assert not sample.z0[n:].any()
    assert min(stats.kstest(row**2, stats.beta(0.5, (n - 1) / 2).cdf).pvalue for row in unit) > 1e-4
    again = fa.energy_grid(
        model, energy=0.5, axes={name: sample[name][:1] for name in sample.names}, at_rest=True, fixed=centre
    )
    np.testing.assert_allclose(again.z0[:, 0], sample.z0[:, 0], rtol=1e-12)


def test_rays_end_at_the_first_wall():
    """Henon-Heiles below its saddles: by a root finder; above them some rays have no end."""
    axes = {"phi": np.linspace(0.05, 6.2, 40)}
    grid = fa.energy_grid(HH, energy=0.15, axes=axes, at_rest=True)
    for phi, x, y in zip(grid["phi"], *grid.z0[:2]):
        c, s = np.cos(phi), np.sin(phi)
        r = np.linspace(0, 1.2, 4001)
        first = np.flatnonzero(HH.potential_energy(r * c, r * s) > 0.15)[0]
        root = optimize.brentq(
            lambda t, c=c, s=s: HH.potential_energy(t * c, t * s) - 0.15, r[first - 1], r[first], xtol=1e-15
        )
        np.testing.assert_allclose([x, y], [root * c, root * s], rtol=1e-12)
    above = fa.energy_grid(HH, energy=0.2, axes=axes, at_rest=True)
    assert 0 < above.inaccessible.sum() < 40


# --- jobs -----------------------------------------------------------------------------------------------------------

LOG = fa.jobs.Model(
    hamiltonian="log(r**2 + x**2 + y**2 + z**2/c**2)/2", coordinates="x y z", parameter=["r=0.1", "c=0.8"]
)


@pytest.mark.parametrize(
    "starts",
    [
        {"orbits": 2500, "microcanonical": True},
        {"orbits": 2500},
        {"orbits": 1500, "at_rest": True},
        {"orbits": 2500, "axes": {"x": "-0.2:0.2", "z": "0:0.1"}, "solve": "p_y"},
        {"axes": {"x": "-1:1:40", "z": "0:1:30"}, "solve": "p_y", "fixed": {"y": 0.05}},
        {"axes": ["theta=0:pi:20", "phi=0:2*pi:20"], "at_rest": True},
        {"axes": ["y=-0.3:0.3:20", "p_y=-0.3:0.3:20"]},
    ],
    ids=lambda s: "-".join(s),
)
def test_jobs_have_the_same_points_in_any_units(starts):
    """Blocks are computed whole: parts of a launch set have the bits of the whole, and the text of a job makes it
    again.
    """
    job = fa.Job(model=LOG, energy_surface={"energy": -0.4}, initial_conditions=starts, frequency_map={"time": 50.0})
    launch = job.plan().launch
    z0, place = between(launch, 0, launch.size)
    np.testing.assert_allclose(energies(job.plan().model, z0), -0.4, rtol=1e-11)
    again = fa.Job.parsed(job.text()).plan().launch
    for low, high in ((0, 300), (BLOCK - 7, BLOCK + 100), (launch.size - 30, launch.size)):
        part, at = between(again, low, min(high, launch.size))
        kept = (place >= low) & (place < high)
        assert part.tobytes() == np.ascontiguousarray(z0[:, kept]).tobytes()
        np.testing.assert_array_equal(at, place[kept] - low)
    assert place.size == launch.size or not starts.get("orbits")


@pytest.mark.parametrize(
    ("model", "energy", "starts", "how"),
    [
        (HH, 0.1, {}, {"section": "x=0"}),
        (fa.Body(fa.NeoHookean()), 3.0, {}, {"section": fa.AlphaTurning(+1)}),
        (LOG, -0.4, {"microcanonical": True}, {}),
        (LOG, -0.4, {"at_rest": True}, {"at_rest": True}),
    ],
    ids=["section", "body", "surface", "rest"],
)
def test_a_job_starts_where_energy_sample_does(model, energy, starts, how):
    """With one seed, in all blocks; parts of a sample are those of the whole."""
    seed = int(np.random.default_rng(31).integers(1000))
    starts = {"orbits": BLOCK + 200, "seed": seed, **starts}
    plan = fa.Job(
        model=model, energy_surface={"energy": energy}, initial_conditions=starts, integrate={"time": 1.0}
    ).plan()
    z0, _ = between(plan.launch, 0, plan.launch.size)
    sample = fa.energy_sample(plan.model, energy=energy, orbits=BLOCK + 200, seed=seed, **how)
    assert z0.tobytes() == sample.z0.tobytes()
    few = fa.energy_sample(plan.model, energy=energy, orbits=100, seed=seed, **how)
    assert few.z0.tobytes() == np.ascontiguousarray(z0[:, :100]).tobytes()
    for other in (np.random.SeedSequence(seed), np.random.default_rng(seed)):
        again = fa.energy_sample(plan.model, energy=energy, orbits=100, seed=other, **how)
        assert again.z0.tobytes() == few.z0.tobytes()


def test_a_job_of_three_degrees_of_freedom_is_that_of_the_library(tmp_path):
    starts = {"axes": {"x": "-0.4:0.4:4", "z": "0:0.2:3"}, "solve": "p_y"}
    job = fa.Job(model=LOG, energy_surface={"energy": -0.4}, initial_conditions=starts, integrate={"time": 5.0})
    found = fa.run(job, tmp_path / "a.zarr")["integrate"]
    body = job.plan().model
    axes = {"x": -0.4 + 0.8 * (np.arange(4) + 0.5) / 4, "z": 0.2 * (np.arange(3) + 0.5) / 3}
    grid = fa.energy_grid(body, energy=-0.4, axes=axes, solve="p_y")
    np.testing.assert_array_equal(found.z, fa.integrate(body, grid.z0, time=5.0).z)


# --- words ----------------------------------------------------------------------------------------------------------

TWO = {"x": [0.0, 0.1], "z": [0.0, 0.1]}


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"axes": {"X1": [0.1]}}, ValueError, "axes must be one of x, y, z, p_x, p_y, p_z, got 'X1'"),
        ({"axes": {"mom_z": [0.1]}}, ValueError, "Did you mean p_z"),
        ({"solve": None}, ValueError, "solve must name what the energy gives, one of y, p_x, p_y, p_z"),
        ({"solve": "p_q"}, ValueError, r"solve must be one of y, p_x, p_y, p_z, got 'p_q'. Did you mean p_"),
        ({"solve": "x"}, ValueError, "solve must be one of y"),
        ({"fixed": {"x": 0.1}}, ValueError, "axes and fixed both name x"),
        ({"fixed": {"w": 0.1}}, ValueError, "fixed must be one of x, y"),
        ({"fixed": {"y": np.nan}}, ValueError, r"fixed\['y'\] must be finite"),
        ({"fixed": {"y": "a"}}, TypeError, r"fixed\['y'\] must be a real number"),
        ({"fixed": [1.0]}, TypeError, "fixed must be numbers by name"),
        ({"sign": 0}, ValueError, r"sign must be \+1 or -1, got 0"),
        ({"sign": 1.0}, ValueError, "sign must be"),
        ({"axes": {"x": [np.nan]}}, ValueError, r"axes\['x'\] must be a non-empty, finite"),
        ({"axes": {"x": []}}, (ValueError, TypeError), r"axes\['x'\]"),
        ({"axes": {}}, ValueError, "axes must name one row at least"),
        ({"axes": ([0.1], [0.2])}, TypeError, r"axes must be arrays of numbers by name, such as axes=dict\(x="),
        ({"at_rest": 1}, TypeError, "at_rest must be True or False"),
        ({"at_rest": True}, ValueError, "at_rest and solve exclude one another"),
        ({"at_rest": True, "solve": None}, ValueError, "axes must be one of theta, phi, got 'x'"),
        ({"at_rest": True, "solve": None, "axes": {"phi": [1.0]}}, ValueError, "axes at rest must be theta, phi"),
        ({"section": "x=0", "solve": None}, ValueError, "x is given by the section, it must not be in axes"),
        ({"section": "q=0"}, ValueError, "section must be one of x=c, y=c, z=c"),
        (
            {"section": fa.Hyperplane((1.0, 1.0, 0, 0, 0, 0))},
            TypeError,
            "section must be a Hyperplane normal to one coordinate",
        ),
        ({"energy": -9.0}, NotReached, r"axes must reach points of energy -9, got x in \[0, 0.1\], z in"),
        ({"energy": np.inf}, ValueError, "energy must be finite"),
        ({"p_eta": 1.0}, ValueError, "p_eta and p_gamma must be 0"),
    ],
    ids=lambda v: "-".join(v) if isinstance(v, dict) else "",
)
def test_wrong_grids(change, error, message):
    options = {"energy": -0.4, "axes": TWO, "solve": "p_y"} | change
    with pytest.raises(error, match=message):
        fa.energy_grid(galaxy(), **options)


def test_axes_without_names_are_refused_with_a_call_that_takes_them():
    """Of grids and of samples of a map, whose rows it names."""
    kick, row = fa.models.StandardMap(0.5), [0.1, 0.2]
    for draw in (fa.energy_grid, lambda *given, **named: fa.energy_sample(*given, orbits=2, **named)):
        with pytest.raises(TypeError, match=r"such as axes=dict\(x=..., p=...\), got \(\[0.1"):
            draw(kick, axes=(row, row))
        assert draw(kick, axes={"x": row, "p": row}).z0.shape[0] == 2


@pytest.mark.parametrize(
    ("model", "change", "error", "message"),
    [
        (HH, {"energy": 0.2}, ValueError, "exceeds the escape energy 0.166667"),
        (HH, {"energy": -1.0}, NotReached, "energy must be at least the local minimum 0 of this system, got -1"),
        (galaxy(), {"energy": -3.0}, NotReached, "energy must be at least the minimum -2.302"),
        (galaxy(), {"section": "x=2"}, NotReached, "minimum 0.694.* of this system on the section"),
        (fa.hamiltonian("x**2/2", coordinates="x"), {}, ValueError, "two degrees of freedom or more"),
        (fa.hamiltonian("x**2 - z**2", coordinates="x y z"), {}, ValueError, "energy 0.1 does not bound the motion"),
        (HH, {"axes": {"q": (0, 1)}}, ValueError, "axes must be one of x, y, p_x, p_y, got 'q'"),
        (HH, {"axes": {"x": (1, 0)}}, ValueError, r"axes\['x'\] must be a range"),
        (HH, {"axes": {"x": (5.0, 6.0), "y": (1.0, 2.0)}}, ValueError, "at least 3.*, the least in the ranges"),
        (HH, {"fixed": {"x": 1.0}}, ValueError, r"fixed requires solve or at_rest.* solve='p_x' .* axes=\{'x': \("),
        (
            HH,
            {"fixed": {"y": 0.1}, "section": "x=0"},
            ValueError,
            r"axes must give the ranges .* Try axes=\{'p_y': \(-1, 1\)\}",
        ),
        (HH, {"fixed": {"y": 0.1}, "section": "x=0", "sign": -1, "axes": {"p_y": (0, 1)}}, ValueError, "direction=-1"),
        (HH, {"solve": "p_y"}, ValueError, "axes must give the ranges"),
        (HH, {"at_rest": True, "axes": {"phi": (0, 1)}}, ValueError, "axes and at_rest exclude one another"),
        (HH, {"at_rest": True, "energy": -1.0}, NotReached, "reaches less than a thousandth of the directions"),
        (HH, {"orbits": 0}, ValueError, "orbits must be at least 1"),
        (HH, {"seed": -1}, ValueError, "seed must be one of"),
        (
            fa.Body(fa.Harmonic()),
            {"energy": 3.0},
            ValueError,
            "axes or section must be given for the energy surface of a body",
        ),
    ],
)
def test_wrong_samples(model, change, error, message):
    with pytest.raises(error, match=message):
        fa.energy_sample(model, **{"energy": 0.1, "orbits": 3} | change)


@pytest.mark.parametrize(
    ("starts", "message"),
    [
        ({"grid": "3x3"}, "grid requires a section of a body or of a system of two coordinates"),
        ({}, "axes NAME=LOW:HIGH:N is required"),
        ({"axes": ["x=0:1"]}, "axes x must be LOW:HIGH:N"),
        ({"axes": ["x=0:1:3", "x=0:1:3"]}, "axes x is given twice"),
        ({"axes": ["x"]}, "axes must be NAME=LOW:HIGH:N, got 'x'"),
        ({"axes": ["k=0:1:3"]}, "axes must be one of x, y, z"),
        ({"axes": ["y=0:1:3"], "fixed": ["z=a"]}, "fixed z"),
        ({"microcanonical": True}, "microcanonical needs orbits"),
        ({"microcanonical": True, "orbits": 3, "at_rest": True}, "give microcanonical or at_rest"),
    ],
)
def test_wrong_jobs(starts, message):
    job = fa.Job(model=LOG, energy_surface={"energy": -0.4}, initial_conditions=starts, frequency_map={"time": 50.0})
    with pytest.raises(ValueError, match=message):
        job.plan()


def test_figures_say_what_they_need():
    ax = pytest.importorskip("matplotlib.figure").Figure().subplots()
    with pytest.raises(ValueError, match="starts must lie over two coordinates, got x, y, p_x, p_y"):
        fa.energy_sample(HH, energy=0.1, orbits=3).plot(ax=ax)
    grid = fa.energy_grid(galaxy(), energy=-0.4, axes=TWO, solve="p_y")
    assert grid.plot(ax=ax).missing == 0


def test_recipes_make_the_same_again():
    grid = fa.energy_grid(galaxy(), energy=-0.4, axes=TWO, solve="p_y", fixed={"y": 0.01})
    assert not grid.call.missing
    axes = [(name, np.array(values)) for name, values in grid.call.arguments["axes"]]
    assert (
        fa.energy_grid(galaxy(), energy=-0.4, axes=axes, solve="p_y", fixed=[["y", 0.01]]).z0.tobytes()
        == grid.z0.tobytes()
    )


def test_sections_through_a_pole_ask_for_ranges():
    """-k/r: 0.1 of the length k/|E| has momenta above sqrt(18 |E|), in any units; the ranges named are taken."""
    rng = np.random.default_rng(43)
    for text in ("-k/sqrt(x**2 + y**2)", "(u**2 + v**2)/2 - k/sqrt(x**2 + y**2)"):
        k, energy = 10.0 ** rng.uniform(-3, 3, 2) * (1, -1)
        model = fa.hamiltonian(text, coordinates="x y", momenta="u v" if "u" in text else None, k=k)
        at = {"energy": energy, "section": "x=0"}
        with pytest.raises(
            ValueError, match=r"unbounded at energy .* at a pole .* Pass the ranges of the axes"
        ) as said:
            fa.energy_sample(model, orbits=5, **at)
        with pytest.raises(ValueError, match=r"Pass axes, two arrays such as np\.linspace"):
            fa.energy_grid(model, **at)
        named = str(said.value).split("such as ", 1)[1].rstrip(".").translate(str.maketrans("", "", "()"))
        low, high, bottom, top = (float(part) for part in named.split(","))
        np.testing.assert_allclose([low, high], [k / energy, -k / energy], rtol=1e-5)
        np.testing.assert_allclose([bottom, top], np.sqrt(-18 * energy) * np.array([-1, 1]), rtol=1e-2)
        z = fa.energy_sample(model, orbits=50, axes=((low, high), (bottom, top)), **at).z0
        assert np.abs(z[3]).max() <= top
        assert np.unique(z[3]).size == 50


def test_sections_of_periodic_potentials_ask_for_ranges():
    """What is allowed has no end of pieces: the one nearest to 0, in any units, is named, and its ranges are taken."""
    rng = np.random.default_rng(41)
    for _ in range(2):
        depth, other, unit = rng.uniform(0.5, 2.0), rng.uniform(0.5, 2.0), 10.0 ** rng.uniform(-3, 3)
        model = fa.hamiltonian("-a*cos(x/u) - b*cos(y/u)", a=depth, b=other, u=unit)
        energy = -depth + rng.uniform(-0.8, 0.8) * other
        half, top = unit * np.arccos(-(energy + depth) / other), np.sqrt(2 * (energy + depth + other))
        with pytest.raises(ValueError, match=r"is unbounded at energy .* Pass the ranges of the axes") as said:
            fa.energy_sample(model, energy=energy, section="x=0", orbits=5)
        named = str(said.value).rstrip(".").rsplit("such as ", 1)[1].translate(str.maketrans("", "", "()"))
        np.testing.assert_allclose([float(part) for part in named.split(",")], [-half, half, -top, top], rtol=1e-5)
        axes = ((-half, half), (-top, top))
        z = fa.energy_sample(model, energy=energy, section="x=0", orbits=50, axes=axes).z0
        assert (np.abs(z[1]) <= half).all()
        np.testing.assert_allclose(model.kinetic_energy(*z[2:]) + model.potential_energy(*z[:2]), energy, atol=1e-13)
    turning = fa.hamiltonian("(p**2 + L**2)/(2 + cos(a)*sin(b)) - cos(a) - cos(b)", coordinates="a b", momenta="p L")
    with pytest.raises(ValueError, match=r"such as .*, or periodic=\{'b': '2\*pi'\} if b is an angle"):
        fa.energy_sample(turning, energy=-1.2, section="a=0", orbits=5)


@pytest.mark.parametrize("n", [2, 3])
def test_wells_without_end_ask_for_ranges(n):
    """Below and above the saddles of a lattice, with a period for each coordinate; a well's own ranges will do."""
    rng = np.random.default_rng([43, n])
    names = NAMES[:n]
    unit, depth, shift = 10.0 ** rng.uniform(-3, 3, n), rng.uniform(0.5, 2.0, n), rng.normal()
    given = {f"u{k}": unit[k] for k in range(n)} | {f"a{k}": depth[k] for k in range(n)}
    text = " - ".join(f"a{k}*cos({name}/u{k})" for k, name in enumerate(names))
    model = fa.hamiltonian(f"V0 - {text}", coordinates=" ".join(names), V0=shift, **given)
    least, saddle = shift - depth.sum(), shift - depth.sum() + 2 * depth.min()
    for energy in (least + 0.1 * (saddle - least), saddle - 0.1 * (saddle - least)):
        with pytest.raises(ValueError, match="falls apart into wells without end: give ranges of the coordinates"):
            fa.energy_sample(model, energy=energy, orbits=5)
        axes = {name: (-np.pi * u, np.pi * u) for name, u in zip(names, unit)}
        z = fa.energy_sample(model, energy=energy, orbits=50, axes=axes).z0
        np.testing.assert_allclose(energies(model, z), energy, atol=1e-12)
    with pytest.raises(ValueError, match="give ranges of the coordinates"):
        fa.energy_sample(model, energy=saddle + 0.1 * (saddle - least), orbits=5)


@pytest.mark.parametrize("text", ["(x**2 + y**2 - a**2)**2", "(x**2 - a**2)**2 + (y**2 - b**2)**2"])
def test_rings_and_wells_far_apart_have_an_end(text):
    rng = np.random.default_rng(44)
    for height in (1e-3, 1e-1, 0.9):
        a = 10.0 ** rng.uniform(-3, 3)
        b = a * rng.uniform(0.5, 2.0)
        given = {"a": a, "b": b} if "b" in text else {"a": a}
        model = fa.hamiltonian(text, coordinates="x y", **given)
        energy = height * min(a, given.get("b", a)) ** 4
        z = fa.energy_sample(model, energy=energy, orbits=50, seed=2).z0
        np.testing.assert_allclose(energies(model, z), energy, rtol=1e-9)
        assert np.abs(z[0]).max() < 2 * a


def test_few_of_the_points_tried_are_enough():
    """A few times what is refused: whatever the seed, points are found."""
    model = fa.hamiltonian("(x**2 - 1)**2 + (y**2 - 1)**2", coordinates="x y")
    energy = 3e-5  # four wells of half-widths sqrt(E)/2: pi E of a box of 4.4
    measure = measure_of(EnergyShell(system_of(model), energy), None)
    for seed in range(20):
        z, _ = measure.draw(3, seed)
        np.testing.assert_allclose(energies(model, z), energy, rtol=1e-9)
    axes = {"x": (-30.0, 30.0), "y": (-30.0, 30.0)}  # 2e-3 of them
    for seed in range(20):
        fa.energy_sample(model, energy=1.0, axes=axes, fixed={"p_x": 0.0}, solve="p_y", orbits=1, seed=seed)


def test_a_spherical_pendulum_is_drawn_over_one_turn_of_its_angle_and_within_ranges_of_momenta():
    """The area of the section within ranges, by quadrature of 2 sqrt(2 (E + cos theta)), is the share of the points."""
    model, energy, count = fa.models.SphericalPendulum(), float(np.random.default_rng(46).uniform(-0.5, 0.8)), 4000
    end = np.arccos(-energy)
    whole = fa.energy_sample(model, energy=energy, section="phi=0", orbits=count)
    theta, p = whole["theta"], whole["p_theta"]
    assert np.abs(theta).max() < end
    half = np.linspace(0.0, end, 20_001)
    most = np.sqrt(2 * np.maximum(energy + np.cos(half), 0.0))
    low, high, top = 0.2 * end, 0.7 * end, 0.5 * most.max()
    inside = np.trapezoid(np.where((half > low) & (half < high), np.minimum(most, top), 0.0), half)
    share = inside / np.trapezoid(most, half) / 2
    found = ((theta > low) & (theta < high) & (np.abs(p) < top)).mean()
    assert abs(found - share) < 5 * np.sqrt(share * (1 - share) / count)
    axes = {"theta": (low, high), "p_theta": (-top, top)}
    named = fa.energy_sample(model, energy=energy, section="phi=0", orbits=count, axes=axes)
    assert named.names == ("theta", "p_theta")
    assert low <= named["theta"].min()
    assert named["theta"].max() <= high
    assert np.abs(named["p_theta"]).max() <= top
    np.testing.assert_allclose(model.energy(*named.z0), energy, atol=1e-12)
    inner = (np.abs(named["p_theta"]) < top / 2).mean()
    truth = np.trapezoid(np.where((half > low) & (half < high), np.minimum(most, top / 2), 0.0), half) / inside
    assert abs(inner - truth) < 5 * np.sqrt(truth * (1 - truth) / count)
    with pytest.raises(ValueError, match="axes must be one of theta, p_theta, got 'phi'"):
        fa.energy_sample(model, energy=energy, section="phi=0", orbits=5, axes={"phi": (0, 1)})
    held = fa.energy_sample(
        model, energy=0.3, section="theta=pi/2", fixed={"p_phi": 0.2}, axes={"phi": (-np.pi, np.pi)}, orbits=9
    )
    np.testing.assert_allclose(held.z0[[0, 2, 3]].T, np.tile([np.pi / 2, np.sqrt(0.6 - 0.04), 0.2], (9, 1)))
