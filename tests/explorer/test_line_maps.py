"""The explorer of maps of one variable: iterates, exponents, bifurcation diagrams and the page against the package."""

# ruff: noqa: E501 (lines of JavaScript)

import json

import numpy as np
import pytest
from page_engine import compute, crossings, explored, launch_message, needs_node, of, system_message
from test_page import Sheet

import fastaff as fa
from fastaff.explorer.explore import setup_of
from fastaff.explorer.records import model_code
from fastaff.systems.models.mechanics import system_of

LOGISTIC = fa.iterated_map("x1 = r*x*(1 - x)", r=3.7)
CIRCLE = fa.iterated_map("t1 = t + W - K*sin(t)", periodic={"t": "2*pi"}, W=1.3, K=0.6)
GAUSS = fa.iterated_map("x1 = exp(-a*x**2) + b", a=6.2, b=-0.5)


def plane_of(model, width=20, height=10):
    return {"type": "surface", "section": model.coordinates[0], "energy": None, "width": width, "height": height}


def launched(model, x0, iterates):
    """What a page hears of one orbit of a map of one variable."""
    told = system_message(model)
    told["system"]["momenta"] = []
    (heard,) = explored(
        [(model_code(system_of(model)), [told, plane_of(model), launch_message(1, (x0, 0.5), iterates)])]
    )
    assert not of(heard, "wrong"), heard
    return heard


@needs_node
@pytest.mark.parametrize("model", [LOGISTIC._replace(r=3.2), GAUSS._replace(b=-0.3), CIRCLE])
def test_points_are_iterates_and_their_images(model):
    """All of them on cycles and invariant circles, where rounding does not grow."""
    x0 = float(np.random.default_rng(52).uniform(0.1, 0.4))
    heard = launched(model, x0, 600)
    times, points = crossings(heard)
    np.testing.assert_array_equal(times, np.arange(1, 601))
    exact = np.concatenate([[x0], fa.poincare_map(model, [x0], crossings=600).points[0, :, 0]])
    (period,) = model.periods()
    exact = np.mod(exact + period / 2, period) - period / 2 if period else exact
    np.testing.assert_allclose(points, [exact[:-1], exact[1:]], atol=1e-10)
    surface = of(heard, "surface")[0]
    assert (surface["axes"], surface["periods"]) == ([model.coordinates[0], "image"], [period, period])
    graph = np.array(surface["graph"], dtype=float).reshape(-1, 2)
    known = graph[np.isfinite(graph[:, 1])]
    image = np.broadcast_to(model.iterate(known[:, 0])[0], len(known))
    away = image - known[:, 1]
    np.testing.assert_allclose(away - (period * np.rint(away / period) if period else 0), 0, atol=1e-12)
    assert len(known) > 3900


@needs_node
def test_exponents_are_those_of_closed_form_and_of_the_package():
    """ln 2 at r = 4; the mean logarithm of the slopes of a cycle of two; minus infinity on a superstable one."""
    last = of(launched(LOGISTIC._replace(r=4.0), 0.3, 20000), "reading")[-1]
    assert last["classification"] == "chaotic"
    assert last["lyapunov"] == pytest.approx(np.log(2), abs=0.01)
    r = 3.2
    last = of(launched(LOGISTIC._replace(r=r), 0.3, 4000), "reading")[-1]
    assert last["classification"] == "regular"
    assert last["lyapunov"] == pytest.approx(np.log(abs(4 + 2 * r - r * r)) / 2, abs=5e-3)  # the product of both slopes
    chaos = fa.chaos_map(LOGISTIC._replace(r=r), [0.3], time=4000, indicators=(fa.MEGNO(), fa.Lyapunov()))
    assert last["lyapunov"] == pytest.approx(chaos.lyapunov[0], rel=1e-9)
    assert last["megno"] == pytest.approx(chaos.megno[0], rel=1e-6)
    assert last["rotation"] is None
    steady = of(launched(LOGISTIC._replace(r=2.0), 0.5, 4000), "reading")[-1]
    assert (steady["classification"], steady["lyapunov"], steady["megno"]) == ("regular", None, None)


