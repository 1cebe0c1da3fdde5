"""Lifted grids: energy, angular momenta and section exact; directions; inaccessible cells; errors."""

import numpy as np
import pytest
from naive import constants, label
from own_models import Radius

import fastaff as fa
from fastaff import (
    AlphaEquals,
    AlphaTurning,
    Anharmonic,
    AreaEquals,
    BetaEquals,
    BetaTurning,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    NeoHookean,
    affine_body,
    energy_grid,
    energy_sample,
    hamiltonian,
    poincare_map,
)
from fastaff.sections import NotReached

ALPHAS = np.linspace(1.0, 2.0, 9), np.linspace(-0.8, 0.8, 7)
BETAS = np.linspace(0.1, 0.6, 9), np.linspace(-0.8, 0.8, 7)
SECTIONS = [
    (AlphaTurning(1), BETAS),
    (AlphaTurning(-1), BETAS),
    (AlphaTurning(0), BETAS),
    (BetaTurning(1), ALPHAS),
    (BetaTurning(-1), ALPHAS),
    (AlphaEquals(1.4, 1), BETAS),
    (AlphaEquals(1.4, -1), BETAS),
    (BetaEquals(0.3, 1), ALPHAS),
    (BetaEquals(0.3, 0), ALPHAS),
    (AreaEquals(1.0, 1), BETAS),
    (AreaEquals(1.1, -1), BETAS),
    (Radius(1.6), BETAS),
    (Radius(1.7, -1), BETAS),
]
every_section = pytest.mark.parametrize(("section", "axes"), SECTIONS, ids=[str(s) for s, _ in SECTIONS])
BODIES = [
    (Body(Harmonic(1.3), 0.7), 3.0),
    (Body(Anharmonic(0.9), 1.4), 3.2),
    (Body(Hyperelastic(1.1), 0.8), 3.2),
    (Body(HeavyTop(1.0, 0.5), 1.1), 2.8),
    (Body(NeoHookean(1.0, 2.0)), 1.5),
]
every_body = pytest.mark.parametrize(("body", "energy"), BODIES, ids=lambda v: label(v) if isinstance(v, Body) else "")


def rate(body, section, z):
    """Derivative of the section function along the motion, by a complex step."""
    flow = np.array([*body.velocity(*z[4:]), *body.force(*z[:4])])
    return section.value(*(z + 1e-30j * flow)).imag / 1e-30


@every_section
@every_body
def test_every_point_has_what_was_asked_for(body, energy, section, axes):
    grid = energy_grid(body, energy=energy, section=section, axes=axes, p_eta=0.3, p_gamma=-0.1)
    E, p_eta, p_gamma = constants(body, grid.z0)
    assert grid.z0.shape == (8, grid.cell_index.size)
    assert grid.cell_index.size >= 5
    np.testing.assert_allclose(E, energy, rtol=0, atol=2e-13 * (1 + energy))
    np.testing.assert_allclose(p_eta, 0.3, rtol=0, atol=1e-15)
    np.testing.assert_allclose(p_gamma, -0.1, rtol=0, atol=1e-15)
    np.testing.assert_allclose(section.value(*grid.z0), 0.0, rtol=0, atol=1e-15)
    assert (body.margin(*grid.z0[:4]) > 0).all()


@every_section
@every_body
def test_the_motion_crosses_in_the_direction_of_the_section(body, energy, section, axes):
    """Turning points: a minimum of the radius for +1, a maximum for -1."""
    grid = energy_grid(body, energy=energy, section=section, axes=axes, p_eta=0.3, p_gamma=-0.1)
    rates = rate(body, section, grid.z0)
    if section.direction:
        assert (rates * section.direction > -1e-12).all()
    assert np.abs(rates).max() > 0.1


