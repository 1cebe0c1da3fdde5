"""Turning frames and uniform magnetic fields: against frames at rest, closed forms and published numbers."""

from types import FunctionType
from typing import NamedTuple

import mpmath
import numpy as np
import pytest
import shared_systems
from exact_steps import fma_exact, run_block, run_single
from own_models import OneSpring
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import fastaff as fa
from fastaff.engine import source
from fastaff.engine.blocks import model_block
from fastaff.engine.fused import FUSED
from fastaff.engine.jit import JIT_DISABLED, LANES
from fastaff.engine.turning import FRAME, turn
from fastaff.engine.values import parameters
from fastaff.jobs import EnergySurface, InitialConditions, Job, Model, PoincareOptions
from fastaff.jobs.system import described
from fastaff.runs.schemes.catalogue import KAHAN_LI8, SCHEMES, Splitting
from fastaff.systems.models.contracts import Kind
from fastaff.systems.models.mechanics import system_of

SPLITTINGS = [scheme for scheme in SCHEMES.values() if isinstance(scheme, Splitting)]
MOON = 1.215058560962404e-2
"""m_2/(m_1 + m_2) of Earth and Moon as of JPL's catalogue of periodic orbits."""

POINTS = [0.8369151257723572, 1.155682165444884, -1.005062645810278]
"""x of L1, L2, L3 for MOON: ssd-api.jpl.nasa.gov/periodic_orbits.api (Park et al. 2021), field `L1` and so on."""


def three_bodies(m=MOON):
    """The restricted three-body problem in the plane."""
    V = "-(1 - m)/sqrt((x + m)**2 + y**2) - m/sqrt((x - 1 + m)**2 + y**2)"
    return fa.hamiltonian(V, rotation=1.0, m=m)


def triangular(m=MOON):
    """L4, at rest in the frame."""
    x, y = 0.5 - m, np.sqrt(0.75)
    return np.array([x, y, -y, x])


exact_turn = FunctionType(turn.__code__, {**turn.__globals__, "fma": fma_exact})
"""`turn` as Python computes it, with exact sums."""


class Bar(NamedTuple):
    """A logarithmic potential that turns, of somebody's own class: V = v^2 log(c^2 + x^2 + y^2/s^2)/2 and mass m."""

    omega: float = 0.3
    v: float = 1.0
    c: float = 0.2
    s: float = 0.8
    m: float = 1.0
    kind = Kind.ROTATING
    degrees_of_freedom = 2
    coordinates = ("x", "y")

    def angular_velocity(self):
        return self.omega

    def velocity(self, px, py):
        return px / self.m, py / self.m

    def kinetic_energy(self, px, py):
        return (px * px + py * py) / (2 * self.m)

    def force(self, x, y):
        w = self.m * self.v**2 / (self.c**2 + x * x + y * y / self.s**2)
        return -w * x, -w * y / self.s**2

    def potential_energy(self, x, y):
        return self.m * self.v**2 * np.log(self.c**2 + x * x + y * y / self.s**2) / 2

    def margin(self, x, y):
        return 1.0 + 0.0 * (x + y)


def seen(model, z):
    """z as coordinates and velocities in the frame."""
    n = model.degrees_of_freedom
    return np.concatenate([z[:n], system_of(model).velocities(z)])


def at_rest(omega, t, w):
    """Coordinates and velocities of a turning frame seen from one at rest."""
    c, s = np.cos(omega * t), np.sin(omega * t)
    turned, rate = np.array([[c, -s], [s, c]]), omega * np.array([[-s, -c], [c, -s]])
    q, v = w[:2], w[2:]
    return np.concatenate([turned @ q, turned @ v + rate @ q])


