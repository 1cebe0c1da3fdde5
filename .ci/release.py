"""Make all of a release but the upload: sdist, a wheel with machine code and one without, checked, the first wheel
installed in a bare environment; the text of its tag.

Run: python .ci/release.py FOLDER (make release). Version and date stand in pyproject.toml, fastaff/__init__.py,
CITATION.cff and the first heading of CHANGELOG.md, which says "unreleased" until there is a date.
"""

import email
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TRIAL = """
import fastaff as fa
found = fa.integrate(fa.HenonHeiles(), [0.0, 0.1, 0.4, 0.14], time=10.0, accuracy=1e-10)
assert found.success and found.energy_error.max() < 1e-9, found
print(fa.__version__, found.message)
"""


def facts() -> dict[str, tuple[str, str]]:
    """Return version and date, where one is said, of each file that has them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    citation = dict(re.findall(r"^(version|date-released): (\S+)$", (ROOT / "CITATION.cff").read_text(), re.M))
    package = re.search(r'^__version__ = "(.+)"$', (ROOT / "fastaff/__init__.py").read_text(), re.M)
    heading = re.search(r"^## (\S+) \((.+)\)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    return {
        "pyproject.toml": (project, ""),
        "fastaff/__init__.py": (package[1] if package else "", ""),
        "CITATION.cff": (citation.get("version", ""), citation.get("date-released", "")),
        "CHANGELOG.md": (heading[1], heading[2]) if heading else ("", ""),
    }


def tag() -> str:
    """Return the text of the tag: the part of the changelog about this version."""
    text = (ROOT / "CHANGELOG.md").read_text().split("\n## ")[1]
    return "fastaff " + text.replace("**", "").strip() + "\n"


def disagreements(said: dict[str, tuple[str, str]]) -> list[str]:
    """Return what must agree and does not."""
    found = []
    if len({version for version, _ in said.values()}) > 1:
        found.append(f"versions differ: {said}")
    day = said["CITATION.cff"][1]
    if not re.fullmatch(r"\d{4}-\d{2}-\d{2}", day):
        found.append(f"CITATION.cff has the date {day!r}")
    if said["CHANGELOG.md"][1] not in ("unreleased", day):
        found.append(f"CHANGELOG.md says {said['CHANGELOG.md'][1]}, CITATION.cff {day}")
    return found


def _metadata(text: bytes) -> None:
    """Refuse metadata that a registry would refuse."""
    from packaging.metadata import Metadata

    Metadata.from_email(text, validate=True)
    kind = email.message_from_bytes(text)["Description-Content-Type"]
    if kind is None or not kind.startswith("text/markdown"):
        raise SystemExit(f"the description is of the type {kind}")


def _environment(place: Path, *packages: str) -> str:
    """Make a bare environment with packages, checked; return its Python."""
    venv.create(place, with_pip=True)
    python = str(place / "bin/python")
    pip = [python, "-m", "pip", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--quiet", *packages], check=True)
    subprocess.run([*pip, "check"], check=True)
    return python


def main(target: Path) -> None:
    """Build and check everything in a folder, which is emptied of older files of these kinds."""
    wrong = disagreements(facts())
    if wrong:
        raise SystemExit("\n".join(wrong))
    if subprocess.run([sys.executable, str(ROOT / ".ci/deep.py"), "--due"], check=False).returncode:
        raise SystemExit("a release needs all stages of the deep tier: make test-deep")
    target.mkdir(exist_ok=True)
    for old in [*target.glob("*.tar.gz"), *target.glob("*.whl")]:
        old.unlink()
    needs = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        tree = place / "tree"
        archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, check=True, capture_output=True).stdout
        (place / "tree.tar").write_bytes(archive)
        with tarfile.open(place / "tree.tar") as packed:
            packed.extractall(tree, filter="data")
        builder = _environment(place / "builder", *needs)
        build = f"from setuptools.build_meta import build_sdist; build_sdist({str(target)!r})"
        subprocess.run([builder, "-c", build], cwd=tree, check=True, stdout=subprocess.DEVNULL)
        subprocess.run([sys.executable, str(ROOT / ".ci/wheel.py"), str(target)], check=True)
        (sdist,), (wheel,) = target.glob("*.tar.gz"), target.glob("*.whl")
        plain = [builder, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(place), str(sdist)]
        subprocess.run(plain, check=True)
        (again,) = place.glob("*.whl")
        files = [
            {entry for entry in zipfile.ZipFile(one).namelist() if "prebuilt" not in entry} for one in (wheel, again)
        ]
        if files[0] != files[1]:
            raise SystemExit(f"wheels of the tree and of the sdist differ in {sorted(files[0] ^ files[1])}")
        for one in (wheel, again):
            with zipfile.ZipFile(one) as packed:
                _metadata(
                    packed.read(next(entry for entry in packed.namelist() if entry.endswith(".dist-info/METADATA")))
                )
        with tarfile.open(sdist) as packed:
            _metadata(packed.extractfile(f"{sdist.name.removesuffix('.tar.gz')}/PKG-INFO").read())  # type: ignore[union-attr]
        bare = _environment(place / "bare", str(wheel))
        subprocess.run([bare, "-c", TRIAL], cwd=place, check=True)
        shutil.copy(again, target)  # pip takes it where the other wheel does not fit
    version, day = facts()["CHANGELOG.md"]
    (target / "tag.txt").write_text(tag())
    if day == "unreleased":
        print("CHANGELOG.md says unreleased: give its heading the date of CITATION.cff, and run this again")
    print(f"git tag -a v{version} -F {target.name}/tag.txt; then upload {sdist.name}, {wheel.name}, {again.name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
