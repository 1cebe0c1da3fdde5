"""Print the lowest versions that pyproject.toml allows for users and tests, as constraints of pip."""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]


def lowest(requirements: list[str]) -> set[str]:
    """Return the requirements, those of extras too, with equals signs."""
    found: set[str] = set()
    for entry in requirements:
        if entry.startswith("fastaff["):
            for extra in entry.removeprefix("fastaff[").removesuffix("]").split(","):
                found |= lowest(EXTRAS[extra])
        else:
            found.add(entry.partition(",")[0].replace(">=", "=="))
    return found


print("\n".join(sorted(lowest([*PROJECT["dependencies"], "fastaff[test]"]))))
