"""Draw the figure of `fastaff demo` for light and for dark pages of README, both from one computation.

Run: python docs/figures/demo.py. It writes examples/demo.png and examples/demo-dark.png in about two minutes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib import style

from fastaff.cli.demonstration import FULL, both, draw

EXAMPLES = Path(__file__).parents[2] / "examples"
GROUND = "#121212"
"""Ground of dark pictures, that of the inverted ones of dark.py: a grey of 7 %."""
STYLES: dict[str, list[Any]] = {
    "demo.png": ["default"],
    "demo-dark.png": ["default", "dark_background", {"figure.facecolor": GROUND, "axes.facecolor": GROUND}],
}
"""Styles of Matplotlib for each file."""


def drawn(portraits: Any, styles: list[Any]) -> Any:
    """Return the figure of both portraits in a style."""
    with style.context(styles):
        return draw(*portraits)


if __name__ == "__main__":
    portraits = both(FULL)
    for name, styles in STYLES.items():
        drawn(portraits, styles).savefig(EXAMPLES / name, facecolor="auto")
