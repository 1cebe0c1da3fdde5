"""A molecule of atoms with pair potentials, and the affinely-rigid body that it becomes under homogeneous deformation.

The atoms are at phi x_a, with x_a about the centre of mass. A molecule in three dimensions keeps its heights along the
axis: the body is its projection. Everything here follows from the energy of the atoms, its gradient and its Hessian;
`pair_sums` has the same energy in a form that kernels compile.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array, checked
from ...core.numbers import an_array, positive, real, shown, whole
from ...engine.values import parameters
from ..kinematics import Inertia, inertia
from ..models import Body
from .pair_sums import AveragedPairs, DirectedPairs, MolecularBody, NoPairs
from .pairs import PairPotential

SAME = 1e-12
"""Relative difference below which two distances or directions of pairs are merged."""

ISOTROPIC = 1e-9
"""Relative difference of the principal moments below which the inertia is isotropic."""

FLAT = 1e-9
"""Ratio of the principal moments below which atoms are on one line, and stretch below which they collapse to one."""

AT_REST = 1e-9
"""Largest force at an equilibrium, relative to the stiffness at the given positions times their size."""

DEGENERATE = 1e-9
"""Relative difference of squared frequencies below which modes have one frequency."""

MOST_ATOMS = 1000
"""Most atoms of a ring: the Hessian of all atoms then has 32 MB."""

STEPS = 500
"""Largest number of steps to an equilibrium."""

METHODS = ("value", "slope", "curvature")
"""Methods of a pair potential."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Homogeneous deformation of a molecule with the least energy.

    Attributes
    ----------
    phi : ndarray, shape (2, 2)
        Deformation, symmetric: a rotation does not change the energy.
    positions : ndarray, shape (2 or 3, atoms)
        Deformed positions about the centre of mass.
    energy : float
        Energy of all pairs.
    residual : float, force
        Largest force on an atom. It is 0 if the homogeneous equilibrium is an equilibrium of the atoms.
    """

    phi: Array
    positions: Array
    energy: float
    residual: float


@dataclass(frozen=True, eq=False)
class Vibrations:
    """Small homogeneous vibrations of a molecule about its equilibrium.

    Attributes
    ----------
    omega : ndarray, shape (4,), radians per unit time
        Angular frequencies in ascending order; the rotation has 0. An unstable mode has the negative root of
        ``|omega^2|``.
    modes : ndarray, shape (2, 2, 4)
        Changes of phi with ``Tr(mode^T mode J) = 1``.
    """

    omega: Array
    modes: Array


@dataclass(frozen=True, eq=False)
class MolecularModes:
    """Normal modes of all atoms about the homogeneous equilibrium.

    Attributes
    ----------
    omega : ndarray, shape (modes,), radians per unit time
        Angular frequencies in ascending order. An unstable mode has the negative root of ``|omega^2|``.
    displacements : ndarray, shape (2 or 3, atoms, modes)
        Displacements with ``sum m |u|^2 = 1``.
    overlap : ndarray, shape (modes,)
        Share of the kinetic energy of a mode in homogeneous deformations and the rotation, from 0 to 1. Their sum is 4.
        Modes of one frequency are ordered by this share.
    """

    omega: Array
    displacements: Array
    overlap: Array


@dataclass(frozen=True, eq=False)
class Molecule:
    """Atoms with pair potentials, for homogeneous deformation in a plane.

    `molecule` and `ring` make it and check the arguments.

    Attributes
    ----------
    masses : ndarray, shape (atoms,)
        Masses.
    positions : ndarray, shape (2 or 3, atoms)
        Positions about the centre of mass. The third row is the height along the axis, which the body keeps.
    pairs : tuple of tuple
        Triples of two atoms and their potential.

    Examples
    --------
    >>> ring = fa.molecules.ring(6, mass=1.0, radius=1.0, pairs=[fa.molecules.HarmonicBond(), None])
    >>> ring.inertia.moments.round(12).tolist()
    [[3.0, 0.0], [0.0, 3.0]]
    """

    masses: Array
    positions: Array
    pairs: tuple[tuple[int, int, PairPotential], ...]

    def __repr__(self) -> str:
        """Return the numbers of atoms and of pairs: the arrays of a ring of 1000 atoms fill pages."""
        kinds = Counter(type(potential).__name__ for _, _, potential in self.pairs)
        bonds = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        return f"<Molecule of {len(self.masses)} atoms, mass {self.masses.sum():.6g}: {bonds}>"

    # --- the atoms --------------------------------------------------------------------------------------------------

    def energy(self, positions: ArrayLike) -> float:
        """Return the energy of all pairs.

        Parameters
        ----------
        positions : array_like, shape (2 or 3, atoms)
            Positions.

        Returns
        -------
        float
            Energy.

        Raises
        ------
        TypeError, ValueError
            If `positions` has another shape, or entries that are not finite.
        """
        r = self._placed(positions)
        return float(sum(pair.value(np.linalg.norm(r[:, i] - r[:, j])) for i, j, pair in self.pairs))

    def gradient(self, positions: ArrayLike) -> Array:
        """Return the derivatives of the energy.

        Parameters
        ----------
        positions : array_like, shape (2 or 3, atoms)
            Positions.

        Returns
        -------
        ndarray, shape (2 or 3, atoms)
            Minus the forces on the atoms.

        Raises
        ------
        TypeError, ValueError
            If `positions` has another shape, or entries that are not finite.
        """
        r = self._placed(positions)
        total = np.zeros_like(r)
        for i, j, pair in self.pairs:
            apart = r[:, i] - r[:, j]
            distance = np.linalg.norm(apart)
            pull = pair.slope(distance) * apart / distance
            total[:, i] += pull
            total[:, j] -= pull
        return total

    def hessian(self, positions: ArrayLike) -> Array:
        """Return the second derivatives of the energy.

        Parameters
        ----------
        positions : array_like, shape (2 or 3, atoms)
            Positions.

        Returns
        -------
        ndarray, shape (coordinates, coordinates)
            Hessian in the coordinates ``positions.ravel()``.

        Raises
        ------
        TypeError, ValueError
            If `positions` has another shape, or entries that are not finite.
        """
        r = self._placed(positions)
        dimensions, atoms = r.shape
        H = np.zeros((dimensions, atoms, dimensions, atoms))
        for i, j, pair in self.pairs:
            apart = r[:, i] - r[:, j]
            distance = np.linalg.norm(apart)
            along = np.outer(apart, apart) / distance**2
            block = pair.curvature(distance) * along + pair.slope(distance) / distance * (np.eye(dimensions) - along)
            for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                H[:, a, :, b] += sign * block
        return H.reshape(r.size, r.size)

    def normal_modes(self) -> MolecularModes:
        """Compute the normal modes of all atoms about the homogeneous equilibrium.

        Returns
        -------
        MolecularModes
            Frequencies, displacements, and their shares of homogeneous deformation.

        Raises
        ------
        ValueError
            If the molecule has no equilibrium near its positions.

        Notes
        -----
        The frequencies belong to an equilibrium of the atoms only if `Equilibrium.residual` is 0, as for a ring. Else
        take the modes of ``molecule.relaxed()``.

        Examples
        --------
        >>> bond = fa.molecules.HarmonicBond()
        >>> triangle = fa.molecules.ring(3, mass=1.0, radius=3**-0.5, pairs=bond)
        >>> bool(np.allclose(triangle.normal_modes().omega[3:], triangle.vibrations().omega[1:]))
        True
        """
        rest = self.equilibrium()
        root = np.sqrt(np.tile(self.masses, len(self.positions)))
        squares, vectors = np.linalg.eigh(self.hessian(rest.positions) / np.outer(root, root))
        affine = np.linalg.qr(root[:, None] * self._affine()).Q
        vectors = _sorted_by_share(squares, vectors, affine)
        return MolecularModes(
            omega=_rooted(squares),
            displacements=(vectors / root[:, None]).reshape(*self.positions.shape, -1),
            overlap=np.sum((affine.T @ vectors) ** 2, axis=0),
        )

    def relaxed(self) -> Molecule:
        """Return the molecule with its atoms at the nearest equilibrium of all their coordinates.

        Returns
        -------
        Molecule
            The same atoms at rest.

        Raises
        ------
        ValueError
            If the molecule has no equilibrium near its positions.
        """
        x = self._least(np.eye(self.positions.size), self.positions.ravel())
        return molecule(self.masses, x.reshape(self.positions.shape), {(i, j): pair for i, j, pair in self.pairs})

    # --- the body ---------------------------------------------------------------------------------------------------

    @cached_property
    def inertia(self) -> Inertia:
        """Mass, centre and second moments in the plane."""
        return inertia(self.positions[:2], self.masses)

    @property
    def heights(self) -> Array:
        """Heights of the atoms along the axis, 0 in the plane."""
        return self.positions[2] if len(self.positions) == 3 else np.zeros(len(self.masses))

    @cached_property
    def principal(self) -> tuple[float, float, Array]:
        """Principal moments mu_1 >= mu_2 and the rotation (2, 2) to their axes; the identity if they are equal."""
        J = self.inertia.moments
        low, high = np.linalg.eigvalsh(J)
        if high - low <= ISOTROPIC * high:
            mean = float(np.trace(J) / 2)
            return mean, mean, np.eye(2)
        axis = np.linalg.eigh(J)[1][:, 1]
        return float(high), float(low), np.array([axis, [-axis[1], axis[0]]])

    @cached_property
    def body(self) -> Body:
        """The doubly isotropic body: the energy averaged over the orientations of the material.

        Raises ValueError if the principal moments differ. The energy is that of `exact_body` up to the order
        `anisotropy_order` of beta/alpha.
        """
        mu_1, mu_2, _ = self.principal
        if mu_1 != mu_2:
            raise ValueError(
                f"molecule must have equal principal moments, got {mu_1:.6g} and {mu_2:.6g}. Try exact_body."
            )
        chain: Any = NoPairs()
        for pair, vectors in self._by_potential():
            merged = _merged(np.stack([np.hypot(vectors[:, 0], vectors[:, 1]), np.abs(vectors[:, 2])], axis=1))
            lengths, heights, counts = map(tuple, merged.T.tolist())
            chain = AveragedPairs(pair, lengths, heights, counts, chain)
        return Body(chain, mu_1)

    @cached_property
    def exact_body(self) -> MolecularBody:
        """The body with the energy of all pairs in their directions, in the frame of the principal axes."""
        mu_1, mu_2, axes = self.principal
        chain: Any = NoPairs()
        for pair, vectors in self._by_potential():
            turned = vectors.copy()
            turned[:, :2] = vectors[:, :2] @ axes.T
            merged = _merged(turned * _half_plane(turned)[:, None] + 0.0)
            x, y, heights, counts = map(tuple, merged.T.tolist())
            chain = DirectedPairs(pair, x, y, heights, counts, chain)
        return MolecularBody(chain, mu_1, mu_2)

    @cached_property
    def anisotropy_order(self) -> int:
        """Least k for which the energy has a term (beta/alpha)^k cos(2 k psi + const).

        It is n for a ring of an odd number n of atoms, n/2 for an even one. From 3 on, the small vibrations of `body`
        are those of `exact_body`.
        """
        orders = []
        for _, vectors in self._by_potential():
            lengths = np.hypot(vectors[:, 0], vectors[:, 1])
            for group in _groups(np.stack([lengths, np.abs(vectors[:, 2])], axis=1)):
                if lengths[group[0]] == 0:
                    continue
                turn = (vectors[group, 0] + 1j * vectors[group, 1]) ** 2 / lengths[group] ** 2
                sums = [abs(np.sum(turn**k)) for k in range(1, len(group) + 1)]
                orders.append(1 + next(k for k, size in enumerate(sums) if size > 1e-9 * len(group)))
        return min(orders)

    def equilibrium(self) -> Equilibrium:
        """Find the homogeneous deformation with the least energy.

        Returns
        -------
        Equilibrium
            Deformation, positions, energy and the largest force on an atom.

        Raises
        ------
        ValueError
            If the molecule has no equilibrium near its positions.

        Notes
        -----
        The method is Newton's in a trust region, from phi = 1. Symmetric positions may lead to a symmetric saddle
        point. `vibrations` then has a negative frequency.

        Examples
        --------
        >>> ring = fa.molecules.ring(6, mass=1.0, radius=1.3, pairs=fa.molecules.HarmonicBond(k=2.0))
        >>> float(1.3 * ring.equilibrium().phi[0, 0].round(12))
        1.0
        """
        start = np.array([1.0, 0.0, 0.0, 1.0])
        phi = self._least(self._affine(), start).reshape(2, 2)
        _, stretches, right = np.linalg.svd(phi)
        if not (np.linalg.det(phi) > 0 and stretches[1] > FLAT):
            raise ValueError(f"molecule must have an equilibrium with det phi > 0, got stretches {stretches}.")
        phi = right.T @ (stretches[:, None] * right)
        positions = self._deformed(phi.ravel())
        force = self.gradient(positions)
        residual = float(np.linalg.norm(force, axis=0).max())
        return Equilibrium(phi=phi, positions=positions, energy=self.energy(positions), residual=residual)

    def vibrations(self) -> Vibrations:
        """Compute the small vibrations of the body about its equilibrium.

        Returns
        -------
        Vibrations
            Frequencies and modes: rotation, two shears and a dilatation for a ring.

        Raises
        ------
        ValueError
            If the molecule has no equilibrium near its positions.

        Notes
        -----
        The Hessian is that of the energy of all pairs, restricted to phi. Its frequencies interlace with those of the
        atoms (Rayleigh and Ritz).

        Examples
        --------
        >>> ring = fa.molecules.ring(3, mass=1.0, radius=3**-0.5, pairs=fa.molecules.HarmonicBond())
        >>> (ring.vibrations().omega[1:] ** 2).round(12).tolist()
        [1.5, 1.5, 3.0]
        """
        affine = self._affine()
        H = affine.T @ self.hessian(self.equilibrium().positions) @ affine
        M = np.kron(np.eye(2), self.inertia.moments)
        inverse_root = np.linalg.inv(np.linalg.cholesky(M))
        squares, vectors = np.linalg.eigh(inverse_root @ H @ inverse_root.T)
        return Vibrations(omega=_rooted(squares), modes=(inverse_root.T @ vectors).reshape(2, 2, 4))

    # --- private ----------------------------------------------------------------------------------------------------

    def _placed(self, positions: ArrayLike) -> Array:
        """Return checked positions of this molecule's shape."""
        return checked("positions", positions, self.positions.shape)

    def _affine(self) -> Array:
        """Return the displacements (coordinates, 4) of the four elements of phi, in the order of phi.ravel()."""
        moved = np.zeros((*self.positions.shape, 2, 2))
        for i in range(2):
            moved[i, :, i] = self.positions[:2].T
        return moved.reshape(self.positions.size, 4)

    def _deformed(self, elements: Array) -> Array:
        """Return the positions of the atoms under phi."""
        moved = self.positions.copy()
        moved[:2] = elements.reshape(2, 2) @ self.positions[:2]
        return moved

    def _least(self, directions: Array, start: Array) -> Array:
        """Return coordinates c of least energy, positions = fixed + directions c, by Newton's method in a trust
        region; the last steps are without one.
        """
        from scipy.optimize import minimize

        fixed = self.positions.ravel() - directions @ start

        def at(c: Array) -> Array:
            return (fixed + directions @ c).reshape(self.positions.shape)

        def slope(c: Array) -> Array:
            return directions.T @ self.gradient(at(c)).ravel()

        def bend(c: Array) -> Array:
            return directions.T @ self.hessian(at(c)) @ directions

        options = {"maxiter": STEPS}
        force = np.inf
        with np.errstate(all="ignore"), contextlib.suppress(ValueError, np.linalg.LinAlgError):  # of NaN
            c = minimize(
                lambda c: self.energy(at(c)), start, jac=slope, hess=bend, method="trust-exact", options=options
            ).x
            for _ in range(3):
                c = c - np.linalg.lstsq(bend(c), slope(c), rcond=1e-9)[0]
            force = float(np.abs(slope(c)).max() / (np.linalg.norm(bend(start), 2) * np.linalg.norm(start)))
        if not force <= AT_REST:
            got = f"a relative force of {force:.3g}" if np.isfinite(force) else "no finite forces or no stiffness"
            raise ValueError(f"molecule must have an equilibrium near its positions, got {got}.")
        return c

    def _by_potential(self) -> list[tuple[PairPotential, Array]]:
        """Return each potential with the differences (pairs, 3) of its atoms."""
        raised = np.stack([*self.positions[:2], self.heights])
        groups: dict[PairPotential, list[Array]] = {}
        for i, j, pair in self.pairs:
            groups.setdefault(pair, []).append(raised[:, j] - raised[:, i])
        return [(pair, np.array(vectors)) for pair, vectors in groups.items()]


