"""Resolution of a potential: partitions of an interval on whose panels it equals its interpolant.

An interval is halved until on every panel the potential agrees with the polynomial through a few of its points, at many
others.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .singular_ends import sampled

ORDER = 12
"""Points of the polynomial that is compared with a potential on a panel."""
DENSE = 1 << 15
"""Points of an interval at which a potential of one variable is evaluated: half a step resolves a Gaussian of 4e-6 of
the interval.
"""
FEWEST = 48
"""Points at which V is evaluated on a panel, however short it is."""
MISS = 1e-8
"""Distance of a potential from its polynomial, relative to |V| and to the energies of the levels, below which a panel
resolves it.
"""
SHORTEST = 2.0**-30
"""Shortest panel, relative to the interval; its remaining misfit counts as error."""
SPAN = 2.0**-13
"""Panels at the ends of an interval are not cut below this part of it: singular ends are in the exponents of the basis.
"""
SCATTERED = 1 << 18
"""Points of a rectangle at which a potential is compared with its panels: they find a Gaussian of 1e-3 of the sides."""
BETWEEN = 1e-6
"""The same as MISS at these points."""
WAVES = 7.0
"""Phase of the shortest wave over one element."""


class Panels(NamedTuple):
    """Edges (panels + 1,) of a partition of an interval, and the difference of a potential from its polynomial on each
    panel (panels,).
    """

    edges: np.ndarray
    missed: np.ndarray

    @property
    def needed(self) -> int:
        """Nodes of a global Gauss rule that is as dense as the panels' own points, away from the ends.

        n of its nodes are pi sqrt(d d')/n apart at distances d, d' from the ends; panels graded to a singular end do
        not count.
        """
        lo = self.edges[:-1]
        hi = self.edges[1:]
        h = np.diff(self.edges)
        d = lo - self.edges[0]
        other = self.edges[-1] - hi
        inside = np.minimum(d, other) > 4 * h
        dense = np.pi * np.sqrt((d + h / 2) * (other + h / 2)) * ORDER / (2 * h)
        return int(dense[inside].max()) if inside.any() else 0

    @property
    def points(self) -> np.ndarray:
        """Return some points (panels, ORDER) of every panel."""
        return self.edges[:-1, None] + np.diff(self.edges)[:, None] * chebyshev(FEWEST)[0]

    def place(self, at: np.ndarray) -> np.ndarray:
        """Return the numbers of the panels that hold given points."""
        return np.clip(np.searchsorted(self.edges, at, "right") - 1, 0, self.missed.size - 1)

    def missing(self, at: np.ndarray, miss: np.ndarray) -> Panels:
        """Return the same partition with the misfits of a potential at further points."""
        missed = self.missed.copy()
        np.maximum.at(missed, self.place(at), miss)
        return Panels(self.edges, missed)

    def cut(self, phases: np.ndarray) -> Panels:
        """Return the partition, of at least two, with panels cut where the phases (panels,) of waves over them are
        above WAVES.
        """
        pieces = np.clip(np.ceil(phases / WAVES), 1 + (phases.size == 1), 10_000).astype(int)
        parts = [
            np.linspace(a, b, n, endpoint=False)
            for a, b, n in zip(self.edges[:-1], self.edges[1:], pieces, strict=True)
        ]
        return Panels(np.append(np.concatenate(parts), self.edges[-1]), np.repeat(self.missed, pieces))


def merged(first: Panels, second: Panels) -> Panels:
    """Return the common refinement of two partitions of an interval by halves."""
    edges = np.union1d(first.edges, second.edges)
    middle = (edges[1:] + edges[:-1]) / 2
    missed = [part.missed[np.searchsorted(part.edges, middle) - 1] for part in (first, second)]
    return Panels(edges, np.maximum(*missed))


_PHASES = np.pi * (np.arange(ORDER) + 0.5) / ORDER
_NODES = (1 - np.cos(_PHASES)) / 2, (-1.0) ** np.arange(ORDER) * np.sin(_PHASES)
"""Chebyshev points in (0, 1), and their barycentric weights."""


@lru_cache(maxsize=64)
def chebyshev(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return ORDER Chebyshev points in (0, 1) and the matrix (points, ORDER) from values there to values in the middles
    of equal parts.
    """
    return _NODES[0], barycentric(*_NODES, (np.arange(points) + 0.5) / points)


def barycentric(nodes: np.ndarray, weights: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the values (points, nodes) of the cardinal polynomials of `nodes` with barycentric weights."""
    distance = at[:, None] - nodes
    hit = distance == 0
    terms = weights / np.where(hit, 1.0, distance)
    struck = hit.any(axis=1)
    terms[struck] = hit[struck]
    return terms / terms.sum(axis=1, keepdims=True)


def panels(
    V: Callable[[np.ndarray], np.ndarray],
    lo: float,
    hi: float,
    low: float,
    scale: float,
    dense: int,
    most: int,
    thin: np.ndarray | None = None,
) -> Panels:
    """Return a partition of (lo, hi) on which V is resolved, or of `most` panels.

    V(points) -> (..., points), rows of potentials at once; low, scale: the bottom, and the energy of the levels above
    it; dense: a power of 2, the number of equidistant points at which V is first evaluated; thin: intervals (2, k) with
    narrow features.
    """
    thin = np.empty((2, 0)) if thin is None else thin
    left = np.array([lo])
    width = hi - lo
    depth = 0
    seen = sampled(V, lo + width * (np.arange(dense) + 0.5) / dense)[..., None, :]
    done: list[tuple[np.ndarray, np.ndarray]] = []
    while True:
        inner = sampled(V, (left[:, None] + width * chebyshev(FEWEST)[0]).ravel())
        inner = inner.reshape(*inner.shape[:-1], left.size, ORDER)
        with np.errstate(invalid="ignore", over="ignore"):
            miss, part = _misses(inner, seen, low, scale)
        at_end = (left == lo) | (left >= hi - 1.5 * width) & (width <= SPAN * (hi - lo))
        missed = np.where((part > MISS) & ~at_end, miss, 0.0)
        rough = (missed > 0) | (part > MISS) & (width > SPAN * (hi - lo))
        hidden = _holding(left, width, thin, width / seen.shape[-1]) & (~at_end | (width > SPAN * (hi - lo)))
        rough = (rough | hidden) & (width > SHORTEST * (hi - lo))
        if sum(row.size for row, _ in done) + left.size + rough.sum() > most:
            rough[:] = False
        missed = np.where(hidden & ~rough, np.inf, missed)
        done.append((left[~rough], missed[~rough]))
        if not rough.any():
            break
        depth = depth + 1
        width = width / 2
        left = np.stack([left[rough], left[rough] + width], axis=1).ravel()
        seen = seen[..., rough, :]
        if seen.shape[-1] >= 2 * FEWEST:
            seen = seen.reshape(*seen.shape[:-2], left.size, -1)
        else:
            seen = sampled(V, (left[:, None] + width * (np.arange(FEWEST) + 0.5) / FEWEST).ravel())
            seen = seen.reshape(*seen.shape[:-1], left.size, FEWEST)
    edges, missed = (np.concatenate(rows) for rows in zip(*done, strict=True))
    order = np.argsort(edges)
    return Panels(np.append(edges[order], hi), missed[order])


def _holding(left: np.ndarray, width: float, thin: np.ndarray, step: float) -> np.ndarray:
    """Return a mask of panels that hold the middle of a thin interval that samples a step apart may miss."""
    narrow = thin.mean(axis=0)[np.diff(thin, axis=0)[0] < 2 * step]
    place = np.searchsorted(left, narrow, "right") - 1
    inside = (place >= 0) & (narrow < left[place] + width)
    return np.isin(np.arange(left.size), place[inside])


def between(
    V: Callable[..., np.ndarray], parts: tuple[Panels, Panels], low: float, scale: float, share: Callable
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (2, k) of a rectangle where V differs from its polynomial on the products of the panels, and the
    misfits (k,).

    V(x, y) of arrays of one shape; share(x): the weight of a misfit there. The points are scattered evenly, those of
    the largest misfit come first; panels of the least length at the ends are left out.
    """
    unit = (np.arange(SCATTERED)[None] * np.array([[0.7548776662466927], [0.5698402909980532]]) + 0.5) % 1
    at = np.array(
        [part.edges[0] + (part.edges[-1] - part.edges[0]) * row for part, row in zip(parts, unit, strict=True)]
    )
    place = [part.place(row) for part, row in zip(parts, at, strict=True)]
    kept = np.ones(SCATTERED, bool)
    for part, panel in zip(parts, place, strict=True):
        short = np.diff(part.edges) <= 1.01 * SPAN * (part.edges[-1] - part.edges[0])
        short[1:-1] = False
        kept &= ~short[panel]
    at = at[:, kept]
    i, j = (panel[kept] for panel in place)
    x, y = (part.points for part in parts)
    nodes = sampled(lambda y: V(x.reshape(-1, 1), y), y.ravel()).reshape(*x.shape, *y.shape)
    rows = [
        barycentric(*_NODES, (row - part.edges[panel]) / np.diff(part.edges)[panel])
        for part, row, panel in zip(parts, at, (i, j), strict=True)
    ]
    seen = sampled(lambda y: V(at[0], y), at[1])
    inner = np.empty(at.shape[1])
    for begin in range(0, inner.size, 1 << 13):
        some = slice(begin, begin + (1 << 13))
        inner[some] = np.einsum("pa,pab,pb->p", rows[0][some], nodes[i[some], :, j[some]], rows[1][some])
    with np.errstate(invalid="ignore", over="ignore"):
        miss = np.abs(inner - seen)
        weighed = miss * share(at[0])
        found = np.flatnonzero(weighed > BETWEEN * (np.abs(seen - low) + scale))
    order = found[np.argsort(-weighed[found], kind="stable")]
    return at[:, order], miss[order]


def _misses(inner: np.ndarray, seen: np.ndarray, low: float, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest misfits of V on panels, absolute and relative: values inner (..., panels, ORDER), seen (...,
    panels, points).

    A few of the points come first, and all of them if these find none.
    """
    points = seen.shape[-1]
    few = seen[..., :: max(seen.shape[-1] // 1024, 1)]
    if few.shape[-1] < points:
        miss, part = _largest(inner @ chebyshev(points)[1][:: points // few.shape[-1]].T, few, low, scale)
        rest = part <= MISS
        if rest.any():
            miss[rest], part[rest] = _largest(
                inner[..., rest, :] @ chebyshev(points)[1].T, seen[..., rest, :], low, scale
            )
        return miss, part
    return _largest(inner @ chebyshev(points)[1].T, seen, low, scale)


def _largest(V: np.ndarray, seen: np.ndarray, low: float, scale: float) -> tuple[np.ndarray, np.ndarray]:
    V -= seen
    np.abs(V, out=V)
    miss = V.max(axis=-1)
    V /= np.abs(seen - low) + scale
    part = V.max(axis=-1)
    sizes = (np.where(np.isnan(x), np.inf, x).reshape(-1, seen.shape[-2]).max(axis=0) for x in (miss, part))
    return next(sizes), next(sizes)
