"""Write figures for dark pages beside those on white: each colour keeps its hue, light and dark change places.

Run: python docs/figures/dark.py examples/demo.png docs/figures/body.png. It writes examples/demo-dark.png and
docs/figures/body-dark.png, which README shows to readers with a dark theme. The site inverts all its figures in the
same way, by a filter of its style sheet.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.image as images
import numpy as np

INVERTED = 0.93
"""Share of the inverted picture in each colour, as in docs/_static/site.css: white becomes a grey of 7 %."""

TURNED = 2 * np.array([0.213, 0.715, 0.072]) * np.ones((3, 1)) - np.eye(3)
"""Matrix of a turn of hues by half a circle: twice the luminance less the colour (Filter Effects Module, hueRotate)."""


def darkened(picture: np.ndarray) -> np.ndarray:
    """Return the dark version of a picture (rows, columns, 3 or 4), values in [0, 1]."""
    colours = picture[..., :3]
    inverted = INVERTED * (1.0 - colours) + (1.0 - INVERTED) * colours
    found = picture.copy()
    found[..., :3] = np.clip(inverted @ TURNED.T, 0.0, 1.0)
    return found


if __name__ == "__main__":
    for name in sys.argv[1:]:
        path = Path(name)
        images.imsave(path.with_name(f"{path.stem}-dark.png"), darkened(images.imread(path)))
