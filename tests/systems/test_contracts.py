"""Contracts (`fastaff.models.contracts`): what the package has keeps them, what keeps them works, what lacks
something is told.
"""

import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest
import shared_systems
from own_models import OneSpring

import fastaff as fa
import fastaff.jobs.system  # reads the options of all terms before a test adds its own
from fastaff.engine import kinds
from fastaff.engine.terms import Substep, Term
from fastaff.runs.requirements import check_derivatives, lacking
from fastaff.systems.formulas.library import Request, generated_class
from fastaff.systems.models.contracts import Angles, Kind, Nonseparable, OneVariable, Potential, Section, SeparableModel
from fastaff.systems.models.mechanics import system_of

POTENTIALS = [fa.Harmonic(), fa.Anharmonic(), fa.Hyperelastic(), fa.HeavyTop(), fa.NeoHookean()]
POTENTIALS += [fa.SeparableAlphaBeta(fa.models.Oscillator(1.0), fa.models.Zero())]
BODIES = [fa.Body(potential) for potential in POTENTIALS]
SYSTEMS = [
    fa.HenonHeiles(),
    fa.reduced_body(BODIES[0], p_eta=0.3, p_gamma=0.2),
    fa.hamiltonian("x**2*y**2", coordinates="x y"),
]
SECTIONS = [fa.AlphaTurning(), fa.BetaTurning(), fa.AlphaEquals(1.0), fa.BetaEquals(1.0), fa.AreaEquals()]
SECTIONS += [fa.Hyperplane((1.0, 0.0, 0.0, 0.0))]
NEEDS = [
    (SeparableModel, BODIES + SYSTEMS),
    (Potential, POTENTIALS),
    (Section, SECTIONS),
    (OneVariable, [fa.models.Zero()]),
]
NEEDS += [(Nonseparable, [fa.hamiltonian("p**2*(1 + x**2)/2", coordinates="x", momenta="p")])]
NEEDS += [(Angles, [body.angles for body in BODIES] + [fa.HenonHeiles().angles])]
Z = np.array([[0.1, 0.05], [0.02, -0.1], [0.1, 0.2], [0.0, 0.1]])


class Relativistic(NamedTuple):
    """H = sqrt(m^2 + p^2) - m + |q|^2/2, two degrees of freedom, no names: a T that is not quadratic."""

    m: float = 1.0

    @property
    def degrees_of_freedom(self):
        return 2

    def velocity(self, px, py):
        w = 1 / np.sqrt(self.m**2 + px * px + py * py)
        return px * w, py * w

    def force(self, x, y):
        return -x, -y

    def kinetic_energy(self, px, py):
        return np.sqrt(self.m**2 + px * px + py * py) - self.m

    def potential_energy(self, x, y):
        return (x * x + y * y) / 2

    def margin(self, x, y):
        return 1.0 + 0.0 * x


class OwnBody(NamedTuple):
    """A body of somebody else, not the package's class."""

    potential: Any
    mu: float = 1.0
    degrees_of_freedom = 4
    coordinates = ("a1", "a2", "b1", "b2")
    isotropic = True

    velocity = fa.Body.velocity
    force = fa.Body.force
    kinetic_energy = fa.Body.kinetic_energy
    potential_energy = fa.Body.potential_energy
    margin = fa.Body.margin


class Whirled(NamedTuple):
    """A kind that the package has not: H = (px^2 + py^2)/2 + V(x, y, t) in a frame that turns at the rate omega."""

    wave: float = 0.3
    omega: float = 0.4
    kind = Kind("H = T(p) + V(q, t) in a turning frame", {"drive", "frame"})
    coordinates, degrees_of_freedom, period = ("x", "y", "t"), 3, 2 * np.pi

    def phase(self, t):
        return t - 2 * np.pi * np.floor(t / (2 * np.pi))

    def angular_velocity(self):
        return self.omega

    def velocity(self, px, py, pt):
        return px, py, 1.0 + 0.0 * pt

    def kinetic_energy(self, px, py, pt):
        return (px * px + py * py) / 2

    def potential_energy(self, x, y, t):
        return (1.3 * x * x + 2 * y * y) / 2 + x * x * y * y + x**4 / 4 - self.wave * x * np.cos(t)

    def force(self, x, y, t):
        fx, fy = -1.3 * x - 2 * x * y * y - x * x * x + self.wave * np.cos(t), -2 * y - 2 * x * x * y
        return fx, fy, -self.wave * x * np.sin(t)

    def tangent_force(self, x, y, t, dx, dy, dt):
        fx = -(1.3 + 2 * y * y + 3 * x * x) * dx - 4 * x * y * dy - self.wave * np.sin(t) * dt
        fy = -2 * dy - 4 * x * y * dx - 2 * x * x * dy
        return fx, fy, -self.wave * (dx * np.sin(t) + x * np.cos(t) * dt)

    def margin(self, x, y, t):
        return 1.0 + 0.0 * (x + y + t)


