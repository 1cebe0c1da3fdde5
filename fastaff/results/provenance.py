"""Provenance of results: versions, machine, date and command line."""

from __future__ import annotations

import datetime
import platform
import shlex
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np

from .machine import cores, cpu_name

FORMAT = 2
"""Version of the format of `fastaff.files`."""


def provenance() -> dict[str, Any]:
    """Return versions, machine, date and command line."""
    return {
        "format": FORMAT,
        "fastaff": sys.modules[__name__.partition(".")[0]].__version__,
        "numpy": np.__version__,
        "numba": numba.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cpu": cpu_name(),
        "cores": cores(),
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]) if sys.argv else "",
    }
