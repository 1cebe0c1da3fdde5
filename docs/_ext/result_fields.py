"""The page of all result classes and their fields: axes and units from the annotations, a meaning for each field."""

from __future__ import annotations

import dataclasses
import inspect
import re
from typing import Any

from fastaff.results.result import Result, declared

AXES = {
    "orbit": "orbits, in the order of the initial conditions",
    "coordinate": "rows of a phase point: coordinates, then momenta",
    "sample": "sample times",
    "crossing": "crossings of the section, in time",
    "angle": "fundamental frequencies, or angles",
    "generator": "fundamental frequencies",
    "line": "spectral lines, the strongest first",
    "half": "first and second half of the run",
    "indicator": "chaos indicators, in the order of `names`",
    "exponent": "Lyapunov exponents, the largest first",
    "record": "records of the indicators in time",
    "vector": "vectors: deviation vectors, or integer vectors of resonances",
    "signal": "signals",
    "case": "parameter values; two axes for two parameters",
    "status": "values of `Status`",
    "island": "islands of a chain, in the order of visits",
    "point": "points of a branch, or of a boundary",
    "level": "energy levels, ascending",
    "constant": "separation constants, or their eigenvalues",
    "term": "Fourier terms, the largest first",
    "first": "cells along the first axis of a grid",
    "second": "cells along the second axis of a grid",
}
"""Axes that several classes have, or that need a word."""

COMMON = {
    "names": "names of the rows of the arrays whose first axis they label",
    "status": "outcome of each orbit, a `Status`",
    "classification": "type of motion, a `Classification`",
    "energy_error": "largest energy error of the orbit, relative to the largest kinetic energy",
    "step": "step size; inf for an adaptive method",
    "scheme": "integration method",
    "section": "section of the points, or None",
    "time": "integration time",
    "t": "time that the orbit reached",
    "energy": "energy of each item, or of all",
    "accurate_until": "time until which the error stays below the tolerance; None without a tolerance",
}
"""Fields that mean the same in most classes."""