class Damped(NamedTuple):
    """Another: the same potential at rest, with friction."""

    wave: float = 0.3
    friction: float = 0.05
    kind = Kind("H = T(p) + V(q, t) with friction", {"drive", "friction"})
    coordinates, degrees_of_freedom, period = Whirled.coordinates, 3, Whirled.period
    phase, velocity, force, tangent_force = Whirled.phase, Whirled.velocity, Whirled.force, Whirled.tangent_force
    kinetic_energy, potential_energy, margin = Whirled.kinetic_energy, Whirled.potential_energy, Whirled.margin

    def damping_rate(self):
        return self.friction


def test_what_the_package_has_keeps_its_contracts():
    for contract, values in NEEDS:
        for value in values:
            assert isinstance(value, contract), (contract, value)
            assert not lacking(value, contract)


@pytest.mark.parametrize("method", ["velocity", "force", "kinetic_energy", "potential_energy", "margin"])
def test_a_model_that_lacks_a_method_is_told_which(method):
    own = type("Own", (Relativistic,), {})
    body = {name: entry for name, entry in vars(Relativistic).items() if name != method and not name.startswith("__")}
    own = type("Own", (tuple,), {**body, "_fields": ("m",), "__getnewargs__": lambda self: tuple(self)})
    with pytest.raises(TypeError, match=f"Own has no {method}$"):
        fa.integrate(own((1.0,)), Z[:, 0], time=1.0)


def test_what_names_no_kind_is_refused_in_a_sentence():
    class Other(NamedTuple):
        m: float = 1.0

    for name, entry in vars(Relativistic).items():
        if not name.startswith("_") and name != "m":
            setattr(Other, name, entry)
    Other.kind = "relativistic"
    calls = (
        lambda: fa.integrate(Other(), Z, time=1.0),
        lambda: fa.frequency_map(Other(), Z, time=1.0),
        lambda: fa.poincare_map(Other(), Z, section=SECTIONS[-1], crossings=1, max_time=1.0),
        lambda: fa.chaos_map(Other(), Z, time=1.0),
        lambda: fa.fit_torus(Other(), Z[:, 0], time=1.0),
    )
    for call in calls:
        with pytest.raises(TypeError, match=r"model.kind must be a .* got 'relativistic'"):
            call()


LORENZ = fa.ode("x' = 10*(y - x); y' = x*(28 - z) - y; z' = x*y - 8/3*z")
PLANE = "x**2/2 + y**2 + x**2*y**2"
TRAITS = {  # of each kind: what is true of it, and n, moving, rows, positions
    "separable": (fa.hamiltonian(PLANE), "canonical energetic conserves symplectic quadratic", (2, 2, 4, 2)),
    "body": (BODIES[0], "canonical energetic conserves symplectic quadratic planar isotropic", (4, 4, 8, 4)),
    "relativistic": (Relativistic(), "canonical energetic conserves symplectic", (2, 2, 4, 2)),
    "rotating": (
        fa.hamiltonian(PLANE, rotation=0.3),
        "frame canonical energetic conserves symplectic quadratic",
        (2, 2, 4, 2),
    ),
    "driven": (
        fa.hamiltonian("x**2/2 + x*cos(t)", coordinates="x", drive_period="2*pi"),
        "driven canonical energetic conserves symplectic quadratic",
        (2, 1, 4, 2),
    ),
    "damped": (fa.hamiltonian(PLANE, friction=0.1), "dissipative canonical energetic quadratic", (2, 2, 4, 2)),
    "nonseparable": (
        fa.hamiltonian("p**2*(1 + x**2)/2", coordinates="x", momenta="p"),
        "nonseparable canonical energetic conserves symplectic",
        (1, 1, 2, 2),
    ),
    "driven nonseparable": (
        fa.hamiltonian("p**2*(1 + x**2)/2 + x*cos(t)", coordinates="x", momenta="p", drive_period="2*pi"),
        "driven nonseparable canonical energetic conserves symplectic",
        (2, 1, 4, 4),
    ),
    "flow": (LORENZ, "", (2, 2, 3, 3)),
    "map": (fa.models.StandardMap(), "iterated canonical symplectic", (1, 1, 2, 1)),
    "dissipative map": (
        shared_systems.henon(),
        "iterated canonical",
        (1, 1, 2, 1),
    ),
    "driven frame": (Whirled(), "driven frame canonical energetic conserves symplectic quadratic", (3, 2, 6, 3)),
    "driven with friction": (Damped(), "driven dissipative canonical energetic quadratic", (3, 2, 6, 3)),
}
FACTS = (
    *(
        "driven",
        "frame",
        "dissipative",
        "nonseparable",
        "iterated",
        "canonical",
        "energetic",
        "conserves",
        "symplectic",
    ),
    "quadratic",
)


