"""Potentials of the body in space, written as one line of mathematics."""

from __future__ import annotations

import re
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.numbers import shown
from ...engine.values import told_apart
from ..models.matrix_potentials import of_invariants, of_stretches
from .arguments import text_of
from .formula import hamiltonian
from .grammar import parse

STRETCHES = ("D1", "D2", "D3")
INVARIANTS = ("I1", "I2", "I3", "J")
OF_STRETCHES = {
    "I1": "(D1**2 + D2**2 + D3**2)",
    "I2": "((D1*D2)**2 + (D2*D3)**2 + (D3*D1)**2)",
    "I3": "((D1*D2*D3)**2)",
    "J": "(D1*D2*D3)",
}
"""Invariants by the stretches, where a formula contains both."""

SAME = 1e-9
"""Relative change of V under an exchange of stretches that counts as 0."""

TRIED = 16
"""Points at which the symmetry of a formula is tried."""


@of_invariants
@inserts_parameters
class FormulaInvariants3(NamedTuple):
    """Hold a potential of the body in space that is a formula of the invariants. `formula3` makes it.

    Parameters
    ----------
    law : model
        V(I1, I2, I3, J) with I3 = J^2, and its derivatives, with the parameters as fields.

    References
    ----------
    Martens & Slawianowski, section 3 (deformation invariants), for n = 3.

    Examples
    --------
    >>> float(fa.models.formula3("I1/2 + 1/J").value(3.0, 3.0, 1.0))
    2.5
    """

    law: Any

    @property
    def formula(self) -> str:
        """Text of V."""
        return str(self.law.formula)

    def value(self, I1, I2, J):
        """Return the potential energy V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.law.potential_energy(I1, I2, J * J, J)

    def slopes(self, I1, I2, J):
        """Return the first derivatives of V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        tuple of float or ndarray
            Derivatives with respect to I1, I2 and J.
        """
        f1, f2, f3, f = self.law.force(I1, I2, J * J, J)
        return -f1, -f2, -f - 2 * J * f3

    def changes(self, I1, I2, J, dI1, dI2, dJ):
        """Return the change of the slopes along a vector.

        Parameters
        ----------
        {invariants3}
        {invariant_changes3}

        Returns
        -------
        tuple of float or ndarray
            Changes of the derivatives with respect to I1, I2 and J.
        """
        _, _, f3, _ = self.law.force(I1, I2, J * J, J)
        d1, d2, d3, d = self.law.tangent_force(I1, I2, J * J, J, dI1, dI2, 2 * J * dJ, dJ)
        return -d1, -d2, -d - 2 * (J * d3 + f3 * dJ)

    def margin(self, I1, I2, J):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            Margin of the formula.
        """
        return self.law.margin(I1, I2, J * J, J)


@of_stretches
@inserts_parameters
class FormulaStretches3(NamedTuple):
    """Hold a potential of the body in space that is a symmetric formula of the stretches. `formula3` makes it.

    Parameters
    ----------
    law : model
        V(D1, D2, D3) and its derivatives, with the parameters as fields.

    References
    ----------
    Martens & Slawianowski, section 3 (deformation invariants), for n = 3.

    Examples
    --------
    >>> float(fa.models.formula3("D1 + D2 + D3").value(1.0, 2.0, 3.0))
    6.0
    """

    law: Any

    @property
    def formula(self) -> str:
        """Text of V."""
        return str(self.law.formula)

    def value(self, D1, D2, D3):
        """Return the potential energy V.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.law.potential_energy(D1, D2, D3)

    def slopes(self, D1, D2, D3):
        """Return the first derivatives of V.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        tuple of float or ndarray
            Derivatives with respect to D1, D2 and D3.
        """
        f1, f2, f3 = self.law.force(D1, D2, D3)
        return -f1, -f2, -f3

    def changes(self, D1, D2, D3, d1, d2, d3):
        """Return the change of the slopes along a vector.

        Parameters
        ----------
        {stretches}
        {stretch_changes}

        Returns
        -------
        tuple of float or ndarray
            Changes of the derivatives with respect to D1, D2 and D3.
        """
        f1, f2, f3 = self.law.tangent_force(D1, D2, D3, d1, d2, d3)
        return -f1, -f2, -f3

    def margin(self, D1, D2, D3):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            Margin of the formula.
        """
        return self.law.margin(D1, D2, D3)


