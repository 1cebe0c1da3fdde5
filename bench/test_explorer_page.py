"""The explorer's page in a browser: frames a second with many points, time from a click to the first points drawn.

Run: pytest bench/test_explorer_page.py -s. Headless Chromium draws by SwiftShader, on the processor: a machine with a
graphics card draws faster.
"""

from __future__ import annotations

import shutil
import time

import pytest

import fastaff as fa

BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
APP = "const app = document.querySelector('.explorer').explorer;"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    api = pytest.importorskip("playwright.sync_api")
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.skip("there is no Chromium on this machine")
    file = fa.explore(fa.HenonHeiles(), energy=0.125, out=tmp_path_factory.mktemp("explorer") / "page.html")
    with api.sync_playwright() as player:
        browser = player.chromium.launch(executable_path=path, args=FLAGS)
        page = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce").new_page()
        page.goto(file.as_uri() + "#system=henon-heiles&crossings=300")
        wait(page, "app.section.surface !== null")
        yield page
        browser.close()


def wait(page, expression):
    end = time.monotonic() + 60
    while not page.evaluate(f"() => {{ {APP} return {expression}; }}"):
        assert time.monotonic() < end, expression
        time.sleep(0.02)


def test_first_points_after_a_click(page):
    """Five clicks one after another: milliseconds until the first points are drawn."""
    for k in range(5):
        x, y = 520 + 40 * k, 290
        page.mouse.click(x, y)
        wait(page, f"app.firstPoints.length > {k}")
        wait(page, "[...app.orbits.shown.values()].every((one) => one.reading.status === 'done')")
    times = page.evaluate(f"() => {{ {APP} return app.firstPoints; }}")
    print("\nfrom click to first points, ms:", ", ".join(f"{value:.0f}" for value in times))


@pytest.mark.parametrize("software", [True, False])
@pytest.mark.parametrize("points", [10_000, 100_000, 900_000, 3_000_000])
def test_frames(page, points, software):
    """The view moves in every frame; points of 20 orbits by the processor or by WebGL2; 3 million are counted."""
    page.evaluate(
        "([points, software]) => {" + APP + " app.section.software = software;"
        " app.actions.do('clear');"
        " for (let k = 0; k < 20; k++) { app.actions.click(0.3, 0.1); const number = app.orbits.chosen;"
        " const all = new Float64Array(points/10);"
        " for (let i = 0; i < all.length; i++) all[i] = 0.6*(Math.random() - 0.5);"
        " app.backend.onmessage({ data: { type: 'points', orbit: number, first: 0, points: all } }); } }",
        [points, software],
    )
    page.wait_for_timeout(1500)
    frames = page.evaluate(
        "() => new Promise((done) => {" + APP + " let count = 0; const begun = performance.now();"
        " const next = () => { app.actions.pan(count % 2 ? 0.01 : -0.01, 0); count++;"
        " const time = performance.now() - begun;"
        " if (time < 3000) requestAnimationFrame(next); else done(1000*count/time); };"
        " requestAnimationFrame(next); })"
    )
    own = page.evaluate(
        "() => {" + APP + " const begun = performance.now(); for (let k = 0; k < 20; k++) app.drawSection();"
        " return (performance.now() - begun)/20; }"
    )
    by = "processor" if software else "WebGL2"
    print(f"\n{points} points by {by}: {frames:.0f} frames/s, {own:.2f} ms of the page's own in each")
