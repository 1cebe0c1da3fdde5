"""Tangent maps: the derivative of every scheme's map, symplectic, and bitwise the orbit of `integrate`."""

import numpy as np
import pytest
from own_models import OneSpring
from scipy.integrate import solve_ivp
from shared_systems import duffing

import fastaff
from fastaff.runs.schemes.catalogue import SCHEMES, Splitting

SPLITTINGS = [scheme for scheme in SCHEMES.values() if isinstance(scheme, Splitting)]
CASES = {
    "henon-heiles": (fastaff.HenonHeiles(), [0.0, -0.25, 0.42081, 0.0]),
    "neo-hookean": (fastaff.Body(fastaff.NeoHookean(), mu=1.3), [1.5, 0.1, 0.3, 0.05, 0.1, 0.3, 0.2, 0.1]),
    "hyperelastic": (fastaff.Body(fastaff.Hyperelastic(C=0.7)), [1.4, -0.2, 0.3, 0.1, 0.2, 0.3, -0.2, 0.4]),
    "heavy-top": (fastaff.Body(fastaff.HeavyTop(A=0.5)), [1.1, 0.2, 0.4, -0.3, 0.3, 0.5, 0.2, 0.1]),
    "elliptic": (fastaff.Body(fastaff.Anharmonic(C=0.8).elliptic), [1.4, 0.2, 0.4, -0.3, 0.3, 0.5, 0.2, 0.1]),
    "stackel": (
        fastaff.models.StackelBody(
            fastaff.Harmonic(C=0.8),
            fastaff.univariate(lambda s: 0.2 * np.cos(s), lambda s: -0.2 * np.sin(s)),
            fastaff.models.Zero(),
        ),
        [1.4, 0.2, 0.4, -0.3, 0.3, 0.5, 0.2, 0.1],
    ),
}


def cloud(start, orbits=3, seed=0):
    """Orbits around a start."""
    return np.array(start)[:, None] + 1e-2 * np.random.default_rng(seed).standard_normal((len(start), orbits))


def omega(n):
    """The symplectic form."""
    return np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])


@pytest.mark.parametrize("scheme", SPLITTINGS, ids=lambda s: s.name)
@pytest.mark.parametrize("name", ["henon-heiles", "neo-hookean"])
def test_tangent_maps_of_splittings_are_symplectic(name, scheme):
    """M^T Omega M = Omega however long the step is: the derivative of a symplectic map, not of the flow."""
    (model, start) = CASES[name]
    form = omega(model.degrees_of_freedom)
    for step in (0.05, 0.2):
        moved = fastaff.tangent_map(model, cloud(start), time=4.0, step=step, scheme=scheme, energy_tolerance=1e9)
        matrix = np.moveaxis(moved.matrix, -1, 0)
        found = matrix.transpose(0, 2, 1) @ form @ matrix
        assert np.abs(found - form).max() <= 1e-13 * np.abs(matrix).max() ** 2


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=lambda s: s.name)
@pytest.mark.parametrize("name", ["henon-heiles", "neo-hookean"])
def test_vectors_are_the_derivative_of_the_map(name, scheme):
    """Against central differences of the scheme's own orbits: error delta^2 f'''/6 + eps/delta."""
    model, start = CASES[name]
    z, delta, run = cloud(start), 1e-4, {"time": 3.0, "step": 0.05, "scheme": scheme, "energy_tolerance": 1.0}
    found = fastaff.tangent_map(model, z, **run)
    for j, vector in enumerate(found.vectors):
        ends = [fastaff.integrate(model, z + side * delta * np.eye(len(z))[:, [j]], **run).z for side in (1, -1)]
        assert np.abs((ends[0] - ends[1]) / (2 * delta) - vector).max() <= 2e-6 * np.abs(found.vectors).max()


@pytest.mark.parametrize(
    ("model", "start"),
    [
        pytest.param(*case, id=name, marks=[pytest.mark.slow] if name in ("heavy-top", "elliptic") else [])
        for name, case in CASES.items()
    ],
)
def test_every_model_is_symplectic_and_follows_the_variational_equations(model, start):
    n, z0 = model.degrees_of_freedom, np.array(start)
    form, splitting = omega(n), {"scheme": fastaff.SOFRONIOU_SPALETTA10, "energy_tolerance": 1e9}
    matrix = fastaff.tangent_map(model, z0, time=1.0, step=0.1, **splitting).matrix[:, :, 0]
    assert np.abs(matrix.T @ form @ matrix - form).max() <= 1e-13 * np.abs(matrix).max() ** 2
    deviations = np.random.default_rng(1).standard_normal((2, 2 * n))

    def slope(_, y):
        z, vectors = y[: 2 * n], y[2 * n :].reshape(2, 2 * n)
        slopes = [*model.velocity(*z[n:]), *model.force(*z[:n])]
        for w in vectors:
            slopes += [*model.velocity(*w[n:]), *model.tangent_force(*z[:n], *w[:n])]
        return np.array(slopes, dtype=float)

    truth = (
        solve_ivp(slope, (0, 5), [*z0, *deviations.ravel()], "DOP853", rtol=1e-12, atol=1e-13)
        .y[2 * n :, -1]
        .reshape(2, 2 * n)
    )
    matrix = fastaff.tangent_map(model, z0, time=5.0, step=0.025, **splitting).matrix[:, :, 0]
    adaptive = fastaff.tangent_map(model, z0, time=5.0, deviation_vectors=deviations, scheme=fastaff.DOP853).vectors[
        :, :, 0
    ]
    for found in (deviations @ matrix.T, adaptive):
        assert np.abs(found - truth).max() <= 3e-9 * np.abs(truth).max()