@pytest.mark.parametrize(("model", "true", "counts"), TRAITS.values(), ids=TRAITS)
def test_traits_are_those_written_here(model, true, counts):
    """What has no energy is not asked whether T is quadratic."""
    system = system_of(model)
    asked = [fact for fact in (*FACTS, "planar", "isotropic") if fact != "quadratic" or system.energetic]
    assert {fact for fact in asked if getattr(system, fact)} == set(true.split())
    assert (system.n, system.moving, system.rows, system.positions) == counts
    assert len(system.row_names) == system.rows
    assert system_of(model) is system


def test_traits_tell_equal_tuples_apart():
    """Models of one number each, equal as tuples."""
    assert Relativistic(0.5) == fa.models.StandardMap(0.5)
    assert system_of(fa.models.StandardMap(0.5)).iterated
    assert not system_of(Relativistic(0.5)).iterated


@pytest.mark.parametrize(
    "terms",
    [{"frame", "friction"}, {"drive", "frame", "friction"}, {"drive", "rates"}, {"iterates", "friction"}, {"magic"}],
)
def test_terms_that_loops_cannot_have_together_are_refused(terms):
    with pytest.raises(ValueError, match=r"^terms must be one of drive, frame, .*, got "):
        Kind("x' = ?", terms)


@pytest.mark.parametrize("model", [Whirled(), Damped()], ids=["driven frame", "driven with friction"])
def test_a_kind_of_ones_own_runs_by_its_terms(model):
    """Integration and section against SciPy's states, exponents against their sum, classifications, and refusals."""
    from scipy.integrate import solve_ivp

    turning, losing = getattr(model, "omega", 0.0), getattr(model, "friction", 0.0)

    def rates(t, z):
        x, y, px, py = z
        fx, fy, _ = model.force(x, y, t)
        return px + turning * y, py - turning * x, fx + turning * py - losing * px, fy - turning * px - losing * py

    def truth(time):
        return np.array([solve_ivp(rates, (0, time), z, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1] for z in Z.T])

    kept = [0, 1, 3, 4]
    for options in ({"accuracy": 1e-9}, {"scheme": fa.DOP853}, {"scheme": fa.KAHAN_LI8, "step": 0.05}):
        found = fa.integrate(model, Z, time=40.0, **options)
        assert (found.status == fa.Status.OK).all()
        np.testing.assert_allclose(found.z[kept].T, truth(40.0), rtol=0, atol=1e-8)
    cut = fa.poincare_map(model, Z, section="t=0", crossings=6)
    np.testing.assert_allclose(cut.points[kept, 5].T, truth(12 * np.pi), rtol=0, atol=1e-8)
    spectrum = fa.chaos_map(model, Z, time=300.0, indicators="spectrum").spectrum
    np.testing.assert_allclose(spectrum.sum(axis=0), -2 * losing, atol=1e-9)
    calm, wild = (fa.chaos_map(model._replace(wave=w), Z, time=2000.0, indicators="sali") for w in (0.01, 4.0))
    assert not calm.chaotic.any()
    assert wild.chaotic.all() == (not losing)
    with pytest.raises((TypeError, ValueError), match=r"is not supported for driven systems|, and Damped has friction"):
        fa.integrate(model, Z, time=1.0, scheme=fa.TimeTransformed())
    asked = "signals must be given for a driven system" if not losing else "must be a Hamiltonian system"
    with pytest.raises((TypeError, ValueError), match=asked):
        fa.frequency_map(model, Z, time=100.0)
    with pytest.raises(TypeError, match="must be a system without a drive"):
        fa.energy_grid(model, energy=0.1, axes={"x": [0.1]}, solve="p_y")


def test_a_driven_frame_has_periodic_orbits_and_friction_none():
    found = fa.periodic_orbits(Whirled(wave=0.1, omega=0.2), [0.3, 0.0, 0.0, 0.2], section="t=0")
    again = fa.integrate(Whirled(wave=0.1, omega=0.2), found.z, time=2 * np.pi, accuracy=1e-12).z
    np.testing.assert_allclose(again[[0, 1, 3, 4]], found.z[[0, 1, 3, 4]], rtol=0, atol=1e-11)
    with pytest.raises(TypeError, match=r"model Damped has a drive and has friction\. Write both as equations"):
        fa.periodic_orbits(Damped(), Z[:, 0], section="t=0")


