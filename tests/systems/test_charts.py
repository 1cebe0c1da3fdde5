"""Charts of GL(2,R): conversions both ways, canonical, right in every sheet and on the singular sets.

Tolerances: a conversion is a dozen rounded operations, so 1e-13 (450 units of rounding) where nothing cancels;
1e-14 sqrt(r)/min(alpha, beta) for the momenta of charts that keep alpha and beta only through D1, D2 or vartheta.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fastaff.systems.charts import (
    ALPHA_BETA,
    R_VARTHETA,
    TWO_POLAR,
    angular_momenta,
    deformation,
    from_matrix,
    to_matrix,
)

CHARTS = (TWO_POLAR, ALPHA_BETA, R_VARTHETA)
every_chart = pytest.mark.parametrize("chart", CHARTS, ids=[chart.name for chart in CHARTS])

# 20-digit reference of the project (tests/data/reference_numbers.json, table d_classical, computed from the matrix
# elements with mpmath at 40 digits): x y z u, p_x p_y p_z p_u, then the values named in VALUES.
VALUES = ("alpha", "beta", "p_alpha", "p_beta", "r", "vartheta", "p_phi", "p_psi")
REFERENCE = (
    (
        (1.3, 0.2, -0.1, 0.8),
        (0.3, -0.4, 0.5, 0.2),
        (1.5, 0.36055512754639892931, 0.26, 0.083205029433784368303, 2.38, 0.47178976086985510967, 1.04, -1.0),
    ),
    (
        (1.0, 0.5, -0.3, 1.4),
        (-0.2, 0.6, 0.1, -0.5),
        (
            1.7888543819998317571,
            0.3162277660168379332,
            -0.35777087639996635143,
            0.03162277660168379332,
            3.3,
            0.34993809133137772301,
            -1.05,
            0.71,
        ),
    ),
    (
        (1.7, -0.2, 0.5, 0.8),
        (0.2, -0.9, -0.3, -0.4),
        (
            1.8357559750685819298,
            0.67082039324993690892,
            -0.021789388428113732105,
            0.13416407864998738178,
            3.82,
            0.70068936298187437586,
            0.19,
            -1.45,
        ),
    ),
)


def grid(orbits=400, seed=1):
    """Phase points (8, orbits) of both signs of det, alpha and beta between 0.3 and 2."""
    rng = np.random.default_rng(seed)
    radii, angles = rng.uniform(0.3, 2, (2, orbits)), rng.uniform(0, 2 * np.pi, (2, orbits))
    planes = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1).reshape(4, orbits)
    return np.concatenate([planes, rng.normal(size=(4, orbits))])


def named(chart, q):
    return dict(zip(chart.names + chart.momenta, q))


@pytest.mark.parametrize(("matrix", "momentum", "values"), REFERENCE)
def test_reference_points(matrix, momentum, values):
    z = from_matrix(np.reshape(matrix, (2, 2)), np.reshape(momentum, (2, 2)))
    got = named(R_VARTHETA, R_VARTHETA.from_planes(z)) | named(ALPHA_BETA, ALPHA_BETA.from_planes(z))
    np.testing.assert_allclose([got[name] for name in VALUES], values, rtol=1e-13)


def test_matrices_round_trip_and_isometry():
    rng = np.random.default_rng(2)
    phi, momentum = rng.normal(size=(2, 2, 2, 3, 5))
    z = from_matrix(phi, momentum)
    assert z.shape == (8, 3, 5)
    np.testing.assert_allclose(to_matrix(z), (phi, momentum), rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.sum(z[:4] ** 2, axis=0), np.sum(phi**2, axis=(0, 1)), rtol=1e-13)
    np.testing.assert_allclose(np.sum(z[:4] * z[4:], axis=0), np.sum(phi * momentum, axis=(0, 1)), rtol=0, atol=1e-13)


sign = st.sampled_from([-1.0, 1.0])
wide = st.one_of(
    st.just(0.0), st.builds(lambda s, m, e: s * m * 10.0**e, sign, st.floats(1, 10), st.integers(-100, 100))
)


@settings(max_examples=200, deadline=None)
@given(z=st.lists(wide, min_size=8, max_size=8).map(np.array))
def test_alpha_beta_returns_every_phase_point(z):
    """Plane by plane, over 200 orders of magnitude, with zeros."""
    pairs, back = z.reshape(4, 2), ALPHA_BETA.to_planes(ALPHA_BETA.from_planes(z)).reshape(4, 2)
    assert np.all(np.hypot(*(back - pairs).T) <= 1e-13 * np.hypot(*pairs.T))


near = st.one_of(st.just(0.0), st.builds(lambda s, m: s * m, sign, st.floats(1e-3, 10)))


@pytest.mark.parametrize("chart", [TWO_POLAR, R_VARTHETA], ids=lambda chart: chart.name)
@settings(max_examples=200, deadline=None)
@given(z=st.lists(near, min_size=8, max_size=8).map(np.array))
def test_round_trip_to_the_condition_of_the_chart(chart, z):
    radii = np.hypot(z[[0, 2]], z[[1, 3]])
    if not radii.any():
        return  # r = 0 has its own test
    back = chart.to_planes(chart.from_planes(z))
    condition = np.hypot(*radii) / radii[radii > 0].min()
    assert np.linalg.norm(back[:4] - z[:4]) <= 1e-13 * np.linalg.norm(z[:4])
    assert np.linalg.norm(back[4:] - z[4:]) <= 1e-14 * max(condition, 10) * np.linalg.norm(z[4:])


@every_chart
def test_shapes(chart):
    z = grid(12)
    q = chart.from_planes(z)
    assert q.shape == (8, 12)
    assert q.dtype == np.float64
    np.testing.assert_array_equal(chart.from_planes(z.reshape(8, 3, 4)), q.reshape(8, 3, 4))
    np.testing.assert_array_equal(chart.from_planes(z[:, 5]), q[:, 5])
    np.testing.assert_array_equal(chart.to_planes(q[:, 5]), chart.to_planes(q)[:, 5])
    assert chart.from_planes(z[:, :0]).shape == (8, 0)
    assert len(chart.names) == len(chart.momenta) == 4
    assert chart.momenta[0] == "p_" + chart.names[0]


def test_identities_of_the_invariants():
    """EQ2.2x, EQ2.2y: 2 D1 D2 = alpha^2 - beta^2 = r cos vartheta = 2 det phi, r = tr phi^T phi; both signs of det."""
    z = grid()
    phi = np.moveaxis(to_matrix(z)[0], -1, 0)
    D1, D2, alpha, beta = deformation(z)
    two_polar, r_vartheta = named(TWO_POLAR, TWO_POLAR.from_planes(z)), named(R_VARTHETA, R_VARTHETA.from_planes(z))
    r, vartheta = r_vartheta["r"], r_vartheta["vartheta"]
    det = np.linalg.det(phi)
    assert (det > 0).any()
    assert (det < 0).any()
    for twice_det in (2 * D1 * D2, alpha**2 - beta**2, r * np.cos(vartheta)):
        np.testing.assert_allclose(twice_det, 2 * det, rtol=0, atol=1e-13 * 8)
    for twice_shear in (D1**2 - D2**2, 2 * alpha * beta):
        np.testing.assert_allclose(twice_shear, r * np.sin(vartheta), rtol=1e-12)
    for size in (D1**2 + D2**2, alpha**2 + beta**2, np.sum(phi**2, axis=(1, 2))):
        np.testing.assert_allclose(size, r, rtol=1e-13)
    np.testing.assert_array_equal((two_polar["D1"], two_polar["D2"]), (D1, D2))
    singular = np.linalg.svd(phi, compute_uv=False).T
    np.testing.assert_allclose((D1, np.abs(D2)), singular, rtol=0, atol=1e-13 * 3)
    np.testing.assert_array_equal(np.sign(D2), np.sign(det))


def test_angular_momenta():
    """p_phi and p_psi generate rotations of space and of material; every chart carries the same four."""
    z = grid()
    phi, momentum = to_matrix(z)
    p = angular_momenta(z)
    generator = np.array([[0.0, -1.0], [1.0, 0.0]])
    spin = np.einsum("ijn,ik,kjn->n", momentum, generator, phi)  # d/ds of O(s) phi at 0
    vorticity = np.einsum("ijn,ikn,jk->n", momentum, phi, generator)  # d/ds of phi O(s)^T at 0
    np.testing.assert_allclose((p.p_phi, p.p_psi), (spin, vorticity), rtol=0, atol=1e-13)
    for chart in CHARTS:
        q = named(chart, chart.from_planes(z))
        for name in set(p._fields) & set(q):
            np.testing.assert_array_equal(q[name], getattr(p, name))


def test_canonical_sheet():
    z = grid(2000)
    z[:4, :200] *= np.repeat([0, 1e-20], 100)  # on and near r = 0
    z[1, 200:300], z[3, 200:300] = -1e-30, -0.0  # eta less than a rounding below 2 pi, gamma from below 0
    alpha, beta, eta, gamma = ALPHA_BETA.from_planes(z)[:4]
    D1, D2, phi, psi = TWO_POLAR.from_planes(z)[:4]
    vartheta = R_VARTHETA.from_planes(z[:, 100:])[1]
    assert min(alpha.min(), beta.min()) >= 0
    assert (D1 - np.abs(D2)).min() >= 0
    for angle, low, high in ((eta, 0, 2), (gamma, 0, 2), (phi, 0, 2), (psi, -1, 1), (vartheta, 0, 1)):
        assert angle.min() >= low * np.pi
        assert angle.max() <= high * np.pi
    assert max(eta.max(), gamma.max(), phi.max()) < 2 * np.pi


# The phase points where a chart is singular, with what alpha-beta says of them: (alpha, beta, eta, gamma, momenta).
SINGULAR = {
    "beta = 0": ((2, 0, 0, 0, 0.5, 3, 0, 4), (2, 0, 0, np.pi / 2, 0.5, 4, 6, 0)),
    "beta = 0, p_b = 0": ((0, 2, 0, 0, 0.5, 3, 0, 0), (2, 0, np.pi / 2, 0, 3, 0, -1, 0)),
    "beta = -0": ((2, 0, -0.0, -0.0, 0.5, 3, -0.0, -0.0), (2, 0, 0, 0, 0.5, 0, 6, 0)),
    "alpha = 0": ((0, 0, -2, 0, 0, -4, 0.5, 3), (0, 2, 3 * np.pi / 2, np.pi, 4, -0.5, 0, -6)),
    "alpha = 0, p_a = 0": ((0, 0, 0, 2, 0, 0, 0.5, 3), (0, 2, 0, np.pi / 2, 0, 3, 0, -1)),
    "rest at the centre": ((0,) * 8, (0,) * 8),
}


@pytest.mark.parametrize("where", SINGULAR)
def test_singular_sets(where):
    z, expected = (np.array(row, dtype=float) for row in SINGULAR[where])
    q = ALPHA_BETA.from_planes(z)
    np.testing.assert_allclose(q, expected, rtol=1e-15, atol=0)
    r_vartheta = named(R_VARTHETA, R_VARTHETA.from_planes(z))
    alpha, beta, p_alpha, p_beta = q[[0, 1, 4, 5]]
    assert r_vartheta["vartheta"] == (0 if beta == 0 else np.pi)
    assert r_vartheta["p_vartheta"] == pytest.approx((alpha * p_beta - beta * p_alpha) / 2, rel=1e-15)
    for chart in CHARTS:
        back = chart.to_planes(chart.from_planes(z))
        np.testing.assert_allclose(back, z, rtol=0, atol=1e-14)
        for radius, plane in ((alpha, back[:2]), (beta, back[2:4])):
            assert radius > 0 or not plane.any()  # what was 0 comes back 0


def test_passing_through_the_centre():
    """At r = 0 the limit along the motion: vartheta from the momentum, p_vartheta = 0, p_r infinite, no warning."""
    q = R_VARTHETA.from_planes([0, 0, 0, 0, 3, 0, 0, -3])
    np.testing.assert_allclose(q, [0, np.pi / 2, 3 * np.pi / 4, 3 * np.pi / 4, np.inf, 0, 0, 0], rtol=1e-15)
    with pytest.raises(ValueError, match=r"q must be finite .* got inf at index \(4,\)"):
        R_VARTHETA.to_planes(q)


def test_negative_r_is_refused():
    with pytest.raises(ValueError, match=r"q: r = .* got r = -1"):
        R_VARTHETA.to_planes([-1, 0, 0, 0, 0, 0, 0, 0])


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (np.zeros((4, 2)), ValueError, r"z must be finite real numbers of shape \(8, ...\), got shape \(4, 2\)"),
        (1.0, ValueError, r"got shape \(\)"),
        ([[1.0], [2.0, 3.0]], ValueError, r"z must be .* got \[\[1.0\], \[2.0, 3.0\]\]"),
        ([[0, 0]] * 7 + [[0, np.nan]], ValueError, r"got nan at index \(7, 1\)"),
        ([0] * 7 + [np.inf], ValueError, r"z must be .* got inf at index \(7,\)"),
        (np.zeros(8, complex), TypeError, "z must be .* got ndarray of complex128"),
        ([None] * 8, TypeError, "got list of object"),
        ("alpha", TypeError, "got str of"),
    ],
)
def test_bad_input_is_named(value, error, message):
    for function in (*(chart.from_planes for chart in CHARTS), to_matrix, angular_momenta, deformation):
        with pytest.raises(error, match=message):
            function(value)
    for chart in CHARTS:
        with pytest.raises(error, match=message.replace("z must", "q must")):
            chart.to_planes(value)


def test_bad_matrices_are_named():
    with pytest.raises(ValueError, match=r"phi must be .*\(2, 2, ...\), got shape \(4,\)"):
        from_matrix(np.zeros(4), np.zeros((2, 2)))
    with pytest.raises(ValueError, match=r"momentum must be .* got inf"):
        from_matrix(np.zeros((2, 2)), np.full((2, 2), np.inf))
    with pytest.raises(ValueError, match=r"momentum must have the shape of phi, \(2, 2, 3\); got \(2, 2\)"):
        from_matrix(np.zeros((2, 2, 3)), np.zeros((2, 2)))
