"""Molecules as bodies: sums over atoms and pairs, differences, full Hessians, minimisation over all atoms, rigid
rotors.
"""

import mpmath
import numpy as np
import pytest
from scipy.optimize import minimize

import fastaff as fa
from fastaff.systems.charts import from_matrix
from fastaff.systems.kinematics import kinetic_energy
from fastaff.systems.molecules.pair_sums import AveragedPairs, NoPairs

RNG = np.random.default_rng(31)
PAIRS = (
    fa.molecules.HarmonicBond(1.7, 0.9),
    fa.molecules.MorseBond(0.8, 1.3, 1.2),
    fa.molecules.LennardJones(0.3, 1.1),
)


def drawn(dimensions=2, atoms=5):
    """A molecule without symmetry, with several potentials, not all pairs."""
    positions = RNG.normal(size=(dimensions, atoms)) * 1.5
    every = [(i, j) for i in range(atoms) for j in range(i)]
    bonds = {key: PAIRS[k % 3] for k, key in enumerate(every[1:])}
    return fa.molecules.molecule(RNG.uniform(0.5, 2, atoms), positions, bonds)


def strong(atoms, height=0.0, radius=1.0):
    """A stable ring with neighbours of two orders, strained in different ways."""
    near = 2 * radius * np.sin(np.pi / atoms)
    far = 2 * radius * np.sin(2 * np.pi / atoms)
    first = fa.molecules.MorseBond(RNG.uniform(4, 6), RNG.uniform(0.8, 1.1), 1.03 * np.hypot(near, 2 * height))
    second = fa.molecules.HarmonicBond(RNG.uniform(1, 2), 0.98 * far)
    return fa.molecules.ring(
        atoms, mass=RNG.uniform(1, 2), radius=radius, pairs=[first, second][: atoms // 2], height=height
    )


def planes(phi):
    """The rows a1, a2, b1, b2 of matrices."""
    return from_matrix(phi, np.zeros_like(phi))[:4]


def deformed(molecule, phi):
    """Positions of the atoms under phi, by hand."""
    out = molecule.positions.copy()
    out[:2] = phi @ molecule.positions[:2]
    return out


def total(molecule, positions):
    """Energy by a plain sum over pairs."""
    return sum(pair.value(np.linalg.norm(positions[:, i] - positions[:, j])) for i, j, pair in molecule.pairs)


# --- pair potentials ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pair", PAIRS)
def test_derivatives_of_pair_potentials(pair):
    distance = RNG.uniform(0.7, 2.0, 20)
    step = 1e-100j
    np.testing.assert_allclose(pair.slope(distance), pair.value(distance + step).imag / 1e-100, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(
        pair.curvature(distance), pair.slope(distance + step).imag / 1e-100, rtol=1e-12, atol=1e-12
    )
    least = fa.molecules.LennardJones(2.0, 1.3), fa.molecules.MorseBond(2.0, 1.7, 1.3)
    assert [float(one.slope(1.3)) for one in least] == [0.0, 0.0]
    assert least[1].curvature(1.3) == pytest.approx(2 * 2.0 * 1.7**2)


# --- inertia ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("atoms", [3, 4, 5, 8, 13])
def test_inertia_of_a_ring_is_isotropic(atoms):
    mass, radius = RNG.uniform(0.5, 3, 2)
    made = fa.molecules.ring(atoms, mass=mass, radius=radius, pairs=PAIRS[0])
    np.testing.assert_allclose(made.inertia.moments, atoms * mass * radius**2 / 2 * np.eye(2), rtol=1e-13, atol=1e-13)
    assert made.body.mu == pytest.approx(atoms * mass * radius**2 / 2, rel=1e-13)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_kinetic_energy_is_the_sum_over_atoms(dimensions):
    """Of the body in its principal frame: T by moments, by atoms, and by the exact body's momenta."""
    made = drawn(dimensions)
    rate = RNG.normal(size=(2, 2))
    by_atoms = np.sum(made.masses * np.sum((rate @ made.positions[:2]) ** 2, axis=0)) / 2
    assert kinetic_energy(rate, made.inertia.moments) == pytest.approx(by_atoms, rel=1e-13)
    mu_1, mu_2, axes = made.principal
    momenta = (rate @ axes.T) * [mu_1, mu_2]  # phi x = (phi axes^T)(axes x)
    rows = from_matrix(np.eye(2), momenta)[4:]
    assert made.exact_body.kinetic_energy(*rows) == pytest.approx(by_atoms, rel=1e-13)
    np.testing.assert_allclose(made.positions @ made.masses, 0, atol=1e-14 * made.masses.sum())


# --- energies -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimensions", [2, 3])
def test_exact_body_is_the_sum_over_pairs(dimensions):
    """V, its gradient by differences and its Hessian, at random phi."""
    made = drawn(dimensions)
    body, axes = made.exact_body, made.principal[2]
    for _ in range(4):
        phi = np.eye(2) + 0.4 * RNG.normal(size=(2, 2))
        q = planes(phi @ axes.T)
        assert body.potential_energy(*q) == pytest.approx(total(made, deformed(made, phi)), rel=1e-13)
        step = 1e-5 * np.eye(4)
        force = [-(body.potential_energy(*(q + h)) - body.potential_energy(*(q - h))) / 2e-5 for h in step]
        np.testing.assert_allclose(body.force(*q), force, rtol=0, atol=1e-7 * np.abs(force).max())
        hessian = [(np.array(body.force(*(q + h))) - body.force(*(q - h))) / 2e-5 for h in step]
        found = [body.tangent_force(*q, *unit) for unit in np.eye(4)]
        np.testing.assert_allclose(found, hessian, rtol=0, atol=1e-7 * np.abs(hessian).max())


@pytest.mark.parametrize("height", [0.0, 0.2])
def test_averaged_body_is_the_mean_over_material_orientations(height):
    """The mean of the sum over pairs with the material turned, by 720 orientations; slopes by differences."""
    made = strong(6, height, radius=1.2)
    potential = made.body.potential
    for spread in (0.02, 0.1, 0.25):
        phi = np.diag([1.1 + spread, 1.1 - spread]) @ np.array(
            [[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]]
        )
        angles = 2 * np.pi * np.arange(720) / 720
        mean = np.mean(
            [
                total(made, deformed(made, phi @ np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])))
                for t in angles
            ]
        )
        a1, a2, b1, b2 = planes(phi)
        A, B = a1**2 + a2**2, b1**2 + b2**2
        assert potential.value(A, B) == pytest.approx(mean, rel=0, abs=1e-9 * abs(mean) + 1e-12)