@pytest.mark.parametrize("seed", range(4))
def test_a_turning_frame_shows_the_motion_of_a_frame_at_rest(seed):
    """The bar turned by hand and integrated by SciPy in the frame at rest, in random units."""
    rng = np.random.default_rng(seed)
    length, time, mass = 10.0 ** rng.uniform(-3, 3, 3)
    omega = rng.uniform(-1.5, 1.5)
    bar = Bar(omega / time, length / time, 0.2 * length, rng.uniform(0.7, 1.0), mass)
    z = rng.uniform(-1, 1, (4, 5)) * np.repeat([length, mass * length / time], 2)[:, None]
    ran = fa.integrate(bar, z, time=8 * time)

    def slope(t, w):
        turned = Rotation.from_euler("z", omega * t).as_matrix()[:2, :2]
        q = turned.T @ (w[:2] * length)
        return np.concatenate([w[2:], turned @ np.array(bar.force(*q)) * time**2 / (mass * length)])

    assert (ran.status == fa.Status.OK).all()
    for o in range(z.shape[1]):
        start = np.concatenate([z[:2, o] / length, z[2:, o] * time / (mass * length)])  # p is m times the speed at rest
        truth = solve_ivp(slope, (0, 8), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        frame = seen(bar, ran.z[:, [o]])[:, 0] / np.repeat([length, length / time], 2)
        error = ran.error[:, o].max() / length  # that of momenta in their units is no larger here
        assert np.abs(at_rest(omega, 8.0, frame) - truth).max() <= 5 * error + 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_a_magnetic_field_turns_charges_by_the_force_of_lorentz(seed):
    """Three coordinates, random masses and field: x, y, z and velocities of m q'' = -grad V + e q' x B by SciPy."""
    rng = np.random.default_rng(10 + seed)
    m, M, eB, k = *rng.uniform(0.3, 3, 2), rng.uniform(-3, 3), rng.uniform(0.2, 1)
    model = shared_systems.charge(k, 0.1, eB, (m, m, M))
    assert model.angular_velocity() == pytest.approx(eB / (2 * m))
    z = 0.4 * rng.standard_normal((6, 4))
    ran = fa.integrate(model, z, time=25.0)

    def slope(t, w):
        x, y, c, u, v, _ = w
        force = [-k * x - 0.1 * y * c + eB * v, -k * y - 0.1 * x * c - eB * u, -2 * k * c - 0.1 * x * y]
        return np.concatenate([w[3:], np.array(force) / [m, m, M]])

    for o in range(z.shape[1]):
        truth = solve_ivp(slope, (0, 25), seen(model, z)[:, o], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        np.testing.assert_allclose(seen(model, ran.z)[:, o], truth, atol=3e-9)


@pytest.mark.parametrize("scheme", SPLITTINGS, ids=lambda s: s.name)
def test_splittings_keep_their_order(scheme):
    """Also the Nystroem ones: drift and rotation commute, and with V they make double brackets that depend on q
    alone.
    """
    model, z = three_bodies(), np.array([0.5, 0.0, 0.1, 1.2])
    truth = solve_ivp(
        lambda t, w: system_of(model).slopes(w[:, None])[:, 0], (0, 3), z, method="DOP853", rtol=3e-14, atol=1e-15
    ).y[:, -1]
    longest = {2: 0.02, 4: 0.025}.get(scheme.order, 0.1)
    steps = np.array([longest, longest / 2])
    errors = [np.abs(fa.integrate(model, z, time=3.0, step=h, scheme=scheme).z[:, 0] - truth).max() for h in steps]
    assert errors[1] < 1e-2
    assert np.log2(errors[0] / errors[1]) > scheme.order - 1.0


@pytest.mark.parametrize("scheme", SPLITTINGS, ids=lambda s: s.name)
def test_free_motion_is_exact_whatever_the_step(scheme):
    """Steps of many turns too: a straight line in the frame at rest, and lanes that turn by odd and even half turns."""
    rng = np.random.default_rng(3)
    omega, end = 1.3, 700.0
    model, z = shared_systems.turning_springs(0.0, 0.0, omega), rng.standard_normal((4, 40))
    for step in (0.7, 0.01 + 40 * rng.uniform(size=40)):
        ran = fa.integrate(model, z, time=end, step=step, scheme=scheme)
        angle = omega * end
        c, s = np.cos(angle), np.sin(angle)
        q, p = z[:2] + end * z[2:], z[2:]
        truth = np.array([c * q[0] + s * q[1], c * q[1] - s * q[0], c * p[0] + s * p[1], c * p[1] - s * p[0]])
        assert np.abs(ran.z - truth).max() <= 1e-10 * end
    for o in (0, 7):
        alone = fa.integrate(model, z[:, o], time=end, step=step[o], scheme=scheme)
        np.testing.assert_array_equal(alone.z[:, 0], ran.z[:, o])


@pytest.mark.skipif(not FUSED or JIT_DISABLED, reason="no such instruction")
@pytest.mark.parametrize("kind", ["splitting", "precise_splitting"])
@pytest.mark.parametrize("lanes", [1, 3, 8, 13, 128])
@pytest.mark.parametrize("alike", [False, True])
def test_a_block_has_the_bits_of_its_text(alike, lanes, kind):
    """As for other models: compiled or run by Python with exact sums, in vectors or alone, with steps of all sizes, or
    one for all lanes.
    """
    model, rows, rng = three_bodies(0.3), 4, np.random.default_rng(lanes)
    size, tables = rows * (1 if kind == "splitting" else 3), (KAHAN_LI8.drift_array, KAHAN_LI8.kick_array)
    z = np.zeros((size + FRAME.substep.spare_rows(tables[0].size, tables[1].size)) * LANES)
    for r in range(rows):
        z[r * LANES : r * LANES + lanes] = 2.0 + rng.standard_normal(lanes)
    step = rng.uniform(0.01, 0.1, LANES)
    step[::3] *= 100.0
    step = np.full(LANES, step[0]) if alike else step
    compiled, single, strict = z.copy(), z.copy(), z.copy()
    names = {"fma": fma_exact, "value": model, "numbers": exact_turn}
    head, _, body = source(model, kind).partition("    value = ")
    exec(head + body.partition("\n")[2], names)
    for taken in (1, 2):  # the second call finds the rotations of the first
        given = parameters(model), lanes, *tables, step, taken
        assert run_block(model_block(kind, model, 2), *given, compiled) == taken
        assert names[kind](*given, strict) == taken
        np.testing.assert_array_equal(compiled, strict)
        step[1] *= 1.0 if alike else 1.5
    if kind == "splitting":
        march = model_block("march", model, 2)
        for taken in (1, 2):
            assert run_single(march, parameters(model), *tables, step[0], taken, single) == taken
        np.testing.assert_array_equal(single[::LANES], strict[::LANES])


def test_turns_are_those_of_their_angle():
    """tan(r/2) and sin(r) to three units in the last place, whatever the angle."""
    rng = np.random.default_rng(1)
    angles = np.concatenate([rng.uniform(-2, 2, 300), rng.uniform(-60, 60, 300), [0.0, np.pi / 2, -np.pi, 1e-300]])
    for angle in angles:
        tangent, sine, odd = exact_turn(1.0, angle)
        with mpmath.workdps(40):
            x = mpmath.mpf(float(angle))
            rest = x - mpmath.pi * (2 * mpmath.nint((x / mpmath.pi - odd) / 2) + int(odd))
            half, whole = float(mpmath.tan(rest / 2)), float(mpmath.sin(rest))
        assert odd in (0.0, 1.0)
        assert abs(rest) <= np.pi / 2 * (1 + 1e-15)
        assert tangent == pytest.approx(half, rel=7e-16, abs=0)
        assert sine == pytest.approx(whole, rel=7e-16, abs=0)
    assert exact_turn(1.0, 0.0) == (0.0, 0.0, 0.0)


# --- tangent vectors ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", SPLITTINGS, ids=lambda s: s.name)
def test_tangent_maps_are_symplectic(scheme):
    model = three_bodies()
    z = triangular()[:, None] + 0.05 * np.random.default_rng(2).standard_normal((4, 3))
    form = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])
    for step in (0.05, 0.3):
        moved = fa.tangent_map(model, z, time=6.0, step=step, scheme=scheme, energy_tolerance=1e9)
        matrix = np.moveaxis(moved.matrix, -1, 0)
        assert np.abs(matrix.transpose(0, 2, 1) @ form @ matrix - form).max() <= 1e-13 * np.abs(matrix).max() ** 2


