"""Lattices of xtrack and PyAT as maps of one turn, against the same particles in these programs."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.exchange.kicks import Kick, turn
from fastaff.exchange.linear_parts import J
from fastaff.systems.models.maps import jacobian

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
    model = fa.iterated_map(turn(parts), coordinates="x y", momenta="px py")

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
    model = fa.iterated_map(ring)
    assert model.symplectic
    found = fa.integrate(model, STARTS, time=TURNS)
    assert found.success
    np.testing.assert_allclose(found.z, _tracked(ring, STARTS), atol=1e-10 * np.abs(STARTS).max())


@pytest.mark.slow
def test_dipoles_of_pyat_are_linear():
    at = pytest.importorskip("at")
    ring = _ring(at, dipoles=True, nonlinear=False)
    model = fa.iterated_map(ring)
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
        fa.iterated_map(thick)
    with pytest.raises(TypeError, match=r"write fa.iterated_map\(lattice\)"):
        fa.frequency_map(thick, STARTS, time=100)
    with pytest.raises(TypeError, match=r"got Lattice of PyAT: ring.track.*fa.integrate\(fa.iterated_map\(ring\)"):
        fa.tunes(thick)
    with pytest.raises(ValueError, match="are x y and px py: leave them out"):
        fa.iterated_map(_ring(at, dipoles=False, nonlinear=True), coordinates="a b")
    rays, off = np.asfortranarray(np.zeros((6, STARTS.shape[1]))), []
    rays[[0, 2, 1, 3]] = STARTS
    end = thick.track(rays.copy(order="F"), nturns=1)[0][[0, 2, 1, 3], :, 0, -1]
    for n in (4, 16):  # as the refusal says: errors fall with n^2
        e = thick[1]
        L, drift = e.Length, at.Drift("d", e.Length / 2 / n)
        cut = [drift, at.ThinMultipole("k", e.PolynomA * L / n, e.PolynomB * L / n), drift] * n
        off.append(
            np.abs(
                fa.integrate(fa.iterated_map(at.Lattice([thick[0], *cut], energy=1e9)), STARTS, time=1).z - end
            ).max()
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
    model = fa.iterated_map(line)
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
        fa.iterated_map(line)
    line[cavity].voltage = 0
    start = np.random.default_rng(8).uniform(-1e-4, 1e-4, (4, 6))
    particles = line.build_particles(**dict(zip(("x", "y", "px", "py"), start, strict=True)))
    line.track(particles)
    end = fa.integrate(fa.iterated_map(line), start, time=1).z
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
    np.testing.assert_allclose(
        fa.integrate(fa.iterated_map(line), start, time=3).z, truth, atol=1e-10 * np.abs(start).max()
    )
    cavity = xt.Line([xt.Cavity(length=1.0, voltage=1e5, frequency=4e8)], element_names=["rf"])
    cavity.particle_ref = line.particle_ref
    cavity.slice_thick_elements([xt.Strategy(slicing=xt.Teapot(2, mode="thick"))])
    with pytest.raises(ValueError, match=r"changes the momentum.*line\['rf'\].voltage = 0"):
        fa.iterated_map(cavity)
    line[line.element_names[-1]].rot_x_rad = 0.1
    with pytest.raises(ValueError, match=r"\(Multipole\) has another kick than its strengths say"):
        fa.iterated_map(line)


def test_kicks_of_pyat_that_are_moved_are_refused():
    at = pytest.importorskip("at")
    ring = at.Lattice([at.Drift("d", 1.0), at.ThinMultipole("mine", [0.0] * 3, [0.0, 0.0, 9.0])], energy=1e9)
    assert fa.iterated_map(ring).symplectic
    at.shift_elem(ring[1], 1e-3, 0.0)
    with pytest.raises(ValueError, match=r"the element 'mine' \(ThinMultipole\) has another kick than its strengths"):
        fa.iterated_map(ring)


def _one(xt, **elements):
    line = xt.Line([xt.Drift(length=0.3), *elements.values()], element_names=["d", *elements])
    line.particle_ref = xt.Particles(p0c=7e9, mass0=xt.PROTON_MASS_EV)
    return line


@pytest.mark.parametrize(
    ("kind", "held", "said"),
    [
        ("Bend", {"length": 0.5, "angle": 0.1, "k2": 2.0}, "k2 is not 0"),
        ("RBend", {"length_straight": 0.5, "angle": 0.1, "k2": 2.0}, "k2 is not 0"),
        (
            "Bend",
            {"length": 0.5, "angle": 0.1, "knl": [0.0, 0, 1, 3], "ksl": [0, 0, 0.5]},
            r"knl\[2\], knl\[3\], ksl\[2\] are not 0",
        ),
        ("UniformSolenoid", {"length": 0.5, "ks": 0.1, "knl": [0.0, 0, 1]}, r"knl\[2\] is not 0"),
        ("Quadrupole", {"length": 0.5, "k1": 0.1, "knl": [0.0, 0, 1]}, "neither linear nor a thin multipole"),
    ],
)
def test_multipoles_beyond_the_linear_part_are_refused_by_name(kind, held, said):
    xt = pytest.importorskip("xtrack")
    line = _one(xt, mine=getattr(xt, kind)(**held))
    with pytest.raises(ValueError, match=rf"the element 'mine' \({kind}\).*{said}.*line.slice_thick_elements\("):
        fa.iterated_map(line)


def test_cut_bends_with_multipoles_are_kicks():
    """Against tracking; beside a gradient the curvature has kicks of second order, of size k1 l h x^2, left out."""
    xt = pytest.importorskip("xtrack")
    rng = np.random.default_rng(53)
    k1, k2, knl3, ksl2, angle = rng.uniform([0.2, 2, 20, 0.5, 0.05], [0.4, 4, 40, 1.0, 0.1])
    start = rng.uniform(-1e-3, 1e-3, (4, 20))
    off = []
    for gradient in (0.0, k1):
        bend = xt.Bend(
            length=0.5, angle=angle, k0_from_h=True, k1=gradient, k2=k2, knl=[0, 0, 0, knl3], ksl=[0, 0, ksl2]
        )
        line = _one(xt, b=bend)
        line.slice_thick_elements([xt.Strategy(slicing=xt.Teapot(3))])
        particles = line.build_particles(**dict(zip(("x", "y", "px", "py"), start, strict=True)))
        line.track(particles)
        truth = np.array([getattr(particles, name) for name in ("x", "y", "px", "py")])
        off.append(np.abs(fa.integrate(fa.iterated_map(line), start, time=1).z - truth).max())
    assert off[0] < 1e-12 * np.abs(start).max()
    assert off[1] < k1 * angle * (2 * np.abs(start).max()) ** 2  # amplitudes within the bend are up to twice these


def test_elements_that_depend_on_the_arrival_are_refused_by_name():
    xt = pytest.importorskip("xtrack")
    line = _one(xt, crab=xt.CrabCavity(crab_voltage=1e6, frequency=4e8))
    with pytest.raises(
        ValueError, match=r"'crab' \(CrabCavity\) changes the momentum.*line\['crab'\].crab_voltage = 0"
    ):
        fa.iterated_map(line)
    line["crab"].crab_voltage = 0
    assert fa.iterated_map(line).symplectic
    with pytest.raises(ValueError, match=r"'fast' \(RFMultipole\) changes the momentum.*line.remove\('fast'\)"):
        fa.iterated_map(_one(xt, fast=xt.RFMultipole(knl=[0, 0.1], frequency=4e8)))


def test_apertures_are_told():
    xt, at = pytest.importorskip("xtrack"), pytest.importorskip("at")
    small = [-1e-4, 1e-4, -1e-4, 1e-4]
    line = _one(xt, wide=xt.LimitEllipse(a=0.1, b=0.1), rect=xt.LimitRect(min_x=-1e-4, max_x=1e-4, min_y=-1, max_y=1))
    ring = at.Lattice([at.Drift("d", 0.3), at.Aperture("wide", small), at.Collimator("rect", 0.1, small)], energy=1e9)
    for lattice, length in ((line, 0.3), (ring, 0.4)):
        with pytest.warns(UserWarning, match=r"leaves out apertures \('wide', 'rect'\): no orbit is lost") as told:
            model = fa.iterated_map(lattice)
        assert told[0].filename == __file__
        np.testing.assert_allclose(jacobian(model, np.zeros((4, 1)))[:2, 2:, 0], length * np.eye(2), rtol=1e-9)
    assert all(hasattr(element, name) for element, name in zip(ring[1:], ("Limits", "RApertures"), strict=True))


def test_dipoles_of_pyat_with_multipoles_are_refused_and_cut():
    at = pytest.importorskip("at")
    rng = np.random.default_rng(71)
    gradient, k2, edge = rng.uniform([0.1, 20.0, 0.0], [0.4, 40.0, 0.1])
    start = rng.uniform(-1e-3, 1e-3, (4, 20))
    rays = np.zeros((6, 20), order="F")
    rays[[0, 2, 1, 3]] = start
    thick = at.Dipole("mine", 0.5, 0.1, PolynomB=[0, gradient, k2], EntranceAngle=edge, ExitAngle=edge)
    ring = at.Lattice([thick], energy=1e9)
    end, off = ring.track(rays, nturns=1)[0][[0, 2, 1, 3], :, 0, -1], []
    with pytest.raises(ValueError, match=r"'mine' \(Dipole\).*PolynomB\[2\] is not 0: A, B = .*e.divide\("):
        fa.iterated_map(ring)
    for n in (2, 8):  # as the refusal says: errors fall with n^2
        e = thick.deepcopy()
        A, B, L = e.PolynomA.copy(), e.PolynomB.copy(), e.Length
        A[:2] = B[:2] = 0
        e.PolynomA[2:] = e.PolynomB[2:] = 0
        parts, kick = e.divide([0.5 / n] * 2 * n), at.ThinMultipole("k", A * L / n, B * L / n)
        cut = [p for first, last in zip(parts[::2], parts[1::2], strict=True) for p in (first, kick, last)]
        found = fa.integrate(fa.iterated_map(at.Lattice(cut, energy=1e9)), start, time=1).z
        off.append(np.abs(found - end).max())
    assert 12 < off[0] / off[1] < 20