@every_section
def test_points_sit_on_their_cells(section, axes):
    body, energy = BODIES[2]
    grid = energy_grid(body, energy=energy, section=section, axes=axes, p_eta=0.3, p_gamma=-0.1)
    u, v = np.meshgrid(*axes, indexing="ij")
    plane = 0 if grid.names[0] == "alpha" else 2
    radius = np.hypot(grid.z0[plane], grid.z0[plane + 1])
    momentum = (grid.z0[plane] * grid.z0[4 + plane] + grid.z0[plane + 1] * grid.z0[5 + plane]) / radius
    np.testing.assert_allclose(radius, u.ravel()[grid.cell_index], rtol=1e-14)
    np.testing.assert_allclose(momentum, v.ravel()[grid.cell_index], rtol=0, atol=1e-14)
    assert grid.names == (("alpha", "p_alpha") if plane == 0 else ("beta", "p_beta"))
    np.testing.assert_array_equal(np.flatnonzero(~grid.inaccessible.ravel()), grid.cell_index)
    assert grid.inaccessible.shape == (9, 7)
    assert grid.energy == energy


@every_body
def test_the_allowed_cells_are_those_that_the_energy_reaches(body, energy):
    """AlphaEquals: the rest of the kinetic energy for p_alpha must not be negative."""
    grid = energy_grid(body, energy=energy, section=AlphaEquals(1.4), axes=BETAS, p_eta=0.3, p_gamma=-0.1)
    beta, p_beta = np.meshgrid(*BETAS, indexing="ij")
    V = body.potential_energy(1.4, 0.0, beta, 0.0)
    rest = energy - V - (p_beta**2 + (0.3 / 1.4) ** 2 + (0.1 / beta) ** 2) / (2 * body.mu)
    np.testing.assert_array_equal(grid.inaccessible, ~(rest >= 0))


def test_inaccessible_cells_are_masked_when_values_are_placed():
    body, energy = BODIES[2]
    wide = np.linspace(0.05, 1.5, 12), np.linspace(-3, 3, 11)
    grid = energy_grid(body, energy=energy, section=AlphaTurning(-1), axes=wide)
    assert 0 < grid.inaccessible.mean() < 1
    spread = grid.to_grid(np.arange(grid.cell_index.size))
    assert spread.shape == (12, 11)
    np.testing.assert_array_equal(spread.mask, grid.inaccessible)
    np.testing.assert_array_equal(spread.compressed(), np.arange(grid.cell_index.size))


def test_without_angular_momenta_the_radius_may_be_zero():
    body = Body(Hyperelastic())
    grid = energy_grid(body, energy=2.5, section=AlphaEquals(1.5), axes=([0.0, 0.1], [0.0, 0.2]))
    assert grid.cell_index.size == 4
    np.testing.assert_array_equal(grid.z0[[1, 3, 5, 7]], 0.0)
    assert constants(body, grid.z0)[0] == pytest.approx(2.5)


@pytest.mark.parametrize(("normal", "offset"), [((1.0, 0, 0, 0), 0.0), ((0, 2.0, 0, 0), 0.2), ((-1.0, 0, 0, 0), 0.1)])
@pytest.mark.parametrize("direction", [1, -1])
def test_henon_heiles(normal, offset, direction):
    model, section = HenonHeiles(), Hyperplane(normal, offset, direction)
    axes = np.linspace(-0.4, 0.5, 10), np.linspace(-0.4, 0.4, 9)
    grid = energy_grid(model, energy=0.12, section=section, axes=axes)
    i = int(np.flatnonzero(normal)[0])
    np.testing.assert_allclose(
        model.kinetic_energy(*grid.z0[2:]) + model.potential_energy(*grid.z0[:2]), 0.12, rtol=1e-13
    )
    np.testing.assert_allclose(grid.z0[i], offset / normal[i], rtol=1e-15)
    u, v = np.meshgrid(*axes, indexing="ij")
    np.testing.assert_array_equal(grid.z0[[1 - i, 3 - i]], [u.ravel()[grid.cell_index], v.ravel()[grid.cell_index]])
    assert (np.sign(grid.z0[2 + i]) * np.sign(normal[i]) == direction).all()
    assert grid.names == (("y", "p_y"), ("x", "p_x"))[i]


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"energy": 0.5}, ValueError, r"energy must be at least the minimum 2.2 of this body"),
        (
            {"section": AlphaEquals(30.0)},
            ValueError,
            r"axes must reach points of energy 3.2 on alpha=30, got beta in \[0.1, 0.6\], p_beta in",
        ),
        ({"section": AlphaEquals(0.05)}, ValueError, "axes must reach points of energy 3.2 on alpha=0.05"),
        (
            {"section": Hyperplane((0.0,) * 7 + (1.0,))},
            TypeError,
            "section must be a Hyperplane normal to one coordinate",
        ),
        ({"section": "alpha"}, ValueError, "section must be one of alpha-turning"),
        ({"axes": (BETAS[0],)}, TypeError, "axes must be two arrays"),
        ({"axes": (100, 90)}, ValueError, r"p_beta in \[90, 90\]\. Use coordinates, np.linspace\(low, high, 100\)"),
        ({"axes": 3.0}, TypeError, "axes must be two arrays"),
        ({"axes": ([], BETAS[1])}, ValueError, "axes must be two non-empty"),
        ({"axes": ([np.nan], BETAS[1])}, ValueError, "finite"),
        ({"axes": (np.ones((2, 2)), BETAS[1])}, ValueError, "one-dimensional"),
        ({"energy": np.inf}, ValueError, "energy must be finite"),
        ({"energy": "2"}, TypeError, "energy must be a real number, got '2'"),
        ({"p_eta": None}, TypeError, "p_eta must be a real number"),
        ({"p_gamma": np.nan}, ValueError, "p_gamma must be finite"),
    ],
    ids=lambda v: next(iter(v)) if isinstance(v, dict) else "",
)
def test_wrong_input(change, error, message):
    options = {"energy": 3.2, "section": AlphaTurning(-1), "axes": BETAS} | change
    with pytest.raises(error, match=message):
        energy_grid(BODIES[2][0], **options)


