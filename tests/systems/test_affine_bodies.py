"""The body in its two-polar chart beside the Cartesian one, and affinely invariant kinetic energies, in closed form."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

import fastaff as fa
from fastaff import Classification
from fastaff.core.status import Status

RNG = np.random.default_rng(67)
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


# --- two-polar chart --------------------------------------------------------------------------------------------------


def pairs(count):
    """Phase points of EQ2.2h in the planes, away from D1 = D2, and in the two-polar chart."""
    z = np.array([RNG.uniform(1.5, 1.8, count), 0 * np.zeros(count), RNG.uniform(0.4, 0.7, count), np.zeros(count)])
    z = np.concatenate([z, RNG.uniform(-0.15, 0.15, (4, count))])
    z[5], z[7] = RNG.uniform(0.2, 0.5, count), RNG.uniform(0.25, 0.5, count)
    return z, fa.charts.TWO_POLAR.from_planes(z)


def test_the_two_polar_chart_has_the_orbits_of_the_planes():
    mu, C = RNG.uniform(0.5, 2), RNG.uniform(0.5, 2)
    body, chart = fa.Body(fa.Hyperelastic(C), mu), fa.models.TwoPolarBody(inertia=mu, C=C)
    z, w = pairs(6)
    np.testing.assert_allclose(
        chart.energy(*w), body.kinetic_energy(*z[4:]) + body.potential_energy(*z[:4]), rtol=1e-13
    )
    one, two = (fa.integrate(model, at, time=12.0, accuracy=1e-11) for model, at in ((body, z), (chart, w)))
    assert (two.status == Status.OK).all()
    back = fa.charts.TWO_POLAR.to_planes(two.z)
    np.testing.assert_allclose(back, one.z, rtol=0, atol=1e-8)
    before, after = (fa.constants_of_motion(chart, at) for at in (w, two.z))
    there = fa.constants_of_motion(body, z)
    for name in ("p_phi", "p_psi"):
        np.testing.assert_allclose(before[name], there[name], atol=1e-13)
        np.testing.assert_allclose(after[name], there[name], atol=1e-11)


LAWS = {
    "EQ2.2h": ("C/2*(D1**2 + D2**2) + C/(D1*D2)", {"C": (0.5, 2.0)}, lambda C: fa.Hyperelastic(C)),
    "neo-hooke": (
        "G/2*(D1**2 + D2**2 - 2) - G*log(D1*D2) + K/2*(D1*D2 - 1)**2",
        {"G": (0.7, 1.3), "K": (1.0, 3.0)},
        lambda G, K: fa.NeoHookean(G, K),
    ),
    "hencky": (
        "G*(log(D1)**2 + log(D2)**2) + lam/2*log(D1*D2)**2",
        {"G": (0.6, 1.0), "lam": (0.8, 1.5)},
        lambda **k: fa.affine_body("hencky", **k).potential,
    ),
    "kirchhoff": (
        "lam/8*(D1**2 + D2**2 - 2)**2 + G/4*((D1**2 - 1)**2 + (D2**2 - 1)**2)",
        {"G": (0.6, 1.0), "lam": (0.8, 1.5)},
        lambda **k: fa.affine_body("saint-venant-kirchhoff", **k).potential,
    ),
}
"""V in the stretches, bounds of its parameters, and the potential of the planes; the last one has chaotic orbits."""
COMBINATIONS = [(k, l) for k in range(-2, 3) for l in range(-2, 3)]


def same_lattice(one, two, errors):
    """Whether two pairs of frequencies are integer combinations of each other."""
    return all(
        any(abs(k * b[0] + l * b[1] - c) <= 3 * errors for k, l in COMBINATIONS)
        for c, b in ((one[0], two), (one[1], two), (two[0], one), (two[1], one))
    )


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_the_two_polar_chart_has_the_orbits_frequencies_and_classifications_of_the_planes(law):
    """Spin and vorticity turn at the same rates; those of D1, D2 are combinations of those of the planes' angles."""
    text, bounds, potential = LAWS[law]
    k, mu = {name: float(RNG.uniform(*b)) for name, b in bounds.items()}, float(RNG.uniform(0.5, 2.0))
    body, chart = fa.Body(potential(**k), mu), fa.models.TwoPolarBody(text, inertia=mu, **k)
    z, w = pairs(8)
    one, two = (fa.integrate(m, at, time=20.0, accuracy=1e-10) for m, at in ((body, z), (chart, w)))
    assert (two.status == Status.OK).all()
    off = np.abs(fa.charts.TWO_POLAR.to_planes(two.z) - one.z).max(axis=0)
    assert (off <= 3 * (one.error + two.error).max(axis=0)).all(), (off, one.error, two.error)

    one, two = (fa.frequency_map(m, at, time=500.0) for m, at in ((body, z), (chart, w)))
    assert two.names == ("D1", "D2", "phi", "psi")
    errors = one.error + two.error
    assert (np.abs(two.nu[2:] - one.nu[2:]) <= 3 * errors[2:]).all()
    sharp = (one.classification == two.classification) & (one.classification == Classification.REGULAR)
    for i in np.flatnonzero(sharp):
        assert same_lattice(one.nu[:2, i], two.nu[:2, i], errors[:2, i].max()), (one.nu[:, i], two.nu[:, i])

    one, two = (fa.chaos_map(m, at, time=1000.0, indicators=("megno", "sali")) for m, at in ((body, z), (chart, w)))
    decided = (one.classification != Classification.UNDECIDED) & (two.classification != Classification.UNDECIDED)
    assert (one.classification == two.classification)[decided].all()
    assert decided.sum() > 2
    if law == "kirchhoff":
        assert (one.chaotic & two.chaotic).sum() > 2
    else:
        assert sharp.sum() > 4
        assert not (one.chaotic | two.chaotic).any()


