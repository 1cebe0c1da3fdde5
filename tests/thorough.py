"""How thorough tests of faults are: `make faults` sets FASTAFF_FAULTS=10, which is ten times what CI runs."""

import os

TIMES = int(os.environ.get("FASTAFF_FAULTS", "1"))
