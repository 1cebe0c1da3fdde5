"""Levels of H = T(p) + V(q) in one to three coordinates: closed forms, other bases, complex scaling, published ones."""

import threading

import numpy as np
import pytest
from scipy.linalg import eigh, eigh_tridiagonal
from test_quantum_vibration_errors import graded, on_elements

import fastaff as fa
from fastaff.quantum import NoGroundState, spectrum
from fastaff.quantum.solvers.lapack import lowest_states

RNG = np.random.default_rng(31)


def close(found, truth, factor=1.0):
    """Whether levels are within their errors, which are small."""
    assert (np.abs(found.E - truth) <= factor * found.error).all(), np.abs(found.E - truth) / found.error
    assert (found.n == np.arange(len(truth))).all()
    assert not found.m.any()
    assert not found.l.any()


def ladders(*ladders_of_modes):
    """Sums of the levels of modes, ascending."""
    sums = np.zeros(1)
    for levels in ladders_of_modes:
        sums = np.add.outer(sums, levels).ravel()
    return np.sort(sums)


def test_coupled_oscillators_whose_masses_are_parameters():
    m, n, g, k, hbar = *(RNG.uniform(0.5, 2, 4) * [1, 1, 0.3, 3]), 10.0 ** RNG.uniform(-3, 3)
    text = "p1**2/(2*m) + p2**2/(2*(m + n)) + g*p1*p2 + k*(x**2 + y**2)/2"
    model = fa.hamiltonian(text, coordinates="x y", momenta="p1 p2", m=m, n=n, g=g, k=k)
    modes = np.sqrt(k * np.linalg.eigvalsh([[1 / m, g], [g, 1 / (m + n)]]))
    found = spectrum(model, count=12, hbar=hbar)
    close(found, hbar * ladders(*(w * (np.arange(30) + 0.5) for w in modes))[:12])
    assert found.converged.all()


def test_waves_as_long_as_the_wells_are_told_to_be():
    with pytest.raises(NoGroundState, match=r"no well of V holds a level.* give a smaller hbar"):
        spectrum(fa.HenonHeiles(), count=5, hbar=1.0)


def test_three_coordinates():
    k = RNG.uniform(0.5, 2, 3)
    model = fa.hamiltonian("(k1*x**2 + k2*y**2 + k3*z**2)/2", coordinates="x y z", k1=k[0], k2=k[1], k3=k[2])
    found = spectrum(model, count=3, tolerance=1e-3)
    close(found, ladders(*(np.sqrt(k)[:, None] * (np.arange(9) + 0.5)))[:3])
    assert found.error.max() < 1e-2


@pytest.mark.parametrize("count", [3, 18])
def test_a_morse_oscillator_up_to_its_end(count):
    D, a = RNG.uniform(8, 12), RNG.uniform(0.18, 0.2)  # 22 levels and more
    found = spectrum(fa.hamiltonian("D*(1 - exp(-a*x))**2", coordinates="x", D=D, a=a), count=count)
    omega = a * np.sqrt(2 * D) * (np.arange(count) + 0.5)
    close(found, omega - omega**2 / (4 * D))
    assert found.converged.all()
    with pytest.raises(NoGroundState, match="no end"):
        spectrum(fa.hamiltonian("D*(1 - exp(-a*x))**2", coordinates="x", D=D, a=a), count=80)


def test_a_pendulum_against_mathieu():
    from scipy.special import mathieu_a, mathieu_b

    k = RNG.uniform(0.5, 5)
    found = spectrum(fa.hamiltonian("k*(1 - cos(x))", coordinates="x", periodic={"x": "2*pi"}, k=k), count=9)
    a, b = (f(np.arange(first, 14, 2), 4 * k) for f, first in ((mathieu_a, 0), (mathieu_b, 2)))
    close(found, k + np.sort(np.concatenate([a, b]))[:9] / 8)


def products(n, hbar):
    """Matrices of x and p^2 in n states of an oscillator."""
    x = np.sqrt(hbar / 2) * (np.diag(np.sqrt(np.arange(1, n)), 1) + np.diag(np.sqrt(np.arange(1, n)), -1))
    lower = np.sqrt(hbar / 2) * (np.diag(np.sqrt(np.arange(1, n)), 1) - np.diag(np.sqrt(np.arange(1, n)), -1))
    return x, -(lower @ lower)


