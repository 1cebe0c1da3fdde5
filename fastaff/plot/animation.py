"""Animations: the body itself, a deforming ellipse with material lines, points of plane systems in their wells,
linkages of rods, and several bodies in a plane.
"""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import positive, whole
from ..core.placing import write_atomically
from ..core.status import Status
from ..results.progress import says_progress
from ..runs.integrate import integrate
from ..runs.requirements import current_system
from ..runs.starts import starts_of
from ..sections.energy_shell import Momenta
from ..systems.charts import CARTESIAN
from ..systems.models.contracts import SeparableModel
from ..systems.models.mechanics import System
from .curves import BODY, planes_of
from .sections import words
from .style import Palette, styled, symbol

ENDINGS = (".gif", ".mp4")
SPOKES = 8
"""Material lines: halves of diameters."""

RINGS = (1 / 3, 2 / 3)
"""Material lines: radii of circles inside the body's edge."""

COLOURS = 128
"""Colours of a GIF."""
FINE = 8
"""States of a point's trace for each frame."""
TRAIL = 0.2
"""Part of the time that a trace is drawn for."""
ROUND = np.linspace(0.0, 2 * np.pi, 121)


class Animation(NamedTuple):
    """Frames of motions: figure; draw(k), which sets the figure to frame k; numbers of frames, and of frames a second.

    A notebook shows it as a GIF.
    """

    figure: Any
    draw: Callable[[int], None]
    frames: int
    rate: int

    def __repr__(self) -> str:
        return f"<Animation of {self.frames} frames, {self.frames / self.rate:.3g} s>"

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        with tempfile.TemporaryDirectory() as folder:
            image = save_animation(self, Path(folder) / "animation.gif", dpi=80).read_bytes()
        return {"image/gif": base64.b64encode(image).decode(), "text/plain": repr(self)}


@inserts_parameters
def animate(
    model: SeparableModel,
    z0: Any,
    *,
    time: float,
    frames: int = 200,
    rate: int = 25,
    accuracy: float = 1e-8,
    titles: Sequence[str] | None = None,
    threads: int | None = None,
) -> Animation:
    """Animate a motion: a body as an ellipse, two coordinates as a point, a pendulum as its rods, several bodies.

    Parameters
    ----------
    model : model
        Body with phase points of 8 rows, model of two degrees of freedom, or bodies with coordinates x1, y1, x2, y2,
        ... A model with a method ``joints(q1, q2)``, which returns x and y of the ends of rods, is drawn as rods, for
        example `DoublePendulum`.
    z0 : array_like, shape (2n,) or (2n, motions)
        Initial conditions. Each motion has a panel.
    time : float
        Length of the motion, positive, in units of time.
    frames : int, default 200
        Number of frames at equal times from 0.
    rate : int, default 25
        Frames per second.
    accuracy : float, default 1e-8
        Requested error of the orbits, relative to the amplitudes of the motion.
    titles : sequence of str, optional
        Titles of the panels.
    {threads}

    Returns
    -------
    Animation
        Animation for `save_animation`. A notebook shows it as a GIF.

    Raises
    ------
    TypeError
        If the model is not supported or an argument has the wrong type.
    ValueError
        If an argument has a wrong value or shape.

    Notes
    -----
    - A body is drawn as the ellipse of the unit circle of its material, with material lines. One line in another colour
      shows the rotation and its end leaves a trace. The stretches D1 and D2 are drawn against time below.
    - Several bodies have a colour each and leave traces.
    - A point moves over lines of equal potential. For nonseparable H(q, p) they are lines of the least energy over p.
    - An orbit that escapes stays at its last place.
    - Cost: one integration, and 0.05 s per frame that is written.

    References
    ----------
    Martens & Slawianowski, section 2 (y = phi a), section 3 (D1, D2).

    Examples
    --------
    >>> film = fa.plot.animate(fa.HenonHeiles(), [0.1, 0.1, 0.3, 0.2], time=2.0, frames=3)
    >>> film
    <Animation of 3 frames, 0.12 s>
    """
    time = positive("time", time)
    frames = whole("frames", frames, 2)
    rate = whole("rate", rate, 1)
    z0 = starts_of(z0, model)
    rows = np.shape(z0)[0] if np.ndim(z0) else 0
    fine = 1 if rows == 8 else FINE  # a trace is a curve
    run = integrate(model, z0, time=time, samples=fine * (frames - 1), accuracy=accuracy, threads=threads)
    affine = rows == 8 and tuple(run.names[:4]) == BODY
    several = planes_of(tuple(run.names)) if len(planes_of(tuple(run.names))) > 1 else []
    if not (affine or several or rows == 4):
        raise ValueError(
            "model must be a body in the planes a and b, have two coordinates, or bodies x1, y1, x2, y2, ..., got "
            f"{len(run.z) // 2} coordinates"
        )
    start = np.asarray(z0, float).reshape(rows, -1)
    states = np.concatenate([start[None], run.samples.reshape(fine * (frames - 1), rows, -1)])
    status = np.atleast_1d(run.status)
    motions = start.shape[1]
    if titles is not None and len(titles) != motions:
        raise ValueError(f"titles must have {motions} entries, one for each motion, got {len(titles)}")
    times = np.linspace(0.0, time, len(states))
    states = _held(states)
    heads = [""] * motions if titles is None else list(titles)
    heads = [_head(title, code) for title, code in zip(heads, status, strict=True)]
    with styled():
        kind = _bodies if affine else _several if several else _linkages if hasattr(model, "joints") else _points
        figure, panels = kind(current_system(model), states, times, heads, run.names)

    def draw(k: int) -> None:
        for panel in panels:
            panel(fine * int(k))

    draw(0)
    return Animation(figure, draw, frames, rate)


