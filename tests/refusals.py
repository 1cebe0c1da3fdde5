"""What a call refuses, by the whole sentence that the user reads: rows of the call, the exception and the sentence.

A number that the machine or the compiler changes is `<...>` in the sentence. Add a row for a new refusal.
"""

from typing import Any, NamedTuple

import numpy as np

import fastaff as fa

HENON = fa.HenonHeiles()
BODY = fa.Body(fa.Hyperelastic())
LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=2.5)
PLANE = fa.hamiltonian("(x**2 + y**2)/2 + x**2*y")
SPACE = fa.hamiltonian("(x**2 + y**2 + z**2)/2 + x**2*y", coordinates="x y z")
DAMPED = fa.hamiltonian("(x**2 + y**2)/2", friction=0.1)
DRIVEN = fa.hamiltonian("x**2/2*(1.3 + 0.2*cos(t))", coordinates="x", drive_period="2*pi")
COUPLED = fa.hamiltonian("(p**2 + q**2)*(P**2 + Q**2 + 1)", coordinates="q Q", momenta="p P")
MAP = fa.models.StandardMap(1.0)
STAR = fa.models.Body3(fa.models.Sum3(fa.models.SelfGravity(), fa.models.GasCloud(k=0.2, gamma=2.0, C=0.0)))
SPRING = "p_r**2/(2*m) + p_a**2/(2*m*r**2) + k/2*(r - 1)**2 - m*r*cos(a)"
RING = "k = p + s*x**2; x1 = cos(2*pi*q)*x + sin(2*pi*q)*k; p1 = -sin(2*pi*q)*x + cos(2*pi*q)*k"
Z4 = np.full((4, 2), 0.1)
Z8 = np.array([[1.2, 1.3], [0.1, 0.0], [0.4, 0.3], [0.0, 0.1], [0.1, 0.2], [0.6, 0.5], [0.1, 0.0], [0.2, 0.3]])
CUT = {"section": "x=0", "crossings": 2, "max_time": 5.0}


LONGEST = 160
"""Characters of a sentence."""


class Lonely(NamedTuple):
    """A value without the methods of a model."""

    k: float = 1.0


def misplaced(z0: np.ndarray, row: Any, value: Any) -> np.ndarray:
    """Initial conditions with a wrong one."""
    z = z0.copy()
    z[row] = value
    return z