def test_angular_momenta_belong_to_bodies():
    with pytest.raises(ValueError, match="p_eta and p_gamma must be 0"):
        energy_grid(HenonHeiles(), energy=0.1, section=Hyperplane((1, 0, 0, 0)), axes=([0.1], [0.1]), p_eta=0.1)
    with pytest.raises((TypeError, ValueError), match="section"):
        energy_grid(HenonHeiles(), energy=0.1, section=AlphaTurning(), axes=([0.1], [0.1]))


# --- any scale ----------------------------------------------------------------------------------------------------


def log_uniform(rng, low, high):
    return float(10 ** rng.uniform(np.log10(low), np.log10(high)))


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("kind", [Harmonic, Anharmonic])
@pytest.mark.parametrize("seed", range(4))
def test_allowed_cells_are_those_of_the_closed_form(kind, direction, seed):
    """C alpha^2/2 + k/alpha^2 <= e has its minimum sqrt(2 C k): alpha^2 = (e +- sqrt(e^2 - 2 C k))/C; any C, mu,
    momenta, energy.
    """
    rng = np.random.default_rng([seed, direction + 1])
    C, mu = log_uniform(rng, 1e-6, 1e6), log_uniform(rng, 1e-3, 1e3)
    barrier = 2 * C if kind is Anharmonic else 0.0
    unit = np.sqrt(C * mu)  # of angular momenta where lengths are 1
    p_eta = unit * log_uniform(rng, 1e-4, 1.0)
    k = barrier + p_eta**2 / (2 * mu)
    E = np.sqrt(2 * C * k) + C * log_uniform(rng, 1e-2, 1e3)
    left = E - np.sqrt(2 * C * k)
    p_gamma = -left * np.sqrt(mu / C) * log_uniform(rng, 1e-4, 0.5)
    axes = np.sqrt(left / C) * np.geomspace(3e-3, 3, 23), np.sqrt(2 * mu * left) * np.linspace(-1.3, 1.3, 21)
    grid = energy_grid(
        Body(kind(C), mu), energy=E, section=AlphaTurning(direction), axes=axes, p_eta=p_eta, p_gamma=p_gamma
    )
    beta, p_beta = np.meshgrid(*axes, indexing="ij")
    e = E - C * beta**2 / 2 - (p_beta**2 + (p_gamma / beta) ** 2) / (2 * mu)
    clear = np.abs(e - np.sqrt(2 * C * k)) > 1e-9 * E
    np.testing.assert_array_equal(grid.inaccessible[clear], (e < np.sqrt(2 * C * k))[clear])
    assert 0.1 < grid.inaccessible.mean() < 0.95
    e = e.ravel()[grid.cell_index]
    outer = (e + np.sqrt(np.maximum(e**2 - 2 * C * k, 0))) / C
    sure = e > 1.001 * np.sqrt(2 * C * k)
    A = outer if direction < 0 else 2 * k / (C * outer)
    np.testing.assert_allclose(np.hypot(*grid.z0[:2])[sure], np.sqrt(A)[sure], rtol=1e-11)


