"""H = T(p) + V(q) from a text whose T is not quadratic: splittings, tangent maps and all analyses against truths."""

import numpy as np
import pytest
import shared_systems
import sympy
from scipy.integrate import quad, solve_ivp
from test_contracts import Relativistic

import fastaff as fa
from fastaff.core.status import Status
from fastaff.explorer.records import model_code
from fastaff.runs.schemes import GAUSS16
from fastaff.systems.models.mechanics import system_of

RNG = np.random.default_rng(132)
NAMES = {"coordinates": "x y", "momenta": "px py"}
RELATIVISTIC = "sqrt(m**2 + px**2 + py**2) - m"
T = (
    f"a*({RELATIVISTIC}) + b*(cosh(m*px) + cosh(py) - 2)/m + c*(px**2/(2*m) + py**2/2 + e*(px**4/4 + py**4*px**2))"
    " + d*(px**2 + m*py**2)**2/4"
)
V = "x**2/2 + k*y**2 + s*x**2*y + r*x**2*y**2"
"""One system, which is compiled once; its parameters choose T and V of each test."""

KINETIC = {"relativistic": "a", "hyperbolic": "b", "quartic": "c", "flat": "d", "all": "abcd"}
CHOICE = dict.fromkeys("abcd", 0.0) | {"e": 1.0, "m": 1.0, "k": 0.7, "s": 1.0, "r": 0.0}


def chosen(kinds, **more):
    """Names and parameters of the system whose T is the sum of these terms."""
    return {**NAMES, **CHOICE, **dict.fromkeys(kinds, 1.0), **more}


def pair(T=T, V=V, **more):
    """The system of the text, and the same H as H(q, p): the factor 1 of T has both coordinates and momenta."""
    x = more.get("coordinates", "x").split()[0]
    split = fa.hamiltonian(f"{T} + {V}", **more)
    whole = fa.hamiltonian(f"({T})*(cos({x})**2 + sin({x})**2) + {V}", **more)
    assert system_of(split).nonquadratic
    assert system_of(whole).nonseparable
    return split, whole


def symplectic(matrix):
    n = len(matrix) // 2
    J, M = np.kron([[0, 1], [-1, 0]], np.eye(n)), np.moveaxis(matrix, -1, 0)
    return np.abs(np.swapaxes(M, 1, 2) @ J @ M - J).max() / np.abs(M).max() ** 2


@pytest.mark.parametrize("name", KINETIC)
def test_orbits_and_tangent_maps_are_those_of_collocation(name):
    m, z0 = 10 ** RNG.uniform(-0.2, 0.2), RNG.uniform(-0.2, 0.2, (4, 8))
    split, whole = pair(**chosen(KINETIC[name], m=m))
    assert split.kinetic_energy(0.0, 0.0) == 0.0
    np.testing.assert_allclose(system_of(split).energies(z0), whole.energy(*z0), rtol=1e-14, atol=1e-15)
    one, other = (fa.integrate(model, z0, time=40.0, accuracy=1e-10) for model in (split, whole))
    assert one.scheme == fa.KAHAN_LI8
    assert (one.status == Status.OK).all()
    assert (np.abs(one.z - other.z) <= one.error + other.error).all()
    one, other = (fa.tangent_map(model, z0, time=20.0).matrix for model in (split, whole))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-6 * np.abs(other).max())
    assert symplectic(one) < 1e-13
    alone = fa.integrate(split, z0[:, 3], time=40.0, accuracy=1e-10)  # one orbit runs by a loop of its own
    np.testing.assert_array_equal(alone.z[:, 0], fa.integrate(split, z0, time=40.0, accuracy=1e-10).z[:, 3])


