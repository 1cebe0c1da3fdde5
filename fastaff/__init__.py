"""Poincaré maps, frequency maps and tori of planar affinely-rigid bodies, by lane-blocked Numba kernels.

Here are models, schemes, sections, indicators of chaos and the verbs. What they return, and what is needed less often,
is in the parts `runs`, `sections`, `frequencies`, `chaos`, `periodic`, `tori`, and in `charts`, `models`, `molecules`,
`schemes`, `formulas`, `files`, `jobs`; quantum mechanics in `quantum`, figures in `plot`. All are loaded when they are
first used.
"""

import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import chaos as chaos
    from . import cli as cli
    from . import core as core
    from . import engine as engine
    from . import exchange as exchange
    from . import explorer as explorer
    from . import frequencies as frequencies
    from . import jobs as jobs
    from . import periodic as periodic
    from . import plot as plot
    from . import quantum as quantum
    from . import results as results
    from . import runs as runs
    from . import sections as sections
    from . import systems as systems
    from . import tori as tori
    from .chaos.basins import basins as basins
    from .chaos.chaos_map import chaos_map as chaos_map
    from .chaos.chaotic_fraction import chaotic_fraction as chaotic_fraction
    from .chaos.indicators import FLI as FLI
    from .chaos.indicators import GALI as GALI
    from .chaos.indicators import MEGNO as MEGNO
    from .chaos.indicators import OFLI as OFLI
    from .chaos.indicators import SALI as SALI
    from .chaos.indicators import Lyapunov as Lyapunov
    from .chaos.indicators import LyapunovSpectrum as LyapunovSpectrum
    from .chaos.pass_indicators import FrequencyDiffusion as FrequencyDiffusion
    from .chaos.pass_indicators import ReversibilityError as ReversibilityError
    from .chaos.pass_indicators import WeightedBirkhoff as WeightedBirkhoff
    from .chaos.pass_indicators import ZeroOneTest as ZeroOneTest
    from .core.classification import Classification as Classification
    from .core.interruption import Interrupted as Interrupted
    from .core.status import OrbitError as OrbitError
    from .core.status import Status as Status
    from .exchange import files as files
    from .exchange.files import load as load
    from .exchange.files import save as save
    from .explorer.explore import explore as explore
    from .frequencies.frequency_map import frequency_map as frequency_map
    from .frequencies.naff import naff as naff
    from .frequencies.orbit_frequencies import orbit_frequencies as orbit_frequencies
    from .frequencies.resonance_web import resonance_web as resonance_web
    from .frequencies.resonances import resonances as resonances
    from .frequencies.tune_accumulator import TuneAccumulator as TuneAccumulator
    from .frequencies.tunes import tunes as tunes
    from .jobs import Job as Job
    from .jobs import rerun as rerun
    from .jobs import resume as resume
    from .jobs import run as run
    from .periodic.continuation import continuation as continuation
    from .periodic.find_periodic_orbits import find_periodic_orbits as find_periodic_orbits
    from .periodic.periodic_orbits import periodic_orbits as periodic_orbits
    from .results.progress import show_progress as show_progress
    from .runs import schemes as schemes
    from .runs.integrate import integrate as integrate
    from .runs.schemes.automatic import AUTO as AUTO
    from .runs.schemes.catalogue import BLANES_MOAN6 as BLANES_MOAN6
    from .runs.schemes.catalogue import DOP853 as DOP853
    from .runs.schemes.catalogue import KAHAN_LI8 as KAHAN_LI8
    from .runs.schemes.catalogue import LEAPFROG as LEAPFROG
    from .runs.schemes.catalogue import RK4 as RK4
    from .runs.schemes.catalogue import SOFRONIOU_SPALETTA10 as SOFRONIOU_SPALETTA10
    from .runs.schemes.catalogue import VERNER9 as VERNER9
    from .runs.schemes.catalogue import YOSHIDA4 as YOSHIDA4
    from .runs.schemes.time_transformed import TimeTransformed as TimeTransformed
    from .runs.tangent_map import tangent_map as tangent_map
    from .sections.energy_grid import energy_grid as energy_grid
    from .sections.energy_sample import energy_sample as energy_sample
    from .sections.islands import islands as islands
    from .sections.islands import rotation_number as rotation_number
    from .sections.poincare_map import poincare_map as poincare_map
    from .systems import charts as charts
    from .systems import formulas as formulas
    from .systems import models as models
    from .systems import molecules as molecules
    from .systems.formulas.formula import affine_body as affine_body
    from .systems.formulas.formula import hamiltonian as hamiltonian
    from .systems.formulas.iterated_map import iterated_map as iterated_map
    from .systems.formulas.ode import ode as ode
    from .systems.models import Anharmonic as Anharmonic
    from .systems.models import Body as Body
    from .systems.models import Harmonic as Harmonic
    from .systems.models import HeavyTop as HeavyTop
    from .systems.models import HenonHeiles as HenonHeiles
    from .systems.models import Hyperelastic as Hyperelastic
    from .systems.models import NeoHookean as NeoHookean
    from .systems.models import SeparableAlphaBeta as SeparableAlphaBeta
    from .systems.models import SeparableElliptic as SeparableElliptic
    from .systems.models import SeparableRVartheta as SeparableRVartheta
    from .systems.models import reduced_body as reduced_body
    from .systems.models import univariate as univariate
    from .systems.models.sections import AlphaEquals as AlphaEquals
    from .systems.models.sections import AlphaTurning as AlphaTurning
    from .systems.models.sections import AreaEquals as AreaEquals
    from .systems.models.sections import BetaEquals as BetaEquals
    from .systems.models.sections import BetaTurning as BetaTurning
    from .systems.models.sections import Hyperplane as Hyperplane
    from .tori.action_angles import action_angles as action_angles
    from .tori.fit_torus import fit_torus as fit_torus
    from .tori.inverse_tori import energy_of_actions as energy_of_actions
    from .tori.inverse_tori import from_action_angles as from_action_angles
    from .tori.separation import constants_of_motion as constants_of_motion

