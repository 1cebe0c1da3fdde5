"""The pages of the API and of the command line, written before a build from the package itself."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import job_tables
import numpy as np
import result_fields

import fastaff
from fastaff.chaos.indicators import INDICATORS
from fastaff.systems.formulas.systems import SYSTEMS, constants_of
from fastaff.systems.models.sections import OF_BODIES

OWN_SECTIONS = [kind.__name__ for kind in OF_BODIES.values() if kind.__name__ not in fastaff.__all__]
"""Sections of bodies that `fastaff` itself has not."""
OWN_INDICATORS = sorted({type(entry).__name__ for entry in INDICATORS.values()} - {*fastaff.__all__})
"""Indicators of chaos that it has not."""


class Page(NamedTuple):
    """A page of the API: title, a sentence, and the names in its order, by the folder that has them ("" is fastaff)."""

    title: str
    about: str
    names: dict[str, str]


PAGES: dict[str, Page] = {
    "models": Page(
        "Models",
        "Bodies in the plane and in space, their potentials, systems of one line of mathematics, and maps.",
        {
            "": "Body NeoHookean Hyperelastic Harmonic Anharmonic HeavyTop HenonHeiles affine_body hamiltonian "
            "iterated_map ode reduced_body univariate SeparableAlphaBeta SeparableRVartheta SeparableElliptic",
            "systems.models": f"DoublePendulum {' '.join(SYSTEMS)} "
            "StandardMap HenonMap McMillanMap FroeschleMap OneTurnMap BreathingBody StackelBody Barriers "
            "ReducedBody Oscillator CosOscillator CoshOscillator Cosine Secant Spring "
            "Zero Body3 GasCloud SelfGravity NeoHookean3 MooneyRivlin3 Ogden3 Sum3 formula3 ReducedBody3 reduced_body3 "
            "RelativeEquilibrium riemann_ellipsoid relative_equilibrium",
        },
    ),
    "molecules": Page(
        "Molecules",
        "Rings and other molecules of atoms with pair potentials, as bodies.",
        {
            "systems.molecules": "ring molecule Molecule HarmonicBond MorseBond LennardJones MolecularBody Equilibrium "
            "Vibrations MolecularModes"
        },
    ),
    "orbits": Page(
        "Orbits",
        "Integration of many orbits, with or without tangent vectors, and what became of each.",
        {"": "integrate tangent_map Status Interrupted OrbitError show_progress", "runs": "Orbits TangentMap"},
    ),
    "sections": Page(
        "Sections",
        "Surfaces of section, initial conditions on them, crossings, islands.",
        {
            "": "poincare_map energy_grid energy_sample islands rotation_number AlphaTurning BetaTurning AlphaEquals "
            "BetaEquals AreaEquals Hyperplane",
            "sections": "SectionMap EnergyGrid EnergySample Islands Rotation NotReached map_samples",
            "systems.models.sections": " ".join(["Stroboscopic AngleEquals", *OWN_SECTIONS]),
        },
    ),
    "schemes": Page(
        "Schemes",
        "Integration schemes are values: coefficients, order and source. Those of `fastaff.schemes` not listed under "
        "`fastaff` are in that folder.",
        {
            "": "BLANES_MOAN6 KAHAN_LI8 SOFRONIOU_SPALETTA10 YOSHIDA4 LEAPFROG RK4 DOP853 VERNER9 AUTO TimeTransformed",
            "runs.schemes": "ITERATION BLANES_CASAS_ESCORIHUELA8 SOFRONIOU_SPALETTA8 RKN12 GAUSS8 GAUSS16 Splitting "
            "RungeKutta Nystrom Collocation Scheme compose triple_jump scheme_named SCHEMES Automatic Exponential "
            "Logistic Algebraic",
        },
    ),
    "frequencies": Page(
        "Frequencies",
        "Frequency maps, frequencies of signals, resonances.",
        {
            "": "frequency_map orbit_frequencies tunes TuneAccumulator naff resonances resonance_web",
            "frequencies": "FrequencyMap AngleLines Tunes TuneSums FrequencyLines "
            "Resonances ResonanceLine OrbitFamilies OrbitFamily diffusion_histogram orbit_families ratio_web",
        },
    ),
    "chaos": Page(
        "Chaos",
        "Indicators of chaos, maps of them, and the chaotic fraction over parameters.",
        {
            "": "chaos_map chaotic_fraction basins Classification MEGNO SALI GALI FLI OFLI Lyapunov LyapunovSpectrum "
            "ZeroOneTest WeightedBirkhoff FrequencyDiffusion ReversibilityError",
            "chaos": " ".join(
                [
                    "ChaosMap ChaoticFraction Basins AttractorKind BifurcationDiagram bifurcation_diagram",
                    "SeriesExponent series_exponent Shares TangentIndicator",
                    *OWN_INDICATORS,
                ]
            ),
        },
    ),
    "periodic": Page(
        "Periodic orbits",
        "Periodic orbits, their stability, and families of them.",
        {
            "": "find_periodic_orbits periodic_orbits continuation",
            "periodic": "PeriodicOrbits Stability Branch Bifurcation Event periodic_guesses",
        },
    ),
    "tori": Page(
        "Tori",
        "Actions and angles, both ways, and tori of orbits of bodies that do not separate.",
        {
            "": "action_angles from_action_angles energy_of_actions constants_of_motion fit_torus",
            "tori": "ActionAngles EnergyOfActions TorusFit fit_samples",
        },
    ),
    "quantum": Page(
        "Quantum mechanics",
        "Spectra and wave functions on GL(2,R), packets, quasiclassical levels, level statistics.",
        {
            "quantum": "spectrum all_levels exact_levels level_list spectrum_table wavefunction level_diagram "
            "class_diagram quasiclassical_levels quantizations coherent_packet number_packet "
            "projected_packet revivals husimi weyl_count polynomial_count count_deviation unfold "
            "unitary_levels unitary_wave affine_spectrum AffineSpectrum shear_factor "
            "spacing_ratios mean_spacing_ratio number_variance fit_spacings LevelTable State VibrationState Packet "
            "Revivals TimeScales Multiplets LevelDiagram Quantizations Husimi VibrationHusimi BerryRobnik Brody "
            "SpacingFit MeanRatio NoGroundState BOHR_SOMMERFELD EBK GOE_RATIO POISSON_RATIO"
        },
    ),
    "charts": Page(
        "Charts",
        "Coordinates of GL(2,R), both ways, with velocities, momenta, metric and density. The two-polar form of "
        "GL(3,R).",
        {
            "systems.charts": "Chart CHARTS from_matrix to_matrix angular_momenta AngularMomenta deformation "
            "Deformation "
            "rotate reflect_space reflect_body b_of_vartheta vartheta_of_b bipolar elliptic TWO_POLAR ALPHA_BETA "
            "ALPHA_BETA_PHI_PSI R_VARTHETA R_VARTHETA_ETA_GAMMA RHO_VARTHETA RHO_EPSILON EULER R_EULER EXPONENTIAL "
            "DELTA_B ELLIPTIC PARABOLIC CARTESIAN SPHERICAL SPHERICAL_CARTESIAN POLAR_POLAR POLAR_CARTESIAN "
            "two_polar3 from_two_polar3 TwoPolar3"
        },
    ),
    "results": Page(
        "Results and files",
        "What all results can do, and results on disk.",
        {
            "results.result": "Result",
            "": "save load",
            "exchange.files": "contents recipe Recipe Saved",
            "exchange.jpl": "read_periodic PeriodicTable",
            "exchange.three_bodies": "three_bodies read_three_bodies ThreeBodies",
            "exchange.sources": "source",
        },
    ),
    "jobs": Page(
        "Jobs",
        "Many orbits as data, computed chunk by chunk into a store.",
        {
            "": "Job run resume rerun",
            "jobs": "Model EnergySurface InitialConditions RunOptions PoincareOptions FrequencyOptions ChaosOptions "
            "ActionAngleOptions IntegrateOptions Scan JobResults Progress Store Chunk compute_chunk",
        },
    ),
    "plot": Page("Figures", "Every function takes `ax=` and returns the artists that it made.", {"plot": "*"}),
    "explorer": Page("Explorer", "A page in which clicks launch orbits.", {"": "explore"}),
    "extend": Page(
        "For code of your own",
        "Flows and observers, readings of tangent vectors, the text that is compiled.",
        {
            "runs.options": "Options plan Plan",
            "runs.flow": "Flow",
            "runs.observers": "Observer",
            "engine.kernels.readings": "Growth time length stretch log_volume volume alignment",
            "engine": "source",
        },
    ),
}


def members(page: Page) -> list[tuple[str, str]]:
    """Return (module, name) of all entries of a page."""
    found = []
    for folder, names in page.names.items():
        module = f"fastaff.{folder}".rstrip(".")
        listed = import_module(module).__all__ if names == "*" else names.split()
        found += [(module, name) for name in listed]
    return found


def index() -> dict[str, str]:
    """Return what each public name is called in the site: by its bare name and by its dotted one, without ambiguity."""
    found: dict[str, str] = {}
    for page in PAGES.values():
        for module, name in members(page):
            full = f"{module}.{name}"
            shorter = full.removeprefix("fastaff.")
            for called in (shorter, full) if module.startswith("fastaff.engine.kernels") else (name, shorter, full):
                found.setdefault(called, full)
    return found


def _entry(module: str, name: str) -> str:
    value = getattr(import_module(module), name)
    if inspect.isclass(value):
        return f".. autoclass:: {module}.{name}\n   :members:\n"
    if inspect.isroutine(value) or hasattr(value, "py_func"):
        return f".. autofunction:: {module}.{name}\n"
    about = "".join(f"   {line}\n" for line in _value(value))
    return f".. py:data:: {module}.{name}\n\n{about}"


def _escaped(text: str) -> str:
    return re.sub(r"([\\*`|_<>])", r"\\\1", text)


def _value(value: Any) -> list[str]:
    """Describe a value that is no function by its parts."""
    if hasattr(value, "source") and hasattr(value, "order"):
        stages = f", {value.stages} stages" if hasattr(value, "stages") else ""
        return [f"{type(value).__name__} of order {value.order}{stages}.", "", f":Source: {_escaped(value.source)}"]
    if isinstance(value, dict):
        return ["By name: " + ", ".join(f"``{name}``" for name in value) + "."]
    if hasattr(value, "names"):
        return [f"{type(value).__name__} with coordinates {_escaped(', '.join(value.names))}."]
    return [f"``{value!r}``"]


def page_text(name: str) -> str:
    """Return a page of the API as reStructuredText."""
    page = PAGES[name]
    lines = [page.title, "=" * len(page.title), "", page.about, ""]
    for module in dict.fromkeys(module for module, _ in members(page)):
        names = [f"   {entry}" for owner, entry in members(page) if owner == module]
        lines += [
            f"In ``{module}``:",
            "",
            f".. currentmodule:: {module}",
            "",
            ".. autosummary::",
            "   :nosignatures:",
            "",
            *names,
            "",
        ]
    lines += [".. currentmodule:: None", "", *(_entry(module, entry) for module, entry in members(page))]
    return "\n".join(lines)


def command_line() -> str:
    """Return the options of all commands as Markdown, as the program itself prints them."""
    from fastaff.cli.application import app

    text = app().generate_docs(output_format="markdown")
    text = re.sub(r"## Table of Contents\n.*?(?=\*\*Commands\*\*)", "", text, flags=re.DOTALL)
    text = re.sub(r"^(fastaff [\w-]+) -m \w+ ", r"\1 ", text, flags=re.MULTILINE)  # as started by `python -m sphinx`
    text = text.replace("\n        ", " ").replace("```console\nfastaff COMMAND\n```\n", "")
    return text.replace("# fastaff\n", "", 1)


def systems() -> str:
    """Return the table of named systems as Markdown: each docstring's first sentence, and what is conserved."""
    lines = ["| `fa.models.` | what it is | conserved |", "|---|---|---|"]
    for name, make in SYSTEMS.items():
        model = make()
        constants = constants_of(model)
        assert constants is not None
        with np.errstate(all="ignore"):  # which they are, wherever that is
            names = constants(model, np.full((2 * model.degrees_of_freedom, 1), 0.5))
        about = (inspect.getdoc(make) or "").splitlines()[0].removeprefix("Make ").removesuffix(".")
        lines.append(f"| `{name}` | {about} | {', '.join(names)} |")
    return "\n".join(lines)


