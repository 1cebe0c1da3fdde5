"""The explorer of driven systems: states once a period in its page, against poincare_map and chaos_map."""

import numpy as np
import pytest
from page_engine import crossings, explored, launch_message, needs_node, of, system_message
from test_page import Sheet, saved

import fastaff as fa
from fastaff.explorer.explore import setup_of
from fastaff.explorer.records import model_code
from fastaff.jobs import Job
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, KAHAN_LI8
from fastaff.systems.models.mechanics import system_of
from fastaff.systems.models.sections import Stroboscopic

PENDULUM = fa.hamiltonian("-cos(x) - a*x*cos(w*t)", coordinates="x", a=0.3, w=0.8, drive_period="2*pi/w")
WEAK = PENDULUM._replace(a=0.02)
DUFFING = fa.hamiltonian("x**4/4 - x**2/2 - f*x*cos(w*t)", coordinates="x", f=0.02, w=1.2, drive_period="2*pi/w")
MATHIEU = fa.hamiltonian("(a - 2*q*cos(2*t))*x**2/2", coordinates="x", a=1.7, q=0.4, drive_period=np.pi)


def told(model, scheme=BLANES_CASAS_ESCORIHUELA8, accuracy=1e-12):
    """The first message to the worker of a driven system."""
    message = system_message(model, accuracy, scheme)
    message["system"] |= {"coordinates": ["x"], "momenta": [system_of(model).row_names[2]]}
    message["frame"] = setup_of(model)[0]["frames"]["1"]
    return message


def strobed(model, phase=0.0):
    section = ",".join(["x", system_of(model).row_names[2]])
    return {"type": "surface", "section": section, "energy": None, "phase": phase, "width": 12, "height": 9}


def wrapped(x, model):
    return np.mod(x, 2 * np.pi) if model is WEAK else x


@needs_node
def test_points_are_those_of_the_stroboscopic_section():
    """Regular orbits at several phases, by two schemes; around an angle where the force has that period."""
    cases = [
        (WEAK, (0.3, 0.4), 0.0, BLANES_CASAS_ESCORIHUELA8),
        (WEAK, (5.5, 3.2), 1.3, KAHAN_LI8),
        (DUFFING, (1.05, 0.1), 0.0, KAHAN_LI8),
        (DUFFING, (-0.9, 0.05), 2.0, BLANES_CASAS_ESCORIHUELA8),
        (MATHIEU, (0.4, 0.2), 0.7, KAHAN_LI8),
    ]
    tasks = [
        (model_code(system_of(model)), [told(model, scheme), strobed(model, phase), launch_message(1, point, 60)])
        for model, point, phase, scheme in cases
    ]
    for heard, (model, point, phase, _) in zip(explored(tasks), cases, strict=True):
        assert not of(heard, "wrong"), heard
        _, points = crossings(heard)
        z0 = [point[0], phase, point[1], 0.0]
        found = fa.poincare_map(model, z0, section=Stroboscopic(phase), crossings=60, accuracy=2e-11)
        exact = found.points[[0, 2], :, 0]
        away = np.abs(points - [wrapped(exact[0], model), exact[1]])
        away[0] = np.minimum(away[0], 2 * np.pi - away[0]) if model is WEAK else away[0]
        assert away[:, :12].max() < 1e-9
        assert away.max() < 1e-7
        assert of(heard, "surface")[0]["periods"] == ([2 * np.pi, 0] if model is WEAK else [0, 0])


@needs_node
def test_readings_of_driven_systems():
    """Exponents per period of a linear system by Floquet's theory, of the pendulum's chaos as chaos_map's; tunes."""
    stable, period = MATHIEU, np.pi
    unstable = MATHIEU._replace(a=1.05, q=0.4)
    monodromy = fa.tangent_map(unstable, [0.0, 0.0], time=period).matrix[[0, 2]][:, [0, 2], 0]
    exponent = np.log(np.abs(np.linalg.eigvals(monodromy))).max()
    tasks = [
        (model_code(system_of(stable)), [told(stable), strobed(stable), launch_message(1, (0.4, 0.2), 1400)]),
        (model_code(system_of(unstable)), [told(unstable), strobed(unstable), launch_message(1, (1e-9, 1e-9), 40)]),
        (model_code(system_of(PENDULUM)), [told(PENDULUM), strobed(PENDULUM), launch_message(1, (3.1, 0.1), 1400)]),
    ]
    calm, growing, wild = (of(heard, "reading")[-1] for heard in explored(tasks))
    assert (calm["classification"], wild["classification"]) == ("regular", "chaotic")
    assert growing["lyapunov"] == pytest.approx(exponent, rel=0.1)
    turn = fa.tangent_map(stable, [0.0, 0.0], time=period).matrix[[0, 2]][:, [0, 2], 0]
    tune = np.arccos(np.trace(turn) / 2) / (2 * np.pi)
    assert abs(calm["rotation"]["value"]) == pytest.approx(tune, abs=1e-9)
    chaos = fa.chaos_map(PENDULUM, [3.1, 0.1], time=1400 * PENDULUM.period, indicators="lyapunov")
    assert wild["lyapunov"] == pytest.approx(chaos.lyapunov[0] * PENDULUM.period, rel=0.25)