def test_near_the_singular_set_of_the_chart_orbits_are_right_or_have_a_status():
    """Without spin and vorticity, or with p_phi = -p_psi, D1 passes D2; with a little of their sum it turns back."""
    w = np.repeat([[1.2], [1.0], [0.0], [0.0], [-0.3], [0.3], [0.0], [0.0]], 4, axis=1)
    w[6], w[7] = [0.0, 0.2, 1e-3, 1e-6], [0.0, -0.2, 0.0, 0.0]
    found = fa.integrate(fa.models.TwoPolarBody(), w, time=10.0, accuracy=1e-10)
    truth = fa.integrate(fa.Body(fa.Hyperelastic()), fa.charts.TWO_POLAR.to_planes(w), time=10.0, accuracy=1e-11).z
    assert found.status[0] == found.status[1] == Status.OK
    for k in np.flatnonzero(found.status == Status.OK):
        off = np.abs(fa.charts.TWO_POLAR.to_planes(found.z[:, k]) - truth[:, k]).max()
        assert off <= max(1e-8, 10 * found.error[:, k].max())


# --- affine invariance ------------------------------------------------------------------------------------------------


def drawn(invariance):
    """Constants for which T is positive, or of the doubly invariant one any."""
    A, B = RNG.uniform(0.3, 0.9), RNG.uniform(0.1, 0.5)
    return {"A": A, "B": B} | ({} if invariance == "both" else {"I": RNG.uniform(1.2, 2.0)})


def matrices(count, size=0.4):
    """Matrices with a positive determinant and momenta, as phase points."""
    z = np.concatenate([RNG.normal(0, 0.3, (4, count)), RNG.normal(0, size, (4, count))])
    z[0] += 1.5
    z[3] += 1.2
    return z


def affine_velocity(invariance, phi, speed):
    inverse = np.linalg.inv(phi)
    return inverse @ speed if invariance == "left" else speed @ inverse


