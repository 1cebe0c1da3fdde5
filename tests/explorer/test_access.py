"""The explorer for everybody: names of controls, contrast of colours, landmarks, sizes of targets, keys."""

# ruff: noqa: E501 (lines of JavaScript)

import re
from html.parser import HTMLParser

import pytest
from page_engine import compute, needs_node
from test_page import Sheet

import fastaff as fa
from fastaff.explorer.page import web_text

TEXTS = [
    ("text", "ground"),
    ("text", "panel"),
    ("text", "plot"),
    ("text", "inaccessible"),
    ("quiet", "ground"),
    ("quiet", "panel"),
]
TEXTS += [("quiet", "plot"), ("wrong", "ground"), ("wrong", "panel"), ("accent", "panel"), ("on-accent", "accent")]
NAMELESS = """() => [...document.querySelectorAll("button, input, select, textarea, canvas[tabindex], summary")]
  .filter((one) => !(one.getAttribute("aria-label") ?? "").trim() && !one.textContent.trim()
    && ![...(one.labels ?? [])].some((label) => label.textContent.replace(one.textContent, "").trim()))
  .map((one) => one.outerHTML.slice(0, 90))"""
UNLABELLED = """() => [...document.querySelectorAll("input, select, textarea")]
  .filter((one) => !one.getAttribute("aria-label") && !one.labels?.length).map((one) => one.outerHTML.slice(0, 90))"""
SMALL = """() => [...document.querySelectorAll("button, select, input, summary, textarea")].filter((one) => one.offsetParent)
  .map((one) => [one.outerHTML.slice(0, 90), one.getBoundingClientRect()]).filter(([, box]) => Math.min(box.width, box.height) < 23.9)
  .map(([text]) => text)"""


