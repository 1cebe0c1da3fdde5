"""The planar affine body beside the spatial rigid body: groups, Cartan forms and invariant metrics of section 7.

GL+(2,R), R+SU(2) (the breathing top, twice over) and U(2) are three real forms of GL(2,C). Each is written as a product
of exponentials exp(q0 e0) exp(q1 e1) exp(q2 e2) exp(q3 e1) of its generators:

| value | group | coordinates | generators | label |
|---|---|---|---|---|
| AFFINE_BODY | GL+(2,R) | a, Phi, b, Psi | tilde tau_0, tilde tau_2, tilde tau_3, tilde tau_2 | EQ6.20 |
| BREATHING_TOP | R+SU(2) | a, Phi, Theta, Psi | tau_0, tau_2, tau_3, tau_2 | EQ6.5 |
| BREATHING_TOP_313, BREATHING_TOP_323 | R+SU(2) | a, Phi, Theta, Psi | tau_0, tau_3, tau_1 (tau_2), tau_3 | EQ6.6,
EQ6.7 |
| UNITARY | U(2) | a, Phi, Theta, Psi | i tau_0, tau_2, tau_3, tau_2 | below EQ6.15 |

AFFINE_BODY is the two-polar form with D1, D2 = e^{(a +- b)/2}, Phi = 2 phi, Psi = -2 psi, so its coordinates are those
of the charts EXPONENTIAL and DELTA_B (delta = e^{a/2}). The metrics are functions of the coordinates, (4, ...) in, (4,
4, ...) out, in the row order above; they take complex coordinates, because b = i Theta, a -> i a leads from one real
form to another. The metric of the affine body that is isotropic but not affinely invariant, EQ6.4 and EQ6.4a, is that
of the charts EULER and DELTA_B; in the planes it is the breathing top's own (`top_of_planes`).

Two factors of the paper are read as follows. Tr(dphi^+ dphi) is twice EQ6.10-EQ6.12, so these stand for half the trace.
EQ6.22 has no factor e^a (delta^2, lambda): with it the metric is only conformal to an affinely invariant one.

Source: Martens, Slawianowski, "Affinely-Rigid Body and Oscillatory Dynamical Models on GL(2,R)", section 7.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.arrays import Array, at_orbit, checked, first
from ..core.numbers import shown
from .kinematics import inverse

# sigma_0 .. sigma_3, tau_a = sigma_a/2i (tau_0 = 1/2) and tilde tau = (tau_0, i tau_1, tau_2, i tau_3), real: below
# EQ6.3.
PAULI = np.array([[[1, 0], [0, 1]], [[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])
TAU = np.concatenate([PAULI[:1] / 2, PAULI[1:] / 2j])
TAU_TILDE = np.stack([TAU[0], 1j * TAU[1], TAU[2], 1j * TAU[3]]).real

SMALL = 1e-4
"""Size of x from which on 1 + x^2/6 is sinh(x)/x to round-off."""


class Parametrization(NamedTuple):
    """Carry a product of four one-parameter subgroups, phi = exp(q0 e0) exp(q1 e1) exp(q2 e2) exp(q3 e3), as a value.

    name: the group.  names: the coordinates.  generators: e (4, 2, 2), e0 in the centre, each of square +-1/4.
    Source: EQ6.5, EQ6.6, EQ6.7, EQ6.20.
    """

    name: str
    names: tuple[str, str, str, str]
    generators: np.ndarray

    def matrix(self, q: Any) -> np.ndarray:
        """Compute phi (2, 2, ...) at coordinates q (4, ...), real or complex. Raises TypeError or ValueError for other
        input.
        """
        factors = self._factors(_coordinates(q))
        return _product(_product(factors[0], factors[1]), _product(factors[2], factors[3]))

    def tangents(self, q: Any) -> np.ndarray:
        """Compute dphi/dq_k (4, 2, 2, ...) at q (4, ...): a generator set between the factors. Raises as `matrix`."""
        f = self._factors(_coordinates(q))
        columns = []
        for k, generator in enumerate(self.generators):
            links = [*f[:k], np.broadcast_to(generator.reshape(2, 2, *(1,) * (f[0].ndim - 2)), f[0].shape), *f[k:]]
            product = links[0]
            for link in links[1:]:
                product = _product(product, link)
            columns.append(product)
        return np.stack(columns)

    def cartan_forms(self, q: Any) -> tuple[np.ndarray, np.ndarray]:
        """Compute Omega and hat Omega along the coordinate directions, each (4, 2, 2, ...), at q (4, ...) (EQ6.19)."""
        phi = self.matrix(q)
        tangents = self.tangents(q)
        return np.stack([omega(phi, t) for t in tangents]), np.stack([omega_hat(phi, t) for t in tangents])

    def geodesic(self, q: Any, velocity: Any, t: Any) -> np.ndarray:
        """Compute phi(t) (2, 2, ...) of free motion with a two-sided invariant metric, from q and dq/dt (4, ...).

        t: times, broadcast against the orbits.  Raises TypeError or ValueError for other input.
        Formula: phi(t) = exp(Omega t) phi(0), Omega = (dphi/dt) phi^-1, for every c of the metric. It holds for
        AFFINE_BODY and UNITARY, not for R+SU(2), whose metric the dilatations multiply.  Source: EQ6.16, EQ6.22;
        derived.
        """
        start = self.matrix(q)
        rates = np.einsum("k...,kij...->ij...", _coordinates(velocity), self.tangents(q))
        return _product(one_parameter_group(omega(start, rates), t), start)

    def _factors(self, q: np.ndarray) -> list[np.ndarray]:
        return [exponential(generator, t) for generator, t in zip(self.generators, q)]


def exponential(generator: np.ndarray, t: Any) -> np.ndarray:
    """Compute exp(t e) of a generator e (2, 2) whose square is a multiple of the identity.

    generator: tau_a, tilde tau_a or i tau_0.  t: (...), real or complex.  Returns (2, 2, ...). Raises ValueError for a
    generator of another kind.
    Formula: e^2 = s^2: cosh(s t) + (sinh(s t)/s) e, s = 1/2 or i/2.  Source: section 7, below EQ6.3.
    """
    e = np.asarray(generator)
    parameter = np.asarray(t)
    square = e @ e
    if (
        e.shape != (2, 2)
        or not np.allclose(square, square[0, 0] * np.eye(2), rtol=0, atol=1e-15)
        or abs(abs(square[0, 0]) - 0.25) > 1e-15
    ):
        raise ValueError(f"generator must be one of tau_a, tilde tau_a, of square +-1/4; got {shown(generator)}")
    compact = square[0, 0].real < 0
    even, odd = (np.cos, np.sin) if compact else (np.cosh, np.sinh)
    return np.multiply.outer(np.eye(2), even(parameter / 2)) + np.multiply.outer(2 * e, odd(parameter / 2))


def one_parameter_group(W: Any, t: Any) -> np.ndarray:
    """Compute exp(W t) (2, 2, ...) of any W (2, 2, ...), real or complex, at times t, broadcast against the rest.

    Raises TypeError or ValueError for other input.
    Formula: W = w + N with Tr N = 0 and N^2 = s^2: e^(w t) (cosh(s t) + (sinh(s t)/s) N).  Source: derived.
    """
    generator = _matrices("W", W)
    time = checked("t", t, ())
    mean = (generator[0, 0] + generator[1, 1]) / 2
    unit = np.eye(2).reshape(2, 2, *(1,) * (generator.ndim - 2))
    rest = generator - mean * unit
    angle = np.sqrt(-(rest[0, 0] * rest[1, 1] - rest[0, 1] * rest[1, 0]) + 0j) * time
    small = np.abs(angle) < SMALL
    ratio = np.where(small, 1 + angle**2 / 6, np.sinh(angle) / np.where(small, 1, angle))
    rest = rest.reshape(2, 2, *(1,) * (angle.ndim - mean.ndim), *mean.shape)
    unit = np.eye(2).reshape(2, 2, *(1,) * angle.ndim)
    found = np.exp(mean * time) * (np.cosh(angle) * unit + time * ratio * rest)
    return found if np.iscomplexobj(generator) else found.real


AFFINE_BODY = Parametrization("GL+(2,R)", ("a", "Phi", "b", "Psi"), TAU_TILDE[[0, 2, 3, 2]])
BREATHING_TOP = Parametrization("R+SU(2)", ("a", "Phi", "Theta", "Psi"), TAU[[0, 2, 3, 2]])
BREATHING_TOP_313 = Parametrization("R+SU(2)", ("a", "Phi", "Theta", "Psi"), TAU[[0, 3, 1, 3]])
BREATHING_TOP_323 = Parametrization("R+SU(2)", ("a", "Phi", "Theta", "Psi"), TAU[[0, 3, 2, 3]])
UNITARY = Parametrization("U(2)", ("a", "Phi", "Theta", "Psi"), np.concatenate([1j * TAU[:1], TAU[[2, 3, 2]]]))


def commutator(X: np.ndarray, Y: np.ndarray) -> np.ndarray:
    """Compute [X, Y] = X Y - Y X of matrices (2, 2, ...). Raises ValueError for other shapes.  Source: section 7, below
    EQ6.3.
    """
    first_matrix = _matrices("X", X)
    second_matrix = _matrices("Y", Y)
    return _product(first_matrix, second_matrix) - _product(second_matrix, first_matrix)


def structure_constants(basis: np.ndarray) -> np.ndarray:
    """Compute c[a, b, k] of [e_a, e_b] = sum_k c[a, b, k] e_k.

    basis: (n, 2, 2), closed under commutators.  Returns (n, n, n). Raises ValueError for a set that is not such a
    basis.
    Source: section 7, below EQ6.3.
    """
    e = np.asarray(basis)
    if e.ndim != 3 or e.shape[1:] != (2, 2) or np.linalg.matrix_rank(e.reshape(len(e), 4)) < len(e):
        raise ValueError(f"basis takes linearly independent matrices (n, 2, 2); got shape {e.shape}")
    flat = e.reshape(len(e), 4)
    brackets = np.array([[(x @ y - y @ x).ravel() for y in e] for x in e])
    constants = np.einsum("abm,mk->abk", brackets, np.linalg.pinv(flat))
    if not np.allclose(np.einsum("abk,km->abm", constants, flat), brackets, rtol=0, atol=1e-12):
        raise ValueError("basis is not closed under commutators")
    return constants


def omega(phi: Any, dphi: Any) -> np.ndarray:
    """Compute the Cartan form in space, the affine velocity in space when dphi is dphi/dt.

    phi, dphi: (2, 2, ...), real or complex.  Returns Omega (2, 2, ...). Raises ValueError where det phi = 0.
    Formula: Omega = dphi phi^-1; left translations turn it, right ones leave it.  Source: EQ6.19.
    """
    return _product(_matrices("dphi", dphi), inverse(_matrices("phi", phi)))


def omega_hat(phi: Any, dphi: Any) -> np.ndarray:
    """Compute the Cartan form in the body, the co-moving affine velocity when dphi is dphi/dt.

    phi, dphi: (2, 2, ...), real or complex.  Returns hat Omega (2, 2, ...). Raises ValueError where det phi = 0.
    Formula: hat Omega = phi^-1 dphi = phi^-1 Omega phi; left translations leave it.  Source: EQ6.19.
    """
    return _product(inverse(_matrices("phi", phi)), _matrices("dphi", dphi))


def invariant_form(X: Any, Y: Any, *, main: float = 1.0, dilatation: float = 0.0) -> np.ndarray:
    """Compute the two-sided invariant bilinear form on gl(2) that is made of EQ6.17 and EQ6.18.

    X, Y: (2, 2, ...), Cartan forms or elements of the algebra.  main, dilatation: the two coefficients. Returns (...).
    Raises ValueError for other shapes.
    Formula: main Tr(X Y) + dilatation Tr(X) Tr(Y); degenerate where main = 0 or main + 2 dilatation = 0.
    Source: EQ6.17, EQ6.18.
    """
    x, y = _matrices("X", X), _matrices("Y", Y)
    return main * np.einsum("ij...,ji...->...", x, y) + dilatation * np.einsum("ii...,jj...->...", x, y)


def killing_form(X: Any, Y: Any) -> np.ndarray:
    """Compute the Killing form of gl(2), degenerate on the centre only.

    X, Y: (2, 2, ...).  Returns (...). Raises ValueError for other shapes.
    Formula: Tr(ad_X ad_Y) = 4 Tr(X Y) - 2 Tr(X) Tr(Y), the ratio 4:(-2) of the paper.  Source: section 7, below EQ6.19.
    """
    return invariant_form(X, Y, main=4.0, dilatation=-2.0)


def gram(form: Any, basis: np.ndarray) -> np.ndarray:
    """Compute the matrix form(e_i, e_j) (n, n, ...) of a bilinear form on vectors `basis` (n, 2, 2, ...).

    With `basis` the Cartan forms along the coordinates this is the pullback of the form, a metric. Raises ValueError
    for other shapes.  Source: EQ6.17.
    """
    vectors = np.asarray(basis)
    if vectors.ndim < 3 or vectors.shape[1:3] != (2, 2):
        raise ValueError(f"basis takes matrices (n, 2, 2, ...); got shape {vectors.shape}")
    return np.stack([np.stack([form(x, y) for y in vectors]) for x in vectors])


def trace_form(X: Any, Y: Any) -> np.ndarray:
    """Compute Re Tr(X^+ Y), the form of EQ6.1 and EQ6.8 on tangents X, Y (2, 2, ...): twice EQ6.10-EQ6.12 on R+SU(2).

    Returns (...). Raises ValueError for other shapes.  Source: EQ6.1, EQ6.8.
    """
    return np.einsum("ji...,ji...->...", np.conj(_matrices("X", X)), _matrices("Y", Y)).real


def signature(metric: Any) -> tuple[int, int, int]:
    """Count positive, negative and zero eigenvalues of one symmetric matrix.

    metric: (n, n), real.  Returns (plus, minus, zero), zero being below 1e-12 of the largest.
    Raises ValueError for other input.  Source: below EQ6.19 (signature (+++-)).
    """
    g = checked("metric", metric, ())
    if (
        g.ndim != 2
        or g.shape[0] != g.shape[1]
        or not np.allclose(g, g.T, rtol=0, atol=1e-12 * np.max(np.abs(g), initial=0.0))
    ):
        raise ValueError(f"metric takes one symmetric matrix (n, n); got shape {g.shape}")
    values = np.linalg.eigvalsh(g)
    floor = 1e-12 * np.max(np.abs(values))
    return int(np.sum(values > floor)), int(np.sum(values < -floor)), int(np.sum(np.abs(values) <= floor))


def top_metric(q: Any) -> np.ndarray:
    """Compute the two-sided invariant metric of SU(2), that of the spherical top with I = 1, at (Phi, Theta, Psi).

    q: (3, ...).  Returns (3, 3, ...). Raises TypeError or ValueError for other input.
    Formula: dTheta^2 + dPhi^2 + 2 cos(Theta) dPhi dPsi + dPsi^2; T = (I/2) of it, I = mu r/4 for the affine body.
    Source: section 3, dsigma^2 above EQ2.2c.
    """
    _, Theta, _ = _coordinates(q, 3)
    return _top(np.ones_like(Theta), np.cos(Theta), 0)


def breathing_metric(q: Any, c: float = 0.0) -> np.ndarray:
    """Compute the metric of R+SU(2) at (a, Phi, Theta, Psi).

    q: (4, ...).  c: weight of the dilatational correction c ddelta^2.  Returns (4, 4, ...). Raises TypeError or
    ValueError for other input.
    Formula: (e^a/4)((1 + c) da^2 + dsigma^2) = Tr(dphi^+ dphi)/2 + c ddelta^2; invariant under SU(2) on both sides.
    Source: EQ6.12, EQ6.15 (EQ6.8 read as half the trace).
    """
    a, _, Theta, _ = _coordinates(q)
    return _with_size(np.exp(a) / 4 * (1 + c), np.exp(a) / 4, np.cos(Theta))


def breathing_metric_delta(q: Any, c: float = 0.0) -> np.ndarray:
    """Compute the metric of R+SU(2) at (delta, Phi, Theta, Psi), delta = e^{a/2}; q, c, returns, raises as
    `breathing_metric`.

    Formula: (1 + c) ddelta^2 + (delta^2/4) dsigma^2.  Source: EQ6.10, EQ6.13.
    """
    delta, _, Theta, _ = _coordinates(q)
    return _with_size((1 + c) * np.ones_like(delta), delta**2 / 4, np.cos(Theta))


def breathing_metric_lambda(q: Any, c: float = 0.0) -> np.ndarray:
    """Compute the metric of R+SU(2) at (lambda, Phi, Theta, Psi), lambda = e^a; q, c, returns, raises as
    `breathing_metric`.

    Formula: ((1 + c) dlambda^2 + lambda^2 dsigma^2)/4 lambda.  Raises ValueError where lambda = 0.  Source: EQ6.11,
    EQ6.14.
    """
    lam, _, Theta, _ = _coordinates(q)
    return _with_size((1 + c) / (4 * _nonzero("lambda", lam)), lam / 4, np.cos(Theta))


def unitary_metric(q: Any, c: float = 0.0) -> np.ndarray:
    """Compute the two-sided invariant metric of U(2) at (a, Phi, Theta, Psi).

    q: (4, ...).  c: weight of the dilatational correction.  Returns (4, 4, ...). Raises TypeError or ValueError for
    other input.
    Formula: ((1 + c) da^2 + dsigma^2)/4 = -Tr(Omega^2)/2 - (c/4) Tr(Omega)^2; at c = 0 half of Tr(dphi^+ dphi).
    Source: EQ6.16.
    """
    _, _, Theta, _ = _coordinates(q)
    return _with_size((1 + c) / 4 * np.ones_like(Theta), np.ones_like(Theta) / 4, np.cos(Theta))


def affine_metric(q: Any, c: float = 0.0) -> np.ndarray:
    """Compute the affinely invariant metric of GL+(2,R) at (a, Phi, b, Psi), of signature (+++-) for c > -1.

    q: (4, ...).  c: weight of the dilatational term.  Returns (4, 4, ...). Raises TypeError or ValueError for other
    input.
    Formula: ((1 + c) da^2 + db^2 - dPhi^2 - 2 cosh(b) dPhi dPsi - dPsi^2)/4 = Tr(Omega^2)/2 + (c/4) Tr(Omega)^2; at c =
    -2 it is -det(dphi)/det(phi), at c = -1 an eighth of the Killing form. Invariant under GL+(2,R) on both sides.
    Source: EQ6.17, EQ6.18, EQ6.22; corrected, the printed factor e^a spoils the invariance.
    """
    _, _, b, _ = _coordinates(q)
    return _affine((1 + c) / 4 * np.ones_like(b), b)


def affine_metric_delta(q: Any, c: float = 0.0) -> np.ndarray:
    """Compute the affinely invariant metric at (delta, Phi, b, Psi), delta = e^{a/2}; q, c, returns, raises as
    `affine_metric`.

    Formula: (1 + c) ddelta^2/delta^2 + (db^2 - dPhi^2 - 2 cosh(b) dPhi dPsi - dPsi^2)/4. Raises ValueError where delta
    = 0.
    Source: EQ6.22, first line; corrected.
    """
    delta, _, b, _ = _coordinates(q)
    return _affine((1 + c) / _nonzero("delta", delta) ** 2, b)


def affine_metric_lambda(q: Any, c: float = 0.0) -> np.ndarray:
    """Compute the affinely invariant metric at (lambda, Phi, b, Psi), lambda = e^a; q, c, returns, raises as
    `affine_metric`.

    Formula: (1 + c) dlambda^2/4 lambda^2 + (db^2 - dPhi^2 - 2 cosh(b) dPhi dPsi - dPsi^2)/4. Raises ValueError where
    lambda = 0.
    Source: EQ6.22, second line; corrected.
    """
    lam, _, b, _ = _coordinates(q)
    return _affine((1 + c) / (4 * _nonzero("lambda", lam) ** 2), b)


def continued_affine_metric(q: Any, c: float = 0.0) -> np.ndarray:
    """Continue the affinely invariant metric to the compact real form: b = i Theta, a -> i a.

    q: (a, Phi, Theta, Psi), (4, ...), real.  c: as in `affine_metric`.  Returns (4, 4, ...), minus `unitary_metric`.
    Raises TypeError or ValueError for other input.
    Formula: J^T g(i a, Phi, i Theta, Psi) J, J = diag(i, 1, i, 1).  Source: EQ6.23, and the text below it.
    """
    a, Phi, Theta, Psi = checked("q", q, (4,))
    g = affine_metric(np.stack([1j * a, Phi + 0j, 1j * Theta, Psi + 0j]), c)
    turn = np.array([1j, 1, 1j, 1])
    return np.einsum("i,ij...,j->ij...", turn, g, turn).real


def top_of_planes(planes: Any) -> np.ndarray:
    """Carry planes of the affine body to the breathing top: the linear isometry behind EQ6.4 and EQ6.10.

    planes: a1, a2, b1, b2 (4, ...), the first rows of z.  Returns the matrix in R+SU(2) (and 0) (2, 2, ...) with the
    same coordinates rho = delta, Phi, Theta, Psi; Tr(dphi^+ dphi)/2 there is Tr(dphi^T dphi) of the body. Raises
    TypeError or ValueError for other input.
    Formula: a1 + 2 (a2 tau_2 + b1 tau_3 + b2 tau_1), and phi = (a1 + 2 (a2, b1, b2) . (tilde tau_2, tilde tau_3, tilde
    tau_1))/sqrt2.
    Source: EQ6.4, EQ6.10; the map is derived.
    """
    rows = checked("planes", planes, (4,))
    return np.einsum("k...,kij->ij...", rows, 2 * TAU[[0, 2, 3, 1]])


def _top(weight: Any, cosine: Any, offset: int) -> np.ndarray:
    """weight (dPhi^2 + dTheta^2 + dPsi^2 + 2 cosine dPhi dPsi) in the last three of 3 + offset rows."""
    g = np.zeros((3 + offset, 3 + offset, *np.shape(cosine)), dtype=np.result_type(weight, cosine))
    for k in range(offset, offset + 3):
        g[k, k] = weight
    g[offset, offset + 2] = g[offset + 2, offset] = weight * cosine
    return g


def _with_size(size: Any, weight: Any, cosine: Any) -> np.ndarray:
    g = _top(weight, cosine, 1)
    g[0, 0] = size
    return g


def _affine(size: Any, b: Any) -> np.ndarray:
    """Size dq0^2 + (db^2 - dPhi^2 - 2 cosh(b) dPhi dPsi - dPsi^2)/4."""
    g = _with_size(size, -np.ones_like(b) / 4, np.cosh(b))
    g[2, 2] = 0.25
    return g


def _product(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.einsum("ij...,jk...->ik...", x, y)


def _numbers(name: str, value: Any, leading: tuple[int, ...]) -> np.ndarray:
    """Finite real or complex numbers of shape (*leading, ...)."""
    array = np.asarray(value)
    if array.dtype.kind != "c":
        return checked(name, value, leading)
    checked(name, array.real, leading)
    checked(name, array.imag, leading)
    return array


def _coordinates(q: Any, rows: int = 4) -> np.ndarray:
    return _numbers("q", q, (rows,))


def _matrices(name: str, value: Any) -> np.ndarray:
    return _numbers(name, value, (2, 2))


def _nonzero(name: str, value: Any) -> Array:
    if np.any(value == 0):
        raise ValueError(f"q: {name} must not be 0{at_orbit(first(np.asarray(value == 0)))}")
    return value