@pytest.mark.parametrize("invariance", ["left", "right", "both"])
def test_h_is_the_legendre_transform_of_the_kinetic_energy(invariance):
    """p = dT/d phi' by complex steps; H(phi, p) = T and dH/dp = phi'."""
    for _ in range(3):
        constants = drawn(invariance)
        I, A, B = constants.get("I", 0.0), constants["A"], constants["B"]
        model = fa.models.AffineBody(invariance, **constants)
        phi, speed = matrices(1)[:4, 0].reshape(2, 2), RNG.normal(size=(2, 2))

        def kinetic(v, phi=phi, I=I, A=A, B=B):
            W = affine_velocity(invariance, phi, v)
            return I / 2 * np.trace(W.T @ W) + A / 2 * np.trace(W @ W) + B / 2 * np.trace(W) ** 2

        steps = [1e-30j * np.eye(4)[k].reshape(2, 2) for k in range(4)]
        p = np.array([kinetic(speed + step).imag / 1e-30 for step in steps])
        at = np.concatenate([phi.ravel(), p])
        assert abs(model.energy(*at) - kinetic(speed)) < 1e-12 * (1 + abs(kinetic(speed)))
        np.testing.assert_allclose(model.rates(*at)[:4], speed.ravel(), atol=1e-11)


@pytest.mark.parametrize("invariance", ["left", "right", "both"])
def test_geodesics_are_one_parameter_groups(invariance):
    """phi(t) = exp(W t) phi(0), with a steady turn of the body, or of space, where T is but left or right invariant."""
    constants = drawn(invariance)
    I, A, B = constants.get("I", 0.0), constants["A"], constants["B"]
    model, z0, t = fa.models.AffineBody(invariance, **constants), matrices(6), 3.0
    found = fa.integrate(model, z0, time=t, accuracy=1e-13)
    assert (found.status == Status.OK).all()
    for k in range(6):
        phi, p = z0[:4, k].reshape(2, 2), z0[4:, k].reshape(2, 2)
        S, body = phi @ p.T, p.T @ phi
        W = (S - B / (A + I + 2 * B) * np.trace(S) * np.eye(2)) / (A + I)
        turn = I / (I * I - A * A) if I else 0.0
        before = expm((turn * (S[0, 1] - S[1, 0]) * t * TURN) if invariance == "right" else np.zeros((2, 2)))
        after = expm((turn * (body[0, 1] - body[1, 0]) * t * TURN) if invariance == "left" else np.zeros((2, 2)))
        exact = before @ expm(W * t) @ phi @ after
        np.testing.assert_allclose(found.z[:4, k].reshape(2, 2), exact, rtol=0, atol=2e-12 * np.abs(exact).max())


@pytest.mark.parametrize("invariance", ["left", "right", "both"])
def test_the_affine_spin_is_conserved(invariance):
    model, z0 = fa.models.AffineBody(invariance, **drawn(invariance)), matrices(6)
    end = fa.integrate(model, z0, time=5.0, accuracy=1e-13).z
    before, after = (fa.constants_of_motion(model, z) for z in (z0, end))
    names = {"left": ("Sigma_",), "right": ("Sigma_body_",), "both": ("Sigma_", "Sigma_body_")}[invariance]
    assert {*before} == {"energy", "p_phi", "p_psi"} | {f"{n}{i}{j}" for n in names for i in (1, 2) for j in (1, 2)}
    size = np.maximum(1.0, (end * end).sum(axis=0))
    for name, value in before.items():
        assert (np.abs(after[name] - value) <= 1e-12 * size).all(), name


def of_matrix(z):
    """The two-polar coordinates and momenta of a phase point of matrix elements: in the planes first."""
    x, y, z_, u, px, py, pz, pu = z
    r = math.sqrt(0.5)
    planes = np.array([x + u, z_ - y, x - u, y + z_, px + pu, pz - py, px - pu, py + pz]) * r
    return fa.charts.TWO_POLAR.from_planes(planes)


