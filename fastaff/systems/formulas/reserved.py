"""Bounds of formulas, and the names that their parameters cannot have."""

from ...engine.kinds import TERMS

MAX_DEGREES_OF_FREEDOM = 16
"""Most coordinates of a text. More would work: 32 compile in seconds; the limit on parts of a formula comes first."""

_OF_MODELS = """
degrees_of_freedom coordinates kind angles velocity tangent_velocity force tangent_force kinetic_energy
energy potential_energy margin value slopes curvatures second higher formula domain proof rates tangent_rates
iterate tangent_iterate symplectic momenta periods poles potential ring period phase masses
"""

WITHOUT_BODY = {
    *dir(tuple),
    *_OF_MODELS.split(),
    *(term.rate for term in TERMS.values()),
    *(f"m_{i}" for i in range(1, MAX_DEGREES_OF_FREEDOM + 1)),
}
"""Names that parameters of systems other than bodies cannot have: they have a meaning in the model."""

RESERVED = WITHOUT_BODY | {"mu", "mu_1", "mu_2"}
"""Those that parameters of bodies cannot have: also the inertia."""