@pytest.mark.parametrize(
    "text",
    [
        "cosh(px) + 2*cosh(py) - cos(x) - cos(y) + 0.3*cos(x - y)",
        "log(1 + px**2) + py**4/4 + py**2/2 + exp(x) - x + x**2*y**2 + y**4",
        "1 - cos(px) + exp(py) - py + x**2/2 + 1.3*y**2",
    ],
)
def test_orbits_are_those_of_another_program(text):
    """SciPy's, by derivatives of SymPy; the errors cover, also of an orbit at rest and of chaotic ones."""
    names = sympy.symbols("x y px py")
    slopes = [sympy.sympify(text, locals={str(name): name for name in names}).diff(name) for name in names]
    rates = sympy.lambdify(names, [*slopes[2:], -slopes[0], -slopes[1]])
    z0 = 0.4 * np.random.default_rng(len(text)).standard_normal((4, 5))
    z0[:, 4] = 0.0
    found = fa.integrate(fa.hamiltonian(text, **NAMES), z0, time=30.0, accuracy=1e-9)
    truth = [solve_ivp(lambda t, z: rates(*z), (0, 30), z, method="DOP853", rtol=1e-13, atol=1e-13).y for z in z0.T]
    off = np.abs(found.z - np.array([y[:, -1] for y in truth]).T).max(axis=0)
    assert found.success
    assert found.scheme.name == "KAHAN_LI8"
    assert (off <= found.error.max(axis=0) + 1e-11).all()
    assert (off[:4] < 1e-6).all()


@pytest.mark.parametrize(
    ("scheme", "step"),
    [(fa.LEAPFROG, 0.02), (fa.YOSHIDA4, 0.05), (fa.KAHAN_LI8, 0.25), (fa.SOFRONIOU_SPALETTA10, 1.0)],
    ids=lambda entry: getattr(entry, "name", ""),
)
def test_splittings_keep_their_orders_and_the_symplectic_form(scheme, step):
    model, z0 = fa.hamiltonian(f"{T} + {V}", **chosen("a")), [0.3, -0.2, 0.1, 0.25]
    fine = fa.integrate(model, z0, time=10.0, scheme=fa.SOFRONIOU_SPALETTA10, step=0.02).z
    error = [np.abs(fa.integrate(model, z0, time=10.0, scheme=scheme, step=h).z - fine).max() for h in (step, step / 2)]
    assert np.log2(error[0] / error[1]) > scheme.order - 0.5
    assert symplectic(fa.tangent_map(model, z0, time=10.0, scheme=scheme, step=step).matrix) < 1e-13


def test_tangent_maps_of_many_coordinates_are_right():
    """So many vectors that loops over lanes were several: all have the momenta before the kick."""
    more = {"coordinates": "x y z w", "momenta": "p q r s"}
    split, whole = pair("sqrt(1 + p**2 + q**2 + r**2 + s**2) - 1", "(x**2 + y**2 + z**2 + w**2)/2 + x*y*z*w", **more)
    z0 = RNG.uniform(-0.5, 0.5, (8, 3))
    one, other = (fa.tangent_map(model, z0, time=8.0).matrix for model in (split, whole))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-8)
    assert symplectic(one) < 1e-13


def test_a_relativistic_oscillator_has_the_period_of_its_quadrature():
    k = 10 ** RNG.uniform(-0.5, 0.5)
    model = fa.hamiltonian("sqrt(1 + p**2) - 1 + k*x**2/2", coordinates="x", momenta="p", k=k)
    X = 10 ** RNG.uniform(-1, 1, 6)

    def time(angle, X):  # of dx = X cos(angle), v = sqrt(g^2 - 1)/g with g = 1 + k (X^2 - x^2)/2
        u = k * (X * np.cos(angle)) ** 2 / 2
        return (1 + u) / np.sqrt(k / 2 * (2 + u))

    truth = np.array([4 * quad(time, 0, np.pi / 2, args=(x,), epsabs=0, epsrel=1e-13)[0] for x in X])
    found = fa.frequency_map(model, [X, 0 * X], time=400 * truth.max())
    np.testing.assert_allclose(1 / found.nu[0], truth, rtol=1e-9)
    cut = fa.poincare_map(model, [X, 0 * X], section="x=0", crossings=6, max_time=8 * truth.max(), accuracy=1e-11)
    np.testing.assert_allclose(cut.times[5] - cut.times[0], 5 * truth, rtol=1e-9)