@pytest.mark.parametrize("scheme", [None, "dop853", "SOFRONIOU_SPALETTA10"])
def test_the_tangent_map_of_a_linear_system_is_an_exponential(scheme):
    """Three coordinates, a saddle too: the exponential of Hamilton's matrix."""
    omega, a, b, c = 0.9, -0.4, 1.7, 0.6
    model = fa.hamiltonian("(a*x**2 + b*y**2 + c*z**2)/2", coordinates="x y z", rotation="w", a=a, b=b, c=c, w=omega)
    turning = omega * np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 0]])
    whole = np.block([[turning, np.eye(3)], [-np.diag([a, b, c]), turning]])
    z = np.random.default_rng(0).standard_normal((6, 3))
    moved = fa.tangent_map(model, z, time=7.0, scheme=scheme)
    truth = expm(7.0 * whole)
    size = np.abs(truth).max()
    for o in range(3):
        np.testing.assert_allclose(moved.matrix[..., o], truth, atol=2e-9 * size)
    np.testing.assert_allclose(moved.z, truth @ z, atol=2e-9 * size)


# --- the restricted three-body problem ------------------------------------------------------------------------------


def test_the_five_points_are_at_rest():
    """Where JPL's catalogue has them; orbits stay there, or leave L1 to L3 as rounding grows by their exponents."""
    model, (x, y) = three_bodies(), triangular()[:2]
    places = np.array([*((x, 0.0) for x in POINTS), (x, y), (x, -y)]).T
    z = np.array([*places, -places[1], places[0]])
    assert np.abs(system_of(model).slopes(z)).max() <= 3e-15
    for scheme in (None, "dop853", fa.AUTO):
        stay = fa.integrate(model, z[:, 3:], time=300.0, scheme=scheme)
        assert (stay.status == fa.Status.OK).all()
        np.testing.assert_allclose(stay.z, z[:, 3:], atol=2e-10)
    leave = fa.integrate(model, z[:, :3], time=4.0)
    np.testing.assert_allclose(leave.z, z[:, :3], atol=1e-7)  # exp(2.93*4) times rounding at L1