SCALED = "k*(D1**2 + D2**2)/2 + c/(D1*D2) + w*(D1 - D2)**4 + v"


def scaled(L, T, M, V0=0.0):
    """One body in units of length L, time T and mass M, its potential above V0; and the units of momentum and
    energy.
    """
    energy = M * L**2 / T**2
    return (
        affine_body(
            SCALED, k=0.9 * M / T**2, c=1.2 * M * L**4 / T**2, w=0.1 * energy / L**4, v=V0 * energy, mu=0.7 * M
        ),
        M * L / T,
        energy,
    )


@pytest.mark.parametrize("units", [(1e-6, 1, 1), (1e6, 1, 1), (1, 1e-6, 1), (1, 1e6, 1e-6), (1e4, 1e-3, 1e6)], ids=str)
def test_units_change_nothing(units):
    """Grids and draws in any unit of length, time and mass, to rounding."""
    L, T, M = units
    for section in (AlphaTurning(1), AlphaTurning(-1), BetaTurning(1), AreaEquals(1.1, -1), BetaEquals(0.3, 1)):
        found = []
        for length, time, mass in ((1.0, 1.0, 1.0), (L, T, M)):
            body, momentum, energy = scaled(length, time, mass, 2.0)
            here = section
            if isinstance(section, (BetaEquals, AreaEquals)):
                here = section._replace(
                    constant=section.constant * length ** (2 if isinstance(section, AreaEquals) else 1)
                )
            surface = {
                "energy": 5.5 * energy,
                "section": here,
                "p_eta": 0.3 * length * momentum,
                "p_gamma": 0.05 * length * momentum,
            }
            axes = np.linspace(0.02, 1.6, 14) * length, np.linspace(-1.5, 1.5, 9) * momentum
            unit = np.repeat([length, momentum], 4)[:, None]
            grid, drawn = energy_grid(body, axes=axes, **surface), energy_sample(body, orbits=20, seed=3, **surface)
            found.append((grid.inaccessible, grid.z0 / unit, drawn.z0 / unit))
        np.testing.assert_array_equal(found[0][0], found[1][0])
        for one, other in zip(found[0][1:], found[1][1:]):
            np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1e-5, 0.0), (1e6, 0.0), (1.0, 3e4), (1e-3, -20.0)], ids=str)
def test_all_wells_of_a_line_are_drawn_from(scale, shift):
    """V = (x^2 - 1)^2 + x/5 below its barrier, at any place and scale: shares of the wells are those of their areas (by
    quadrature).
    """
    x = "((x - c)/s)"
    model = hamiltonian(f"({x}**2 - 1)**2 + {x}/5 + y**2/2", c=shift, s=scale)
    E, section = 0.6, Hyperplane((0.0, 1.0, 0.0, 0.0))
    drawn = energy_sample(model, energy=E, section=section, orbits=4000, seed=5)
    s = np.linspace(-2, 2, 400_001)
    width = np.sqrt(np.maximum(E - (s**2 - 1) ** 2 - s / 5, 0))
    share = width[s > 0].sum() / width.sum()
    right = (drawn.points[0] > shift).mean()
    assert abs(right - share) < 4.5 * np.sqrt(share * (1 - share) / 4000)
    assert (
        abs(np.mean((drawn.points[0] - shift) / scale) - (s * width).sum() / width.sum())
        < 0.06 + 1e-9 * abs(shift) / scale
    )


