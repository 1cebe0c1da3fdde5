"""Levels of bodies that separate in the elliptic chart: two equations with two common eigenvalues.

With s = sinh^2(kappa), t = sin^2(lambda) and L = H - K the separated operators of section 3 give, for one class,

    (h_kappa - 2 E s) f = 2 L f,    (h_lambda - 2 E t) g = -2 L g.

Let sigma_i(E) and tau_j(E) be the eigenvalues of the left sides. Both fall as E grows, by -2<s> and -2<t>, so every
pair (i, j) has exactly one level, where sigma_i(E) + tau_j(E) = 0 (Klein's oscillation theorem), and the number of
levels below E is the number of pairs with a negative sum. Newton's method for E is the Rayleigh quotient

    E = (<h_kappa> + <h_lambda>)/(2 (<s> + <t>))

of the product f g. Source: Martens & Slawianowski, h_kappa and h_lambda of section 3 (corrected, quantized); Atkinson &
Mingarelli 2010, Multiparameter Eigenvalue Problems (oscillation theorem).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...systems.charts import R_VARTHETA, Chart
from .convergence import near_end, powers_of, until_equal
from .cover import Cover, line_cover
from .factor_tables import IntervalFunctions, angle_of
from .jacobi_basis import Basis, IntervalFunction, ProblemEnds, basis, interval_rule
from .panels import DENSE, panels
from .singular_ends import NoGroundState, decayed, exponent, sampled, well

FARTHEST = 30.0
"""Largest kappa: r = 2e25, beyond any bound state of numbers in a range of 1e12."""

RADII = 6001
"""Samples of either coordinate in the search for the reach of states."""

SHORT = 0.01
"""Part of an interval, at its end, in which the smoothness of V is examined."""

GLOBAL = 400
"""Nodes of one interval beyond which a potential is not resolved by one polynomial."""

LARGEST_GLOBAL = 600
"""Functions of kappa at most."""

GUESSES = 16
"""Energies at which sums of eigenvalues give the first levels."""

FEWEST = 24
"""Functions of lambda at least."""

PANELS = 800
"""Panels of an interval at most."""

APART = 0.3
"""Least s + t of places where the search for levels begins: the focus, s + t = 0, may be singular."""

SPARE = 3
"""Levels more than are asked for, as neighbours of the highest."""

STEPS = 40
"""Newton steps at most; two are enough from the levels of another basis."""

CLOSE = 1e-9
"""Relative change of E at which Newton's method ends: the error of a Rayleigh quotient is its square."""

NEAREST = 1e-9
"""Least relative step in the search for an energy with enough levels."""

SERIES = 1.0
"""Argument below which sinh(x) - x and x - sin(x) are summed as series."""

NEAR = 0.05
"""Least distance from an end, in parts of the interval, at which the strength of a singularity is sampled."""

AGREE = 1e-6
"""Largest relative difference of two values of this strength."""

TINY = 1e-100
"""Least distance from an end at which factors with a square root are evaluated."""


class Unresolved(Exception):
    """Signal that a potential has walls or features too narrow for one polynomial in each coordinate."""


def _excess(x: np.ndarray, sign: float) -> np.ndarray:
    """Return sinh(x) - x for sign = 1, x - sin(x) for sign = -1, without cancellation."""
    term = x**3 / 6
    total = term
    for k in range(2, 12):
        term = term * sign * x * x / ((2 * k) * (2 * k + 1))
        total = total + term
    with np.errstate(over="ignore", invalid="ignore"):
        return np.where(x < SERIES, total, np.sinh(x) - x if sign > 0 else x - np.sin(x))


def _strength(U: Callable, end: float, way: float) -> float:
    """Return the limit of d^2 U at an end, d = way (x - end); 0 unless two extrapolations agree.

    Nodes keep away from the end, where functions of sin^2 or cos^2 lose digits as 1/d^2.
    """
    n = 14
    angle = np.pi * (np.arange(n) + 0.5) / n
    node = np.cos(angle)
    limits = []
    for longest in (0.8, 0.5):
        d = longest * (NEAR + (1 - NEAR) * (1 + node) / 2)
        outside = -1 - 2 * NEAR / (1 - NEAR)
        weight = (-1.0) ** np.arange(n) * np.sin(angle) / (outside - node)
        limits.append(float((weight * d**2 * sampled(U, end + way * d)).sum() / weight.sum()))
    return limits[0] if abs(limits[0] - limits[1]) <= AGREE * abs(limits[0]) else 0.0