def test_jacobi_constant_over_a_thousand_periods():
    """To 1e-12 on regular orbits of the frame: around each primary, around both, and from L4; chaos_map agrees."""
    model = three_bodies()
    z = triangular()[:, None] + np.zeros((4, 4))
    z[:, 0] += [0.004, 0.003, 0.0, 0.002]
    z[:, 1] = [0.3, 0, 0, 0.3 + 1.45]  # around the heavy one
    z[:, 2] = [1 - MOON + 0.1, 0, 0, 1 - MOON + 0.1 - 0.45]  # retrograde around the light one
    z[:, 3] = [3.0, 0, 0, 0.55]  # around both
    time = 1000 * 2 * np.pi
    ran = fa.integrate(model, z, time=time, scheme="BLANES_CASAS_ESCORIHUELA8", step=0.01)
    assert (ran.status == fa.Status.OK).all()
    drift = np.abs(system_of(model).energies(ran.z) / system_of(model).energies(z) - 1)
    assert drift.max() <= 1e-12, drift


def test_errors_cover_the_truth():
    """Of random orbits, against another scheme: at most one in a hundred beyond its estimate, none ten times."""
    model, rng = three_bodies(), np.random.default_rng(5)
    z, r, turned = np.empty((4, 500)), rng.uniform(0.25, 0.6, 500), rng.uniform(0, 2 * np.pi, 500)
    z[0], z[1] = r * np.cos(turned) - MOON, r * np.sin(turned)
    speed = rng.uniform(0.8, 1.1, 500) / np.sqrt(r)
    z[2], z[3] = -speed * np.sin(turned), speed * np.cos(turned)
    truth = fa.integrate(model, z, time=15.0, scheme="verner9", rtol=1e-14, atol=1e-14)
    rough = fa.integrate(model, z, time=15.0, scheme="dop853", rtol=1e-14, atol=1e-14)
    noise = np.abs(truth.z - rough.z)
    for accuracy in (1e-5, 1e-8):
        ran = fa.integrate(model, z, time=15.0, accuracy=accuracy)
        beyond = ((np.abs(ran.z - truth.z) - noise) / ran.error)[:, noise.max(axis=0) < 1e-9]
        assert beyond.shape[1] > 400
        assert np.mean(beyond > 1) <= 0.01, accuracy
        assert beyond.max() < 10


def test_sections_have_the_crossings_of_scipy():
    """y = 0, upwards, and px + y = 0, where x' changes its sign: linear in the rows, so a section of the frame."""
    model, z = three_bodies(), np.array([[0.45, 0.35], [0.0, 0.1], [0.1, 0.0], [1.9, 2.1]])
    sections = {"y=0": lambda t, w: w[1], fa.Hyperplane((0.0, 1.0, 1.0, 0.0), direction=-1): lambda t, w: -w[1] - w[2]}
    for section, function in sections.items():
        function.direction = 1
        found = fa.poincare_map(model, z, section=section, crossings=4, max_time=60.0)
        assert (found.counts == 4).all()
        for o in range(2):
            truth = solve_ivp(
                lambda t, w: system_of(model).slopes(w[:, None])[:, 0],
                (0, 60),
                z[:, o],
                method="DOP853",
                rtol=1e-12,
                atol=1e-13,
                events=function,
            )
            times = truth.t_events[0][truth.t_events[0] > 1e-9][:4]
            np.testing.assert_allclose(found.times[:, o], times, atol=1e-8)


# --- a pendulum on a turning Earth ----------------------------------------------------------------------------------


# --- what is refused ------------------------------------------------------------------------------------------------


class Fast(NamedTuple):
    """A relativistic particle in a well that turns: T is not quadratic."""

    omega: float = 0.3
    kind = Kind.ROTATING
    degrees_of_freedom = 2
    angular_velocity = Bar.angular_velocity

    def velocity(self, px, py):
        w = 1 / np.sqrt(1 + px * px + py * py)
        return px * w, py * w

    def kinetic_energy(self, px, py):
        return np.sqrt(1 + px * px + py * py) - 1

    def force(self, x, y):
        return -x, -y

    def potential_energy(self, x, y):
        return (x * x + y * y) / 2

    margin = Bar.margin