def test_derivatives_of_the_averaged_potential():
    """By differences of high precision on both sides of the place where quotients are extrapolated, and at beta = 0."""
    chain = AveragedPairs(
        PAIRS[1], (1.1, 1.9), (0.0, 0.2), (4.0, 2.0), AveragedPairs(PAIRS[2], (1.3,), (0.1,), (3.0,), NoPairs())
    )
    A, h = 2.3, 1e-4

    def difference(function, x):
        return (8 * (function(x + h) - function(x - h)) - (function(x + 2 * h) - function(x - 2 * h))) / (12 * h)

    for B in (0.3, 0.05, 0.003):
        V_A, V_B = chain.slopes(A, B)
        V_AA, V_AB, V_BB = chain.curvatures(A, B)
        assert pytest.approx(difference(lambda x, B=B: chain.value(x, B), A), rel=1e-8) == V_A
        assert pytest.approx(difference(lambda x: chain.value(A, x), B), rel=1e-8) == V_B
        assert pytest.approx(difference(lambda x, B=B: chain.slopes(x, B)[0], A), rel=1e-8) == V_AA
        assert pytest.approx(difference(lambda x, B=B: chain.slopes(x, B)[1], A), rel=1e-8) == V_AB
        assert pytest.approx(difference(lambda x: chain.slopes(A, x)[1], B), rel=1e-8) == V_BB


