"""Section 2: placements, inertia, kinetic energy and deformation tensors, against sums over material points and
singular values.
"""

import numpy as np
import pytest

from fastaff.systems.charts import TWO_POLAR, deformation, to_matrix
from fastaff.systems.kinematics import (
    cauchy_tensor,
    green_tensor,
    inertia,
    kinetic_energy,
    placement,
    tensor_invariants,
)

RNG = np.random.default_rng(8)
LABELS, MASSES = RNG.normal(size=(2, 9)), RNG.uniform(0.5, 2, 9)
PHI, RATE = RNG.normal(size=(2, 2, 2, 6))


def test_placement_is_affine():
    x = RNG.normal(size=(2, 6))
    y = placement(PHI, LABELS, x)
    assert y.shape == (2, 9, 6)
    for n in range(6):
        np.testing.assert_allclose(y[..., n], PHI[..., n] @ LABELS + x[:, n, None], rtol=0, atol=1e-14)
    np.testing.assert_allclose(placement(PHI[..., 0], LABELS, x[:, 0]), y[..., 0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(placement(PHI, LABELS), y - x[:, None], rtol=0, atol=1e-14)


def test_kinetic_energy_is_the_sum_over_points():
    """T = sum m |dy/dt|^2/2 for labels about the centre of mass; mu for an isotropic body."""
    body = inertia(LABELS, MASSES)
    labels = LABELS - body.centre[:, None]
    speed = placement(RATE, labels)
    np.testing.assert_allclose(
        kinetic_energy(RATE, body.moments), np.einsum("p,ipn->n", MASSES, speed**2) / 2, rtol=1e-13
    )
    assert body.mass == pytest.approx(MASSES.sum())
    np.testing.assert_allclose(inertia(labels, MASSES).centre, 0, atol=1e-15)
    np.testing.assert_allclose(kinetic_energy(RATE, 1.3), 0.65 * np.sum(RATE**2, axis=(0, 1)), rtol=1e-14)
    square = inertia([[1, -1, 0, 0], [0, 0, 1, -1]], np.ones(4))
    np.testing.assert_array_equal(square.moments, 2 * np.eye(2))


def test_deformation_tensors():
    """G = O(psi) D^2 O(psi)^T, Cauchy = O(phi) D^-2 O(phi)^T; invariants from singular values; rotations leave what
    they must.
    """
    z = np.concatenate([RNG.normal(size=(4, 6)), np.zeros((4, 6))])
    phi, D = to_matrix(z)[0], deformation(z)
    G, C = green_tensor(phi), cauchy_tensor(phi)
    for n in range(6):
        singular = np.linalg.svd(phi[..., n], compute_uv=False)
        np.testing.assert_allclose([D.D1[n], abs(D.D2[n])], singular, rtol=0, atol=1e-14 * 5)
        D1, D2, left, right = TWO_POLAR.from_planes(z[:, n])[:4]
        for tensor, angle, values in ((G, right, (D1**2, D2**2)), (C, left, (D1**-2, D2**-2))):
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            np.testing.assert_allclose(
                tensor[..., n], turn @ np.diag(values) @ turn.T, rtol=0, atol=1e-12 * max(values)
            )
    invariants = tensor_invariants(G)
    np.testing.assert_allclose(invariants.trace, D.r, rtol=1e-13)
    np.testing.assert_allclose(invariants.determinant, D.area**2, rtol=0, atol=1e-13 * D.r.max() ** 2)
    np.testing.assert_allclose(invariants.first, D.D1**2, rtol=1e-13)
    np.testing.assert_allclose(invariants.second, D.D2**2, rtol=0, atol=1e-13 * D.r.max())
    np.testing.assert_allclose(tensor_invariants(C).first, D.D2**-2.0, rtol=1e-10)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    np.testing.assert_allclose(green_tensor(np.einsum("ij,jkn->ikn", turn, phi)), G, rtol=0, atol=1e-14 * 10)
    np.testing.assert_allclose(
        cauchy_tensor(np.einsum("ijn,jk->ikn", phi, turn)), C, rtol=0, atol=1e-12 * np.abs(C).max()
    )


def test_eigenvalues_of_any_symmetric_tensor():
    t = RNG.normal(size=(2, 2, 50))
    t = t + t.swapaxes(0, 1)
    t[..., 0] = 0
    t[..., 1] = -np.eye(2)
    invariants = tensor_invariants(t)
    expected = np.linalg.eigvalsh(np.moveaxis(t, -1, 0)).T
    np.testing.assert_allclose((invariants.second, invariants.first), expected, rtol=0, atol=1e-14 * 5)


def test_bad_input_is_named():
    with pytest.raises(ValueError, match=r"det phi = 0 at orbit \(1,\)"):
        cauchy_tensor(np.stack([np.eye(2), np.ones((2, 2))], axis=-1))
    with pytest.raises(ValueError, match="tensor must be symmetric"):
        tensor_invariants([[1, 2], [3, 4]])
    with pytest.raises(ValueError, match=r"labels takes shape \(2, points\)"):
        placement(np.eye(2), np.zeros(2))
    with pytest.raises(ValueError, match=r"labels takes \(2, points\) and masses \(points,\)"):
        inertia(LABELS, MASSES[:3])
    for bad in (-MASSES, 0 * MASSES):
        with pytest.raises(ValueError, match="masses must not be negative"):
            inertia(LABELS, bad)
    with pytest.raises(ValueError, match="moments must be positive"):
        kinetic_energy(RATE, 0.0)