def test_what_cannot_turn_is_refused_with_what_can():
    z = np.array([0.1, 0.2, 0.1, 0.1])
    model = fa.hamiltonian("(x**2 + y**2)/2", rotation=0.2)
    with pytest.raises(ValueError, match=r"TimeTransformed.*turns\. Use KAHAN_LI8"):
        fa.integrate(model, z, time=1.0, scheme=fa.TimeTransformed())
    with pytest.raises(TypeError, match=r"must be a system H = T.*rotating frame"):
        fa.quantum.weyl_count(model, [1.0], m=0, l=0)
    with pytest.raises(ValueError, match=r"T = \(p_x\^2 \+ p_y\^2\)/2m \+ ... with one mass m of its first two"):
        fa.integrate(Fast(), z, time=1.0)
    with pytest.raises(ValueError, match="masses must be equal for x and y"):
        fa.hamiltonian("x*y", rotation=1.0, masses=(1, 2))
    changed = fa.hamiltonian("(x**2 + y**2)/2", rotation=1.0, masses=(1, 1))._replace(m_1=2.0)
    with pytest.raises(ValueError, match="with one mass m of its first two coordinates"):
        fa.integrate(changed, z, time=1.0)
    with pytest.raises(ValueError, match="rotation must rotate two coordinates, the first ones, got x"):
        fa.hamiltonian("x**2", coordinates="x", rotation=1.0)
    with pytest.raises(ValueError, match=r"rotation: .*Omga"):
        fa.hamiltonian("x**2 + y**2", rotation="Omga", Omega=1.0)
    with pytest.raises(ValueError, match="parameter 'Omega' must be a name in the formula"):
        fa.hamiltonian("x**2 + y**2", Omega=1.0)
    with pytest.raises(TypeError, match="magnetic"):
        fa.hamiltonian("x**2 + y**2", magnetic=[1.0])
    with pytest.raises(ValueError, match="rotation"):
        fa.hamiltonian("x**2 + y**2", rotation=float("nan"))
    lonely = type("Lonely", (OneSpring,), {"kind": Kind.ROTATING, "angular_velocity": Bar.angular_velocity, "omega": 1})
    with pytest.raises(ValueError, match="two coordinates or more"):
        fa.integrate(lonely(), [1.0, 0.0], time=1.0)


def test_a_model_says_what_it_is():
    model = fa.hamiltonian("a*x**2 + y**2", rotation="2*w", magnetic=0.5, a=1.0, w=0.3)
    assert model.kind is Kind.ROTATING
    assert model.angular_velocity() == pytest.approx(0.6 + 0.25)
    assert "rotation='2*w'" in repr(model)
    assert model._replace(w=0.4, magnetic=0.0).angular_velocity() == pytest.approx(0.8)
    with pytest.raises(TypeError, match="angular_velocity"):
        fa.integrate(type("Bare", (Bar,), {"angular_velocity": None})(), np.zeros(4) + 0.1, time=1.0)


# --- periodic orbits ------------------------------------------------------------------------------------------------


def hill():
    """Hill's problem: V = -1/r - x^2 + y^2/2 beside the turning at rate 1; Gamma = -2H."""
    return fa.hamiltonian("-1/sqrt(x**2 + y**2) - x**2 + y**2/2", rotation=1.0)


@pytest.mark.slow
def test_hills_variational_orbit_has_the_motion_of_the_perigee():
    """The periodic orbit of the Moon's synodic month, m = n'/(n - n'), and its stability: Hill 1877, On the part of the
    motion of the lunar perigee (Acta Math. 8, 1886, 1), found c = 1.07158 32774 16012 by his infinite determinant.
    """
    m, c = 0.0808489338083120, 1.0715832774160
    model, a = hill(), (1 + 1 / m) ** (-2 / 3)
    start = np.array([a, 0.0, 0.0, a + a / m])  # a circle
    found = []

    def late(energy):
        found.append(fa.periodic_orbits(model, found[-1].z if found else start, section=UP, energy=energy))
        return found[-1].period[0] - 2 * np.pi * m

    brentq(late, -3.27, -3.24, xtol=1e-14, rtol=1e-14)
    orbit = found[-1]
    assert orbit.status[0] == fa.Status.OK
    assert orbit.period[0] == pytest.approx(2 * np.pi * m, abs=1e-12)
    assert -2 * orbit.energy[0] == pytest.approx(6.50888, abs=5e-6)
    assert 1 + np.arccos(1 - 2 * orbit.residue[0]) / (2 * np.pi) == pytest.approx(c, abs=1e-12)


UP = fa.Hyperplane((0.0, 1.0, 0.0, 0.0), direction=1)


def test_hills_satellites_lose_their_stability_where_henon_found_it():
    """Family g at Gamma = 4.49999, where g' branches off (Henon 1969, Astron. Astrophys. 1, 223)."""
    start = np.array([0.175, 0.0, 0.0, 2.4056])
    branch = fa.continuation(hill(), start, section=UP, bounds=(-4, -2.2), max_steps=60, ds=0.1, ds_max=1.0)
    (change,) = branch.bifurcations
    assert -2 * change.parameter == pytest.approx(4.49999, abs=5e-6)
    assert branch.orbits.residue[0] > 0 > branch.orbits.residue[-1]


