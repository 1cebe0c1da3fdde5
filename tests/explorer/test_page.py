"""The explorer's page in a browser: what people click, type, read, save and send by its address."""

from __future__ import annotations

import base64
import io
import json
import re
import time
from types import SimpleNamespace

import numpy as np
import pytest
from page_engine import compute, needs_node

import fastaff as fa
from fastaff.explorer.page import page as assembled
from fastaff.jobs import Job

APP = "const app = document.querySelector('.explorer').explorer;"
PIXEL = """(() => {
  const { frame, canvases } = app.section, box = canvases.front.getBoundingClientRect();
  const { left, right, top, bottom } = frame.margins, [u0, u1, v0, v1] = frame.view;
  return [box.left + left + (given[0] - u0)/(u1 - u0)*(frame.width - left - right),
          box.top + top + (v1 - given[1])/(v1 - v0)*(frame.height - top - bottom)];
})()"""
TABBED = """() => [...document.querySelectorAll('button, select, input, summary, textarea, [tabindex="0"]')]
  .filter((one) => one.offsetParent && !one.closest('dialog, .menu-list, .player, tbody'))
  .map((one) => [one.getBoundingClientRect(), one.dataset.part ?? one.dataset.do])
  .map(([box, name]) => [Math.round((box.top + box.bottom) / 40), name])"""
"""Rows of forty pixels of the controls that Tab reaches, in its order."""
HENON = "system=henon-heiles&crossings=60"
HANGS = 300
"""Seconds after which a page is taken to hang, however busy the machine."""


class Sheet:
    """One open page, with what it said on its console."""

    def __init__(self, context, url):
        self.url, self.said = url, []
        context.set_default_timeout(1000 * HANGS)
        self.page = context.new_page()
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.goto(url)
        self.wait("app.section.surface !== null")

    def get(self, expression, given=None):
        """Return the value of an expression of `app` and `given` in the page."""
        return self.page.evaluate(f"(given) => {{ {APP} return {expression}; }}", given)

    def wait(self, expression, given=None, seconds=HANGS):
        """Wait until an expression holds; without eval in the page, which its policy forbids."""
        end = time.monotonic() + seconds
        while not (found := self.get(expression, given)):
            assert time.monotonic() < end, f"{expression} does not come true; console: {self.said}"
            time.sleep(0.02)
        return found

    def state(self, text):
        """Open the state of an address."""
        self.page.evaluate(
            "(text) => { " + APP + " app.section.surface = null; app.lastHash = null; document.activeElement.blur();"
            " location.hash = ''; location.hash = text; }",
            text,
        )
        self.wait("app.section.surface !== null && app.pending === null")

    def pixel(self, u, v):
        """Return where a point of the section is in the window, once the page stands still."""
        place = None
        while place != (place := self.get(PIXEL, [u, v])):
            self.page.evaluate("() => new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go)))")
        return place

    def plane(self, x, y):
        """Return which point of the section is at a place of the window."""
        (x0, y0), (x1, y1) = self.pixel(0.0, 0.0), self.pixel(1.0, 1.0)
        return (x - x0) / (x1 - x0), (y - y0) / (y1 - y0)

    def click(self, u, v):
        """Click on a point of the section."""
        self.page.mouse.click(*self.pixel(u, v))

    def done(self, orbits):
        """Wait until so many orbits are there and finished."""
        ended = "[...app.orbits.shown.values()].every((one) => one.z0 && one.reading.status !== 'running')"
        self.wait(f"app.orbits.shown.size === given && {ended}", orbits)

    def orbits(self):
        """Return the orbits: mark, point, z0, points (2, crossings) and reading of each."""
        found = self.get(
            "[...app.orbits.shown.values()].map((one) => ({ mark: one.mark, point: one.point, z0: one.z0,"
            " hidden: one.hidden,"
            " points: [...one.points.subarray(0, 2*one.count)], reading: one.reading }))"
        )
        return [SimpleNamespace(**{**one, "points": np.array(one["points"]).reshape(-1, 2).T}) for one in found]

    def text(self, part):
        """Return the text of a part of the page."""
        return self.page.locator(f"[data-part={part}]").inner_text()

    def do(self, name):
        """Press a button, in the menu that holds it."""
        if name.startswith(("save", "copy")):
            self.page.locator("[data-part=save] > summary").click()
        self.page.locator(f"[data-do={name}]").click()

    def number(self, name, text):
        """Type into a number box."""
        box = self.page.locator(f"[data-number='{name}']")
        box.fill(text)
        box.press("Enter")


@pytest.fixture(scope="module")
def background():
    """A map over the section of the neo-Hookean body that its page opens with."""
    values = np.arange(6 * 4, dtype="<f4").reshape(4, 6) + 0.5
    values[0, 0] = np.nan
    return values


@pytest.fixture(scope="module")
def file(tmp_path_factory, background):
    """The page of a neo-Hookean body with a map, as a file."""
    path = tmp_path_factory.mktemp("explorer") / "page.html"
    fa.explore(fa.Body(fa.NeoHookean()), energy=1.5, p_eta=0.3, p_gamma=0.2, out=path)
    setup = json.loads(re.search(r'id="setup">(.*?)</script>', path.read_text())[1])
    of = {name: value for name, value in setup["start"].items() if name not in ("accuracy", "scheme", "points")}
    setup["background"] = {
        **{"title": "MEGNO", "label": "MEGNO", "axes": ["beta", "p_beta"], "extent": [0.2, 1.1, -1.0, 1.0]},
        **{"width": 6, "height": 4, "values": base64.b64encode(background.tobytes()).decode()},
        **{"low": 0.0, "high": 24.0, "log": False, "of": of},
    }
    path.write_text(assembled(setup))
    return path


@pytest.fixture(scope="module")
def address(file):
    return file.as_uri()