def gyrated(rate, length):
    """Return the integrals of cos(rate t) and sin(rate t) over a length."""
    half = np.sin(0.5 * rate * length)
    return np.sin(rate * length) / rate, 2.0 * half * half / rate


def pulled(r, part, p):
    """Return the text of a row of momenta after a kick that turns them."""
    across = {part[0]: f"fma(across, f{part[1]}, {p})", part[1]: f"fma(-across, f{part[0]}, {p})"}.get(r)
    return f"fma(hk, f{r}, {p})" if across is None else f"fma(along, f{r}, {across})"


NEW = {
    "gyration": Term(
        does="kinetic momenta turn in a uniform magnetic field: gyration_rate()",
        equations="m q'' = -dV/dq + B q' x e_z",
        rate="gyration_rate",
        has="gyrates",
        forces=lambda part: "f{0}, f{1} = f{0} + rate*p{1}, f{1} - rate*p{0}\n".format(*part),
        substep=Substep("kick", gyrated, ("along", "across"), pulled),
        words=frozenset({"noncanonical"}),
        options=("gyration",),
    ),
    "wind": Term(
        does="the medium moves along the first coordinate: wind_speed()",
        equations="H = T(p) + V(q) + u p_x",
        rate="wind_speed",
        has="has wind",
        velocities=lambda part: f"v{part[0]} = v{part[0]} + rate\n" if part[0] == 0 else "",
        energy="rate*p0",
        substep=Substep(
            "drift",
            lambda rate, length: (rate * length,),
            ("moved",),
            lambda part, q, p, base: f"{q}0 = {q}0 + moved\n" if part[0] == 0 else "",
        ),
        options=("wind",),
    ),
}
"""Terms that the package has not, each with a system of the package that it is in other variables."""


@pytest.fixture
def new_terms(monkeypatch):
    for name, entry in NEW.items():
        monkeypatch.setitem(kinds.TERMS, name, entry)
        monkeypatch.setitem(kinds.OPTIONS, name, name)


def with_term(name, rate):
    """Return a system with a new term by its option, the twin, and z of the twin from its own."""
    V, request = PLANE, Request(PLANE, None, (name,), ("x", "y"), "unit", others=((name, name),))
    programs = request.program(2000), request.domain_program()
    model = generated_class(request, programs, {name: rate})(rate)
    if name == "gyration":
        shift = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, -rate / 2, 1, 0], [rate / 2, 0, 0, 1]])
        return model, fa.hamiltonian(V, magnetic=rate), lambda z: np.tensordot(shift, z, 1)
    still = fa.hamiltonian(V)
    return model, still, lambda z: z + np.reshape([0, 0, rate, 0], (4, *[1] * (z.ndim - 1)))


@pytest.mark.parametrize("name", NEW)
def test_a_new_term_is_one_value(name, new_terms):
    """Integration, section, exponents, classifications and frequencies beside those of the same system in other
    variables.
    """
    rate = float(np.random.default_rng(7).uniform(0.2, 0.5))
    model, twin, seen = with_term(name, rate)
    truth = fa.integrate(twin, seen(Z), time=40.0, accuracy=1e-12).z
    for options in ({"accuracy": 1e-10}, {}, {"scheme": fa.DOP853}, {"scheme": fa.LEAPFROG, "step": 1e-4}):
        found = fa.integrate(model, Z, time=40.0, **options)
        assert (found.status == fa.Status.OK).all()
        np.testing.assert_allclose(seen(found.z), truth, rtol=0, atol=1e-7 if "step" in options else 1e-9)
        alone = fa.integrate(model, Z[:, 0], time=40.0, **options)
        np.testing.assert_allclose(alone.z[:, 0], found.z[:, 0], rtol=0, atol=1e-9)
    coarse = [
        np.abs(seen(fa.integrate(model, Z, time=40.0, scheme=fa.KAHAN_LI8, step=h).z) - truth).max() for h in (0.4, 0.2)
    ]
    assert np.log2(coarse[0] / coarse[1]) == pytest.approx(8, abs=0.8)
    cut, other = (
        fa.poincare_map(m, z, section="x=0", crossings=8, max_time=300.0) for m, z in ((model, Z), (twin, seen(Z)))
    )
    np.testing.assert_allclose(seen(cut.points), other.points, rtol=0, atol=1e-9)
    maps = [fa.chaos_map(m, z, time=500.0, indicators=["spectrum", "sali"]) for m, z in ((model, Z), (twin, seen(Z)))]
    np.testing.assert_allclose(maps[0].spectrum, maps[1].spectrum, atol=2e-2)
    np.testing.assert_allclose(maps[0].spectrum.sum(axis=0), 0.0, atol=1e-9)
    assert not (maps[0].chaotic | maps[1].chaotic).any()
    wild = [fa.chaos_map(m, z, time=1000.0, indicators="sali") for m, z in ((model, 15 * Z), (twin, seen(15 * Z)))]
    assert (wild[0].chaotic & wild[1].chaotic).any()
    np.testing.assert_array_equal(wild[0].chaotic, wild[1].chaotic)
    own = [fa.frequency_map(m, z, time=500.0).nu for m, z in ((model, Z), (twin, seen(Z)))]
    np.testing.assert_allclose(np.abs(own[0]), np.abs(own[1]), atol=1e-6)
    tangent = fa.tangent_map(model, Z[:, :1], time=7.0)
    near = [fa.integrate(model, Z[:, :1] + d * np.eye(4), time=7.0, accuracy=1e-12).z for d in (1e-5, -1e-5)]
    np.testing.assert_allclose(np.squeeze(tangent.matrix), (near[0] - near[1]) / 2e-5, atol=1e-7)
    assert system_of(model).conserves
    assert repr(model).endswith(f"{name}={rate!r})")
    assert pickle.loads(pickle.dumps(model)) == model
    with pytest.raises(ValueError, match=rf"and the system {NEW[name].has}\. Use KAHAN_LI8"):
        fa.integrate(model, Z, time=1.0, scheme=fa.TimeTransformed())
    with pytest.raises(TypeError, match=r"must be a system|: it has no page; poincare_map"):
        fa.explore(model, energy=0.1)


