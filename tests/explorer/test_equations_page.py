"""The explorer's page of H(q, p), driven systems and flows: typed, opened from an address, saved; made in Python."""

import numpy as np
import pytest
from test_equations import DOUBLE, TURNS
from test_page import Sheet, saved

import fastaff as fa
from fastaff.explorer.explore import setup_of
from fastaff.jobs import Job

LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=2.667)
ENERGY = DOUBLE.replace("/(2*m*(", "/(2*(").replace("2*g*", "2*").replace(" g*", " ")


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    path = tmp_path_factory.mktemp("equations") / "page.html"
    fa.explore(fa.HenonHeiles(), energy=0.1, points=[], out=path)
    return path.as_uri() + "#system=henon-heiles"


def type_in(sheet, **texts):
    for name, text in texts.items():
        sheet.page.locator(f"[data-part={name}]").fill(text)


def test_a_double_pendulum_is_typed(sheet, here):
    """From V(q) to H(q, p) by typing: section, crossings, address, job; the angles from -pi to pi."""
    sheet.state("system=your-plane&crossings=20")
    type_in(sheet, formula=ENERGY, coordinates="q1 q2", momenta="p1 p2", periodic="q1=2*pi, q2=2*pi")
    sheet.wait("app.section.surface?.axes.join() === 'q2,p2' && app.pending === null && app.state.periodic")
    sheet.number("E", "-1.5")
    sheet.wait("app.section.surface?.energy === -1.5 && app.pending === null && app.section.surface.extent[0] < -3")
    assert sheet.get("app.state.scheme") == "GAUSS16"
    assert sheet.page.locator("[data-part=scheme] option").all_inner_texts() == ["Gauss 8", "Gauss 16"]
    assert sheet.get("app.section.surface.extent")[:2] == pytest.approx([-np.pi, np.pi])
    assert sheet.get("app.section.surface.minimum") == pytest.approx(-3.0)
    sheet.do("clear")
    sheet.click(0.3, 0.2)
    sheet.done(1)
    (one,) = sheet.orbits()
    model = fa.hamiltonian(ENERGY, coordinates="q1 q2", momenta="p1 p2", periodic=TURNS)
    assert model.energy(*one.z0) == pytest.approx(-1.5, rel=1e-12)
    found = fa.poincare_map(model, one.z0, section="q1=0", crossings=20, max_time=400.0, accuracy=1e-12)
    sure = found.times[:, 0] <= found.accurate_until[0]
    np.testing.assert_allclose(one.points[:, sure], found.points[[1, 3], :, 0][:, sure], atol=1e-9)
    sheet.wait("location.hash.includes('points=')")
    text = sheet.get("location.hash")
    files = saved(sheet, "save-job", here, 2)
    cut = fa.run(Job.read(next(file for file in files if file.suffix == ".toml")), "own.zarr")["poincare"]
    np.testing.assert_allclose(cut["p2"][:, 0][sure], one.points[1][sure], atol=1e-8)
    sheet.state("system=henon-heiles")
    sheet.state(text)
    sheet.done(1)
    np.testing.assert_array_equal(sheet.orbits()[0].points, one.points)
    sheet.number("E", "-4")
    sheet.wait("!app.part('wrong-energy').hidden")
    assert "minimum there is -3" in sheet.text("wrong-energy")


def test_an_answer_leaves_newer_text(sheet):
    """An answer that comes while somebody types, or to an older text, changes no box."""
    sheet.state("system=your-plane&crossings=20")
    answered = """(() => {
      const box = app.part("coordinates"), { formula, momenta, periodic, drive_period } = app.state;
      box.value = "u v";
      box.dispatchEvent(new Event("input"));
      const message = { type: "parsed", formula, kind: "plane", momenta, periodic, drive_period, names: ["k"], message:
      null }; const old = ["q1 q2", "x y"].map((coordinates) => ({ ...message, coordinates }));
      app.state.section = "none"; // what an answer sets right, and shows the state with it
      old.forEach((data) => app.backend.onmessage({ data }));
      return [box.value, app.state.section];
    })()"""
    assert sheet.get(answered) == ["u v", "none"]
    sheet.wait("app.state.coordinates === 'u v' && app.state.section === 'u=c' && 'x' in app.state.parameters")