MEANINGS = {
    "Orbits": {
        "z": "states at time `t`",
        "times": "times of the samples",
        "samples": "states at these times",
        "error": "error estimate of `z`; None without a tolerance",
        "sample_error": "error estimate of `samples`; None without a tolerance",
    },
    "TangentMap": {"z": "states at time `t`", "vectors": "images of the deviation vectors under the derivative"},
    "SectionMap": {
        "points": "states at the crossings; NaN past `counts`",
        "times": "times of the crossings; NaN past `counts`",
        "counts": "number of crossings",
        "section_error": "largest absolute value of the section function at a crossing",
        "time_error": "error estimate of `times`; inf if the comparison run has no such crossing",
        "point_error": "error estimate of `points`; inf if the comparison run has no such crossing",
    },
    "EnergyGrid": {
        "z0": "phase points of the accessible cells",
        "cell_index": "flat index of the cell of each orbit",
        "inaccessible": "mask of the cells that the energy does not reach",
        "axes": "values along each axis of the grid",
    },
    "EnergySample": {"z0": "random phase points", "points": "the drawn coordinates, in the order of `names`"},
    "Islands": {
        "rotation": "rotation numbers of the orbits, a `Rotation`",
        "p": "numerator of the rotation number of a chain; 0 without a chain",
        "q": "number of islands of a chain; 0 without a chain",
        "centres": "mean point of each island; NaN past `q`",
        "semi_axes": "half of the range of an island in each coordinate; NaN past `q`",
        "secondary_rotation": "rotation number about the centre of the first island, in `q` crossings",
        "secondary_rotation_error": "its error estimate",
    },
    "Rotation": {
        "rotation": "rotation number in (-1/2, 1/2], positive counterclockwise",
        "error": "its error estimate; inf for too few crossings",
        "digits": "decimal digits to which both halves of the crossings agree",
        "centre": "centre of the rotation",
        "counts": "number of points",
    },
    "FrequencyMap": {
        "nu": "fundamental frequencies; NaN without one",
        "error": "error estimate of `nu`; inf without a frequency",
        "diffusion": "largest change of a frequency between the halves of the run",
        "nu_eta": "frequency of the angle eta of a body, else None",
        "nu_gamma": "frequency of the angle gamma of a body, else None",
        "rank": "number of independent frequencies",
        "dominant": "dominant line of each coordinate",
        "dominant_error": "its error estimate",
        "basis": "integers with dominant_i = sum_j basis_ij nu_j",
        "lines": "strongest lines of each signal, an `AngleLines`, if requested",
        "nu_halves": "frequencies of each half of the run; None for maps",
        "nu_halves_error": "their error estimates",
    },
    "AngleLines": {
        "nu": "signed frequencies of the lines",
        "amplitude": "complex amplitudes at time 0; 0 for a missing line",
        "error": "error estimate of `nu`; inf for a missing line",
    },
    "Tunes": {
        "nu": "tunes in [0, 1); NaN without one",
        "error": "error estimate of `nu`; inf without a tune",
        "method": "0: mean turn; 1: inverted line",
        "diffusion": "largest change of a tune between the halves of the window",
        "turns": "turns before the end of the orbit",
        "window": "number of turns that the tunes are means of",
        "lines": "strongest lines of each plane, an `AngleLines`, if requested",
    },
    "TuneSums": {
        "samples": "number of samples pushed",
        "last": "last sample",
        "planes": "centre, shape and reference turn of each plane",
        "sums": "weighted sums of angles in the current window",
        "moments": "weighted moments in the current window",
        "weights": "sums of the weights",
        "turns": "samples before the first that is not finite",
        "ended": "whether the orbit has ended",
        "still": "number of successive equal samples",
        "nu": "tunes of the last complete window",
        "error": "their error estimates",
        "halves": "tunes of the halves of that window",
        "window": "length of that window; 0 without one",
    },
    "FrequencyLines": {
        "nu": "frequencies of the lines; signals come first here",
        "amplitude": "complex amplitudes",
        "error": "error estimate of `nu`; inf for a missing line",
        "residual": "root mean square of the signal without these lines",
    },
    "Resonances": {
        "max_order": "largest order searched",
        "tolerance": "relative width of a resonance",
        "rank": "number of independent resonances",
        "basis": "integer vectors k with k . nu = 0, the shortest first; 0 past `rank`",
        "order": "order of the shortest vector, the sum of abs(k); 0 without one",
        "distance": "abs(k . nu) of each vector",
        "width": "largest allowed value of `distance`",
        "accidental": "expected number of resonances of a random frequency vector",
    },
    "ResonanceLine": {
        "vector": "integer vector k of the resonance",
        "order": "sum of abs(k)",
        "lines": "polylines in the plane of the axes",
        "locked": "grid points whose frequencies satisfy the resonance",
        "names": "names of the frequencies",
        "axes": "axes of the grid",
        "coordinates": "names of the axes",
    },
    "ChaosMap": {
        "values": "values of the indicators, also as attributes: `result.megno`",
        "thresholds": "threshold of each indicator for each orbit",
        "classifications": "class by each indicator",
        "classification": "class by all indicators together",
        "suggested_time": "integration time that may decide; NaN for decided orbits",
        "detection_time": "time at which an indicator passed its threshold; NaN if it did not",
        "spectrum": "Lyapunov exponents, if requested",
        "spectrum_error": "their 99 % error estimate",
        "history": "values of the indicators during the run, if requested",
        "history_times": "times of `history`",
        "period": "period of a driven system, else None",
    },
    "ChaoticFraction": {
        "names": "names of the parameters",
        "axes": "values of the parameters",
        "orbits": "number of orbits; 0 if the energy is not reached",
        "chaotic": "number of chaotic orbits",
        "regular": "number of regular orbits",
        "undecided": "number of undecided orbits",
        "recomputed": "number of failed orbits that the fallback method finished",
        "statuses": "number of orbits of each status",
        "indicators": "names of the indicators",
        "medians": "median of each indicator",
        "chaotic_medians": "median of each indicator over the chaotic orbits",
        "thresholds": "median threshold of each indicator",
        "step": "median step size",
        "energy_error": "largest energy error",
        "done": "whether the case was computed",
    },
    "PeriodicOrbits": {
        "z": "point of the periodic orbit on the section",
        "crossings": "number of crossings per period",
        "points": "all crossings of a period, `z` first",
        "period": "period; iterates for a map",
        "monodromy": "derivative of the flow over the period",
        "reduced_monodromy": "derivative of the section map within the energy surface",
        "residual": "distance of the end of the period from `z`, in units of `scale`",
        "error": "error estimate of `z`, in units of `scale`",
        "reduced_monodromy_error": "error estimate of `reduced_monodromy`",
        "iterations": "number of returns computed",
        "scale": "unit of each coordinate",
        "symplectic": "False for ODE systems, whose multipliers have no pairs",
    },
    "Branch": {
        "parameter": "energy, or the parameter that is followed",
        "arclength": "arclength of the branch, in units of the first orbit",
        "orbits": "the periodic orbits, a `PeriodicOrbits`",
        "bifurcations": "points at which the stability changes",
        "status": "why the branch ends, one `Status`",
        "stop_reason": "the same in words",
        "amplitude": "half of the range of each variable over the orbit, for driven systems and ODEs",
    },
    "Bifurcation": {
        "event": "kind of bifurcation, an `Event`",
        "arclength": "arclength of the branch there",
        "parameter": "energy or parameter there",
        "z": "point of the periodic orbit on the section",
        "period": "period",
        "error": "error estimate of `parameter`",
        "amplitude": "as in `Branch`",
    },
    "ActionAngles": {
        "J": "actions, the integrals of p dq over the cycles",
        "nu": "frequencies dE/dJ",
        "theta": "angles in [0, 1)",
        "constant_names": "names of the separation constants",
        "constants": "separation constants",
        "region": "signs of p_eta and p_gamma; 0 on the border",
        "error": "relative error estimate of `nu`",
        "nu_eta": "frequency of the primitive cycle of eta",
        "nu_gamma": "frequency of the primitive cycle of gamma",
        "theta_eta": "angle of the primitive cycle of eta",
        "theta_gamma": "angle of the primitive cycle of gamma",
        "separated": "chart and family in which the body separates",
        "regular_turning_points": "turning points in the regular variables of the chart",
    },
    "EnergyOfActions": {"nu": "frequencies dE/dJ"},
    "TorusFit": {
        "nu": "frequencies of the torus",
        "nu_error": "error estimate of `nu`; inf without a torus",
        "J": "actions, the integrals of p dq over the cycles",
        "theta0": "angles of z0: z(t) = evaluate(theta0 + nu t)",
        "k": "integer vectors of the Fourier terms",
        "coefficients": "complex Fourier coefficients",
        "residual": "largest error of the equations of motion on the torus, relative to the largest velocity",
        "prediction_error": "largest distance between orbit and torus after the fitted time, relative to the orbit",
        "dimension": "dimension of the torus",
        "relations": "integer vectors of the resonances",
        "evidence": "numbers behind the classification, by name",
        "energy": "energy of z0; NaN for maps",
        "model": "the model",
        "winding": "advance of a row per cycle of an angle; None if nothing winds",
        "islands": "number of islands of the orbit",
    },
    "LevelTable": {
        "E": "energy levels",
        "error": "error estimate of `E`",
        "status": "outcome of each level, a `Status`",
        "n": "quantum numbers of the coordinates `names`, or the number of the level in its class",
        "m": "quantum number of spin; 0 for other systems",
        "l": "quantum number of vorticity; 0 for other systems",
        "constants": "eigenvalues of the separation constants",
        "constant_names": "names of the separation constants",
        "hbar": "Planck's constant",
        "method": "numerical method and boundary conditions, in words",
        "functions": "size of the largest basis; 0 without one",
        "complete_below": "energy below which no level is missing; -inf if not known",
        "spacing": "energy of one more quantum, for semiclassical levels",
        "waves": "wave functions, if the method has them",
    },
    "Edge": {
        "coordinate": "section coordinate along the boundary",
        "momentum": "largest momentum there, relative to `centre`",
        "centre": "momentum of rest: not 0 in a rotating frame",
    },
}
"""Meanings of the fields of each class."""


