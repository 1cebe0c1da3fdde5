"""Two spectral lines that approach each other: the figure of docs/explanation/frequencies.md and its errors.

Run: python bench/resolution.py [docs/figures/resolution.png] [--write]. It prints the errors of both lines without
noise; with a path it draws the figure; --write puts the table of errors with noise into that page.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from pages import put

import fastaff as fa
from fastaff.frequencies.fundamental import band_sizes
from fastaff.frequencies.kernels.harmonic_inversion import PEAK_BASIS, new_band
from fastaff.frequencies.kernels.loop_lines import FEWEST, LoopLines, read_peaks, signed_places, split_peaks
from fastaff.frequencies.kernels.loop_transforms import SUMS, fill_transforms
from fastaff.frequencies.kernels.spectrum_lines import find_peaks
from fastaff.frequencies.windows import APART_ORDER, apart_window

SAMPLES, FIRST, PHASE = 200, 20.3, 0.7
AMPLITUDES = (1.0, 0.5)
APART = (10.0, 3.0, 2.2, 1.5, 1.0)
"""Distances of the two lines, in cycles over the samples."""

CLOSER = (*APART, 0.5, 0.2)
NOISE = (0.0, 1e-9, 1e-6, 1e-3)
"""Distances and root mean square noise of the table; the noise is relative to the amplitude of the first line."""

REPEATS = 200
PEAKS, LEAST = 2, 1e-2
"""Peaks whose bands are inverted, and smallest relative amplitude of a second line in a band."""

COLOURS = {"transform": "#7f7f7f", "lines": "#d55e00", "found": "#0072b2"}  # Okabe and Ito


def signal(apart: float) -> np.ndarray:
    """Return the samples (SAMPLES,) of two lines."""
    cycles = np.arange(SAMPLES) / SAMPLES
    first, second = (2j * np.pi * place * cycles for place in (FIRST, FIRST + apart))
    return AMPLITUDES[0] * np.exp(first) + AMPLITUDES[1] * np.exp(second + 1j * PHASE)


def inverted(f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return places, in bins, and amplitudes of the lines that harmonic inversion finds, the largest first."""
    n = f.size
    size = int(band_sizes(np.array([n]))[0])
    windowed, sums, edges = np.empty(n, complex), np.empty((SUMS, size), complex), np.empty((2, 3), complex)
    parts = np.ascontiguousarray(f.real), np.ascontiguousarray(f.imag)
    fill_transforms(*parts, apart_window(n), windowed.view(float), sums.view(float), edges)
    lines, band, transform = LoopLines(*np.zeros((4, 16))), new_band(PEAK_BASIS), np.fft.fft(sums, axis=-1)
    first = [entry[:PEAKS] for entry in (lines.place, lines.size, lines.doubt)]
    peaks, _ = find_peaks(np.fft.fft(windowed), APART_ORDER, FEWEST, PEAKS, *first)
    signed_places(lines, peaks, n)
    read_peaks(transform, edges, n, 0, peaks, lines, band)
    count = split_peaks(transform, edges, n, APART_ORDER, peaks, peaks, LEAST, lines, peaks, band)
    sharp = np.flatnonzero(lines.bar[:count] < 1.0)
    sharp = sharp[np.argsort(-lines.size[sharp])]
    return lines.place[sharp], lines.size[sharp]


