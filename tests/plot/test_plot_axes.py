"""Default axes of figures show what varies: no coordinate that a section fixes, no variable against itself."""

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import fastaff as fa
from fastaff import plot

matplotlib.use("Agg")

ROESSLER = fa.ode("x'=-y-z; y'=x+a*y; z'=b+z*(x-c)", a=0.2, b=0.2, c=5.7)
PENDULUM = fa.ode("x'=v; v'=-sin(x)-g*v+f*cos(phi); phi'=w", periodic={"x": "2*pi", "phi": "2*pi"}, g=0.1, f=0.2, w=0.8)


def _axes():
    return Figure().subplots()


def _labels(drawn_on):
    return drawn_on.get_xlabel(), drawn_on.get_ylabel()


@pytest.mark.parametrize(
    ("model", "z0", "section", "labels"),
    [
        (ROESSLER, [1.0, 1.0, 0.0], "y=0+", ("$x$", "$z$")),
        (ROESSLER, [1.0, 1.0, 0.0], "x=0+", ("$y$", "$z$")),
        (PENDULUM, [0.1, 0.2, 0.0], "phi=pi/3", ("$x$", "$v$")),
    ],
)
def test_sections_of_odes_show_free_coordinates(model, z0, section, labels):
    cut = fa.poincare_map(model, z0, section=section, crossings=8, max_time=100.0)
    ax = _axes()
    drawn = plot.plot_section(cut, ax=ax)
    assert _labels(ax) == labels
    dots = drawn.points.get_offsets()
    for column, name in zip(dots.T, labels, strict=True):
        np.testing.assert_array_equal(np.sort(column), np.sort(cut[name.strip("$")][:, 0]))
    assert (np.ptp(dots, axis=0) > 1e-3).all()


@pytest.mark.parametrize(
    ("coordinates", "section", "labels"),
    [("x y z", "y=0+", ("$x$", "$z$")), ("x y px py", "x=0", ("$y$", "$py$")), ("x y u v", "u=0", ("$x$", "$y$"))],
)
def test_sections_of_samples_know_momenta_by_their_names(coordinates, section, labels):
    t = 0.05 * np.arange(400)
    rows = len(coordinates.split())
    samples = np.array([(1 + 0.1 * k) * np.sin((1 + 0.13 * k) * t + k) for k in range(rows)])
    cut = fa.sections.map_samples(samples, 0.05, section=section, coordinates=coordinates)
    ax = _axes()
    plot.plot_section(cut, ax=ax)
    assert _labels(ax) == tuple(f"${plot.symbol(name.strip('$'))}$" for name in labels)


def test_sections_of_hamiltonian_systems_show_a_pair():
    cut = fa.poincare_map(fa.HenonHeiles(), [0.0, 0.1, 0.3, 0.1], section="x=0", crossings=3, max_time=100.0)
    ax = _axes()
    plot.plot_section(cut, ax=ax)
    assert _labels(ax) == ("$y$", "$p_{y}$")