def test_a_model_without_names_is_named_by_numbers():
    with pytest.raises(ValueError, match="rows q1, q2 and their momenta"):
        fa.integrate(Relativistic(), [1.0, 2.0], time=1.0)


@pytest.mark.parametrize("options", [{}, {"accuracy": 1e-5}])
def test_the_default_scheme_takes_any_kinetic_energy(options):
    assert fa.integrate(Relativistic(), Z, time=5.0, **options).scheme == fa.KAHAN_LI8


def test_schemes_for_quadratic_kinetic_energies_are_refused_for_others():
    """BLANES_MOAN6 has order 6 for T quadratic in p alone; among candidates it is passed over."""
    for scheme in (fa.BLANES_MOAN6, fa.schemes.RKN12):
        with pytest.raises(ValueError, match=f"{scheme.name} has its order {scheme.order} only if T is quadratic"):
            fa.integrate(Relativistic(), Z, time=10.0, scheme=scheme)
    only = fa.schemes.Automatic((fa.BLANES_MOAN6,))
    with pytest.raises(ValueError, match="takes T quadratic in the momenta"):
        fa.integrate(Relativistic(), Z, time=10.0, scheme=only)
    free = fa.schemes.Automatic((fa.BLANES_MOAN6, fa.KAHAN_LI8))
    found = fa.integrate(Relativistic(), Z, time=10.0, scheme=free)
    assert found.scheme == fa.KAHAN_LI8
    plain = fa.integrate(Relativistic(), Z, time=10.0, step=0.02, scheme=fa.SOFRONIOU_SPALETTA10)
    assert (np.abs(found.z - plain.z) <= found.error + 1e-13).all()


@pytest.mark.parametrize(
    "text", ["sqrt(1 - p**2) + u**2", "tan(p)**2 + u**2", "p**2/2 + m*p + u**2/2", "cos(p) + u**2"]
)
def test_a_text_whose_kinetic_energy_ends_or_is_least_elsewhere_is_told_what_splittings_need(text):
    model = fa.hamiltonian(
        f"{text} + (x**2 + y**2)/2", coordinates="x y", momenta="p u", **{"m": 1.0} if "m" in text else {}
    )
    assert system_of(model).nonseparable
    for scheme in (fa.KAHAN_LI8, fa.schemes.RKN12, fa.TimeTransformed(fa.KAHAN_LI8)):
        said = r"requires H = T\(p\) \+ V\(q\) with T least at p = 0, and the system has H\(q, p\)\. Use GAUSS16"
        with pytest.raises(ValueError, match=said):
            fa.integrate(model, Z, time=1.0, scheme=scheme, step=0.05)


def test_a_text_and_a_class_of_one_kinetic_energy_have_the_same_orbits():
    """By Gauss's collocation and by a splitting, at a random mass and starts."""
    random = np.random.default_rng(32)
    m, z = random.uniform(0.5, 2), random.uniform(-2, 2, (4, 8))
    text = fa.hamiltonian("sqrt(m**2 + p**2 + u**2) - m + (x**2 + y**2)/2", coordinates="x y", momenta="p u", m=m)
    whole, split = (
        fa.integrate(text, z, time=50.0, scheme=fa.schemes.GAUSS16),
        fa.integrate(Relativistic(m), z, time=50.0),
    )
    assert split.scheme == fa.KAHAN_LI8
    assert (np.abs(whole.z - split.z) <= whole.error + split.error + 1e-13).all()
    assert max(whole.energy_error.max(), split.energy_error.max()) < 1e-9