def test_clicks_launch_orbits_that_stream_in(sheet):
    sheet.state(HENON)
    sheet.page.evaluate(
        f"() => {{ {APP} globalThis.told = []; const take = app.backend.onmessage;"
        " app.backend.onmessage = (event) => { if (event.data.type === 'points')"
        " told.push([event.data.orbit, event.data.first, [...event.data.points]]); take(event); }; }"
    )
    starts = [(0.3, 0.0), (0.1, 0.1), (-0.2, 0.1)]
    for start in starts:
        sheet.click(*start)
    sheet.done(3)
    found = sheet.orbits()
    assert [one.mark for one in found] == [1, 2, 3]
    z0 = np.array([one.z0 for one in found]).T
    np.testing.assert_allclose([one.point for one in found], starts, atol=2e-3)  # half a pixel of a view of width 1.3
    np.testing.assert_array_equal(z0[1], [one.point[0] for one in found])
    truth = fa.poincare_map(
        fa.HenonHeiles(), z0, section=fa.Hyperplane((1.0, 0.0, 0.0, 0.0)), crossings=60, max_time=900.0, accuracy=1e-11
    )
    told = sheet.page.evaluate("() => told")
    for i, one in enumerate(found):
        sent = np.concatenate([points for orbit, first, points in told if orbit == told[0][0] + i])
        np.testing.assert_array_equal(one.points.T.ravel(), sent)  # to the bit what the worker said
        exact = np.array([truth["y"][:, i], truth["p_y"][:, i]])
        np.testing.assert_allclose(one.points[:, :20], exact[:, :20], atol=1e-9)


def test_the_table_says_what_the_worker_reads(sheet):
    sheet.state("system=henon-heiles&crossings=400&points=0.3:0.0,-0.1:0")
    sheet.done(2)
    sheet.wait("app.table.order.length === 2 && !app.dirty.has('table')")
    rows = [row.split("\t") for row in sheet.page.locator("[data-part=rows] tr[data-orbit]").all_inner_texts()]
    calm, wild = sheet.orbits()
    assert [row[0].strip() for row in rows] == ["2", "1"]  # the newest first
    assert (
        [row[1] for row in rows]
        == [wild.reading["classification"], calm.reading["classification"]]
        == ["chaotic", "regular"]
    )
    assert [row[2] for row in rows] == ["400", "400"]
    assert abs(float(rows[1][4].split("(")[0]) - calm.reading["rotation"]["value"]) < 1e-6
    assert rows[0][4] == "–"  # a chaotic orbit has no rotation number
    assert all(row[8] == "done" and "10⁻" in row[7] for row in rows)
    assert "2 orbits (1 regular, 1 chaotic)" in sheet.text("count")
    sheet.page.locator("[data-part=rows] tr[data-orbit]").nth(1).click()
    assert sheet.get("app.orbits.shown.get(app.orbits.chosen).mark") == 1


def test_what_is_wrong_is_said_beside_it(sheet):
    sheet.state("crossings=20")
    sheet.number("E", "-1/2")
    sheet.wait("!app.part('wrong-energy').hidden")
    assert "-0.5" in sheet.text("wrong-energy")
    assert "minimum" in sheet.text("wrong-energy")
    assert sheet.page.locator("[data-number=E]").get_attribute("aria-invalid") == "true"
    sheet.number("E", "7/4")
    sheet.wait("app.section.surface !== null && app.part('wrong-energy').hidden")
    assert sheet.get("app.state.energy") == 1.75
    sheet.number("E", "alert(1)")
    assert sheet.page.locator("[data-number=E]").get_attribute("aria-invalid") == "true"
    assert sheet.get("app.state.energy") == 1.75
    sheet.click(0.06, 1.3)
    sheet.wait("app.part('notice').textContent.includes('energy surface')")
    assert sheet.get("app.orbits.shown.size") == 0


def test_formulas_of_ones_own(sheet):
    sheet.state("system=your-plane&crossings=30&energy=0.1")
    sheet.page.locator("[data-part=formula]").fill("(x**2 + a*y**2)/2 + x**2*")
    sheet.wait("!app.part('wrong-formula').hidden")
    assert "expression" in sheet.text("wrong-formula")
    assert sheet.get("app.section.surface") is None
    sheet.page.locator("[data-part=formula]").fill("(x**2 + a*y**2)/2")
    sheet.wait("app.section.surface !== null && app.part('wrong-formula').hidden")
    assert sheet.page.locator("[data-part=parameters] input[type=text]").count() == 1
    sheet.number("a", "4")
    sheet.wait("app.section.surface !== null && app.pending === null && app.section.surface.extent[1] < 0.3")
    sheet.do("clear")
    sheet.click(0.1, 0.0)
    sheet.done(1)
    (one,) = sheet.orbits()
    period = 2 * np.pi * np.arange(1, 31)  # of x; y = u cos 2t: the points come back
    np.testing.assert_allclose(one.points[0], one.point[0] * np.cos(2 * period), atol=1e-9)


def test_the_address_gives_the_same_page_back(sheet):
    sheet.state(
        "system=neo-hookean&parameter.K=2.5&energy=1.75&p_eta=0.25&section=beta%3Dc&constant=0.4&direction=-1&crossings=25"
    )
    u0, u1, _v0, _v1 = sheet.get("app.section.surface.extent")
    sheet.click((u0 + u1) / 2, 0.1)
    sheet.click((u0 + 2 * u1) / 3, 0.2)
    sheet.done(2)
    sheet.do("zoom-in")
    sheet.wait("location.hash.includes('view=')")
    text, first, view = sheet.get("location.hash"), sheet.orbits(), sheet.get("app.section.frame.view")
    assert "constant=0.4" in text
    assert "parameter.K=2.5" in text
    sheet.state(HENON)
    sheet.state(text)
    sheet.done(2)
    for before, after in zip(first, sheet.orbits()):
        assert before.z0 == after.z0
        np.testing.assert_array_equal(before.points, after.points)
    assert sheet.get("app.section.frame.view") == view
    state = sheet.get("app.state")
    assert (state["energy"], state["p_eta"], state["direction"], state["section"], state["constant"]) == (
        1.75,
        0.25,
        -1,
        "beta=c",
        0.4,
    )