__version__ = "0.2.0"

_FOLDERS = (
    "chaos",
    "charts",
    "cli",
    "core",
    "engine",
    "exchange",
    "explorer",
    "files",
    "formulas",
    "frequencies",
    "jobs",
    "models",
    "molecules",
    "periodic",
    "plot",
    "quantum",
    "results",
    "runs",
    "schemes",
    "sections",
    "systems",
    "tori",
)
"""Parts of the package, and folders and modules in them that have a name here."""

_INSIDE = {
    "charts": "systems.charts",
    "files": "exchange.files",
    "formulas": "systems.formulas",
    "models": "systems.models",
    "molecules": "systems.molecules",
    "schemes": "runs.schemes",
}
"""Folders and modules within parts that have a name here."""

_PLACES = {
    "chaos.basins": ("basins",),
    "chaos.chaos_map": ("chaos_map",),
    "chaos.chaotic_fraction": ("chaotic_fraction",),
    "chaos.indicators": (
        "FLI",
        "GALI",
        "MEGNO",
        "OFLI",
        "SALI",
        "Lyapunov",
        "LyapunovSpectrum",
    ),
    "chaos.pass_indicators": (
        "WeightedBirkhoff",
        "FrequencyDiffusion",
        "ReversibilityError",
        "ZeroOneTest",
    ),
    "frequencies.frequency_map": ("frequency_map",),
    "frequencies.naff": ("naff",),
    "frequencies.orbit_frequencies": ("orbit_frequencies",),
    "frequencies.resonance_web": ("resonance_web",),
    "frequencies.resonances": ("resonances",),
    "frequencies.tune_accumulator": ("TuneAccumulator",),
    "frequencies.tunes": ("tunes",),
    "runs.integrate": ("integrate",),
    "runs.tangent_map": ("tangent_map",),
    "periodic.continuation": ("continuation",),
    "periodic.find_periodic_orbits": ("find_periodic_orbits",),
    "periodic.periodic_orbits": ("periodic_orbits",),
    "sections.energy_grid": ("energy_grid",),
    "sections.energy_sample": ("energy_sample",),
    "sections.islands": (
        "islands",
        "rotation_number",
    ),
    "sections.poincare_map": ("poincare_map",),
    "tori.action_angles": ("action_angles",),
    "tori.fit_torus": ("fit_torus",),
    "tori.inverse_tori": (
        "energy_of_actions",
        "from_action_angles",
    ),
    "tori.separation": ("constants_of_motion",),
    "core.classification": ("Classification",),
    "core.interruption": ("Interrupted",),
    "results.progress": ("show_progress",),
    "core.status": (
        "OrbitError",
        "Status",
    ),
    "exchange.files": (
        "load",
        "save",
    ),
    "explorer.explore": ("explore",),
    "systems.formulas.ode": ("ode",),
    "systems.formulas.formula": (
        "affine_body",
        "hamiltonian",
    ),
    "systems.formulas.iterated_map": ("iterated_map",),
    "jobs": (
        "Job",
        "rerun",
        "resume",
        "run",
    ),
    "systems.models": (
        "Anharmonic",
        "Body",
        "Harmonic",
        "HeavyTop",
        "HenonHeiles",
        "Hyperelastic",
        "NeoHookean",
        "SeparableAlphaBeta",
        "SeparableElliptic",
        "SeparableRVartheta",
        "univariate",
        "reduced_body",
    ),
    "systems.models.sections": (
        "AlphaEquals",
        "AlphaTurning",
        "AreaEquals",
        "BetaEquals",
        "BetaTurning",
        "Hyperplane",
    ),
    "runs.schemes.automatic": ("AUTO",),
    "runs.schemes.catalogue": (
        "BLANES_MOAN6",
        "DOP853",
        "KAHAN_LI8",
        "LEAPFROG",
        "RK4",
        "SOFRONIOU_SPALETTA10",
        "VERNER9",
        "YOSHIDA4",
    ),
    "runs.schemes.time_transformed": ("TimeTransformed",),
}
"""Modules of the public names, which are loaded when one of their names is first used."""

