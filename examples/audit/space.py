"""Bodies in space, which section 3 suggests below EQ2.2h: D1^2 + D2^2 + D3^2 with a term that prevents collapse."""

from __future__ import annotations

from mpmath import mpf

from .dynamics import APART, MU
from .numerics import bracket, square
from .record import Chapter, claim

SPACE = Chapter("Section 3: bodies in space")
states = SPACE.states


def volume(D, p):
    """Return (D1 D2 D3)^-p."""
    return (D[0] * D[1] * D[2]) ** -p


def areas(D, p):
    """Return (D1 D2)^-p + (D3 D1)^-p + (D2 D3)^-p."""
    return (D[0] * D[1]) ** -p + (D[2] * D[0]) ** -p + (D[1] * D[2]) ** -p


def collapse_and_expansion(term):
    """Return the claim that C/2 |D|^2 + k term grows without bound where an axis vanishes or any becomes large."""

    def sides(rng):
        C, k, p = rng.reals(3, 0.5, 2)
        D = rng.reals(3, 0.5, 1.5)
        heights = []
        for axis in range(3):
            for extreme in (mpf(10) ** -40, mpf(10) ** 15):
                moved = [extreme if i == axis else entry for i, entry in enumerate(D)]
                heights.append(C * square(moved) / 2 + k * term(moved, p))
        return claim(min(heights) > 1e15)

    return sides


states("sec. 3, space, (D1 D2 D3)^-p", "with C/2 (D1^2 + D2^2 + D3^2) it prevents collapse, p > 0")(
    collapse_and_expansion(volume)
)
states("sec. 3, space, (D1 D2)^-p + ...", "with C/2 (D1^2 + D2^2 + D3^2) it prevents collapse, p > 0")(
    collapse_and_expansion(areas)
)


@states(
    "sec. 3, space, no separability",
    "with these terms there is no chance for separability and integrability",
    "the radius separates if the term has the degree -2: (D1 D2 D3)^-p with p = 2/3, (D1 D2)^-p + ... with p = 1",
)
def _(rng):
    C, k = rng.reals(2, 0.5, 2)
    z = [*rng.reals(3, 0.5, 1.5), *rng.reals(3)]
    found = []
    for term, degree_two in ((volume, mpf(2) / 3), (areas, mpf(1))):
        for p in (rng.real(1.2, 2), degree_two):

            def H(D1, D2, D3, *momenta, term=term, p=p):
                D = D1, D2, D3
                return square(momenta) / (2 * MU) + C * square(D) / 2 + k * term(D, p)

            def h(D1, D2, D3, *momenta, term=term, p=p):
                D = D1, D2, D3
                along = sum(a * b for a, b in zip(D, momenta))
                turning = square(D) * square(momenta) - along**2
                return turning / (2 * MU) + square(D) * k * term(D, p)

            found.append(int(abs(bracket(H, h, z)) < APART))
    return found, [0, 0, 0, 0], [0, 1, 0, 1]