def test_set_up_of_a_driven_system(tmp_path):
    setup, chosen = setup_of(PENDULUM, section="t=1.5", accuracy=1e-8, scheme="KAHAN_LI8")
    assert chosen is PENDULUM
    own, start = setup["systems"][0], setup["start"]
    assert (own["kind"], own["driven"], own["phase"], own["coordinates"]) == ("map", True, 1.5, ["x"])
    assert own["code"]["winds"] == [True, False]
    assert model_code(system_of(DUFFING))["winds"] == [False, False]
    assert (start["scheme"], start["accuracy"], start["energy"]) == ("KAHAN_LI8", 1e-8, None)
    assert own["job"]["drive_period"] == "2*pi/w"
    for given, error, said in (
        ({"energy": 1.0}, ValueError, "energy is not supported for driven systems"),
        ({"fixed": {"x": 1.0}}, ValueError, "fixed is not supported for"),
        ({"background": 3}, TypeError, "background"),
        ({"section": fa.Hyperplane((1.0, 0.0, 0.0, 0.0))}, TypeError, "Stroboscopic"),
        ({"scheme": "DOP853"}, TypeError, "splitting"),
    ):
        with pytest.raises(error, match=said):
            fa.explore(DUFFING, out=tmp_path / "x.html", **given)
    two = fa.hamiltonian("x**2 + y**2 + x*cos(t)", coordinates="x y", drive_period=2 * np.pi)
    with pytest.raises(TypeError, match=r"one coordinate beside its time .* with 2. Try fa.poincare_map .*'t=0'"):
        fa.explore(two, out=tmp_path / "x.html")


def test_the_page_of_a_driven_system(browser, here):
    """Clicks, the scheme, the address, and a job that gives the same points; the period a number or a formula."""
    for model, phase, place, name in ((WEAK, 0.0, (0.5, 0.3), "weak"), (MATHIEU, 0.4, (0.3, 0.2), "mathieu")):
        path = fa.explore(model, section=f"t={phase}", accuracy=1e-12, out=here / f"{name}.html")
        context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
        sheet = Sheet(context, path.as_uri() + "#system=own&crossings=30")
        assert sheet.page.locator("[data-part=scheme]").is_visible()
        assert not sheet.page.locator("[data-part=direction]").is_visible()
        sheet.click(*place)
        sheet.done(1)
        (one,) = sheet.orbits()
        z0 = [one.z0[0], phase, one.z0[1], 0.0]
        found = fa.poincare_map(model, z0, section=Stroboscopic(phase), crossings=30, accuracy=2e-11)
        np.testing.assert_allclose(one.points[1], found.points[2, :, 0], atol=1e-8)
        files = saved(sheet, "save-job", here, 2)
        job = Job.read(next(file for file in files if file.suffix == ".toml"))
        cut = fa.run(job, f"{name}.zarr")["poincare"]
        np.testing.assert_allclose(cut.points[2, :, 0], one.points[1], atol=1e-8)
        sheet.do("save-grid")
        sheet.wait("app.part('notice').textContent.includes('Grids are not supported for driven')")
        text = sheet.get("location.hash")
        assert "scheme=" in text
        assert "accuracy=1e-12" in text
        assert sheet.said == []
        context.close()


def test_a_notebook_has_no_page_of_a_driven_system():
    pytest.importorskip("anywidget", reason="anywidget shows the explorer in notebooks: fastaff[app]")
    from fastaff.explorer.widget import ExplorerWidget

    with pytest.raises(TypeError, match=r"model must have no drive .* Use fa\.explore, which writes a page"):
        ExplorerWidget(WEAK)
