"""Benchmarks import `common` from this folder and the quadratures of tests/naive.py."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]