def test_the_reduced_potentials_are_those_of_section_7():
    """With D = exp((a +- b)/2), Phi = 2 phi, Psi = -2 psi: p_a^2/(A + 2 B) + (p_b^2 + W)/A, W = (p_Phi^2 - 2 cosh b
    p_Phi p_Psi + p_Psi^2)/sinh(b)^2; and p_psi^2 or p_phi^2 times I/(2 (I^2 - A^2)) where T is left or right invariant.
    """
    z = matrices(20)
    D1, D2, _, _, p1, p2, p_phi, p_psi = of_matrix(z)
    a, b = np.log(D1 * D2), np.log(D1 / D2)
    p_a, p_b = (p1 * D1 + p2 * D2) / 2, (p1 * D1 - p2 * D2) / 2
    P, Q = p_phi / 2, -p_psi / 2
    assert np.isfinite(a).all()
    for invariance in ("left", "right", "both"):
        constants = drawn(invariance)
        I, A, B = constants.get("I", 0.0), constants["A"], constants["B"]
        top = A + I
        exact = p_a**2 / (top + 2 * B) + (p_b**2 + (P * P - 2 * np.cosh(b) * P * Q + Q * Q) / np.sinh(b) ** 2) / top
        if I:
            exact = exact + I / (2 * (I * I - A * A)) * (p_psi if invariance == "left" else p_phi) ** 2
        np.testing.assert_allclose(fa.models.AffineBody(invariance, **constants).energy(*z), exact, rtol=1e-11)


def test_with_a_potential_of_the_stretches_spin_and_vorticity_stay():
    """An area held by k ln(det)^2/8 beside a shear that is held by r/det; a small dilatation against its frequency."""
    k, c = (float(x) for x in RNG.uniform(0.5, 2.0, 2))
    constants = drawn("left")
    model = fa.models.AffineBody("left", **constants, potential="k*log(det)**2/8 + c*r/det/2", k=k, c=c)
    z0 = matrices(5, size=0.2)
    end = fa.integrate(model, z0, time=20.0, accuracy=1e-12)
    assert (end.status == Status.OK).all()
    before, after = (fa.constants_of_motion(model, z) for z in (z0, end.z))
    assert list(before) == ["energy", "p_phi", "p_psi"]
    for name, value in before.items():
        np.testing.assert_allclose(after[name], value, rtol=0, atol=1e-11)
    pulse = [math.exp(0.2), 0.0, 0.0, math.exp(0.2), 0.0, 0.0, 0.0, 0.0]  # a' ' = -(k/4) a/(mass/2), mass of p_a^2
    I, A, B = constants["I"], constants["A"], constants["B"]
    period = 2 * np.pi / math.sqrt(k / 4 * 2 / (A + I + 2 * B))
    back = fa.integrate(model, pulse, time=period, accuracy=1e-12).z[:, 0]
    np.testing.assert_allclose(back, pulse, atol=1e-10)


def test_what_is_no_body_is_refused():
    for call, error, match in (
        (lambda: fa.models.AffineBody("up"), ValueError, "invariance must be one of left, right, both, got 'up'"),
        (lambda: fa.models.AffineBody("both", A=0.0), ValueError, "must not be 0"),
        (lambda: fa.models.AffineBody(I=0.5, A=0.5), ValueError, "I - A"),
        (lambda: fa.models.AffineBody(potential=3), TypeError, "potential must be a text"),
        (lambda: fa.models.AffineBody(potential="k*det"), ValueError, "potential: unknown name 'k'"),
        (lambda: fa.models.TwoPolarBody(inertia=0.0), ValueError, "inertia must be positive"),
        (lambda: fa.models.TwoPolarBody("q*D1", C=1.0), ValueError, "potential: unknown name 'q'"),
        (lambda: fa.models.TwoPolarBody(3), TypeError, "potential must be a text"),
    ):
        with pytest.raises(error, match=match):
            call()
