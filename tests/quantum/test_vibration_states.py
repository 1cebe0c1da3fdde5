"""Wave functions and Husimi functions of vibrations: norms, energies, closed forms, marginals."""

import numpy as np
import pytest
from scipy.special import eval_hermite, factorial

import fastaff as fa
from fastaff.quantum import husimi, spectrum

RNG = np.random.default_rng(312)
TEXT = "(p**2 + w*r**2)/2 + g*p*r + k*(x - a)**2/2 + l*y**2/2 + c*x*y + e*(x - a)**4"


def hermite(n, omega, hbar, x):
    """The wave function of an oscillator of mass 1."""
    u = np.sqrt(omega / hbar) * x
    return eval_hermite(n, u) * np.exp(-(u**2) / 2) * (omega / (np.pi * hbar)) ** 0.25 / np.sqrt(2.0**n * factorial(n))


def drawn():
    low, high = [0.5, -0.3, 0.5, 0.5, -0.2, 0.1], [2, 0.3, 2, 2, 0.2, 0.4]
    numbers = dict(zip("wgklce", RNG.uniform(low, high), strict=True))
    return fa.hamiltonian(TEXT, coordinates="x y", momenta="p r", a=RNG.uniform(-2, 2), **numbers), numbers


def test_an_oscillator_and_its_husimi_function_in_closed_form():
    omega, hbar, n = RNG.uniform(0.5, 3), RNG.uniform(0.1, 2), 3
    levels = spectrum(fa.hamiltonian("w**2*x**2/2", coordinates="x", w=omega), count=5, hbar=hbar)
    state = levels.state(n)
    x = np.linspace(-6, 6, 241) * np.sqrt(hbar / omega)
    truth = hermite(n, omega, hbar, x)
    np.testing.assert_allclose(state(x[None]) * np.sign(state([x[130]]) * truth[130]), truth, atol=1e-9)
    Q = husimi(state)
    np.testing.assert_allclose(Q.width, np.sqrt(hbar / (2 * omega)), rtol=1e-6)
    z = RNG.normal(size=(2, 50)) * np.sqrt(hbar) * 2
    size = (z[0] ** 2 * omega + z[1] ** 2 / omega) / (2 * hbar)
    exact = np.exp(-size) * size**n / factorial(n)
    np.testing.assert_allclose(Q(z), exact, atol=1e-8)


def test_states_are_normalised_orthogonal_and_have_the_energies_of_their_levels():
    model, numbers = drawn()
    hbar = RNG.uniform(0.3, 0.8)
    levels = spectrum(model, count=4, hbar=hbar, tolerance=1e-8)
    W = np.array([[1, numbers["g"]], [numbers["g"], numbers["w"]]])
    axis = np.linspace(-9, 9, 301)
    q, cell = np.array(np.meshgrid(axis, axis, indexing="ij")), (axis[1] - axis[0]) ** 2
    waves = np.array([levels.state(k)(q) for k in range(4)])
    np.testing.assert_allclose(np.einsum("aij,bij->ab", waves, waves) * cell, np.eye(4), atol=1e-7)
    for k in range(4):
        state = levels.state(k)
        mean, _, squares = state.moments()
        potential = (state.density(q) * model.potential_energy(*q)).sum() * cell
        assert abs(np.trace(W @ squares) / 2 + potential - levels.E[k]) < 1e-7
        np.testing.assert_allclose(mean, (state.density(q) * q).sum(axis=(1, 2)) * cell, atol=1e-7)


def test_the_husimi_function_is_normalised_and_its_marginal_is_the_smoothed_density():
    model = fa.hamiltonian("D*(1 - exp(-a*x))**2", coordinates="x", D=RNG.uniform(8, 12), a=RNG.uniform(0.2, 0.3))
    hbar = RNG.uniform(0.3, 0.6)
    state = spectrum(model, count=6, hbar=hbar).state(4)
    Q = husimi(state)
    x, p = np.linspace(-12, 30, 421), np.linspace(-8, 8, 401)
    values = Q(np.array(np.meshgrid(x, p, indexing="ij")))
    dx, dp = x[1] - x[0], p[1] - p[0]
    assert abs(values.sum() * dx * dp / (2 * np.pi * hbar) - 1) < 1e-9
    assert abs(Q.norm - 1) < 1e-12
    fine = np.linspace(-12, 30, 2101)
    spread = np.exp(-((x[:, None] - fine) ** 2) / (2 * Q.width[0] ** 2)) / np.sqrt(2 * np.pi) / Q.width[0]
    smooth = spread @ state.density(fine[None]) * (fine[1] - fine[0])
    np.testing.assert_allclose(values.sum(axis=1) * dp / (2 * np.pi * hbar), smooth, atol=1e-9)


def test_two_coordinates_by_quadrature():
    model, _ = drawn()
    hbar = RNG.uniform(0.3, 0.8)
    state = spectrum(model, count=3, hbar=hbar, tolerance=1e-6).state(2)
    width = RNG.uniform(0.4, 0.9, 2)
    axis = np.linspace(-9, 9, 301)
    q, cell = np.array(np.meshgrid(axis, axis, indexing="ij")), (axis[1] - axis[0]) ** 2
    z = RNG.normal(size=(4, 6))
    away = q[:, None] - z[:2, :, None, None]
    packet = np.exp(-((away / (2 * width[:, None, None, None])) ** 2).sum(axis=0)) / np.sqrt(2 * np.pi * width.prod())
    overlap = packet * np.exp(1j * (z[2:, :, None, None] * away).sum(axis=0) / hbar) * state(q)
    truth = np.abs(overlap.sum(axis=(1, 2)) * cell) ** 2
    np.testing.assert_allclose(husimi(state, width=width)(z), truth, atol=1e-8)