ROWS = [
    (
        lambda: fa.molecules.molecule([1, 0, 1], [[0, 1, 0], [0, 0, 1]], {(0, 1): fa.molecules.HarmonicBond()}),
        ValueError,
        "masses must be positive, got [1.0, 0.0, 1.0].",
    ),
    (
        lambda: fa.molecules.molecule([1, 1, 1], [[0, 1, 2], [0, 1, 2]], {(0, 1): fa.molecules.HarmonicBond()}),
        ValueError,
        "positions must not be on one line in the plane, got principal moments 0, 4.",
    ),
    (
        lambda: fa.molecules.molecule([1, 1, 1], np.ones((4, 3)), {(0, 1): fa.molecules.HarmonicBond()}),
        ValueError,
        "positions must have shape (2, 3) or (3, 3), got (4, 3).",
    ),
    (
        lambda: fa.molecules.ring(6, pairs=[fa.molecules.HarmonicBond()] * 4),
        ValueError,
        "pairs must have 1 to 3 orders of neighbours for 6 atoms, got 4.",
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"section": "q=0"}),
        ValueError,
        "section must be one of x=c, y=c, got 'q=0'. Use fa.Hyperplane(normal, offset) for other sections.",
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"section": "t=0"}),
        ValueError,
        "section must be one of x=c, y=c, got 't=0'. HenonHeiles has no drive.",
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"section": "w"}),
        ValueError,
        "section must be one of x=c, y=c, got 'w'. Use fa.Hyperplane(normal, offset) for other sections.",
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, section="x=0", crossings=2),
        TypeError,
        "max_time is required for the section x=0. The typical period is 5.9. Try max_time=50.",
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"section": None}),
        TypeError,
        (
            "section must be a text such as 'x=0' or a section such as fa.Hyperplane(normal, offset), got "
            "None (NoneType)"
        ),
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"section": fa.AlphaTurning}),
        TypeError,
        (
            "section must be a text such as 'x=0' or a section such as fa.Hyperplane(normal, offset), got "
            "AlphaTurning (type). Use AlphaTurning()."
        ),
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"section": BODY}),
        TypeError,
        (
            "section must be a text such as 'x=0' or a section such as fa.Hyperplane(normal, offset), got "
            "Body(potential=Hyperelastic(C=1.0),  ... (Body)"
        ),
    ),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"section": fa.AlphaTurning(2)}),
        ValueError,
        "section.direction must be -1, 0 or +1, got 2",
    ),
    (
        lambda: fa.poincare_map(BODY, Z8, **CUT | {"section": fa.AlphaTurning(2)}),
        ValueError,
        "section.direction must be -1, 0 or +1, got 2",
    ),
    (
        lambda: fa.poincare_map(BODY, Z8, **CUT | {"section": fa.AlphaEquals(np.nan)}),
        ValueError,
        "section has a parameter that is not finite: AlphaEquals(constant=nan, direction=1)",
    ),
    (
        lambda: fa.poincare_map(BODY, Z8, **CUT | {"section": fa.AlphaEquals("1")}),
        TypeError,
        "section has a wrong parameter: AlphaEquals.constant must be a float, got '1' (str)",
    ),
    (
        lambda: fa.poincare_map(BODY, Z8, **CUT | {"section": fa.Hyperplane((1.0, 0.0, 0.0, 0.0))}),
        ValueError,
        (
            "section must depend on the 8 rows of Body, such as alpha-turning, beta-turning, alpha=c, got "
            "Hyperplane(normal=(1.0, 0.0, 0.0, 0.0), offset=0.0, dire ..."
        ),
    ),
    (
        lambda: fa.poincare_map(BODY, Z8, **CUT | {"section": fa.Hyperplane((0.0,) * 8)}),
        ValueError,
        (
            "section must depend on the 8 rows of Body, such as alpha-turning, beta-turning, alpha=c, got "
            "Hyperplane(normal=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0. ..."
        ),
    ),
    (lambda: fa.poincare_map(HENON, Z4, **CUT | {"max_time": -1.0}), ValueError, "max_time must be positive, got -1.0"),
    (lambda: fa.poincare_map(HENON, Z4, **CUT | {"crossings": 0}), ValueError, "crossings must be at least 1, got 0"),
    (
        lambda: fa.poincare_map(HENON, Z4, **CUT | {"crossings": True}),
        TypeError,
        "crossings must be a whole number, got True (bool)",
    ),
    (
        lambda: fa.frequency_map(LORENZ, [1.0, 1.0, 1.0], time=10.0),
        TypeError,
        (
            "model must be a Hamiltonian system without friction, or a map, got an ODE system. Use fa.naff "
            "on samples of fa.integrate."
        ),
    ),
    (
        lambda: fa.frequency_map(DAMPED, Z4, time=10.0),
        TypeError,
        (
            "model must be a Hamiltonian system without friction, or a map, got a system with friction. Use "
            "fa.naff on samples of fa.integrate."
        ),
    ),
    (
        lambda: fa.frequency_map(BODY, Z8, time=20.0, signals="alpha"),
        ValueError,
        (
            "signals must be 'R phi' for 2 coordinates, 'R z phi' for 3 coordinates, or an object of "
            "fastaff.models.angles, got 'alpha'"
        ),
    ),
    (
        lambda: fa.frequency_map(BODY, Z8, time=20.0, signals=3),
        TypeError,
        "signals must be a text such as 'R z phi', or a value of fastaff.models.angles, got 3",
    ),
    (
        lambda: fa.frequency_map(BODY, Z8, time=20.0, signals=fa.models.angles.Coordinates2()),
        ValueError,
        "signals must have 4 angles for Body, got Coordinates2()",
    ),
    (
        lambda: fa.frequency_map(HENON, Z4, time=20.0, signals=fa.models.angles.AlphaBeta()),
        ValueError,
        "signals must have 2 angles for HenonHeiles, got AlphaBeta(). Use 'R phi', or leave signals out.",
    ),
    (lambda: fa.frequency_map(HENON, Z4, time=np.inf), ValueError, "time must be finite, got inf"),
    (
        lambda: fa.energy_grid(HENON, energy=0.2, section="x=0", axes="whole"),
        ValueError,
        (
            "section x=0 is unbounded: energy 0.2 exceeds the escape energy <...>. Pass axes, two arrays "
            "such as np.linspace(low, high, 101)."
        ),
    ),
    (
        lambda: fa.energy_grid(HENON, section="x=0"),
        TypeError,
        "energy must be given for a model that conserves it, got None",
    ),
    (
        lambda: fa.energy_grid(HENON, energy=-1.0, section="x=0"),
        ValueError,
        "energy must be at least the local minimum 0 of this system, got -1",
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0)[5],
        IndexError,
        "items: the orbit index 5 is out of range for a result with 2 orbits",
    ),
    (
        lambda: fa.integrate(HENON, Z4[:, 0], time=1.0)[5],
        IndexError,
        "items: the orbit index 5 is out of range for a result with 1 orbit",
    ),
    (lambda: fa.integrate(HENON, Z4, time=1.0)["q"], KeyError, "Orbits has no field 'q'. Names: x, y, p_x, p_y."),
    (
        lambda: fa.chaos_map(HENON, Z4, time=1.0, indicators=("megno", 3)),
        TypeError,
        "indicators[1] must be an indicator or its name, got 3",
    ),
    (
        lambda: fa.chaos_map(HENON, Z4, time=1.0, indicators=(fa.MEGNO,)),
        TypeError,
        ("indicators[0] must be an indicator or its name, got <class 'fastaff.chaos.indicators.MEGNO'>. Use MEGNO()."),
    ),
    (
        lambda: fa.chaos_map(HENON, Z4, time=1.0, indicators="entropy"),
        ValueError,
        (
            "indicators must be one of megno, sali, gali_2, gali_3, gali_4, gali_5, gali_6, gali_7, ..., got "
            "'entropy'. Did you mean megno?"
        ),
    ),
    (
        lambda: fa.chaos_map(HENON, Z4, time=1.0, accuracy=1e-3),
        TypeError,
        (
            "chaos_map() got an unexpected keyword argument 'accuracy'. It takes model, z0, time, "
            "indicators, history, early_stop, deviation_vectors, step, ...."
        ),
    ),
    (
        lambda: fa.chaos_map(DRIVEN, [0.1, 0.2], time=1.0, indicators=fa.OFLI()),
        ValueError,
        ("indicators[0], ofli, is not supported for driven systems. Use FLI, MEGNO, SALI or the Lyapunov spectrum."),
    ),
    (
        lambda: fa.chaos_map(MAP, [0.1, 0.2], time=100, indicators=fa.OFLI()),
        ValueError,
        "indicators[0], ofli, is not supported for maps. Use FLI or GALI.",
    ),
    (
        lambda: fa.integrate(LORENZ, [1.0, 1.0, 1.0], time=1.0, scheme="KAHAN_LI8"),
        ValueError,
        "scheme KAHAN_LI8 requires a Hamiltonian system. Use DOP853, VERNER9 or RK4 for an ODE system.",
    ),
    (
        lambda: fa.integrate(LORENZ, [1.0, 1.0, 1.0], time=1.0, accuracy=1e-8),
        ValueError,
        "accuracy is not supported for ODE systems, got 1e-08. Use rtol and atol.",
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, accuracy=1e-8, scheme="dop853"),
        ValueError,
        "accuracy must be None with the adaptive method DOP853, got 1e-08. Use rtol and atol.",
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, accuracy=9e-16),
        ValueError,
        "accuracy must be at least 1e-15, as numbers have 16 digits, got 9e-16",
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, accuracy=1e-8, step=0.1),
        ValueError,
        "accuracy and step must not be given together, got accuracy=1e-08 and step=0.1",
    ),
    (lambda: fa.integrate(HENON, Z4, time=0), ValueError, "time must be positive, got 0"),
    (lambda: fa.integrate(HENON, Z4, time=1.0, rtol=[0.1]), TypeError, "rtol must be a real number, got [0.1] (list)"),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, scheme=fa.DOP853, atol=0.0),
        ValueError,
        "atol must be positive, got 0.0",
    ),
    (lambda: fa.integrate(HENON, Z4, time=1.0, samples=-3), ValueError, "samples must be at least 0, got -3"),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, samples=1.5),
        TypeError,
        "samples must be a whole number, got 1.5 (float)",
    ),
    (lambda: fa.integrate(HENON, Z4, time=1.0, step=-0.1), ValueError, "step must be positive, got -0.1"),
    (lambda: fa.integrate(HENON, Z4, time=1.0, step=np.nan), ValueError, "step must be finite, got nan"),
    (lambda: fa.integrate(HENON, Z4, time=1.0, step=True), TypeError, "step must be a real number, got True (bool)"),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, energy_tolerance=0),
        ValueError,
        "energy_tolerance must be positive, got 0",
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, energy_tolerance="0.1"),
        TypeError,
        "energy_tolerance must be a real number, got '0.1' (str)",
    ),
    (lambda: fa.integrate(HENON, Z4, time=1.0, threads=0), ValueError, "threads must be at least 1, got 0"),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, threads=2.0),
        TypeError,
        "threads must be a whole number, got 2.0 (float)",
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, scheme=8),
        TypeError,
        "scheme must be a scheme such as fastaff.KAHAN_LI8, or its name, got 8 (int)",
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, scheme="KAHAN"),
        ValueError,
        (
            "scheme must be one of LEAPFROG, YOSHIDA4, BLANES_MOAN6, BLANES_CASAS_ESCORIHUELA8, ..., got "
            "'KAHAN'. Did you mean KAHAN_LI8?"
        ),
    ),
    (
        lambda: fa.integrate(HENON, Z4, time=1.0, steps=3),
        TypeError,
        "integrate() got an unexpected keyword argument 'steps'. Did you mean step?",
    ),
    (
        lambda: fa.integrate(HENON, Z4.T[:, :3], time=1.0),
        ValueError,
        ("z0 must have shape (4,) or (4, orbits) for HenonHeiles, rows x, y and their momenta, got shape (2, 3)"),
    ),
    (
        lambda: fa.integrate(HENON, np.ones((3, 4)), time=1.0),
        ValueError,
        (
            "z0 must have shape (4,) or (4, orbits) for HenonHeiles, rows x, y and their momenta, got shape "
            "(3, 4). Try z0.T."
        ),
    ),
    (
        lambda: fa.integrate(HENON, np.ones((4, 2, 3)), time=1.0),
        ValueError,
        (
            "z0 must have shape (4,) or (4, orbits) for HenonHeiles, rows x, y and their momenta, got shape "
            "(4, 2, 3). Try z0.reshape(4, -1)."
        ),
    ),
    (
        lambda: fa.integrate(HENON, np.ones((4, 0)), time=1.0),
        ValueError,
        ("z0 must have shape (4,) or (4, orbits) for HenonHeiles, rows x, y and their momenta, got shape (4, 0)"),
    ),
    (
        lambda: fa.integrate(HENON, 1.0, time=1.0),
        ValueError,
        "z0 must have shape (4,) or (4, orbits) for HenonHeiles, rows x, y and their momenta, got shape ()",
    ),
    (lambda: fa.integrate(HENON, "abc", time=1.0), TypeError, "z0 must be an array of real numbers, got 'abc' (str)"),
    (
        lambda: fa.integrate(HENON, [[1, 2], [3]], time=1.0),
        ValueError,
        "z0 must be an array of numbers, with rows of one length, got [[1, 2], [3]]",
    ),
    (
        lambda: fa.integrate(HENON, np.ones(4) * 1j, time=1.0),
        TypeError,
        "z0 must be an array of real numbers, got array([0.+1.j, 0.+1.j, 0.+1.j, 0.+1.j]) (ndarray)",
    ),
    (
        lambda: fa.integrate(HENON, misplaced(Z4, (3, 1), np.nan), time=1.0),
        ValueError,
        "z0 must be finite, got [0.1, 0.1, 0.1, nan] in orbit 1",
    ),
    (
        lambda: fa.integrate(BODY, misplaced(Z8, (slice(4), 1), (0.3, 0, 0.3, 0)), time=1.0),
        ValueError,
        ("z0 must lie in the domain of the potential (for most bodies det phi > 0), got margin 0 in orbit 1"),
    ),
    (
        lambda: fa.integrate("HenonHeiles", Z4, time=1.0),
        TypeError,
        (
            "model must be a model such as Body(Hyperelastic()) or HenonHeiles(), got 'HenonHeiles' (str). "
            "Names are for jobs and the command line."
        ),
    ),
    (
        lambda: fa.integrate(None, Z4, time=1.0),
        TypeError,
        "model must be a model such as Body(Hyperelastic()) or HenonHeiles(), got None (NoneType)",
    ),
    (
        lambda: fa.integrate(fa.HenonHeiles, Z4, time=1.0),
        TypeError,
        (
            "model must be a model such as Body(Hyperelastic()) or HenonHeiles(), got HenonHeiles (type). "
            "Use HenonHeiles(), with its parameters."
        ),
    ),
    (
        lambda: fa.integrate(fa.Hyperelastic(), Z8, time=1.0),
        TypeError,
        "model Hyperelastic(C=1.0) is a potential. Use Body(Hyperelastic(...)).",
    ),
    (
        lambda: fa.integrate(Lonely(), Z4, time=1.0),
        TypeError,
        "model Lonely has no degrees_of_freedom, velocity, force, kinetic_energy, potential_energy, margin",
    ),
    (
        lambda: fa.integrate(fa.Body(1.0), Z8, time=1.0),
        TypeError,
        "model.potential must be a NamedTuple such as Hyperelastic(C=1.0), got 1.0",
    ),
    (
        lambda: fa.integrate(fa.Body(fa.Hyperelastic(np.nan)), Z8, time=1.0),
        ValueError,
        "model has a parameter that is not finite: Body(potential=Hyperelastic(C=nan), mu=1.0)",
    ),
    (
        lambda: fa.integrate(fa.Body(fa.Hyperelastic(), -1.0), Z8, time=1.0),
        ValueError,
        "model.mu must be positive, got -1.0",
    ),
    (
        lambda: fa.integrate(fa.Body(fa.Hyperelastic("1.0")), Z8, time=1.0),
        TypeError,
        "model has a wrong parameter: Body.potential: Hyperelastic.C must be a float, got '1.0' (str)",
    ),
    (
        lambda: fa.integrate(COUPLED, Z4, time=1.0, scheme="KAHAN_LI8"),
        ValueError,
        (
            "scheme KAHAN_LI8 requires H = T(p) + V(q) with T least at p = 0, and the system has H(q, p). "
            "Use GAUSS16, GAUSS8, DOP853 or VERNER9."
        ),
    ),
    (
        lambda: fa.integrate(COUPLED, Z4, time=1.0, scheme=fa.TimeTransformed()),
        ValueError,
        (
            "scheme TimeTransformed(KAHAN_LI8) requires H = T(p) + V(q) with T least at p = 0, and the "
            "system has H(q, p). Use GAUSS16, GAUSS8, DOP853 or VERNER9."
        ),
    ),
    (
        lambda: fa.integrate(DRIVEN, [0.1, 0.2], time=1.0, scheme=fa.TimeTransformed()),
        ValueError,
        (
            "scheme TimeTransformed(KAHAN_LI8) is not supported for driven systems. Use a splitting or a "
            "Runge-Kutta scheme such as KAHAN_LI8."
        ),
    ),
    (
        lambda: fa.integrate(PLANE, Z4, time=1.0, friction=0.1),
        TypeError,
        "integrate() got an unexpected keyword argument 'friction'. Use hamiltonian('...', friction=...).",
    ),
    (
        lambda: fa.periodic_orbits(DRIVEN, [0.1, 0.2], section="t=0", max_time=1.0),
        ValueError,
        "max_time is not supported for driven systems, got 1.0.",
    ),
    (
        lambda: fa.periodic_orbits(DRIVEN, [0.1, 0.2], section="t=0", energy=1.0),
        ValueError,
        "energy is not supported for driven systems, which do not conserve it, got 1.0.",
    ),
    (
        lambda: fa.periodic_orbits(DAMPED, Z4, section="x=0", max_time=9.0),
        TypeError,
        ("model has friction and no drive, so no orbit returns. Write a drive and friction as equations, fa.ode."),
    ),
    (
        lambda: fa.energy_sample(DAMPED, energy=0.1, orbits=3, axes={"x": (-1, 1)}),
        ValueError,
        "energy requires a conserved energy, which a system that has friction does not have, got 0.1.",
    ),
    (
        lambda: fa.hamiltonian("x**2 + k*y**2"),
        ValueError,
        (
            "text: unknown name 'k' at column 8. Give a parameter its value, k=1.0, or name the coordinates, "
            "coordinates='k ...'."
        ),
    ),
    (
        lambda: fa.hamiltonian(SPRING, coordinates="r a", m=1.0, k=4.0),
        ValueError,
        (
            "text: unknown name 'p_r' at column 1. For a momentum give momenta='p_r p_a'; the text is then "
            "the whole of H."
        ),
    ),
    (
        lambda: fa.hamiltonian("(p1**2 + p2**2)/2 - cos(a - b)", coordinates="a b"),
        ValueError,
        ("text: unknown name 'p1' at column 2. For a momentum give momenta='p1 p2'; the text is then the whole of H."),
    ),
    (
        lambda: fa.hamiltonian("p**2/2 - cos(a)", coordinates="a"),
        ValueError,
        ("text: unknown name 'p' at column 1. For a momentum give momenta='p'; the text is then the whole of H."),
    ),
    (
        lambda: fa.hamiltonian("(px**2 + py**2)/2 + x**2"),
        ValueError,
        ("text: unknown name 'px' at column 2. For a momentum give momenta='px py'; the text is then the whole of H."),
    ),
    (
        lambda: fa.hamiltonian(SPRING, m=1.0, k=4.0),
        ValueError,
        "text: unknown name 'p_r' at column 1. For a momentum give coordinates='r ...' and momenta='p_r ...'.",
    ),
    (
        lambda: fa.hamiltonian(SPRING, momenta="p_r p_a", m=1.0, k=4.0),
        ValueError,
        (
            "text: unknown name 'r' at column 28. Give a parameter its value, r=1.0, or name the "
            "coordinates, coordinates='r ...'."
        ),
    ),
    (
        lambda: fa.hamiltonian("R**2 + z**4"),
        ValueError,
        (
            "text: unknown name 'R' at column 1. Give a parameter its value, R=1.0, or name the coordinates, "
            "coordinates='R ...'."
        ),
    ),
    (
        lambda: fa.hamiltonian("x**2 + f*cos(t)*x", coordinates="x", f=1.0),
        ValueError,
        (
            "text: unknown name 't' at column 14. Use drive_period, such as drive_period='2*pi/w', for the "
            "time of a driven system."
        ),
    ),
    (
        lambda: fa.hamiltonian("k*x**2", coordinates="x"),
        ValueError,
        "text: unknown name 'k' at column 1. Give a parameter its value, k=1.0. Known names: x, pi.",
    ),
    (
        lambda: fa.hamiltonian("x**2", coordinates="x", friction=0.1, drive_period=6.28),
        ValueError,
        (
            "friction must be given without rotation, magnetic and drive_period. Use ode(model, forces={'x': "
            "'f*cos(w*t) - g*p_x'}, ...)."
        ),
    ),
    (
        lambda: fa.hamiltonian("x**2 + y**2", s=1.0),
        ValueError,
        "parameter 's' must be a name in the formula, got 'x**2 + y**2'",
    ),
    (
        lambda: fa.hamiltonian("x**2 + y**2 + lamda*x*y", lambd=1.0),
        ValueError,
        (
            "text: unknown name 'lamda' at column 15. Give a parameter its value, lamda=1.0, or name the "
            "coordinates, coordinates='lamda ...'."
        ),
    ),
    (
        lambda: fa.hamiltonian("x**2 + 2y"),
        ValueError,
        "text: not one expression, invalid decimal literal at column 8. Use * for a product.",
    ),
    (
        lambda: fa.hamiltonian("x**2 + abs(y)"),
        ValueError,
        "text: a call of 'abs' at column 8. Use sqrt(q**2 + small**2), which is smooth at 0.",
    ),
    (
        lambda: fa.hamiltonian("x**2 + y[0]"),
        ValueError,
        (
            "text: a subscript or list at column 9. Use numbers, names, pi, + - * / ** (or ^), parentheses "
            "and functions such as sqrt, exp and sin."
        ),
    ),
    (
        lambda: fa.affine_body("D1**2 + D2**2 + f*cos(t)", f=1.0),
        ValueError,
        (
            "text: unknown name 't' at column 23. For friction or a drive use hamiltonian(..., friction=0.1, "
            "drive_period=6.28) or ode(body, forces=...)."
        ),
    ),
    (
        lambda: fa.affine_body("gent", G=1.0, Jm=3.0, K=4.0, friction=0.1),
        ValueError,
        (
            "friction must be a name in 'gent'. For friction or a drive use hamiltonian(..., friction=0.1, "
            "drive_period=6.28) or ode(body, forces=...)."
        ),
    ),
    (
        lambda: fa.affine_body("D1**2 + D2**2", drive_period=6.28),
        ValueError,
        (
            "drive_period must be a name in 'D1**2 + D2**2'. For friction or a drive use hamiltonian(..., "
            "friction=0.1, drive_period=6.28) or ode(body, forces=...)."
        ),
    ),
    (
        lambda: fa.affine_body("D1**2 + 2*D2**2"),
        ValueError,
        ("text must be symmetric under D1 <-> D2, got 4.40396 at D1 = 1.7503, D2 = 0.81866 and 6.79731 exchanged"),
    ),
    (
        lambda: fa.iterated_map(RING, s=1.0, q=0.2, aperture=1.0),
        ValueError,
        (
            "parameter 'aperture' is not used by the map: a domain is a formula that is positive inside, "
            "such as domain='1 - x**2'"
        ),
    ),
    (
        lambda: fa.iterated_map(RING, s=1.0, q=0.2, zeta=1.0),
        ValueError,
        "parameter 'zeta' is not used by the map: leave it out, or is a name misspelt?",
    ),
    (
        lambda: fa.iterated_map("x1 = x + p; p1 = p + sin(x)", periodic={"x": 3}),
        ValueError,
        "periodic['x'] must be a period of the map, got 3: the image of p changes by -1.49115 after it",
    ),
    (
        lambda: fa.ode("x' = t*x; y' = y; z' = z"),
        ValueError,
        "text: x' must not depend on t. Try a variable t with t' = 1, periodic={'t': '2*pi/w'}.",
    ),
    (
        lambda: fa.action_angles(fa.Body(fa.NeoHookean()), Z8),
        ValueError,
        "model must be separable, got a Body of NeoHookean. Use fa.fit_torus for other bodies.",
    ),
    (
        lambda: fa.integrate(fa.models.BreathingBody(fa.Harmonic(), -1.0), Z8, time=1.0),
        ValueError,
        "model.c must be above -1 for a positive kinetic energy, got -1.0",
    ),
    (
        lambda: fa.quantum.spectrum(
            fa.models.StackelBody(fa.Harmonic(), fa.models.Cosine(1.0), fa.models.Zero()), count=1
        ),
        fa.quantum.NoGroundState,
        (
            "V_eta must have no level below 0, got 2 mu c/hbar^2 = -1.07: the body falls to the centre alpha = 0. Try "
            "n_eta and n_gamma of higher levels."
        ),
    ),
    (
        lambda: fa.action_angles(fa.Body(fa.HeavyTop()), Z8, chart=fa.charts.SPHERICAL),
        ValueError,
        "chart must separate HeavyTop (r-vartheta), got 'spherical'.",
    ),
    (
        lambda: fa.from_action_angles(fa.Body(fa.Harmonic()), [1, -1, 1, 1], [0] * 4, chart=fa.charts.SPHERICAL),
        ValueError,
        "J of r and lambda and mu must not be negative, got -1.0",
    ),
    (
        lambda: fa.quantum.spectrum(fa.Body(fa.Harmonic()), m=0, l=0, count=1, chart=fa.charts.SPHERICAL),
        ValueError,
        "chart must separate Harmonic in two coordinates (alpha-beta, r-vartheta, elliptic), got 'spherical'.",
    ),
    (
        lambda: fa.action_angles(HENON, Z4),
        TypeError,
        "model must be a separable Body, got HenonHeiles. Use fa.fit_torus for other systems.",
    ),
    (
        lambda: fa.action_angles(PLANE, Z4),
        TypeError,
        "model must be a separable Body, got the system. Use fa.fit_torus for other systems.",
    ),
    (
        lambda: fa.fit_torus(PLANE, Z4, time=50.0),
        ValueError,
        "z0 must be one phase point of shape (4,), got 2 orbits. Try z0[:, 0].",
    ),
    (
        lambda: fa.fit_torus(PLANE, Z4[:, 0], time=50.0, angles="phi R"),
        ValueError,
        "angles must be 'R phi' for x, y or 'R z phi' for x, y, z, got 'phi R'.",
    ),
    (
        lambda: fa.fit_torus(PLANE, Z4[:, 0], time=50.0, angles="R z phi"),
        ValueError,
        "angles must be of 2 coordinates, got 'R z phi' of 3. Use 'R phi'.",
    ),
    (
        lambda: fa.fit_torus(PLANE, Z4[:, 0], time=50.0, angles="R phi"),
        ValueError,
        (
            "model must be symmetric about the z axis for angles='R phi', got forces that depend on the azimuth. "
            "Leave angles out."
        ),
    ),
    (
        lambda: fa.tunes(np.ones((3, 4, 100))),
        ValueError,
        (
            "samples must have 2n rows q1, ..., qn, p1, ..., pn on the first axis, n up to 12, got shape (3, "
            "4, 100). Try samples.transpose(1, 0, 2)."
        ),
    ),
    (
        lambda: fa.quantum.spectrum(fa.Body(fa.Harmonic()), m=1, l=0, count=2),
        ValueError,
        "m + l must be even, got m = 1, l = 0. Use single_valued=False for functions on the double cover.",
    ),
    (
        lambda: fa.quantum.spectrum(fa.models.AffineBody(), m=0, l=0, count=2),
        TypeError,
        "model must be a Body, got an AffineBody. Use affine_spectrum(model, m=..., l=...) for its levels.",
    ),
    (
        lambda: fa.quantum.affine_spectrum(BODY, m=0, l=0),
        TypeError,
        "model must be an AffineBody, got Body. Use spectrum for other systems.",
    ),
    (
        lambda: fa.quantum.affine_spectrum(fa.models.AffineBody("both", A=0.5, B=-0.4), m=0, l=0),
        ValueError,
        "model must have I + A and I + A + 2 B positive, got 0.5 and -0.3",
    ),
    (
        lambda: fa.quantum.unitary_levels(k=1, j=1),
        ValueError,
        "k + 2 j must be even, got k = 1, j = 1. (a + 2 pi, -u) and (a, u) are the same matrix.",
    ),
    (
        lambda: fa.models.UnitaryBody(c=-1.5),
        ValueError,
        "c must be above -1, got -1.5. Elsewhere the metric of U(2) is not positive.",
    ),
    (
        lambda: fa.quantum.shear_factor(1.0, n=0, m=2, l=2),
        ValueError,
        "n must be below the 0 discrete levels of m = 2, l = 2, got 0",
    ),
    (
        lambda: fa.quantum.spectrum(PLANE, m=0, l=0, count=3),
        ValueError,
        "m is for a Body alone, the system takes none: got m = 0",
    ),
    (
        lambda: fa.quantum.all_levels(PLANE, max_energy=1.0),
        TypeError,
        (
            "model must be a Body with a doubly isotropic potential, got the system of 2 coordinates. Use "
            "spectrum(model, count=..., hbar=...) for one to 3 coordinates."
        ),
    ),
    (
        lambda: PLANE.energy(Z4),
        TypeError,
        "energy must be given 4 rows of the system, as model.energy(*z), got 1.",
    ),
    (
        lambda: HENON.energy(0.1, 0.0, 0.2),
        TypeError,
        "energy must be given 4 rows of HenonHeiles, as model.energy(*z), got 3.",
    ),
    (
        lambda: fa.NeoHookean(mu=1.0),
        TypeError,
        (
            "NeoHookean takes G and K, got mu=1.0. The shear modulus is G; mu is the inertia, "
            "fa.Body(fa.NeoHookean(G=1.0), mu=...)."
        ),
    ),
    (
        lambda: fa.models.NeoHookean3(mu=1.0),
        TypeError,
        (
            "NeoHookean3 takes G and K, got mu=1.0. The shear modulus is G; mu is the inertia, "
            "fa.models.Body3(..., mu=...)."
        ),
    ),
    (
        lambda: fa.Body(fa.NeoHookean(), friction=0.1),
        TypeError,
        (
            "Body takes potential and mu, got friction=0.1. For friction or a drive use hamiltonian(..., "
            "friction=0.1, drive_period=6.28) or ode(body, forces=...)."
        ),
    ),
    (
        lambda: fa.frequency_map(SPACE, [0.1] * 6, time=50.0, signals="R phi"),
        ValueError,
        (
            "signals must have 3 angles for the system, got 'R phi', of 2 Cartesian coordinates. Use 'R z "
            "phi', or leave signals out."
        ),
    ),
    (
        lambda: fa.frequency_map(PLANE, [0.1] * 4, time=50.0, signals="R z phi"),
        ValueError,
        (
            "signals must have 2 angles for the system, got 'R z phi', of 3 Cartesian coordinates. Use 'R "
            "phi', or leave signals out."
        ),
    ),
    (
        lambda: fa.frequency_map(SPACE, [0.1] * 6, time=50.0, signals="R phi z"),
        ValueError,
        (
            "signals must be 'R phi' for 2 coordinates, 'R z phi' for 3 coordinates, or an object of "
            "fastaff.models.angles, got 'R phi z'. Did you mean 'R z phi'?"
        ),
    ),
    (
        lambda: fa.frequency_map(SPACE, [0.1] * 6, time=50.0, signals="polar"),
        ValueError,
        (
            "signals must be 'R phi' for 2 coordinates, 'R z phi' for 3 coordinates, or an object of "
            "fastaff.models.angles, got 'polar'"
        ),
    ),
    (
        lambda: fa.explore(PLANE, energy=0.1, section="z=0"),
        ValueError,
        "section must be one of x=c, y=c, got 'z=0'. Use fa.Hyperplane(normal, offset) for other sections.",
    ),
    (
        lambda: fa.models.Body3(fa.NeoHookean()),
        TypeError,
        "potential must be a potential of 3x3 matrices such as fa.models.GasCloud(), got NeoHookean(G=1.0, K=2.0).",
    ),
    (
        lambda: fa.Body(fa.models.GasCloud()),
        TypeError,
        "potential must be a potential of A and B, got GasCloud. Use fa.models.Body3 for 3x3 matrices.",
    ),
    (
        lambda: fa.integrate(fa.models.SelfGravity(), np.ones(18), time=1.0),
        TypeError,
        "model SelfGravity(k=1.0) is a potential. Use fa.models.Body3(SelfGravity(...)).",
    ),
    (
        lambda: fa.models.formula3("D1 + 2*D2"),
        ValueError,
        "text must not change if D1, D2 and D3 are exchanged, got 'D1 + 2*D2'.",
    ),
    (
        lambda: fa.models.riemann_ellipsoid(STAR, 1.0),
        ValueError,
        "a3 must be given for a spheroid, a2 = 1, got None.",
    ),
    (
        lambda: fa.models.riemann_ellipsoid(STAR, 0.9, 3.0),
        ValueError,
        "a2 and a3 must be the axes of a steady ellipsoid, got 0.9 and 3.",
    ),
    (
        lambda: fa.models.reduced_body3(HENON),
        TypeError,
        "model must be a Body3, got HenonHeiles(lam=1.0) (HenonHeiles).",
    ),
    (
        lambda: fa.models.relative_equilibrium(STAR, [1, 1, -1], [0, 0, 1]),
        ValueError,
        "D must be positive and inside the domain of the potential, got [1, 1, -1].",
    ),
    (lambda: fa.show_progress("no"), TypeError, "shown must be True or False, got 'no' (str)"),
]
"""The call, the exception and the sentence."""
