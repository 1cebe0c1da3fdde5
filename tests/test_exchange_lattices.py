"""Lattices of xtrack and PyAT as maps of one turn, against the same particles in these programs."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.exchange.kicks import Kick, turn
from fastaff.exchange.linear_parts import J
from fastaff.models.maps import jacobian

RNG = np.random.default_rng(41)
STARTS = RNG.uniform(-3e-4, 3e-4, (4, 12))
TURNS = 100


def _symplectic(rng):
    """A random symplectic matrix of x, y, px, py: the exponential of a Hamiltonian one."""
    from scipy.linalg import expm

    symmetric = rng.normal(size=(4, 4))
    return expm(0.4 * J @ (symmetric + symmetric.T))


def test_a_long_map_is_the_product_of_its_parts():
    """Against complex numbers in NumPy, with its derivative by the complex step of real ones."""
    rng = np.random.default_rng(3)
    parts = [(_symplectic(rng), rng.normal(size=4) * 1e-2)]
    for orders in (1, 2, 3, 4, 3, 5):
        parts += [
            Kick(tuple(rng.normal(size=orders)), tuple(rng.normal(size=orders - 1))),
            (_symplectic(rng), np.zeros(4)),
        ]
    model = fa.mapping(turn(parts), coordinates="x y", momenta="px py")

    def image(z):
        for part in parts:
            if not isinstance(part, Kick):
                z = np.tensordot(part[0], z, 1) + part[1].reshape(4, *[1] * (z.ndim - 1))
                continue
            place, total, factorial = z[0] + 1j * z[1], 0, 1.0
            for n, (normal, skew) in enumerate(zip(part.knl, (*part.ksl, 0.0), strict=True)):
                factorial *= max(n, 1)
                total = total + (normal + 1j * skew) * place**n / factorial
            z = z + np.array([0 * total.real, 0 * total.real, -total.real, total.imag])
        return z

    z = 0.1 * rng.normal(size=(4, 9))
    np.testing.assert_allclose(np.array(model.iterate(*z)), image(z), rtol=1e-12)
    h, own = 1e-6, jacobian(model, z)
    for k in range(4):
        step = h * np.eye(4)[k][:, None]
        np.testing.assert_allclose(own[:, k], (image(z + step) - image(z - step)) / (2 * h), rtol=1e-5, atol=1e-6)
    assert model.symplectic


def _ring(at, dipoles=False, nonlinear=True):
    qf, qd, drift = at.Quadrupole("qf", 0.4, 0.9), at.Quadrupole("qd", 0.4, -0.8), at.Drift("d", 0.8)
    sextupole = at.ThinMultipole("s", [0, 0, 0.4], [0, 0, 5.0])
    octupole = at.ThinMultipole("o", [0, 0, 0, 20.0], [0, 0, 2.0, 900.0])
    corrector = at.Corrector("c", 0.0, [1e-5, -2e-5])
    bend = at.Dipole("b", 0.6, np.pi / 8)
    cell = [qf, drift, *([sextupole] if nonlinear else []), *([bend] if dipoles else [drift]), qd, corrector, drift]
    return at.Lattice([*cell, *([octupole] if nonlinear else []), drift, at.Marker("m"), *cell], energy=1e9)


def _tracked(ring, starts):
    rays = np.zeros((6, starts.shape[1]), order="F")
    rays[[0, 2, 1, 3]] = starts
    return ring.track(rays, nturns=TURNS)[0][[0, 2, 1, 3], :, 0, -1]


@pytest.mark.slow
def test_lattices_of_pyat():
    at = pytest.importorskip("at")
    ring = _ring(at)
    model = fa.mapping(ring)
    assert model.symplectic
    found = fa.integrate(model, STARTS, time=TURNS)
    assert found.success
    np.testing.assert_allclose(found.z, _tracked(ring, STARTS), atol=1e-10 * np.abs(STARTS).max())


@pytest.mark.slow
def test_dipoles_of_pyat_are_linear():
    at = pytest.importorskip("at")
    ring = _ring(at, dipoles=True, nonlinear=False)
    model = fa.mapping(ring)
    tiny = 1e-9 * STARTS / np.abs(STARTS).max()
    orbit = at.find_orbit4(ring)[0][[0, 2, 1, 3]]
    matrix = at.find_m44(ring, 0)[0]
    mine = jacobian(model, orbit)
    np.testing.assert_allclose(mine, matrix[np.ix_([0, 2, 1, 3], [0, 2, 1, 3])], atol=1e-6)
    phases = np.sort(np.abs(np.angle(np.linalg.eigvals(mine))))[::2] / (2 * np.pi)
    tunes = np.sort(np.minimum(ring.get_tune(), 1 - ring.get_tune()))
    np.testing.assert_allclose(phases, tunes, atol=1e-7)
    assert fa.integrate(model, orbit[:, None] + tiny, time=TURNS).success


@pytest.mark.slow
def test_what_is_no_part_of_a_map_is_named():
    at = pytest.importorskip("at")
    thick = at.Lattice([at.Drift("d", 1.0), at.Sextupole("mine", 0.3, 12.0)], energy=1e9)
    with pytest.raises(ValueError, match=r"the element 'mine' \(Sextupole\) is neither linear nor a thin multipole"):
        fa.mapping(thick)
    with pytest.raises(TypeError, match=r"write fa.mapping\(lattice\)"):
        fa.frequency_map(thick, STARTS, time=100)
    with pytest.raises(TypeError, match=r"got Lattice of PyAT: ring.track.*fa.integrate\(fa.mapping\(ring\)"):
        fa.tunes(thick)
    with pytest.raises(ValueError, match="are x y and px py: leave them out"):
        fa.mapping(_ring(at, dipoles=False, nonlinear=True), coordinates="a b")
    rays, off = np.asfortranarray(np.zeros((6, STARTS.shape[1]))), []
    rays[[0, 2, 1, 3]] = STARTS
    end = thick.track(rays.copy(order="F"), nturns=1)[0][[0, 2, 1, 3], :, 0, -1]
    for n in (4, 16):  # as the refusal says: errors fall with n^2
        e = thick[1]
        L, drift = e.Length, at.Drift("d", e.Length / 2 / n)
        cut = [drift, at.ThinMultipole("k", e.PolynomA * L / n, e.PolynomB * L / n), drift] * n
        off.append(
            np.abs(fa.integrate(fa.mapping(at.Lattice([thick[0], *cut], energy=1e9)), STARTS, time=1).z - end).max()
        )
    assert 12 < off[0] / off[1] < 20


def _line(xtrack):
    elements = {
        "qf": xtrack.Quadrupole(length=0.4, k1=0.9),
        "d1": xtrack.Drift(length=0.8),
        "s": xtrack.Multipole(knl=[0, 0, 9.0], ksl=[0, 0, 0.7]),
        "d2": xtrack.Drift(length=0.8),
        "thin": xtrack.Multipole(knl=[0, -0.33], ksl=[0, 0.02]),
        "d3": xtrack.Drift(length=1.2),
        "o": xtrack.Multipole(knl=[1e-5, 0, 0, 4000.0]),
        "end": xtrack.Marker(),
    }
    line = xtrack.Line(elements=list(elements.values()), element_names=list(elements))
    line.particle_ref = xtrack.Particles(p0c=1e9, mass0=xtrack.PROTON_MASS_EV)
    return line


@pytest.mark.slow
def test_lines_of_xtrack():
    xtrack = pytest.importorskip("xtrack")
    line = _line(xtrack)
    model = fa.mapping(line)
    assert model.symplectic
    particles = line.build_particles(**dict(zip(("x", "y", "px", "py"), STARTS, strict=True)))
    line.track(particles, num_turns=TURNS, turn_by_turn_monitor=True)
    found = fa.integrate(model, STARTS, time=TURNS)
    particles.sort()
    assert (particles.state > 0).all()
    assert found.success
    after = np.array([getattr(particles, row) for row in ("x", "y", "px", "py")])
    np.testing.assert_allclose(found.z, after, atol=1e-10 * np.abs(STARTS).max())
    theirs = line.twiss(method="4d")
    orbit = np.array([theirs[row][0] for row in ("x", "y", "px", "py")])
    phases = np.sort(np.abs(np.angle(np.linalg.eigvals(jacobian(model, orbit)))))[::2] / (2 * np.pi)
    whole = np.array([theirs.qx, theirs.qy])
    np.testing.assert_allclose(phases, np.sort(np.abs(whole - np.rint(whole))), atol=1e-7)


def test_elements_that_change_the_momentum_are_refused_and_solenoids_taken():
    xt = pytest.importorskip("xtrack")
    ends = [xt.Quadrupole(length=0.3, k1=0.4), xt.Multipole(knl=[0, 0, 1.1]), xt.Drift(length=1.3)]
    line = xt.Line([*ends, xt.Cavity(voltage=1e5, frequency=4e8), xt.UniformSolenoid(length=0.8, ks=0.07)])
    line.particle_ref = xt.Particles(p0c=2e9, mass0=xt.ELECTRON_MASS_EV)
    cavity = line.element_names[3]
    with pytest.raises(ValueError, match=rf"changes the momentum.*line\['{cavity}'\].voltage = 0"):
        fa.mapping(line)
    line[cavity].voltage = 0
    start = np.random.default_rng(8).uniform(-1e-4, 1e-4, (4, 6))
    particles = line.build_particles(**dict(zip(("x", "y", "px", "py"), start, strict=True)))
    line.track(particles)
    end = fa.integrate(fa.mapping(line), start, time=1).z
    truth = np.array([getattr(particles, name) for name in ("x", "y", "px", "py")])
    assert np.abs(end - truth).max() < 1e-6 * np.abs(truth).max()


def test_cut_and_misaligned_elements_of_xtrack():
    xt = pytest.importorskip("xtrack")
    rng = np.random.default_rng(31)
    k1, k2, k3, psi = rng.uniform([0.5, 2.0, 50.0, -1.0], [0.9, 4.0, 90.0, 1.0])
    dx, dy = rng.uniform(-2e-3, 2e-3, 2)
    line = xt.Line(
        [
            xt.Quadrupole(length=0.4, k1=k1, shift_y=dy),
            xt.Sextupole(length=0.1, k2=k2, k2s=0.4 * k2),
            xt.Drift(length=0.7),
            xt.Octupole(length=0.1, k3=k3, rot_s_rad=psi, shift_x=dx),
            xt.Multipole(knl=[1e-5, 0.02, 1.3], ksl=[0, 0, 0, 20.0], shift_x=dx, shift_y=dy, rot_s_rad=psi),
        ]
    )
    line.particle_ref = xt.Particles(p0c=1e9)
    line.slice_thick_elements([xt.Strategy(slicing=xt.Teapot(2))])
    start = rng.uniform(-5e-3, 5e-3, (4, 20))
    particles = line.build_particles(**dict(zip(("x", "y", "px", "py"), start, strict=True)))
    line.track(particles, num_turns=3)
    truth = np.array([getattr(particles, name) for name in ("x", "y", "px", "py")])
    assert (particles.state > 0).all()
    np.testing.assert_allclose(fa.integrate(fa.mapping(line), start, time=3).z, truth, atol=1e-10 * np.abs(start).max())
    cavity = xt.Line([xt.Cavity(length=1.0, voltage=1e5, frequency=4e8)], element_names=["rf"])
    cavity.particle_ref = line.particle_ref
    cavity.slice_thick_elements([xt.Strategy(slicing=xt.Teapot(2, mode="thick"))])
    with pytest.raises(ValueError, match=r"changes the momentum.*line\['rf'\].voltage = 0"):
        fa.mapping(cavity)
    line[line.element_names[-1]].rot_x_rad = 0.1
    with pytest.raises(ValueError, match=r"\(Multipole\) has another kick than its strengths say"):
        fa.mapping(line)


def test_kicks_of_pyat_that_are_moved_are_refused():
    at = pytest.importorskip("at")
    ring = at.Lattice([at.Drift("d", 1.0), at.ThinMultipole("mine", [0.0] * 3, [0.0, 0.0, 9.0])], energy=1e9)
    assert fa.mapping(ring).symplectic
    at.shift_elem(ring[1], 1e-3, 0.0)
    with pytest.raises(ValueError, match=r"the element 'mine' \(ThinMultipole\) has another kick than its strengths"):
        fa.mapping(ring)