def test_a_halo_orbit_of_the_catalogue_closes():
    """L2 of Earth and Moon, three coordinates: state and period of JPL's catalogue (as for POINTS)."""
    x, z, vy, period = 1.0809931218390707, -2.0235953267405354e-01, -1.9895001215078018e-01, 2.3538670417546639
    V = "-(1 - m)/sqrt((x + m)**2 + y**2 + z**2) - m/sqrt((x - 1 + m)**2 + y**2 + z**2)"
    model = fa.hamiltonian(V, coordinates="x y z", rotation=1.0, m=MOON)
    start = np.array([x, 0.0, z, 0.0, vy + x, 0.0])
    moved = fa.tangent_map(model, start, time=period, step=0.002)
    np.testing.assert_allclose(moved.z[:, 0], start, atol=1e-9)
    assert np.linalg.det(moved.matrix[..., 0]) == pytest.approx(1.0, abs=1e-7)
    found = fa.periodic_orbits(
        model,
        start,
        section=fa.Hyperplane((0.0, 1.0, 0.0, 0.0, 0.0, 0.0), direction=-1),
        step=0.002,
    )
    assert found.status[0] == fa.Status.OK
    assert found.period[0] == pytest.approx(period, abs=1e-9)
    np.testing.assert_allclose(found.z[:, 0], start, atol=1e-9)


LYAPUNOV = {  # x, y', Jacobi's constant, period, stability index
    "L1, small": (0.830023864314168, 0.06088309999599009, 3.18515736797775, 2.702881200253821, 1300.72578337944),
    "L1": (0.8007325761918545, 0.35248700747556716, 3.07728036254377, 3.297097386764505, 425.868250560381),
    "L1, large": (0.7076756180347542, 0.621513254358129, 2.94595078958827, 5.709795908302705, 64.0473059678341),
    "L2, small": (1.1599891825364728, -0.023755466801822275, 3.1717305860487, 3.3740716677049702, 724.023759109433),
    "L2": (1.039766165259229, 0.6277452743730177, 3.03331847496241, 4.056819398703425, 164.905262178291),
}
"""Planar Lyapunov orbits of JPL's catalogue (as for POINTS; families `lyapunov` with libr=1 and 2): they cross y = 0 at
right angles; the index is (lambda + 1/lambda)/2.
"""


@pytest.mark.parametrize("name", LYAPUNOV)
def test_lyapunov_orbits_are_those_of_the_catalogue(name):
    """Found from starts beside them, at the same Jacobi constant: state, period and stability index."""
    x, vy, jacobi, period, index = LYAPUNOV[name]
    model, start = three_bodies(), np.array([x, 0.0, 0.0, vy + x])
    assert -2 * system_of(model).energies(start) == pytest.approx(jacobi, abs=2e-14)
    section = fa.Hyperplane((0.0, 1.0, 0.0, 0.0), direction=1 if vy > 0 else -1)
    beside = start + 1e-6 * np.array([1.0, 0.0, -1.0, 0.0])
    found = fa.periodic_orbits(model, beside, section=section, energy=-jacobi / 2)
    assert found.status[0] == fa.Status.OK
    assert found.period[0] == pytest.approx(period, abs=5e-10)
    np.testing.assert_allclose(found.z[:, 0], start, atol=1e-11)
    assert found.indices[0, 0] == pytest.approx(2 * index, rel=2e-7)


@pytest.mark.slow
def test_lyapunov_orbits_at_the_energy_of_oterma_are_where_they_were_proved():
    """Sun and Jupiter: intervals of CAPD's proof (its IPoincareMapExample) for the point and half the period at L1; the
    point at L2 by Wilczak & Zgliczynski 2003, Commun. Math. Phys. 234, 37 (arXiv:math/0201278). Their C has m(1 - m).
    """
    m = 0.0009537
    energy = -(3.03 - m * (1 - m)) / 2
    for x, sign, half in ((0.9208034913207435, 1, 1.541059563195996), (1.081929486841799903, -1, None)):
        speed = np.sqrt(2 * energy + x**2 + 2 * ((1 - m) / (x + m) + m / abs(x - 1 + m)))
        beside = np.array([x + 1e-6, 0.0, -1e-6, x + sign * speed])
        section = fa.Hyperplane((0.0, 1.0, 0.0, 0.0), direction=sign)
        found = fa.periodic_orbits(three_bodies(m), beside, section=section, energy=energy)
        assert found.status[0] == fa.Status.OK
        np.testing.assert_allclose(found.z[[0, 2], 0], [x, 0.0], atol=1e-12)
        if half:
            assert abs(found.period[0] / 2 - half) <= found.error[0] + 3e-12


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_penning_trap_has_its_three_frequencies(seed):
    """omega_c/2 +- (omega_c^2/4 - omega_z^2/2)^(1/2) and omega_z (Brown & Gabrielse 1986, Rev. Mod. Phys. 58, 233)."""
    rng = np.random.default_rng(seed)
    mass, field, axial = rng.uniform(0.5, 2), rng.uniform(-4, 4), rng.uniform(0.1, 0.25)
    axial *= abs(field) / mass
    V = "k/2*(z**2 - (x**2 + y**2)/2)"
    model = fa.hamiltonian(V, coordinates="x y z", masses=[mass] * 3, magnetic=field, k=mass * axial**2)
    cyclotron = abs(field) / mass
    root = np.sqrt(cyclotron**2 / 4 - axial**2 / 2)
    truth = np.sort([cyclotron / 2 + root, cyclotron / 2 - root, axial])
    found = fa.frequency_map(model, rng.standard_normal((6, 6)), time=40 * 2 * np.pi / truth[0])
    assert (found.classification == fa.Classification.REGULAR).all()
    order = np.argsort(found.omega, axis=0)
    omega, error = (np.take_along_axis(rows, order, axis=0) for rows in (found.omega, 2 * np.pi * found.error))
    assert (np.abs(omega - truth[:, None]) <= error + 1e-15).all()
    assert (np.abs(omega - truth[:, None]) <= 1e-12 * cyclotron).all()


