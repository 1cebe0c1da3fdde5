"""Print the path of the newest Python of this machine, if it is newer than the one that runs this."""

import os
import subprocess
import sys
from itertools import chain
from pathlib import Path

ASK = "import sys; print(sys.version_info.minor if sys.version_info.releaselevel == 'final' else 0)"


def minor(python: Path) -> int:
    """Return the 13 of Python 3.13; 0 for what does not run and for what is no release."""
    try:
        return int(subprocess.run([python, "-c", ASK], capture_output=True, check=True, timeout=30).stdout)
    except (OSError, subprocess.SubprocessError, ValueError):
        return 0


pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
on_path = (Path(folder).glob("python3.[0-9][0-9]") for folder in os.environ["PATH"].split(os.pathsep) if folder)
best = max(chain(*on_path, pyenv.glob("versions/3.*/bin/python3.[0-9][0-9]")), key=minor, default=None)
if best is not None and minor(best) > sys.version_info.minor:
    print(best)