def meaning(cls: type, field: str) -> str:
    """Return the meaning of a field; KeyError where it has none."""
    own = MEANINGS.get(cls.__name__, {})
    return own[field] if field in own else COMMON[field]


def fields(cls: Any) -> list[str]:
    """Return the names of the public fields of a class."""
    return [field.name for field in dataclasses.fields(cls) if not field.name.startswith("_")]


def _kind(cls: Any, name: str) -> str:
    """Return the axes of an array, or the type of another field."""
    axes = declared(cls).get(name)
    if axes is not None:
        return ", ".join(axes.names)
    (field,) = (field for field in dataclasses.fields(cls) if field.name == name)
    kind = re.sub(r"tuple\[([\w.]+), \.\.\.\]", r"tuple of \1", str(field.type)).replace("np.ndarray", "array")
    return {"Any": "value"}.get(kind, kind.replace("|", "or").replace("[", "(").replace("]", ")"))


def table(cls: Any) -> str:
    """Return the table of a class as Markdown."""
    marks = declared(cls)
    lines = ["| field | axes, or type | unit | meaning |", "|---|---|---|---|"]
    for name in fields(cls):
        unit = marks[name].unit if name in marks else ""
        lines.append(f"| `{name}` | {_kind(cls, name)} | {unit} | {meaning(cls, name)} |")
    return "\n".join(lines)


def text(pages: list[tuple[str, str, list[tuple[str, type]]]]) -> str:
    """Return the tables of all classes as Markdown: (title, name of the API's page, (module, class) there)."""
    lines = ["## Axes", "", "| axis | entries |", "|---|---|"]
    lines += [f"| {name} | {about} |" for name, about in AXES.items()]
    for title, page, classes in pages:
        lines += ["", f"## {title}"]
        for _, cls in classes:
            about = (inspect.getdoc(cls) or "").split("\n\n")[0].replace("\n", " ")
            first = re.split(r"(?<=[.:])\s", about)[0].rstrip(".:")
            axis = cls.axis  # type: ignore[attr-defined]
            items = f"Items: {axis}s." if axis else "One result, without items."
            lines += ["", f"### {cls.__name__}", "", f"{first}. {items} [API](../api/{page}.rst)", "", table(cls)]
    return "\n".join(lines) + "\n"


def is_result(value: Any) -> bool:
    """Whether it is a class of results."""
    return inspect.isclass(value) and issubclass(value, Result) and value is not Result