def test_a_class_that_does_not_name_its_kind_is_told_it():
    class Whole(NamedTuple):
        degrees_of_freedom, coordinates = 1, ("q",)

        def energy(self, q, p):
            return p * p * (1 + q * q) / 2

        def rates(self, q, p):
            return p * (1 + q * q), -p * p * q

        def tangent_rates(self, q, p, dq, dp):
            return dp * (1 + q * q) + 2 * p * q * dq, -2 * p * q * dp - p * p * dq

        def margin(self, q, p):
            return 1.0 + 0.0 * q

    with pytest.raises(
        TypeError, match=r"has no velocity, force, .* must have kind = \S*contracts.Kind.NONSEPARABLE\.$"
    ):
        fa.integrate(Whole(), [0.3, 0.4], time=1.0)
    del Whole.energy, Whole.tangent_rates
    with pytest.raises(TypeError, match=r"has no velocity, force, .* must have kind = \S*contracts.Kind.FLOW\.$"):
        fa.integrate(Whole(), [0.3, 0.4], time=1.0)


def test_the_axis_of_a_top_is_refused_with_the_chart_that_takes_it():
    upright = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])
    for top in (fa.models.SymmetricTop(), fa.models.SymmetricTop(h=0.0)):
        with pytest.raises(ValueError, match=r"for a top use AsymmetricTop\(..., chart=\"quaternion\"\)"):
            fa.integrate(top, upright, time=1.0)
    lost = fa.integrate(fa.models.AsymmetricTop(h_3=1.0), upright, time=1.0)
    assert lost.status == fa.Status.NOT_CONVERGED
    assert np.isinf(lost.error).all()
    taken = fa.models.AsymmetricTop(h_3=1.0, chart="quaternion")
    run = fa.integrate(taken, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0], time=1.0)
    assert np.allclose(run.z[[1, 2, 5, 6]], 0, atol=1e-12)
    with pytest.raises(ValueError, match=r"in the domain \(r - 1 - sqrt\(1 - a\*\*2\) > 0\)"):
        fa.integrate(fa.models.KerrGeodesic(0.9), [1.0, 1.5, 0.0, 0.0, 0.1, 2.0], time=1.0)


def test_a_body_of_another_class_is_a_body():
    """p_eta, p_gamma, grids, frequencies of the planes: by what it says of itself, not by its class."""
    own, ours = OwnBody(fa.Hyperelastic()), fa.Body(fa.Hyperelastic())
    assert system_of(own).isotropic
    assert not system_of(fa.HenonHeiles()).isotropic
    where = {
        "energy": 3.5,
        "section": fa.AlphaTurning(1),
        "axes": [np.linspace(-0.5, 0.5, 4)] * 2,
        "p_eta": 0.3,
        "p_gamma": 0.1,
    }
    z = fa.energy_grid(own, **where).z0
    np.testing.assert_array_equal(z, fa.energy_grid(ours, **where).z0)
    found, known = (fa.action_angles(body, z[:, :3]) for body in (own, ours))
    np.testing.assert_array_equal(found.J, known.J)


def test_a_step_belongs_to_its_orbit_and_a_chosen_scheme_to_the_set():
    """Both halves of what plans promise: alone or in company the same step; AUTO's scheme is that of the sample."""
    from fastaff.runs.options import Options, plan

    body, rng = fa.HenonHeiles(), np.random.default_rng(12)
    z = rng.uniform(-0.2, 0.2, (4, 30)) * rng.choice([1.0, 1e-3], 30)
    order = rng.permutation(30)
    together = plan(body, z, Options(), time=100.0)
    np.testing.assert_array_equal(plan(body, z[:, order], Options(), time=100.0).flow.step, together.flow.step[order])
    for k in (0, 7, 29):
        np.testing.assert_array_equal(plan(body, z[:, k], Options(), time=100.0).flow.step, together.flow.step[[k]])
    chosen = plan(body, z, Options(scheme=fa.AUTO), time=100.0)
    same = plan(body, z, Options(scheme=chosen.flow.scheme), time=100.0)
    if not chosen.flow.adaptive:
        np.testing.assert_array_equal(chosen.flow.step, same.flow.step)
    assert chosen.flow.scheme.name in chosen.why
    assert "own step" in together.why
    assert plan(body, z, Options(step=0.1)).why == "the step given"
    assert "rtol 1e-12" in plan(body, z, Options(scheme=fa.DOP853)).why