@pytest.mark.parametrize(
    "hostile",
    [
        "system=__proto__",
        "energy=alert(1)&p_eta=1e999&crossings=-3&direction=2",
        "system=your-plane&formula=fetch(%27//x%27)%3B%60%24%7B1%7D%60",
        "system=your-plane&formula=constructor.constructor(x)",
        "system=your-plane&formula=x**2%2By**2&coordinates=x%20__proto__%3Balert",
        "parameter.__proto__=1&parameter.<img src=x onerror=alert(1)>=2&parameter.G=NaN",
        "points=1:2:3,<script>&view=1:0:0:1&%E0%A4%A",
        "section=<svg onload=alert(1)>&scheme=constructor&" + "x=1&" * 3000,
    ],
)
def test_an_address_gives_numbers_names_and_formulas_only(sheet, hostile):
    sheet.page.evaluate(
        "(text) => { globalThis.ran = []; globalThis.alert = (x) => ran.push(x);"
        " location.hash = ''; location.hash = text; }",
        hostile,
    )
    sheet.wait("app.part('notice').textContent.includes('were ignored') || !app.part('wrong-formula').hidden")
    state = sheet.get("app.state")
    assert sheet.page.evaluate("() => [ran, {}.polluted, document.querySelectorAll('img, iframe, object').length]") == [
        [],
        None,
        0,
    ]
    numbers = [state[name] for name in ("energy", "p_eta", "p_gamma", "accuracy", "crossings", "direction")]
    assert all(
        isinstance(value, (int, float)) and np.isfinite(value) for value in [*numbers, *state["parameters"].values()]
    )
    assert state["system"] in ("neo-hookean", "your-plane")
    assert state["points"] == []
    assert state["view"] is None
    assert state["scheme"] == "KAHAN_LI8" or state["scheme"] in fa.schemes.SCHEMES
    assert set(state["parameters"]) <= {"G", "K", "mu", "lam"}


def test_undo_clear_hide_and_forget(sheet):
    sheet.state(HENON)
    for start in ((0.3, 0.0), (0.1, 0.1)):
        sheet.click(*start)
    sheet.done(2)
    kept = sheet.orbits()
    sheet.do("clear")
    assert sheet.get("[app.orbits.shown.size, app.orbits.total]") == [0, 0]
    sheet.do("undo")
    assert sheet.get("[app.orbits.shown.size, app.orbits.total]") == [2, 120]
    np.testing.assert_array_equal(sheet.orbits()[1].points, kept[1].points)
    sheet.page.keyboard.press("h")
    assert [one.hidden for one in sheet.orbits()] == [False, True]
    sheet.page.keyboard.press("h")
    sheet.page.keyboard.press("m")
    sheet.wait(
        "[...app.orbits.shown.values()][1].count === 120 && [...app.orbits.shown.values()][1].reading.status === 'done'"
    )
    np.testing.assert_array_equal(sheet.orbits()[1].points[:, :60], kept[1].points)
    sheet.page.keyboard.press("Delete")
    assert [one.mark for one in sheet.orbits()] == [1]
    sheet.page.keyboard.press("u")
    assert sorted(one.mark for one in sheet.orbits()) == [1, 2]
    for _ in range(3):
        sheet.do("undo")
    assert sheet.get("[app.orbits.shown.size, app.orbits.total, app.orbits.actions.length]") == [0, 0, 0]


def test_a_fill_launches_what_the_energy_reaches(sheet):
    sheet.state("system=henon-heiles&crossings=10")
    sheet.page.locator("[data-part=grid]").select_option("8")
    sheet.do("fill")
    u0, u1, v0, v1 = sheet.get("app.section.frame.view")
    u, v = np.meshgrid(u0 + (u1 - u0) * (np.arange(8) + 0.5) / 8, v0 + (v1 - v0) * (np.arange(8) + 0.5) / 8)
    reached = 2 * 0.125 - v**2 - u**2 + 2 * u**3 / 3 >= 0
    reached &= u < 1  # beyond the saddle of V at y = 1 nothing comes from the section's region
    sheet.done(int(reached.sum()))
    np.testing.assert_allclose(
        np.array([one.point for one in sheet.orbits()]), np.stack([u[reached], v[reached]], 1), atol=1e-12
    )
    sheet.do("undo")
    assert sheet.get("app.orbits.shown.size") == 0


@pytest.fixture(params=[True, False], ids=["processor", "WebGL2"])
def drawn(request, sheet):
    """The page, which draws points by the processor or by WebGL2."""
    usual = sheet.get("app.section.software")
    sheet.get("app.section.software = given", request.param)
    yield sheet
    sheet.get("app.section.software = given", usual)


def test_zoom_and_back(sheet):
    sheet.state(HENON)
    sheet.click(0.3, 0.02)
    sheet.done(1)
    view = sheet.get("app.section.frame.view")
    x, y = np.round(sheet.pixel(0.2, 0.0))
    at = sheet.plane(x, y)
    sheet.page.mouse.move(x, y)
    sheet.page.mouse.wheel(0, -400)
    sheet.wait("app.section.frame.view[1] - app.section.frame.view[0] < given", 0.8 * (view[1] - view[0]))
    np.testing.assert_allclose(sheet.pixel(*at), (x, y), atol=1e-6)  # the point under the pointer stays
    sheet.page.keyboard.press("Backspace")
    assert sheet.get("app.section.frame.view") == view
    sheet.do("box")
    sheet.page.mouse.move(*sheet.pixel(0.0, -0.2))
    sheet.page.mouse.down()
    sheet.page.mouse.move(*sheet.pixel(0.1, 0.0))
    sheet.page.mouse.move(*sheet.pixel(0.4, 0.2))
    sheet.page.mouse.up()
    np.testing.assert_allclose(sheet.get("app.section.frame.view"), [0.0, 0.4, -0.2, 0.2], atol=2e-3)