for _kind in (FormulaInvariants3, FormulaStretches3):
    told_apart(_kind)


@inserts_parameters
def formula3(text: str, /, *, domain: str | None = None, **parameters: float) -> FormulaInvariants3 | FormulaStretches3:
    """Make a potential of the body in space from a formula of V.

    All derivatives are exact.

    Parameters
    ----------
    text : str
        Potential energy V in the grammar of `affine_body`, of parameters and of

        * I1, I2, I3 or J, the invariants of phi^T phi and J = det phi = D1 D2 D3, I3 = J^2;
        * D1, D2, D3, the stretches. V must not change if they are exchanged. V may contain invariants, too.
    {formula_domain}
    {formula_parameters}

    Returns
    -------
    potential
        Potential for `Body3`. Its field `law` has the parameters as fields.

    Raises
    ------
    TypeError
        If `text` is not a text, or if a value is not a number.
    ValueError
        If the text is not a formula (no text is ever executed), a name has no value, or a value is not used. Also if V
        changes under an exchange of stretches, which are names of one matrix.
    ImportError
        If SymPy is missing and the formula is new.

    Notes
    -----
    * Domain: by default J > 0 if V contains J, I3 or a stretch, else all matrices.
    * Cost: a formula of invariants is as fast as a handwritten model. A formula of stretches takes a singular value
      decomposition in each force, 40 times as long.
    * Coinciding stretches: forces and their derivatives are regular.

    References
    ----------
    Martens & Slawianowski, section 3 (deformation invariants), for n = 3; Meurer et al. 2017, PeerJ Comput. Sci. 3,
    e103 (SymPy).

    Examples
    --------
    >>> potential = fa.models.formula3("C*I1/2 + J**-p", C=1.0, p=1.0)
    >>> fa.models.Body3(potential).potential_energy(1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0)
    np.float64(3.5)
    """
    written = text_of(text)
    program = parse(written, (*STRETCHES, *INVARIANTS), parameters)
    names = set(program.names)
    options: dict[str, Any] = dict(parameters)
    if domain is not None:
        names |= set(parse(domain, (*STRETCHES, *INVARIANTS), parameters, argument="domain").names)
    if names & set(STRETCHES):
        whole, bound = (_replaced(part, OF_STRETCHES) for part in (written, domain))
        law = hamiltonian(whole, coordinates=STRETCHES, domain=bound, **options)
        _check_symmetry(law, written)
        return FormulaStretches3(law)
    if domain is None and names & {"J", "I3"}:
        domain = "J"
    return FormulaInvariants3(hamiltonian(written, coordinates=INVARIANTS, domain=domain, **options))


def _replaced(text: str | None, by: dict[str, str]) -> Any:
    """Return a text with names replaced by formulas."""
    if text is None:
        return None
    return re.sub(rf"\b({'|'.join(by)})\b", lambda found: by[found[0]], text)


def _check_symmetry(law: Any, text: str) -> None:
    """Refuse a formula that changes if stretches are exchanged."""
    D = np.random.default_rng(3).uniform(0.5, 1.5, (3, TRIED))
    with np.errstate(all="ignore"):
        values = [np.broadcast_to(law.potential_energy(*D[list(order)]), TRIED) for order in permutations(range(3))]
        spread = np.ptp(values, axis=0)
        wrong = spread > SAME * np.abs(values).max(axis=0)
    if wrong.any():
        raise ValueError(f"text must not change if D1, D2 and D3 are exchanged, got {shown(text, 60)}.")