class _EllipticLine(NamedTuple):
    """One separated equation -u'' + (U + centrifugal - 2 E q) u = value u of u = f sqrt(measure), in units of
    hbar^2/(2 mu).

    sign: +1 for kappa, q = sinh^2, measure = sinh(2 kappa); -1 for lambda, q = sin^2, measure = sin(2 lambda). a, b:
    quanta of eta and gamma; U: the potential; c_lo, c_hi: limits of distance^2 U at the natural ends.
    """

    name: str
    U: Callable
    sign: int
    a: float
    b: float
    c_lo: float
    c_hi: float

    @property
    def e_lo(self) -> float:
        """Exponent of u at 0."""
        return exponent(self.name, self.b**2 - 0.25 + self.c_lo, "at 0")

    @property
    def e_hi(self) -> float:
        """Exponent of u at the outer end: that of alpha = 0 for lambda = pi/2, of a wall for kappa."""
        return 1.0 if self.sign > 0 else exponent(self.name, self.a**2 - 0.25 + self.c_hi, "at pi/2")

    def sine(self, x: Any) -> Any:
        """Return sinh(kappa) or sin(lambda)."""
        return np.sinh(x) if self.sign > 0 else np.sin(x)

    def cosine(self, x: Any) -> Any:
        """Return cosh(kappa) or cos(lambda)."""
        return np.cosh(x) if self.sign > 0 else np.cos(x)

    def whole(self, x: Any, E: float) -> Any:
        """Return the potential with the centrifugal terms of Langer, for numbers or intervals."""
        square = np.square(self.sine(x))
        turns = self.b**2 / square if self.b else 0.0
        far = self.a**2 / np.square(self.cosine(x)) if self.a else 0.0
        return self.U(x) + turns - self.sign * far - (2 * E) * square

    def remainder(self, base: Basis) -> np.ndarray:
        """Return the potential at the nodes of a basis less the terms that its weight takes."""
        x, low, high = base.x, base.below, base.above
        e0, e1 = self.e_lo, self.e_hi
        # 1/sinh^2 - 1/x^2 and 1/sin^2 - 1/x^2 without cancellation
        gap = -self.sign * _excess(x, self.sign) * (x + self.sine(x)) / (x * self.sine(x)) ** 2
        q = sampled(self.U, x) - self.c_lo / x**2 + (self.b**2 - 0.25) * gap + self.sign
        if self.sign > 0:
            q = q - (self.a**2 - 0.25) / np.cosh(x) ** 2 - e1 * (e1 - 1) / high**2
        else:
            gap = _excess(high, -1) * (high + np.sin(high)) / (high * np.sin(high)) ** 2
            q = q - self.c_hi / high**2 + (self.a**2 - 0.25) * gap
        return q + 2 * e0 * e1 / (low * high)