def test_points_are_sharp_however_deep_the_zoom(drawn, tmp_path):
    from PIL import Image

    sheet = drawn
    sheet.state(HENON)
    sheet.click(0.3, 0.02)
    sheet.done(1)
    sheet.page.locator("[data-part=paint]").select_option("orbit")
    u, v = sheet.orbits()[0].points[:, 17]
    width = 1e-10  # single precision of the numbers themselves would be off by 100 views
    sheet.page.evaluate(
        f"(view) => {{ {APP} app.section.frame.view = view; }}", [u - width, u + width, v - width, v + width]
    )
    picture = Image.open(io.BytesIO(saved(sheet, "save-picture", tmp_path)[0].read_bytes())).convert("RGB")
    colour = np.array([0x00, 0x72, 0xB2])
    middle = sheet.get(
        "(() => { const { frame } = app.section, m = frame.margins;"
        " return [2*(m.left + (frame.width - m.left - m.right)/2),"
        " 2*(50 + m.top + (frame.height - m.top - m.bottom)/2)]; })()"
    )
    near = np.asarray(picture)[round(middle[1]) - 2 : round(middle[1]) + 3, round(middle[0]) - 2 : round(middle[0]) + 3]
    assert (np.abs(near.astype(int) - colour).sum(axis=2) < 40).any()


def saved(sheet, name, folder, count=1):
    """Press a button that saves and return the files."""
    got = []

    def take(download):
        got.append(download)

    sheet.page.on("download", take)
    sheet.do(name)
    end = time.monotonic() + HANGS
    while len(got) < count and time.monotonic() < end:
        sheet.page.wait_for_timeout(20)
    sheet.page.remove_listener("download", take)
    for entry in got:
        entry.save_as(folder / entry.suggested_filename)
    return [folder / entry.suggested_filename for entry in got]


def test_the_picture_has_axes_and_points(drawn, tmp_path):
    from PIL import Image

    sheet = drawn
    sheet.state("system=henon-heiles&crossings=300&points=0.3:0.1,0.1:0.1")
    sheet.done(2)
    sheet.page.locator("[data-part=paint]").select_option("orbit")
    (path,) = saved(sheet, "save-picture", tmp_path)
    assert path.name == "henon-heiles.png"
    picture = np.asarray(Image.open(path).convert("RGB")).astype(int)
    stage = sheet.get("[app.section.frame.width, app.section.frame.height]")
    assert picture.shape[:2] == (round(2 * (stage[1] + 50)), round(2 * stage[0]))
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)):
        assert (np.abs(picture - colour).sum(axis=2) < 30).sum() > 300
    assert (picture[:100].sum(axis=2) < 300).sum() > 200  # the caption


def test_a_saved_job_runs_and_gives_the_same_crossings(sheet, here):
    sheet.state("crossings=20&points=0.3:0.2,0.6:0.5,0.8:0.05")
    sheet.done(3)
    found = sheet.orbits()
    files = saved(sheet, "save-job", here, 2)
    assert sorted(path.name for path in files) == ["neo-hookean.npy", "neo-hookean.toml"]
    np.testing.assert_array_equal(np.load("neo-hookean.npy"), np.array([one.z0 for one in found]).T)
    cut = fa.run(Job.read("neo-hookean.toml"), "job.zarr")["poincare"]
    for i, one in enumerate(found):
        np.testing.assert_allclose(np.array([cut["beta"][:, i], cut["p_beta"][:, i]]), one.points, atol=1e-8)
    (path,) = saved(sheet, "save-grid", here)
    job = Job.read(path)
    assert job.energy_surface.energy == 1.5
    assert job.plan().launch.size == 64


def test_a_job_of_a_formula(sheet, tmp_path):
    sheet.state("system=your-plane&parameter.lam=0.75&crossings=5&energy=0.1&points=0.1:0.05")
    sheet.done(1)
    path = next(path for path in saved(sheet, "save-job", tmp_path, 2) if path.suffix == ".toml")
    model = Job.read(path).model.build()
    assert model.coordinates == ("x", "y")
    assert model.lam == 0.75


def test_hovering_reads_the_map_and_the_orbit(sheet, background):
    sheet.state("crossings=500&points=0.3:0.2")
    sheet.done(1)
    assert sheet.get("document.querySelector('[data-do=background]').hidden") is False
    for row, column in ((2, 3), (3, 5)):
        u, v = 0.2 + 0.9 * (column + 0.5) / 6, -1 + 2 * (row + 0.5) / 4
        sheet.page.mouse.move(*sheet.pixel(u, v))
        sheet.wait("app.part('readout').textContent.includes(given)", f"MEGNO {background[row, column]:.4g} (map)")
    sheet.page.mouse.move(*sheet.pixel(0.2 + 0.075, -1 + 0.25))
    sheet.wait("app.part('readout').textContent !== '' && !app.part('readout').textContent.includes('map')")  # NaN
    u, v = sheet.orbits()[0].points[:, 7]
    sheet.page.mouse.move(*sheet.pixel(u, v))
    sheet.wait("app.part('readout').textContent.includes('orbit 1, crossing')")
    assert "regular" in sheet.text("readout")
    sheet.number("E", "1.6")
    sheet.wait("app.section.surface?.energy === 1.6")
    assert "energy 1.5" in sheet.text("notice")
    assert sheet.page.locator("[data-do=background]").is_disabled()


