"""All charts of the paper, each one row: a chain of steps from the planes, and its line element.

PLANES is the pair of polar coordinates (alpha, eta), (beta, gamma) in which every chart of the deformation invariants
begins; ELEMENTS leads to the matrix elements, in which the charts of R^4 begin.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ...core.arrays import Array, Mask
from ...core.numbers import positive
from . import metrics
from .chart import Chart
from .steps import Conformal, Mix, PolarStep, Step, Warp, direction

ROOT2 = float(np.sqrt(2.0))

# Rows (a1, a2, b1, b2) -> (alpha, eta, beta, gamma), and to (x, y, u, z).
PLANES: tuple[Step, ...] = (
    PolarStep(0, 1, "alpha = (D1 + D2)/sqrt2", "p_eta = (p_phi - p_psi)/2"),
    PolarStep(2, 3, "beta = (D1 - D2)/sqrt2", "p_gamma = (p_phi + p_psi)/2"),
)
ELEMENTS: tuple[Step, ...] = (Mix(0, 2, ROOT2), Mix(3, 1, ROOT2))

SUM_AND_DIFFERENCE = Mix(0, 2, ROOT2)  # (alpha, beta) -> (D1, D2)
HALF_TURNS = Mix(3, 1, 2.0)  # (gamma, eta) -> (phi, psi) = (gamma +- eta)/2
DOUBLED_ANGLES = Mix(1, 3, 1.0)  # (eta, gamma) -> (Phi, Psi) = (2 phi, -2 psi) = eta +- gamma


def _everywhere(x: Array) -> Mask:
    return np.ones(np.shape(x), dtype=bool)


def _twice_root(r: Array) -> Array:
    return 2 * np.sqrt(r)


def _not_negative(r: Array) -> Mask:
    return r >= 0


def _exp_minus(x: Array) -> Array:
    return np.exp(-x)


def _exp_half(a: Array) -> Array:
    return np.exp(a / 2)


def _twice_log(delta: Array) -> Array:
    return 2 * np.log(delta)


def _half(delta: Array) -> Array:
    return delta / 2


def _above_zero(delta: Array) -> Mask:
    return delta > 0


SQUARE = Warp(0, np.square, np.sqrt, _twice_root, _not_negative, "r = D1^2 + D2^2 must not be negative", "r")
LOGARITHMS: tuple[Step, ...] = (
    Warp(0, np.log, np.exp, _exp_minus, _everywhere),
    Warp(2, np.log, np.exp, _exp_minus, _everywhere),
    Mix(0, 2, 1.0),
)  # (D1, D2) -> (a, b) = ln D1 +- ln D2
DILATATION = Warp(0, _exp_half, _twice_log, _half, _above_zero, "delta = sqrt(D1 D2) must be positive", "delta")


def _polar_invariants(radius: str, angle: str, fold: int) -> PolarStep:
    """(alpha, beta) = rho (cos, sin)(angle/fold)."""
    return PolarStep(0, 2, radius, f"p_{angle}", fold)


def elliptic(focus: float) -> Chart:
    """Build the elliptic chart (kappa, lambda) of the plane of invariants.

    Parameters
    ----------
    focus : float, length
        Position of the foci, alpha = +-focus, beta = 0, positive. The value sqrt2 puts the focus at the undeformed
        state D1 = D2 = 1.

    Returns
    -------
    `Chart`
        Chart with the coordinates kappa, lambda, eta, gamma.

    Raises
    ------
    TypeError
        If `focus` is not a number.
    ValueError
        If `focus` is not positive.

    Notes
    -----
    * Coordinates: alpha + i beta = focus cosh(kappa + i lambda).
    * Sheet: ``from_planes`` returns kappa >= 0 and lambda in [0, pi/2].
    * Focus, kappa = lambda = 0: ``from_planes`` returns the limit p_kappa = p_lambda = 0. It has no inverse, so
      ``to_planes`` raises `ValueError` there.

    References
    ----------
    Martens & Slawianowski, section 3, elliptic variables.

    Examples
    --------
    >>> fa.charts.elliptic(2**0.5).names
    ('kappa', 'lambda', 'eta', 'gamma')
    """
    f = positive("focus", focus)
    singular = (
        "the focus D1 = D2 (kappa = lambda = 0) or alpha = 0 (lambda = pi/2) or beta = 0 (kappa = 0 or lambda = 0)"
    )
    step = Conformal(0, 2, partial(_elliptic, f), partial(_elliptic_slope, f), partial(_elliptic_inverse, f))
    return Chart(
        "elliptic",
        ("kappa", "lambda", "eta", "gamma"),
        (*PLANES, step),
        (0, 2, 1, 3),
        partial(metrics.elliptic, f),
        singular,
    )


def bipolar(c: float) -> Chart:
    """Build the bipolar chart (e, f) of the plane of invariants.

    Parameters
    ----------
    c : float, length
        Position of the poles, alpha = +-c, beta = 0, positive.

    Returns
    -------
    `Chart`
        Chart with the coordinates e, f, eta, gamma.

    Raises
    ------
    TypeError
        If `c` is not a number.
    ValueError
        If `c` is not positive.

    Notes
    -----
    * Coordinates: alpha, beta = c (sinh e, sin f)/(cosh e - cos f). The paper calls them "two-polar".
    * Sheet: ``from_planes`` returns e >= 0 and f in [0, pi].
    * Pole, D1 = D2 = c/sqrt2: e is infinite, so ``from_planes`` raises `ValueError`.
    * Infinity, e = f = 0: ``to_planes`` raises `ValueError`.

    References
    ----------
    Martens & Slawianowski, section 3, the variables (e, f).

    Examples
    --------
    >>> fa.charts.bipolar(1.0).names
    ('e', 'f', 'eta', 'gamma')
    """
    c = positive("c", c)
    singular = "alpha = c, beta = 0 (e infinite), infinity (e = f = 0), alpha = 0 (e = 0) and beta = 0 (sin f = 0)"
    step = Conformal(0, 2, partial(_bipolar, c), partial(_bipolar_slope, c), partial(_bipolar_inverse, c), sign=-1)
    return Chart(
        "bipolar", ("e", "f", "eta", "gamma"), (*PLANES, step), (0, 2, 1, 3), partial(metrics.bipolar, c), singular
    )


def _elliptic(focus: float, k: Array, lam: Array) -> tuple[Array, Array]:
    c, s = direction(lam)
    return focus * np.cosh(k) * c, focus * np.sinh(k) * s


def _elliptic_slope(focus: float, k: Array, lam: Array) -> np.ndarray:
    c, s = direction(lam)
    return focus * (np.sinh(k) * c + 1j * np.cosh(k) * s)


def _elliptic_inverse(focus: float, alpha: Array, beta: Array) -> tuple[Array, Array]:
    zeta = np.arccosh((alpha + 1j * beta) / focus)
    return zeta.real, zeta.imag


def _bipolar(c: float, e: Array, f: Array) -> tuple[Array, Array]:
    factor = c / (2 * (np.sinh(e / 2) ** 2 + np.sin(f / 2) ** 2))
    return factor * np.sinh(e), factor * direction(f)[1]


def _bipolar_slope(c: float, e: Array, f: Array) -> np.ndarray:
    cosine, sine = direction(f / 2)
    return -c / 2 / (np.sinh(e / 2) * cosine + 1j * np.cosh(e / 2) * sine) ** 2


def _bipolar_inverse(c: float, alpha: Array, beta: Array) -> tuple[Array, Array]:
    e = np.log1p(4 * c * alpha / ((alpha - c) ** 2 + beta**2)) / 2
    return e, np.arctan2(2 * c * beta, (alpha - c) * (alpha + c) + beta**2)


def _parabola(xi: Array, delta: Array) -> tuple[Array, Array]:
    return (xi - delta) * (xi + delta) / 2, xi * delta


def _parabola_slope(xi: Array, delta: Array) -> np.ndarray:
    return xi + 1j * delta


def _parabola_inverse(alpha: Array, beta: Array) -> tuple[Array, Array]:
    zeta = np.sqrt(2 * (alpha + 1j * beta))
    return zeta.real, zeta.imag


_TURNED = (*PLANES, HALF_TURNS)
_D1_D2 = (*PLANES, SUM_AND_DIFFERENCE)
_CENTRE = "r = 0 or alpha = 0 (vartheta = pi) or beta = 0 (vartheta = 0)"
_DET = "det phi = D1 D2 <= 0 and D1 = D2 (b = 0)"

ALPHA_BETA = Chart(
    "alpha-beta",
    ("alpha", "beta", "eta", "gamma"),
    PLANES,
    (0, 2, 1, 3),
    metrics.alpha_beta,
    "alpha = 0 or beta = 0",
)
ALPHA_BETA_PHI_PSI = Chart(
    "alpha-beta-phi-psi",
    ("alpha", "beta", "phi", "psi"),
    _TURNED,
    (0, 2, 3, 1),
    metrics.alpha_beta_phi_psi,
    "alpha = 0 or beta = 0",
)
TWO_POLAR = Chart(
    "two-polar",
    ("D1", "D2", "phi", "psi"),
    (*_D1_D2, HALF_TURNS),
    (0, 2, 3, 1),
    metrics.two_polar,
    "D1 = D2 or D1 = -D2",
)
RHO_EPSILON = Chart(
    "rho-epsilon",
    ("rho", "epsilon", "eta", "gamma"),
    (*PLANES, _polar_invariants("rho", "epsilon", 1)),
    (0, 2, 1, 3),
    metrics.rho_epsilon,
    "rho = 0 or alpha = 0 (epsilon = pi/2) or beta = 0 (epsilon = 0)",
)
RHO_VARTHETA = Chart(
    "rho-vartheta",
    ("rho", "vartheta", "eta", "gamma"),
    (*PLANES, _polar_invariants("rho", "vartheta", 2)),
    (0, 2, 1, 3),
    metrics.rho_vartheta,
    f"rho^2 = {_CENTRE}",
)
R_VARTHETA_ETA_GAMMA = Chart(
    "r-vartheta-eta-gamma",
    ("r", "vartheta", "eta", "gamma"),
    (*PLANES, _polar_invariants("r", "vartheta", 2), SQUARE),
    (0, 2, 1, 3),
    metrics.r_vartheta_eta_gamma,
    _CENTRE,
)
R_VARTHETA = Chart(
    "r-vartheta",
    ("r", "vartheta", "phi", "psi"),
    (*_TURNED, _polar_invariants("r", "vartheta", 2), SQUARE),
    (0, 2, 3, 1),
    metrics.r_vartheta,
    _CENTRE,
)
EULER = Chart(
    "Euler",
    ("rho", "Phi", "Theta", "Psi"),
    (*PLANES, _polar_invariants("rho", "Theta", 2), DOUBLED_ANGLES),
    (0, 1, 2, 3),
    metrics.euler,
    "rho = 0 or sin(Theta) = 0 (D1 = D2 or D1 = -D2)",
)
R_EULER = Chart(
    "r-Euler",
    ("r", "Phi", "Theta", "Psi"),
    (*PLANES, _polar_invariants("r", "Theta", 2), DOUBLED_ANGLES, SQUARE),
    (0, 1, 2, 3),
    metrics.r_euler,
    "r = 0 or sin(Theta) = 0 (D1 = D2 or D1 = -D2)",
)
ELLIPTIC = elliptic(ROOT2)
PARABOLIC = Chart(
    "parabolic",
    ("xi", "delta", "eta", "gamma"),
    (*PLANES, Conformal(0, 2, _parabola, _parabola_slope, _parabola_inverse)),
    (0, 2, 1, 3),
    metrics.parabolic,
    "the focus D1 = D2 = 0 (xi = delta = 0) or alpha = 0 (xi^2 = delta^2) or beta = 0 (xi delta = 0)",
)
EXPONENTIAL = Chart(
    "exponential", ("a", "b", "phi", "psi"), (*_D1_D2, HALF_TURNS, *LOGARITHMS), (0, 2, 3, 1), metrics.exponential, _DET
)
DELTA_B = Chart(
    "delta-b",
    ("delta", "b", "Phi", "Psi"),
    (*_D1_D2, DOUBLED_ANGLES, *LOGARITHMS, DILATATION),
    (0, 2, 1, 3),
    metrics.delta_b,
    _DET,
)
CARTESIAN = Chart("Cartesian", ("x", "y", "z", "u"), ELEMENTS, (0, 1, 3, 2), metrics.cartesian, "nowhere")
SPHERICAL = Chart(
    "spherical",
    ("r", "lambda", "mu", "nu"),
    (
        *ELEMENTS,
        PolarStep(0, 1, "r sin(lambda) cos(mu)", "p_nu"),
        PolarStep(0, 3, "r sin(lambda)", "p_mu", wrap=False),
        PolarStep(2, 0, "r", "p_lambda"),
    ),
    (2, 0, 3, 1),
    metrics.spherical,
    "r = 0, sin(lambda) = 0 (x = y = z = 0) or cos(mu) = 0 (x = y = 0)",
)
SPHERICAL_CARTESIAN = Chart(
    "spherical-Cartesian",
    ("R", "theta", "chi", "u"),
    (*ELEMENTS, PolarStep(0, 1, "R sin(theta)", "p_chi"), PolarStep(3, 0, "R", "p_theta")),
    (3, 0, 1, 2),
    metrics.spherical_cartesian,
    "R = 0 (x = y = z = 0) or sin(theta) = 0 (x = y = 0)",
)
POLAR_POLAR = Chart(
    "polar-polar",
    ("r1", "chi1", "r2", "chi2"),
    (*ELEMENTS, PolarStep(0, 1, "r1", "p_chi1"), PolarStep(3, 2, "r2", "p_chi2")),
    (0, 1, 3, 2),
    metrics.polar_polar,
    "r1 = 0 (x = y = 0) or r2 = 0 (z = u = 0)",
)
POLAR_CARTESIAN = Chart(
    "polar-Cartesian",
    ("r1", "chi1", "z", "u"),
    (*ELEMENTS, PolarStep(0, 1, "r1", "p_chi1")),
    (0, 1, 3, 2),
    metrics.polar_cartesian,
    "r1 = 0 (x = y = 0)",
)

CHARTS: dict[str, Chart] = {
    chart.name: chart
    for chart in (
        CARTESIAN,
        TWO_POLAR,
        ALPHA_BETA,
        ALPHA_BETA_PHI_PSI,
        R_VARTHETA,
        R_VARTHETA_ETA_GAMMA,
        RHO_VARTHETA,
        RHO_EPSILON,
        EULER,
        R_EULER,
        ELLIPTIC,
        PARABOLIC,
        bipolar(1.0),
        EXPONENTIAL,
        DELTA_B,
        SPHERICAL,
        SPHERICAL_CARTESIAN,
        POLAR_POLAR,
        POLAR_CARTESIAN,
    )
}
