"""Numerical schemes as data that checks itself: splittings, explicit Runge-Kutta tableaux and all others by name.

A scheme is a frozen value: its coefficients, its stated order and its publication. Construction raises ValueError for
wrong lengths, lost digits, broken symmetry or an order that the quadrature conditions refute.

For a choice: forces per unit time for a global error of 1e-11 after time 20, on a Hénon-Heiles orbit of energy 0.096
and on a Kepler orbit of eccentricity 0.3 (constants of the leading error, measured in 45 digits):

                   LEAPFROG   YOSHIDA4   BLANES_MOAN6   KAHAN_LI8   SOFRONIOU_SPALETTA10
    Hénon-Heiles     206500       1666             87         127                     84
    Kepler          1371000       5176            282         220                    169

docs/explanation/schemes.md has the race on seven systems and its leaders.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from itertools import chain
from math import isfinite
from types import MappingProxyType
from typing import Any

import numpy as np

from ...core.names import named
from ...core.numbers import flag, reals, shown, text, whole
from . import _dop853, _splittings, _verner98
from .collocation import GAUSS8, GAUSS16, Collocation
from .conditions import MOST_ORDER, Rows, Weights, agree, moments, nested, require, tableau
from .nystrom import RKN12, Nystrom


def _label(scheme: "Splitting | RungeKutta") -> None:
    """Check name, source and order of a scheme."""
    text("name", scheme.name)
    text("source", scheme.source)
    whole("order", scheme.order, 1, MOST_ORDER)


def _shown(scheme: "Splitting | RungeKutta") -> str:
    """Return the name of a scheme of the package, for others class, name, order and stages."""
    if scheme.name == ITERATION.name or SCHEMES.get(scheme.name) == scheme:
        return scheme.name
    return f"{type(scheme).__name__}(name={scheme.name!r}, order={scheme.order}, stages={scheme.stages})"


@dataclass(frozen=True)
class Splitting:
    """Define a symmetric splitting of H = T(p) + V(q).

    Parameters
    ----------
    name : str
        Name of the scheme.
    order : int
        Order, which construction checks.
    source : str
        Publication.
    drift : tuple of float
        Coefficients of the drifts, one more than kicks, palindromic, with the sum 1.
    kick : tuple of float
        Coefficients of the kicks, palindromic, with the sum 1.
    nystrom : bool, default False
        True if the order holds only for T quadratic in p.
    increments : bool, default False
        True to add steps as increments with compensated (Kahan) summation. Steps take 1.2 to 1.4 times as long. Use it
        if the error of the scheme is below 1e-13.

    Raises
    ------
    TypeError
        If a value has a wrong type.
    ValueError
        If coefficients are not finite, not palindromic, do not sum to 1, or contradict the order.

    Notes
    -----
    * Method: explicit, symplectic and reversible. A step of size h moves q by the flow of T for drift[0] h, p by the
      flow of V for kick[0] h, and so on; it ends with drift[-1] h. A scheme that kicks first has drift[0] = drift[-1] =
      0.
    * Test of the order: necessary, not sufficient. If force and velocity depend on time alone, the scheme must be a
      quadrature of that order.
    * Compensated variant: ``dataclasses.replace(scheme, increments=True)``.

    Examples
    --------
    >>> import dataclasses
    >>> dataclasses.replace(fa.LEAPFROG, increments=True).stages
    1
    """

    name: str
    order: int
    source: str
    drift: Weights
    kick: Weights
    nystrom: bool = False
    increments: bool = False

    def __repr__(self) -> str:
        return _shown(self)

    def __post_init__(self) -> None:
        _label(self)
        flag("nystrom", self.nystrom)
        flag("increments", self.increments)
        for what in ("drift", "kick"):
            object.__setattr__(self, what, reals(f"scheme {self.name}: {what}", getattr(self, what)))
        require(
            len(self.drift) == len(self.kick) + 1 >= 2,
            self.name,
            f"needs one drift more than kicks, got {len(self.drift)} drifts and {len(self.kick)} kicks",
        )
        require(all(map(isfinite, (*self.drift, *self.kick))), self.name, "coefficients must be finite")
        for what, weights in (("drift", self.drift), ("kick", self.kick)):
            require(weights == weights[::-1], self.name, f"{what} coefficients must be palindromic")
            require(
                agree(sum(weights), 1.0, weights),
                self.name,
                f"{what} coefficients must sum to 1, got {sum(weights)!r}",
            )
        # The drift's moment k belongs to the bracket of k - 1 kicks with one drift: none for k > 3 if T is quadratic.
        for what, weights, other, degree in (
            ("kick", self.kick, self.drift[:-1], self.order),
            ("drift", self.drift, (0.0, *self.kick), min(self.order, 3) if self.nystrom else self.order),
        ):
            found = moments(weights, np.cumsum(other), degree)
            require(
                agree(found, 1 / np.arange(1, degree + 1), weights),
                self.name,
                f"{what} coefficients contradict the order {self.order}",
            )

    symplectic = True
    """Whether it is symplectic and reversible with equal steps."""

    adaptive = False
    """Whether it can control its step size."""

    @cached_property
    def stages(self) -> int:
        """Number of kicks in a step."""
        return sum(k != 0.0 for k in self.kick)

    @property
    def evaluations(self) -> int:
        """Forces per step when the last force of a step that ends with a kick serves the next step too."""
        return self.stages - (self.drift[-1] == 0.0)

    @property
    def drift_array(self) -> np.ndarray:
        """A fresh float64 array (kicks + 1,)."""
        return np.array(self.drift, dtype=np.float64)

    @property
    def kick_array(self) -> np.ndarray:
        """A fresh float64 array (kicks,)."""
        return np.array(self.kick, dtype=np.float64)


def compose(
    base: Splitting,
    weights: Iterable[str | float | Fraction],
    *,
    name: str,
    order: int,
    source: str,
    increments: bool = False,
) -> Splitting:
    """Compose a symmetric splitting with itself at several step sizes.

    Parameters
    ----------
    base : Splitting
        Scheme that is composed.
    weights : iterable of str, float or Fraction
        Step sizes w1, w2, ... in units of h, from the outside in, without the central one. Texts keep all digits.
    name : str
        Name of the new scheme.
    order : int
        Order of the new scheme.
    source : str
        Publication.
    increments : bool, default False
        True to add steps with compensated summation.

    Returns
    -------
    `Splitting`
        Scheme with the step sizes w1 h, w2 h, ..., w0 h, ..., w2 h, w1 h and w0 = 1 - 2 (w1 + w2 + ...).

    Raises
    ------
    ValueError
        If the result contradicts the order.

    Notes
    -----
    Adjacent flows of the same kind are merged exactly and rounded once.

    References
    ----------
    Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed. 2006, V.3.2.

    Examples
    --------
    >>> weights = ["1.3512071919596576"]
    >>> fa.schemes.compose(fa.LEAPFROG, weights, name="three leapfrogs", order=4, source="Yoshida 1990").stages
    3
    """
    outer = [Fraction(w) for w in weights]
    flows = [Fraction(0)] * (2 * len(base.kick) + 1)
    flows[::2] = map(Fraction, base.drift)
    flows[1::2] = map(Fraction, base.kick)
    kicks_first = not flows[0]
    if kicks_first:
        flows = flows[1:-1]
    merged = [Fraction(0)]
    for w in (*outer, 1 - 2 * sum(outer), *reversed(outer)):
        merged[-1] += w * flows[0]
        merged += [w * flow for flow in flows[1:]]
    if kicks_first:
        merged = [Fraction(0), *merged, Fraction(0)]
    drift = tuple(map(float, merged[::2]))
    kick = tuple(map(float, merged[1::2]))
    return Splitting(name, order, source, drift=drift, kick=kick, nystrom=base.nystrom, increments=increments)


def triple_jump(base: Splitting, *, name: str, source: str) -> Splitting:
    """Raise the order of a symmetric splitting by two.

    Parameters
    ----------
    base : Splitting
        Scheme that is composed.
    name : str
        Name of the new scheme.
    source : str
        Publication.

    Returns
    -------
    `Splitting`
        Scheme of three steps of sizes w h, (1 - 2 w) h, w h with w = 1/(2 - 2^(1/(order + 1))).

    Raises
    ------
    ValueError
        If the result contradicts its order.

    References
    ----------
    Yoshida, Phys. Lett. A 150 (1990) 262, eq. 4.4.

    Examples
    --------
    >>> jump = fa.schemes.triple_jump(fa.LEAPFROG, name="triple leapfrog", source="Yoshida 1990")
    >>> jump.order, jump.stages
    (4, 3)
    """
    w = 1 / (2 - Decimal(2) ** (1 / Decimal(base.order + 1)))
    return compose(base, [Fraction(w)], name=name, order=base.order + 2, source=source)


@dataclass(frozen=True)
class RungeKutta:
    """Define an explicit Runge-Kutta tableau.

    Parameters
    ----------
    name : str
        Name of the scheme.
    order : int
        Order, which construction checks.
    source : str
        Publication.
    a : tuple of tuple of float
        Row i has i entries.
    b : tuple of float
        Weights, one for each stage.
    c : tuple of float
        Nodes, one for each stage.
    errors : tuple of tuple of float, default ()
        At most two rows of weights of error estimates. With them the scheme controls its step size.
    error_orders : tuple of int, default ()
        Order of the solution whose error each row estimates.
    extra_a : tuple of tuple of float, default ()
        Rows of further slopes for the interpolant.
    extra_c : tuple of float, default ()
        Nodes of these slopes.
    dense : tuple of tuple of float, default ()
        Rows of the interpolant, over all slopes.
    dense_order : int, default 0
        Order of the interpolant.

    Raises
    ------
    TypeError
        If a value has a wrong type.
    ValueError
        If a row of `a` does not sum to its node, or if weights contradict their order as a quadrature.

    Notes
    -----
    * Step: k_i = f(t + c_i h, y + h sum_j a_ij k_j); the step ends at y + h sum_i b_i k_i.
    * Step control: one row of errors, or the blend of two of DOP853. It needs the last slope of a step as the first
      slope of the next.
    * Interpolant: ``y + h x (F_0 + (1-x) (F_1 + x (F_2 + (1-x) (F_3 + ...))))`` at t + x h, with F_r = sum_i dense_ri
      k_i and F_0 = sum_i b_i k_i. This nesting loses fewer digits than powers of x.
    * The test of the order is necessary, not sufficient.

    Examples
    --------
    >>> fa.RK4.stages, fa.RK4.adaptive, fa.DOP853.adaptive
    (4, False, True)
    """

    name: str
    order: int
    source: str
    a: Rows
    b: Weights
    c: Weights
    errors: Rows = ()
    error_orders: tuple[int, ...] = ()
    extra_a: Rows = ()
    extra_c: Weights = ()
    dense: Rows = ()
    dense_order: int = 0

    def __repr__(self) -> str:
        return _shown(self)

    def __post_init__(self) -> None:
        _label(self)
        for what in ("b", "c", "extra_c"):
            object.__setattr__(self, what, reals(f"scheme {self.name}: {what}", getattr(self, what)))
        for what in ("a", "errors", "extra_a", "dense"):
            object.__setattr__(self, what, tableau(f"scheme {self.name}: {what}", getattr(self, what)))
        orders = reals("error_orders", self.error_orders)
        object.__setattr__(self, "error_orders", tuple(whole("error_orders", int(p), 1, MOST_ORDER) for p in orders))
        whole("dense_order", self.dense_order, 0, MOST_ORDER)
        rows = (*self.a, *self.extra_a)
        every = self.stages + len(self.extra_c)
        for condition, fault in (
            (len(self.a) == self.stages == len(self.c), "a, b and c must have one row or entry per stage"),
            (len(rows) == every, "extra_a and extra_c must have one row or entry per extra slope"),
            (all(len(row) == i for i, row in enumerate(rows)), "row i of a must have i entries (explicit)"),
            (all(len(row) == self.stages for row in self.errors), "rows of errors must have one weight per stage"),
            (len(self.errors) == len(self.error_orders), "errors must have one order per row"),
            (len(self.errors) <= 2, "errors must have at most two rows"),
            (all(len(row) == every for row in self.dense), f"rows of dense must have {every} weights"),
            (self.dense_order <= len(self.dense), "dense must have at least as many rows as its order"),
            (all(map(isfinite, chain(*rows, self.b, *self.errors, *self.dense))), "coefficients must be finite"),
        ):
            require(condition, self.name, fault)
        require(not self.errors or self.fsal, self.name, "errors need a last row of a that is b, with b[-1] = 0")
        nodes = self.c_array
        for i, row in enumerate(rows):
            require(agree(sum(row), nodes[i], row), self.name, f"row {i} of a must sum to c[{i}] = {nodes[i]!r}")
        targets = np.array([nested(k, len(self.dense)) for k in range(1, self.dense_order + 1)]).T
        for what, weights, target in (
            ("b", self.b, 1 / np.arange(1, self.order + 1)),
            *((f"errors[{r}]", row, np.zeros(p)) for r, (row, p) in enumerate(zip(self.errors, self.error_orders))),
            *((f"dense[{r}]", row, targets[r]) for r, row in enumerate(self.dense)),
        ):
            found = moments(weights, nodes[: len(weights)], len(target))
            require(agree(found, target, weights), self.name, f"{what} contradicts the order {len(target)}")
        require(
            not self.dense or self.dense[0] == (*self.b, *[0.0] * len(self.extra_c)), self.name, "dense[0] must be b"
        )

    @property
    def stages(self) -> int:
        """Slopes in a step, without those of the interpolant."""
        return len(self.b)

    @property
    def fsal(self) -> bool:
        """Whether the last slope is the first of the next step."""
        return self.stages > 1 and self.b[-1] == 0.0 and self.a[-1] == self.b[:-1]

    @property
    def evaluations(self) -> int:
        """Slopes to compute per step after the first step."""
        return self.stages - self.fsal

    symplectic = False
    """Whether it is symplectic and reversible with equal steps."""

    @property
    def adaptive(self) -> bool:
        """Whether the tableau can control its step size."""
        return bool(self.errors)

    @property
    def a_array(self) -> np.ndarray:
        """A fresh float64 array (stages + extra, stages + extra), lower triangular; the extra rows are last."""
        rows = (*self.a, *self.extra_a)
        return np.array([[*row, *[0.0] * (len(rows) - len(row))] for row in rows], dtype=np.float64)

    @property
    def b_array(self) -> np.ndarray:
        """A fresh float64 array (stages,)."""
        return np.array(self.b, dtype=np.float64)

    @property
    def c_array(self) -> np.ndarray:
        """A fresh float64 array (stages + extra,)."""
        return np.array((*self.c, *self.extra_c), dtype=np.float64)

    @property
    def error_array(self) -> np.ndarray:
        """A fresh float64 array (rows of errors, stages)."""
        return np.array(self.errors, dtype=np.float64).reshape(-1, self.stages)

    @property
    def dense_array(self) -> np.ndarray:
        """A fresh float64 array (rows of dense, stages + extra)."""
        return np.array(self.dense, dtype=np.float64).reshape(-1, self.stages + len(self.extra_c))


def _mirrored(half: str, *, central: bool) -> Weights:
    """Return the palindrome of sum 1 with that outer half; the sum gives its central value or pair of values."""
    outer = [Fraction(w) for w in half.split()]
    inner = 1 - 2 * sum(outer)
    middle = [inner] if central else [inner / 2] * 2
    return tuple(map(float, (*outer, *middle, *reversed(outer))))


LEAPFROG = Splitting(
    name="LEAPFROG",
    order=2,
    source="Störmer 1907; Verlet, Phys. Rev. 159 (1967) 98; Strang 1968",
    drift=(0.5, 0.5),
    kick=(1.0,),
)

ITERATION = Splitting(
    name="ITERATION",
    order=1,
    source="a map is iterated as it is: no step, no error of a scheme",
    drift=(0.5, 0.5),
    kick=(1.0,),
)

YOSHIDA4 = triple_jump(
    LEAPFROG,
    name="YOSHIDA4",
    source="Yoshida, Phys. Lett. A 150 (1990) 262; Forest and Ruth, Physica D 43 (1990) 105",
)

BLANES_MOAN6 = Splitting(
    name="BLANES_MOAN6",
    order=6,
    nystrom=True,
    source="Blanes and Moan, J. Comput. Appl. Math. 142 (2002) 313, table 3, SRKN 14a; digits refined by Newton",
    drift=_mirrored(_splittings.BLANES_MOAN6_DRIFT, central=True),
    kick=_mirrored(_splittings.BLANES_MOAN6_KICK, central=False),
)

BLANES_CASAS_ESCORIHUELA8 = Splitting(
    name="BLANES_CASAS_ESCORIHUELA8",
    order=8,
    nystrom=True,
    source="Blanes, Casas and Escorihuela-Tomàs, arXiv 2202.01541 (2022), the symmetric method with 19 forces that "
    "drifts first",
    drift=_mirrored(_splittings.BLANES_CASAS_ESCORIHUELA8_DRIFT, central=False),
    kick=_mirrored(_splittings.BLANES_CASAS_ESCORIHUELA8_KICK, central=True),
)

KAHAN_LI8 = compose(
    LEAPFROG,
    _splittings.KAHAN_LI8.split(),
    name="KAHAN_LI8",
    order=8,
    source="Kahan and Li, Math. Comp. 66 (1997) 1089, 17 stages; digits of Hairer, Lubich, Wanner 2006, V.3.14",
)

SOFRONIOU_SPALETTA8 = compose(
    LEAPFROG,
    _splittings.SOFRONIOU_SPALETTA8.split(),
    name="SOFRONIOU_SPALETTA8",
    order=8,
    source="Sofroniou and Spaletta, Optim. Methods Softw. 20 (2005) 597, 21 stages",
)

SOFRONIOU_SPALETTA10 = compose(
    LEAPFROG,
    _splittings.SOFRONIOU_SPALETTA10.split(),
    name="SOFRONIOU_SPALETTA10",
    order=10,
    source="Sofroniou and Spaletta, Optim. Methods Softw. 20 (2005) 597, 35 stages",
    increments=True,
)

RK4 = RungeKutta(
    name="RK4",
    order=4,
    source="Kutta 1901; interpolant: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed. 1993, II.6",
    a=((), (1 / 2,), (0.0, 1 / 2), (0.0, 0.0, 1.0)),
    b=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
    c=(0.0, 1 / 2, 1 / 2, 1.0),
    dense=((1 / 6, 1 / 3, 1 / 3, 1 / 6), (5 / 6, -1 / 3, -1 / 3, -1 / 6), (-2 / 3, 2 / 3, 2 / 3, -2 / 3)),
    dense_order=3,
)

# Hairer's controller takes |E5|^2 / sqrt(|E5|^2 + 0.01 |E3|^2) as the error: it shrinks as fast as h^8.
DOP853 = RungeKutta(
    name="DOP853",
    order=8,
    source="Dormand and Prince; Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed. 1993, II.5, II.6",
    a=_dop853.A[:13],
    b=_dop853.B,
    c=_dop853.C[:13],
    errors=(_dop853.E5, _dop853.E3),
    error_orders=(5, 3),
    extra_a=_dop853.A[13:],
    extra_c=_dop853.C[13:],
    dense=_dop853.DENSE,
    dense_order=7,
)

# Slopes for each one of DOP853 at equal errors of 1e-8, 1e-10 and 1e-12: 1.03, 0.92 and 0.80 on Hénon-Heiles orbits,
# 0.94, 0.84 and 0.77 on Hyperelastic, 0.76, 0.77 and 0.77 on HeavyTop ones.
VERNER9 = RungeKutta(
    name="VERNER9",
    order=9,
    source="Verner, Numer. Algorithms 53 (2010) 383, the most efficient 9(8) pair (IIa), with its interpolant of order "
    "8",
    a=_verner98.A[:17],
    b=_verner98.B,
    c=_verner98.C[:17],
    errors=(_verner98.E8,),
    error_orders=(8,),
    extra_a=_verner98.A[17:],
    extra_c=_verner98.C[17:],
    dense=_verner98.DENSE,
    dense_order=8,
)

Scheme = Splitting | Nystrom | RungeKutta | Collocation

_BELOW_10 = (LEAPFROG, YOSHIDA4, BLANES_MOAN6, BLANES_CASAS_ESCORIHUELA8, KAHAN_LI8, SOFRONIOU_SPALETTA8)
_OTHERS = (SOFRONIOU_SPALETTA10, RKN12, RK4, DOP853, VERNER9, GAUSS8, GAUSS16)
SCHEMES: Mapping[str, Scheme] = MappingProxyType({scheme.name: scheme for scheme in (*_BELOW_10, *_OTHERS)})


def scheme_named(name: str) -> Scheme:
    """Return the scheme of a name.

    Parameters
    ----------
    name : str
        Name, in capitals or not, with spaces or hyphens too.

    Returns
    -------
    Scheme
        Scheme of the package.

    Raises
    ------
    TypeError
        If `name` is not a text.
    ValueError
        If no scheme has this name. The message lists the names.

    Examples
    --------
    >>> fa.schemes.scheme_named("Kahan-Li8").order
    8
    """
    if not isinstance(name, str):
        raise TypeError(
            f"name must be the name of a scheme such as 'KAHAN_LI8', got {shown(name)} ({type(name).__name__})"
        )
    return ITERATION if name == ITERATION.name else SCHEMES[named("name of a scheme", name, SCHEMES)]


def scheme_of(value: Any, _: Any = None) -> Any:
    """Return the scheme of a name; anything else as it is."""
    return SCHEMES[named("scheme", value, SCHEMES)] if isinstance(value, str) else value
