"""The explorer of H(q, p), of driven systems and of flows as they are typed: the page's engine beside the package."""

# ruff: noqa: E501 (lines of JavaScript)

import json

import numpy as np
import pytest
from page_engine import (
    BCE8,
    compute,
    crossings,
    explored,
    launch_message,
    needs_node,
    of,
    surface_message,
    system_message,
)

import fastaff as fa
from fastaff.explorer.explore import setup_of
from fastaff.explorer.records import model_code
from fastaff.explorer.setup import scheme_record
from fastaff.runs.schemes import DOP853, GAUSS8, GAUSS16
from fastaff.systems.models.mechanics import system_of
from fastaff.systems.models.sections import Stroboscopic

RNG = np.random.default_rng(3204)
DOUBLE = "(p1**2 + 2*p2**2 - 2*p1*p2*cos(q1 - q2))/(2*m*(1 + sin(q1 - q2)**2)) - 2*g*cos(q1) - g*cos(q2)"
TURNS = {"q1": "2*pi", "q2": "2*pi"}
FAST = "sqrt(1 + px**2 + b*py**2) + (x**2 + y**2)/2 + x**2*y/4"  # of no degree in the momenta
TURNING = "(px**2 + py**2)/2 - w*(x*py - y*px) + (x**2 + y**2)/2 + x**2*y/3"
CURVED = "(px**2*(1 + x**2) + py**2)/2 + a*x*py + (x**2 + y**2)/2 + x**2*y/5"


def typed(*given):
    """The records that the page makes of what is typed."""
    return compute(f"{json.dumps(list(given))}.map(formulaCode)", "formula_code.js")


def told(code, model, scheme=GAUSS8, accuracy=1e-11):
    """The first message to the worker of a system of rates."""
    message, rows = system_message(model, accuracy, scheme), system_of(model).row_names
    message["system"] |= {"coordinates": code.get("coordinates", list(model.coordinates))}
    message["system"]["momenta"] = code.get("momenta", list(rows[2:4]))
    message["frame"] = [0.6, 0.8, 0.0, 0.1] + [0.3] * 12
    return message


def systems():
    """H(q, p) with parameters at random: what is typed, the model, its section, an energy, and a point."""
    m, g, b, a = RNG.uniform(0.8, 1.3, 4)
    for text, names, momenta, periods, own, section, energy, point in (
        (DOUBLE, "q1 q2", "p1 p2", TURNS, {"m": m, "g": g}, "q1=0", -1.9 * g, (0.2, 0.1)),
        (DOUBLE, "q1 q2", "p1 p2", TURNS, {"m": m, "g": g}, "q2=0.3", -1.8 * g, (0.2, 0.3)),
        (FAST, "x y", "px py", {}, {"b": b}, "x=0", 1.4, (0.2, 0.1)),
        (CURVED, "x y", "px py", {}, {"a": 0.3 * a}, "y=0.05", 0.2, (0.1, 0.2)),
        (TURNING, "x y", "px py", {}, {"w": 0.4 * a}, "x=0", 0.2, (0.1, 0.2)),
    ):
        model = fa.hamiltonian(text, coordinates=names, momenta=momenta, periodic=periods or None, **own)
        angles = ", ".join(f"{name}={period}" for name, period in periods.items())
        given = {"kind": "plane", "formula": text, "coordinates": names, "momenta": momenta, "periodic": angles}
        yield given | {"parameters": own}, model, section, energy, point


