"""The explorer of maps: iterates a second of the printed text in Node, and of the page in Chromium with tangent vector,
points and readings; beside them the package's own. Run: pytest bench/test_explorer_maps.py -s
"""

# ruff: noqa: E501 (lines of JavaScript)

from __future__ import annotations

import json
import time

import pytest
from page_engine import compute, launch_message
from test_explorer import FLAGS, FOUND, LISTEN, WAIT

import fastaff as fa
from fastaff.explorer.parameters import parameter_values
from fastaff.explorer.records import model_code
from fastaff.systems.models import FroeschleMap, HenonMap, OneTurnMap, StandardMap
from fastaff.systems.models.mechanics import system_of

COUNT = 4_000_000
MODELS = {type(model).__name__: model for model in (StandardMap(0.9), HenonMap(), FroeschleMap(), OneTurnMap())}


@pytest.mark.parametrize("name", MODELS)
def test_iterates_in_node(name):
    """Time the iterates with a tangent vector, eight at a time as the page has them; the package's on one thread."""
    model = MODELS[name]
    z0, parameters = [0.1] * (2 * model.degrees_of_freedom), json.dumps(list(parameter_values(model).values()))
    taken = compute(
        f"""(() => {{
          const system = new Function(systemText({json.dumps(model_code(system_of(model)))}) + "return compiledSystem;")();
          const P = {parameters}, z = Float64Array.from({z0}), w = z.slice(), out = new Float64Array(8*3*z.length);
          const run = (n) => {{ for (let k = 0; k < n; k += 8) system.iterates(z, w, P, 8, out); w.fill(0.1); }};
          run(80000); const t = performance.now(); for (let k = 0; k < {COUNT}; k += 800) run(800); return performance.now() - t;
        }})()""",
        "system.js",
    )
    fa.chaos_map(model, z0, time=100, indicators="megno", threads=1)
    begun = time.perf_counter()
    fa.chaos_map(model, z0, time=COUNT // 10, indicators="megno", threads=1)
    own = (time.perf_counter() - begun) / (COUNT // 10)
    print(
        f"\n{name}: {COUNT / taken / 1e3:.1f} million iterates/s with a tangent vector in Node, {1e6 * taken / COUNT:.0f} ns each; "
        f"one orbit of chaos_map on one thread {1e9 * own:.0f} ns"
    )


@pytest.mark.skipif(FOUND is None, reason="there is no Chromium here")
@pytest.mark.parametrize("name", MODELS)
def test_page_in_chromium(tmp_path, name):
    """Time the page: from opening to the plane, and iterates a second with points, tangent vector and readings."""
    playwright = pytest.importorskip("playwright.sync_api")
    path = fa.explore(MODELS[name], out=tmp_path / "page.html")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=FOUND, args=FLAGS)
        page = browser.new_page()
        page.add_init_script(LISTEN)
        page.goto(path.as_uri())
        opened = page.evaluate(WAIT, ["surface", None, 20000])[0]["at"]
        page.evaluate(
            "(m) => window.workers.at(-1).postMessage(m)",
            launch_message(200, (3.3, 0.1) if name in ("StandardMap", "FroeschleMap") else (0.1, 0.05), 3 * 10**6),
        )
        page.evaluate(WAIT, ["reading", 200, 20000])
        speeds = page.evaluate("window.heard.filter((m) => m.type === 'speed').map((m) => m.steps_per_second)")
        last = page.evaluate("window.heard.filter((m) => m.type === 'reading').at(-1).crossings")
        browser.close()
    print(
        f"\n{name}: plane {opened:.0f} ms after opening; {max(speeds) / 1e6:.1f} million iterates/s in Chromium; {last} iterates"
    )
