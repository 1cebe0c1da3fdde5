"""A torus as a Fourier series: the result of fits, and how well it obeys equations of motion or a map."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np

from ...base.axes import along
from ...base.numbers import numbers, shown, whole
from ...base.results import Result
from ...base.status import Status
from ...models.mechanics import slopes
from ...models.traits import traits_of
from ..chaos.chaos_map import chaos_map
from ..frequencies.integer_lattice import determinant, inverse
from .fit_signals import Unknown
from .series import actions, evaluate
from .turns import area, spread, turn_residual, turned


class Verdict(Enum):
    """Whether an orbit lies on a torus; the value is the sentence for people."""

    TORUS = "torus"
    RESONANT = "resonant torus of lower dimension"
    NOT_A_TORUS = "not a torus"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class TorusFit(Result, axis=None):
    """The torus of an orbit as a Fourier series: z(theta) = Re sum_k z_k exp(2 pi i k . theta), one k of each pair +-k.

    names (d,) of the angles; nu (d,) in cycles per unit time and nu_error (d,), inf where there is no torus; J (d,),
    the integrals of p dq over the cycles (`I` = J/2 pi); theta0 (d,), the angles of z0 in cycles, so that z(t) =
    evaluate(theta0 + nu t); k (terms, d) integer and coefficients (2n, terms) complex, the largest first; residual:
    largest ``|nu . dz/dtheta - X(z)|`` over points of the torus, relative to the largest ``|X|``; prediction_error:
    largest distance between the orbit and evaluate(theta0 + nu t) after the fitted time, relative to the size of the
    orbit; verdict; dimension d of the torus; relations (n' - d, n'): integer vectors that the n' natural frequencies
    are annihilated by; evidence: numbers by name; energy of z0; body.

    Of a map, and of a driven system's map over its period, t counts turns (iterates, periods) and nu is in cycles per
    turn: between 0 and 1, in the sense in which the action is positive, but for an angle that winds, whose nu and J are
    as it goes. residual: largest ``|z(theta + nu) - M(z(theta))|`` relative to the size of the orbit about its middle;
    energy NaN. winding (2n, d): how far a row goes on in a cycle of an angle, its period or 0; None where nothing
    winds; evaluate(theta) adds winding @ theta. islands: on how many pieces, images of each other, the orbit lies; z(t)
    is above for multiples t of it, nu is below 1/islands, and J is that of one of them.
    """

    names: tuple[str, ...]
    nu: Annotated[np.ndarray, along("angle", unit="cycles/time", labels="names", plain=True)]
    nu_error: Annotated[np.ndarray, along("angle", unit="cycles/time", labels="names")]
    J: Annotated[np.ndarray, along("angle", unit="action", labels="names")]
    theta0: Annotated[np.ndarray, along("angle", unit="cycles", labels="names")]
    k: Annotated[np.ndarray, along("term", "angle")]
    coefficients: Annotated[np.ndarray, along("coordinate", "term")]
    residual: float
    prediction_error: float
    verdict: Verdict
    dimension: int
    relations: Annotated[np.ndarray, along("relation", "frequency")]
    evidence: Mapping[str, float]
    energy: float
    body: Any
    winding: Annotated[np.ndarray | None, along("coordinate", "angle")] = None
    islands: int = 1

    @property
    def I(self) -> np.ndarray:  # noqa: E743
        """Actions J/2 pi."""
        return self.J / (2 * np.pi)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu, in radians per unit time."""
        return 2 * np.pi * self.nu

    @property
    def order(self) -> int:
        """Largest sum ``|k_i|`` of the series."""
        return int(np.abs(self.k).sum(axis=1).max(initial=0))

    def evaluate(self, theta: Any) -> np.ndarray:
        """Return the phase points (2n, ...) at angles theta (d, ...) in cycles.

        :Raises: ValueError for another shape.
        """
        theta = numbers("theta", theta)
        if theta.ndim < 1 or len(theta) != self.dimension:
            raise ValueError(f"theta must have shape ({self.dimension}, ...), got {theta.shape}")
        if not np.isfinite(theta).all():
            raise ValueError(f"theta must be finite, got {shown(theta)}")
        flat = theta.reshape(self.dimension, int(np.prod(theta.shape[1:])))
        z = evaluate(self.k, self.coefficients, flat)
        z = z if self.winding is None else z + self.winding @ flat
        return z.reshape(len(self.coefficients), *theta.shape[1:])

    def in_basis(self, M: Any) -> TorusFit:
        """Return the same torus with the angles M theta, M (d, d) integer of determinant +-1: nu' = M nu, J' = M^-T J.

        :Raises: ValueError for another matrix.
        """
        given = numbers("M", M)
        if (
            given.shape != (self.dimension,) * 2
            or not np.all(np.abs(given) < 2**53)
            or (given % 1).any()
            or abs(determinant(given)) != 1
        ):
            raise ValueError(f"M must be an integer matrix {(self.dimension,) * 2} of determinant +-1, got {M!r}")
        M = given.astype(int)
        back = inverse(M)
        names = tuple(combination(row, self.names) for row in M)
        known = np.isfinite(self.nu_error).all()
        return replace(
            self,
            names=names,
            nu=M @ self.nu,
            nu_error=np.abs(M) @ self.nu_error if known else self.nu_error,
            J=back.T @ self.J,
            theta0=M @ self.theta0 % 1.0,
            k=self.k @ back,
            winding=None if self.winding is None else self.winding @ back,
        )

    def truncated(self, order: int) -> TorusFit:
        """Return the series cut at sum ``|k_i|`` <= order, with the actions and the residual that it has.

        :Raises: for order < 0.
        """
        kept = np.abs(self.k).sum(axis=1) <= whole("order", order, 0)
        k, z = self.k[kept], self.coefficients[:, kept]
        if self.body is not None and turned(self.body):
            nu, J = self.nu * self.islands, area(self.body, k, z, self.winding)
            left = turn_residual(self.body, k, z, nu, self.winding, self.islands)
            return replace(self, k=k, coefficients=z, J=J, residual=left)
        return replace(self, k=k, coefficients=z, J=actions(k, z), residual=flow_residual(self.body, k, z, self.nu))

    def summary(self) -> str:
        """Say in one line the verdict and its numbers."""
        pairs = ", ".join(f"{name} {value:.9g}" for name, value in zip(self.names, self.nu))
        text = (
            f"{self.verdict.value}, dimension {self.dimension}: nu {pairs or '-'}; {len(self.k)} terms, "
            f"residual {self.residual:.1e}, prediction error {self.prediction_error:.1e}"
        )
        if self.verdict is Verdict.UNDECIDED:
            outcome = Status(int(self.evidence["status"]))
            text += (
                f"; a time of {self.evidence['longer']:.3g} may decide"
                if "longer" in self.evidence
                else f"; {outcome.sentence}"
                if outcome == Status.INTERRUPTED
                else "; the orbit failed"
            )
        return text


