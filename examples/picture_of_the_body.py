"""Draw an affinely-rigid body: its two stretches and two angles, and the two planes of the regular coordinates.

Run: python examples/picture_of_the_body.py [docs/figures/body.png]
"""

from __future__ import annotations

import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

D1, D2 = 1.55, 0.6
PHI, PSI = np.radians(62.0), np.radians(24.0)
"""Stretches, the angle of the ellipse in space, and the angle of its main axis in the material."""

BODY, MATERIAL, AXES = "#9ecae1", "#08519c", "#b30000"


def rotation(angle: float) -> np.ndarray:
    """Return the matrix that rotates by an angle."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


CONFIGURATION = rotation(PHI) @ np.diag([D1, D2]) @ rotation(PSI).T


def arrow(ax: Axes, end: np.ndarray, colour: str, label: str, offset: tuple[float, float]) -> None:
    """Draw an arrow from the origin, with its name beside the tip."""
    ax.annotate(
        "", end, (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0}
    )
    ax.annotate(label, end, offset, textcoords="offset points", color=colour, fontsize=11, ha="center", va="center")


def arc(ax: Axes, radius: float, angle: float, label: str, colour: str = "0.25") -> None:
    """Draw an angle, counted from the horizontal axis."""
    along = np.linspace(0.0, angle, 60)
    ax.plot(radius * np.cos(along), radius * np.sin(along), color=colour, lw=1.0)
    middle = 0.55 * angle
    ax.text(
        1.22 * radius * np.cos(middle), 1.22 * radius * np.sin(middle), label, color=colour, ha="center", va="center"
    )


def material(ax: Axes, matrix: np.ndarray) -> None:
    """Draw a disc with a grid of material lines, as a matrix deforms it."""
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 300))
    edge = matrix @ [circle.real, circle.imag]
    ax.fill(*edge, color=BODY, alpha=0.45, lw=0)
    ax.plot(*edge, color=MATERIAL, lw=1.4)
    for offset in np.linspace(-0.75, 0.75, 7):
        half = np.sqrt(1 - offset**2)
        for line in ([[offset, offset], [-half, half]], [[-half, half], [offset, offset]]):
            ax.plot(*(matrix @ line), color=MATERIAL, lw=0.5, alpha=0.55)


def frame(ax: Axes, title: str, reach: float) -> None:
    """Give an axis a title, equal scales and a horizontal line from which angles are counted."""
    ax.plot([0, reach], [0, 0], color="0.6", lw=0.8, ls=(0, (4, 3)))
    ax.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
    ax.set_title(title, fontsize=11)
    ax.axis("off")


def plane(ax: Axes, point: np.ndarray, radius: str, angle: str, name: str, title: str) -> None:
    """Draw one of the two planes with the point of the configuration and its polar coordinates."""
    frame(ax, title, 2.0)
    ax.plot([-1.9, 1.9], [0, 0], color="0.6", lw=0.8)
    ax.plot([0, 0], [-1.9, 1.9], color="0.6", lw=0.8)
    ax.text(1.9, -0.2, f"${name}_1$", ha="right", va="center", color="0.4")
    ax.text(0.2, 1.85, f"${name}_2$", ha="left", va="center", color="0.4")
    arrow(ax, point, AXES, "", (0, 0))
    ax.plot(*point, "o", color=AXES, ms=5)
    half = point / 2
    normal = np.array([-point[1], point[0]]) / np.hypot(*point)
    ax.text(*(half + 0.22 * normal), radius, color=AXES, fontsize=12, ha="center", va="center")
    arc(ax, 0.45, np.arctan2(point[1], point[0]), angle)


def draw() -> plt.Figure:
    """Return the figure."""
    figure, (left, body, plane_a, plane_b) = plt.subplots(1, 4, figsize=(11.5, 3.1))
    main, other = rotation(PSI).T[0], rotation(PSI).T[1]  # material directions that become the axes of the ellipse

    frame(left, "material", 1.7)
    material(left, np.eye(2))
    arrow(left, main, AXES, "1", (5, 8))
    arrow(left, other, AXES, "1", (-8, 4))
    arc(left, 0.42, PSI, r"$\psi$")

    frame(body, r"body in space, $x = \varphi\, a$", 1.7)
    material(body, CONFIGURATION)
    arrow(body, CONFIGURATION @ main, AXES, r"$D_1$", (8, 9))
    arrow(body, CONFIGURATION @ other, AXES, r"$D_2$", (-9, 6))
    arc(body, 0.6, PHI, r"$\phi$")

    (x, y), (z, u) = CONFIGURATION
    a, b = np.array([x + u, z - y]) / np.sqrt(2), np.array([x - u, y + z]) / np.sqrt(2)
    plane(
        plane_a, a, r"$\alpha$", r"$\eta$", "a", r"plane $a$:  $\alpha = (D_1 + D_2)/\sqrt{2}$,  $\eta = \phi - \psi$"
    )
    plane(
        plane_b, b, r"$\beta$", r"$\gamma$", "b", r"plane $b$:  $\beta = (D_1 - D_2)/\sqrt{2}$,  $\gamma = \phi + \psi$"
    )
    for ax in (plane_a, plane_b):
        ax.title.set_fontsize(9.5)
    figure.tight_layout()
    return figure


if __name__ == "__main__":
    draw().savefig(sys.argv[1] if len(sys.argv) > 1 else "body.png", dpi=160, bbox_inches="tight", pad_inches=0.05)