def test_another_energy_keeps_every_orbit(sheet):
    """Initial conditions keep their place in the region of every energy; the first one brings all back to the bit."""
    starts = "0.3:0.1,-0.3:0.25,0.64:0,-0.42:0.02,0.0:0.49,0.2:-0.4"
    sheet.state(f"system=henon-heiles&crossings=20&energy=0.125&points={starts}")
    sheet.done(6)
    before = sheet.orbits()
    for energy in (0.1, 0.0333, 0.16, 0.02):
        sheet.number("E", str(energy))
        sheet.wait("app.section.surface?.energy === given && app.pending === null", energy)
        sheet.done(6)
        y, p_y = np.array([one.point for one in sheet.orbits()]).T
        assert (p_y**2 + y**2 - 2 / 3 * y**3 <= 2 * energy).all()
        assert [one.mark for one in sheet.orbits()] == [1, 2, 3, 4, 5, 6]
        assert sheet.text("notice").startswith(f"6 initial conditions scaled to the accessible region at E = {energy}.")
        assert "is-wrong" not in sheet.page.locator("[data-part=notice]").get_attribute("class")
        roots = np.sort(np.roots([-1 / 3, 1 / 2, 0.0, -energy]).real)[:2]
        share = (y - roots[0]) / np.ptp(roots)
        assert share.min() < 0.1
        assert share.max() > 0.9
    sheet.number("E", "0.125")
    sheet.wait("app.section.surface?.energy === 0.125 && app.pending === null")
    sheet.done(6)
    assert [one.z0 for one in sheet.orbits()] == [one.z0 for one in before]
    assert [one.points.tolist() for one in sheet.orbits()] == [one.points.tolist() for one in before]
    sheet.number("lam", "1.3")  # whose region is smaller: a point inside of it stays where it is
    sheet.wait("app.pending === null && app.state.parameters.lam === 1.3 && app.section.surface !== null")
    sheet.done(6)
    assert sheet.orbits()[0].point == [0.3, 0.1]
    sheet.click(-0.51, 0.5)
    sheet.wait("app.part('notice').textContent.includes('energy surface')")
    assert sheet.text("notice").startswith("y = ")


def test_another_energy_fits_the_view_unless_it_was_zoomed(sheet):
    sheet.state("system=henon-heiles&crossings=20&energy=0.125&points=0.3:0.1")
    whole = sheet.get("app.section.frame.view")
    sheet.number("E", "0.03")
    sheet.wait("app.section.surface?.energy === 0.03 && app.pending === null")
    small = sheet.get("app.section.frame.view")
    # V = y^2/2 - y^3/3 on the section x = 0: the region reaches from root to root
    roots = np.sort(np.roots([-1 / 3, 1 / 2, 0.0, -0.03]).real)[:2]
    assert small[0] < roots[0] < roots[1] < small[1]
    assert small[1] - small[0] < 1.2 * (roots[1] - roots[0]) < whole[1] - whole[0]
    sheet.do("zoom-in")
    zoomed = sheet.get("app.section.frame.view")
    sheet.number("E", "0.1")
    sheet.wait("app.section.surface?.energy === 0.1 && app.pending === null")
    assert sheet.get("app.section.frame.view") == zoomed


def test_an_energy_that_is_not_reached_keeps_the_orbits(sheet):
    sheet.state("system=neo-hookean&crossings=40&energy=1.5&points=0.3:0.2,0.6:0.5")
    sheet.done(2)
    before = [(one.point, one.points.tolist()) for one in sheet.orbits()]
    sheet.number("E", "-0.5")
    sheet.wait("!app.part('wrong-energy').hidden")
    assert "the minimum there is" in sheet.text("wrong-energy")
    assert "The orbits are those of E = 1.5." in sheet.text("wrong-energy")
    assert [(one.point, one.points.tolist()) for one in sheet.orbits()] == before
    sheet.click(0.8, 0.05)
    sheet.done(3)
    assert sheet.get("app.section.surface.energy") == 1.5
    sheet.do("undo")  # of the energy that was refused: the orbits are still here
    assert sheet.page.locator("[data-number=E]").input_value() == "1.5"
    assert sheet.get("[app.state.energy, app.part('wrong-energy').hidden, app.orbits.shown.size]") == [1.5, True, 3]
    sheet.number("E", "1.4")
    sheet.wait("app.section.surface?.energy === 1.4 && app.pending === null")
    sheet.done(3)
    sheet.do("undo")  # of the energy: what went comes back
    sheet.wait("app.section.surface?.energy === 1.5 && app.pending === null")
    sheet.done(3)
    assert [(one.point, one.points.tolist()) for one in sheet.orbits()][:2] == before
    assert sheet.page.locator("[data-number=E]").input_value() == "1.5"


def rows_of(sheet):
    """The rows of the table, the newest first."""
    sheet.wait("app.table.order.length === app.orbits.shown.size && !app.dirty.has('table')")
    return sheet.page.locator("[data-part=rows] tr[data-orbit]").all_inner_texts()


def test_colours_say_classifications_numbers_or_orbits(sheet):
    sheet.state("system=henon-heiles&crossings=300&energy=0.125&points=0.3:0.0,0.35:0.0,-0.1:0.1,0.0:0.4")
    sheet.done(4)

    def paints(what):
        sheet.page.locator("[data-part=paint]").select_option(what)
        sheet.wait("!app.paintStale")
        return sheet.get("[...app.orbits.shown.values()].map((one) => one.paint)")

    found, classifications = paints("classification"), [one.reading["classification"] for one in sheet.orbits()]
    assert {"regular", "chaotic"} <= set(classifications)
    assert [paint == "chaotic" for paint in found] == [
        classification == "chaotic" for classification in classifications
    ]
    regular = [one for one in sheet.orbits() if one.reading["classification"] == "regular"]
    values = [one.reading["rotation"]["value"] for one in regular if one.reading["rotation"]]
    shades = [paint for paint in found if isinstance(paint, int)]
    assert shades[int(np.argmin(values))] == 0
    assert shades[int(np.argmax(values))] == 48
    low, high = min(values), max(values)
    said = sheet.text("scale").replace("\u2212", "-").split()
    plain = [word for one in ("regular", "undecided") if one in found for word in (f"{one},", "no", "ν")]
    assert [*said[:3], *said[5:]] == ["not", "chaotic,", "ν", *plain, "chaotic"]
    assert [float(end) for end in said[3:5]] == pytest.approx([low, high], abs=1e-3)
    swatches = sheet.page.locator("[data-part=swatches] .patch").evaluate_all(
        "(all) => all.map((one) => getComputedStyle(one).backgroundColor)"
    )
    assert len({*swatches}) == len({*found} & {"regular", "undecided", "chaotic"})
    without = [one.reading["classification"] == "chaotic" or not one.reading["rotation"] for one in sheet.orbits()]
    assert [row.split("\t")[4] == "–" for row in rows_of(sheet)][::-1] == without
    assert paints("orbit") == [None] * 4
    assert not sheet.page.locator("[data-part=scale]").is_visible()
    megno = np.array([one.reading["megno"] for one in sheet.orbits()])
    share = np.clip((np.log2(megno) - np.log2(1.5)) / (4 - np.log2(1.5)), 0.0, 1.0)
    np.testing.assert_allclose(paints("megno"), 48 * share, atol=0.51)
    paints("classification")


