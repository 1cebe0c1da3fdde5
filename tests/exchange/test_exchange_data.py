"""Orbits of other tools as they are: tables, labelled arrays, Quantities, Orbits, archives, monitors."""

import warnings
from functools import cache

import numpy as np
import pytest
from comparison import same

import fastaff as fa
from fastaff.runs.given_orbits import given_orbits

RNG = np.random.default_rng(31)
DT, SAMPLES = 0.2, 600
STARTS = RNG.uniform(-0.15, 0.15, (4, 3))
NAMES = ("x", "y", "p_x", "p_y")


@cache
def own_orbits():
    return fa.integrate(fa.HenonHeiles(), STARTS, time=DT * SAMPLES, samples=SAMPLES)


def samples_of_own():
    return own_orbits().samples.transpose(1, 2, 0)


def test_own_samples_need_no_transpose():
    same(fa.tunes(own_orbits().samples), fa.tunes(samples_of_own()))
    same(fa.orbit_frequencies(own_orbits().samples, DT).nu, fa.orbit_frequencies(samples_of_own(), DT).nu)
    same(fa.tunes(own_orbits()[:2].samples), fa.tunes(samples_of_own()[:, :2]))
    standard = fa.iterated_map("p1 = p + K*sin(x); x1 = x + p1", K=-0.3)
    orbits = fa.integrate(standard, RNG.uniform(-0.5, 0.5, (2, 4)), time=300, samples=300)
    same(fa.tunes(orbits.samples), fa.tunes(np.ascontiguousarray(orbits.samples.transpose(1, 2, 0))))
    with pytest.raises(ValueError, match=r"samples.transpose\(1, 2, 0\)"):
        fa.tunes(own_orbits().samples.copy())  # an array like any other


def columns(shuffled):
    """A row for each sample of each orbit, in any order; the second orbit ends early."""
    orbit, sample = (part.ravel() for part in np.meshgrid(np.arange(3), np.arange(SAMPLES), indexing="ij"))
    keep = (orbit != 1) | (sample < 300)
    orbit, sample = orbit[keep], sample[keep]
    order = RNG.permutation(orbit.size) if shuffled else np.arange(orbit.size)
    orbit, sample = orbit[order], sample[order]
    rows = {name: samples_of_own()[k, orbit, sample] for k, name in enumerate(NAMES)}
    return {"particle": 10 * orbit, "time": own_orbits().times[sample], **rows}


def ended():
    array = np.array(samples_of_own())
    array[:, 1, 300:] = np.nan
    return array


