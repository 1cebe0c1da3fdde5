"""Systems of other tools: their own energies, accelerations and orbits at random points."""

import warnings

import numpy as np
import pytest

import fastaff as fa

RNG = np.random.default_rng(32)


def slopes(model, points):
    """Accelerations (n, points) of a model with unit masses."""
    return np.transpose([model.force(*point) for point in points.T])


GALA = [
    ("HernquistPotential", {"m": 1e11, "c": 3.0}),
    ("IsochronePotential", {"m": 1e11, "b": 2.0}),
    ("JaffePotential", {"m": 1e11, "c": 5.0}),
    ("KeplerPotential", {"m": 1e10}),
    ("LogarithmicPotential", {"v_c": 0.22, "r_h": 4.0, "q1": 1.0, "q2": 0.9, "q3": 0.75}),
    ("LongMuraliBarPotential", {"m": 1e10, "a": 3.0, "b": 0.4, "c": 0.6, "alpha": 0.4}),
    ("MiyamotoNagaiPotential", {"m": 1e11, "a": 3.0, "b": 0.3}),
    ("MN3ExponentialDiskPotential", {"m": 1e11, "h_R": 3.0, "h_z": 0.3}),
    ("NFWPotential", {"m": 1e12, "r_s": 16.0, "a": 1.0, "b": 0.9, "c": 0.8}),
    ("PlummerPotential", {"m": 1e11, "b": 1.0}),
    ("PowerLawCutoffPotential", {"m": 1e10, "alpha": 1.1, "r_c": 1.9}),
    ("SatohPotential", {"m": 1e11, "a": 3.0, "b": 0.3}),
    ("StonePotential", {"m": 1e11, "r_c": 0.5, "r_h": 9.0}),
]


@pytest.mark.parametrize(("kind", "fields"), GALA, ids=[kind for kind, _ in GALA])
def test_potentials_of_gala(kind, fields):
    potentials = pytest.importorskip("gala.potential")
    units = pytest.importorskip("astropy.units")
    from gala.units import galactic

    fields = {
        name: value * RNG.uniform(0.7, 1.3) if name not in ("q1", "a") else value for name, value in fields.items()
    }
    potential = getattr(potentials, kind)(**fields, units=galactic)
    model = fa.hamiltonian(potential)
    points = RNG.uniform(-9, 9, (3, 30))
    at = points * units.kpc
    energies = [model.potential_energy(*point) for point in points.T]
    np.testing.assert_allclose(energies, potential.energy(at).value, rtol=1e-9)
    np.testing.assert_allclose(slopes(model, points), potential.acceleration(at).value, rtol=2e-8, atol=1e-14)


def test_sums_and_turning_frames_of_gala():
    potentials = pytest.importorskip("gala.potential")
    dynamics, units = pytest.importorskip("gala.dynamics"), pytest.importorskip("astropy.units")
    from gala.units import galactic

    with warnings.catch_warnings():  # its name will mean another one
        warnings.simplefilter("ignore")
        milky_way = potentials.MilkyWayPotential()
    model = fa.hamiltonian(milky_way)
    assert {"m_disk", "a_disk", "m_halo", "G"} <= set(model._fields)
    points = RNG.uniform(-9, 9, (3, 30))
    np.testing.assert_allclose(
        [model.potential_energy(*point) for point in points.T], milky_way.energy(points * units.kpc).value, rtol=1e-9
    )
    bar = potentials.LongMuraliBarPotential(m=1e10, a=3.0, b=0.4, c=0.6, units=galactic)
    frame = potentials.ConstantRotatingFrame(Omega=[0, 0, -40] * units.km / units.s / units.kpc, units=galactic)
    whole = potentials.CCompositePotential(**milky_way, bar=bar)
    turning = potentials.Hamiltonian(whole, frame)
    start = dynamics.PhaseSpacePosition([4.0, 0.3, 0.1] * units.kpc, [10, 180, 20] * units.km / units.s)
    theirs = turning.integrate_orbit(start, dt=0.25 * units.Myr, n_steps=2000, Integrator="dop853")
    mine = fa.integrate(fa.hamiltonian(turning), start, time=500.0, samples=2000, accuracy=1e-9)
    np.testing.assert_allclose(mine.samples[:, :3, 0], theirs.pos.xyz.value.T[1:], atol=1e-5)
    with pytest.raises(ValueError, match=r"coordinates of this potential are x y z: leave them out .*got 'a b c'"):
        fa.hamiltonian(milky_way, coordinates="a b c")
    with pytest.raises(
        ValueError, match=r"x y z: leave them out \(orbits .* plane of symmetry stay there\), got 'x y'"
    ):
        fa.hamiltonian(milky_way, coordinates="x y")
    with pytest.raises(ValueError, match="is V alone: leave them out"):
        fa.hamiltonian(milky_way, momenta="px py pz")
    with pytest.raises(TypeError, match=r"write fa.hamiltonian\(potential\)"):
        fa.affine_body(milky_way)
    assert fa.hamiltonian(milky_way, coordinates=["x", "y", "z"]) == model
    heavier = fa.hamiltonian(milky_way, m_halo=1e12)
    assert heavier.m_halo == 1e12
    assert heavier._replace(m_halo=model.m_halo) == model


