"""The explorer of maps: iterates, readings and planes of its page against the package's."""

# ruff: noqa: E501 (lines of JavaScript)

import json

import numpy as np
import pytest
from page_engine import compute, crossings, explored, launch_message, needs_node, of, system_message

import fastaff as fa
from fastaff.explorer.explore import setup_of
from fastaff.explorer.parameters import parameter_values
from fastaff.explorer.records import model_code
from fastaff.explorer.setup import planes
from fastaff.systems.models import FroeschleMap, HenonMap, McMillanMap, OneTurnMap, StandardMap
from fastaff.systems.models.maps import jacobian
from fastaff.systems.models.mechanics import system_of

RNG = np.random.default_rng(1604)
CAT = fa.iterated_map("x1 = a*x + y; y1 = (a*b - 1)*x + b*y", periodic={"x": "w", "y": "w"}, a=2.0, b=1.0, w=1.0)
WALLED = fa.iterated_map("p1 = p + k*x*(1 - x**2); x1 = x + log(1 + p1)", domain="c - x**2", k=-0.3, c=1.5)
SWING = fa.iterated_map("J1 = J + e*T/(2*pi)*sin(2*pi*t/T); t1 = t + J1", periodic={"t": "T"}, e=0.9, T=3.5)


def drawn_maps():
    """Maps with parameters at random."""
    u = RNG.uniform
    return [
        StandardMap(u(0.4, 0.6)),
        HenonMap(u(0.19, 0.23)),
        McMillanMap(u(1.2, 1.8)),
        FroeschleMap(u(0.2, 0.4), u(0.2, 0.4), u(0.0, 0.02)),
        OneTurnMap(u(0.26, 0.29), u(0.3, 0.33), u(-0.5, 0.5)),
        SWING._replace(e=u(0.4, 0.6), T=u(3.0, 4.0)),
        WALLED._replace(k=u(-0.4, -0.2)),
    ]


def told(model, accuracy=1e-10):
    """The first message to the worker of a map."""
    message = system_message(model, accuracy)
    message["system"]["momenta"] = list(system_of(model).row_names[system_of(model).n :])
    return message


def plane_of(model, index=0, others=None, width=20, height=15):
    where = {
        "section": planes(system_of(model))[index],
        "others": others or {},
        "energy": None,
        "width": width,
        "height": height,
    }
    return {"type": "surface", **where}


def reduced(rows, model):
    """Rows (2n, ...) of states with those that have a period within half of one around 0."""
    out = np.array(rows, copy=True)
    for row, period in zip(out, model.periods(), strict=True):
        if period > 0:
            row[...] = np.mod(row + period / 2, period) - period / 2
    return out


def apart(one, other, model, rows):
    """Largest distance of points (2, ...), around the periods of their rows."""
    difference = np.abs(one - other)
    for entry, row in zip(difference, rows, strict=True):
        period = model.periods()[row]
        if period > 0:
            entry[...] = np.minimum(entry, period - entry)
    return difference.max()


@needs_node
def test_iterates_are_those_of_poincare_map():
    """All iterates of regular orbits, in every plane of a map; the start values of other rows are those given."""
    tasks, truth = [], []
    for model in drawn_maps():
        n = model.degrees_of_freedom
        for index in range(n):
            z0 = RNG.uniform(0.02, 0.12, 2 * n)
            z0 -= np.array(model.periods()) / 2  # of angles, about the elliptic point of a pendulum
            names = (*model.coordinates, *model.momenta)
            others = {name: z0[r] for r, name in enumerate(names) if r % n != index}
            tasks.append(
                (
                    model_code(system_of(model)),
                    [told(model), plane_of(model, index, others), launch_message(1, z0[[index, n + index]], 800)],
                )
            )
            truth.append((model, index, z0))
    for heard, (model, index, z0) in zip(explored(tasks), truth, strict=True):
        times, points = crossings(heard)
        n = model.degrees_of_freedom
        np.testing.assert_array_equal(of(heard, "launched")[0]["z0"], z0)
        result = fa.poincare_map(model, z0, crossings=800)
        assert result.counts[0] == 800
        np.testing.assert_array_equal(times, np.arange(1, 801))
        rows = [index, n + index]
        assert apart(points, reduced(result.points[:, :, 0], model)[rows], model, rows) < 1e-9
        (answer,) = of(heard, "surface")
        assert answer["axes"] == planes(system_of(model))[index].split(",")
        for value, row in zip(points, rows, strict=True):
            half = model.periods()[row] / 2
            assert half == 0 or ((value >= -half) & (value < half)).all()


