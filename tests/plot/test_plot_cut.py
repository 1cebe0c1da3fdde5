"""Figures that show less than there is say so, and those that show all say nothing."""

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import fastaff as fa
from fastaff import plot

matplotlib.use("Agg")
BODY = fa.HenonHeiles()


def _axes():
    return Figure().subplots()


def _notes(drawn):
    return [text.get_text() for text in drawn.labels]


def test_sides_of_a_grid_beyond_which_there_is_more():
    """The section x = 0 at E = 0.12, whose p_y ends at sqrt(2 E) for y = 0."""
    narrow = fa.energy_grid(
        BODY, energy=0.12, section="x=0", axes=(np.linspace(-0.2, 0.9, 40), np.linspace(-0.6, 0.3, 40))
    )
    whole = fa.energy_grid(BODY, energy=0.12, section="x=0")
    values = np.ones(narrow.cell_index.size)
    for drawn in (plot.plot_starts(narrow), plot.plot_diffusion_grid(narrow, values), plot.plot_husimi(narrow, values)):
        assert _notes(drawn) == ["allowed too: $y < -0.2$, $p_{y} > 0.3$"]
    for drawn in (plot.plot_starts(whole), plot.plot_husimi(whole, np.ones(whole.cell_index.size))):
        assert _notes(drawn) == []
    edge = fa.plot.edge(BODY, "x=0", energy=0.12)
    for cells in (30, 50, 81):  # cells that end at the edge, and the upper half
        y, p_y = ((np.arange(cells) + 0.5) / cells * (high - low) + low for low, high in edge.axes)
        for axes in ((y, p_y), (y, (p_y - p_y[0]) / 2 + (p_y[1] - p_y[0]) / 4)):
            assert _notes(plot.plot_starts(fa.energy_grid(BODY, energy=0.12, section="x=0", axes=axes))) == []
    y, p_y = whole.axes
    assert 0.5 * p_y[-1] ** 2 == pytest.approx(0.12, rel=1e-3)
    assert [0.5 * r**2 - r**3 / 3 for r in y[[0, -1]]] == pytest.approx([0.12, 0.12], rel=1e-6)


def test_grids_of_maps_and_of_angles_have_no_sides():
    standard = fa.models.StandardMap(0.9)
    turn = np.linspace(-np.pi, np.pi, 20)
    assert _notes(plot.plot_starts(fa.energy_grid(standard, axes={"x": turn, "p": turn}))) == []


def test_crossings_beyond_the_frame_are_counted():
    """Escaping orbits go far away: the frame is around those that stay."""
    starts = fa.energy_sample(BODY, energy=0.19, section="x=0", orbits=40, seed=3, axes=((-0.6, 1.0), (-0.6, 0.6)))
    cut = fa.poincare_map(BODY, starts, section="x=0", crossings=50, max_time=300.0)
    drawn = plot.plot_section(cut)
    ax = drawn.points.axes
    gone = ~np.isin(cut.status, (fa.Status.OK, fa.Status.TOO_FEW_CROSSINGS))
    y, p_y = (cut[name][:, gone].ravel() for name in ("y", "p_y"))
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    with np.errstate(invalid="ignore"):
        beyond = np.isfinite(y) & ~((x0 <= y) & (y <= x1) & (y0 <= p_y) & (p_y <= y1))
    assert beyond.any()
    assert _notes(drawn) == [f"{beyond.sum()} crossings of grey orbits beyond the axes"]


def test_spacings_above_the_top_are_counted():
    spacings = np.random.default_rng(1).exponential(size=500)
    drawn = plot.plot_spacings(spacings, fa.quantum.BerryRobnik(0.0))
    assert _notes(drawn) == [f"{(spacings > 3.5).sum()} of 500 spacings above 3.5"]
    assert _notes(plot.plot_spacings(spacings, fa.quantum.BerryRobnik(0.0), top=20.0)) == []


def test_the_frame_of_a_density_holds_what_is_allowed():
    """That of EQ2.2h's elementary states ends where V = E."""
    body = fa.Body(fa.NeoHookean(G=1.0, K=2.0), mu=1.0)
    state = fa.quantum.spectrum(body, m=2, l=0, count=12).state(0)
    x1 = plot.plot_density(state).points.axes.get_xlim()[1]
    r = np.linspace(0.01, 40, 4000)
    angle = np.linspace(0.01, 1.57, 200)[:, None]
    A, B = r * np.cos(angle / 2) ** 2, r * np.sin(angle / 2) ** 2
    allowed = body.potential.value(A, B) + (2 * state.hbar) ** 2 / (8 * body.mu) * (1 / A + 1 / B) < state.energy
    end = r[allowed.any(axis=0)].max()
    held = plot.plot_density(state, model=body).points.axes.get_xlim()[1]
    assert held > end
    assert held >= x1


def test_a_section_draws_the_edge_of_its_own_energy(tmp_path):
    """That of `edge` at the energy and momenta of the starts; of a file too; orbits of two energies have none."""
    rng = np.random.default_rng(11)
    energy, spin = rng.uniform(0.8, 1.4), rng.uniform(0.05, 0.3)
    rubber = fa.Body(fa.NeoHookean())
    for body, section, planes in (
        (BODY, "x=0", {"energy": rng.uniform(0.05, 0.15)}),
        (rubber, "alpha-turning", {"energy": energy, "p_eta": spin, "p_gamma": 0.1}),
    ):
        starts = fa.energy_sample(body, section=section, orbits=5, seed=3, **planes)
        cut = fa.poincare_map(body, starts, section=section, crossings=4, max_time=200.0, accuracy=1e-6)
        edge = fa.plot.edge(body, section, **planes)
        for found in (cut, fa.load(fa.save(tmp_path / section, cut))):
            ((curve,), u) = found.plot(boundary=True, ax=_axes()).lines, edge.coordinate
            np.testing.assert_allclose(curve.get_xdata()[: u.size], u, rtol=1e-6)
            np.testing.assert_allclose(curve.get_ydata()[: u.size], edge.momentum, atol=1e-5)
        assert cut.plot(boundary=False, ax=_axes()).lines == ()
    mixed = fa.poincare_map(
        BODY, [[0.0] * 2, [0.1] * 2, [0.3, 0.2], [0.1] * 2], section="x=0", crossings=2, max_time=99.0
    )
    with pytest.raises(ValueError, match=r"needs orbits of one energy, got 0.02\d+ to 0.05\d+: give boundary="):
        mixed.plot(boundary=True, ax=_axes())
    with pytest.raises(ValueError, match="boundary=True needs the call that made the map"):
        cut[:2].plot(boundary=True, ax=_axes())