def windowed_transform(f: np.ndarray, padding: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return places, in bins, and sizes of the transform with a Hann window, 1 for a line of amplitude 1."""
    window = 1.0 - np.cos(2 * np.pi * (np.arange(f.size) + 0.5) / f.size)
    size = np.abs(np.fft.fft(f * window, padding * f.size)) / f.size
    return np.arange(size.size) / padding, size


def distances(places: np.ndarray, apart: float) -> np.ndarray:
    """Return the distances (2,), in bins, of both lines from the nearest of places."""
    return np.array([np.abs(places - line).min(initial=np.inf) for line in (FIRST, FIRST + apart)])


def errors(f: np.ndarray, apart: float) -> dict[str, np.ndarray]:
    """Return the errors (2,), in bins, of both lines by each method."""
    place, size = windowed_transform(f)
    inner = (size > np.roll(size, 1)) & (size > np.roll(size, -1)) & (size > 0.1 * size.max())

    def fitted(lines: int) -> np.ndarray:
        return fa.naff(f, 1.0 / f.size, lines=lines).nu

    return {
        "largest bins": distances(place[inner], apart),
        "naff, 1 line": distances(fitted(1), apart),
        "naff, 2 lines": distances(fitted(2), apart),
        "inversion": distances(inverted(f)[0], apart),
    }


def printed(error: float) -> str:
    """Return an error, in bins."""
    if error < 1e-13:
        return "< 1e-13"
    return f"{error:.2f}" if error >= 0.01 else f"{error:.0e}".replace("e-0", "e-")


def figure() -> plt.Figure:
    """Return the figure, one row a distance: the transform and the lines on the left, the errors on the right."""
    mpl.rcParams.update({"font.size": 10, "axes.titlesize": 10.5})
    fig, axes = plt.subplots(
        len(APART), 2, figsize=(9.2, 9.6), sharex="col", width_ratios=(1.65, 1), layout="constrained"
    )
    for (left, right), apart in zip(axes, APART, strict=True):
        f = signal(apart)
        fine, bins = windowed_transform(f, 32), windowed_transform(f)
        left.semilogy(fine[0] - FIRST, fine[1], color=COLOURS["transform"], lw=1.0)
        left.semilogy(
            bins[0] - FIRST,
            bins[1],
            "o",
            color=COLOURS["transform"],
            ms=3.2,
            label="bins of the Fourier transform (Hann window)",
        )
        for line in (0.0, apart):
            label = "exact lines" if line == 0.0 else None
            left.axvline(line, ymin=0.70, color=COLOURS["lines"], lw=2.0, label=label)
        place, amplitude = inverted(f)
        left.plot(
            place - FIRST,
            amplitude,
            "D",
            mfc="none",
            mec=COLOURS["found"],
            mew=1.6,
            ms=8,
            label="lines by harmonic inversion",
        )
        left.set(xlim=(-8, 18), ylim=(2e-5, 20), yticks=[1e-4, 1e-2, 1], ylabel="amplitude")
        left.minorticks_off()
        left.text(
            0.985,
            0.93,
            f"{apart:g} cycle{'s' if apart != 1 else ''} apart",
            transform=left.transAxes,
            ha="right",
            va="top",
            weight="bold",
        )
        right.axis("off")
        rows = [
            (name, printed(first), printed(second) if second < 0.5 * apart else "not found")
            for name, (first, second) in errors(f, apart).items()
        ]
        for j, row in enumerate([("error (cycles)", "line 1", "line 2"), *rows]):
            for x, text, align in zip((0.0, 0.72, 1.0), row, ("left", "right", "right"), strict=True):
                strong = "bold" if row[0] == "inversion" else "normal"
                colour = COLOURS["found"] if row[0] == "inversion" else "0.35" if j == 0 else "black"
                right.text(x, 0.86 - 0.18 * j, text, ha=align, va="center", weight=strong, color=colour)
        right.axhline(0.77, color="0.7", lw=0.8)
        right.set(xlim=(0, 1), ylim=(0, 1))
    axes[-1, 0].set_xlabel("frequency relative to line 1 (cycles over the samples)")
    fig.legend(
        *axes[0, 0].get_legend_handles_labels(),
        loc="outside upper left",
        ncols=3,
        frameon=False,
        columnspacing=1.4,
        handletextpad=0.5,
    )
    return fig


def table() -> str:
    """Return the median of the larger error of both lines by inversion, with noise, in bins."""
    random = np.random.default_rng(1)
    heads = ["cycles apart", *("no noise" if level == 0 else f"noise {printed(level)}" for level in NOISE)]
    rows = ["|".join(["", *(f" {head} " for head in heads), ""]), "|" + "---|" * len(heads)]
    for apart in CLOSER:
        f, cells = signal(apart), []
        for level in NOISE:
            found = []
            for _ in range(REPEATS if level > 0 else 1):
                white = random.standard_normal((2, SAMPLES)) * level / np.sqrt(2)
                found.append(distances(inverted(f + white[0] + 1j * white[1])[0], apart).max())
            cells.append(printed(float(np.median(found))))
        rows.append("|".join(["", f" {apart:g} ", *(f" {cell} " for cell in cells), ""]))
    return "\n".join(rows)


def main() -> None:
    """Print the errors, and draw and write them if that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("figure", type=Path, nargs="?", help="such as docs/figures/resolution.png")
    parser.add_argument(
        "--write", action="store_true", help="the table with noise into docs/explanation/frequencies.md"
    )
    given = parser.parse_args()
    for apart in APART:
        for name, pair in errors(signal(apart), apart).items():
            print(f"{apart:4g} {name:14} {pair[0]:.1e} {pair[1]:.1e}")
    text = table()
    print(text)
    if given.write:
        put("docs/explanation/frequencies.md", "close lines", text)
    if given.figure is not None:
        figure().savefig(given.figure, dpi=110)


if __name__ == "__main__":
    main()