def test_a_coupled_quartic_against_a_basis_of_oscillators():
    """Pullen and Edmonds' V = (x^2 + y^2)/2 + k x^2 y^2, with quartics of both."""
    k, b, hbar, n = RNG.uniform(0.05, 0.3), RNG.uniform(0.02, 0.1), RNG.uniform(0.5, 1.0), 26
    x, p2 = products(n + 8, hbar)
    one = p2 / 2 + x @ x / 2 + b * np.linalg.matrix_power(x, 4)
    one, x2, unit = one[:n, :n], (x @ x)[:n, :n], np.eye(n)
    truth = np.linalg.eigvalsh(np.kron(one, unit) + np.kron(unit, one) + k * np.kron(x2, x2))[:6]
    model = fa.hamiltonian("(x**2 + y**2)/2 + k*x**2*y**2 + b*(x**4 + y**4)", coordinates="x y", k=k, b=b)
    found = spectrum(model, count=6, hbar=hbar, tolerance=1e-6)
    assert (np.abs(found.E - truth) <= found.error + 1e-6).all()
    assert found.converged.all()


def test_henon_heiles_as_published():
    """Noid & Marcus 1977, J. Chem. Phys. 67, 559; Davis 1979: lambda = sqrt(0.0125), here with hbar = lambda^2."""
    published = [0.9986, 1.9901, 1.9901, 2.9562, 2.9853, 2.9853, 3.9260, 3.9260, 3.9824, 3.9858, 4.8702, 4.8987]
    found = spectrum(fa.HenonHeiles(), count=12, hbar=0.0125, tolerance=1e-8)
    np.testing.assert_allclose(found.E / 0.0125, published, atol=6e-5)
    assert found.converged.all()
    assert "walls below" in found.method
    drawn = fa.plot.plot_spectrum(found)
    assert drawn.colorbar is None
    assert not drawn.points.axes.get_xlabel()


def test_a_metastable_well_against_complex_scaling():
    """V = x^2/2 - g x^3: real parts of resonances; x -> x e^(i angle) turns them into eigenvalues."""
    g, n, turn = RNG.uniform(0.06, 0.075), 120, np.exp(0.3j)
    x, p2 = products(n + 8, 1.0)
    H = p2 / 2 / turn**2 + x @ x * turn**2 / 2 - g * np.linalg.matrix_power(x, 3) * turn**3
    E = np.linalg.eigvals(H[:n, :n])
    E = E[np.abs(E.imag) < 0.1]
    found = spectrum(fa.hamiltonian("x**2/2 - g*x**3", coordinates="x", g=g), count=3)
    truth = E[np.abs(E[:, None] - found.E).argmin(axis=0)]
    assert (np.abs(found.E - truth.real) <= found.error + np.abs(truth.imag)).all()
    assert (np.abs(truth.imag[:2]) < 1e-3).all()
    assert found.error[-1] > 1e-6  # tunnelling


def test_a_singular_barrier_has_errors_that_cover():
    """V = x^2/2 + c/x^2 on either side of a barrier, to which a uniform grid converges slowly: 2 n + 1 + s."""
    c = RNG.uniform(0.5, 2)
    found = spectrum(fa.hamiltonian("x**2/2 + c/x**2", coordinates="x", c=c), count=6)
    close(found, np.repeat(2 * np.arange(3) + 1 + np.sqrt(0.25 + 2 * c), 2))
    assert not found.converged.any()


@pytest.mark.parametrize("width", [0.3, 0.05, 0.01, 0.003])
def test_a_barrier_narrower_than_the_waves(width):
    """Against finite elements that are small where the barrier is: a uniform grid hardly sees it."""
    height, place = (float(x) for x in RNG.uniform([1, -0.5], [5, 0.5]))
    text = f"x**2/2 + {height!r}*exp(-((x - ({place!r}))/{width!r})**2)"
    truth = on_elements(text, graded(place, width, 11.0), 6)
    found = spectrum(fa.hamiltonian(text, coordinates="x"), count=6)
    assert (np.abs(found.E - truth) <= found.error + 1e-11 * truth).all(), np.abs(found.E - truth) / found.error


@pytest.mark.parametrize("text", ["y**2/2 - x**2/2", "x + y", "-1/sqrt(x**2 + y**2)", "x**2*y**2", "cos(x) + y**2"])
def test_what_has_no_levels_says_so(text):
    with pytest.raises(NoGroundState):
        spectrum(fa.hamiltonian(text, coordinates="x y"), count=4)