def molecule(masses: ArrayLike, positions: ArrayLike, pairs: Mapping[tuple[int, int], PairPotential]) -> Molecule:
    """Make a molecule for homogeneous deformation in a plane.

    Parameters
    ----------
    masses : array_like, shape (atoms,)
        Masses, positive.
    positions : array_like, shape (2, atoms) or (3, atoms)
        Positions of at least three atoms, not on one line in the plane of the first two rows. They may be strained.
        The third row is the height along the axis.
    pairs : dict
        Potential of each pair of atoms that interacts, by the numbers of the atoms: ``{(0, 1): HarmonicBond(k=2.0)}``.
        A potential is one of `HarmonicBond`, `MorseBond`, `LennardJones`, a result of `univariate`, or any NamedTuple
        with the methods value, slope and curvature.

    Returns
    -------
    Molecule
        Atoms, with the inertia, the bodies, the equilibrium and the vibrations as attributes and methods.

    Raises
    ------
    TypeError
        If an argument has a wrong type.
    ValueError
        If a mass is not positive, a shape is wrong, the atoms are on one line or a pair is not one of two atoms.

    Notes
    -----
    * ``molecule.body`` is a `Body` for all functions of `fastaff`: the energy is averaged over the orientations of the
      material.
    * ``molecule.exact_body`` has the energy of all pairs and unequal moments. Its spin is conserved, its vorticity is
      not.
    * Cost: each different potential adds to the time of the first compilation. A ring with 3 takes seconds, one with 20
      two minutes.
    * Dropped: all vibrations that are not homogeneous, and motion along the axis.

    References
    ----------
    Martens & Slawianowski, section 2 (inertia, affine constraints); the energy is derived.

    Examples
    --------
    >>> bond = fa.molecules.MorseBond(D=4.0, a=1.2)
    >>> square = fa.molecules.molecule(
    ...     [1, 2, 1, 2], [[0, 1, 1, 0], [0, 0, 1, 1]], {(0, 1): bond, (1, 2): bond, (2, 3): bond, (0, 3): bond}
    ... )
    >>> square.inertia.moments.tolist(), square.anisotropy_order
    ([[1.5, -0.5], [-0.5, 1.5]], 2)
    """
    m = checked("masses", masses, an_array("masses", masses).shape)
    if m.ndim != 1 or len(m) < 3:
        raise ValueError(f"masses must be those of at least three atoms, got shape {m.shape}.")
    if not (m > 0).all():
        raise ValueError(f"masses must be positive, got {shown(m.tolist())}.")
    r = an_array("positions", positions)
    if r.shape not in ((2, len(m)), (3, len(m))):
        raise ValueError(f"positions must have shape (2, {len(m)}) or (3, {len(m)}), got {r.shape}.")
    r = checked("positions", positions, r.shape)
    about = r - (r @ m / np.sum(m))[:, None]
    low, high = np.linalg.eigvalsh(inertia(about[:2], m).moments)
    if not low > FLAT * high:
        raise ValueError(
            f"positions must not be on one line in the plane, got principal moments {low:.3g}, {high:.3g}."
        )
    return Molecule(masses=m, positions=about, pairs=_checked_pairs(pairs, about))