def test_derivatives_of_the_averaged_potential_near_beta_zero():
    """By derivatives of its sum over directions at 40 digits, on both sides of the place where quotients are
    extrapolated.
    """
    D, a, length = PAIRS[1]
    chain = AveragedPairs(PAIRS[1], (1.1,), (0.2,), (4.0,), NoPairs())
    A = 2.3
    with mpmath.workdps(40):

        def value(A, B):
            cosines = [mpmath.cos(mpmath.pi * (2 * j + 1) / 16) for j in range(8)]  # at the digits of the derivative
            squares = [mpmath.mpf(1.1) ** 2 * ((A + B) / 2 + c * mpmath.sqrt(A * B)) for c in cosines]
            distances = [mpmath.sqrt(square + mpmath.mpf(0.2) ** 2) for square in squares]
            return mpmath.re(mpmath.fsum(D * (1 - mpmath.exp(-a * (d - length))) ** 2 for d in distances)) / 2

        for B in (0.0, 1e-14, 1e-9, 1e-7, 1e-6, 3e-6, 1e-5, 1e-3):
            at = (mpmath.mpf(A), mpmath.mpf(B))
            slopes = [float(mpmath.diff(value, at, order)) for order in ((1, 0), (0, 1))]
            curvatures = [float(mpmath.diff(value, at, order)) for order in ((2, 0), (1, 1), (0, 2))]
            assert chain.value(A, B) == pytest.approx(float(value(*at)), rel=1e-14)
            np.testing.assert_allclose(chain.slopes(A, B), slopes, rtol=2e-11)
            np.testing.assert_allclose(chain.curvatures(A, B)[0], curvatures[0], rtol=1e-10)
            np.testing.assert_allclose(chain.curvatures(A, B)[1], curvatures[1], rtol=1e-9)
            np.testing.assert_allclose(chain.curvatures(A, B)[2], curvatures[2], rtol=1e-4)


@pytest.mark.parametrize(("atoms", "order"), [(3, 3), (4, 2), (5, 5), (6, 3), (7, 7), (8, 4), (12, 6)])
def test_anisotropy_of_a_ring_begins_at_its_order(atoms, order):
    """Exact less averaged energy falls as beta^order, and turns as cos(2 order psi)."""
    made = strong(atoms)
    assert made.anisotropy_order == order
    angles = np.linspace(0, np.pi / order, 24, endpoint=False)

    def anisotropic(spread):
        stretch = np.diag([1 + spread, 1 - spread])
        return np.array(
            [
                total(made, deformed(made, stretch @ np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])))
                for t in angles
            ]
        )

    sizes = []
    for spread in (0.1, 0.2):
        values = anisotropic(spread)
        part = 2 * np.abs(np.mean(values * np.exp(2j * order * angles)))
        rest = (
            values
            - np.mean(values)
            - np.real(2 * np.mean(values * np.exp(2j * order * angles)) * np.exp(-2j * order * angles))
        )
        assert np.abs(rest).max() < 0.2 * part + 1e-12
        sizes.append(part)
    if sizes[0] > 1e-11:
        assert np.log2(sizes[1] / sizes[0]) == pytest.approx(order, abs=0.35)


def test_squared_distances_make_an_isotropic_body():
    """(l^2 - L^2)^2 is a polynomial of Green's tensor of degree 2: exact for every ring of anisotropy order above 2."""
    pair = fa.univariate(lambda d: (d**2 - 1.3) ** 2, lambda d: 4 * d * (d**2 - 1.3), lambda d: 12 * d**2 - 5.2)
    made = fa.molecules.ring(8, radius=1.1, pairs=pair)
    for _ in range(5):
        phi = np.eye(2) + 0.5 * RNG.normal(size=(2, 2))
        a1, a2, b1, b2 = planes(phi)
        exact = total(made, deformed(made, phi))
        assert made.body.potential.value(a1**2 + a2**2, b1**2 + b2**2) == pytest.approx(exact, rel=1e-13)
        green = phi.T @ phi
        square = (2 * 1.1 * np.sin(np.pi / 8)) ** 2
        trace = np.trace(green)
        mean_square = (trace**2 + 2 * np.sum(green**2)) / 8  # of (d . G d)^2 over directions
        by_hand = 8 * (square**2 * mean_square - 1.3 * square * trace + 1.3**2)
        assert exact == pytest.approx(by_hand, rel=1e-12)