def test_scales_are_those_of_the_motion_where_masses_are_infinite_at_rest():
    """T = p^4/4 has no mass at p = 0: from rest, next to it and far from it, in any units of the momentum."""
    for size in (1.0, 1e-3, 1e3):
        split, whole = pair("b*(p/b)**4/4", "b*x**2/2", coordinates="x", momenta="p", b=size)
        z0 = np.array([[1.0, 0.0, 0.3, 1.0], [0.0, 1.0, 0.4, 1e-3]]) * np.array([[1.0], [size]])
        found = fa.integrate(split, z0, time=30.0, accuracy=1e-9)
        truth = fa.integrate(whole, z0, time=30.0, scheme=GAUSS16, step=0.01).z
        assert (np.abs(found.z - truth) <= found.error).all()
        assert (found.error <= 1e-8 * np.array([[1.0], [size]])).all()


def test_sections_frequencies_chaos_and_periodic_orbits_are_those_of_h_of_q_and_p():
    models = pair(**chosen("a"))
    starts = [fa.energy_sample(model, orbits=24, energy=0.1, section="y=0", seed=3).z0 for model in models]
    np.testing.assert_allclose(*starts, rtol=0, atol=1e-12)
    z0, cuts = starts[0], []
    for model in models:
        cuts.append(fa.poincare_map(model, z0, section="y=0", crossings=10, max_time=300.0, accuracy=1e-9))
    off = np.abs(cuts[0].points - cuts[1].points)
    assert (off <= cuts[0].point_error + cuts[1].point_error).mean() > 0.99
    for measure in (
        lambda model: fa.frequency_map(model, z0[:, :6], time=500.0).nu,
        lambda model: fa.find_periodic_orbits(model, z0[:, :6], section="y=0", max_crossings=3, max_time=100.0).period,
    ):
        np.testing.assert_allclose(*map(measure, models), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(*(fa.chaos_map(model, z0, time=200.0).megno for model in models), rtol=0, atol=3e-3)


def test_chaos_has_the_exponents_of_collocation():
    """Of chaotic orbits exponents agree within their spread; orbits of both kinds have the same classifications."""
    models = pair(**chosen("a", k=0.5, s=0.0, r=4.0))
    z0 = fa.energy_sample(models[0], orbits=24, energy=2.0, section="y=0", seed=5).z0
    found = [fa.chaos_map(model, z0, time=2000.0, indicators=[fa.Lyapunov()]) for model in models]
    one, other = (np.sort(entry.lyapunov) for entry in found)
    assert one[-12:].mean() > 0.05
    np.testing.assert_allclose(one[-12:].mean(), other[-12:].mean(), rtol=0.05)


def test_a_driven_one_is_split_too():
    drive = {"coordinates": "x", "momenta": "p", "drive_period": "2*pi/w", "e": 0.3, "w": RNG.uniform(1, 2)}
    models = pair("sqrt(1 + p**2) - 1", "x**2/2 + x**4/4 - e*x*cos(w*t)", **drive)
    assert models[0].momenta == ("p", "p_t")
    z0 = RNG.uniform(-0.4, 0.4, (2, 6))
    one, other = (fa.integrate(model, z0, time=50.0, accuracy=1e-10) for model in models)
    assert (np.abs(one.z - other.z) <= one.error + other.error).all()
    assert (one.energy_error < 1e-9).all()
    one, other = (fa.poincare_map(model, z0, section="t=0", crossings=8, accuracy=1e-10).points for model in models)
    np.testing.assert_allclose(one[[0, 2]], other[[0, 2]], rtol=0, atol=1e-8)
    fine = [(fa.SOFRONIOU_SPALETTA10, 0.02), (GAUSS16, 0.05)]
    one, other = (fa.tangent_map(m, z0, time=20.0, scheme=s, step=h).matrix for m, (s, h) in zip(models, fine))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


def tangent_velocity(self, px, py, dx, dy):
    w = 1 / np.sqrt(self.m**2 + px * px + py * py)
    along = (px * dx + py * dy) * w * w
    return (dx - px * along) * w, (dy - py * along) * w


def tangent_force(self, x, y, dx, dy):
    return -dx, -dy


OWN = {name: entry for name, entry in vars(Relativistic).items() if not name.startswith("_") and name != "m"}
TANGENT = {"tangent_velocity": tangent_velocity, "tangent_force": tangent_force}
Fast = type("Fast", (Relativistic,), {**OWN, **TANGENT})
Wrong = type("Wrong", (Relativistic,), {**OWN, **TANGENT, "tangent_velocity": lambda self, px, py, dx, dy: (dx, dy)})


def test_a_class_has_tangent_vectors_by_its_tangent_velocity():
    z0 = RNG.uniform(-1, 1, (4, 6))
    text = fa.hamiltonian(f"{T} + {V}", **chosen("a", m=0.8, k=0.5, s=0.0))
    one, other = (fa.tangent_map(model, z0, time=10.0).matrix for model in (Fast(0.8), text))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-11 * np.abs(other).max())
    with pytest.raises(ValueError, match="tangent_velocity and a tangent_force that is the change of its rates"):
        fa.tangent_map(Wrong(), z0, time=1.0)
    lacking = type("Lacking", (Fast,), {"tangent_velocity": property(lambda self: self.none)})
    with pytest.raises(ValueError, match=r"must have tangent_velocity\(p..., dp...\) for deviation vectors"):
        fa.chaos_map(lacking(), z0, time=10.0)


