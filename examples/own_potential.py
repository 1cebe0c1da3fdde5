"""A potential and a section of one's own: two small classes of plain formulas, compiled when they are first used.

Shows the equatorial return of an Ogden-like body, V = C/2 (D1^2 + D2^2) + C/(D1 D2) + k (D1 - D2)^4, at the moments
when it is as wide as at rest, D1^2 + D2^2 = 2. In A = alpha^2 and B = beta^2: D1 D2 = (A - B)/2, D1^2 + D2^2 = A + B,
(D1 - D2)^2 = 2 B.
"""

from typing import NamedTuple

import numpy as np

import fastaff


class Stiffening(NamedTuple):
    """V = C ((A + B)/2 + 2/(A - B)) + 4 k B^2: hyperelastic, and stiffer against shear."""

    C: float = 1.0
    k: float = 0.1

    angles = fastaff.Hyperelastic.angles

    def value(self, A, B):
        """Return V."""
        return self.C * ((A + B) / 2 + 2 / (A - B)) + 4 * self.k * B * B

    def slopes(self, A, B):
        """Return V_A, V_B."""
        wall = 2 * self.C / ((A - B) * (A - B))
        return self.C / 2 - wall, self.C / 2 + wall + 8 * self.k * B

    def curvatures(self, A, B):
        """Return V_AA, V_AB, V_BB."""
        d = A - B
        w = 4 * self.C / (d * d * d)
        return w, -w, w + 8 * self.k

    def margin(self, A, B):
        """Return 2 det phi, positive where the potential lives."""
        return A - B


class SizeEquals(NamedTuple):
    """The surface D1^2 + D2^2 = constant."""

    constant: float = 2.0
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return D1^2 + D2^2 - constant."""
        return a1 * a1 + a2 * a2 + b1 * b1 + b2 * b2 - self.constant


body = fastaff.Body(Stiffening(C=1.0, k=0.2))
start = fastaff.energy_grid(
    body, energy=3.5, section=fastaff.AlphaTurning(+1), axes=(np.linspace(0.2, 0.9, 8), [0.0]), p_eta=0.3, p_gamma=0.2
).z0
found = fastaff.poincare_map(body, start, section=SizeEquals(2.0), crossings=200, max_time=2000.0)

print(f"{found.counts.sum()} crossings of {start.shape[1]} orbits: {found.summary()}")
print(
    f"largest |D1^2 + D2^2 - 2| at a crossing {found.section_error.max():.1e}, energy error "
    f"{found.energy_error.max():.1e}"
)
beta = found["beta"]
for low, high in zip(np.nanmin(beta, axis=0), np.nanmax(beta, axis=0)):
    print(f"  beta from {low:.4f} to {high:.4f}")