def luminance(colour):
    """The relative luminance of #rrggbb. WCAG 2.2, 1.4.3."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def themes():
    """The colours of the light and the dark theme."""
    light, dark = (
        dict(re.findall(r"--([a-z-]+): (#[0-9a-f]{6})", block)) for block in web_text("style.css").split("}")[:2]
    )
    return {"light": light, "dark": light | dark}


def test_texts_stand_out():
    """4.5 of every text on every ground that it stands on, in both themes; a row that is hidden too."""
    for colours in themes().values():
        for text, ground in TEXTS:
            assert contrast(colours[text], colours[ground]) >= 4.5, (text, ground)
        share = float(re.search(r"is-hidden td \{ opacity: ([0-9.]+)", web_text("style.css"))[1])
        text, ground = ([int(colours[name][k : k + 2], 16) for k in (1, 3, 5)] for name in ("text", "ground"))
        mixed = [round(share * a + (1 - share) * b) for a, b in zip(text, ground, strict=True)]
        assert contrast("#" + "".join(f"{part:02x}" for part in mixed), colours["ground"]) >= 4.5


@needs_node
def test_orbits_stand_out():
    """3 of the colour of every orbit on the ground of the section, as of all that is drawn."""
    for theme, colours in themes().items():
        for colour in compute(f'[0, 1, 2, 3, 4, 5, 6, 7].map((k) => orbitColour(k, "{theme}"))', "colours.js"):
            assert contrast(colour, colours["plot"]) >= 3.0, (theme, colour)


class Outline(HTMLParser):
    """Tags of a page with their attributes, in order."""

    def __init__(self, text):
        super().__init__()
        self.tags = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def all(self, *names):
        return [attributes for tag, attributes in self.tags if tag in names]


def test_the_page_has_its_landmarks():
    page = Outline(web_text("page.html"))
    assert page.all("html")[0]["lang"] == "en"
    assert [len(page.all(name)) for name in ("title", "main", "h1")] == [1, 1, 1]
    names = {entry.get("name") for entry in page.all("meta")}
    assert {"viewport", "description"} <= names
    assert not any("user-scalable" in entry.get("content", "") for entry in page.all("meta"))
    assert all(section.get("aria-label") for section in page.all("section"))
    assert all(int(one.get("tabindex", 0)) <= 0 for _, one in page.tags)
    assert all(one.get("aria-label") or one.get("aria-hidden") for one in page.all("canvas"))
    assert all(one.get("type") == "button" for one in page.all("button")[:-1])  # the last closes its dialog
    parts = [one["data-part"] for _, one in page.tags if "data-part" in one]
    assert len(parts) == len({*parts})


@pytest.mark.parametrize("width", [1280, 390])
def test_every_control_has_a_name_and_room(browser, tmp_path, width):
    """A name, 24 pixels each way, nothing beside a telephone's screen; the title is that of the system; keys reach all."""
    path = fa.explore(fa.HenonHeiles(), energy=0.1, points=[[0.1, 0.2], [0.0, 0.1]], out=tmp_path / "page.html")
    context = browser.new_context(viewport={"width": width, "height": 844}, reduced_motion="reduce")
    sheet = Sheet(context, path.as_uri())
    sheet.done(2)
    for system in ("henon-heiles", "neo-hookean", "your-plane", "your-ode", "froeschle-map"):
        sheet.state(f"system={system}&crossings=5" + ("&points=0.1:0.1" if system == "henon-heiles" else ""))
        assert sheet.page.evaluate(NAMELESS) == []
        assert sheet.page.evaluate(UNLABELLED) == []
        assert sheet.page.evaluate(SMALL) == []
        assert sheet.page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")
    assert sheet.page.title() == "Froeschlé’s map – fastaff explorer"
    sheet.state("system=henon-heiles&crossings=5")
    sheet.page.locator("[data-part=front]").focus()
    for key in ("ArrowRight", "ArrowUp", "Enter"):
        sheet.page.keyboard.press(key)
    sheet.done(1)
    sheet.wait("app.part('readout').getAttribute('aria-live') === 'polite' && app.part('readout').textContent !== ''")
    button = sheet.page.locator("[data-part=rows] button").nth(2)
    assert button.get_attribute("aria-label") == "Remove orbit 1"
    button.focus()
    assert sheet.page.evaluate("() => getComputedStyle(document.activeElement).outlineStyle") != "none"
    sheet.page.keyboard.press("Enter")
    sheet.wait("app.orbits.shown.size === 0")
    assert sheet.said == []
    context.close()


FOCUS = """() => { const one = document.activeElement;
  return one.getAttribute("aria-label") || one.dataset.do || one.dataset.part || one.textContent }"""
COVERED = """() => { const one = document.activeElement, box = one.getBoundingClientRect();
  return document.elementFromPoint(box.x + box.width / 2, box.y + 2) !== one }"""


def test_keys_alone_reach_every_orbit(browser, tmp_path):
    """Of more rows than are elements of the page, both ways, none under the head of the table; a button that takes its row away leaves the focus to the next one's; the list of colours keeps it."""
    path = fa.explore(fa.HenonHeiles(), energy=0.1, out=tmp_path / "page.html")
    context = browser.new_context(viewport={"width": 1280, "height": 700}, reduced_motion="reduce")
    sheet = Sheet(context, path.as_uri())
    sheet.state("system=henon-heiles&crossings=5")
    sheet.page.locator("[data-part=grid]").select_option("8")
    sheet.page.locator("[data-do=fill]").press("Enter")
    count = 36  # cells of the grid that have the energy
    sheet.done(count)
    table = sheet.page.locator("[data-part=table]")
    table.focus()
    table.evaluate("(element) => { element.scrollTop = 0 }")
    seen, rows = [], "() => new Promise((ready) => requestAnimationFrame(() => setTimeout(ready, 30)))"
    sheet.wait("document.querySelector(given)", f"[aria-label='Remove orbit {count}']")
    sheet.page.evaluate(rows)
    for _ in range(3 * count):
        sheet.page.keyboard.press("Tab")
        sheet.page.evaluate(rows)
        seen.append(sheet.page.evaluate(FOCUS))
    marks = [int(name.split()[-1]) for name in seen if name.startswith("Remove orbit")]
    assert marks == sorted(marks, reverse=True)
    assert len(marks) == count
    for _ in range(40):
        sheet.page.keyboard.press("Shift+Tab")
        sheet.page.evaluate(rows)
        assert not sheet.page.evaluate(COVERED), sheet.page.evaluate(FOCUS)
    before = sheet.page.evaluate(FOCUS)
    sheet.page.locator(f"[aria-label='Remove orbit {before.split()[-1]}']").press("Enter")
    sheet.wait(f"app.orbits.shown.size === {count - 1} && !document.querySelector(\"[aria-label='{before}']\")")
    assert sheet.page.evaluate(FOCUS) == f"Remove orbit {int(before.split()[-1]) - 1}"
    paint = sheet.page.locator("[data-part=paint]")
    sheet.page.locator("[data-do=density]").focus()
    sheet.page.keyboard.press("Tab")
    paint.press("ArrowDown")
    assert sheet.page.evaluate(FOCUS) == "paint"
    assert sheet.said == []
    context.close()


