"""Figures: what they draw, where the section ends, which resonances are labelled."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
import shared_systems

import fastaff
from fastaff import plot
from fastaff.systems.models.mechanics import system_of

matplotlib = pytest.importorskip("matplotlib")

NEO = fastaff.Body(fastaff.NeoHookean())
SURFACE = {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2}


def section_map(orbits=3, crossings=5):
    rng = np.random.default_rng(0)
    points = rng.uniform(0.5, 1.0, (8, crossings, orbits))
    counts = np.full(orbits, crossings)
    counts[-1] = 0
    points[..., -1] = np.nan
    return fastaff.sections.SectionMap(
        points,
        np.where(np.isnan(points[0]), np.nan, 1.0),
        counts,
        np.zeros(orbits),
        np.zeros(orbits),
        np.array([0] * (orbits - 1) + [5]),
        fastaff.AlphaTurning(),
        fastaff.KAHAN_LI8,
        0.01,
        system_of(fastaff.Body(fastaff.Hyperelastic())).row_names,
    )


def frequency_map(ratio, gamma):
    """A map of a body whose second libration is `ratio` times the first."""
    nu = np.array([np.ones_like(ratio), ratio, gamma / 2, gamma / 2])
    zero = np.zeros(ratio.size)
    return fastaff.frequencies.FrequencyMap(
        ("alpha", "beta", "phi", "psi"),
        nu,
        0 * nu,
        np.linspace(-9, -2, ratio.size),
        zero,
        zero.astype(int),
        zero,
        gamma,
        100.0,
        fastaff.KAHAN_LI8,
        0.01,
        zero.astype(int),
        zero.astype(int) + 4,
        nu,
        0 * nu,
        np.zeros((4, 4, ratio.size), int),
    )


SECTIONS = [
    fastaff.AlphaTurning(+1),
    fastaff.BetaTurning(-1),
    fastaff.AlphaEquals(1.4),
    fastaff.BetaEquals(0.5),
    fastaff.AreaEquals(1.0),
]


@pytest.mark.parametrize("section", SECTIONS, ids=repr)
def test_edge_is_where_the_energy_grid_ends(section):
    edge = plot.edge(NEO, section, **SURFACE)
    assert edge.momentum[[0, -1]] == pytest.approx(0.0, abs=1e-4)
    middle = slice(40, -40, 40)
    # Negative momenta: on an area section the direction forbids some of the positive ones.
    for u, p in zip(edge.coordinate[middle], -edge.momentum[middle]):
        inside = fastaff.energy_grid(NEO, section=section, axes=([u], [0.95 * p]), **SURFACE)
        assert inside.cell_index.size == 1
        with pytest.raises(ValueError, match=r"axes must reach points of energy 1\.5 on"):
            fastaff.energy_grid(NEO, section=section, axes=([u], [1.01 * p]), **SURFACE)


def test_edge_of_henon_heiles_is_the_well_not_the_valleys():
    edge = plot.edge(fastaff.HenonHeiles(), fastaff.Hyperplane((1, 0, 0, 0)), energy=1 / 8)
    # y^2/2 - y^3/3 = 1/8: the well between y = -0.4340 and 0.6731 (roots of the cubic).
    roots = np.sort(np.roots([-1 / 3, 1 / 2, 0, -1 / 8]).real)
    assert (edge.coordinate[0], edge.coordinate[-1]) == pytest.approx((roots[0], roots[1]), abs=1e-9)
    assert edge.momentum.max() == pytest.approx(0.5, abs=1e-5)
    with pytest.raises(ValueError, match="is unbounded"):
        plot.edge(fastaff.HenonHeiles(), fastaff.Hyperplane((1, 0, 0, 0)), energy=1.0)


@pytest.mark.parametrize(("pieces", "energy"), [(1, 0.05), (2, -0.1)])
def test_each_piece_of_an_edge_is_a_curve_of_its_own(ax, pieces, energy):
    """No line joins two wells below the saddle between them, nor their kinetic energy of any kind."""
    wells = "x**4/4 - x**2/2 + y**2/2"
    fast = fastaff.hamiltonian(f"sqrt(1 + p_x**2 + p_y**2) - 1 + {wells}", coordinates="x y", momenta="p_x p_y")
    for model in (shared_systems.plane(-1, 1, e=1), fast):
        curves = plot.style.outline(ax, plot.edge(model, "y=0", energy=energy))
        assert len(curves) == pieces
        for curve in curves:
            x = curve.get_xdata()
            assert (x[0], np.ptp(np.sign(x))) == (x[-1], 4 - 2 * pieces)


def test_a_section_at_a_pole_names_the_others():
    trap = fastaff.hamiltonian(
        "p_r**2/2 + p_z**2/2*(1 + r**2/9) + (L/r - r)**2/2 + z**2/2", coordinates="r z", momenta="p_r p_z", L=0.2
    )
    with pytest.raises(ValueError, match=r"section r=0 has no points of finite energy\. Try z=c"):
        plot.edge(trap, "r=0", energy=0.5)
    assert plot.edge(trap, "z=0", energy=0.5).momentum.max() == pytest.approx(1.0, abs=1e-4)


def test_plot_section(ax):
    found = section_map()
    drawn = plot.plot_section(
        found, ax=ax, values=[-8.0, -2.0, -5.0], boundary=plot.edge(NEO, fastaff.AlphaTurning(), **SURFACE)
    )
    assert drawn.missing == 1
    assert len(drawn.points.get_offsets()) == 10
    assert drawn.points.get_rasterized()
    assert drawn.colorbar.ax.get_ylabel() == ""
    assert (drawn.points.norm.vmin, drawn.points.norm.vmax) == (-8.0, -2.0)
    assert len(drawn.lines) == 1
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\beta$", r"$p_{\beta}$")


def test_plot_section_without_values_and_other_coordinates(ax):
    drawn = plot.plot_section(section_map(), ax=ax, x="alpha", y="p_alpha")
    assert drawn.colorbar is None
    assert ax.get_xlabel() == r"$\alpha$"


def test_plot_section_refuses(ax):
    with pytest.raises(ValueError, match="x and y must be among"):
        plot.plot_section(section_map(), ax=ax, x="radius")
    with pytest.raises(ValueError, match="values must have shape"):
        plot.plot_section(section_map(), ax=ax, values=np.zeros(7))


def test_resonances_between():
    assert plot.resonances_between(1.2, 1.6, 7) == [(2, 0, -3), (3, 0, -4)]
    assert all(1.2 < -m / n < 1.6 for n, _, m in plot.resonances_between(1.2, 1.6, 20))


def test_three_coordinates_are_drawn_by_their_dominant_lines(ax):
    """Independent frequencies of a triaxial potential change their order from orbit to orbit: their ratios are a cross
    of dots, those of the dominant lines of x, y and z lie near the potential's own.
    """
    body = fastaff.hamiltonian("0.5*log(x**2 + (y/0.9)**2 + (z/0.7)**2 + 0.01)", coordinates="x, y, z")
    v = np.random.default_rng(9).normal(size=(3, 60))
    v /= np.sqrt(v[0] ** 2 + (v[1] / 0.9) ** 2 + (v[2] / 0.7) ** 2)
    found = fastaff.frequency_map(body, np.concatenate([v, 0 * v]), time=200.0)
    drawn = plot.plot_frequency_map(found, ax=ax, lines=[(1, -1, 0)])
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\nu_{x}/\nu_{z}$", r"$\nu_{y}/\nu_{z}$")
    places = np.asarray(drawn.points.get_offsets())
    shown = np.isfinite(found.dominant_error).all(axis=0)
    assert len(places) == shown.sum() > 50
    truth = (found.dominant[:2] / found.dominant[2])[:, shown]
    np.testing.assert_allclose(np.sort(places[:, 0]), np.sort(truth[0]))
    np.testing.assert_allclose(np.sort(places[:, 1]), np.sort(truth[1]))
    assert (places < 1.3).all()
    assert (np.abs((found.nu[:2] / found.nu[2])[:, shown] - truth) > 1e-3).any()  # which the generators are not
    assert drawn.missing == (~shown).sum()
    inside = plot.on_line(found, (1, -1, 0), x="x/z", y="y/z", tolerance=1e-6)
    assert inside == (np.abs(truth[0] - truth[1]) < 1e-6).sum()


def _stars(body, seed: int, n: int = 60):
    """Return starts (6, n) in a disc, near and far from circular, some of them high above its plane."""
    rng = np.random.default_rng(seed)
    R, z, turned = rng.uniform(0.6, 2, n), rng.uniform(0.05, 1.0, n), rng.uniform(0.6, 1.0, n)
    pull = -body.force(R, 0 * R, 0 * R)[0]
    return np.array([R, 0 * R, z, rng.normal(0, 0.1, n), turned * np.sqrt(R * pull), 0 * R])


def test_a_harmonic_is_no_line_of_its_coordinate(ax):
    """Small swings about a circular orbit under a strong vertical one: the strongest line of R is 2 nu_z, but its own
    is the epicyclic one, which lies among those of the neighbours.
    """
    body = fastaff.hamiltonian(
        "-1/sqrt(x**2 + y**2 + (0.5 + sqrt(z**2 + 0.01))**2) + 0.32*log(0.09 + x**2 + y**2 + z**2/0.64)",
        coordinates="x, y, z",
    )
    found = fastaff.frequency_map(body, _stars(body, 3), time=400.0, signals="R z phi")
    strong = (
        (found.classification == fastaff.Classification.REGULAR) & (found.basis[0, 1] == 2) & (found.basis[0, 0] == 0)
    )
    plain = (found.classification == fastaff.Classification.REGULAR) & (found.basis[0, 0] == 1)
    assert strong.sum() > 2 < plain.sum()
    np.testing.assert_allclose(found.dominant[0, strong], 2 * found.nu[1, strong], rtol=1e-6)
    R = plot.frequency(found, "R/phi")
    np.testing.assert_array_equal(R[strong], (found.nu[0] / found.dominant[2])[strong])
    np.testing.assert_array_equal(R[plain], (found.dominant[0] / found.dominant[2])[plain])
    assert 1.2 < R[plain | strong].min() < R[plain | strong].max() < 2.0  # dominant lines: up to 2.8
    drawn = plot.plot_frequency_map(found, ax=ax)
    assert [text.get_text() for text in ax.texts] == [f"{strong.sum()} of {60 - drawn.missing} orbits by another basis"]
    for chosen in (found.dominant, found.nu):
        ax.clear()
        figure = plot.plot_frequency_map(found, ax=ax, frequencies=chosen)
        places = np.asarray(figure.points.get_offsets())
        shown = np.isfinite(found.error).all(axis=0) & np.isfinite(found.dominant_error).all(axis=0)
        np.testing.assert_allclose(np.sort(places[:, 0]), np.sort((chosen[0] / chosen[2])[shown]))
    assert any("by another basis" in text.get_text() for text in figure.points.axes.texts)  # that of nu
    for wrong in ("nu", "dominant", found.nu[:2], found.nu[0], 3.0):
        with pytest.raises(ValueError, match=r"frequencies must be an array \(3, 60\), such as found.nu or"):
            plot.plot_frequency_map(found, ax=ax, frequencies=wrong)


def test_particles_without_a_tune_are_not_drawn(ax):
    """They have the number 0 in `nu`; by any colours, and of one plane too."""
    turn, rng = np.arange(400), np.random.default_rng(7)
    z = np.exp(2j * np.pi * (rng.uniform(0.1, 0.4, (2, 20, 1)) * turn))
    z[:, ::2, 30:] = np.nan
    samples = np.concatenate([z.real, -z.imag])
    found = fastaff.tunes(samples)
    for drawn in (
        plot.plot_tunes(found, ax=ax),
        plot.plot_tunes(found, ax=ax, values=np.arange(20.0)),
        plot.plot_tunes(fastaff.tunes(samples[::2]), ax=ax),
    ):
        assert len(drawn.points.get_offsets()) == 10
        assert drawn.missing == 10
        assert drawn.points.get_offsets()[:, 1].min() > 0.05
    found = dataclasses.replace(found, status=np.zeros(20, np.int64))  # some may be OK without one
    assert plot.plot_tunes(found, ax=ax, values=np.arange(20.0)).missing == 10


def test_plot_frequency_map_labels_the_line_that_orbits_stand_on(ax):
    ratio = np.concatenate([np.full(30, 1.5), np.linspace(1.25, 1.7, 41)])
    found = frequency_map(ratio, np.linspace(0.6, 0.7, ratio.size))
    drawn = plot.plot_frequency_map(found, ax=ax, lines=[(2, 0, -3), (3, 0, -4), (0, 3, -2), (1, 0, -9)])
    assert drawn.labels[0].get_text() == "3:2"
    assert r"$3\nu_{\gamma}-2\nu_{\alpha}=0$" in [text.get_text() for text in drawn.labels]
    assert len(drawn.lines) == 3, "a line outside of the frame is not drawn"
    assert drawn.lines[0].get_xdata()[0] == 1.5
    assert plot.on_line(found, (2, 0, -3), x="beta/alpha", y="gamma/alpha", tolerance=1e-9) >= 30
    assert drawn.missing == 0


@pytest.mark.parametrize(("x", "y"), [("a/c", "b/c"), ("a", "b")])
def test_lines_up_to_an_order_are_all_that_cross_the_view(x, y):
    """Against all integers of a cube; the order of ratios is that of k . nu = 0, of tunes |k1| + |k2|."""
    rng = np.random.default_rng(17)
    for _ in range(5):
        centre, order = rng.uniform(0.1, 1.4, 2), int(rng.integers(2, 7))
        (u0, u1), (v0, v1) = view = [tuple(np.array([-0.15, 0.15]) + c) for c in centre]
        found = plot.ratios.lines_of(f"order<={order}", x, y, view)
        expected = set()
        for k in itertools.product(range(-order, order + 1), range(-order, order + 1), range(-20, 21)):
            weight = abs(k[0]) + abs(k[1]) + (abs(k[2]) if "/" in x else 0)
            corners = [k[0] * u + k[1] * v + k[2] for u in (u0, u1) for v in (v0, v1)]
            if (k[0] or k[1]) and weight <= order and np.gcd.reduce(k) == 1 and min(corners) <= 0 <= max(corners):
                expected.add(max(k, tuple(-c for c in k)))
        assert {max(k, tuple(-c for c in k)) for k in found} == expected
        assert len(found) == len(expected) > 0


def test_lines_may_be_one_line_or_a_text(ax):
    found = frequency_map(np.linspace(1.25, 1.7, 41), np.linspace(0.6, 0.7, 41))
    assert len(plot.plot_frequency_map(found, ax=ax, lines=(2, 0, -3)).lines) == 1
    drawn = plot.plot_frequency_map(found, ax=ax, lines="order <= 5")
    assert len(drawn.lines) == len(plot.ratios.lines_of("order<=5", "b/a", "c/a", (ax.get_xlim(), ax.get_ylim())))
    assert drawn.labels[0].get_text() == "3:2"
    for wrong in ("order<5", "order<=0", "all", [(1, 2)], (1, 2)):
        with pytest.raises(ValueError, match="lines must be triples"):
            plot.plot_frequency_map(found, ax=ax, lines=wrong)
    with pytest.raises(
        TypeError, match=r"lines must be triples .* k1 \* beta/alpha \+ k2 \* gamma/alpha \+ k0 = 0, .* got 4"
    ):
        plot.plot_frequency_map(found, ax=ax, lines=4)
    with pytest.raises(ValueError, match="lines must be at most 400 in the figure, got more"):
        plot.plot_frequency_map(found, ax=ax, lines="order<=99")


def test_lines_of_a_flow_do_not_know_the_unit_of_time(ax):
    """All up to an order go through 0: a flow has no turn, whose frequency is 1."""
    found = fastaff.frequency_map(fastaff.HenonHeiles(), 0.2 * np.eye(4)[:, :2] + 0.1, time=300.0)
    drawn = plot.plot_frequency_map(found, ax=ax, lines="order<=6", limits=((0.1, 0.2), (0.1, 0.2)))
    view = ax.get_xlim(), ax.get_ylim()
    chosen = plot.ratios.lines_of("order<=6", "x", "y", view, turns=False)
    assert (1, -1, 0) in chosen
    assert not any(k0 for _, _, k0 in chosen)
    assert 3 <= len(drawn.lines) <= len(chosen)  # some touch a corner alone
    assert all("=1$" not in label.get_text() for label in drawn.labels)
    assert any(k0 for _, _, k0 in plot.ratios.lines_of("order<=6", "x", "y", view))


def test_orbits_without_samples_are_their_ends(ax):
    drawn = plot.plot_orbits(fastaff.integrate(fastaff.HenonHeiles(), 0.1 * np.ones((4, 3)), time=1.0), ax=ax)
    assert [len(curve.get_xdata()) for curve in drawn.points] == [1, 1, 1]


def test_a_few_orbits_far_away_do_not_make_the_view(ax):
    """They are counted in words that no label covers."""
    ratio = np.concatenate([np.linspace(1.25, 1.35, 197), [0.1, 5.0, 9.0]])
    found = frequency_map(ratio, np.linspace(0.6, 0.7, 200))
    drawn = plot.plot_frequency_map(found, ax=ax, lines="order<=9")
    assert ax.get_xlim()[0] > 1.2
    assert ax.get_xlim()[1] < 1.4
    (note,) = [text for text in ax.texts if "beyond" in text.get_text()]
    x0, x1 = ax.get_xlim()
    assert note.get_text() == f"{np.count_nonzero((ratio < x0) | (ratio > x1))} of 200 orbits beyond the axes"
    slanted = [label for label in drawn.labels if "=" in label.get_text()]
    assert len(slanted) > 2
    for label in slanted:
        assert not label.get_window_extent().overlaps(note.get_window_extent())


def test_labels_do_not_overlap(ax):
    ratio = np.linspace(1.1, 1.9, 200)
    drawn = plot.plot_frequency_map(
        frequency_map(ratio, 0.6 + 0 * ratio), ax=ax, lines=plot.resonances_between(1.1, 1.9, 25)
    )
    ax.figure.canvas.draw()
    boxes = sorted((t.get_window_extent() for t in drawn.labels), key=lambda box: box.x0)
    assert len(boxes) > 5
    assert all(a.x1 < b.x0 for a, b in itertools.pairwise(boxes))


def test_frequency_names():
    found = frequency_map(np.array([1.5]), np.array([0.7]))
    assert plot.frequency(found, "gamma/alpha") == pytest.approx(0.7)
    with pytest.raises(ValueError, match="frequency must be one of"):
        plot.frequency(found, "delta")


def test_a_wrong_axis_is_refused_with_the_values_of_initial_conditions(ax):
    found = frequency_map(np.array([1.5]), np.array([0.7]))
    with pytest.raises(ValueError, match=r"got 'L'\. Axes may be energy, angular_momentum or radius") as refused:
        plot.plot_frequency_map(found, ax=ax, x="L")
    assert len(str(refused.value)) <= 160


def test_plot_diffusion_grid(ax):
    grid = fastaff.energy_grid(
        NEO, section=fastaff.AlphaTurning(), axes=(np.linspace(0.1, 1.2, 9), np.linspace(-1.6, 1.6, 7)), **SURFACE
    )
    values = np.linspace(-9, -2, grid.cell_index.size)
    values[0] = np.nan
    drawn = plot.plot_diffusion_grid(grid, values, ax=ax)
    assert drawn.missing == 1
    assert ax.get_title(loc="left") == "grey: 1 orbit without a value"
    assert drawn.points.get_array().count() == grid.cell_index.size - 1
    assert drawn.points.get_rasterized()
    with pytest.raises(ValueError, match="values must have shape"):
        plot.plot_diffusion_grid(grid, values[1:], ax=ax)


def test_a_grid_of_a_result_has_its_colours_and_no_lost_orbit(ax):
    body = fastaff.models.OneTurnMap()
    grid = fastaff.energy_grid(body, axes={"x": np.linspace(0.02, 0.6, 9), "y": np.linspace(0.02, 0.6, 8)})
    found = fastaff.frequency_map(body, grid.z0, time=200.0)
    lost = found.status != 0
    assert 10 < lost.sum() < 60
    drawn, own = plot.plot_diffusion_grid(grid, found, ax=ax), found.plot()
    assert drawn.missing == lost.sum()
    np.testing.assert_array_equal(np.ma.getmaskarray(drawn.points.get_array()), grid.to_grid(1.0 * lost).T == 1)
    for end in ("vmin", "vcenter", "vmax"):
        assert getattr(drawn.points.norm, end) == getattr(own.points.norm, end)
    assert drawn.colorbar.ax.get_ylabel() == own.colorbar.ax.get_ylabel() != ""


def test_colours_are_told_apart_by_lightness():
    colours = plot.colour_map()(np.linspace(0, 1, 50))[:, :3]
    lightness = colours @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) > 0).all()
    assert lightness[-1] < 0.85, "the last colour is seen on white"


def test_scales():
    scale = plot.clipped(np.append(np.linspace(-10, -2, 101), np.nan))
    assert (scale.vmin, scale.vmax) == (-10.0, -2.0)
    narrow = plot.clipped(np.linspace(0.1, 0.2, 101))
    assert (narrow.vmin, narrow.vmax) == pytest.approx((0.105, 0.195))
    assert plot.clipped([3.0]).vmin < 3.0 < plot.clipped([3.0]).vmax