def test_no_regular_orbit_is_grey(sheet):
    """The largest crescent of Henon and Heiles at 1/8 has a number and a colour; a short one is undecided."""
    sheet.state("system=henon-heiles&crossings=500&energy=0.125&points=-0.3314:-0.03487,0.3:0.1")
    sheet.done(2)
    sheet.wait("!app.paintStale")
    crescent, other = sheet.orbits()
    assert crescent.reading["classification"] == other.reading["classification"] == "regular"
    assert crescent.reading["rotation"]["error"] < 1e-4
    assert sorted(sheet.get("[...app.orbits.shown.values()].map((one) => one.paint)")) == [0, 48]
    assert not any(row.split("\t")[4] == "–" for row in rows_of(sheet))
    sheet.state("system=henon-heiles&crossings=20&energy=0.125&points=0.3:0.1")
    sheet.done(1)
    sheet.wait("!app.paintStale")
    assert sheet.get("[...app.orbits.shown.values()].map((one) => one.paint)") == ["undecided"]
    assert sheet.page.locator("[data-part=scale]").inner_text().split() == ["undecided,", "no", "ν"]


def test_an_undecided_orbit_has_the_colour_of_its_number(sheet):
    """Before its classification is known, once its rotation number has an error below 0.005."""
    sheet.state("system=henon-heiles&crossings=150&energy=0.125&points=0.3:0.1,0.25:0.0")
    sheet.done(2)
    sheet.wait("!app.paintStale")
    orbits = sheet.orbits()
    assert {one.reading["classification"] for one in orbits} == {"undecided"}
    assert all(one.reading["rotation"]["error"] < 5e-3 for one in orbits)
    assert sorted(sheet.get("[...app.orbits.shown.values()].map((one) => one.paint)")) == [0, 48]


@pytest.mark.parametrize("energy", [0.05, 0.125, 1 / 6 - 1e-3])
def test_the_edge_of_the_region_is_a_curve(sheet, energy):
    """Its area is that of |v| < sqrt(2 E - y^2 + 2 y^3/3), as quadrature has it, to what chords of its cells leave."""
    sheet.state(f"system=henon-heiles&energy={energy}&points=")
    ends = np.sort(np.roots([-1 / 3, 1 / 2, 0.0, -energy]).real)[:2]
    angle = (np.arange(4000) + 0.5) * np.pi / 4000
    y = ends.mean() + np.ptp(ends) / 2 * np.cos(angle)
    speed = np.sqrt(np.maximum(0.0, 2 * energy - y**2 + 2 / 3 * y**3))
    exact = np.sum(2 * speed * np.ptp(ends) / 2 * np.sin(angle)) * np.pi / 4000
    outline = np.array(sheet.get("[...app.section.surface.outline]"), dtype=float).reshape(-1, 2)
    pieces = np.split(outline, np.flatnonzero(np.isnan(outline[:, 0])))
    area = 0.0
    for piece in pieces:
        x, v = piece[~np.isnan(piece[:, 0])].T
        if x.size and x.min() < 1.0:  # the region beyond the saddle at y = 1, beside the view, is open
            area += np.sum(x * np.roll(v, -1) - v * np.roll(x, -1)) / 2
    assert area == pytest.approx(exact, rel=3e-4)


def test_the_motion_is_that_of_the_orbit(sheet):
    sheet.state("crossings=60&points=0.3:0.2")
    sheet.done(1)
    sheet.wait("app.motion.windows.length > 0 && app.configuration.region !== null")
    (one,) = sheet.orbits()
    part = sheet.get("({ rows: app.motion.windows[0].rows, states: [...app.motion.windows[0].states] })")
    states = np.array(part["states"]).reshape(-1, part["rows"]).T
    np.testing.assert_allclose(states[4:, 0], one.z0, atol=1e-14)
    a1, a2, b1, b2 = one.z0[:4]  # axes (x + u, z - y)/sqrt 2 and (x - u, y + z)/sqrt 2
    phi = np.array([a1 + b1, b2 - a2, a2 + b2, a1 - b1]) / np.sqrt(2)
    np.testing.assert_allclose(states[:4, 0], phi, atol=1e-14)
    # The trace keeps to the region that is drawn.
    region = sheet.get("({ ...app.configuration.region, values: [...app.configuration.region.values] })")
    values = np.array([np.nan if value is None else value for value in region["values"]]).reshape(
        region["height"], region["width"]
    )
    q0, q1, r0, r1 = region["extent"]
    alpha, beta = np.hypot(*states[4:6]), np.hypot(*states[6:8])
    column = ((alpha - q0) / (q1 - q0) * region["width"]).astype(int)
    row = ((beta - r0) / (r1 - r0) * region["height"]).astype(int)
    body = fa.Body(fa.NeoHookean())
    assert np.mean(values[row, column] <= 0) > 0.98  # cells at the edge have their middle outside
    middle_alpha, middle_beta = (
        q0 + (column + 0.5) * (q1 - q0) / region["width"],
        r0 + (row + 0.5) * (r1 - r0) / region["height"],
    )
    exact = (
        body.potential.value(middle_alpha**2, middle_beta**2)
        + 0.3**2 / (2 * middle_alpha**2)
        + 0.2**2 / (2 * middle_beta**2)
        - 1.5
    )
    np.testing.assert_allclose(values[row, column], exact, rtol=1e-5, atol=1e-5)
    assert sheet.get("[app.motion.playing, app.motion.time]") == [False, 0]
    sheet.page.keyboard.press(" ")
    sheet.wait("app.motion.time > 0.05")
    sheet.page.keyboard.press(" ")
    assert sheet.get("app.motion.playing") is False