@pytest.mark.parametrize("shift", [0.0, np.pi, 2.5])
def test_mean_quanta_of_an_angle_are_those_about_its_well(shift):
    """A stretch and a bend that separate: the bend by plane waves and a quadrature."""
    barrier, hbar = RNG.uniform(1.5, 3), 0.1
    bend = fa.hamiltonian(
        "p**2/2 + r**2/2 + 2*(x - 1)**2 + V*(1 - cos(t - s))",
        coordinates="x t",
        momenta="p r",
        periodic={"t": "2*pi"},
        V=barrier,
        s=shift,
    )
    levels = spectrum(bend, count=1, hbar=hbar, tolerance=1e-8)
    k, t = np.arange(-80, 81), np.linspace(-np.pi, np.pi, 2001)[:-1]
    matrix = np.diag(hbar**2 * k**2 / 2 + barrier) - barrier / 2 * (np.abs(np.subtract.outer(k, k)) == 1)
    ground = np.linalg.eigh(matrix)[1][:, 0]
    density = np.abs(np.exp(1j * np.outer(t, k)) @ ground) ** 2
    squares = density @ t**2 / density.sum(), hbar**2 * ground**2 @ k**2
    omega = np.sqrt(barrier)
    truth = (omega * squares[0] + squares[1] / omega) / (2 * hbar) - 0.5
    fast, slow = levels.state(0).quanta()
    assert abs(fast) < 1e-7
    assert abs(slow - truth) < 1e-6


def test_mean_quanta_of_oscillators_and_polyads_of_a_fermi_resonance():
    """Coupled oscillators in closed form; of a Fermi pair 2 n1 + n2 is whole to second order in the coupling."""
    k, g, hbar = RNG.uniform(1.2, 2), RNG.uniform(0.1, 0.3), RNG.uniform(0.1, 1)
    linear = fa.hamiltonian(
        "(p**2 + r**2)/2 + (x - 1)**2/2 + k*y**2/2 + g*(x - 1)*y", coordinates="x y", momenta="p r", k=k, g=g
    )
    levels = spectrum(linear, count=6, hbar=hbar, tolerance=1e-8)
    omega = np.sqrt(np.linalg.eigvalsh([[1, g], [g, k]]))[::-1]
    for state in map(levels.state, range(6)):
        quanta = state.quanta()
        np.testing.assert_allclose(quanta, np.rint(quanta), atol=1e-6)
        assert abs(hbar * omega @ (quanta + 0.5) - state.energy) < 1e-6
    local = levels.state(0).quanta("local")
    assert local.shape == (2,)
    assert (local > 0).all()
    c = RNG.uniform(0.1, 0.2)
    for weaker, most in ((1.0, 0.05), (0.5, 0.0125)):
        fermi = fa.hamiltonian("2*x**2 + y**2/2 + c*x*y**2", coordinates="x y", c=c * weaker)
        levels = spectrum(fermi, count=9, hbar=0.1, tolerance=1e-6)
        quanta = np.array([levels.state(k).quanta() for k in range(9)])
        P = 2 * quanta[:, 0] + quanta[:, 1]
        np.testing.assert_allclose(P, [0, 1, 2, 2, 3, 3, 4, 4, 4], atol=most)
        assert np.abs(quanta[2:4, 0] - 0.5).max() < 0.2  # the states of a polyad share their quanta


def test_figures_over_the_section_and_the_plane():
    model = fa.HenonHeiles()
    state = spectrum(model, count=8, hbar=0.0125, tolerance=1e-4).state(5)
    axes = [np.linspace(-0.3, 0.3, 9)] * 2
    grid = fa.energy_grid(model, energy=state.energy, section="x=0", axes=axes)
    cut = fa.poincare_map(model, grid.z0[:, :2], section="x=0", crossings=3, max_time=60.0)
    Q = husimi(state)
    figure = fa.plot.plot_husimi(grid, Q(grid.z0), section_map=cut)
    assert figure.missing == 0
    assert len(figure.lines) == 1
    assert Q.plot(grid).missing == 0
    image = state.plot(model=model, points=31)
    assert image.points.get_array().shape == (31, 31)
    assert image.points.axes.get_xlabel() == "$x$"


def test_wrong_calls_say_the_right_one():
    pendulum = fa.hamiltonian("1 - cos(x)", coordinates="x", periodic={"x": "2*pi"})
    state = spectrum(pendulum, count=3).state(0)
    assert abs((state.density(np.arange(64)[None] * 2 * np.pi / 64)).sum() * 2 * np.pi / 64 - 1) < 1e-9
    with pytest.raises(ValueError, match="must have no periodic coordinates for a Husimi function, got x"):
        husimi(state)
    one = spectrum(fa.hamiltonian("x**2/2", coordinates="x"), count=2).state(1)
    with pytest.raises(ValueError, match="width must be one positive number or 1"):
        husimi(one, width=[1.0, 2.0])
    with pytest.raises(ValueError, match="of two coordinates to be drawn"):
        one.plot()
    with pytest.raises(ValueError, match="Did you mean local"):
        one.quanta("locl")
    with pytest.raises(ValueError, match="k must be below"):
        spectrum(pendulum, count=3).state(3)