def _head(title: str, status: int) -> str:
    """Return the title of a panel, with the outcome of the motion."""
    return title if status == Status.OK else f"{title}  ({words(status)})".strip()


def _held(states: np.ndarray) -> np.ndarray:
    """Return states (frames, 2n, motions) whose motions stay at their last finite state."""
    last = np.zeros(states.shape[2], int)
    held = states.copy()
    for k in range(len(states)):
        fine = np.isfinite(states[k]).all(axis=0)
        last = np.where(fine, k, last)
        held[k] = states[last, :, np.arange(last.size)].T
    return held


def matrices(z: np.ndarray) -> np.ndarray:
    """Return phi (2, 2, ...) of phase points (8, ...) of a body: the material point a is at phi a."""
    x, y, third, u = CARTESIAN.points_from_planes(z[:4])
    return np.array([[x, y], [third, u]])


def material_lines() -> tuple[list[np.ndarray], np.ndarray]:
    """Return the body's lines, each (2, points) in the material: rings and spokes, and the marked spoke."""
    circle = np.array([np.cos(ROUND), np.sin(ROUND)])
    angles = 2 * np.pi * np.arange(1, SPOKES) / SPOKES
    spokes = [np.outer([np.cos(a), np.sin(a)], [0.0, 1.0]) for a in angles]
    return [circle, *(r * circle for r in RINGS), *spokes], np.array([[0.0, 1.0], [0.0, 0.0]])


def _bodies(system: System, states: np.ndarray, times: np.ndarray, heads: list[str], names: Any) -> tuple[Any, list]:
    """Return a figure of bodies, each above its stretches, and the functions that draw its frames."""
    from matplotlib.figure import Figure

    count = len(heads)
    figure = Figure(figsize=(4.0 * count, 5.2), dpi=100, layout="constrained")
    axes = figure.subplots(2, count, squeeze=False, height_ratios=(3.4, 1.0))
    phi = matrices(states.transpose(1, 0, 2))  # (2, 2, frames, motions)
    size = 1.05 * float(np.sqrt((phi**2).sum(axis=1)).max())
    return figure, [
        _body(axes[0, k], axes[1, k], phi[..., k], states[:, :, k], times, size, heads[k]) for k in range(count)
    ]


def _body(
    above: Any, below: Any, phi: np.ndarray, z: np.ndarray, times: np.ndarray, size: float, head: str
) -> Callable[[int], None]:
    """Draw one body; return the function that sets it to a frame."""
    lines, marked = material_lines()
    palette = Palette.of(above)
    above.set(xlim=(-size, size), ylim=(-size, size), aspect="equal", xticks=[], yticks=[], title=head)
    for side in above.spines.values():
        side.set_color(palette.grey(0.85))
    (inside,) = above.fill([], [], color=palette.tint, zorder=1)
    thin = [above.plot([], [], color=palette.main, lw=1.8 if k == 0 else 0.7, zorder=3)[0] for k in range(len(lines))]
    (spoke,) = above.plot([], [], color=palette.accent, lw=2.0, zorder=4)
    (trace,) = above.plot([], [], color=palette.accent, lw=0.8, alpha=0.6, zorder=2)
    tip = phi[:, 0]  # of the marked spoke
    alpha = np.hypot(z[:, 0], z[:, 1])
    beta = np.hypot(z[:, 2], z[:, 3])
    stretches = (alpha + beta) / np.sqrt(2), (alpha - beta) / np.sqrt(2)
    for row, colour, name in zip(stretches, (palette.main, palette.pale), ("D_1", "D_2")):
        below.plot(times, row, color=colour, lw=0.9, label=f"${name}$")
    below.legend(loc="lower right", bbox_to_anchor=(1.0, 0.93), ncols=2, frameon=False, borderpad=0.2, handlelength=1.2)
    below.set(xlabel="time $t$", xlim=(times[0], times[-1]))
    now = below.axvline(times[0], color=palette.accent, lw=1.2)

    def draw(k: int) -> None:
        matrix = phi[:, :, k]
        for line, curve in zip(thin, lines):
            line.set_data(*(matrix @ curve))
        inside.set_xy((matrix @ lines[0]).T)
        spoke.set_data(*(matrix @ marked))
        first = max(0, k - int(TRAIL * len(times)))
        trace.set_data(*tip[:, first : k + 1])
        now.set_xdata([times[k]] * 2)

    return draw


