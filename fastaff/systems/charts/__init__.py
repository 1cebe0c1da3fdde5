"""Convert between matrices, planes and the paper's charts of GL(2,R), both ways, with velocities and momenta.

A phase point `z` has rows a1, a2, b1, b2, then their momenta: the planes a = (x + u, z - y)/sqrt2 and
b = (x - u, y + z)/sqrt2 of phi = [[x, y], [z, u]], an orthogonal and so canonical change of the matrix elements.
It is regular everywhere. The charts are for users. Each is a chain of steps: plane polar coordinates, a sum and
difference, a function of one coordinate, a conformal map of the plane of invariants.

    a = alpha (cos eta, sin eta),   b = beta (cos gamma, sin gamma),   (alpha, beta) = sqrt(r) (cos, sin)(vartheta/2)
    D1, D2 = (alpha +- beta)/sqrt2,   phi = (eta + gamma)/2,   psi = (gamma - eta)/2

| chart | coordinates | relation |
|---|---|---|
| TWO_POLAR | D1, D2, phi, psi | phi = O(phi) diag(D1, D2) O(psi)^T |
| ALPHA_BETA, ALPHA_BETA_PHI_PSI | alpha, beta, eta, gamma (phi, psi) | above |
| R_VARTHETA, R_VARTHETA_ETA_GAMMA | r, vartheta, phi, psi (eta, gamma) | above |
| RHO_VARTHETA, RHO_EPSILON | rho, vartheta (epsilon), eta, gamma | rho = sqrt(r), epsilon = vartheta/2 |
| EULER, R_EULER | rho (r), Phi, Theta, Psi | Theta = vartheta, Phi = 2 phi, Psi = -2 psi |
| EXPONENTIAL | a, b, phi, psi | D1, D2 = e^{(a +- b)/2} |
| DELTA_B | delta, b, Phi, Psi | delta = e^{a/2} = sqrt(D1 D2) |
| ELLIPTIC, elliptic(focus) | kappa, lambda, eta, gamma | alpha + i beta = focus cosh(kappa + i lambda), focus = sqrt2 |
| PARABOLIC | xi, delta, eta, gamma | alpha + i beta = (xi + i delta)^2/2 |
| bipolar(c) | e, f, eta, gamma | alpha, beta = c (sinh e, sin f)/(cosh e - cos f) |
| CARTESIAN | x, y, z, u | the matrix elements |
| SPHERICAL | r, lambda, mu, nu | x, y = r sin(lambda) cos(mu) (cos, sin)(nu), z = r sin(lambda) sin(mu), u = r
cos(lambda) |
| SPHERICAL_CARTESIAN | R, theta, chi, u | x, y = R sin(theta) (cos, sin)(chi), z = R cos(theta): R^3 x R |
| POLAR_POLAR, POLAR_CARTESIAN | r1, chi1, r2, chi2 (z, u) | (x, y) = r1 (cos, sin)(chi1), (z, u) = r2 (cos, sin)(chi2):
R^2 x R^2 |

CHARTS has all of them by name (bipolar with c = 1). The Euler angles have Psi = -2 psi, which gives the cross term of
EQ6.4 its usual sign; with +2 psi, the other convention of section 3, it would be -2 cos(Theta) dPhi dPsi.

Conventions. One matrix has many coordinates: (D1, D2, phi, psi), (D2, D1, phi + pi/2, psi + pi/2), (D1, D2, phi + pi,
psi + pi) and (-D1, -D2, phi + pi, psi) are the same phi. So the exchange D1 <-> D2 is beta -> -beta, gamma -> gamma +
pi; the third is one turn of gamma; the fourth is alpha, beta -> -alpha, -beta, eta + pi, gamma + pi. `to_planes` and
every other method that starts from coordinates takes any sheet: negative radii, any turn of an angle. `from_planes`
returns the canonical sheet: alpha, beta >= 0; eta, gamma in [0, 2 pi); hence D1 >= |D2| with the sign of det phi =
D1 D2 (det phi < 0 is vartheta > pi/2 and beta > alpha), vartheta in [0, pi], b >= 0, kappa >= 0, lambda in [0, pi/2],
xi >= delta >= 0, e >= 0, f in [0, pi] and, of the two pairs (phi, psi) ~ (phi + pi, psi + pi) of one matrix, the one
with phi in [0, 2 pi), psi in (-pi, pi); Phi in [0, 4 pi), Psi in (-2 pi, 2 pi). In SPHERICAL lambda is in [0, pi], mu
in [-pi/2, pi/2]. Rotations and reflections: `rotate`, `reflect_space`, `reflect_body`.

Polar coordinates are singular where the radius is 0. There the angle is that of the momentum, so that p_radius =
|momentum| and p_angle = 0 exactly, the limit along the straight motion through that point, and the inverse returns the
phase point. If the momentum is 0 too, the angle is 0. So at beta = 0 (D1 = D2, vartheta = 0): gamma = arg p_b, p_beta =
|p_b|, p_gamma = 0; likewise for eta at alpha = 0 (D1 = -D2, vartheta = pi). At rho = 0 epsilon = arg(p_alpha, p_beta),
p_epsilon = 0, and p_r = p_rho/(2 sqrt(r)) is +inf (0 for a body at rest): only this value is infinite, with no inverse.
Velocities have the same limits, with every rate of an angle 0 (and dr/dt = 0 at r = 0).

Other singular sets. At the focus of ELLIPTIC (alpha = focus, beta = 0: the undeformed state) and of PARABOLIC
(alpha = beta = 0) the derivative of the map is 0: the momenta of the two coordinates have the limit 0, which
`from_planes` returns and `to_planes` refuses, as it has no inverse; their rates are infinite and refused except for a
body at rest. The pole of bipolar(c) (alpha = c, beta = 0) and, for EXPONENTIAL and DELTA_B, det phi <= 0 are outside of
the chart. Each refusal is a ValueError that names the set and the orbit. `metric` and `density` are defined on singular
sets wherever they are finite; `inverse_metric` needs density > 0.

Rounding: a round trip returns z to a few units of rounding of each plane in ALPHA_BETA. The charts that mix alpha and
beta keep the smaller one only to the digits of the larger one. Near a singular set they return momenta to eps |p|
sqrt(r)/min(alpha, beta), and a radius below eps sqrt(r) becomes 0 (`to_planes` then refuses an angular momentum that is
not 0). At distance d from a focus of ELLIPTIC the error is larger by a factor sqrt(focus/d).

Source: Martens, Slawianowski, "Affinely-Rigid Body and Oscillatory Dynamical Models on GL(2,R)", labels as cited.
"""

