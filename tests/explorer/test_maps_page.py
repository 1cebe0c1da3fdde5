"""The explorer's page of a map in a browser: clicks, sliders, planes, what it reads, saves and sends by its address."""

from __future__ import annotations

import numpy as np
import pytest
from test_page import APP, saved

import fastaff as fa
from fastaff.jobs import Job
from fastaff.systems.models import FroeschleMap, StandardMap

TURN = 2 * np.pi


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The page of a standard map over a map of chaos whose angle begins at -pi."""
    model = StandardMap(0.9)
    grid = fa.energy_grid(model, axes={"x": np.linspace(-np.pi, np.pi, 25), "p": np.linspace(-3.0, 3.0, 13)})
    chaos = fa.chaos_map(model, grid, time=200, indicators="megno")
    return fa.explore(model, background=(chaos, grid), out=tmp_path_factory.mktemp("explorer") / "map.html"), chaos


@pytest.fixture(scope="module")
def address(file):
    return file[0].as_uri()


def iterates(model, z0, count):
    """Iterates (2n, count) with the rows that have a period within half of one around 0."""
    points = fa.poincare_map(model, z0, crossings=count).points[:, :, 0]
    periods = zip(points, model.periods(), strict=True)
    return np.array([np.mod(row + T / 2, T) - T / 2 if T > 0 else row for row, T in periods])


def opened_again(sheet, text, one):
    """Assert that an address opens the page with the one orbit that it had."""
    sheet.state(text)
    sheet.done(1)
    assert sheet.orbits()[0].z0 == one.z0
    np.testing.assert_array_equal(sheet.orbits()[0].points, one.points)


def test_clicks_launch_orbits_of_iterates(sheet):
    sheet.state("system=standard-map&parameter.K=0.6&crossings=400")
    for start in ((3.0, 0.2), (2.0, 2.1), (-0.4, -1.0)):
        sheet.click(*start)
    sheet.done(3)
    for one in sheet.orbits():
        assert one.point == one.z0
        exact = iterates(StandardMap(0.6), one.z0, 400)
        away = np.abs(one.points - exact)
        away[0] = np.minimum(away[0], TURN - away[0])
        assert away.max() < 1e-9
        assert one.reading["status"] == "done"
    assert (np.abs(sheet.orbits()[0].points[0]) <= np.pi).all()
    assert "iterates/s" in sheet.text("foot") or "Regular orbits agree with fastaff" in sheet.text("foot")


def test_only_what_a_map_has_is_shown(sheet):
    sheet.state("system=standard-map&crossings=2000&points=3.3:0.1,0.1:0.05")
    sheet.done(2)
    shown = (
        "[...app.root.querySelectorAll(given)].filter((one) => one.offsetParent !== null).map((one) => one.textContent)"
    )
    assert not any(
        "energy" in text.lower() for text in sheet.get(shown, ".controls h2, .controls .row, .controls .slider")
    )
    heads = [text.strip() for text in sheet.get(shown, ".table th")]
    assert heads[:7] == ["Orbit", "Classification", "Points", "Rotation ν", "Lyapunov λ", "MEGNO", "Status"]
    sheet.wait("app.table.order.length === 2 && !app.dirty.has('table')")
    rows = [row.split("\t") for row in sheet.page.locator("[data-part=rows] tr[data-orbit]").all_inner_texts()]
    wild, calm = [[cell for cell in row if cell] for row in rows]
    assert (wild[1], calm[1]) == ("chaotic", "regular")
    assert calm[3].startswith("0/1 · 0.1")  # in the island of the fixed point it turns about its centre
    assert sheet.page.locator("canvas[data-part=series]").is_visible()
    assert not sheet.page.locator("canvas[data-part=configuration]").is_visible()
    sheet.state("system=henon-heiles&crossings=20")
    assert sheet.page.locator("canvas[data-part=configuration]").is_visible()
    assert not sheet.page.locator("canvas[data-part=series]").is_visible()


def test_a_slider_starts_the_same_points_anew(sheet):
    sheet.state("system=standard-map&parameter.K=0.5&crossings=300&points=3:0.2")
    sheet.done(1)
    view = sheet.get("app.section.frame.view")
    sheet.number("K", "0.25")
    sheet.wait("app.state.parameters.K === 0.25 && app.pending === null && app.orbits.shown.size === 1")
    sheet.done(1)
    (one,) = sheet.orbits()
    assert (one.mark, one.point) == (1, [3, 0.2])
    np.testing.assert_allclose(one.points[1], iterates(StandardMap(0.25), [3, 0.2], 300)[1], atol=1e-10)
    assert sheet.get("app.section.frame.view") == view


def test_other_rows_start_where_they_are_told_to(sheet):
    sheet.state("system=froeschle-map&crossings=100&start.x_2=2.5&start.p_2=0.3&points=3:0.2")
    sheet.done(1)
    assert sheet.orbits()[0].z0 == [3, 2.5, 0.2, 0.3]
    sheet.number("p_2", "0.4")
    sheet.wait("app.state.others.p_2 === 0.4 && app.pending === null && app.orbits.shown.size === 1")
    sheet.done(1)
    (one,) = sheet.orbits()
    assert one.z0 == [3, 2.5, 0.2, 0.4]
    exact = iterates(FroeschleMap(), one.z0, 100)
    np.testing.assert_allclose(one.points, exact[[0, 2]], atol=1e-10)
    sheet.wait("location.hash.includes('start.p_2=0.4')")
    text = sheet.get("location.hash")
    sheet.page.locator("[data-part=section]").select_option("x_2,p_2")
    sheet.wait("app.section.surface?.axes[0] === 'x_2'")
    assert sheet.get("app.orbits.shown.size") == 0
    sheet.click(1.0, 0.5)
    sheet.done(1)
    assert sheet.orbits()[0].z0[0::2] == [0, 0]
    opened_again(sheet, text, one)


def test_a_map_of_ones_own(sheet, here):
    sheet.state("system=your-map&crossings=200")
    assert sheet.text("title") == "Your map"
    sheet.page.locator("[data-part=formula]").fill("k = p + K*sin(w*x); x' = x + k; p' =")
    sheet.wait("!app.part('wrong-formula').hidden")
    assert "name = formula" in sheet.text("wrong-formula")
    sheet.page.locator("[data-part=formula]").fill("k = p + K*sin(w*x); x' = x + k; p' = k")
    sheet.page.locator("[data-part=periodic]").fill("x=2*pi/w")
    sheet.wait("app.section.surface !== null && app.part('wrong-formula').hidden && 'w' in app.state.parameters")
    sheet.number("w", "2")
    sheet.wait("app.section.surface?.periods[0] < 3.2 && app.pending === null")
    sheet.do("whole")
    sheet.click(-1.4, 0.1)
    sheet.done(1)
    (one,) = sheet.orbits()
    sheet.wait("location.hash.includes('points=')")
    text = sheet.get("location.hash")
    model = fa.iterated_map("k = p + K*sin(w*x); x' = x + k; p' = k", periodic={"x": "2*pi/w"}, K=0.9, w=2.0)
    away = np.abs(one.points - iterates(model, one.z0, 200))
    assert np.minimum(away, np.pi - away).max() < 1e-9
    files = saved(sheet, "save-job", here, 2)
    cut = fa.run(Job.read(next(path for path in files if path.suffix == ".toml")), "own.zarr")["poincare"]
    np.testing.assert_allclose(cut["p"][:, 0], one.points[1], atol=1e-9)
    # Four variables have two planes.
    sheet.page.locator("[data-part=formula]").fill("a1 = a + u1; b1 = b + v1; u1 = u + K*sin(w*a); v1 = v + K*sin(w*b)")
    sheet.wait("!app.part('wrong-formula').hidden")
    assert "no value yet" in sheet.text("wrong-formula")
    sheet.page.locator("[data-part=periodic]").fill("")
    sheet.page.locator("[data-part=formula]").fill("u1 = u + K*sin(w*a); v1 = v + K*sin(w*b); a1 = a + u1; b1 = b + v1")
    sheet.wait("app.section.surface !== null && app.state.section === 'u,a'")
    assert sheet.page.locator("[data-part=section] option").count() == 2
    opened_again(sheet, text, one)


def test_a_saved_job_gives_the_same_iterates(sheet, here):
    sheet.state("system=froeschle-map&parameter.K_1=0.3&crossings=50&start.x_2=3&points=3:0.2,2.9:-0.1")
    sheet.done(2)
    found = sheet.orbits()
    files = saved(sheet, "save-job", here, 2)
    assert sorted(path.name for path in files) == ["froeschle-map.npy", "froeschle-map.toml"]
    np.testing.assert_array_equal(np.load("froeschle-map.npy"), np.array([one.z0 for one in found]).T)
    cut = fa.run(Job.read("froeschle-map.toml"), "job.zarr")["poincare"]
    for i, one in enumerate(found):
        exact = np.array([np.mod(cut["x_1"][:, i] + np.pi, TURN) - np.pi, cut["p_1"][:, i]])
        np.testing.assert_allclose(exact, one.points, atol=1e-10)
    (path,) = saved(sheet, "save-grid", here)
    plan = Job.read(path).plan()
    assert plan.launch.size == 64
    _, _, v0, v1 = sheet.get("app.section.frame.view")
    z, _ = plan.launch.points(0)
    np.testing.assert_allclose(np.unique(z[0].round(9)), TURN * ((np.arange(8) + 0.5) / 8 - 0.5), atol=1e-8)
    assert (z[1] == 3).all()
    np.testing.assert_allclose([z[2].min(), z[2].max()], [v0 + (v1 - v0) / 16, v1 - (v1 - v0) / 16])


def test_the_map_below_is_read_in_every_period(sheet, file):
    chaos, cells = file[1], np.full((25, 13), np.nan)
    cells.flat[:] = chaos.megno
    sheet.state("system=standard-map&parameter.K=0.9&crossings=10")
    assert sheet.page.locator("[data-do=background]").is_enabled()
    for column, row in ((3, 4), (20, 9), (12, 6)):
        x, p = -np.pi + column * TURN / 24, -3 + row * 0.5
        sheet.page.mouse.move(*sheet.pixel((x + np.pi) % TURN - np.pi, p))
        value = f"{cells[column, row]:.4g}".rstrip("0").rstrip(".").replace("-", "\u2212")
        sheet.wait("app.part('readout').textContent.includes(given)", f"MEGNO {value}")
    sheet.number("K", "0.8")
    sheet.wait("app.part('notice').textContent.includes('K = 0.9')")
    assert sheet.page.locator("[data-do=background]").is_disabled()


def test_fill_undo_zoom_and_picture(sheet, tmp_path):
    from PIL import Image

    sheet.state("system=henon-map&crossings=300")
    sheet.page.locator("[data-part=grid]").select_option("4")
    sheet.do("fill")
    sheet.done(16)
    assert {one.reading["status"] for one in sheet.orbits()} <= {"done", "escaped"}
    sheet.do("zoom-in")
    (path,) = saved(sheet, "save-picture", tmp_path)
    assert path.name == "henon-map.png"
    assert np.asarray(Image.open(path).convert("RGB")).std() > 5
    sheet.do("undo")
    assert sheet.get("app.orbits.shown.size") == 0
    # Beyond half a period, and beyond the first view, there are points too.
    sheet.state("system=standard-map&crossings=20")
    sheet.do("zoom-out")
    sheet.click(3.5, 4.0)
    sheet.done(1)
    (one,) = sheet.orbits()
    assert -2.85 < one.point[0] < -2.7
    assert one.point[1] == pytest.approx(4.0, abs=0.05)
    assert sheet.page.evaluate(f"() => {{ {APP} return app.root.dataset.kind; }}") == "map"


@pytest.mark.parametrize(
    "hostile", ["start.x_2=alert(1)", "energy=1", "start.__proto__=1", "section=x_1,p_2", "parameter.b=NaN"]
)
def test_an_address_of_a_map_gives_numbers_only(sheet, hostile):
    sheet.page.evaluate("(text) => { location.hash = ''; location.hash = text; }", "system=froeschle-map&" + hostile)
    sheet.wait("app.part('notice').textContent.includes('were ignored')")
    state = sheet.get("app.state")
    assert state["others"] == {"x_1": 0, "x_2": 0, "p_1": 0, "p_2": 0}
    assert (state["energy"], state["section"]) == (None, "x_1,p_1")
    assert state["parameters"] == {"K_1": 0.5, "K_2": 0.3, "b": 0.02}