def _points(system: System, states: np.ndarray, times: np.ndarray, heads: list[str], names: Any) -> tuple[Any, list]:
    """Return a figure of points in their potential, and the functions that draw its frames."""
    from matplotlib.figure import Figure

    count = len(heads)
    figure = Figure(figsize=(4.4 * count, 4.4), dpi=100, layout="constrained")
    axes = figure.subplots(1, count, squeeze=False)[0]
    middle = 0.5 * (states[:, :2].max(axis=(0, 2)) + states[:, :2].min(axis=(0, 2)))
    half = 0.7 * float(np.ptp(states[:, :2], axis=0).max()) or 1.0
    x, y = (np.linspace(c - half, c + half, 181) for c in middle)
    X, Y = np.meshgrid(x, y)
    V = _wells(system, np.array([X, Y]))
    panels = []
    for k, ax in enumerate(axes):
        z = states[0, :, k]
        energy = float(system.energies(z))
        palette = Palette.of(ax)
        low = float(np.min(V, where=np.isfinite(V), initial=np.inf))
        if energy > low:
            ax.contour(x, y, V, levels=np.linspace(low, energy, 8)[1:-1], colors=[palette.grey(0.82)], linewidths=0.7)
            ax.contour(x, y, V, levels=[energy], colors=[palette.lost], linewidths=1.4)
        ax.set(title=heads[k], aspect="equal", xlabel=f"${symbol(names[0])}$", ylabel=f"${symbol(names[1])}$")
        panels.append(_point(ax, states[:, :2, k], palette.main, palette.accent))
    return figure, panels


def _wells(system: System, q: np.ndarray) -> np.ndarray:
    """Return the least energy at positions q (2, ...), NaN where there is none or it is not known."""
    with np.errstate(all="ignore"):
        if system.separable:
            return np.where(system.inside(np.concatenate([q, 0 * q])), system.least_energies(q), np.nan)
        if not system.ellipsoidal:
            return np.full(q.shape[1:], np.nan)
        V = Momenta.of(system).floor(q)
        return np.where(np.isfinite(V), V, np.nan)


def _linkages(system: System, states: np.ndarray, times: np.ndarray, heads: list[str], names: Any) -> tuple[Any, list]:
    """Return a figure of rods, and the functions that draw its frames."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.0 * len(heads), 4.0), dpi=100, layout="constrained")
    axes = figure.subplots(1, len(heads), squeeze=False)[0]
    places = np.array(system.model.joints(states[:, 0], states[:, 1]))  # (2, joints, frames, motions)
    size = 1.1 * float(np.abs(places).max())
    panels = []
    for k, ax in enumerate(axes):
        ax.set(xlim=(-size, size), ylim=(-size, size), aspect="equal", xticks=[], yticks=[], title=heads[k])
        panels.append(_linkage(ax, places[..., k]))
    return figure, panels


def _linkage(ax: Any, places: np.ndarray) -> Callable[[int], None]:
    """Draw rods between joints (2, joints, frames), and the trace of the last; return the function that sets frames."""
    palette = Palette.of(ax)
    (trace,) = ax.plot([], [], color=palette.pale, lw=0.9)
    style = {"color": palette.main, "mfc": palette.accent, "mec": palette.main}
    (rods,) = ax.plot([], [], "-o", lw=1.6, ms=7, zorder=4, **style)

    def draw(k: int) -> None:
        trace.set_data(*places[:, -1, max(0, k - int(TRAIL * places.shape[2])) : k + 1])
        rods.set_data(*places[:, :, k])

    return draw


def _point(ax: Any, path: np.ndarray, ink: str, fill: str, label: str | None = None) -> Callable[[int], None]:
    """Draw one point (frames, 2) with its trace; return the function that sets it to a frame."""
    (whole_way,) = ax.plot([], [], color=Palette.of(ax).pale, lw=0.6, alpha=0.7)
    (trace,) = ax.plot([], [], color=ink, lw=1.3)
    (point,) = ax.plot([], [], "o", color=fill, ms=7, zorder=4, label=label)

    def draw(k: int) -> None:
        whole_way.set_data(*path[: k + 1].T)
        trace.set_data(*path[max(0, k - int(TRAIL * len(path))) : k + 1].T)
        point.set_data(*path[k : k + 1].T)

    return draw


def _several(system: System, states: np.ndarray, times: np.ndarray, heads: list[str], names: Any) -> tuple[Any, list]:
    """Return a figure of bodies x1, y1, x2, y2, ... with their traces, and the functions that draw its frames."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.4 * len(heads), 4.4), dpi=100, layout="constrained")
    axes = figure.subplots(1, len(heads), squeeze=False)[0]
    rows = [[names.index(name) for name in pair] for pair in planes_of(tuple(names))]
    paths = states[:, rows]  # (frames, bodies, 2, motions)
    low, high = paths.min(axis=(0, 1, 3)), paths.max(axis=(0, 1, 3))
    half = 0.55 * float((high - low).max()) or 1.0
    panels = []
    for k, ax in enumerate(axes):
        middle = 0.5 * (low + high)
        ends = {f"{axis}lim": (c - half, c + half) for axis, c in zip("xy", middle, strict=True)}
        ax.set(title=heads[k], aspect="equal", xlabel="$x$", ylabel="$y$", **ends)
        curves = Palette.of(ax).curves
        for body, name in enumerate(pair[0][1:] for pair in planes_of(tuple(names))):
            colour, _ = curves[body % len(curves)]
            panels.append(_point(ax, paths[:, body, :, k], colour, colour, f"body {name}"))
        ax.legend(loc="upper right")
    return figure, panels