# --- equilibrium and vibrations -----------------------------------------------------------------------------------


@pytest.mark.parametrize("atoms", [3, 5, 6, 8])
def test_equilibrium_of_a_ring_is_that_of_all_atoms(atoms):
    """Minimisation over all atoms by another method, from perturbed positions."""
    made = strong(atoms)
    rest = made.equilibrium()
    start = made.positions + 0.02 * RNG.normal(size=made.positions.shape)
    free = minimize(lambda x: total(made, x.reshape(2, -1)), start.ravel(), method="BFGS", options={"gtol": 1e-9})
    radius = np.linalg.norm(free.x.reshape(2, -1) - free.x.reshape(2, -1).mean(axis=1)[:, None], axis=0)
    np.testing.assert_allclose(radius, rest.phi[0, 0], rtol=1e-5)
    assert rest.energy == pytest.approx(free.fun, rel=1e-9)
    np.testing.assert_allclose(rest.phi, rest.phi[0, 0] * np.eye(2), atol=1e-10)
    assert rest.residual < 1e-10
    A = 2 * rest.phi[0, 0] ** 2
    assert abs(made.body.potential.slopes(A, 0.0)[0]) < 1e-10  # dilatation
    relaxed = made.relaxed()
    assert np.abs(relaxed.gradient(relaxed.positions)).max() < 1e-9


def test_equilibrium_of_any_molecule_is_the_least_homogeneous_energy():
    made = fa.molecules.molecule(
        [1.0, 2.0, 1.5, 0.7],
        [[0, 1.1, 1.0, -0.1], [0, 0.1, 0.9, 1.2]],
        {(i, j): fa.molecules.HarmonicBond(1 + i + j, 1.0 + 0.1 * j) for i in range(4) for j in range(i + 1, 4)},
    )
    rest = made.equilibrium()
    free = minimize(
        lambda c: total(made, deformed(made, c.reshape(2, 2))), np.eye(2).ravel(), method="BFGS", options={"gtol": 1e-9}
    )
    assert rest.energy == pytest.approx(free.fun, rel=1e-9)
    np.testing.assert_allclose(rest.phi, rest.phi.T, atol=1e-12)
    relaxed = made.relaxed()
    assert relaxed.energy(relaxed.positions) < rest.energy
    assert rest.residual > 1e-3  # the atoms are not at rest


@pytest.mark.parametrize(("atoms", "height"), [(3, 0.0), (5, 0.0), (6, 0.0), (8, 0.15)])
def test_vibrations_are_the_projected_hessian_of_all_atoms(atoms, height):
    """Of both bodies, by their kernels' derivatives, beside the mass-weighted 4 x 4 problem of the full Hessian."""
    made = strong(atoms, height)
    rest, found = made.equilibrium(), made.vibrations()
    weights = np.sqrt(np.tile(made.masses, len(made.positions)))
    basis = np.zeros((made.positions.size, 4))
    for k in range(4):
        unit = np.zeros((2, 2))
        unit[divmod(k, 2)] = 1
        moved = np.zeros_like(made.positions)
        moved[:2] = unit @ made.positions[:2]
        basis[:, k] = weights * moved.ravel()
    basis /= np.sqrt(made.body.mu)  # orthonormal for a ring
    projected = basis.T @ (made.hessian(rest.positions) / np.outer(weights, weights)) @ basis
    squares = np.linalg.eigvalsh(projected)
    np.testing.assert_allclose(found.omega**2, squares, rtol=0, atol=1e-10 * squares[-1])
    q = planes(rest.phi)
    for body in (made.exact_body, made.body):
        mu = body.mu if isinstance(body, fa.Body) else body.mu_1
        kernel = -np.array([body.tangent_force(*q, *unit) for unit in np.eye(4)]) / mu
        np.testing.assert_allclose(np.linalg.eigvalsh(kernel), squares, rtol=0, atol=2e-8 * squares[-1])
    assert found.omega[1] == pytest.approx(found.omega[2], rel=1e-9)  # shears
    norms = np.einsum("ijm,ikm,jk->m", found.modes, found.modes, made.inertia.moments)
    np.testing.assert_allclose(norms, 1, rtol=1e-12)


