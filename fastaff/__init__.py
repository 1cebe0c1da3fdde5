"""Poincaré maps, frequency maps and tori of planar affinely-rigid bodies, by lane-blocked Numba kernels.

Here are models, schemes, sections, indicators of chaos and the verbs. What they return, and what is needed less often,
is in `analysis`, `charts`, `models`, `schemes`, `formulas`, `files`, `jobs`; quantum mechanics in `quantum`, figures in
`plot`: each is loaded when it is first used, and so are the names themselves (`fastaff.public`).
"""

import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import analysis as analysis
    from . import charts as charts
    from . import cli as cli
    from . import compile as compile
    from . import exchange as exchange
    from . import explorer as explorer
    from . import flows as flows
    from . import formulas as formulas
    from . import jobs as jobs
    from . import models as models
    from . import paper as paper
    from . import plot as plot
    from . import quantum as quantum
    from . import schemes as schemes
    from .exchange import files as files
    from .public import *  # noqa: F403
    from .public import __all__ as __all__

__version__ = "0.2.0"

_FOLDERS = (
    "analysis",
    "charts",
    "cli",
    "compile",
    "exchange",
    "explorer",
    "files",
    "flows",
    "formulas",
    "jobs",
    "models",
    "paper",
    "plot",
    "quantum",
    "schemes",
)

_INSIDE = {"files": "exchange.files"}
"""Modules that have a name of their own here."""

_RENAMED = {
    "ChaosScan": "ChaoticFraction",
    "ExactLevels": "LevelTable",
    "Grid": "EnergyGrid",
    "LevelList": "LevelTable",
    "Levels": "LevelTable",
    "Lines": "FrequencyLines",
    "QuasiclassicalLevels": "LevelTable",
    "Sample": "EnergySample",
    "Tori": "ActionAngles",
    "WebLine": "ResonanceLine",
    "chaos": "chaos_map",
    "exact_levels_below": "exact_levels",
    "from_action_angle": "from_action_angles",
    "multiplets": "exact_levels",
    "quasiclassical_levels_below": "quasiclassical_levels",
    "tori": "action_angles",
    "web": "resonance_web",
}
"""Names of version 0.1 that are others now."""


def _named(name: str) -> Any:
    """Load a folder of the package or its public names when one is first used.

    Raises AttributeError for a name that is none, which says where one of version 0.1 is now; in `from fastaff import
    name`, which shows no AttributeError, ImportError with the same message.
    """
    if name in _FOLDERS:
        return _module(name)
    if name.startswith("_") and name != "__all__":
        raise AttributeError(f"fastaff has no {name!r}")
    names = _loaded()
    if name in names:
        return names[name]
    new = _RENAMED.get(name, name)
    for folder in ("", "analysis.", "charts.", "models.", "quantum.", "schemes."):
        if new in (_listed(folder[:-1]) if folder else names["__all__"]):
            importing = sys._getframe(1).f_code.co_name == "_handle_fromlist"  # of importlib
            kind = ImportError if importing else AttributeError
            raise kind(f"fastaff.{name} is fastaff.{folder}{new} since version 0.2")
    from .base.names import did_you_mean

    raise AttributeError(f"fastaff has no {name!r}.{did_you_mean(name, __dir__())} dir(fastaff) lists what it has")


def _module(name: str) -> Any:
    """Load a module of the package, which takes a second the first time, and says so where it takes more."""
    from .base.interruption import imported
    from .base.progress import watched

    with watched("loading"):
        return imported(f".{_INSIDE.get(name, name)}", __name__)


def _listed(folder: str) -> list[str]:
    """Return the public names of a folder, those among them that it loads when they are first used."""
    module = _module(folder)
    return [*module.__all__, *vars(module).get("__dir__", list)()]


def _loaded() -> dict[str, Any]:
    """Load the public names into this module, and return them with their list."""
    public = _module("public")
    names = {name: getattr(public, name) for name in ("__all__", *public.__all__)}
    for name, value in names.items():
        globals().setdefault(name, value)
    return names


if not TYPE_CHECKING:  # type checkers know the names, and what is none
    __getattr__ = _named


def __dir__() -> list[str]:
    """List the public names and folders."""
    return sorted([*_loaded()["__all__"], *_FOLDERS])