def results() -> str:
    """Return the tables of all result classes and their fields as Markdown."""
    pages = []
    for name, page in PAGES.items():
        entries = [(module, getattr(import_module(module), entry)) for module, entry in members(page)]
        chosen = [(module, entry) for module, entry in entries if result_fields.is_result(entry)]
        if chosen:
            pages.append((page.title, name, chosen))
    return result_fields.text(pages)


def write_if_changed(path: Path, text: str) -> None:
    """Write a file unless it has this text already, so that Sphinx reads again only what is new."""
    path.parent.mkdir(exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def write_pages(app: Any) -> None:
    """Write api/*.rst and _generated/*.md."""
    source = Path(app.srcdir)
    for name in PAGES:
        write_if_changed(source / "api" / f"{name}.rst", page_text(name))
    write_if_changed(source / "_generated" / "commands.md", command_line())
    write_if_changed(source / "_generated" / "systems.md", systems())
    write_if_changed(source / "_generated" / "result-fields.md", results())
    write_if_changed(source / "_generated" / "jobs.md", job_tables.text())


def resolve(app: Any, env: Any, node: Any, text: Any) -> Any:
    """Link a name in single quotes to its entry on whichever page; other names and expressions stay code."""
    if node.get("refdomain") != "py":
        return None
    target = index().get(node["reftarget"].removesuffix("()"))
    if target is None:
        return text if node["reftype"] == "obj" else None
    return env.get_domain("py").resolve_xref(env, node["refdoc"], app.builder, "obj", target, node, text)


def begin(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Begin the text of a property with an empty comment: of its first line napoleon takes words before a colon for a
    type. A number or a dict has no text: that of its class would stand in the tables.
    """
    if type(value).__module__ == "builtins" and what == "data":
        lines.clear()
    if what in ("attribute", "property"):
        lines[:0] = ["..", ""]


def skip(app: Any, what: str, name: str, value: Any, skipped: bool, options: Any) -> bool | None:
    """Leave out the fields of named tuples, which the docstring of the class describes."""
    return True if (getattr(value, "__doc__", None) or "").startswith("Alias for field number") else None


def setup(app: Any) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", begin, priority=400)  # before napoleon
    app.connect("missing-reference", resolve)
    app.connect("autodoc-skip-member", skip)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
