"""What a release says of itself is the same everywhere."""

import importlib.util
from pathlib import Path

import pytest

import fastaff as fa

ROOT = Path(__file__).parents[2]


@pytest.fixture
def release():
    """The script of `make release`."""
    spec = importlib.util.spec_from_file_location("release", ROOT / ".ci/release.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_version_and_date_agree(release):
    said = release.facts()
    assert release.disagreements(said) == []
    assert {version for version, _ in said.values()} == {fa.__version__}
    assert release.tag().startswith(f"fastaff {fa.__version__} ")


def test_disagreements_are_named(release):
    said = release.facts()
    for name, value in (("CITATION.cff", ("0.0.1", "2026-01-01")), ("CHANGELOG.md", (fa.__version__, "2001-01-01"))):
        assert any(name in line for line in release.disagreements({**said, name: value}))
    assert release.disagreements({**said, "CITATION.cff": (fa.__version__, "soon")})
