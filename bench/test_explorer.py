"""The explorer: steps a second in Node and in Chromium, with and without a tangent vector; first points after a click;
size of the page. Run: pytest bench/test_explorer.py -s
"""

# ruff: noqa: E501 (lines of JavaScript)

from __future__ import annotations

import json
import os
import shutil
import time

import pytest
from page_engine import compute, launch_message, system_message

import fastaff as fa
from fastaff.explorer.records import model_code
from fastaff.explorer.setup import scheme_record
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8
from fastaff.systems.models.mechanics import system_of

FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
FOUND = os.environ.get("FASTAFF_CHROMIUM") or shutil.which("chromium-headless-shell") or shutil.which("chromium")
LISTEN = """
const Plain = window.Worker;
window.heard = [];
window.workers = [];
window.Worker = class extends Plain {
  constructor(url) {
    super(url);
    window.workers.push(this);
    this.addEventListener("message", (event) => window.heard.push({ ...event.data, at: performance.now() }));
  }
};
"""
WAIT = """([kind, orbit, most]) => new Promise((done) => {
  const begun = performance.now();
  const look = () => {
    const found = window.heard.filter((m) => m.type === kind && (orbit === null || m.orbit === orbit));
    const last = found[found.length - 1];
    const ready = last && (kind !== "reading" || last.status !== "running");
    if (ready || performance.now() - begun > most) {
      done(found.map((m) => ({ ...m, ...Object.fromEntries(["points", "times", "z0"].filter((k) => m[k]).map((k) => [k, [...m[k]]])) })));
    } else setTimeout(look, 5);
  };
  look();
})"""
STEPS = 2_000_000
SYSTEMS = {"Henon-Heiles": (fa.HenonHeiles(), [0.0, 0.1, 0.42, 0.05]), "neo-Hookean": (fa.Body(fa.NeoHookean()), None)}
Z8 = [1.5, 0.0, 0.3, 0.0, 0.0, 0.2, 0.1, 0.3]


@pytest.mark.parametrize("name", SYSTEMS)
def test_steps_in_node(name):
    """Time the bare steps of the printed text."""
    body, z0 = SYSTEMS[name]
    record, z = scheme_record(BLANES_CASAS_ESCORIHUELA8), json.dumps(z0 or Z8)
    parameters = json.dumps(list(system_message(body)["system"]["parameters"].values()))
    plain, tangent = compute(
        f"""(() => {{
          const system = new Function(systemText({json.dumps(model_code(system_of(body)))}) + "return compiledSystem;")();
          const a = Float64Array.from({record["a"]}), b = Float64Array.from({record["b"]}), P = {parameters};
          const timed = (call) => {{ call(20000); const t = performance.now(); call({STEPS}); return performance.now() - t; }};
          const z = Float64Array.from({z}), y = z.slice(), u = z.slice();
          return [timed((n) => {{ for (let k = 0; k < n; k++) system.march(z, P, a, b, 0.1, 1); }}),
            timed((n) => {{ for (let k = 0; k < n; k++) system.marchTangent(y, u, P, a, b, 0.1, 1); }})];
        }})()""",
        "system.js",
    )
    rates = [STEPS / (1e-3 * t) / 1e6 for t in (plain, tangent)]
    print(f"\n{name}, {record['name']}, Node: {rates[0]:.2f} million steps/s, {rates[1]:.2f} with a tangent vector")


@pytest.mark.skipif(FOUND is None, reason="there is no Chromium here")
def test_page_in_chromium(tmp_path):
    """Time the page: from opening to the surface, from a launch to points, and steps a second with all readings."""
    playwright = pytest.importorskip("playwright.sync_api")
    path = fa.explore(fa.HenonHeiles(), energy=0.1, out=tmp_path / "page.html")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=FOUND, args=FLAGS)
        page = browser.new_page()
        page.add_init_script(LISTEN)
        page.goto(path.as_uri())
        surface = page.evaluate(WAIT, ["surface", None, 20000])[0]["at"]
        waits = []
        for orbit in range(101, 111):
            message = launch_message(orbit, (0.1, 0.05), 30)
            sent = page.evaluate("(m) => { window.workers.at(-1).postMessage(m); return performance.now(); }", message)
            waits.append(page.evaluate(WAIT, ["points", orbit, 5000])[0]["at"] - sent)
        page.evaluate("(m) => window.workers.at(-1).postMessage(m)", launch_message(200, (0.1, 0.05), 10**7))
        time.sleep(6)
        speeds = page.evaluate("window.heard.filter((m) => m.type === 'speed').map((m) => m.steps_per_second)")
        browser.close()
    print(
        f"\npage {path.stat().st_size / 1e3:.0f} kB; surface {surface:.0f} ms after opening; points {min(waits):.0f} to "
        f"{max(waits):.0f} ms after a launch; {max(speeds) / 1e6:.2f} million steps/s of Henon-Heiles with tangent vector, "
        "crossings and readings in Chromium"
    )