def test_configuration_space_fits_its_region(sheet):
    """The log potential of half widths sqrt(e^E - c^2) and 0.9 times that; a region that goes on has its cut marked."""
    sheet.state(
        "system=your-plane&formula=log(x**2%2B0.14**2%2B(y/0.9)**2)&coordinates=x+y&energy=0.125&section=x%3Dc&constant=0"
    )
    sheet.wait("app.configuration.region !== null")
    half = np.sqrt(np.exp(0.125) - 0.14**2)
    extent = np.array(sheet.get("app.configuration.region.extent"))
    exact = np.array([-half, half, -0.9 * half, 0.9 * half])
    assert (np.abs(extent) >= np.abs(exact)).all()
    np.testing.assert_allclose(extent, exact, rtol=0.08)
    cuts = (
        "(() => { const { values, width, height } = app.configuration.region;"
        " return [...values].some((value, k) => value <= 0 && (k < width || k >= width*(height - 1)"
        " || k % width === 0 || k % width === width - 1)); })()"
    )
    assert sheet.get(cuts) is False
    sheet.state("system=henon-heiles&energy=0.2")  # above the saddles: it goes on at three of them
    sheet.wait("app.configuration.region !== null")
    assert sheet.get(cuts) is True


@needs_node
def test_the_cut_of_a_region_is_marked():
    """Edges of the cells at the border that are in the region; where an angle goes round or alpha is 0, none."""
    region = "{ values: [-1, 1, -1, -1, 1, 1], width: 3, height: 2, extent: [0, 3, 0, 2], spans: [0, 0] }"
    found = compute(f"[cutsOf({region}, 'plane'), cutsOf({region}, 'body')]", "view_configuration.js")
    left, right, low, high = [[0, 0, 0, 1], [0, 1, 0, 2]], [[3, 0, 3, 1]], [[0, 0, 1, 0], [2, 0, 3, 0]], [[0, 2, 1, 2]]
    assert sorted(found[0]) == sorted(left + right + low + high)
    assert sorted(found[1]) == sorted(right + high)
    turning = region.replace("[0, 0] }", "[3, 0] }")
    assert sorted(compute(f"cutsOf({turning}, 'plane')", "view_configuration.js")) == sorted(low + high)


def test_beyond_a_million_points_their_density_is_drawn(sheet):
    sheet.state("system=henon-heiles&crossings=1&points=0.3:0.1")
    sheet.done(1)
    assert "density" not in sheet.text("count")
    sheet.page.evaluate(
        f"() => {{ {APP} const points = new Float64Array(2.4e6); let seed = 1;"
        " for (let i = 0; i < points.length; i++) { seed = (seed*16807) % 2147483647;"
        " points[i] = 0.2*(seed/2147483647 - 0.5); }"
        " app.backend.onmessage({ data: { type: 'points', orbit: app.orbits.chosen, first: 1, points } }); }"
    )
    sheet.wait("app.section.density.todo.length === 0 && app.part('count').textContent.includes('density')")
    drawn = sheet.get(
        "(({ counts, most }) => ({ sum: counts.reduce((a, b) => a + b, 0), most,"
        " counted: counts.reduce((a, b) => Math.max(a, b), 0) }))(app.section.density)"
    )
    assert drawn["sum"] == 1_200_001
    assert drawn["most"] == drawn["counted"] > 1
    before = sheet.get("app.section.density.key")
    sheet.do("zoom-in")
    sheet.wait("app.section.density.key !== given && app.section.density.todo.length === 0", before)
    sheet.do("clear")


def test_keys_launch_and_explain(sheet):
    sheet.state("system=henon-heiles&crossings=5")
    sheet.page.locator("canvas[data-part=front]").focus()
    for key in ("ArrowRight", "ArrowUp", "Enter"):
        sheet.page.keyboard.press(key)
    sheet.done(1)
    u0, u1, v0, v1 = sheet.get("app.section.frame.view")
    np.testing.assert_allclose(
        sheet.orbits()[0].point, [(u0 + u1) / 2 + (u1 - u0) / 60, (v0 + v1) / 2 + (v1 - v0) / 60], atol=1e-4
    )
    sheet.page.keyboard.press("Shift+ArrowRight")
    assert sheet.get("app.section.frame.view[0]") > u0
    sheet.page.keyboard.press("0")
    sheet.page.keyboard.press("?")
    assert sheet.page.locator("dialog").is_visible()
    assert "launch an orbit at the cursor" in sheet.text("keys")
    sheet.page.keyboard.press("Escape")
    assert not sheet.page.locator("dialog").is_visible()


def test_light_and_dark(sheet):
    assert sheet.get("app.root.dataset.theme") == "light"
    sheet.page.emulate_media(color_scheme="dark")
    sheet.wait("app.root.dataset.theme === 'dark' && app.colours.plot === '#0d1014'")
    sheet.do("theme")
    assert sheet.get("app.root.dataset.theme") == "light"
    sheet.do("theme")
    sheet.page.emulate_media(color_scheme="light")
    assert sheet.get("[app.root.dataset.theme, app.themeChoice]") == ["dark", "dark"]
    sheet.do("theme")
    sheet.wait("app.root.dataset.theme === 'light' && app.themeChoice === 'system'")