@pytest.mark.parametrize(
    ("text", "place"),
    [("-x**2", "x = 1e[+]08 it is -1e[+]16"), ("-sqrt(1 + x**2)", "it is -1e[+]08"), ("1/(1 + x**2)", "it is 1e-16")],
)
def test_a_potential_that_only_falls_says_where_it_is_low(text, place):
    with pytest.raises(NoGroundState, match=f"V has no minimum, so it binds no level: .* {place}"):
        spectrum(fa.hamiltonian(text, coordinates="x"), count=2)


def test_masses_that_depend_on_the_place_are_told_of_tori():
    """The levels by the torus that the refusal names are those of its Hamiltonian's action, by quadrature."""
    model = fa.hamiltonian("p**2/(2*(1 + q**2)) + q**2/2", coordinates="q", momenta="p")
    with pytest.raises(TypeError, match=r"must be a system H = T\(p\) \+ V\(q\), got H\(q, p\)\. Use fa.fit_torus"):
        spectrum(model, count=2)
    fit = fa.fit_torus(model, [0.4, 0.0], time=300.0)
    q = 0.4 * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 4001))
    J = 2 * np.trapezoid(np.sqrt((1 + q**2) * (0.4**2 - q**2)), q)
    assert fit.maslov == [2]
    np.testing.assert_allclose(fit.J, J, rtol=1e-6)


def test_wrong_calls_say_the_right_one():
    model = fa.hamiltonian("x**2/2", coordinates="x")
    with pytest.raises(ValueError, match="m is for a Body alone"):
        spectrum(model, m=0, l=0, count=2)
    with pytest.raises(TypeError, match="needs m and l"):
        spectrum(fa.Body(fa.Harmonic()), count=2)
    with pytest.raises(ValueError, match="count must be at least 1"):
        spectrum(model, count=0)
    with pytest.raises(ValueError, match=r"count = 8000 needs more than 2500 functions .* Try a larger hbar"):
        spectrum(fa.HenonHeiles(), count=8000, hbar=1e-4)
    four = fa.hamiltonian("(a**2 + b**2 + c**2 + d**2)/2", coordinates="a b c d")
    with pytest.raises(TypeError, match="one to 3 coordinates"):
        spectrum(four, count=2)


def matrix_of_700_rows():
    H = np.random.default_rng(5).normal(size=(700, 700))
    return H + H.T


def by_scipy(H):
    return eigh(H, subset_by_index=(0, 199), check_finite=False, driver="evr")


def test_lowest_states_have_the_bits_of_scipy():
    H = matrix_of_700_rows()
    E, C = lowest_states(H, 200)
    same, vectors = by_scipy(H)
    np.testing.assert_array_equal(E, same)
    np.testing.assert_array_equal(C, vectors)
    with pytest.raises(np.linalg.LinAlgError, match="dsyevr found"):
        lowest_states(np.full((3, 3), np.nan), 3)


@pytest.mark.race
def test_other_threads_go_on_while_levels_are_looked_for():
    """A thread counts meanwhile, as Ctrl-C and progress need; with SciPy's call it waits."""
    H, ended, counts = matrix_of_700_rows(), threading.Event(), []

    def count():
        while not ended.wait(0.001):
            counts.append(None)

    def counted(solver):
        before = len(counts)
        solver()
        return len(counts) - before

    thread = threading.Thread(target=count)
    thread.start()
    try:
        ours = counted(lambda: lowest_states(H, 200))
        theirs = counted(lambda: by_scipy(H))
    finally:
        ended.set()
        thread.join()
    assert ours > 10 * max(theirs, 1)


def test_a_well_that_rises_as_a_logarithm_is_cut_where_no_wave_comes():
    """Where V is twice as high it is exponentially wider: grids up to there would take minutes."""
    s, hbar = RNG.uniform(1.5, 2.5), RNG.uniform(0.6, 0.8)
    levels = spectrum(fa.hamiltonian("log(s**2 + x**2)", coordinates="x", s=s), count=3, hbar=hbar, tolerance=1e-7)
    assert levels.converged.all()
    assert levels.state(0).table.size < 1000
    rows = []
    for points in (8000, 16000):
        step = 120 / points
        V = np.log(s**2 + (np.arange(1, points) * step - 60) ** 2)
        kinetic = hbar**2 / step**2
        off = np.full(points - 2, -kinetic / 2)
        rows.append(eigh_tridiagonal(kinetic + V, off, select="i", select_range=(0, 2))[0])
    truth = (4 * rows[1] - rows[0]) / 3
    np.testing.assert_array_less(np.abs(levels.E - truth), levels.error + 1e-8)