def test_a_potential_of_gala_that_is_placed_and_turned_elsewhere():
    potentials, units = pytest.importorskip("gala.potential"), pytest.importorskip("astropy.units")
    from gala.units import galactic
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("zyx", [0.3, 0.5, -0.2])
    potential = potentials.LogarithmicPotential(
        v_c=0.2, r_h=3.0, q1=1.0, q2=0.8, q3=0.6, origin=[1.0, -2.0, 0.5], R=turn.as_matrix(), units=galactic
    )
    model, points = fa.hamiltonian(potential), RNG.uniform(-9, 9, (3, 30))
    np.testing.assert_allclose(
        slopes(model, points), potential.acceleration(points * units.kpc).value, rtol=1e-9, atol=1e-14
    )
    plain = potentials.HenonHeilesPotential()
    np.testing.assert_allclose(
        fa.hamiltonian(plain).potential_energy(0.3, 0.2), plain.energy([0.3, 0.2])[0], rtol=1e-12
    )


def test_what_gala_has_no_true_formula_of_is_refused():
    potentials = pytest.importorskip("gala.potential")
    from gala.units import galactic

    turned = potentials.LogarithmicPotential(v_c=0.2, r_h=3.0, q1=1.0, q2=0.8, q3=0.6, phi=0.7, units=galactic)
    said = r"has not its energies, .* \(gala's formula leaves out phi = 0.7 of its LogarithmicPotential\)"
    with pytest.raises(ValueError, match=said):
        fa.hamiltonian(turned)
    with pytest.raises(ValueError, match=r"leaves out phi = 1.69297 of its LogarithmicPotential"):
        fa.hamiltonian(potentials.LM10Potential())
    with pytest.raises(ValueError, match="no formula of a BurkertPotential; write one"):
        fa.hamiltonian(potentials.BurkertPotential(rho=1e7, r0=3.0, units=galactic))
    with pytest.raises(TypeError, match=r"model must be a model .*fa.hamiltonian\(potential\)"):
        fa.integrate(turned, [1.0, 0, 0, 0, 0.2, 0], time=1.0)


GALPY = [
    ("DehnenCoreSphericalPotential", {"a": 1.2}),
    ("DehnenSphericalPotential", {"a": 1.2, "alpha": 0.7}),
    ("FlattenedPowerPotential", {"alpha": 0.6, "q": 0.8, "core": 0.2}),
    ("HernquistPotential", {"a": 1.1}),
    ("IsochronePotential", {"b": 0.7}),
    ("JaffePotential", {"a": 1.3}),
    ("KeplerPotential", {}),
    ("KuzminKutuzovStaeckelPotential", {"ac": 4.0, "Delta": 1.1}),
    ("LogarithmicHaloPotential", {"q": 0.85, "b": 0.9, "core": 0.1}),
    ("LogarithmicHaloPotential", {"q": 0.7}),
    ("MiyamotoNagaiPotential", {"a": 0.5, "b": 0.05}),
    ("NFWPotential", {"a": 2.1}),
    ("PlummerPotential", {"b": 0.6}),
    ("PowerSphericalPotential", {"alpha": 2.6}),
    ("PowerSphericalPotentialwCutoff", {"alpha": 1.0, "rc": 0.4}),
    ("PowerSphericalPotentialwCutoff", {"alpha": 0.37, "rc": 1.3}),
    ("PseudoIsothermalPotential", {"a": 0.9}),
]


