"""Tell whether the deep tier is due: whether code or tests have changed since it last passed.

.ci/deep.txt holds a checksum of these files, which `make test-deep` writes when all of it has passed.
Run: python .ci/deep.py (exits with 1 where it is due), python .ci/deep.py --passed (writes the checksum).
"""

import hashlib
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PASSED = ROOT / ".ci/deep.txt"
ABOUT = ("fastaff", "tests", "bench/gate.py", ".ci/wheel.py", "pyproject.toml")
"""The package and its tests, and what the other stages of the deep tier need."""


def checksum() -> str:
    """Return the checksum of these files."""
    digest = hashlib.sha256()
    for top in (ROOT / entry for entry in ABOUT):
        for path in sorted(top.rglob("*.py")) if top.is_dir() else [top]:
            digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


if __name__ == "__main__":
    if sys.argv[1:] == ["--passed"]:
        PASSED.write_text(f"{checksum()}\n")
    else:
        sys.exit(not PASSED.exists() or PASSED.read_text().strip() != checksum())
