"""The browser of the explorer's pages, and one open page of each module, at the `address` that this gives."""

import os
import shutil

import pytest

BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="playwright drives the browser: fastaff[test]")
    path = os.environ.get("FASTAFF_CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.skip("there is no Chromium here: FASTAFF_CHROMIUM names one")
    with api.sync_playwright() as player:
        launched = player.chromium.launch(executable_path=path, args=FLAGS)
        yield launched
        launched.close()


@pytest.fixture(scope="module")
def one_sheet(browser, address):
    from test_page import Sheet

    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    yield Sheet(context, address)
    context.close()


@pytest.fixture
def sheet(one_sheet):
    """The page, which must say nothing on its console."""
    yield one_sheet
    assert one_sheet.said == []