@pytest.mark.parametrize("atoms", [3, 4, 5, 6, 8, 11])
def test_normal_modes_beside_homogeneous_ones(atoms):
    """Breathing is exact; shears are for 3 atoms, else no slower than the mode that they resemble most."""
    made = strong(atoms)
    modes, body = made.normal_modes(), made.vibrations()
    assert modes.overlap.sum() == pytest.approx(4)
    breathing = np.argmin(np.abs(modes.omega - body.omega[3]))
    assert modes.omega[breathing] == pytest.approx(body.omega[3], rel=1e-9)
    exact = np.abs(modes.omega - body.omega[3]) < 1e-7 * body.omega[3]
    assert modes.overlap[exact].sum() == pytest.approx(1, abs=1e-6) or atoms == 3
    kinetic = np.einsum("p,ipm,ipm->m", made.masses, modes.displacements, modes.displacements)
    np.testing.assert_allclose(kinetic, 1, rtol=1e-12)
    # Rayleigh: the mean of omega^2 over modes, weighted by their share of a homogeneous mode, is that mode's omega^2.
    assert np.sum(modes.overlap * modes.omega**2) == pytest.approx(np.sum(body.omega**2), rel=1e-9)
    if atoms == 3:
        np.testing.assert_allclose(modes.omega[3:], body.omega[1:], rtol=1e-9)


def test_modes_of_an_irregular_molecule_are_no_slower_than_the_atoms_allow():
    """Interlacing of Rayleigh and Ritz, with the relaxed molecule."""
    made = fa.molecules.molecule(
        RNG.uniform(1, 2, 6),
        np.array([np.cos(np.arange(6)), np.sin(np.arange(6))]) * RNG.uniform(0.8, 1.2, 6),
        {
            (i, j): fa.molecules.HarmonicBond(RNG.uniform(1, 2), RNG.uniform(0.8, 1.4))
            for i in range(6)
            for j in range(i)
        },
    ).relaxed()
    full, body = made.normal_modes().omega, made.vibrations().omega
    assert (full[:4] <= body + 1e-6).all()
    assert (body <= full[-4:] + 1e-6).all()
    np.testing.assert_allclose(full[:3], 0, atol=1e-5)
    assert (full[3:] > 0.01).all()


def test_shears_of_a_square_are_modes_of_its_atoms():
    """Both shears have a symmetry of their own among the vibrations of a square; those of a pentagon share theirs."""
    k, far = RNG.uniform(0.5, 2, (2, 2))
    square = fa.molecules.ring(4, pairs=[fa.molecules.HarmonicBond(*k), fa.molecules.HarmonicBond(*far)])
    modes = square.normal_modes()
    np.testing.assert_allclose(modes.omega[modes.overlap > 0.5], square.vibrations().omega, atol=1e-7)
    np.testing.assert_allclose(modes.overlap[modes.overlap > 0.5], 1, rtol=1e-12)


# --- motion and levels --------------------------------------------------------------------------------------------


def test_orbits_conserve_energy_and_spin():
    made = strong(6)
    z0 = np.array([1.45, 0.0, 0.1, 0.05, 0.1, 0.8, 0.3, 0.2])
    for body, conserved in ((made.body, ("p_phi", "p_psi")), (made.exact_body, ("p_phi",))):
        end = fa.integrate(body, z0, time=30.0, accuracy=1e-9)
        assert end.status[0] == fa.Status.OK
        assert end.energy_error[0] < 1e-9
        before, after = (fa.charts.angular_momenta(z) for z in (z0, end.z[:, 0]))
        for name in conserved:
            assert getattr(after, name) == pytest.approx(getattr(before, name), abs=1e-9)
    constants = fa.constants_of_motion(body, end.z)
    assert constants["p_phi"][0] == pytest.approx(after.p_phi, rel=1e-13)
    assert constants["energy"][0] == pytest.approx(fa.constants_of_motion(body, z0)["energy"], rel=1e-9)