def flow_residual(body: Any, k: np.ndarray, z: np.ndarray, nu: np.ndarray) -> float:
    """Return the largest |nu . dz/dtheta - X(z)| on the torus over the largest |X|, for coordinates and momenta apart;
    NaN where no equations of motion are known.
    """
    if body is None or isinstance(body, Unknown):
        return float("nan")
    n, theta = len(z) // 2, spread(k.shape[1])
    point, slope = np.split(evaluate(k, np.vstack([z, 2j * np.pi * (k @ nu) * z]), theta), 2)
    with np.errstate(all="ignore"):
        speed = slopes(body, point)
        parts = [
            np.abs(slope[s] - speed[s]).max() / (np.abs(speed[s]).max() or 1.0) for s in (slice(n), slice(n, 2 * n))
        ]
    return float(max(parts)) if np.isfinite(parts).all() else np.inf


def resting(path: np.ndarray) -> bool:
    """Tell whether the orbit stays where it is, to rounding."""
    return bool((np.ptp(path, axis=1) <= 1e-12 * np.abs(path).max()).all())


def unsure(found: TorusFit, time: float) -> TorusFit:
    """Return a fit that is not good enough, undecided."""
    evidence, none = MappingProxyType({**found.evidence, "longer": 4 * time}), np.full_like(found.nu_error, np.inf)
    return replace(found, verdict=Verdict.UNDECIDED, nu_error=none, evidence=evidence)


def doubted(found: TorusFit, z: np.ndarray, time: float) -> TorusFit:
    """Return an undecided fit with the verdict that chaos gives, or that there is none to be seen."""
    if not traits_of(found.body).iterated and not hasattr(found.body, "tangent_force"):
        return found
    seen = chaos_map(found.body, z, time=1.5 * time)
    values = {name: float(value[0]) for name, value in zip(seen.names, seen.values, strict=True)}
    verdict = Verdict.NOT_A_TORUS if seen.chaotic[0] else found.verdict
    return replace(found, verdict=verdict, evidence=MappingProxyType({**found.evidence, **values}))


def nothing(body: Any, energy: float, evidence: dict, verdict: Verdict) -> TorusFit:
    """Return what there is to say of an orbit that failed, or is too short: its status."""
    n = body.degrees_of_freedom
    unknown, one = np.full(n, np.nan), np.full((2 * n, 1), np.nan + 0j)
    return TorusFit(
        names=traits_of(body).names,
        nu=unknown,
        nu_error=np.full(n, np.inf),
        J=unknown,
        theta0=unknown,
        k=np.zeros((1, n), int),
        coefficients=one,
        residual=np.inf,
        prediction_error=np.inf,
        verdict=verdict,
        dimension=n,
        relations=np.zeros((0, n), int),
        evidence=MappingProxyType(evidence),
        energy=energy,
        body=body,
    )


def point(
    body: Any, path: np.ndarray, evidence: dict, *, residual: float, rows: Any = slice(None), energy: float = math.nan
) -> TorusFit:
    """Return the torus of dimension 0 of an orbit (2n, samples) that stays where it is; its residual is absolute."""
    none, moved, size = np.zeros(0), np.ptp(path[rows], axis=1).max(), np.abs(path[rows]).max() or 1.0
    return replace(
        nothing(body, energy, evidence, Verdict.RESONANT),
        names=(),
        nu=none,
        nu_error=none,
        J=none,
        theta0=none,
        k=np.zeros((1, 0), int),
        coefficients=path[:, :1] + 0j,
        residual=residual,
        prediction_error=float(moved / size),
        dimension=0,
        relations=np.zeros((0, 0), int),
    )


def basis_name(unit: np.ndarray, R: np.ndarray, names: tuple[str, ...]) -> str:
    """Return the name of the frequency whose row of R is that unit vector, else a number."""
    return next(
        (name for row, name in zip(R, names, strict=True) if np.array_equal(row, unit)),
        f"theta {int(unit.argmax()) + 1}",
    )


def combination(row: np.ndarray, names: tuple[str, ...]) -> str:
    """Return an integer combination of names, like r-2*gamma."""
    text = "".join(
        f"{'+' if c > 0 else '-'}{'' if abs(c) == 1 else f'{abs(c)}*'}{name}" for c, name in zip(row, names) if c
    )
    return text.removeprefix("+")
