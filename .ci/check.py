"""Run the fast tests that a change touches: `make check`, or `python .ci/check.py [COMMIT] [--list]`.

Touched are the test files that changed, and those that name a module that changed, one of the same part that stands on
it, or one of another part that imports one of these. Changed is what differs from COMMIT (HEAD by default), committed
or not. All parts stand on the first five: after an edit there run `make test`.
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "fastaff"


def changed(commit: str) -> set[Path]:
    """Return the files that differ from a commit, and those that git does not know."""
    calls = (["diff", "--name-only", commit], ["ls-files", "--others", "--exclude-standard"])
    lines = [subprocess.run(["git", *call], cwd=ROOT, capture_output=True, text=True, check=True) for call in calls]
    return {ROOT / name for done in lines for name in done.stdout.split("\n") if name}


def dotted(path: Path) -> str:
    """Return the dotted name of a file below the root."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def modules() -> dict[str, Path]:
    """Return the modules of the package and of the tests by name."""
    package = {dotted(path): path for path in (ROOT / PACKAGE).rglob("*.py")}
    return package | {path.stem: path for path in (ROOT / "tests").rglob("*.py")}


def imports(name: str) -> set[str]:
    """Return the known modules that a module imports, anywhere in its text; of tests also the homes of names of the
    package that they use.
    """
    path, found = modules()[name], set()
    text = path.read_text()
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {entry.name for entry in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            found |= {base, *(f"{base}.{entry.name}" for entry in node.names)}
    if not name.startswith(PACKAGE):
        found.discard(PACKAGE)
        found |= {home for word, home in homes().items() if re.search(rf"\b(?:fa|{PACKAGE})\.{word}\b", text)}
    return found & modules().keys()


@cache
def homes() -> dict[str, str]:
    """Return the modules of the public names and folders of the package, by name."""
    tree = ast.parse((ROOT / PACKAGE / "__init__.py").read_text())
    tables = {
        target.id: ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name) and target.id in ("_PLACES", "_FOLDERS", "_INSIDE")
    }
    names = {word: f"{PACKAGE}.{module}" for module, words in tables["_PLACES"].items() for word in words}
    return names | {word: f"{PACKAGE}.{tables['_INSIDE'].get(word, word)}" for word in tables["_FOLDERS"]}


def part(name: str) -> str:
    """Return the part of the package that a module is in; the tests are one."""
    return name.split(".")[1] if name.startswith(f"{PACKAGE}.") else "tests"


def touched(files: set[Path]) -> list[Path]:
    """Return the test files that name one of these files, or a module that stands on it."""
    graph = {name: imports(name) for name in modules()}
    listing = {name for name, path in modules().items() if path.name == "__init__.py"}
    found = {name for name, path in modules().items() if path in files}
    inside, grown = set(found), True
    while grown:
        more = {
            name
            for name, used in graph.items()
            if name not in listing and any(part(other) == part(name) for other in used & inside)
        }
        grown = not more <= inside
        inside |= more
    beside = {name for name, used in graph.items() if name not in listing and used & inside}
    known = inside | {name for name in beside if part(name) != "tests"}
    tests = inside | {name for name, used in graph.items() if part(name) == "tests" and used & known}
    return sorted(modules()[name] for name in tests if modules()[name].stem.startswith("test_"))


def main() -> int:
    """Run or list the tests that a change touches."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("commit", nargs="?", default="HEAD")
    parser.add_argument("--list", action="store_true", help="only print their files")
    given = parser.parse_args()
    files = touched(changed(given.commit))
    print(f"{len(files)} files of tests")
    if given.list or not files:
        print(*(path.relative_to(ROOT) for path in files), sep="\n")
        return 0
    call = ["-m", "pytest", "-n", "2", "--dist", "worksteal", "-p", "no:benchmark", "-m", "not slow and not race"]
    return subprocess.run([sys.executable, *call, *map(str, files)], cwd=ROOT).returncode


if __name__ == "__main__":
    sys.exit(main())