class _LineMatrices(NamedTuple):
    """Matrices of one line in one basis: h, that of q = sinh^2 or sin^2, and both at the nodes."""

    base: Basis
    potential: np.ndarray
    square: np.ndarray
    h: np.ndarray
    weighted: np.ndarray

    def values(self, E: float) -> np.ndarray:
        """Return all sigma or tau at E."""
        return np.linalg.eigvalsh(self.h - 2 * E * self.weighted)

    def vectors(self, E: np.ndarray, which: np.ndarray) -> np.ndarray:
        """Return eigenvectors (levels, n), the one of each level by number, positive near 0."""
        from scipy.linalg import eigh

        out = np.empty((E.size, len(self.h)))
        for energy in np.unique(E):
            some = np.flatnonzero(energy == E)
            first, last = int(which[some].min()), int(which[some].max())
            matrix = self.h - 2 * energy * self.weighted
            vectors = eigh(matrix, subset_by_index=(first, last), driver="evr", check_finite=False)[1]
            out[some] = vectors[:, which[some] - first].T
        f = out @ self.base.values[0].T
        density = self.base.weight[0] * f**2
        first = np.argmax(density > 1e-8 * density.max(axis=1, keepdims=True), axis=1)
        return out * np.sign(np.take_along_axis(f, first[:, None], axis=1))

    def means(self, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return <h>, <q> and the mean of the sizes of the terms of h: sums over nodes, accurate to rounding."""
        base = self.base
        weight = base.weight[0]
        f = vectors @ base.values[0].T
        slope = vectors @ base.slopes[0].T
        norm = (weight * f**2).sum(axis=1)
        kinetic = (weight * slope**2).sum(axis=1) / norm
        density = weight * f**2 / norm[:, None]
        sizes = kinetic + (density * np.abs(self.potential)).sum(axis=1)
        return kinetic + (density * self.potential).sum(axis=1), (density * self.square).sum(axis=1), sizes


def _line_matrices(line: _EllipticLine, n: int, hi: float) -> _LineMatrices:
    """Return the matrices of a line on (0, hi) with n functions."""
    ends = ProblemEnds(0.0, hi, np.array([line.e_lo]), np.array([line.e_hi]), True, True)
    base = basis(ends, n, 16)
    potential = line.remainder(base)
    if not np.isfinite(potential).all():
        raise Unresolved
    square = line.sine(base.x) ** 2
    h = base.matrix(potential, np.ones_like(potential))[0]
    weighted = base.matrix(square, np.zeros_like(square))[0]
    return _LineMatrices(base, potential[0], square[0], h, weighted)


@dataclass
class _TwoLines:
    """The two equations of a class, and their solution in bases of any size."""

    kappa: _EllipticLine
    lam: _EllipticLine
    count: int
    wall: float = np.inf
    bottom: float = 0.0
    known: dict[tuple[int, int], float] = field(default_factory=dict)

    def samples(self) -> tuple[np.ndarray, np.ndarray]:
        """Return places of both coordinates, of all sizes."""
        kappa = np.geomspace(1e-6, min(self.wall, FARTHEST), RADII)
        half = np.geomspace(1e-6, math.pi / 4, RADII // 2)
        return kappa, np.concatenate([half, math.pi / 2 - half[-2::-1]])

    def tops(self, E: float) -> tuple[np.ndarray, np.ndarray, float, float]:
        """Return both potentials at the samples, and upper bounds of sigma and tau of levels up to E."""
        y, x = self.samples()
        W, w = sampled(lambda q: self.kappa.whole(q, E), y), sampled(lambda q: self.lam.whole(q, E), x)
        # No eigenvalue is below the least value of its potential, and sigma_i = -tau_j.
        return W, w, float(-w.min()), float(-W.min())

    def reach(self, E: float) -> tuple[float, int, int]:
        """Return the largest kappa of levels up to E, and the numbers of nodes that resolve them in both lines."""
        y, x = self.samples()
        W, w, top, other = self.tops(E)
        far = decayed("V_kappa", y, W, top, 0.0, self.wall)[1]
        waves = np.maximum(top - W, 0) * y * np.maximum(far - y, 0)
        around = np.maximum(other - w, 0) * x * (math.pi / 2 - x)
        return far, int(1.3 * math.sqrt(waves.max())) + 24, int(1.3 * math.sqrt(around.max())) + 24

    def below(self, E: float) -> int:
        """Return the number of levels below E, in a basis that resolves them."""
        far, n, m = self.reach(E)
        if max(n, m) > GLOBAL:
            raise Unresolved
        sigma = _line_matrices(self.kappa, n, far).values(E)
        tau = _line_matrices(self.lam, m, math.pi / 2).values(E)
        return int(np.count_nonzero(sigma[:, None] + tau < 0))

    def top(self, bottom: float) -> float:
        """Return an energy with more than `count` levels below it, but not many more."""
        step = 1.0
        low = bottom
        limited = False
        while self.below(low) >= self.count + SPARE:
            low, step = low - step, 2 * step
        self.bottom = low
        while True:
            try:
                found = self.below(low + step)
            except NoGroundState:  # above the limit of V
                limited, step = True, step / 2
                if step < NEAREST * max(1.0, abs(low)):
                    raise Unresolved from None
                continue
            if found >= self.count + SPARE:
                break
            low, step = low + step, step if limited else 2 * step
        high = low + step
        while found > 1.3 * self.count + 2 * SPARE and high - low > NEAREST * max(1.0, abs(high)):
            middle = (low + high) / 2
            now = self.below(middle)
            if now < self.count + SPARE:
                low = middle
            else:
                high, found = middle, now
        return high

    def guesses(
        self, lines: tuple[_LineMatrices, _LineMatrices], top: float, i: np.ndarray, j: np.ndarray
    ) -> np.ndarray:
        """Return first energies of levels: those of another basis, or from sums of eigenvalues at a few energies."""
        pairs = list(zip(i.tolist(), j.tolist(), strict=True))
        if all(pair in self.known for pair in pairs):
            return np.array([self.known[pair] for pair in pairs])
        energies = np.linspace(self.bottom, top, GUESSES)
        sigma, tau = (np.array([line.values(E) for E in energies]) for line in lines)
        # sums fall with the energy
        return np.array([np.interp(0.0, -(sigma[:, p] + tau[:, q]), energies) for p, q in pairs])

    def solve(self, top: float, n: int, m: int, hi: float) -> tuple[Any, tuple[np.ndarray, Any]]:
        """Return bases of n and m functions up to kappa = hi, the levels below `top`, ascending, and their vectors."""
        lines = _line_matrices(self.kappa, n, hi), _line_matrices(self.lam, m, math.pi / 2)
        i, j = np.nonzero(lines[0].values(top)[:, None] + lines[1].values(top) < 0)
        E = self.guesses(lines, top, i, j)
        low, high = np.full(i.size, -np.inf), np.full(i.size, np.inf)
        f, g = np.empty((i.size, len(lines[0].h))), np.empty((i.size, len(lines[1].h)))
        size = np.zeros(i.size)
        todo = np.arange(i.size)
        for _ in range(STEPS):
            f[todo] = lines[0].vectors(E[todo], i[todo])
            g[todo] = lines[1].vectors(E[todo], j[todo])
            (h, s, large), (k, t, larger) = lines[0].means(f[todo]), lines[1].means(g[todo])
            better = (h + k) / (2 * (s + t))
            size[todo] = (large + larger) / (2 * (s + t))
            change = np.abs(better - E[todo])
            # the sum of both eigenvalues falls with E: a negative one is above the level
            high[todo] = np.where(better < E[todo], np.minimum(high[todo], E[todo]), high[todo])
            low[todo] = np.where(better > E[todo], np.maximum(low[todo], E[todo]), low[todo])
            done = change <= CLOSE * np.maximum(np.abs(better), 1.0)
            outside = ((better <= low[todo]) | (better >= high[todo])) & ~done
            bracketed = np.isfinite(low[todo]) & np.isfinite(high[todo])
            middle = np.where(bracketed, low[todo], 0.0) / 2 + np.where(bracketed, high[todo], 0.0) / 2
            E[todo] = np.where(outside & bracketed, middle, better)
            todo = todo[~done]
            if not todo.size:
                break
        self.known = dict(zip(zip(i.tolist(), j.tolist(), strict=True), E.tolist(), strict=True))
        order = np.argsort(E, kind="stable")
        return lines, (E[None, order], _Found(i[order], j[order], f[order], g[order], size[order], not todo.size))


class _Found(NamedTuple):
    """Numbers of both coordinates, vectors of both equations, and the sizes of the terms of E; whether Newton's method
    has converged.
    """

    i: np.ndarray
    j: np.ndarray
    f: np.ndarray
    g: np.ndarray
    size: np.ndarray
    converged: bool


class EllipticLevels(NamedTuple):
    """Levels of a class: E, error (levels,), n, constants E and K (2, levels), wave functions, the size of the largest
    basis and words about the potential.
    """

    E: np.ndarray
    error: np.ndarray
    n: np.ndarray
    constants: np.ndarray
    waves: EllipticWaves
    size: int
    said: str


def elliptic_levels(
    V_kappa: Any, V_lambda: Any, a: float, b: float, count: int, hbar: float, mu: float, tolerance: float, limit: float
) -> EllipticLevels:
    """Solve the two equations of a class of quanta a = |m - l|/2, b = |m + l|/2: the lowest `count` levels.

    limit: as in `separable.radial`. Raises Unresolved where V has walls or narrow features, NoGroundState where it does
    not bind the levels.
    """
    unit = hbar**2 / (2 * mu)
    lines = []
    for name, V, sign, length in (("V_kappa", V_kappa, 1, FARTHEST), ("V_lambda", V_lambda, -1, math.pi / 2)):

        def U(x: Any, V: Any = V) -> Any:
            return V.value(x) / unit

        found = well(name, U, 0.0, length)
        if not (found.natural_lo and found.natural_hi):
            raise Unresolved
        c_hi = 0.0 if sign > 0 else _strength(U, length, -1.0)
        lines.append(_EllipticLine(name, U, sign, a, b, _strength(U, 0.0, 1.0), c_hi))
    pair = _TwoLines(lines[0], lines[1], count)
    if np.isfinite(limit):
        pair.wall = pair.reach(limit / unit)[0]
    top = pair.top(_bottom(pair))
    covers = [_cover(pair, which, top) for which in (0, 1)]
    far, n, m = pair.reach(top)
    n, m = (
        max(size, _needed(line, hi, W, cover))
        for line, size, hi, W, cover in zip(lines, (n, m), (far, math.pi / 2), pair.tops(top)[:2], covers, strict=True)
    )

    def attempt(size: int, hi: float) -> tuple[Any, tuple[np.ndarray, Any]]:
        if size > LARGEST_GLOBAL:
            raise Unresolved
        found = pair.solve(top, size, max(int(size * m / n), FEWEST), min(hi, pair.wall))
        if found[1][0].size <= count:
            raise Unresolved
        return found

    ends = [near_end(lines[0].U, 0.0, SHORT * far, 1.0)]
    ends += [near_end(lines[1].U, *end, 1.0) for end in ((0.0, SHORT), (math.pi / 2, -SHORT))]
    grow = 1.0 if far >= pair.wall else 1.05
    solved, (values, at), error, size = until_equal(attempt, max(n, 30), far, grow, count, tolerance, powers_of(*ends))
    E = values[0, :count]
    first, second = solved
    h, s, _ = first.means(at.f[:count])
    _, t, _ = second.means(at.g[:count])
    sigma = h - 2 * E * s
    lost = (covers[0].lost(sigma) + covers[1].lost(-sigma)) / (2 * (s + t))
    rounding = 16 * np.finfo(float).eps * at.size[:count]
    left = np.inf if not at.converged else 0.0
    waves = EllipticWaves(
        IntervalFunctions(first.base.interval, at.f[:count].T[None]),
        IntervalFunctions(second.base.interval, at.g[:count].T[None]),
        np.stack([at.i[:count], at.j[:count]]),
        1 / (2 * math.pi * np.sqrt(s + t)),
    )
    return EllipticLevels(
        unit * E,
        unit * (error[0] + rounding + lost + left),
        np.stack([at.i[:count], at.j[:count]]),
        unit * np.array([E, E - sigma / 2]),
        waves,
        size,
        next((cover.said for cover in covers if cover.said), ""),
    )


def _bottom(pair: _TwoLines) -> float:
    """Return the least V with centrifugal terms away from the focus, where V may be singular."""
    y, x = (q[::60] for q in pair.samples())
    W = sampled(lambda q: pair.kappa.whole(q, 0.0), y)
    w = sampled(lambda q: pair.lam.whole(q, 0.0), x)
    width = np.sinh(y)[:, None] ** 2 + np.sin(x) ** 2
    V = (W[:, None] + w) / (2 * width)
    return float(V[width > APART].min())


def _cover(pair: _TwoLines, which: int, top: float) -> Cover:
    """Return the cover of one line at the top energy; raises Unresolved where there is a well between the samples."""
    line = (pair.kappa, pair.lam)[which]
    y = pair.samples()[which]
    W, w, above, around = pair.tops(top)
    height = (above, around)[which]
    low = float((W, w)[which].min())
    inside = y[: np.searchsorted(y, 1.2 * pair.reach(top)[0])] if which == 0 else y
    seen = line_cover(lambda q: line.whole(q, top), lambda q: line.whole(q, top), inside[::40], height, height - low)
    if seen.unseen([y]).low.size:
        raise Unresolved
    return seen


def _needed(line: _EllipticLine, hi: float, W: np.ndarray, cover: Cover) -> int:
    """Return the nodes of a global rule that resolves the potential of a line on (0, hi); raises Unresolved."""
    low = float(W.min())
    scale = max(1.0 - low, 1.0)
    parts = panels(line.U, 0.0, hi, low, scale, DENSE, PANELS, cover.thin(0.0, hi, DENSE))
    if parts.needed > GLOBAL:
        raise Unresolved
    return parts.needed


@dataclass(frozen=True, repr=False)
class EllipticWaves:
    """Products of solutions of both equations: coefficients of u = f sqrt(measure), numbers (2, levels) of the levels,
    and norms.
    """

    kappa: IntervalFunctions
    lam: IntervalFunctions
    numbers: np.ndarray
    front: np.ndarray

    def __repr__(self) -> str:
        return "products of factors in kappa and lambda"

    def shape(self, n: Sequence[int]) -> EllipticShape:
        """Return the shape of the state with quantum numbers n (2,)."""
        k = int(np.flatnonzero((self.numbers == np.asarray(n)[:, None]).all(axis=0))[0])
        return EllipticShape(self.kappa.one(0, k), self.lam.one(0, k), float(self.front[k]))


class EllipticShape(NamedTuple):
    """A(r, vartheta) = front f(kappa) g(lambda) of solutions u = f sqrt(sinh(2 kappa)), u = g sqrt(sin(2 lambda))."""

    kappa: IntervalFunction
    lam: IntervalFunction
    front: float

    @property
    def chart(self) -> Chart:
        """The chart r, vartheta, in which states are integrated."""
        return R_VARTHETA

    @property
    def degrees(self) -> tuple[int, int]:
        """Return the degrees of both polynomials."""
        return self.kappa.degree, self.lam.degree

    def __call__(self, r: np.ndarray, vartheta: np.ndarray) -> np.ndarray:
        """Return A (...) at r, vartheta (...)."""
        rho = np.sqrt(r)
        half = np.asarray(vartheta) / 2
        return self.of_radii(rho * np.cos(half), rho * np.sin(half))

    def of_radii(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return A (...) at alpha, beta (...) >= 0."""
        A, B = np.square(alpha), np.square(beta)
        sigma = (A + B) / 2 - 1
        large = (np.abs(sigma) + np.sqrt(sigma**2 + 2 * B)) / 2
        small = np.where(large > 0, B / np.where(large > 0, 2 * large, 1.0), 0.0)
        s, t = np.where(sigma >= 0, large, small), np.where(sigma >= 0, small, large)
        rest = A / (2 * (1 + s))
        kappa = np.maximum(np.arcsinh(np.sqrt(s)), TINY)
        lam = np.maximum(np.arctan2(np.sqrt(t), np.sqrt(rest)), TINY)
        above = np.maximum(np.arctan2(np.sqrt(rest), np.sqrt(t)), TINY)
        f = self.kappa.at(kappa, self.kappa.hi - kappa, -0.5) * np.sqrt(kappa / np.sinh(2 * kappa))
        g = self.lam.at(lam, above, -0.5) / np.sqrt(above) * np.sqrt(lam * above / np.sin(2 * np.minimum(lam, above)))
        return self.front * f * g

    def rule(self, orders: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return Gauss nodes r (i,), vartheta (j,) and weights (i, j), up to the reach of kappa."""
        reach = math.sqrt(2) * math.cosh(self.kappa.hi)
        rho, w = interval_rule(0.0, reach, 1.5, 0.0, orders[0])
        # A falls as a power of alpha at lambda = pi/2, and of beta at lambda = 0.
        below, v = interval_rule(-1.0, 1.0, (self.lam.e_hi - 0.5) / 2, (self.lam.e_lo - 0.5) / 2, orders[1])
        return rho**2, angle_of(-1.0, 1.0, below), np.outer(np.pi**2 * w * rho**3, v)