@needs_node
def test_an_angle_has_its_winding_number():
    last = of(launched(CIRCLE, 0.4, 8000), "reading")[-1]
    x = 0.4
    for _ in range(200_000):
        x += 1.3 - 0.6 * np.sin(x)
    exact = (x - 0.4) / (2 * np.pi * 200_000)
    assert abs(last["rotation"]["value"] - exact) <= last["rotation"]["error"] + 1.0 / 200_000
    assert last["rotation"]["error"] < 1e-6


@needs_node
def test_the_frame_holds_the_orbits_that_stay():
    """[0, 1] of the logistic map, in any unit; all of a period; what attracts where all stay."""
    unit = fa.iterated_map("x1 = r*x*(1 - x/s)", r=3.7, s=1.0)
    cases = [(unit._replace(s=s, r=r), (0.0, s)) for s in (1e-3, 1.0, 250.0) for r in (2.0, 3.7, 4.0)]
    for model, (low, high) in cases:
        extent = of(launched(model, 0.3 * high, 20), "surface")[0]["extent"]
        np.testing.assert_allclose(extent, [low, high, low, high], atol=0.02 * high)
    assert of(launched(CIRCLE, 0.1, 20), "surface")[0]["extent"] == pytest.approx([-np.pi, np.pi, -np.pi, np.pi])
    low, high, *_ = of(launched(GAUSS, 0.1, 20), "surface")[0]["extent"]
    orbit = fa.poincare_map(GAUSS, [0.1], crossings=2000).points[0, 100:, 0]
    assert low < orbit.min() < orbit.max() < high
    assert high - low < 3 * np.ptp(orbit)
    for text in ("x1 = 2*x", "x1 = x + 1", "x1 = x", "x1 = x/2 + 3"):
        low, high, *_ = of(launched(fa.iterated_map(text), 0.1, 20), "surface")[0]["extent"]
        assert -1000 < low < high < 1000


@needs_node
def test_diagrams_are_the_packages():
    """The iterates of chaos.bifurcation_diagram on cycles; the range from before the first bifurcation to the last orbit that stays, 4."""
    told = system_message(LOGISTIC)
    told["system"]["momenta"] = []
    asked = {"type": "bifurcations", "key": "k", "parameter": "r", "range": [0.37, 11.1], "columns": 40}
    asked |= {"start": 0.3, "transient": 1000, "kept": 64}
    wrong = {**asked, "parameter": "K"}
    outside = {**asked, "range": [5.0, 9.0]}
    (heard,) = explored(
        [
            (
                model_code(system_of(LOGISTIC)),
                [told, plane_of(LOGISTIC), asked, wrong, outside, launch_message(1, (0.3, 0.3), 5)],
            )
        ]
    )
    found, nothing = of(heard, "bifurcations")
    assert "parameter must be one of r, got K" in of(heard, "wrong")[0]["message"]
    assert nothing["from"] is None
    assert found["to"] == pytest.approx(4.0, abs=1e-3)  # just beyond it orbits stay for long
    assert 2.2 < found["from"] < 2.9
    values = np.array(found["values"])
    points = np.array(found["points"]).reshape(len(values), 64).T
    theirs = fa.chaos.bifurcation_diagram(LOGISTIC, "r", values, x0=0.3, transient=1000, iterates=64)
    calm = theirs.exponent < -0.05
    assert 15 < calm.sum() < 40
    np.testing.assert_allclose(points[:, calm], theirs.points[:, calm], atol=1e-9)
    chaotic = theirs.exponent > 0.05
    assert chaotic.any()
    assert ((points[:, chaotic] > 0) & (points[:, chaotic] < 1)).all()


@needs_node
def test_a_typed_map_is_the_packages():
    (code,) = compute(
        f"""[{json.dumps({"kind": "map", "formula": "y = 1 - x; x1 = r*x*y", "periodic": "", "parameters": {"r": 3.2}})}].map(formulaCode)""",
        "formula_code.js",
    )
    assert (code["line"], code["coordinates"], code["momenta"], code["parameters"]) == (True, ["x"], [], ["r"])
    model = LOGISTIC._replace(r=3.2)
    messages = [system_message(model), plane_of(model), launch_message(1, (0.2, 0.0), 300)]
    heard, other = explored([(code, messages), (model_code(system_of(model)), messages)])
    np.testing.assert_allclose(crossings(heard)[1], crossings(other)[1], atol=1e-13)
    assert of(heard, "reading")[-1]["lyapunov"] == pytest.approx(of(other, "reading")[-1]["lyapunov"], rel=1e-10)


