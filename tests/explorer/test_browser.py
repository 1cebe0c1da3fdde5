"""The explorer's engine in headless Chromium: the file as it is written, opened from the disk."""

# ruff: noqa: E501 (lines of JavaScript)

import math
from pathlib import Path

import numpy as np
import pytest
from page_engine import launch_message, own_points

import fastaff as fa

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


def opened(browser, path: Path):
    """The page of a file, with what its workers say, and what its console and the network heard."""
    page, said = browser.new_page(viewport={"width": 1280, "height": 800}), []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda problem: said.append(str(problem)))
    page.on(
        "request",
        lambda request: None if request.url.startswith(("file:", "blob:", "data:")) else said.append(request.url),
    )
    page.add_init_script(LISTEN)
    page.goto(path.as_uri())
    return page, said


@pytest.mark.parametrize(
    ("body", "section", "energy", "point", "momenta"),
    [
        (fa.HenonHeiles(0.9), fa.Linear((1.0, 0.0, 0.0, 0.0)), 0.1, (0.12, 0.05), {}),
        (fa.Body(fa.NeoHookean(1.1, 1.7)), fa.AlphaTurning(), 1.5, (0.5, 0.1), {"p_eta": 0.3, "p_gamma": 0.2}),
    ],
    ids=["plane", "body"],
)
def test_first_crossings_in_chromium(browser, tmp_path, body, section, energy, point, momenta):
    path = fa.explore(body, energy=energy, section=section, accuracy=1e-11, out=tmp_path / "page.html", **momenta)
    page, said = opened(browser, path)
    (surface, *_) = page.evaluate(WAIT, ["surface", None, 20000])
    assert surface["energy"] == energy
    page.evaluate("(message) => window.workers.at(-1).postMessage(message)", launch_message(77, point, 12))
    (last, *_) = page.evaluate(WAIT, ["reading", 77, 20000])[::-1]
    assert last["status"] == "done"
    (launched,) = page.evaluate(WAIT, ["launched", 77, 1000])
    parts = page.evaluate(WAIT, ["points", 77, 1000])
    times = np.concatenate([part["times"] for part in parts])
    points = np.concatenate([part["points"] for part in parts]).reshape(-1, 2).T
    z0 = np.array(launched["z0"])
    result = fa.poincare_map(body, z0, section=section, crossings=12, max_time=500.0, accuracy=1e-11, threads=1)
    sure = result.times[:, 0] <= result.accurate_until[0]
    assert sure.sum() >= 8
    np.testing.assert_allclose(times[sure], result.times[sure, 0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(points[:, sure], own_points(result, body, section)[:, sure], rtol=0, atol=1e-9)
    assert math.isfinite(last["megno"])
    assert not [text for text in said if "GL Driver Message" not in text]  # remarks of Chromium on its own renderer
    page.close()