@needs_node
def test_derivatives_and_images_are_pythons():
    models = [*drawn_maps(), CAT]
    asked, expected = [], []
    for model in models:
        z = RNG.uniform(-0.3, 0.3, (2 * model.degrees_of_freedom, 6))
        asked.append([model_code(system_of(model)), list(parameter_values(model).values()), z.T.tolist()])
        M = jacobian(model, z)
        expected.append(
            (
                np.array([np.broadcast_to(row, 6) for row in model.iterate(*z)]),
                M,
                model.periods(),
                model.margin(*z[: len(z) // 2]),
            )
        )
    found = compute(
        f"""{json.dumps(asked)}.map(([code, P, points]) => {{
          const system = new Function(systemText(code) + "return compiledSystem;")(), rows = 2*code.n;
          const out = (call) => {{ const a = new Float64Array(rows); call(a); return [...a]; }};
          return {{ periods: system.periods(P), points: points.map((z) => ({{
            image: out((a) => system.iterate(z, P, a)), margin: system.margin(z, P),
            columns: z.map((_, k) => out((a) => system.tangent(z, z.map((_, r) => Number(r === k)), P, a))),
          }})) }};
        }})""",
        "system.js",
    )
    for values, (image, M, periods, margin) in zip(found, expected, strict=True):
        np.testing.assert_array_equal(values["periods"], periods)
        for k, place in enumerate(values["points"]):
            np.testing.assert_allclose(place["image"], image[:, k], rtol=1e-14, atol=1e-15)
            np.testing.assert_allclose(np.array(place["columns"]).T, M[:, :, k], rtol=1e-14, atol=1e-14)
            assert place["margin"] == pytest.approx(np.broadcast_to(margin, 6)[k], rel=1e-14)


@needs_node
def test_readings_are_the_packages():
    """Indicators of chaos_map, rotation numbers and tunes of frequency_map; islands turn about their own centre."""
    golden = 2 * np.pi * (np.sqrt(5) - 1) / 2
    cases = [
        (StandardMap(0.5), [np.pi, golden], "regular"),
        (StandardMap(0.9), [np.pi + 0.4, 0.1], "regular"),
        (StandardMap(2.0), [0.2, 0.1], "chaotic"),
        (HenonMap(0.2114), [0.15, 0.05], "regular"),
        (SWING._replace(e=0.3), [1.6, 0.4], "regular"),
        (OneTurnMap(0.28, 0.31, -0.3), [0.1, 0.08, 0.02, 0.05], "regular"),
        (FroeschleMap(0.3, 0.2, 0.01), [3.0, 0.4, 1.9, 2.7], "regular"),
    ]
    tasks = []
    for model, z0, _ in cases:
        n, names = model.degrees_of_freedom, (*model.coordinates, *model.momenta)
        others = {name: z0[r] for r, name in enumerate(names) if r % n}
        tasks.append(
            (
                model_code(system_of(model)),
                [told(model), plane_of(model, 0, others), launch_message(1, [z0[0], z0[n]], 2400)],
            )
        )
    for heard, (model, z0, classification) in zip(explored(tasks), cases, strict=True):
        last = of(heard, "reading")[-1]
        assert (last["status"], last["crossings"], last["time"], last["classification"]) == (
            "done",
            2400,
            2400,
            classification,
        )
        chaos = fa.chaos_map(model, z0, time=2400, indicators=(fa.MEGNO(), fa.Lyapunov()))
        loose = 0.15 if classification == "chaotic" else 1e-6
        assert last["megno"] == pytest.approx(chaos.megno[0], rel=loose)
        assert last["lyapunov"] == pytest.approx(chaos.lyapunov[0], rel=loose)
        if classification == "chaotic":
            continue
        tunes, lines = fa.frequency_map(model, z0, time=2400), last["frequencies"]
        assert lines["names"] == list(model.coordinates)
        difference = np.abs(np.array(lines["values"]) - tunes.nu[:, 0])
        assert (np.minimum(difference, 1 - difference) <= np.array(lines["errors"]) + tunes.error[:, 0]).all()
        if model.degrees_of_freedom == 1 and model.periods()[0] == 0:
            _, points = crossings(heard)
            turning, own = fa.rotation_number(points), last["rotation"]
            about = abs(own["value"] - turning.rotation[0]) <= own["error"] + turning.error[0]
            turns = (
                np.mod(np.array([1, -1]) * own["value"] - tunes.nu[0, 0] + 0.5, 1) - 0.5
            )  # of a curve beside its mean
            assert about or np.abs(turns).min() <= own["error"] + tunes.error[0, 0]
        else:
            assert last["rotation"]["value"] == lines["values"][0]
            if model.degrees_of_freedom == 1:
                assert lines["values"][0] == pytest.approx(tunes.nu[0, 0], abs=1e-11)


@needs_node
def test_islands_turn_about_their_own_centre():
    """An elliptic fixed point of the standard map turns by arccos(1 - K/2)/2 pi an iterate, one of period 2 by its residue."""
    K = 0.8
    model = StandardMap(K)
    orbit = fa.periodic_orbits(model, [np.pi, np.pi], crossings=2)
    half = np.arcsin(np.sqrt(orbit.residue[0])) / np.pi  # R = sin^2(pi nu): Greene 1979
    starts = [([np.pi + 1e-3, 0.0], 1, np.arccos(1 - K / 2) / (2 * np.pi)), (orbit.z[:, 0] + [1e-3, 0.0], 2, half)]
    tasks = [
        (model_code(system_of(model)), [told(model), plane_of(model), launch_message(1, z0, 3000)]) for z0, *_ in starts
    ]
    for heard, (_, q, turns) in zip(explored(tasks), starts, strict=True):
        rotation = of(heard, "reading")[-1]["rotation"]
        assert rotation["q"] == q
        assert abs(rotation["secondary"]["value"]) == pytest.approx(turns, abs=1e-6)
    # Beside another angle: those of two standard maps that are not coupled.
    both = FroeschleMap(K, 0.3, 0.0)
    others = {"x_2": 2.0, "p_2": 0.7}
    (heard,) = explored(
        [(model_code(system_of(both)), [told(both), plane_of(both, 0, others), launch_message(1, starts[0][0], 3000)])]
    )
    rotation = of(heard, "reading")[-1]["rotation"]
    assert rotation["q"] == 1
    assert abs(rotation["secondary"]["value"]) == pytest.approx(starts[0][2], abs=1e-6)
    # A chain of a map without angles: 1/5 of Henon's.
    henon, z0 = HenonMap(0.2114), [0.62, 0.0]
    (heard,) = explored([(model_code(system_of(henon)), [told(henon), plane_of(henon), launch_message(1, z0, 3000)])])
    rotation, chain = of(heard, "reading")[-1]["rotation"], fa.islands(fa.poincare_map(henon, z0, crossings=3000))
    assert (rotation["q"], chain.q[0]) == (5, 5)
    assert abs(rotation["secondary"]["value"]) == pytest.approx(abs(chain.secondary_rotation[0]), abs=1e-6)


@needs_node
def test_orbits_that_leave_keep_what_is_known():
    cases = [
        (HenonMap(0.2114), [0.9, 0.3]),
        (OneTurnMap(0.28, 0.31, -0.3, 2.0), [0.9, 0.2, 0.1, 0.1]),
        (WALLED, [0.9, 0.4]),
    ]
    tasks = []
    for model, z0 in cases:
        n, names = model.degrees_of_freedom, (*model.coordinates, *model.momenta)
        others = {name: z0[r] for r, name in enumerate(names) if r % n}
        tasks.append(
            (
                model_code(system_of(model)),
                [
                    told(model),
                    plane_of(model, 0, others),
                    launch_message(1, [z0[0], z0[n]], 5000),
                    launch_message(2, [0.05, 0.02], 50),
                ],
            )
        )
    for heard, (model, z0) in zip(explored(tasks), cases, strict=True):
        chaos = fa.chaos_map(model, z0, time=5000)
        status = {fa.Status.ESCAPED: "escaped", fa.Status.NONFINITE: "escaped", fa.Status.LOST: "lost"}
        last, survived = of(heard, "reading", 1)[-1], int(chaos.t[0]) - 1
        assert 0 < survived < 4999
        assert (last["status"], last["crossings"]) == (status[fa.Status(chaos.status[0])], survived)
        _, points = crossings(heard)
        assert points.shape == (2, survived)
        beyond = ~np.isfinite(points.astype(float)).all(axis=0)  # what the page's numbers of four bytes do not hold
        assert (np.flatnonzero(beyond) >= survived - 3).all()
        assert last["classification"] == "undecided"
        assert of(heard, "reading", 2)[-1]["status"] == "done"
        (answer,) = of(heard, "surface")
        u0, u1, v0, v1 = answer["extent"]
        u, v = u0 + (u1 - u0) * (np.arange(20) + 0.5) / 20, v0 + (v1 - v0) * (np.arange(15) + 0.5) / 15
        grid = np.array(answer["allowed"]).reshape(15, 20).T
        rest = [z0[r] for r in range(1, model.degrees_of_freedom)]
        inside = np.broadcast_to(model.margin(u[:, None], *rest) > 0, grid.shape)
        np.testing.assert_array_equal(grid == 1, inside & (v > -np.inf))
        assert answer["open"] is bool(inside.all())


@needs_node
def test_whole_planes_hold_what_stays():
    """A page begins with whole periods of angles and turns, or with a frame around orbits that stay."""
    models = [StandardMap(0.9), HenonMap(0.2114), McMillanMap(1.6), OneTurnMap(0.28, 0.31), CAT, SWING]
    models += [fa.iterated_map("x1 = x + s*p; p1 = p - x1/s*(1 - x1/(s*s))", s=10.0**k) for k in (-4, 0, 3)]
    found = explored([(model_code(system_of(m)), [told(m), plane_of(m)]) for m in models])
    extents = [of(heard, "surface")[0]["extent"] for heard in found]
    np.testing.assert_allclose(extents[0], [-np.pi, np.pi, -np.pi, np.pi])
    np.testing.assert_allclose(extents[4], [-0.5, 0.5, -0.5, 0.5])
    np.testing.assert_allclose(extents[5], [-1.75, 1.75, -1.75, 1.75])  # its coordinate is J
    for model, extent in list(zip(models, extents, strict=True))[1:4]:
        half = np.abs(extent).max()
        assert 0.3 < half < 10, type(model)
    # Another unit of length is another frame and nothing else; this map has its x in s, its p without a unit.
    assert all(np.isfinite(extent).all() and extent[0] < 0 < extent[1] for extent in extents[6:])


@needs_node
def test_wrong_messages_have_answers():
    model = FroeschleMap()
    messages = [
        told(model),
        launch_message(1, (0.1, 0.2), 10),
        {**plane_of(model), "section": "x_1,p_2"},
        {**plane_of(model), "others": {"x_2": None}},
        {**plane_of(model), "others": {"x_2": "1"}},
        plane_of(model),
        {"type": "region", "width": 8, "height": 8},
        launch_message(2, (0.1, 0.2), 10),
        {"type": "motion", "orbit": 2, "from": 0, "to": 1, "samples": 4},
    ]
    (heard,) = explored([(model_code(system_of(model)), messages)])
    said = [m["message"] for m in heard if m["type"] in ("wrong", "refused")]
    assert [text[:30] for text in said] == [
        "there is no section yet",
        "the plane must be one of x_1,p",
        "x_2 must be a finite number, g",
        "a map has no motion between it",
    ]
    assert of(heard, "launched")[0]["orbit"] == 2


def test_what_a_map_does_not_have_is_refused(tmp_path):
    out = tmp_path / "x.html"
    grid = fa.energy_grid(StandardMap(), axes={"p": [0.0, 1.0], "x": [0.0, 1.0]})
    chaos = fa.chaos_map(StandardMap(), grid, time=64)
    for given, said in (
        ({"energy": 1.0}, "energy is not supported for maps"),
        ({"section": "x=0"}, "section is not supported for maps"),
        ({"scheme": "KAHAN_LI8"}, "scheme is not supported for maps"),
        ({"accuracy": 1e-8}, "accuracy is not supported for maps"),
        ({"p_eta": 0.1}, "p_eta and p_gamma must be 0"),
        ({"fixed": {"x": 1.0}}, "outside of the plane"),
        ({"fixed": {"z": 1.0}}, "fixed must be one of x, p"),
        ({"background": (chaos, grid)}, "over a plane of the map, x,p"),
    ):
        with pytest.raises(ValueError, match=said):
            fa.explore(StandardMap(), out=out, **given)
    with pytest.raises(ValueError, match="fixed is supported for maps and ODE systems only, got"):
        fa.explore(fa.HenonHeiles(), energy=0.1, fixed={"x": 0.0}, out=out)
    with pytest.raises(TypeError, match="model must be a system without friction, got a system with friction"):
        fa.explore(fa.hamiltonian("x**2/2 + y**2/2", friction=0.1), energy=1.0, out=out)
    assert not out.exists()


def test_set_up_of_a_map():
    model = fa.iterated_map("p1 = p + K*sin(x); x1 = x + p1", periodic={"x": "2*pi"}, K=0.7)
    setup, chosen = setup_of(model, points=[[0.1, 1.0], [0.2, 0.3]])
    assert chosen is model
    own, start = setup["systems"][0], setup["start"]
    assert (own["name"], own["kind"], own["formula"]) == ("own", "map", model.formula)
    assert own["job"]["map"] == model.formula
    assert own["job"]["periodic"] == ["x=2*pi"]
    assert (start["section"], start["parameters"], start["energy"], start["others"]) == ("x,p", {"K": 0.7}, None, {})
    assert start["points"] == [[0.1, 0.2], [1.0, 0.3]]
    named, _ = setup_of(FroeschleMap(K_1=0.4), fixed={"x_2": 0.3})
    assert named["start"]["system"] == "froeschle-map"
    assert named["start"]["others"] == {"x_1": 0.0, "x_2": 0.3, "p_1": 0.0, "p_2": 0.0}
    bent, _ = setup_of(fa.iterated_map("x1 = 1 + y - a*x**2; y1 = b*x", a=1.4, b=0.3))
    assert "not symplectic" in bent["systems"][0]["formula"]
    assert "not symplectic" not in own["formula"]


def test_a_chaos_map_lies_under_a_plane():
    model = FroeschleMap(0.4)
    grid = fa.energy_grid(
        model, axes={"x_2": np.linspace(-3, 3, 7), "p_2": np.linspace(0.0, 1.0, 5)}, fixed={"x_1": 0.3}
    )
    chaos = fa.chaos_map(model, grid, time=100, indicators="megno")
    setup, _ = setup_of(model, background=(chaos, grid))
    of_map, start = setup["background"]["of"], setup["start"]
    assert of_map["section"] == start["section"] == "x_2,p_2"
    assert of_map["others"] == start["others"] == {"x_1": 0.3, "x_2": 0.0, "p_1": 0.0, "p_2": 0.0}
    np.testing.assert_allclose(setup["background"]["extent"], [-3.5, 3.5, -0.125, 1.125])


def answered(model, messages):
    """What the package answers to the messages of a notebook's page."""
    from fastaff.explorer.answers import Answers

    heard = []
    answers = Answers({"own": model}, heard.append)
    system = {"name": "own", "code": {}, "parameters": parameter_values(model)}
    for message in ({"type": "system", "system": system}, *messages):
        answers.receive(message)
    return heard


@needs_node
def test_the_package_answers_as_the_page_does():
    """What a notebook's widget talks to: planes, points and readings are those of the worker."""
    cases = [
        (StandardMap(0.9), [3.3, 0.1], {}),
        (StandardMap(0.5), [3.0, 2 * np.pi * 0.618 - 2 * np.pi], {}),
        (HenonMap(0.2114), [0.62, 0.0], {}),
        (HenonMap(0.2114), [0.9, 0.3], {}),
        (McMillanMap(1.6), [0.3, 0.1], {}),
        (OneTurnMap(0.28, 0.31, -0.3), [0.1, 0.02], {"y": 0.08, "p_y": 0.05}),
        (CAT, [0.3, 0.2], {}),
    ]
    messages = [[plane_of(model, 0, others), launch_message(1, z0, 1504)] for model, z0, others in cases]
    page = explored(
        [(model_code(system_of(model)), [told(model), *own]) for (model, *_), own in zip(cases, messages, strict=True)]
    )
    for (model, *_), own, theirs in zip(cases, messages, page, strict=True):
        heard = answered(model, own)
        assert [m["type"] for m in heard] == ["ready", "surface", "launched", "points", "reading"]
        for name in ("axes", "section", "periods", "open", "energy"):
            assert heard[1][name] == of(theirs, "surface")[0][name]
        np.testing.assert_allclose(heard[1]["extent"], of(theirs, "surface")[0]["extent"], rtol=0.05)
        mine, last = heard[-1], of(theirs, "reading")[-1]
        assert [mine[k] for k in ("status", "crossings", "classification")] == [
            last[k] for k in ("status", "crossings", "classification")
        ]
        assert list(heard[2]["point"]) == of(theirs, "launched")[0]["point"]
        if mine["classification"] != "regular":
            continue
        (_, points), (_, others) = crossings(heard), crossings(theirs)
        np.testing.assert_allclose(points, others, atol=1e-9)
        assert mine["megno"] == pytest.approx(last["megno"], rel=1e-6)
        one, other = mine["rotation"], last["rotation"]
        assert one["value"] == pytest.approx(other["value"], abs=max(one["error"], other["error"]) + 1e-12)
        assert one.get("q") == other.get("q")
        if "q" in one:
            assert one["secondary"]["value"] == pytest.approx(other["secondary"]["value"], abs=1e-9)


def test_the_package_names_what_a_map_lacks():
    heard = answered(
        WALLED,
        [
            launch_message(1, (0.1, 0.2), 10),
            {**plane_of(WALLED), "section": "p,x"},
            plane_of(WALLED),
            launch_message(2, (5.0, 0.2), 10),
            launch_message(3, (0.1, 0.02), 10),
            {"type": "motion", "orbit": 3, "from": 0, "to": 1, "samples": 4},
            {"type": "fill", "columns": 3, "rows": 3, "view": [-0.2, 0.2, -0.1, 0.1], "crossings": 5, "first": 10},
        ],
    )
    said = [m["message"] for m in heard if m["type"] in ("wrong", "refused")]
    assert [text[:31] for text in said] == [
        "there is no section yet",
        "the plane must be one of x,p, g",
        "x = 5, p = 0.2 is not in the do",
        "a map has no motion between its",
    ]
    assert [m["orbit"] for m in of(heard, "launched")] == [3, *range(10, 19)]


TYPED = [
    ("p1 = p + K*sin(x); x1 = x + p1", "x=2*pi", {"K": 0.7}),
    ("k = p + x**2; x' = x*cos(2*pi*nu) + k*sin(2*pi*nu)\np' = k*cos(2*pi*nu) - x*sin(2*pi*nu)", "", {"nu": 0.21}),
    ("x' = p; p' = -x + 2*m*p/(1 + p**2)", "", {"m": 1.5}),
    (
        "b1 = b*sin(x_1 + x_2); p_1' = p_1 + a*sin(x_1) + b1; p_2' = p_2 + c*sin(x_2) + b1; x_1' = x_1 + p_1'; x_2' = x_2 + p_2'",
        "x_1 = 2*pi; x_2 = 2*pi",
        {"a": 0.4, "b": 0.02, "c": 0.3},
    ),
    ("t1 = t + E; E1 = E + h*sin(2*pi*t1/T)*exp(-E**2/50)", "t=T", {"h": 0.2, "T": 2.5}),
    ("u1 = 1 + w - a*u**2; w1 = b*u", "", {"a": 1.4, "b": 0.3}),
]
"""Texts of maps, their angles, their parameters."""


def typed_periods(angles):
    return dict(part.replace(" ", "").split("=") for part in angles.split(";") if part) or None


@needs_node
def test_typed_maps_are_the_packages():
    """Statements, pairs of rows, derivatives and periods as the page reads them, against `iterated_map`."""
    texts = TYPED
    asked = [{"kind": "map", "formula": text, "periodic": angles, "parameters": own} for text, angles, own in texts]
    codes = compute(f"{json.dumps(asked)}.map(formulaCode)", "formula_code.js")
    tasks, cases = [], []
    for (text, angles, own), code in zip(texts, codes, strict=True):
        model = fa.iterated_map(text, periodic=typed_periods(angles), **own)
        assert (tuple(code["coordinates"]), tuple(code["momenta"])) == (model.coordinates, model.momenta)
        assert sorted(code["parameters"]) == sorted(own)
        n = model.degrees_of_freedom
        z0 = RNG.uniform(0.02, 0.1, 2 * n) + np.array(model.periods()) / 2
        names = (*model.coordinates, *model.momenta)
        others = {name: z0[r] for r, name in enumerate(names) if r % n}
        tasks.append((code, [told(model), plane_of(model, 0, others), launch_message(1, z0[[0, n]], 304)]))
        cases.append((model, z0))
    for heard, (model, z0) in zip(explored(tasks), cases, strict=True):
        assert not of(heard, "wrong"), heard
        _, points = crossings(heard)
        n, result = model.degrees_of_freedom, fa.poincare_map(model, z0, crossings=304)
        rows, count = [0, n], 304 if model.symplectic else 40
        exact = reduced(result.points[:, :, 0], model)[rows]
        assert apart(points[:, :count], exact[:, :count], model, rows) < (1e-9 if model.symplectic else 1e-6)
        if model.symplectic:
            chaos = fa.chaos_map(model, z0, time=304, indicators=(fa.MEGNO(), fa.Lyapunov()))
            last = of(heard, "reading")[-1]
            assert last["megno"] == pytest.approx(chaos.megno[0], rel=1e-5, abs=1e-7)
            assert last["lyapunov"] == pytest.approx(chaos.lyapunov[0], rel=1e-5, abs=1e-7)


@needs_node
def test_texts_that_are_no_maps_are_refused_by_both():
    """What the page refuses the package refuses, and the other way round."""
    texts = [
        *(
            "x1 = x",
            "x1 = r*x*(1 - x)",
            "x1 = y; y1 = x; z1 = x",
            "x + 1",
            "x1 = ; p1 = 2",
            "x1 = p1; p1 = x",
            "x1 = p; x1 = x; p1 = x",
        ),
        *("x = p; p1 = x; x1 = p", "x1 = sin(p; p1 = x"),
    ]
    texts += [
        *("x1 = sqrt(-1 - x**2); p1 = p", "x1 = x[0]; p1 = p", "x1 = p; p1 = fetch(x)", "count1 = p; p1 = 2*count"),
        *("x1 = kind*p; p1 = x", "x1 = iterate*p; p1 = x", "x1 = symplectic*p; p1 = x", "x1 = p\np1 = -x"),
        "a = 2; x1 = a*p; p1 = -x/a",
    ]
    texts += [
        *("", ";", "x1 = x + p1; p1 = p", "x' = p; p' = -x", "x' = p'; p' = -x", "sin1 = p; p1 = x"),
        *("x1 = constructor(p); p1 = x", "x1 == p; p1 = x"),
    ]
    found = compute(
        f"""{json.dumps(texts)}.map((formula) => {{
          try {{ return formulaCode({{ kind: "map", formula, periodic: "" }}).parameters; }} catch (problem) {{ return problem.message; }}
        }})""",
        "formula_code.js",
    )
    refused = 0
    for text, answer in zip(texts, found, strict=True):
        try:
            fa.iterated_map(text, **dict.fromkeys(answer if isinstance(answer, list) else (), 1.0))
            said = None
        except ValueError as problem:
            said = str(problem)
        assert (said is not None) == isinstance(answer, str), (text, said, answer)
        refused += said is not None
    assert 12 < refused < len(texts)
    wrong = compute(
        """["y=1", "x", "x=-1", "x=p"].map((periodic) => {
          try { return formulaCode({ kind: "map", formula: "x1 = p; p1 = -x", periodic }).winds; } catch (problem) { return problem.message; }
        })""",
        "formula_code.js",
    )
    assert [isinstance(entry, str) for entry in wrong] == [
        True,
        True,
        False,
        True,
    ]  # a period below 0 is named with the plane


def test_the_package_takes_typed_maps():
    heard = answered(
        StandardMap(),
        [{"type": "parse", "kind": "map", "formula": "p1 = p + K*sin(x); x1 = x + p1", "periodic": "x=T"}],
    )
    assert (heard[-1]["names"], heard[-1]["message"]) == (["K", "T"], None)
    system = {
        "kind": "map",
        "formula": "p1 = p + K*sin(x); x1 = x + p1",
        "periodic": "x=T",
        "parameters": {"K": 0.4, "T": 2 * np.pi},
    }
    heard = answered(
        StandardMap(),
        [{"type": "system", "system": system}, {"type": "surface", "section": "x,p", "width": 4, "height": 4}],
    )
    assert heard[-1]["type"] == "surface"
    assert heard[-1]["periods"] == [2 * np.pi, 0.0]
    heard = answered(StandardMap(), [{"type": "parse", "kind": "map", "formula": "p1 = p +", "periodic": ""}])
    assert heard[-1]["message"] is not None