@needs_node
def test_h_of_q_and_p_moves_as_the_package_moves_it():
    """Launches by a root of the momentum and crossings: of typed records and of those printed from Python."""
    cases = list(systems())
    tasks, followed = [], []
    for code, (_, model, text, energy, point) in zip(typed(*(given for given, *_ in cases)), cases, strict=True):
        for record, scheme in ((code, GAUSS8), (model_code(system_of(model)), GAUSS16)):
            section = fa.formulas.section_text.section_named(text, system_of(model))
            where = surface_message(model, section, energy)
            tasks.append((record, [told(code, model, scheme), where, launch_message(1, point, 12)]))
            followed.append((model, section, energy, point))
    for heard, (model, section, energy, point) in zip(explored(tasks), followed, strict=True):
        assert not of(heard, "wrong"), of(heard, "wrong")
        grid = fa.energy_grid(model, energy=energy, section=section, axes=([point[0]], [point[1]]))
        launched = np.array(of(heard, "launched")[0]["z0"])
        np.testing.assert_allclose(launched, grid.z0[:, 0], rtol=0, atol=1e-13)
        found = fa.poincare_map(model, launched, section=section, crossings=12, max_time=400.0, accuracy=1e-11)
        times, points = crossings(heard)
        sure = found.times[:, 0] <= found.accurate_until[0]
        assert sure.sum() >= 3
        other = 1 - int(np.flatnonzero(section.normal)[0])
        seen = system_of(model).turned_back(found.points[:, :, 0].copy())[[other, 2 + other]]
        np.testing.assert_allclose(times[:12][sure], found.times[sure, 0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(points[:, :12][:, sure], seen[:, sure], rtol=0, atol=1e-9)
        assert of(heard, "reading")[-1]["energy_error"] < 1e-10


@needs_node
def test_the_page_of_a_frame_that_turns_saves_its_job():
    """A field and a rotation beside V, one of them moved by its slider."""
    w, b = RNG.uniform(0.1, 0.3, 2)
    model = fa.hamiltonian("x**2/2 + y**2 + x**2*y/3", rotation=w, magnetic="2*b", b=b)
    setup, _ = setup_of(model, energy=0.2, section="x=0")
    record, start = setup["systems"][0], {**setup["start"], "crossings": 5, "parameters": {"rotation": 2 * w, "b": b}}
    assert setup["start"]["scheme"] == "GAUSS16"
    text = compute(f"jobText({json.dumps(start)}, {json.dumps(record)}, [])", "saving.js")
    job = fa.Job.parsed(text.replace("[initial_conditions]", "[initial_conditions]\norbits = 3"))
    assert job.model.build() == fa.hamiltonian("x**2/2 + y**2 + x**2*y/3", rotation=2 * w, magnetic="2*b", b=b)


@needs_node
def test_bounds_of_the_surface_and_what_reaches_nothing():
    """The least energy, that of escape, the region in angles from -pi to pi, and a momentum's outermost root."""
    m, g = RNG.uniform(0.8, 1.3, 2)
    double = {
        "kind": "plane",
        "formula": DOUBLE,
        "coordinates": "q1 q2",
        "momenta": "p1 p2",
        "periodic": "q1=2*pi, q2=2*pi",
    }
    code, fast, curved = typed(
        double | {"parameters": {"m": m, "g": g}},
        {"kind": "plane", "formula": FAST, "coordinates": "x y", "momenta": "px py", "parameters": {"b": 1.2}},
        {"kind": "plane", "formula": CURVED, "coordinates": "x y", "momenta": "px py", "parameters": {"a": 0.2}},
    )
    model = fa.hamiltonian(DOUBLE, coordinates="q1 q2", momenta="p1 p2", periodic=TURNS, m=m, g=g)
    first = told(code, model)
    where = {"type": "surface", "section": "q1=c", "constant": 0.0, "direction": 1, "width": 60, "height": 60}
    quick = told(fast, model)
    quick["system"] |= {"coordinates": ["x", "y"], "momenta": ["px", "py"], "parameters": {"b": 1.2, "a": 0.2}}
    heard, none, other, last = explored(
        [
            (code, [first, where | {"energy": -2.2 * g}]),
            (code, [first, where | {"energy": -3.1 * g}]),
            (fast, [quick, where | {"energy": 1.3, "section": "x=c"}]),
            (curved, [quick, where | {"energy": 0.1, "section": "x=c"}]),
        ]
    )
    (shown,) = of(heard, "surface")
    assert shown["minimum"] == pytest.approx(-3 * g, rel=1e-12)
    assert shown["extent"][:2] == pytest.approx([-np.pi, np.pi], rel=1e-15)
    assert shown["extent"][3] == pytest.approx(
        np.sqrt(2 * 0.8 * g * m), rel=0.1
    )  # at q = 0, where p1 = p2 = sqrt(2 m T)
    assert f"{-3 * g:.6g}"[:6] in of(none, "wrong")[0]["message"]
    assert of(other, "surface")[0]["minimum"] == pytest.approx(1.0, rel=1e-12)
    # H = 1.3 at x = 0: y**2/2 = 0.3 at rest, and 1.2 py**2 = 1.3**2 - 1
    assert of(other, "surface")[0]["extent"][1::2] == pytest.approx([np.sqrt(0.6), np.sqrt(0.69 / 1.2)], rel=0.07)
    assert of(last, "surface")[0]["extent"][1::2] == pytest.approx([np.sqrt(0.2), np.sqrt(0.2)], rel=0.07)


@needs_node
def test_a_view_through_a_pole_keeps_its_walls():
    """The restricted three-body problem in a turning frame, and -k/r: walls where momenta are 0, views of usual momenta."""
    mass, k = RNG.uniform(0.005, 0.02), RNG.uniform(0.5, 2.0)
    moon = "(px^2 + py^2)/2 - (x*py - y*px) - (1 - m)/sqrt((x + m)^2 + y^2) - m/sqrt((x - 1 + m)^2 + y^2)"
    given = {"kind": "plane", "coordinates": "x y", "momenta": "px py", "periodic": ""}
    turning = given | {"formula": moon, "parameters": {"m": mass}}
    still = given | {"formula": "-k/sqrt(x^2 + y^2)", "momenta": "", "parameters": {"k": k}}
    model = fa.hamiltonian("(px**2 + py**2*(1 + x**2))/2 + k*m*x", coordinates="x y", momenta="px py", k=k, m=mass)
    codes, first = typed(turning, still), told({"momenta": ["px", "py"]}, model)
    first["system"]["parameters"] = {"m": mass, "k": k}
    where = {"type": "surface", "constant": 0.0, "direction": 1, "width": 40, "height": 30}
    energies = (-1.62, -0.5 * k, 0.1 * k)
    told_of = [
        (codes[0], [first, where | {"section": "y=c", "energy": energies[0]}]),
        *(
            (codes[1], [first | {"scheme": scheme_record(BCE8)}, where | {"section": "x=c", "energy": E}])
            for E in energies[1:]
        ),
    ]
    turned, bound, free = (of(heard, "surface")[0]["extent"] for heard in explored(told_of))
    x = np.linspace(-0.9, 0.9, 200001)
    rest = energies[0] + (1 - mass) / np.abs(x + mass) + mass / np.abs(x - 1 + mass) + x**2 / 2
    walls = x[(rest > 0) & (x < 0.84)][[0, -1]]
    assert 1.15 * walls[0] < turned[0] < walls[0]
    assert turned[1] > walls[1]
    np.testing.assert_allclose(bound, [-2.12, 2.12, *np.sqrt(9 * k) * np.array([-1.03, 1.03])], rtol=0.02)
    assert 1 < turned[3] < 10
    assert 2 < free[1] < 50
    assert free[3] < 10


def driven():
    """Driven systems with parameters at random: typed, the model, its starts."""
    a, w, g = RNG.uniform(0.05, 0.2), RNG.uniform(0.9, 1.3), RNG.uniform(0.1, 0.3)
    own, period = {"a": a, "w": w}, "2*pi/w"
    common = {"kind": "plane", "coordinates": "x", "drive_period": period, "parameters": own}
    text, whole = "-cos(x) - a*x*cos(w*t)", "p**2/(2 + a*sin(w*t)**2) + x**4/4 + a*x*p*cos(w*t)"
    yield (
        common | {"formula": text, "periodic": "x=2*pi"},
        fa.hamiltonian(text, coordinates="x", drive_period=period, **own),
    )
    yield (
        common | {"formula": whole, "momenta": "p"},
        fa.hamiltonian(whole, coordinates="x", momenta="p", drive_period=period, **own),
    )
    flow = "x' = p; p' = -sin(x) - g*p + a*cos(w*t)"
    timed = "x' = p; t' = 1; p' = -sin(x) - g*p + a*cos(w*t)"
    own = own | {"g": g}
    yield common | {"kind": "ode", "formula": flow, "parameters": own, "periodic": "x=2*pi"}, fa.ode(timed, **own)


@needs_node
def test_driven_systems_as_they_are_typed():
    """States once a period of V(x, t), of H(x, p, t) and of equations with friction; the second printed from Python too."""
    cases, phase, count = list(driven()), 0.4, 12
    codes = typed(*(given for given, _ in cases))
    plans = [(code, *case) for code, case in zip(codes, cases, strict=True)]
    plans.append((model_code(system_of(cases[1][1])), *cases[1]))
    tasks = []
    for code, given, model in plans:
        scheme = scheme_record(GAUSS16)
        system = {"parameters": dict(given["parameters"]), "coordinates": ["x"], "momenta": code.get("momenta", ["p"])}
        first = {"type": "system", "system": system, "accuracy": 1e-11, "scheme": scheme, "frame": [0.6, 0.8]}
        if "period" in code["parameters"]:
            system["parameters"]["period"] = float(model.period)
        plane = {
            "type": "surface",
            "section": f"x,{system['momenta'][0]}",
            "energy": None,
            "phase": phase,
            "width": 20,
            "height": 20,
        }
        tasks.append((code, [first, plane, launch_message(1, (0.4, 0.3), count)]))
    for heard, (_, given, model) in zip(explored(tasks), plans, strict=True):
        assert not of(heard, "wrong"), of(heard, "wrong")
        _, points = crossings(heard)
        own = given["parameters"]
        if given["kind"] == "ode":
            period = 2 * np.pi / own["w"]
            run = fa.integrate(
                model, [0.4, phase, 0.3], time=count * period, samples=count, scheme=DOP853, rtol=1e-13, atol=1e-13
            )
            exact = run.samples[1:, [0, 2], 0].T if len(run.samples) > count else run.samples[:, [0, 2], 0].T
        else:
            found = fa.poincare_map(
                model, [0.4, phase, 0.3, 0.0], section=Stroboscopic(phase), crossings=count, accuracy=1e-12
            )
            exact = found.points[[0, 2], :, 0]
        if given.get("periodic"):
            exact[0] = (exact[0] + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(points, exact, rtol=0, atol=1e-9)
        (shown,) = of(heard, "surface")
        assert shown["periods"] == ([2 * np.pi, 0] if given.get("periodic") else [0, 0])
        assert not given.get("periodic") or shown["extent"][:2] == [-np.pi, np.pi]


@needs_node
def test_flows_as_they_are_typed():
    """Sections of Lorenz's and Roessler's equations, their exponent, and how far the first view reaches."""
    r, c = RNG.uniform(26.0, 30.0), RNG.uniform(5.0, 6.0)
    lorenz = "x' = s*(y - x); dy/dt = x*(r - z) - y; z' = x*y - b*z"
    cases = [
        (lorenz, {"s": 10.0, "r": r, "b": 8 / 3}, "z", r - 1, (4.0, 5.0), 1),
        ("x' = -y - z\ny' = x + a*y\nz' = b + z*(x - c)", {"a": 0.2, "b": 0.2, "c": c}, "y", 0.0, (4.0, 0.1), -1),
    ]
    tasks = []
    codes = typed(*({"kind": "ode", "formula": text, "parameters": own} for text, own, *_ in cases))
    for code, (text, own, name, constant, point, direction) in zip(codes, cases, strict=True):
        model = fa.ode(text, **own)
        for record in (code, model_code(system_of(model))):
            first = {"type": "system", "system": {"parameters": own, "coordinates": ["x", "y", "z"], "momenta": []}}
            first |= {"accuracy": 1e-11, "scheme": scheme_record(GAUSS16), "frame": [0.6, 0.8, 0.1]}
            where = {
                "type": "surface",
                "energy": None,
                "section": f"{name}=c",
                "constant": constant,
                "direction": direction,
            }
            tasks.append((record, [first, where | {"width": 10, "height": 10}, launch_message(1, point, 250)]))
    for k, heard in enumerate(explored(tasks)):
        text, own, name, constant, point, direction = cases[k // 2]
        assert not of(heard, "wrong"), of(heard, "wrong")
        model, row = fa.ode(text, **own), "xyz".index(name)
        kept = [i for i in range(3) if i != row]
        z0 = np.insert(np.array(point), row, constant)
        section = fa.Hyperplane(tuple(float(i == row) for i in range(3)), constant, direction)
        found = fa.poincare_map(
            model, z0, section=section, crossings=8, max_time=80.0, scheme=DOP853, rtol=1e-13, atol=1e-13
        )
        times, points = crossings(heard)
        np.testing.assert_allclose(times[:3], found.times[:3, 0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(points[:, :3], found.points[kept, :3, 0], rtol=0, atol=1e-8)
        last = of(heard, "reading")[-1]
        assert last["energy_error"] is None
        assert last["frequencies"] is None
        chaos = fa.chaos_map(model, z0, time=last["time"], indicators="lyapunov")
        assert last["lyapunov"] == pytest.approx(chaos.lyapunov[0], rel=0.2, abs=0.02)
        (shown,) = of(heard, "surface")
        u0, u1, v0, v1 = shown["extent"]
        inside = (u0 < points[0]) & (points[0] < u1) & (v0 < points[1]) & (points[1] < v1)
        assert inside[20:].mean() > 0.9
        assert (u1 - u0) < 3 * np.ptp(points[0, 20:])


@needs_node
def test_what_is_no_system_of_rates_is_said():
    """Sentences for missing and doubled names, a time without a period, equations without a section."""
    cases = [
        ({"kind": "plane", "formula": "p1**2 + q1**2", "coordinates": "q1 q2", "momenta": "p1"}, "momenta must be 2"),
        ({"kind": "plane", "formula": "p1**2 + q1**2", "coordinates": "q1 q2", "momenta": "p1 q1"}, "taken"),
        ({"kind": "plane", "formula": "cos(x)*t", "coordinates": "x y", "drive_period": "2"}, "coordinates must be 1"),
        ({"kind": "ode", "formula": "x' = y; y' = -x"}, "3 to 16"),
        ({"kind": "ode", "formula": "x' = y; y' = -x; z' = cos(t)"}, "period of the drive"),
        ({"kind": "plane", "formula": "x^4/4 - f*x*cos(w*t)", "coordinates": "x y"}, "period of the drive"),
        ({"kind": "body", "formula": "D1 + t*D2"}, "period of the drive"),
        ({"kind": "plane", "formula": "x^2 + t^2", "coordinates": "x t"}, ""),
        ({"kind": "ode", "formula": "x = y"}, "equations must be"),
        ({"kind": "ode", "formula": "x' = y; x' = -x; z' = 1"}, "taken"),
        ({"kind": "ode", "formula": "x' = sqrt(-1 - x**2); y' = y; z' = z"}, "finite and real"),
        (
            {"kind": "plane", "formula": "p1*q1+p2*q2", "coordinates": "q1 q2", "momenta": "p1 p2", "periodic": "w=2"},
            "periodic must be",
        ),
    ]
    asked = json.dumps([given for given, _ in cases])
    said = compute(
        f"{asked}.map((given) => {{ try {{ formulaCode(given); return ''; }} catch (e) {{ return e.message; }} }})",
        "formula_code.js",
    )
    for (_, expected), sentence in zip(cases, said, strict=True):
        assert expected in sentence if expected else not sentence