def test_all_wells_of_the_turning_radius_are_drawn_from():
    """V has wells at alpha = 2 and 3: where both are reached each inner turning point has the same density of (beta,
    p_beta).
    """
    body = affine_body("(alpha**2 - 4)**2*(alpha**2 - 9)**2/50 + g*alpha + beta**2/2", g=0.05)
    surface = {"energy": 0.4, "section": AlphaTurning(1), "p_gamma": 0.02}
    drawn = energy_sample(body, orbits=4000, seed=2, **surface)
    alpha, beta = np.hypot(*drawn.z0[:2]), np.hypot(*drawn.z0[2:4])
    areas = []
    for low, high in ((1.5, 2.5), (2.5, 3.5)):
        a = np.linspace(low, high, 4001)
        V = ((a**2 - 4) ** 2 * (a**2 - 9) ** 2 / 50 + 0.05 * a).min()
        b = np.linspace(1e-4, 1.2, 40_001)
        areas.append(np.sqrt(np.maximum(2 * (0.4 - V) - b**2 - (0.02 / b) ** 2, 0)).sum())
    share = areas[0] / sum(areas)
    assert abs((alpha < 2.5).mean() - share) < 4.5 * np.sqrt(share * (1 - share) / 4000)
    assert (rate(body, surface["section"], drawn.z0) > 0).all()
    assert beta.min() > 0
    grid = energy_grid(body, axes=([0.3], [0.1]), **surface)
    assert np.hypot(*grid.z0[:2])[0] > 2.5  # the outermost


@pytest.mark.parametrize(
    "text",
    [
        "1.7*exp(-(alpha - 3)**2) - 2*exp(-(alpha - 5)**2/0.3) + r/40 + 0.3*beta**2*alpha/(1 + r)",
        "cos(4*alpha)/alpha + r/9 + 1/(D1*D2)**2",
        "sin(r)/(1 + r) + r/30 + 0.2*log(1 + 1/(D1*D2))",
    ],
)
def test_allowed_cells_are_those_of_a_fine_scan(text):
    """Several wells: 200,000 radii for each beta, the largest rest of the energy decides; nothing is called allowed
    that is not.
    """
    body, rng = affine_body(text, mu=1.3), np.random.default_rng(9)
    axes = np.sort(rng.uniform(0.05, 1.5, 12)), np.linspace(-1.5, 1.5, 15)
    for E in (0.3, 1.1):
        inaccessible = np.ones((12, 15), bool)
        clear = np.ones((12, 15), bool)
        a = np.linspace(1e-3, 40, 200_000)
        for i, b in enumerate(axes[0]):
            with np.errstate(all="ignore"):
                rest = 2 * 1.3 * (E - body.potential.value(a * a, b * b)) - (0.1 / a) ** 2 - (0.2 / b) ** 2
            top = np.max(np.where(body.potential.margin(a * a, b * b + 0 * a) > 0, rest, -np.inf))
            inaccessible[i], clear[i] = top < axes[1] ** 2, np.abs(top - axes[1] ** 2) > 1e-6
        for direction in (1, -1):
            section = AlphaTurning(direction)
            try:
                grid = energy_grid(body, energy=E, section=section, axes=axes, p_eta=0.1, p_gamma=0.2)
            except NotReached:
                assert inaccessible[clear].all()
                continue
            np.testing.assert_array_equal(grid.inaccessible[clear], inaccessible[clear])
            assert (rate(body, section, grid.z0) * direction > -1e-9).all()


def test_through_the_axis_where_the_angular_momentum_is_zero():
    """p_eta = 0: the least radius is 0; it is the limit of the inner turning points, and where the map goes."""
    body, section, axes = Body(Harmonic(1.3), 0.7), AlphaTurning(1), BETAS
    exact, near = (energy_grid(body, energy=3.0, section=section, axes=axes, p_eta=p, p_gamma=0.1) for p in (0.0, 1e-9))
    np.testing.assert_array_equal(exact.inaccessible, near.inaccessible)
    np.testing.assert_allclose(exact.z0, near.z0, atol=1e-7)
    assert not exact.z0[:2].any()
    cut = poincare_map(body, exact.z0, section=section, crossings=2, max_time=20.0, step=0.02)
    assert (cut.counts == 2).all()
    np.testing.assert_allclose(cut.points[:2], 0, atol=1e-9)


def test_walls_are_no_turning_points():
    """A smooth potential cut off by a domain: the section ends there, without a turning point."""
    body = affine_body("r/2", domain="4 - alpha**2")
    axes = np.linspace(0.1, 1.0, 5), np.linspace(-0.5, 0.5, 5)
    inner = energy_grid(body, energy=8.0, section=AlphaTurning(1), axes=axes, p_eta=0.3)
    assert not inner.inaccessible.any()
    with pytest.raises(NotReached):
        energy_grid(body, energy=8.0, section=AlphaTurning(-1), axes=axes, p_eta=0.3)