@pytest.mark.parametrize(("kind", "fields"), GALPY, ids=[f"{kind} {len(fields)}" for kind, fields in GALPY])
def test_potentials_of_galpy(kind, fields):
    potentials = pytest.importorskip("galpy.potential")
    potential = getattr(potentials, kind)(amp=RNG.uniform(0.5, 2.0), **fields)
    check_galpy(potentials, potential)


def check_galpy(potentials, potential, model=None):
    model = model or fa.hamiltonian(potential)
    points = RNG.uniform(-2, 2, (3, 20))
    R, phi = np.hypot(*points[:2]), np.arctan2(points[1], points[0])
    at = [(R[k], points[2, k], phi[k]) for k in range(20)]
    energies = [potentials.evaluatePotentials(potential, r, z, phi=f) for r, z, f in at]
    np.testing.assert_allclose([model.potential_energy(*point) for point in points.T], energies, rtol=1e-10)
    radial, vertical, torque = (
        np.array([force(potential, r, z, phi=f) for r, z, f in at])
        for force in (potentials.evaluateRforces, potentials.evaluatezforces, potentials.evaluatephitorques)
    )
    cos, sin = np.cos(phi), np.sin(phi)
    theirs = np.array([radial * cos - torque / R * sin, radial * sin + torque / R * cos, vertical])
    np.testing.assert_allclose(slopes(model, points), theirs, rtol=1e-9, atol=1e-12)


def test_the_milky_way_of_galpy_and_of_gala():
    potentials = pytest.importorskip("galpy.potential")
    from galpy.orbit import Orbit

    model = fa.hamiltonian(potentials.MWPotential2014)
    check_galpy(potentials, potentials.MWPotential2014, model)
    disc = Orbit([1.0, 0.1, 1.1, 0.0, 0.1, 0.3])
    times = np.linspace(0.0, 50.0, 501)
    with warnings.catch_warnings():  # of the language that it runs in
        warnings.simplefilter("ignore")
        disc.integrate(times, potentials.MWPotential2014, method="dop853_c")
    run = fa.integrate(model, disc, time=50.0, accuracy=1e-11)
    assert run.status[0] == 0
    np.testing.assert_allclose(run.z[:3, 0], [disc.x(50.0), disc.y(50.0), disc.z(50.0)], atol=1e-9)
    found = fa.frequency_map(model, disc, time=200.0, signals="R z phi")
    assert found.names == ("R", "z", "phi")
    assert found.status[0] == 0
    np.testing.assert_array_less(found.error[:, 0], 1e-7)
    turns = np.unwrap(np.arctan2(disc.y(times), disc.x(times)))
    assert abs((turns[-1] - turns[0]) / 50 / (2 * np.pi) - found.nu[2, 0]) < 0.003

    gala, units = pytest.importorskip("gala.potential"), pytest.importorskip("astropy.units")
    dynamics, whole = pytest.importorskip("gala.dynamics"), gala.BovyMWPotential2014()
    model, points = fa.hamiltonian(whole), RNG.uniform(-9, 9, (3, 30))
    energies = [model.potential_energy(*point) for point in points.T]
    np.testing.assert_allclose(energies, whole.energy(points * units.kpc).value, rtol=1e-12)
    np.testing.assert_allclose(slopes(model, points), whole.acceleration(points * units.kpc).value, rtol=1e-11)
    start = dynamics.PhaseSpacePosition([8.0, 0.3, 0.1] * units.kpc, [10, 210, 20] * units.km / units.s)
    theirs = whole.integrate_orbit(start, dt=0.25 * units.Myr, n_steps=2000, Integrator="dop853")
    mine = fa.integrate(model, start, time=500.0, accuracy=1e-11)
    np.testing.assert_allclose(mine.z[:3, 0], theirs.pos.xyz.value[:, -1], atol=1e-6)