def ring(
    atoms: int,
    *,
    mass: float = 1.0,
    radius: float = 1.0,
    pairs: PairPotential | Sequence[PairPotential | None],
    height: float = 0.0,
) -> Molecule:
    """Make a ring of equal atoms, or the cross-section of a tube.

    Parameters
    ----------
    atoms : int
        Number n of atoms, from 3 to 1000.
    mass : float, default 1
        Mass of an atom, or the mass of a row of atoms along a tube.
    radius : float, default 1
        Radius, positive. It may be strained.
    pairs : pair potential or sequence
        Potential of neighbours, or potentials of neighbours of order 1, 2, ..., at most n/2. None for no interaction.
    height : float, default 0
        Height of the atoms above and below the plane in turn, for a crown of an even number of atoms.

    Returns
    -------
    Molecule
        Ring, with the inertia n m R^2/2 times the identity.

    Raises
    ------
    TypeError
        If an argument has a wrong type.
    ValueError
        If a number is out of its range, or `pairs` has more orders than the ring.

    Notes
    -----
    * `Molecule.anisotropy_order` is n if n is odd, else n/2. Vibrations of the averaged body are exact for n = 3 and
      n > 4, to second order in the amplitude.
    * Homogeneous modes of a ring: rotation, dilatation (exact breathing mode), two shears.

    References
    ----------
    Martens & Slawianowski, section 6 (S8, C6H6, nanotubes).

    Examples
    --------
    >>> spring = fa.molecules.HarmonicBond(k=2.0, length=1.0)
    >>> ring = fa.molecules.ring(8, mass=32.06, radius=1.2, pairs=[spring, fa.molecules.HarmonicBond(length=1.8)])
    >>> ring.anisotropy_order, round(ring.body.mu, 6)
    (4, 184.6656)
    """
    n = whole("atoms", atoms, 3, MOST_ATOMS)
    m = positive("mass", mass)
    R = positive("radius", radius)
    orders: Any = [pairs] if hasattr(pairs, "_fields") else pairs
    if isinstance(orders, (str, Mapping)) or not isinstance(orders, Sequence):
        raise TypeError(f"pairs must be a pair potential or a sequence of them, got {shown(pairs)}.")
    if not 1 <= len(orders) <= n // 2:
        raise ValueError(f"pairs must have 1 to {n // 2} orders of neighbours for {n} atoms, got {len(orders)}.")
    raised = _alternating(n, height)
    angle = 2 * np.pi * np.arange(n) / n
    where = np.stack([R * np.cos(angle), R * np.sin(angle), *([raised] if raised.any() else [])])
    bonds = {}
    for order, pair in enumerate(orders, 1):
        for i in range(n if 2 * order < n else order):
            if pair is not None:
                bonds[i, (i + order) % n] = pair
    return molecule(np.full(n, m), where, bonds)