@pytest.mark.parametrize(
    "scheme", [s for s in SCHEMES.values() if not getattr(s, "adaptive", False)], ids=lambda s: s.name
)
def test_the_orbit_is_that_of_integrate_to_the_bit(scheme):
    """To rounding of a collocation, whose iteration settles the orbit together with its vectors."""
    off = 1e-15 if hasattr(scheme, "sweeps") else 0.0
    run = {"time": 6.0, "step": 0.03, "scheme": scheme, "energy_tolerance": 1.0}
    for name, counts in (("henon-heiles", (1, 2, 3, 4)), ("neo-hookean", (3, 8))):
        model, start = CASES[name]
        plain = fastaff.integrate(model, cloud(start, 5), **run)
        for count in counts:
            found = fastaff.tangent_map(model, cloud(start, 5), deviation_vectors=np.eye(len(start))[:count], **run)
            assert np.abs(found.z - plain.z).max() <= off
            assert np.abs(found.energy_error - plain.energy_error).max() <= off


def test_it_is_linear_and_takes_deviations_of_each_orbit():
    model, start = CASES["henon-heiles"]
    z = cloud(start, 4)
    deviations = np.random.default_rng(5).standard_normal((3, 4, 4))
    matrix = fastaff.tangent_map(model, z, time=7.0, step=0.05).matrix
    found = fastaff.tangent_map(model, z, time=7.0, step=0.05, deviation_vectors=deviations).vectors
    assert np.allclose(found, np.einsum("ijo,kjo->kio", matrix, deviations), rtol=0, atol=1e-13 * np.abs(matrix).max())


@pytest.mark.parametrize("orbits", [1, 5])
@pytest.mark.parametrize("scheme", ["KAHAN_LI8", "SOFRONIOU_SPALETTA10"])
@pytest.mark.parametrize("name", ["henon-heiles", "driven"])
def test_many_vectors_have_the_bits_of_few(name, scheme, orbits):
    # More than 12 vectors of one orbit stay in memory; a loop moves all groups of four after the first.
    model, start = (duffing(), [0.4, 0.1]) if name == "driven" else CASES[name]
    z0 = cloud(start, orbits)
    vectors = np.random.default_rng(8).standard_normal((18, 4))  # a drive has rows for its time
    how = {"time": 3.0, "step": 0.1, "scheme": scheme}
    whole = fastaff.tangent_map(model, z0, deviation_vectors=vectors, **how)
    few = [fastaff.tangent_map(model, z0, deviation_vectors=vectors[k : k + 2], **how) for k in range(0, 18, 2)]
    assert np.array_equal(whole.vectors, np.concatenate([part.vectors for part in few]))
    assert all(np.array_equal(whole.z, part.z) for part in few)


@pytest.mark.parametrize("orbits", [1, 5])
def test_vectors_that_overflow_end_their_orbit(orbits):
    model, start = CASES["henon-heiles"]
    vectors = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1e308]])
    found = fastaff.tangent_map(model, cloud(start, orbits), deviation_vectors=vectors, time=200.0, step=0.1)
    assert (found.status == fastaff.Status.NONFINITE).all()
    assert np.isfinite(found.z).all()
    assert (found.t < 200.0).all()


def test_checks_of_orbits_have_one_text_for_all_numbers_of_vectors():
    model, _ = CASES["neo-hookean"]
    for kind in ("check", "inside"):
        assert fastaff.engine.source(model, kind, vectors=8) == fastaff.engine.source(model, kind)


class Relativistic(OneSpring):
    """A model whose velocity is not linear in p."""

    def velocity(self, p):
        return (p / np.sqrt(1 + p * p),)

    def tangent_force(self, x, dx):
        return (-self.k * dx,)


@pytest.mark.parametrize(
    ("arguments", "problem", "words"),
    [
        ({"model": OneSpring(), "z0": [1.0, 0.0]}, TypeError, "tangent_force"),
        ({"model": Relativistic(), "z0": [1.0, 0.0]}, ValueError, "linear"),
        ({"deviation_vectors": np.eye(3)}, ValueError, r"deviation_vectors must have shape \(count, 4\)"),
        ({"deviation_vectors": np.ones((2, 4, 3))}, ValueError, "deviation_vectors must have shape"),
        ({"deviation_vectors": np.zeros((0, 4))}, ValueError, "deviation_vectors must have shape"),
        ({"deviation_vectors": [[np.nan] * 4]}, ValueError, "finite"),
        ({"deviation_vectors": "e1"}, TypeError, "deviation_vectors must be an array"),
        ({"time": -1.0}, ValueError, "time must be positive"),
    ],
)
def test_wrong_input_is_refused(arguments, problem, words):
    model, start = CASES["henon-heiles"]
    with pytest.raises(problem, match=words):
        fastaff.tangent_map(**{"model": model, "z0": start, "time": 1.0, "step": 0.1, **arguments})