_HOME = {name: module for module, names in _PLACES.items() for name in names}

__all__ = [
    "AUTO",
    "BLANES_MOAN6",
    "DOP853",
    "FLI",
    "GALI",
    "KAHAN_LI8",
    "LEAPFROG",
    "MEGNO",
    "OFLI",
    "RK4",
    "SALI",
    "SOFRONIOU_SPALETTA10",
    "VERNER9",
    "YOSHIDA4",
    "AlphaEquals",
    "AlphaTurning",
    "Anharmonic",
    "AreaEquals",
    "BetaEquals",
    "BetaTurning",
    "Body",
    "Classification",
    "FrequencyDiffusion",
    "Harmonic",
    "HeavyTop",
    "HenonHeiles",
    "Hyperelastic",
    "Hyperplane",
    "Interrupted",
    "Job",
    "Lyapunov",
    "LyapunovSpectrum",
    "NeoHookean",
    "OrbitError",
    "ReversibilityError",
    "SeparableAlphaBeta",
    "SeparableElliptic",
    "SeparableRVartheta",
    "Status",
    "TimeTransformed",
    "TuneAccumulator",
    "WeightedBirkhoff",
    "ZeroOneTest",
    "action_angles",
    "affine_body",
    "basins",
    "chaos_map",
    "chaotic_fraction",
    "constants_of_motion",
    "continuation",
    "energy_grid",
    "energy_of_actions",
    "energy_sample",
    "explore",
    "find_periodic_orbits",
    "fit_torus",
    "frequency_map",
    "from_action_angles",
    "hamiltonian",
    "integrate",
    "islands",
    "iterated_map",
    "load",
    "naff",
    "ode",
    "orbit_frequencies",
    "periodic_orbits",
    "poincare_map",
    "reduced_body",
    "rerun",
    "resonance_web",
    "resonances",
    "resume",
    "rotation_number",
    "run",
    "save",
    "show_progress",
    "tangent_map",
    "tunes",
    "univariate",
]

_LISTED = (
    *("runs", "sections", "frequencies", "chaos", "periodic", "tori"),
    *("charts", "models", "molecules", "quantum", "schemes"),
)
"""Folders where a name is looked up that `fastaff` itself does not have."""


def _named(name: str) -> Any:
    """Load a folder of the package or its public names when one is first used.

    For an unknown name it raises AttributeError, whose message names the folder that has it, if one does. In `from
    fastaff import name`, which shows no AttributeError, it raises ImportError with the same message.
    """
    if name in _FOLDERS:
        return _module(name)
    if name in _HOME:
        value = globals()[name] = getattr(_module(_HOME[name]), name)
        return value
    if name.startswith("_"):
        raise AttributeError(f"fastaff has no {name!r}")
    for folder in _LISTED:
        if name in _listed(folder):
            importing = sys._getframe(1).f_code.co_name == "_handle_fromlist"  # of importlib
            kind = ImportError if importing else AttributeError
            raise kind(f"fastaff has no {name!r}. Use fastaff.{folder}.{name}")
    from .core.names import did_you_mean

    raise AttributeError(f"fastaff has no {name!r}.{did_you_mean(name, __dir__())} dir(fastaff) lists what it has")


def _module(name: str) -> Any:
    """Load a module of the package, which takes a second the first time, and says so where it takes more."""
    from .core.interruption import imported
    from .results.progress import watched

    with watched("loading", logged=False):
        return imported(f".{_INSIDE.get(name, name)}", __name__)


def _listed(folder: str) -> list[str]:
    """Return the public names of a folder, those among them that it loads when they are first used."""
    module = _module(folder)
    return [*module.__all__, *vars(module).get("__dir__", list)()]


if not TYPE_CHECKING:  # type checkers know the names, and what is none
    __getattr__ = _named


def __dir__() -> list[str]:
    """List the public names and folders."""
    return sorted([*__all__, *_FOLDERS])