def test_a_quadratic_special_case_takes_the_schemes_of_quadratic_ones():
    """Parameters may make T quadratic: Nyström schemes then know its vectors too."""
    model = fa.hamiltonian(f"{T} + {V}", **chosen("c", e=0.0))
    plain, z0 = shared_systems.plane(1, 1.4, c=1), RNG.uniform(-0.3, 0.3, (4, 5))
    assert not system_of(model).nonquadratic
    for scheme in (fa.schemes.RKN12, fa.BLANES_MOAN6):
        one, other = (fa.tangent_map(entry, z0, time=10.0, scheme=scheme, step=0.1).matrix for entry in (model, plain))
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-13)
    assert fa.integrate(model._replace(e=0.1), z0, time=5.0).scheme == fa.KAHAN_LI8
    with pytest.raises(ValueError, match="only if T is quadratic"):
        fa.integrate(model._replace(e=0.1), z0, time=5.0, scheme=fa.schemes.RKN12)


def test_a_page_runs_it_as_h_of_q_and_p():
    pages = [model_code(system_of(model)) for model in pair(**chosen("a"))]
    for page in pages:
        assert page["kind"] == "equations"
        assert len(page["methods"]["tangent"]["results"]) == 4
    assert pages[0]["methods"].keys() == pages[1]["methods"].keys()


@pytest.mark.parametrize(
    "T", ["cos(p)", "p**2/2 - p**4/4", "p**3/3", "tan(p)**2", "sqrt(1 - p**2)", "p**2/2 + 1/(3 + p)"]
)
def test_what_ends_or_is_least_elsewhere_is_left_to_collocation(T):
    assert system_of(fa.hamiltonian(f"{T} + x**2/2", coordinates="x", momenta="p")).nonseparable


def test_the_command_and_exported_equations(here):
    pytest.importorskip("cyclopts")
    from fastaff.cli.main import main
    from fastaff.exchange.sources import source

    text = "sqrt(m**2 + p**2 + u**2) - m + (x**2 + y**2)/2 + x**2*y"
    words = [f"--hamiltonian={text}", "--coordinates", "x y", "--momenta", "p u", "--parameter", "m=1"]
    how = ["--energy", "0.05", "--orbits", "4", "--time", "60", "--no-figure"]
    assert main(["chaos-map", *words, *how]) == 0
    found = fa.load("fastaff-chaos-map.npz")
    assert len(found) == 4
    assert np.isfinite(found.megno).all()
    assert "heyoka.make_vars('x', 'y', 'p', 'u')" in source(
        fa.hamiltonian(text, coordinates="x y", momenta="p u", m=1.0), "heyoka"
    )