def _alternating(n: int, height: Any) -> Array:
    """Return heights above and below the plane in turn."""
    h = real("height", height)
    if h != 0 and n % 2:
        raise ValueError(f"height must be 0 for an odd number of atoms, got {h}.")
    heights: Array = np.full(n, h)
    heights[1::2] = -h
    return heights


def _checked_pairs(pairs: Any, positions: Array) -> tuple[tuple[int, int, PairPotential], ...]:
    """Return the pairs as triples, each once."""
    if not isinstance(pairs, Mapping):
        raise TypeError(f"pairs must be potentials by pairs of atoms such as {{(0, 1): bond}}, got {shown(pairs)}.")
    if not pairs:
        raise ValueError("pairs must have at least one entry, got none.")
    atoms = positions.shape[1]
    known: dict[frozenset[int], tuple[int, int, PairPotential]] = {}
    for key, pair in pairs.items():
        if not isinstance(key, tuple) or len(key) != 2:
            raise TypeError(f"pairs must have keys of two atoms such as (0, 1), got {shown(key)}.")
        i, j = (whole("atoms of pairs", atom, 0, atoms - 1) for atom in key)
        if i == j or frozenset((i, j)) in known:
            raise ValueError(f"pairs must name two different atoms once, got {shown(key)}.")
        if not np.any(positions[:, i] != positions[:, j]):
            raise ValueError(f"positions must differ for the atoms of a pair, got equal ones for {shown(key)}.")
        missing = [name for name in METHODS if not hasattr(pair, name)]
        if missing or not hasattr(pair, "_fields") or isinstance(pair, type):
            raise TypeError(
                f"pairs[{i}, {j}] must be a NamedTuple with the methods value, slope and curvature, got {shown(pair)}."
            )
        if not np.isfinite(parameters(pair)).all():
            raise ValueError(f"pairs[{i}, {j}] must have finite parameters, got {shown(pair)}.")
        known[frozenset((i, j))] = (i, j, pair)
    return tuple(known.values())