def test_files_keep_the_bodies_of_molecules(tmp_path):
    made = strong(6)
    z0 = [1.45, 0.0, 0.1, 0.05, 0.1, 0.8, 0.3, 0.2]
    for body in (made.body, made.exact_body):
        end = fa.integrate(body, z0, time=1.0, accuracy=1e-9)
        path = tmp_path / f"{type(body).__name__}.npz"
        fa.save(path, end)
        recipe = fa.files.recipe(path)
        assert recipe.arguments["model"] == body
        assert recipe.run().z.tobytes() == end.z.tobytes()
        job = fa.Job(model=body, initial_conditions=np.array(z0)[:, None], integrate=fa.jobs.IntegrateOptions(time=1.0))
        assert type(body).__name__ in job.text()


def test_small_orbits_oscillate_with_the_frequencies_of_the_vibrations():
    made = strong(8)
    rest, omega = made.equilibrium(), made.vibrations().omega
    plane = fa.reduced_body(made.body, p_eta=0.0, p_gamma=0.0)
    amplitude = 1e-3
    start = [np.sqrt(2) * rest.phi[0, 0] + amplitude, amplitude, 0.0, 0.0]
    small = fa.frequency_map(plane, np.array(start)[:, None], time=300.0)
    np.testing.assert_allclose(small.omega[:, 0], omega[[3, 1]], rtol=1e-5)


def test_levels_of_a_stiff_ring_are_those_of_a_rigid_rotor():
    """Gaps m^2 hbar^2/(2 I), I = 2 mu s^2, up to hbar/sqrt(k mu); one quantum of the shear; half a quantum of each."""
    bonds = [fa.molecules.HarmonicBond(80.0, 1.0), fa.molecules.HarmonicBond(80.0, 3**0.5)]
    made = fa.molecules.ring(6, radius=1.0, pairs=bonds)
    omega, hbar = made.vibrations().omega, 0.3
    still, turning, sheared = (
        fa.quantum.spectrum(made.body, m=m, l=l, count=1, hbar=hbar, tolerance=1e-5).E[0]
        for m, l in ((0, 0), (2, -2), (1, 1))
    )
    rotor = 2**2 * hbar**2 / (2 * 2 * made.body.mu * made.equilibrium().phi[0, 0] ** 2)
    assert turning - still == pytest.approx(rotor, rel=0.01)
    assert still == pytest.approx(hbar * omega.sum() / 2, rel=0.02)
    assert sheared - still == pytest.approx(hbar * omega[1], rel=0.03)


# --- wrong input --------------------------------------------------------------------------------------------------