def _frames(animation: Animation, callback: Any) -> Iterator[None]:
    """Set the figure to one frame after the other; it is laid out once."""
    animation.draw(0)
    animation.figure.draw_without_rendering()
    animation.figure.set_layout_engine("none")
    for k in range(animation.frames):
        animation.draw(k)
        yield
        if callback is not None:
            callback((k + 1) / animation.frames)


def _write_gif(animation: Animation, name: str, dpi: float, callback: Any) -> None:
    """Write a GIF: all frames in the colours of the last one, without dithering, which would multiply its size."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    animation.figure.set_dpi(dpi)
    canvas = FigureCanvasAgg(animation.figure)
    images = []
    for _ in _frames(animation, callback):
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()))
    palette = images[-1].quantize(COLOURS, dither=Image.Dither.NONE)
    first, *others = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    first.save(name, save_all=True, append_images=others, duration=1000 / animation.rate, loop=0, disposal=1)


def _write_mp4(animation: Animation, name: str, dpi: float, callback: Any) -> None:
    """Write an MP4 by ffmpeg, in the pixels that players know."""
    from matplotlib.animation import FFMpegWriter

    writer = FFMpegWriter(fps=animation.rate, codec="h264", extra_args=["-pix_fmt", "yuv420p", "-crf", "20"])
    with writer.saving(animation.figure, name, dpi):
        for _ in _frames(animation, callback):
            writer.grab_frame()


@says_progress
@inserts_parameters
def save_animation(
    animation: Animation, path: Any, *, dpi: float = 100.0, overwrite: bool = False, callback: Any = None
) -> Path:
    """Write an animation as a GIF, or as an MP4 if ffmpeg is installed.

    Parameters
    ----------
    animation : Animation
        Animation of `animate`.
    path : path_like
        Path of the file, which ends with .gif or .mp4.
    dpi : float, default 100
        Pixels per inch.
    overwrite : bool, default False
        Replace an existing file. Otherwise the new file gets a number.
    {callback}

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    ValueError
        If the path has another ending or ffmpeg is missing.
    FileNotFoundError
        If the folder does not exist.

    Notes
    -----
    The file is complete or absent: it is written under another name and then moved.

    Examples
    --------
    >>> film = fa.plot.animate(fa.HenonHeiles(), [0.1, 0.1, 0.3, 0.2], time=2.0, frames=3)
    >>> fa.plot.save_animation(film, "orbit.gif", dpi=30.0).name
    'orbit.gif'
    """
    from matplotlib.animation import FFMpegWriter

    path = Path(path)
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise ValueError(f"path must end with {' or '.join(ENDINGS)}, got {path}")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"path {path}: the folder {path.parent} does not exist")
    dpi = positive("dpi", dpi)
    if ending == ".mp4" and not FFMpegWriter.isAvailable():
        raise ValueError("path must end with .gif: .mp4 needs the program ffmpeg, which is not installed")
    write = _write_gif if ending == ".gif" else _write_mp4
    return write_atomically(
        path.with_suffix(""), path.suffix, lambda name: write(animation, str(name), dpi, callback), overwrite=overwrite
    )