@pytest.mark.parametrize("shuffled", [False, True])
@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_tables_of_several_orbits(package, shuffled):
    frames = pytest.importorskip(package)
    table = frames.DataFrame(columns(shuffled))
    found = fa.orbit_frequencies(table, coordinates=NAMES)
    seen = [orbit // 10 for orbit in dict.fromkeys(table["particle"])]
    expected = fa.orbit_frequencies(ended()[:, seen], times=own_orbits().times, coordinates=NAMES)
    same(found, expected)
    assert found.status[seen.index(1)] == fa.Status.NONFINITE
    if package == "pandas":
        same(fa.orbit_frequencies(table.set_index(["particle", "time"]), coordinates=NAMES), expected)
    with pytest.raises(ValueError, match=r"coordinates must name the columns .* which has particle, time, x, y"):
        fa.orbit_frequencies(table)
    with pytest.raises(ValueError, match=r"which has particle, .*, got 'px'"):
        fa.tunes(table, coordinates="x y px py")
    numbered = {"star_id": table["particle"], "t": table["time"], **{name: table[name] for name in NAMES}}
    same(fa.orbit_frequencies(frames.DataFrame(numbered), coordinates=NAMES), expected)
    del numbered["t"]
    with pytest.raises(ValueError, match=r"samples must have a column 'time' or 'turn' that orders .* \('star_id'\)"):
        fa.orbit_frequencies(frames.DataFrame(numbered), DT, coordinates=NAMES)
    twice = frames.concat([table, table[:1]])
    with pytest.raises(ValueError, match="one row for each 'particle' and 'time'"):
        fa.tunes(twice, coordinates=NAMES)


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_orbits_of_tables_keep_their_order(package):
    orbits = np.random.default_rng(5).normal(size=(2, 3, 300))
    rows = {"x": orbits[0].ravel(), "p": orbits[1].ravel(), "turn": np.tile(np.arange(300), 3)}
    for names in ([900, 12, 77], ["b", "c", "a"]):
        table = pytest.importorskip(package).DataFrame({"orbit": np.repeat(names, 300).tolist(), **rows})
        np.testing.assert_array_equal(given_orbits(table, coordinates="x p").read(0, 3), orbits)


def test_results_of_scipy():
    integrate, t = pytest.importorskip("scipy.integrate"), np.arange(200) * 0.3
    found = integrate.solve_ivp(lambda t, z: [z[1], -z[0]], (0, 60), [1, 0], t_eval=t, rtol=1e-9, atol=1e-9)
    same(fa.orbit_frequencies(found), fa.orbit_frequencies(found.y, times=t))
    np.testing.assert_allclose(fa.orbit_frequencies(found, coordinates="x v").omega, [[1.0]], atol=1e-6)


def test_pairs_of_times_and_rows_name_the_call():
    orbits = np.empty((2, 2), dtype=object)
    for k in range(2):
        orbits[k] = own_orbits().times, samples_of_own()[:, k].T
    for given in (orbits, orbits[0], tuple(orbits[1]), [tuple(pair) for pair in orbits]):
        with pytest.raises(TypeError, match=r"rows.T, times=times; for several orbits .*times=orbits\[0\]\[0\]"):
            fa.orbit_frequencies(given)
    samples = np.stack([rows.T for _, rows in orbits], axis=1)
    same(
        fa.orbit_frequencies(samples, times=orbits[0][0]),
        fa.orbit_frequencies(samples_of_own()[:, :2], times=orbits[0][0]),
    )


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_tables_of_one_orbit_and_columns(package):
    frames = pytest.importorskip(package)
    table = frames.DataFrame({name: samples_of_own()[k, 0] for k, name in enumerate(NAMES)})
    same(fa.tunes(table, coordinates=NAMES), fa.tunes(samples_of_own()[:, 0], coordinates=NAMES))
    same(fa.naff(table["x"], DT, lines=2), fa.naff(samples_of_own()[0, 0], DT, lines=2))
    same(
        fa.orbit_frequencies(table, DT, coordinates="x p_x").nu,
        fa.orbit_frequencies(samples_of_own()[[0, 2], 0], DT).nu,
    )


def test_quantities_become_kpc_and_myr():
    units = pytest.importorskip("astropy.units")
    q, v = samples_of_own()[:2] * units.kpc, (samples_of_own()[2:] * units.kpc / units.Myr).to(units.km / units.s)
    expected = fa.orbit_frequencies(samples_of_own(), times=own_orbits().times, coordinates="x y vx vy")
    named = {"x": q[0], "y": q[1].to(units.pc), "vx": v[0], "vy": v[1]}
    times = (own_orbits().times * units.Myr).to(units.Gyr)
    for found in (
        fa.orbit_frequencies(named, times=times, coordinates="x y vx vy"),
        fa.orbit_frequencies([*q, *v], times=times, coordinates="x y vx vy"),
        fa.orbit_frequencies(named, (DT * units.Myr).to(units.s), coordinates="x y vx vy"),
    ):
        np.testing.assert_allclose(found.nu, expected.nu, rtol=1e-9)
    with pytest.raises(TypeError, match=r"units are not converted: give .to_value\(unit\)"):
        fa.integrate(fa.HenonHeiles(), [0.1, 0, 0, 0.1], time=1.0 * units.s)
    with pytest.raises(TypeError, match=r"in km2 / s2.*of the system, -0\.010[0-9]* for one in kpc, Myr"):
        fa.energy_sample(fa.HenonHeiles(), energy=-1e4 * units.km**2 / units.s**2, orbits=3)


def test_results_of_quantities_say_their_units():
    units = pytest.importorskip("astropy.units")
    q, v = samples_of_own()[:2] * units.kpc, (samples_of_own()[2:] * units.kpc / units.Myr).to(units.km / units.s)
    named = {"x": q[0], "y": q[1], "vx": v[0], "vy": v[1]}
    times = (own_orbits().times * units.Myr).to(units.Gyr)
    found = fa.orbit_frequencies(named, times=times, coordinates="x y vx vy")
    said = {name: entry["attrs"].get("units") for name, entry in found.to_dict()["data_vars"].items()}
    assert said["nu"] == "cycles/Myr"
    assert said["error"] == "cycles/Myr"
    assert found[:2].to_dict()["data_vars"]["nu"]["attrs"] == {"units": "cycles/Myr"}
    plain = fa.orbit_frequencies(samples_of_own(), times=own_orbits().times, coordinates="x y vx vy")
    assert plain.to_dict()["data_vars"]["nu"]["attrs"] == {"units": "cycles/time"}


def test_orbits_of_gala():
    potentials = pytest.importorskip("gala.potential")
    units, dynamics = pytest.importorskip("astropy.units"), pytest.importorskip("gala.dynamics")
    from gala.units import galactic

    potential = potentials.LogarithmicPotential(
        v_c=220 * units.km / units.s, r_h=8 * units.kpc, q1=1, q2=0.9, q3=0.7, units=galactic
    )
    place = RNG.uniform(1, 6, (3, 4)) * units.kpc
    points = dynamics.PhaseSpacePosition(pos=place, vel=RNG.uniform(-80, 80, (3, 4)) * units.km / units.s)
    orbits = potential.integrate_orbit(points, dt=1.0 * units.Myr, n_steps=8000, Integrator="dop853")
    found = fa.orbit_frequencies(orbits)
    mine = fa.integrate(fa.hamiltonian(potential), points, time=8000.0, samples=8000)
    expected = fa.orbit_frequencies(mine)
    known = np.isfinite(found.error) & np.isfinite(expected.error)
    assert known.mean() > 0.6
    off = np.abs(found.nu - expected.nu)
    assert (off <= found.error + expected.error + 1e-9)[known].all()
    assert found.names == ("x", "y", "z")
    elsewhere = dynamics.PhaseSpacePosition(*(getattr(points.represent_as("cylindrical"), k) for k in ("pos", "vel")))
    np.testing.assert_allclose(
        fa.integrate(fa.hamiltonian(potential), elsewhere, time=1.0).z,
        fa.integrate(fa.hamiltonian(potential), points, time=1.0).z,
        rtol=1e-9,
    )
    assert found.to_dict()["data_vars"]["nu"]["attrs"] == {"units": "cycles/Myr"}
    one = fa.orbit_frequencies(orbits[:, 2])
    np.testing.assert_allclose(one.nu[:, 0], found.nu[:, 2], rtol=1e-12)
    with pytest.raises(TypeError, match="z0 must be a PhaseSpacePosition of gala, got Logarithmic"):
        fa.integrate(fa.hamiltonian(potential), potential, time=1.0)
    with pytest.raises(TypeError, match=r"orbit\[0\]"):
        fa.integrate(fa.hamiltonian(potential), orbits, time=1.0)


def test_orbits_of_galpy():
    potential = pytest.importorskip("galpy.potential")
    from galpy.orbit import Orbit

    halo = potential.LogarithmicHaloPotential(normalize=1.0, q=0.9, core=0.2)
    vxvv = np.array([[1.0, 0.1, 1.1, 0.1, 0.05, 0.3], [1.1, -0.2, 0.8, 0.05, 0.1, 2.0]])
    orbits, alone, plane = Orbit(vxvv), Orbit(vxvv[0]), Orbit([1.0, 0.1, 1.1, 0.1, 0.05])
    times = np.linspace(0, 300, 6001)
    with pytest.raises(ValueError, match="an integrated Orbit of galpy"):
        fa.orbit_frequencies(orbits)
    with warnings.catch_warnings():  # it says that it uses C
        warnings.simplefilter("ignore")
        for orbit in (orbits, alone, plane):
            orbit.integrate(times, halo, method="dop853_c", progressbar=False)
    model = fa.hamiltonian(halo)
    mine = fa.integrate(model, orbits, time=300.0, samples=6000)
    np.testing.assert_allclose(mine.samples[-1, 0], orbits.x(times[-1]), atol=1e-6)
    np.testing.assert_allclose(mine.samples[-1, 5], orbits.vz(times[-1]), atol=1e-6)
    with pytest.raises(TypeError, match="text must be a potential of galpy, or some of one dimension, got Orbit"):
        fa.hamiltonian(orbits)
    found, expected = fa.orbit_frequencies(orbits), fa.orbit_frequencies(mine)
    np.testing.assert_allclose(found.nu, expected.nu, rtol=1e-6)
    np.testing.assert_allclose(fa.orbit_frequencies(alone).nu[:, 0], found.nu[:, 0], rtol=1e-9)
    assert fa.orbit_frequencies(plane).names == ("R", "z")


def test_bodies_of_an_archive(tmp_path):
    rebound = pytest.importorskip("rebound")
    simulation = rebound.Simulation()
    simulation.integrator, simulation.dt = "whfast", 0.05
    simulation.add(m=1.0)
    n = RNG.uniform(0.3, 1.2, 2)
    for rate in n:
        simulation.add(m=0.0, a=rate ** (-2 / 3), e=0.0)
    path = str(tmp_path / "archive.bin")
    simulation.save_to_file(path, step=10, delete_file=True)
    simulation.integrate(1000.0, exact_finish_time=0)
    found = fa.orbit_frequencies(rebound.Simulationarchive(path))
    assert np.abs(found.dominant[0, 1:] * 2 * np.pi - n).max() < 1e-8
    with pytest.raises(TypeError, match="save_to_file"):
        fa.orbit_frequencies(simulation)
    with pytest.raises(TypeError, match="of a body give"):
        fa.integrate(fa.HenonHeiles(), simulation, time=1.0)


def test_turns_of_xtrack():
    xtrack = pytest.importorskip("xtrack")
    turn = xtrack.LineSegmentMap(qx=0.31, qy=0.22, betx=3.0, bety=5.0)
    line = xtrack.Line(elements=[turn])
    line.particle_ref = xtrack.Particles(p0c=1e9, mass0=xtrack.PROTON_MASS_EV)
    line.build_tracker()
    particles = line.build_particles(x=np.linspace(1e-4, 1e-3, 5), y=1e-4)
    line.track(particles, num_turns=256, turn_by_turn_monitor=True)
    found = fa.tunes(line.record_last_track)
    np.testing.assert_allclose(found.nu, np.repeat([[0.31], [0.22]], 5, axis=1), atol=1e-12)
    assert found.names == ("x", "y")
    one = fa.tunes(line.record_last_track, coordinates="y py")
    np.testing.assert_allclose(one.nu[0], 0.22, atol=1e-12)
    with pytest.raises(TypeError, match="turn_by_turn_monitor=True"):
        fa.tunes(particles)


def test_particles_that_xtrack_loses():
    xtrack = pytest.importorskip("xtrack")
    turn = xtrack.LineSegmentMap(qx=0.31, qy=0.22, betx=3.0, bety=5.0)
    line = xtrack.Line(elements=[turn, xtrack.Multipole(knl=[0, 0, 60.0]), xtrack.LimitEllipse(a=0.02, b=0.02)])
    line.particle_ref = xtrack.Particles(p0c=1e9, mass0=xtrack.PROTON_MASS_EV)
    line.build_tracker()
    particles = line.build_particles(x=np.linspace(1e-4, 1.9e-2, 8), y=1e-4)
    line.track(particles, num_turns=512, turn_by_turn_monitor=True)
    found = fa.tunes(line.record_last_track)
    order = np.argsort(particles.particle_id)
    lost = particles.state[order] <= 0
    assert 0 < lost.sum() < 8
    np.testing.assert_array_equal(found.status, np.where(lost, fa.Status.LOST, fa.Status.OK))
    np.testing.assert_array_equal(found.turns[lost], particles.at_turn[order][lost] + 1)
    # a chosen start of ours: those that are alive
    assert fa.integrate(fa.models.FroeschleMap(), particles, time=3).z.shape == (4, 8 - lost.sum())


def test_turns_of_pyat():
    at = pytest.importorskip("at")
    cell = [at.Drift("d", 1.0), at.Quadrupole("qf", 0.3, 1.4), at.Drift("d", 1.0), at.Quadrupole("qd", 0.3, -1.4)]
    ring = at.Lattice(cell, energy=3e9, periodicity=1)
    start = np.zeros((6, 4))
    start[0], start[2] = np.linspace(1e-6, 1e-5, 4), 2e-6
    turns = ring.track(start, nturns=512)[0]
    expected = ring.get_tune(get_integer=False)[:2]
    found = fa.tunes(turns)
    np.testing.assert_allclose(found.nu, np.repeat(np.asarray(expected)[:, None], 4, axis=1), atol=1e-7)
    same(found, fa.tunes(turns[[0, 2, 1, 3], :, 0]))


def test_angles_about_an_axis_in_the_isochrone():
    """Omega_r = (-2E)^(3/2)/GM, and Omega_phi/Omega_r = (1 + L/sqrt(L^2 + 4 GM b))/2 (Binney & Tremaine, 3.226)."""
    b, count = 0.7, 12
    x, vx, vy = RNG.uniform(0.5, 2, count), RNG.uniform(-0.3, 0.3, count), RNG.uniform(0.2, 0.6, count)
    vy *= RNG.choice([-1, 1], count)
    zero = np.zeros(count)
    disk = fa.hamiltonian("-1/(b + sqrt(b**2 + x**2 + y**2))", b=b)
    orbits = fa.integrate(disk, [x, zero, vx, vy], time=1500.0, samples=12000)
    found = fa.orbit_frequencies(orbits.samples, times=orbits.times, signals="R phi")
    L, E = x * vy, (vx**2 + vy**2) / 2 - 1 / (b + np.sqrt(b**2 + x**2))
    radial = (-2 * E) ** 1.5
    turning = np.sign(L) * radial * (1 + np.abs(L) / np.sqrt(L**2 + 4 * b)) / 2
    np.testing.assert_allclose(found.omega, [radial, turning], rtol=1e-7)
    assert (np.abs(found.omega - [radial, turning]) <= 2 * np.pi * found.error + 1e-8).all()
    assert found.names == ("R", "phi")
    assert fa.frequency_map(disk, [x, zero, vx, vy], time=400.0, signals="R phi").names == ("R", "phi")
    with pytest.raises(
        ValueError, match="signals must be 'R phi' for 2 coordinates, 'R z phi' for 3 coordinates, or an object of fast"
    ):
        fa.orbit_frequencies(orbits, signals="r theta")


def test_tables_without_rows_or_of_arrow_are_refused_with_the_call():
    polars = pytest.importorskip("polars")
    table = polars.DataFrame({"x": np.cos(np.arange(99.0)), "v": -np.sin(np.arange(99.0))})
    for call in (lambda value: fa.tunes(value, coordinates="x v"), fa.iterated_map):
        with pytest.raises(TypeError, match=r"a LazyFrame of polars has no rows yet: give its .collect\(\)"):
            call(table.lazy())
    pytest.importorskip("pyarrow")
    with pytest.raises(TypeError, match=r"table of Arrow: give samples.to_pandas\(\) or polars.from_arrow\(samples\)"):
        fa.tunes(table.to_arrow(), coordinates="x v")
    again = polars.from_arrow(table.to_arrow())
    assert (fa.tunes(again, coordinates="x v").nu == fa.tunes(table, coordinates="x v").nu).all()
