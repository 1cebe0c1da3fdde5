"""Run the stages of the deep tier, and keep a record of what each last passed on.

.ci/deep.json holds, for each stage, the commit, the day, the seconds that it took and a checksum of the files that it
depends on. A stage is due when these files differ from the ones that it passed on.

Run: python .ci/deep.py (prints the record), --run (runs the stages that are due), --run slow races (runs these),
--due (exits with 1 where a stage is due, as a release asks).
"""

import argparse
import datetime
import hashlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RECORD = ROOT / ".ci/deep.json"
ABOUT = ("fastaff", "tests", "bench/gate.py", ".ci/wheel.py", "pyproject.toml")
"""The package with the explorer's page, its tests, and what other stages need."""
SUFFIXES = {".py", ".js", ".css", ".html", ".toml"}
STAGES = ("slow", "races", "bounds", "wheel", "lowest", "newest", "tools", "gate")
"""Targets of the Makefile, in the order in which they run."""


def checksum() -> str:
    """Return the checksum of the files that all stages depend on."""
    digest = hashlib.sha256()
    for top in (ROOT / entry for entry in ABOUT):
        paths = sorted(top.rglob("*")) if top.is_dir() else [top]
        for path in paths:
            if path.is_file() and path.suffix in SUFFIXES:
                name = path.relative_to(ROOT).as_posix().encode()
                digest.update(name + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def read() -> dict[str, dict]:
    """Return the record: what is known of each stage that has passed."""
    return json.loads(RECORD.read_text()) if RECORD.exists() else {}


def git(*words: str) -> str:
    """Return what git says."""
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip()


def due(now: str) -> list[str]:
    """Return the stages whose files differ from the ones that they passed on."""
    record = read()
    return [stage for stage in STAGES if record.get(stage, {}).get("checksum") != now]


def run(stage: str) -> bool:
    """Run a stage; write down that it passed, or return False. Files that change meanwhile make it due at once."""
    before, begin = checksum(), time.time()
    passed = subprocess.run([os.environ.get("MAKE", "make"), stage], cwd=ROOT, check=False).returncode == 0
    if passed:
        changed = "+" if git("status", "--porcelain", "--", *ABOUT) else ""
        entry = {
            "commit": git("rev-parse", "--short=10", "HEAD") + changed,
            "day": datetime.date.today().isoformat(),
            "seconds": round(time.time() - begin),
            "checksum": before,
        }
        record = {**read(), stage: entry}
        ordered = {name: record[name] for name in STAGES if name in record}
        RECORD.write_text(json.dumps(ordered, indent=1) + "\n")
    return passed


def report(now: str) -> None:
    """Print the record."""
    record = read()
    for stage in STAGES:
        if stage not in record:
            print(f"{stage:8s} has not been recorded")
            continue
        entry = record[stage]
        state = "passed" if entry["checksum"] == now else "due, passed"
        print(f"{stage:8s} {state} at {entry['commit']} on {entry['day']} in {entry['seconds']} s")


def main() -> int:
    """Return the exit code of the command."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--run", nargs="*", choices=STAGES, metavar="STAGE", help="stages; none: all that are due")
    parser.add_argument("--due", action="store_true", help="exit with 1 where a stage is due")
    given = parser.parse_args()
    now = checksum()
    failed = []
    if given.run is not None:
        failed = [stage for stage in given.run or due(now) if not run(stage)]
    report(now)
    if failed:
        print(f"failed: {', '.join(failed)}")
    return bool(failed) or (given.due and bool(due(now)))


if __name__ == "__main__":
    sys.exit(main())