def test_sums_of_galpy_and_what_is_refused():
    potentials = pytest.importorskip("galpy.potential")
    disk = potentials.MiyamotoNagaiPotential(a=0.5, b=0.05, normalize=0.6)
    halo = potentials.NFWPotential(a=2.0, normalize=0.4)
    check_galpy(potentials, disk + halo)
    plane = potentials.HenonHeilesPotential(amp=1.0)
    model = fa.hamiltonian(plane)
    ours, x, y = fa.HenonHeiles(), *RNG.uniform(-0.5, 0.5, 2)
    assert abs(model.potential_energy(x, y) - ours.potential_energy(x, y)) < 1e-15
    check_galpy(potentials, disk + halo, fa.hamiltonian([disk, halo]))
    with pytest.raises(ValueError, match="no formula of galpy's BurkertPotential is known, only of Dehnen"):
        fa.hamiltonian(halo + potentials.BurkertPotential())
    with pytest.raises(ValueError, match=r"alpha of a PowerSphericalPotentialwCutoff must be below 2, got 2.2"):
        fa.hamiltonian(potentials.PowerSphericalPotentialwCutoff(alpha=2.2))
    with pytest.raises(TypeError, match="some of one dimension, got HenonHeilesPotential"):
        fa.hamiltonian([halo, potentials.HenonHeilesPotential()])
    with pytest.raises(ValueError, match="has not its energies"):
        fa.hamiltonian(potentials.PowerSphericalPotential(alpha=2.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fa.hamiltonian(halo)


def test_expressions_of_heyoka():
    heyoka = pytest.importorskip("heyoka")
    x, y, vx, vy = heyoka.make_vars("x", "y", "v_x", "v_y")
    potential = heyoka.par[0] * x**2 / 2 + heyoka.sqrt(1 + y**2) + 0.1 * heyoka.cos(x * y) + heyoka.exp(-(x**2))
    model = fa.hamiltonian(potential, coordinates="x y", par_0=1.3)
    start = RNG.uniform(-0.5, 0.5, 4)
    rates = [(x, vx), (y, vy), (vx, -heyoka.diff(potential, x)), (vy, -heyoka.diff(potential, y))]
    truth = heyoka.taylor_adaptive(rates, list(start), pars=[1.3])
    truth.propagate_until(20.0)
    np.testing.assert_allclose(fa.integrate(model, start, time=20.0, accuracy=1e-12).z[:, 0], truth.state, atol=1e-10)
    flow = fa.ode(rates, par_0=1.3)
    np.testing.assert_allclose(fa.integrate(flow, start, time=20.0).z[:, 0], truth.state, atol=1e-9)
    driven = fa.hamiltonian(x**2 / 2 - 0.1 * x * heyoka.cos(2.0 * heyoka.time), coordinates="x", drive_period="pi")
    assert driven.period == pytest.approx(np.pi)
    with pytest.raises(ValueError, match="par_0"):
        fa.hamiltonian(potential, coordinates="x y")
    with pytest.raises(ValueError, match="kepE"):
        fa.hamiltonian(heyoka.kepE(x, y), coordinates="x y")


def test_systems_of_sympy():
    sympy = pytest.importorskip("sympy")
    x, y, z, s = sympy.symbols("x y z s")
    sides = {x: s * (y - x), y: x * (28 - z) - y, z: x * y - sympy.Rational(8, 3) * z}
    text = fa.ode("x' = s*(y - x); y' = x*(28 - z) - y; z' = x*y - 8/3*z", s=10.0)
    point = RNG.normal(size=3)
    for given in (sides, list(sides.items())):
        model = fa.ode(given, s=10.0)
        assert model.coordinates == ("x", "y", "z")
        np.testing.assert_allclose(model.rates(*point), text.rates(*point), rtol=1e-14)
    with pytest.raises(ValueError, match="gamma"):
        fa.ode({x: sympy.gamma(x)})
    with pytest.raises(TypeError, match="text must be equations such as"):
        fa.ode([1.0, 2.0])
