"""Hyperelastic laws by name: stored energies W(D1, D2) of a planar body, as formulas.

The body is in plane strain (the third stretch is 1) and free of stress at rest, D1 = D2 = 1. For that each law of the
deviatoric part has a logarithm of D1 D2; it also has the volume term K/2 (D1 D2 - 1)^2 of `NeoHookean`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import Any

from ...core.numbers import listed, shown
from .grammar import FUNCTIONS
from .variables import VARIABLES

_VOLUME = "K/2*(D1*D2 - 1)**2"

INVARIANTS = {"I1": "D1**2 + D2**2 + 1", "I2": "D1**2*D2**2 + D1**2 + D2**2", "J": "D1*D2"}
"""Invariants of phi^T phi in plane strain, and det phi: letters of the literature, for formulas of bodies."""


def _ogden(terms: int) -> str:
    """Return the sum of terms (D1^m + D2^m - 2) c/m, with the logarithm that removes the stress at rest."""
    sums = " + ".join(f"c{k}/m{k}*(D1**m{k} + D2**m{k} - 2)" for k in range(1, terms + 1))
    return f"{sums} - ({' + '.join(f'c{k}' for k in range(1, terms + 1))})*log(D1*D2) + {_VOLUME}"


_EIGHT_CHAINS = (Fraction(1, 2), Fraction(1, 20), Fraction(11, 1050), Fraction(19, 7000), Fraction(519, 673750))
"""Coefficients of (I1^k - 3^k)/N^(k - 1) in the series of the inverse Langevin function, k = 1, 2, ..., 5."""


def _arruda_boyce() -> str:
    """Return five terms of the eight-chain law, G its shear modulus at rest, with the logarithm that removes the
    stress there.
    """
    trace = f"({INVARIANTS['I1']})"
    terms = [
        f"{c.numerator}*({trace}**{k} - {3**k})/({c.denominator}*N**{k - 1})" for k, c in enumerate(_EIGHT_CHAINS, 1)
    ]
    slope = " + ".join(f"{2 * k * c * 3 ** (k - 1)}/N**{k - 1}" for k, c in enumerate(_EIGHT_CHAINS, 1))
    return f"G/({slope})*({' + '.join(terms)}) - G*log(D1*D2) + {_VOLUME}"


LAWS: Mapping[str, str | Callable[[int], str]] = MappingProxyType(
    {
        "neo-hookean": f"G/2*(D1**2 + D2**2 - 2) - G*log(D1*D2) + {_VOLUME}",
        "mooney-rivlin": "c10*(D1**2 + D2**2 - 2) + c01*(D1**2*D2**2 + D1**2 + D2**2 - 3)"
        f" - 2*(c10 + 2*c01)*log(D1*D2) + {_VOLUME}",
        "ogden": _ogden,
        "yeoh": "c10*(D1**2 + D2**2 - 2) + c20*(D1**2 + D2**2 - 2)**2 + c30*(D1**2 + D2**2 - 2)**3"
        f" - 2*c10*log(D1*D2) + {_VOLUME}",
        "arruda-boyce": _arruda_boyce(),
        "gent": f"-G*Jm/2*log(1 - (D1**2 + D2**2 - 2)/Jm) - G*log(D1*D2) + {_VOLUME}",
        "hencky": "G*(log(D1)**2 + log(D2)**2) + lam/2*log(D1*D2)**2",
        "saint-venant-kirchhoff": "lam/8*(D1**2 + D2**2 - 2)**2 + G/4*((D1**2 - 1)**2 + (D2**2 - 1)**2)",
    }
)
"""The text of each, or a function of the number of its terms.

Source: Ogden 1984, Non-Linear Elastic Deformations, section 7.2 (neo-Hookean); Mooney 1940, J. Appl. Phys. 11, 582;
Rivlin 1948, Phil. Trans. R. Soc. A 241, 379; Ogden 1972, Proc. R. Soc. A 328, 567; Yeoh 1993, Rubber Chem. Technol. 66,
754; Arruda & Boyce 1993, J. Mech. Phys. Solids 41, 389 (five terms of the series); Gent 1996, Rubber Chem. Technol. 69,
59; Hencky 1928, Z. tech. Phys. 9, 215; Ciarlet 1988, Mathematical Elasticity I, section 4.4 (Saint Venant-Kirchhoff).
"""


def written_out(text: Any, letters: Mapping[str, Any]) -> tuple[Any, dict[str, Any]]:
    """Return the formula of a law that a text names, with its parameters; anything else as it is.

    The a1, a2, ... of Ogden's terms are fields c1, c2, ..., as a1 is a variable of formulas. Raises ValueError for
    missing letters and letters that the law does not have.
    """
    name = "-".join(text.lower().split()) if isinstance(text, str) else ""
    law = LAWS.get(name)
    if law is None:
        words = name.split("-")
        if all(re.fullmatch("[a-z]{3,}", word) and word not in {*VARIABLES, *letters} for word in words):
            raise ValueError(f"{shown(text)} is no law known by name, those are {listed(LAWS)}: write its formula")
        return text, dict(letters)
    values = {re.sub(r"^a(\d)$", r"c\1", key) if name == "ogden" else key: entry for key, entry in letters.items()}
    terms = max(1, sum(re.fullmatch(r"m\d", key) is not None for key in values))
    found = law if isinstance(law, str) else law(terms)
    needs = set(re.findall(r"[A-Za-z]\w*", found)) - {"D1", "D2", *FUNCTIONS}
    if needs != values.keys():
        takes = ", ".join(sorted(re.sub(r"^c(\d)$", r"a\1", key) if name == "ogden" else key for key in needs))
        raise ValueError(f"the law {shown(name)} takes the parameters {takes}; got {listed(sorted(letters)) or 'none'}")
    return found, values


def in_stretches(text: str, letters: Mapping[str, Any]) -> str:
    """Return the formula of a body with I1, I2 and J, where they are no parameters, written out in D1 and D2."""
    free = [name for name in INVARIANTS if name not in letters]
    if not free:
        return text
    return re.sub(rf"\b({'|'.join(free)})\b", lambda match: f"({INVARIANTS[match[1]]})", text)