# --- frequencies ----------------------------------------------------------------------------------------------------


def test_frequencies_of_turning_springs_are_eigenvalues():
    """Unequal springs and any rate of turning, also faster than they swing: those of Hamilton's matrix, positive."""
    rng, tried = np.random.default_rng(8), 0
    for _ in range(12):
        a, b, w = *rng.uniform(0.3, 2, 2), rng.uniform(-2.5, 2.5)
        turning = np.array([[0.0, w], [-w, 0.0]])
        values = np.linalg.eigvals(np.block([[turning, np.eye(2)], [-np.diag([a, b]), turning]]))
        truth = np.sort(np.abs(values.imag))[::2] / (2 * np.pi)
        if np.abs(values.real).max() > 1e-9 or truth.min() < 0.01:
            continue
        model = shared_systems.turning_springs(a, b, w)
        found = fa.frequency_map(model, rng.standard_normal((4, 3)), time=300 / truth.min())
        assert (np.abs(np.sort(found.nu, axis=0) - truth[:, None]) <= np.sort(found.error, axis=0) + 1e-15).all()
        tried += 1
    assert tried >= 6


# --- launch sets ----------------------------------------------------------------------------------------------------


def deep_bar(omega, mass=1.0):
    """A well that confines whatever turns so slowly: k r^2/2 + x^4 + y^2/3."""
    return fa.hamiltonian("k*(x**2 + y**2)/2 + x**4 + y**2/3", rotation=omega, masses=(mass, mass), k=1.0)


@pytest.mark.parametrize("text", ["x=0", "y=0.3", "x=-0.4"])
@pytest.mark.parametrize("direction", [1, -1])
def test_grids_on_sections_have_their_energy_and_go_their_way(text, direction):
    """Cells are reached where some momentum has the energy: (p_j - p_rest)^2/2m <= E - V + m Omega^2 r^2/2."""
    mass, omega, energy = 1.7, -0.5, 0.8
    model, (name, value) = deep_bar(omega, mass), text.split("=")
    i = "xy".index(name)
    section = fa.Hyperplane(tuple(float(r == i) for r in range(4)), float(value), direction)
    u, v = np.linspace(-1.2, 1.2, 41), np.linspace(-2, 2, 43)
    grid = fa.energy_grid(model, energy=energy, section=section, axes=(u, v))
    np.testing.assert_allclose(system_of(model).energies(grid.z0), energy, rtol=1e-12)
    np.testing.assert_allclose(grid.z0[i], float(value))
    assert (direction * system_of(model).velocities(grid.z0)[i] >= 0).all()
    other, momentum = np.meshgrid(u, v, indexing="ij")
    q = [np.full_like(other, float(value)), other] if i == 0 else [other, np.full_like(other, float(value))]
    room = energy - model.potential_energy(*q) + mass * omega**2 * (q[0] ** 2 + q[1] ** 2) / 2
    rest = mass * omega * float(value) * (1 if i == 0 else -1)
    np.testing.assert_array_equal(grid.inaccessible, (momentum - rest) ** 2 / (2 * mass) > room)

    edge = fa.plot.edge(model, section, energy=energy)
    assert edge.centre == pytest.approx(rest, abs=1e-15)
    inside = np.abs(v[None, :] - edge.centre) < np.interp(u, edge.coordinate, edge.momentum, 0, 0)[:, None]
    assert np.mean(inside == ~grid.inaccessible) > 0.985  # but for cells next to the boundary
    sample = fa.energy_sample(model, energy=energy, section=section, orbits=4000, seed=3)
    np.testing.assert_allclose(system_of(model).energies(sample.z0), energy, rtol=1e-12)
    (left, right), (low, high) = edge.axes
    area = np.trapezoid(2 * edge.momentum, edge.coordinate)
    half = np.mean(sample.points[1] > edge.centre), np.mean(np.abs(sample.points[0]) < 0.3)
    middle = np.linspace(-0.3, 0.3, 301)
    share = np.trapezoid(2 * np.interp(middle, edge.coordinate, edge.momentum), middle) / area
    assert abs(half[0] - 0.5) < 0.04
    assert abs(half[1] - share) < 0.04
    assert left <= sample.points[0].min()
    assert sample.points[0].max() <= right
    assert low <= sample.points[1].min()
    assert sample.points[1].max() <= high