from ...engine.values import tell_apart
from .catalogue import (
    ALPHA_BETA,
    ALPHA_BETA_PHI_PSI,
    CARTESIAN,
    CHARTS,
    DELTA_B,
    ELLIPTIC,
    EULER,
    EXPONENTIAL,
    PARABOLIC,
    POLAR_CARTESIAN,
    POLAR_POLAR,
    R_EULER,
    R_VARTHETA,
    R_VARTHETA_ETA_GAMMA,
    RHO_EPSILON,
    RHO_VARTHETA,
    SPHERICAL,
    SPHERICAL_CARTESIAN,
    TWO_POLAR,
    bipolar,
    elliptic,
)
from .chart import Chart
from .invariants import (
    AngularMomenta,
    Deformation,
    angular_momenta,
    b_of_vartheta,
    deformation,
    from_matrix,
    reflect_body,
    reflect_space,
    rotate,
    to_matrix,
    vartheta_of_b,
)
from .stretches import TwoPolar3, from_two_polar3, two_polar3

__all__ = [
    "ALPHA_BETA",
    "ALPHA_BETA_PHI_PSI",
    "CARTESIAN",
    "CHARTS",
    "DELTA_B",
    "ELLIPTIC",
    "EULER",
    "EXPONENTIAL",
    "PARABOLIC",
    "POLAR_CARTESIAN",
    "POLAR_POLAR",
    "RHO_EPSILON",
    "RHO_VARTHETA",
    "R_EULER",
    "R_VARTHETA",
    "R_VARTHETA_ETA_GAMMA",
    "SPHERICAL",
    "SPHERICAL_CARTESIAN",
    "TWO_POLAR",
    "AngularMomenta",
    "Chart",
    "Deformation",
    "TwoPolar3",
    "angular_momenta",
    "b_of_vartheta",
    "bipolar",
    "deformation",
    "elliptic",
    "from_matrix",
    "from_two_polar3",
    "reflect_body",
    "reflect_space",
    "rotate",
    "to_matrix",
    "two_polar3",
    "vartheta_of_b",
]

tell_apart(__name__)
