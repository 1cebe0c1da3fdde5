"""Names of parameters on axes."""

from __future__ import annotations

from .style import symbol

KNOWN = {
    "energy": "energy $E$",
    "parameter": "parameter",
    "p_phi": r"spin $p_\varphi$",
    "p_psi": r"vorticity $p_\psi$",
    "mu": r"inertia $\mu$",
}


def parameter_label(name: str) -> str:
    """Return the label of a parameter for an axis."""
    return KNOWN.get(name) or (f"${symbol(name)}$" if name.replace("_", "").isalnum() else name)