def test_on_a_telephone(browser, file):
    context = browser.new_context(
        viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True, reduced_motion="reduce"
    )
    sheet = Sheet(context, file.as_uri() + "#system=henon-heiles&crossings=20")
    assert sheet.get("document.documentElement.scrollWidth") <= 390
    tops = [sheet.page.locator(f"[data-{one}]").bounding_box()["y"] for one in ("part=stage", "do=box", "do=undo")]
    assert tops == sorted(tops)
    assert tops[0] < 100  # the plot is above the buttons
    order = sheet.page.evaluate(TABBED)
    assert [top for top, _ in order] == sorted(top for top, _ in order), order
    table = sheet.page.locator("[data-part=table]")
    assert table.get_attribute("data-more") is not None  # a sign that it goes on
    table.evaluate("(one) => { one.scrollLeft = one.scrollWidth; }")
    sheet.wait("!app.part('table').hasAttribute('data-more')")
    sheet.page.touchscreen.tap(*sheet.pixel(0.3, 0.1))
    sheet.done(1)
    np.testing.assert_allclose(sheet.orbits()[0].point, (0.3, 0.1), atol=0.01)
    view = sheet.get("app.section.frame.view")
    x, y = sheet.pixel(0.2, 0.0)
    touch = context.new_cdp_session(sheet.page)
    for kind, apart in (("touchStart", 20), ("touchMove", 30), ("touchMove", 60)):
        points = [{"x": x - apart, "y": y, "id": 1}, {"x": x + apart, "y": y, "id": 2}]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    sheet.wait("app.section.frame.view[1] - app.section.frame.view[0] < 0.4*given", view[1] - view[0])
    np.testing.assert_allclose(sheet.pixel(0.2, 0.0), (x, y), atol=1)
    assert sheet.get("app.orbits.shown.size") == 1
    assert sheet.get("document.documentElement.scrollWidth") <= 390
    assert sheet.said == []
    context.close()


def test_the_file_asks_nothing_of_anybody(file):
    text = file.read_text()
    assert not re.search(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", text)
    assert "default-src 'none'" in text
    assert "unsafe" not in text.split("</head>")[0]
    assert len(text.encode()) < 1_000_000
    own = text.split('id="setup">')[0] + text.split("</script>", 1)[1]
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function", own)


def test_where_all_orbits_escape_the_page_says_from_which_energy(browser, tmp_path):
    """The saddle of Henon and Heiles is at 1/6, the minimum at 0; x y has no minimum. A view has no walls."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    path = fa.explore(fa.HenonHeiles(), energy=3.0, section="x=0", points=[[-0.5], [2.2]], out=tmp_path / "page.html")
    sheet = Sheet(context, path.as_uri())
    sheet.wait("app.part('notice').textContent.includes('escape')")
    assert sheet.text("notice") == "Orbits can escape above E = 0.16667. Try E = 0.12."
    u0, u1 = sheet.get("app.section.surface.extent")[:2]
    outline = np.array(sheet.get("[...app.section.surface.outline]"), dtype=float).reshape(-1, 2)
    assert np.nanmax(outline[:, 0]) > u1  # where y goes on, V falls for ever
    assert np.nanmin(outline[:, 0]) > u0  # a wall
    path = fa.explore(fa.hamiltonian("x*y"), energy=0.2, section="y=0", out=tmp_path / "none.html")
    other = Sheet(context, path.as_uri())
    other.wait("app.part('notice').textContent.includes('no minimum')")
    assert other.text("title") == "System of a formula"
    assert other.text("formula-shown") == "V = x\u2009y"
    assert sheet.said == other.said == []
    context.close()


def test_where_nothing_comes_back_the_page_suggests_an_energy(browser, tmp_path):
    """Potentials that are 0 far away, of a minimum -1 and of none: under 0 orbits stay."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    for text, lower in (("-exp(-x**2 - y**2)", -0.25), ("-1/sqrt(x**2 + y**2)", -0.13)):
        with pytest.raises(ValueError, match=r"energy must be given .*, such as energy=-0") as said:
            fa.explore(fa.hamiltonian(text))
        path = fa.explore(
            fa.hamiltonian(text), energy=0.125, section="x=0", points=[[1.0], [0.3]], out=tmp_path / "free.html"
        )
        sheet = Sheet(context, path.as_uri())
        sheet.wait("app.part('notice').textContent.includes('escape')")
        assert sheet.text("notice") == f"Orbits can escape above E = 0. Try E = {lower:.2g}.".replace("-", "\u2212")
        sheet.wait("[...app.orbits.shown.values()].every((one) => one.reading.status === 'escaped')")
        (gone,) = sheet.orbits()  # a hundred widths of the view away
        assert gone.reading["time"] < 1e5
        sheet.wait("app.part('count').textContent.startsWith('1 orbit (1 undecided)')")
        for energy in (float(str(said.value).rpartition("=")[2]), lower):
            fa.energy_grid(fa.hamiltonian(text), energy=energy, section="x=0", axes=([0.4], [0.0]))
        assert sheet.said == []
    context.close()


def test_the_page_opens_alive(browser, tmp_path):
    """Twelve orbits of the region with the hint beside them; none where points are given, be it none."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    path = fa.explore(fa.HenonHeiles(), energy=0.11, section="x=0", out=tmp_path / "alive.html")
    sheet = Sheet(context, path.as_uri())
    sheet.done(12)
    u, v = np.array([one.point for one in sheet.orbits()]).T
    assert (v**2 < 2 * 0.11 - u**2 + 2 / 3 * u**3).all()
    assert sheet.page.locator("[data-part=hello]").is_visible()
    sheet.click(0.1, 0.1)
    sheet.done(13)
    assert sheet.page.locator("[data-part=hello]").is_hidden()
    for left in (12, 0):
        sheet.do("undo")
        sheet.wait("app.orbits.shown.size === given", left)
    sheet.page.locator("[data-part=system]").select_option("standard-map")
    sheet.wait("app.section.surface?.periods && app.orbits.shown.size === 12")
    path = fa.explore(fa.HenonHeiles(), energy=0.11, section="x=0", points=[], out=tmp_path / "still.html")
    quiet = Sheet(context, path.as_uri())
    quiet.wait("app.pending === null")
    assert quiet.get("app.orbits.shown.size") == 0
    assert sheet.said == quiet.said == []
    context.close()