def test_launch_sets_without_a_section_turn_too():
    """By name, at rest in the frame, and random points of the whole energy surface."""
    model = deep_bar(0.6)
    grid = fa.energy_grid(model, energy=0.7, axes={"x": np.linspace(-0.5, 0.5, 7)}, solve="p_y", fixed={"y": 0.2})
    np.testing.assert_allclose(system_of(model).energies(grid.z0), 0.7, rtol=1e-12)
    assert (system_of(model).velocities(grid.z0)[1] > 0).all()
    resting = fa.energy_grid(model, energy=0.7, axes={"phi": np.linspace(0, 6, 13)}, at_rest=True)
    np.testing.assert_allclose(system_of(model).velocities(resting.z0), 0.0, atol=1e-14)
    np.testing.assert_allclose(system_of(model).energies(resting.z0), 0.7, rtol=1e-9)
    sample = fa.energy_sample(model, energy=0.7, orbits=3000, seed=1)
    np.testing.assert_allclose(system_of(model).energies(sample.z0), 0.7, rtol=1e-12)
    # uniform in d^2q d^2p delta(E - H): velocities have every direction, wherever
    v = system_of(model).velocities(sample.z0)
    assert abs(np.mean(np.exp(1j * np.arctan2(v[1], v[0])))) < 0.06


def test_energies_above_a_saddle_of_the_frame_may_escape():
    """Of Hill's problem: -3^(4/3)/2 at both collinear points."""
    with pytest.raises(ValueError, match=r"energy -2 exceeds the escape energy -2\.16337"):
        fa.energy_sample(hill(), energy=-2.0, section="y=0", orbits=10)


def test_jobs_and_commands_turn(tmp_path):
    """A rate as a number or a formula; what builds a model is found again from it."""
    for turning in ({"rotation": "0.3"}, {"rotation": "2*k", "magnetic": "0.5"}):
        table = Model(hamiltonian="k*(x**2 + y**2)/2 + x**4", parameter=["k=0.7"], **turning)
        model = table.build()
        assert model.angular_velocity() == pytest.approx(0.3 if len(turning) == 1 else 1.65)
        again = described(system_of(model))
        assert again is not None
        assert again.build() == model
    with pytest.raises(ValueError, match="rotation belongs to hamiltonian"):
        Model(formula="D1**2 + D2**2", rotation="0.3").build()
    with pytest.raises(ValueError, match="rotation"):
        Model(rotation="0.3").build()
    with pytest.raises(ValueError, match="an option of its own"):
        Model(hamiltonian="x**2 + y**2", parameter=["rotation=1"]).build()
    job = Job(
        model=Model(hamiltonian="(a*x**2 + b*y**2)/2", parameter=["a=1", "b=1.7", "w=0.4"], rotation="w"),
        energy_surface=EnergySurface(energy=0.5, section="x=0"),
        initial_conditions=InitialConditions(orbits=3),
        poincare=PoincareOptions(crossings=4, max_time=200.0),
    )
    results = fa.run(job, tmp_path / "turning.zarr", threads=1)
    found = results["poincare"]
    assert (found.status == fa.Status.OK).all()
    model = job.plan().model
    np.testing.assert_allclose(system_of(model).energies(found.points[:, 0]), 0.5, atol=1e-9)
    assert (system_of(model).velocities(found.points[:, 0])[0] > 0).all()


def test_the_rounding_of_many_turns_is_part_of_the_error():
    # An isotropic well in a frame that turns fast: at rest its orbits are ellipses, in closed form.
    rng = np.random.default_rng(12)
    for rate, well, time in ((1000.0, 1.7, 30.0), (-200.0, 0.9, 40.0)):
        model = fa.hamiltonian("w**2*(x**2 + y**2)/2", rotation=rate, w=well)
        z = rng.normal(size=(4, 24))
        c, s = np.cos(well * time), np.sin(well * time)
        q, p = c * z[:2] + s / well * z[2:], -well * s * z[:2] + c * z[2:]
        angle = float(mpmath.fmod(mpmath.mpf(rate) * time, 2 * mpmath.pi))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        found = fa.integrate(model, z, time=time)
        ratio = np.abs(found.z - np.concatenate([turn @ q, turn @ p])) / found.error
        assert (ratio <= 1).mean() > 0.97
        assert ratio.max() < 10