def test_driven_systems_and_flows_are_typed(sheet):
    """A period makes V(x, t) driven, three equations have a section, and two of them a period."""
    sheet.state("system=your-plane&crossings=30")
    type_in(sheet, formula="-cos(x) - a*x*cos(w*t)", coordinates="x", periodic="x=2*pi", drive_period="2*pi/w")
    sheet.wait("app.root.hasAttribute('data-driven') && app.section.surface?.axes.join() === 'x,p_x'")
    sheet.number("a", "0.05")
    sheet.number("w", "0.8")
    sheet.wait("app.pending === null && app.state.parameters.w === 0.8 && app.section.surface.periods[0] > 6")
    assert not sheet.page.locator("[data-part=direction]").is_visible()
    sheet.do("clear")
    sheet.click(0.5, 0.3)
    sheet.done(1)
    (one,) = sheet.orbits()
    model = fa.hamiltonian("-cos(x) - a*x*cos(w*t)", coordinates="x", drive_period="2*pi/w", a=0.05, w=0.8)
    exact = fa.poincare_map(model, [one.z0[0], 0.0, one.z0[1], 0.0], section="t=0", crossings=30, accuracy=1e-12)
    np.testing.assert_allclose(one.points[1], exact.points[2, :, 0], atol=1e-8)
    sheet.number("t", "1.25")
    sheet.wait("app.pending === null && app.orbits.shown.size === 1 && location.hash.includes('phase=1.25')")
    sheet.done(1)
    (later,) = sheet.orbits()
    np.testing.assert_allclose(later.point, one.point, atol=1e-12)
    moved = [later.z0[0], 1.25, later.z0[1], 0.0]
    exact = fa.poincare_map(model, moved, section="t=1.25", crossings=30, accuracy=1e-12)
    np.testing.assert_allclose(later.points[1], exact.points[2, :, 0], atol=1e-8)
    sheet.state("system=your-ode&crossings=10")
    assert sheet.get("[app.root.dataset.kind, app.state.section, app.state.constant]") == ["ode", "z=c", 27]
    assert not sheet.page.locator("[data-number=E]").count()
    sheet.click(3.0, 4.0)
    sheet.done(1)
    (one,) = sheet.orbits()
    cut = fa.poincare_map(LORENZ, one.z0, section="z=27", crossings=3, max_time=50.0, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(one.points[:, :2], cut.points[:2, :2, 0], atol=1e-8)
    type_in(sheet, formula="x' = p; p' = -sin(x) - g*p + a*cos(t)")
    sheet.wait("!app.part('wrong-formula').hidden")
    assert "3 to 16" in sheet.text("wrong-formula")
    type_in(sheet, drive_period="2*pi")
    sheet.wait("app.part('wrong-formula').hidden && app.section.surface?.axes.join() === 'x,p'")
    sheet.wait("location.hash.includes('drive_period=2*pi')")
    assert sheet.get("app.state.energy") is None


def test_another_flow_has_its_own_section(sheet):
    """Rössler after Lorenz: letters at 1, y = 0 from a trial orbit, twelve orbits as in Python."""
    sheet.state("system=your-ode&crossings=5")
    type_in(sheet, formula="x' = -y - z; y' = x + a*y; z' = b + z*(x - c)")
    sheet.wait("Object.keys(app.state.parameters).join() === 'a,b,c'")
    assert sheet.get("app.state.parameters") == {"a": 1, "b": 1, "c": 1}
    for name, value in (("c", 5.7), ("b", 0.2), ("a", 0.2)):
        sheet.number(name, str(value))
        sheet.wait(f"app.pending === null && app.state.parameters.{name} === {value} && app.section.surface !== null")
    sheet.wait("app.state.section === 'y=c' && app.state.constant === 0")
    sheet.wait("app.orbits.shown.size === 12 && [...app.orbits.shown.values()].every((one) => one.count >= 3)")
    one = sheet.orbits()[0]
    flow = fa.ode("x' = -y - z; y' = x + a*y; z' = b + z*(x - c)", a=0.2, b=0.2, c=5.7)
    cut = fa.poincare_map(flow, one.z0, section="y=0", crossings=3, max_time=100.0, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(one.points[:, :3], cut.points[[0, 2], :3, 0], atol=1e-7)
    sheet.number("y", "0.5")  # a section of one's own stays
    sheet.number("a", "0.25")
    sheet.wait("app.pending === null && app.state.parameters.a === 0.25 && app.section.surface !== null")
    assert sheet.get("[app.state.section, app.state.constant]") == ["y=c", 0.5]


def test_a_driven_pendulum_knows_its_angle(sheet):
    """Typed without its period, as hamiltonian takes it: -pi to pi, twelve orbits; Duffing has no angle."""
    sheet.state("system=your-plane")
    type_in(sheet, formula="-cos(x) - a*x*cos(w*t)", coordinates="x", drive_period="2*pi/w")
    sheet.wait("app.section.surface?.periods?.[0] > 6 && app.orbits.shown.size === 12")
    assert sheet.get("app.section.surface.extent")[:2] == pytest.approx([-np.pi, np.pi])
    type_in(sheet, formula="x**4/4 - x**2/2 - a*x*cos(w*t)")
    sheet.wait("app.section.surface?.periods?.[0] === 0")


def test_what_is_wrong_with_an_angle_stands_at_its_box(sheet):
    """Blanks separate angles; a wrong one marks its own box, a wrong formula greys the plot."""
    sheet.state("system=your-plane&crossings=5")
    type_in(sheet, formula=ENERGY, coordinates="q1 q2", momenta="p1 p2", periodic="q1=2*pi q2 = 2*pi")
    sheet.wait("app.section.surface?.axes.join() === 'q2,p2'")
    assert sheet.get("app.section.surface.spans") == pytest.approx([2 * np.pi, 0])
    type_in(sheet, periodic="q1=2*pi q5=2*pi")
    sheet.wait("!app.part('wrong-periodic').hidden")
    assert "q5" in sheet.text("wrong-periodic")
    assert sheet.page.locator("[data-part=periodic]").get_attribute("aria-invalid") == "true"
    assert sheet.page.locator("[data-part=formula]").get_attribute("aria-invalid") is None
    assert not sheet.page.locator("[data-part=wrong-formula]").is_visible()
    type_in(sheet, periodic="", formula="p1**2/2 + (")
    sheet.wait("!app.part('wrong-formula').hidden && app.part('wrong-periodic').hidden")
    assert sheet.text("unread") == "Formula not read."
    assert not sheet.page.locator("[data-part=hello]").is_visible()
    assert float(sheet.page.locator("[data-part=back]").evaluate("(one) => getComputedStyle(one).opacity")) < 0.5
    type_in(sheet, formula=ENERGY, periodic="q1=2*pi, q2=2*pi")
    sheet.wait("app.section.surface !== null && app.part('unread').hidden")


def test_pages_of_models_made_in_python(browser, tmp_path):
    """H(q, p) and a flow are systems of a page, which opens alive; what suits neither is said."""
    model = fa.hamiltonian(ENERGY, coordinates="q1 q2", momenta="p1 p2", periodic=TURNS)
    setup, _ = setup_of(model, energy=-1.0, section="q2=0.2")
    start, own = setup["start"], setup["systems"][0]
    assert (own["kind"], own["code"]["kind"], own["momenta"]) == ("plane", "equations", ["p1", "p2"])
    assert (start["section"], start["constant"], start["scheme"]) == ("q2=c", 0.2, "GAUSS16")
    attracted, _ = setup_of(LORENZ)  # by the section that orbits meet
    assert (attracted["start"]["section"], attracted["systems"][0]["formula"]) == ("z=c", LORENZ.formula)
    assert 15 < attracted["start"]["constant"] < 35
    swing = fa.hamiltonian("-cos(q)", coordinates="q", periodic={"q": "2*pi"})
    driven = fa.ode(swing, forces={"q": "f*cos(w*t) - g*p_q"}, f=1.2, w=0.7, g=0.1)
    started, _ = setup_of(driven)
    assert (started["start"]["section"], started["start"]["constant"]) == ("sine=c", 0.0)
    assert started["start"]["others"] == {"q": 0.0, "p_q": 0.0, "cosine": 1.0, "sine": 0.0}
    assert started["systems"][0]["code"]["winds"] == [True, False, False, False]
    pendulum = fa.models.DoublePendulum(m_2=0.7)
    for body, given in (
        (model, {"energy": -1.0}),
        (LORENZ, {"section": "z=27"}),
        (pendulum, {"section": "q1=0"}),
        (driven, {}),
    ):
        path = fa.explore(body, out=tmp_path / "page.html", **given)
        context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
        sheet = Sheet(context, path.as_uri())
        sheet.wait("app.orbits.shown.size === 12 && app.orbits.total > 100")
        assert sheet.said == []
        context.close()
    wide = fa.hamiltonian("(p1**2*q2**2 + p2**2 + p3**2)/2", coordinates="q1 q2 q3", momenta="p1 p2 p3")
    for body, given, error, said in (
        (model, {}, ValueError, "energy must be given"),
        (model, {"energy": -4.0}, ValueError, "least energy there is -3"),
        (model, {"energy": -1.0, "scheme": "KAHAN_LI8"}, TypeError, "GAUSS16"),
        (LORENZ, {"energy": 1.0}, ValueError, "energy"),
        (LORENZ, {"section": "z=27", "fixed": {"w": 1.0}}, ValueError, "w"),
        (wide, {"energy": 1.0}, TypeError, "two coordinates, or one beside its time, got .* with 3. Try"),
        (fa.ode("x' = -x; y' = x"), {}, TypeError, "3 variables"),
    ):
        with pytest.raises(error, match=said):
            fa.explore(body, out=tmp_path / "x.html", **given)
