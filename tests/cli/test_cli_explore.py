"""`fastaff explore`: the page is written, its path printed, and the browser opens it where that is asked for."""

import webbrowser

import pytest

pytest.importorskip("cyclopts")

from fastaff.cli.main import main

WORDS = ["explore", "--model", "henon-heiles", "--energy", "0.125"]


@pytest.mark.parametrize(("wanted", "opens"), [(False, True), (True, True), (True, False)])
def test_the_page_is_opened_where_asked(here, capsys, monkeypatch, wanted, opens):
    seen = []
    monkeypatch.setattr(webbrowser, "open", lambda address: seen.append(address) or opens)
    assert main([*WORDS, *["--open"][: int(wanted)]]) == 0
    said = capsys.readouterr()
    assert said.out.strip() == "fastaff-explorer.html"
    assert seen == [(here / "fastaff-explorer.html").resolve().as_uri()][: int(wanted)]
    assert ("no browser was found" in said.err) is (wanted and not opens)