def test_set_up_and_refusals():
    setup, _ = setup_of(LOGISTIC)
    own, start = setup["systems"][0], setup["start"]
    assert (own["kind"], own["line"], own["coordinates"], own["momenta"]) == ("map", True, ["x"], [])
    assert (start["section"], start["others"], start["energy"]) == ("x", {}, None)
    with pytest.raises(ValueError, match="fixed must be of rows outside of the plane x, got x"):
        setup_of(LOGISTIC, fixed={"x": 0.1})
    with pytest.raises(ValueError, match="energy is not supported for maps"):
        setup_of(LOGISTIC, energy=1.0)


def test_a_notebook_has_no_page_of_one_variable():
    pytest.importorskip("anywidget")
    from fastaff.explorer.widget import ExplorerWidget

    with pytest.raises(TypeError, match="must have two variables or more in a notebook's explorer"):
        ExplorerWidget(LOGISTIC)


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    return fa.explore(LOGISTIC, out=tmp_path_factory.mktemp("explorer") / "line.html").as_uri()


def test_the_page_opens_with_a_cobweb(sheet):
    sheet.wait("app.orbits.shown.size === 1 && app.orbits.shown.get(app.orbits.chosen).reading.status === 'done'")
    (orbit,) = sheet.orbits()
    x, image = orbit.points
    np.testing.assert_allclose(image, 3.7 * x * (1 - x), atol=1e-14)
    assert orbit.reading["classification"] == "chaotic"
    assert sheet.page.locator("[data-part=bifurcations]").is_visible()
    assert not sheet.page.locator("[data-part=frequency]").is_visible()
    assert not sheet.page.locator("[data-part=scheme]").is_visible()
    sheet.wait("app.bifurcations.found !== null")
    sheet.do("save-job")
    assert "no plane of a map of one variable" in sheet.text("notice")


def test_a_click_in_the_diagram_sets_the_parameter(sheet):
    sheet.wait("app.bifurcations.found !== null && app.orbits.shown.size === 1")
    before = sheet.orbits()[0].z0
    box = sheet.page.locator("[data-part=bifurcations]").bounding_box()
    sheet.page.locator("[data-part=bifurcations]").click(position={"x": 0.5 * box["width"], "y": 0.5 * box["height"]})
    sheet.wait("Math.abs(app.state.parameters.r - 3.7) > 0.1 && app.section.surface !== null && app.pending === null")
    r = sheet.get("app.state.parameters.r")
    assert 2.5 < r < 4
    assert float(sheet.page.locator("[data-number=r]").input_value()) == r
    sheet.done(1)
    (orbit,) = sheet.orbits()
    assert orbit.z0[0] == pytest.approx(before[0], abs=1e-12)  # the same initial condition
    np.testing.assert_allclose(orbit.points[1], r * orbit.points[0] * (1 - orbit.points[0]), atol=1e-14)
    sheet.do("fill")
    sheet.wait("app.orbits.shown.size === 9")  # a row of eight


def test_one_variable_is_typed_and_left_again(browser, address):
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    sheet = Sheet(context, address)
    sheet.page.locator("[data-part=system]").select_option("your-map")
    sheet.page.locator("[data-part=formula]").fill("x1 = r*sin(pi*x)")
    sheet.page.locator("[data-part=periodic]").fill("")
    sheet.wait("app.root.hasAttribute('data-line') && app.section.surface !== null && app.state.section === 'x'")
    sheet.number("r", "0.9")
    sheet.wait("app.section.surface !== null && app.pending === null && app.state.parameters.r === 0.9")
    sheet.click(0.3, 0.6)
    sheet.wait("[...app.orbits.shown.values()].some((one) => Math.abs(one.point?.[0] - 0.3) < 0.01 && one.count > 100)")
    sheet.page.locator("[data-part=formula]").fill("p1 = p + r*sin(x); x1 = x + p1")
    sheet.wait("!app.root.hasAttribute('data-line') && app.section.surface !== null && app.state.section === 'x,p'")
    assert sheet.said == []
    context.close()