def _rooted(squares: Array) -> Array:
    """Return roots, negative for negative squares; squares of round-off size are 0."""
    small = np.abs(squares) <= 1e-11 * np.abs(squares).max()
    return np.where(small, 0.0, np.sign(squares) * np.sqrt(np.abs(squares)))


def _sorted_by_share(squares: Array, vectors: Array, affine: Array) -> Array:
    """Return modes where those of one frequency are turned: as much as possible of a few of them is homogeneous."""
    turned = vectors.copy()
    gap = DEGENERATE * np.abs(squares).max()
    for group in np.split(np.arange(len(squares)), 1 + np.flatnonzero(np.diff(squares) > gap)):
        turned[:, group] = vectors[:, group] @ np.linalg.svd(affine.T @ vectors[:, group])[2].T
    return turned


def _half_plane(vectors: Array) -> Array:
    """Return the sign that turns a difference of atoms into one half of space."""
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    rounded = np.where(np.abs(vectors) <= SAME * size, 0.0, vectors)
    leading = np.argmax(rounded != 0, axis=1)
    return np.sign(rounded[np.arange(len(vectors)), leading])


def _groups(rows: Array) -> list[Any]:
    """Return the indices of rows that are equal up to round-off, group by group."""
    scale = np.abs(rows).max()
    left = np.arange(len(rows))
    groups = []
    while len(left):
        same = np.abs(rows[left] - rows[left[0]]).max(axis=1) <= SAME * scale
        groups.append(left[same])
        left = left[~same]
    return groups


def _merged(rows: Array) -> Array:
    """Return different rows, with a last column that counts them."""
    return np.array([[*rows[group[0]], len(group)] for group in _groups(rows)])