# --- derivatives of one's own -----------------------------------------------------------------------------------------


class Rotor(NamedTuple):
    """H = (p_x^2 + p_y^2)(1 + a x^2)/2 + (x^2 + 2 y^2)/2 + a x^2 y in units of length and time; one of its derivatives
    is off by a part `off` of itself: in rows `of` of the rates or `of_tangent` of the tangent rates.
    """

    a: float = 0.3
    length: float = 1.0
    time: float = 1.0
    off: float = 0.0
    of: float = -1.0
    of_tangent: float = -1.0

    kind, degrees_of_freedom, coordinates = Kind.NONSEPARABLE, 2, ("x", "y")

    def margin(self, x, y, px, py):
        return 1.0 + 0.0 * x

    def energy(self, x, y, px, py):
        x, y, px, py = x / self.length, y / self.length, px * self.time / self.length, py * self.time / self.length
        H = (px * px + py * py) / 2 * (1 + self.a * x * x) + (x * x + 2 * y * y) / 2 + self.a * x * x * y
        return H * self.length**2 / self.time**2

    def rates(self, x, y, px, py):
        x, y, px, py = x / self.length, y / self.length, px * self.time / self.length, py * self.time / self.length
        s, a, p = 1 + self.a * x * x, self.a, px * px + py * py
        v, f = self.length / self.time, self.length / self.time**2
        vx, vy = (1 + self.off * (self.of == 0)) * px * s, (1 + self.off * (self.of == 1)) * py * s
        fx = (1 + self.off * (self.of == 2)) * (p * a * x + x + 2 * a * x * y)
        return v * vx, v * vy, -f * fx, -f * (1 + self.off * (self.of == 3)) * (2 * y + a * x * x)

    def tangent_rates(self, x, y, px, py, dx, dy, dpx, dpy):
        x, y, px, py = x / self.length, y / self.length, px * self.time / self.length, py * self.time / self.length
        dx, dy, dpx, dpy = (
            dx / self.length,
            dy / self.length,
            dpx * self.time / self.length,
            dpy * self.time / self.length,
        )
        s, a, p = 1 + self.a * x * x, self.a, px * px + py * py
        v, f = self.length / self.time, self.length / self.time**2
        wx = (1 + self.off * (self.of_tangent == 0)) * (dpx * s + 2 * a * px * x * dx)
        wy = (1 + self.off * (self.of_tangent == 1)) * (dpy * s + 2 * a * py * x * dx)
        gx = 2 * (px * dpx + py * dpy) * a * x + p * a * dx + dx + 2 * a * (dx * y + x * dy)
        gx = (1 + self.off * (self.of_tangent == 2)) * gx
        return v * wx, v * wy, -f * gx, -f * (1 + self.off * (self.of_tangent == 3)) * (2 * dy + 2 * a * x * dx)


def test_wrong_derivatives_of_ones_own_are_refused_in_all_units():
    """A wrong tangent map ran under OK, a wrong force until its energy had drifted; right ones are never refused."""
    random = np.random.default_rng(32)
    for _ in range(40):
        length, time = (float(x) for x in 10 ** random.uniform(-6, 6, 2))
        right = Rotor(float(random.uniform(0.1, 3)), length, time)
        z = random.uniform(-1, 1, (4, 5)) * random.choice([0.0, 1e-3, 1.0], (4, 1))
        z = z * np.array([length, length, length / time, length / time])[:, None]
        check_derivatives("model", system_of(right), z)
        row, off = random.integers(4), float(10 ** random.uniform(-4, -1) * random.choice([-1, 1]))
        with pytest.raises(
            ValueError,
            match=r"model Rotor must have rates dH/dp and -dH/dq of its energy H: that of \w+ is \S+, by diff",
        ):
            check_derivatives("model", system_of(right._replace(off=off, of=float(row))), z)
        with pytest.raises(ValueError, match="model Rotor must have a tangent_rates that is the change of its rates"):
            check_derivatives("model", system_of(right._replace(off=off, of_tangent=float(row))), z)


def test_all_verbs_refuse_wrong_derivatives():
    z0 = [0.3, 0.2, 0.1, -0.3]
    for wrong, match in ((Rotor(off=1e-3, of=3.0), "energy H"), (Rotor(off=1e-3, of_tangent=2.0), "tangent_rates")):
        for call in (
            lambda body: fa.integrate(body, z0, time=1.0),
            lambda body: fa.frequency_map(body, z0, time=100.0),
            lambda body: fa.chaos_map(body, z0, time=100.0),
            lambda body: fa.tangent_map(body, z0, time=1.0),
            lambda body: fa.poincare_map(body, z0, section="y=0", crossings=2, max_time=50.0),
            lambda body: fa.fit_torus(body, z0, time=100.0),
            lambda body: fa.periodic_orbits(body, z0, section="y=0"),
            lambda body: fa.continuation(body, z0, section="y=0", max_steps=1),
        ):
            with pytest.raises(ValueError, match=match):
                call(wrong)