def test_the_menu_and_what_is_wrong(browser, tmp_path):
    """Esc closes the menu and gives the focus back, as does leaving it; a wrong formula has its sentence; on a telephone the section comes before its controls."""
    path = fa.explore(fa.HenonHeiles(), energy=0.1, points=[[0.1], [0.2]], out=tmp_path / "page.html")
    context = browser.new_context(viewport={"width": 390, "height": 844}, reduced_motion="reduce")
    sheet = Sheet(context, path.as_uri())
    sheet.done(1)
    page, opened = sheet.page, "() => document.querySelector('[data-part=save]').open"
    summary = page.locator("[data-part=save] > summary")
    summary.press("Enter")
    page.keyboard.press("Tab")
    assert page.evaluate(FOCUS) == "save-picture"
    page.keyboard.press("Escape")
    assert not page.evaluate(opened)
    assert page.evaluate("() => document.activeElement.tagName") == "SUMMARY"
    assert page.evaluate("() => document.querySelector('.explorer').explorer.orbits.chosen !== null")
    summary.press("Enter")
    for _ in range(5):
        page.keyboard.press("Tab")
    assert page.evaluate(FOCUS) == "theme"
    assert not page.evaluate(opened)
    page.locator("[data-do=help]").focus()
    page.keyboard.press("Tab")
    assert page.evaluate(FOCUS) == "Orbits"  # the table: as they are seen, whatever the browser
    page.locator("[data-part=front]").focus()
    page.keyboard.press("Tab")
    assert page.evaluate(FOCUS) == "box"
    sheet.page.set_viewport_size({"width": 1280, "height": 844})
    sheet.wait("document.querySelector('.bar .buttons') !== null")
    page.locator("[data-do=help]").focus()
    page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement.closest('.controls') !== null")
    sheet.page.set_viewport_size({"width": 390, "height": 844})
    sheet.wait("document.querySelector('.bar .buttons') === null")
    sheet.state("system=your-plane")
    for part, text in (("coordinates", "x"), ("drive_period", "2*pi/w"), ("formula", "x**2/2 - f*x*cos(w*t)")):
        page.locator(f"[data-part={part}]").fill(text)
        page.locator(f"[data-part={part}]").press("Tab")
    sheet.wait("app.root.dataset.driven !== undefined")
    for script in (NAMELESS, UNLABELLED, SMALL):
        assert page.evaluate(script) == []
    formula = page.locator("[data-part=formula]")
    formula.fill("x**2/2 - f*x*cos(w*t")
    formula.press("Tab")
    sheet.wait("app.part('formula').getAttribute('aria-invalid') === 'true'")
    described = formula.get_attribute("aria-describedby")
    assert "was never closed" in page.locator(f"#{described}").inner_text()
    formula.fill("x**2/2 - f*x*cos(w*t)")
    formula.press("Tab")
    sheet.wait("!app.part('formula').hasAttribute('aria-describedby')")
    assert sheet.said == []
    context.close()