@pytest.mark.parametrize(
    ("body", "section", "energy", "angular"),
    [
        (fa.HenonHeiles(), fa.Hyperplane((1, 0, 0, 0)), 0.11, {}),
        (fa.Body(fa.NeoHookean()), fa.AlphaTurning(), 1.5, {"p_eta": 0.3, "p_gamma": 0.2}),
        (fa.Body(fa.Hyperelastic()), fa.BetaTurning(), 3.2, {"p_eta": 0.1, "p_gamma": 0.2}),
        (fa.Body(fa.NeoHookean()), fa.AreaEquals(1.0), 1.0, {"p_eta": 0.1, "p_gamma": 0.0}),
    ],
)
def test_a_whole_grid_cuts_nothing(body, section, energy, angular):
    """Random points of the section lie in it, and it is no wider than needed."""
    grid = fa.energy_grid(body, energy=energy, section=section, axes="whole", **angular)
    sample = fa.energy_sample(body, orbits=2000, energy=energy, section=section, seed=3, **angular)
    for axis, points in zip(grid.axes, sample.points, strict=True):
        assert axis.min() <= points.min()
        assert axis.max() >= points.max()
        assert np.ptp(points) > 0.8 * np.ptp(axis)
    assert grid.inaccessible.shape == (101, 101)
    with pytest.raises(ValueError, match="axes must be two arrays, rows by name, or 'whole', got 'all'"):
        fa.energy_grid(body, energy=energy, section=section, axes="all", **angular)


@pytest.mark.parametrize("section", ["x=0", "y=0"])
def test_a_product_of_momenta_in_the_kinetic_energy(section):
    """Two oscillators with T = (a p_x^2 + b p_y^2)/2 + t p_x p_y: the section is an ellipse, free of the other momentum
    where that has the least energy, and the velocity through it has the section's sign.
    """
    random = np.random.default_rng(17)
    for _ in range(4):
        a, b, t, k = *random.uniform(0.5, 2, 2), *random.uniform(-0.45, 0.45, 1), random.uniform(0.5, 2)
        text = "(k*x**2 + y**2)/2 + t*p_x*p_y + (a*p_x**2 + b*p_y**2)/2"
        model = fa.hamiltonian(text, coordinates="x y", momenta="p_x p_y", a=a, b=b, t=t, k=k)
        stiff, heavy, own = (1.0, b, a) if section == "x=0" else (k, a, b)
        ends = np.sqrt(2 * 0.7 / stiff), np.sqrt(2 * 0.7 / (heavy - t * t / own))
        found = fa.plot.edge(model, section, energy=0.7).axes
        np.testing.assert_allclose(np.array(found)[:, 1], ends, rtol=1e-5)
        grid = fa.energy_grid(model, energy=0.7, section=section)
        u, v = grid.axes[0][:, None] / ends[0], grid.axes[1] / ends[1]
        near = np.abs(u * u + v * v - 1) < 1e-9
        assert ((u * u + v * v < 1) == ~grid.inaccessible)[~near].all()
        x, y, p_x, p_y = grid.z0
        H = (k * x**2 + y**2) / 2 + t * p_x * p_y + (a * p_x**2 + b * p_y**2) / 2
        np.testing.assert_allclose(H, 0.7, rtol=1e-12)
        assert ((a * p_x + t * p_y if section == "x=0" else b * p_y + t * p_x) >= 0).all()
        sample = (
            fa.energy_sample(model, energy=0.7, section=section, orbits=30, seed=2).points / np.array(ends)[:, None]
        )
        assert (np.hypot(*sample) < 1).all()


@pytest.mark.parametrize("body", [fa.HenonHeiles(), fa.models.DoublePendulum()], ids=["V(q)", "H(q, p)"])
def test_a_section_of_a_momentum_launches_nothing(body):
    section = fa.Hyperplane((0.0, 0.0, 1.0, 0.0))
    for launch in (
        lambda: fa.energy_sample(body, energy=0.1, orbits=3, section=section),
        lambda: fa.energy_grid(body, energy=0.1, section=section),
        lambda: fa.plot.edge(body, section, energy=0.1),
    ):
        with pytest.raises(TypeError, match="must be a Hyperplane normal to one coordinate to launch orbits on it"):
            launch()