SQUARE = [[0, 1, 1, 0], [0, 0, 1, 1]]
BONDS = {(0, 1): PAIRS[0], (1, 2): PAIRS[0]}


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({"masses": [1, 1, 0, 1]}, ValueError, "masses must be positive"),
        ({"masses": [1, 1, -2, 1]}, ValueError, "masses must be positive"),
        ({"masses": [1, 1]}, ValueError, "masses must be those of at least three atoms"),
        ({"masses": "many"}, TypeError, "masses must be finite real numbers"),
        ({"positions": np.ones((4, 4))}, ValueError, r"positions must have shape \(2, 4\) or \(3, 4\)"),
        ({"positions": np.ones((2, 3))}, ValueError, "positions must have shape"),
        ({"positions": [[0, 1, np.nan, 0], [0, 0, 1, 1]]}, ValueError, "positions must be finite"),
        ({"positions": [[0, 1, 2, 3], [0, 2, 4, 6]]}, ValueError, "positions must not be on one line"),
        ({"positions": [[0, 1, 2, 3], [0, 0, 0, 0], [0, 1, 0, 1]]}, ValueError, "positions must not be on one line"),
        ({"positions": [[0, 0, 1, 0], [0, 0, 1, 1]]}, ValueError, "positions must differ for the atoms of a pair"),
        ({"pairs": [PAIRS[0]]}, TypeError, "pairs must be potentials by pairs of atoms"),
        ({"pairs": {}}, ValueError, "pairs must have at least one entry"),
        ({"pairs": {(0, 4): PAIRS[0]}}, ValueError, "atoms of pairs must be at most 3, got 4"),
        ({"pairs": {(1, 1): PAIRS[0]}}, ValueError, "two different atoms once"),
        ({"pairs": {(0, 1): PAIRS[0], (1, 0): PAIRS[0]}}, ValueError, "two different atoms once"),
        ({"pairs": {0: PAIRS[0]}}, TypeError, "keys of two atoms"),
        ({"pairs": {(0, 1): 2.0}}, TypeError, r"pairs\[0, 1\] must be a NamedTuple with the methods"),
        ({"pairs": {(0, 1): fa.molecules.MorseBond}}, TypeError, r"pairs\[0, 1\] must be a NamedTuple"),
    ],
)
def test_wrong_molecules_are_refused(given, kind, words):
    with pytest.raises(kind, match=words) as refused:
        fa.molecules.molecule(**{"masses": np.ones(4), "positions": SQUARE, "pairs": BONDS, **given})
    assert len(str(refused.value)) <= 160


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({"atoms": 2}, ValueError, "atoms must be at least 3"),
        ({"atoms": 5.5}, TypeError, "atoms must be a whole number"),
        ({"mass": 0.0}, ValueError, "mass must be positive"),
        ({"radius": -1.0}, ValueError, "radius must be positive"),
        ({"pairs": [PAIRS[0]] * 4}, ValueError, "pairs must have 1 to 2 orders of neighbours"),
        ({"pairs": []}, ValueError, "pairs must have 1 to 2 orders"),
        ({"pairs": "morse"}, TypeError, "pairs must be a pair potential or a sequence"),
        ({"pairs": [None]}, ValueError, "pairs must have at least one entry"),
        ({"height": 0.1}, ValueError, "height must be 0 for an odd number of atoms"),
    ],
)
def test_wrong_rings_are_refused(given, kind, words):
    with pytest.raises(kind, match=words):
        fa.molecules.ring(**{"atoms": 5, "pairs": PAIRS[0], **given})


def test_molecules_without_what_is_asked_for_are_refused():
    uneven = fa.molecules.molecule(np.ones(4), [[0, 2, 2, 0], [0, 0, 1, 1]], BONDS)
    with pytest.raises(ValueError, match=r"must have equal principal moments, got 4 and 1\. Try exact_body"):
        _ = uneven.body
    spring = fa.molecules.HarmonicBond(1.0, 0.5)
    with pytest.raises(ValueError, match="molecule must have an equilibrium with det phi > 0"):
        fa.molecules.ring(6, height=10.0, pairs=spring).equilibrium()
    with pytest.raises(ValueError, match="got no finite forces or no stiffness"):
        fa.molecules.ring(6, pairs=spring._replace(k=0.0)).equilibrium()
    apart = fa.univariate(lambda d: 1 / d, lambda d: -1 / d**2, lambda d: 2 / d**3)
    with pytest.raises(ValueError, match="molecule must have an equilibrium"):
        fa.molecules.ring(5, pairs=apart).equilibrium()
    together = fa.univariate(lambda d: -1 / d, lambda d: 1 / d**2, lambda d: -2 / d**3)
    for find in (fa.molecules.Molecule.equilibrium, fa.molecules.Molecule.relaxed):
        with pytest.raises(ValueError, match="molecule must have an equilibrium near its positions"):
            find(fa.molecules.ring(5, pairs=together))
    with pytest.raises(ValueError, match="positions must be finite real numbers"):
        uneven.energy(np.ones((2, 3)))


def test_repr_of_many_atoms_is_one_line():
    ring = fa.molecules.ring(1000, mass=0.5, pairs=[fa.molecules.HarmonicBond(), fa.molecules.LennardJones()])
    assert repr(ring) == "<Molecule of 1000 atoms, mass 500: 1000 HarmonicBond, 1000 LennardJones>"