def test_wrong_derivatives_of_springs_maps_and_flows_are_refused():
    class Stiff(OneSpring):
        def force(self, x):
            return (-1.001 * self.k * x,)

    class Bent(OneSpring):
        def tangent_force(self, x, dx):
            return (-1.001 * self.k * dx,)

    class Kicked(fa.models.StandardMap):
        def tangent_iterate(self, x, p, dx, dp):
            return dx + dp, dp

    class Wound(NamedTuple):
        w: float = 1.0
        kind, degrees_of_freedom, coordinates = Kind.FLOW, 1, ("x", "y")

        def rates(self, x, y):
            return y, -self.w * np.sin(x) - 0.1 * y

        def tangent_rates(self, x, y, dx, dy):
            return dy, -self.w * np.cos(x) * dx - 0.11 * dy

        def margin(self, x, y):
            return 1.0 + 0.0 * x

    z, check = np.array([[0.7], [0.4]]), check_derivatives
    check("model", system_of(OneSpring()), z)
    check("model", system_of(fa.models.StandardMap(0.9)), z)
    for body, match in (
        (Stiff(), "energy H: .* of p_x is"),
        (Bent(), "a tangent_force"),
        (Kicked(0.9), "a tangent_iterate"),
        (Wound(), "a tangent_rates .* of y is"),
    ):
        with pytest.raises(ValueError, match=match):
            check("model", system_of(body), z)


def half(x):
    return x / 2


class Uncompiled(NamedTuple):
    """A spring whose force calls a Python function, which Numba does not know."""

    k: float = 1.0
    degrees_of_freedom, coordinates, velocity, margin = 1, ("x",), OneSpring.velocity, OneSpring.margin
    kinetic_energy, potential_energy = OneSpring.kinetic_energy, OneSpring.potential_energy

    def force(self, x):
        return (-2 * self.k * half(x),)


def test_methods_that_numba_does_not_compile_are_refused_by_name():
    with pytest.raises(
        TypeError, match=r"Uncompiled must have methods, of the class itself, that Numba compiles \(.*\): .*'half'"
    ):
        fa.integrate(Uncompiled(), [0.3, 0.2], time=1.0, step=0.1, scheme="LEAPFROG")


class Uneven(NamedTuple):
    """H = p^2/2 + V with V of many scales, kinks, walls, an offset: V, -V', -V''."""

    which: int
    degrees_of_freedom, coordinates, velocity, margin = 1, ("x",), OneSpring.velocity, OneSpring.margin
    kinetic_energy = OneSpring.kinetic_energy

    def potential_energy(self, x):
        return UNEVEN[self.which][0](x)

    def force(self, x):
        return (UNEVEN[self.which][1](x),)

    def tangent_force(self, x, dx):
        return (UNEVEN[self.which][2](x) * dx,)


UNEVEN = [
    (np.abs, lambda x: -np.sign(x), lambda x: 0 * x),
    (
        lambda x: x * x / 2 + 1e-7 * np.cos(1e6 * x),
        lambda x: 0.1 * np.sin(1e6 * x) - x,
        lambda x: 1e5 * np.cos(1e6 * x) - 1,
    ),
    (lambda x: np.exp(40 * x), lambda x: -40 * np.exp(40 * x), lambda x: -1600 * np.exp(40 * x)),
    (lambda x: x**-12, lambda x: 12 * x**-13, lambda x: -156 * x**-14),
    (lambda x: 1e10 + x * x / 2, lambda x: -x, lambda x: 0 * x - 1),
    (np.sqrt, lambda x: -0.5 / np.sqrt(x), lambda x: 0.25 * x**-1.5),
    (lambda x: np.where(x > 0.3, x * x, 0.0), lambda x: np.where(x > 0.3, -2 * x, 0.0), lambda x: -2.0 * (x > 0.3)),
    (lambda x: 1e250 * x * x / 2, lambda x: -1e250 * x, lambda x: 0 * x - 1e250),
]


@pytest.mark.parametrize("which", range(len(UNEVEN)))
def test_right_derivatives_are_never_refused(which):
    random = np.random.default_rng(which)
    for _ in range(60):
        z = random.uniform(-1, 1, (2, random.integers(1, 5))) * 10 ** random.uniform(-6, 0)
        check_derivatives("model", system_of(Uneven(which)), z)
