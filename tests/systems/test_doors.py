"""Short ways to write equations: second order as typed, and matrices as maps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastaff as fa

# --- x'' = ... ------------------------------------------------------------------------------------------------------


def test_an_equation_of_second_order_is_a_system_of_two_variables():
    oscillator = fa.ode("x'' = mu*(1 - x**2)*x' - x", mu=1.2)
    assert oscillator.coordinates == ("x", "v_x")
    found = fa.integrate(oscillator, [1.0, 0.3], time=6.0).z[:, 0]
    truth = solve_ivp(
        lambda t, z: [z[1], 1.2 * (1 - z[0] ** 2) * z[1] - z[0]], (0, 6), [1.0, 0.3], rtol=1e-12, atol=1e-13
    )
    np.testing.assert_allclose(found, truth.y[:, -1], rtol=1e-9)


def test_equations_of_both_orders_go_together():
    mixed = fa.ode("x'' = -x + c*y' + z; y'' = -2*x' - y\n z' = v_x - z", c=0.5)
    assert mixed.coordinates == ("x", "v_x", "y", "v_y", "z")
    x, v_x, y, v_y, z = row = (0.3, -0.4, 0.7, 1.1, 0.2)
    assert mixed.rates(*row) == pytest.approx((v_x, -x + 0.5 * v_y + z, v_y, -2 * v_x - y, v_x - z), rel=1e-15)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x'' = -x; x' = y; y' = x", "text must have one equation of x, got two"),
        ("x'' = -x; v_x' = x", "text must leave the name v_x to the velocity of x"),
        ("x'' = -x''", "text must give x'' by variables and by x'"),
        ("x'' = -x + y'; y' = x", "text must give x'' by variables and by x'"),
        ("x'' =", "text must give x'' by variables and by x'"),
        ("x''' = -x", "text must be equations such as"),
    ],
)
def test_other_equations_of_second_order_are_refused(text, said):
    with pytest.raises(ValueError, match=said):
        fa.ode(text)


@pytest.mark.parametrize("make", [fa.hamiltonian, fa.affine_body])
def test_equations_are_no_energy(make):
    with pytest.raises(ValueError, match=r"text must be an energy, got equations .*\. Use fa\.ode\(text\)"):
        make("x'' = -x")


# --- matrices -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [2, 4, 8])
def test_a_matrix_is_the_map_of_its_products(rows):
    rng = np.random.default_rng(rows)
    matrix = rng.normal(size=(rows, rows))
    model = fa.iterated_map(matrix)
    z, dz = rng.normal(size=(2, rows, 5))
    np.testing.assert_allclose(model.iterate(*z), matrix @ z, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(model.tangent_iterate(*z, *dz), matrix @ dz, rtol=1e-13, atol=1e-14)
    assert not model.symplectic


def test_a_one_turn_matrix_has_the_tune_of_its_trace():
    """The matrix of a turn with Courant and Snyder's alpha, beta has cos(2 pi nu) = trace/2."""
    nu, alpha, beta = 0.2137, 0.4, 3.0
    c, s = np.cos(2 * np.pi * nu), np.sin(2 * np.pi * nu)
    turn = fa.iterated_map([[c + alpha * s, beta * s], [-(1 + alpha**2) / beta * s, c - alpha * s]])
    assert turn.symplectic
    assert (turn.coordinates, turn.momenta) == (("x",), ("p",))
    orbit = fa.integrate(turn, [0.1, 0.0], time=1024, samples=1024)
    assert abs(fa.tunes(orbit).nu[0, 0] - nu) < 1e-9
    other = turn._replace(m11=2.0)
    assert other.iterate(1.0, 0.0)[0] == 2.0


def test_names_of_the_rows_of_a_matrix():
    model = fa.iterated_map(np.eye(4), coordinates="u v", momenta="pu pv", domain="a**2 - u**2 - v**2", a=2.0)
    assert (model.coordinates, model.momenta) == (("u", "v"), ("pu", "pv"))
    assert model.margin(1.0, 1.0) == 2.0


@pytest.mark.parametrize(
    ("matrix", "named", "error", "said"),
    [
        (np.eye(3), {}, ValueError, r"text must be a matrix of one of the shapes 2x2, .*, got shape \(3, 3\)"),
        (np.ones(4), {}, ValueError, r"got shape \(4,\)"),
        ([[1.0, 0.0], [0.0]], {}, TypeError, "text must be a map or a matrix of real numbers"),
        (np.eye(2) * 1j, {}, TypeError, "text must be a map or a matrix of real numbers"),
        ([["a", "b"], ["c", "d"]], {}, TypeError, "text must be a map or a matrix of real numbers"),
        ([[1.0, np.nan], [0.0, 1.0]], {}, ValueError, "text must be a matrix of finite numbers"),
        (np.eye(4), {"coordinates": "x"}, ValueError, "must each be 2 names for a matrix of 4 rows"),
        (np.eye(2), {"coordinates": "p"}, ValueError, "momenta 'p' is taken"),
        (np.eye(2), {"m11": 1.0}, ValueError, "parameter 'm11' is the name of an entry"),
        (np.eye(2), {"K": 1.0}, ValueError, "parameter 'K' is not used by the map"),
    ],
)
def test_other_arrays_are_refused(matrix, named, error, said):
    with pytest.raises(error, match=said):
        fa.iterated_map(matrix, **named)
