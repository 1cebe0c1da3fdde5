"""The page of all result classes and their fields: axes and units from the annotations, meanings from the
docstrings."""

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

OTHERS = {
    "ActionAngles": {
        "names": "Names of the rows of the arrays whose first axis they label",
        "J": "Actions, the integrals of p dq over the cycles",
        "nu": "Frequencies dE/dJ",
        "theta": "Angles in [0, 1)",
        "energy": "Energy of each item, or of all",
        "constant_names": "Names of the separation constants",
        "constants": "Separation constants",
        "region": "Signs of p_eta and p_gamma; 0 on the border",
        "error": "Relative error estimate of `nu`",
        "status": "Outcome of each orbit, a `Status`",
        "nu_eta": "Frequency of the primitive cycle of eta; NaN in the charts of R^4",
        "nu_gamma": "Frequency of the primitive cycle of gamma; NaN in the charts of R^4",
        "theta_eta": "Angle of the primitive cycle of eta; NaN in the charts of R^4",
        "theta_gamma": "Angle of the primitive cycle of gamma; NaN in the charts of R^4",
        "separated": "Chart and family in which the body separates",
        "regular_turning_points": "Turning points in the regular variables of the chart",
    },
    "EnergyOfActions": {
        "names": "Names of the rows of the arrays whose first axis they label",
        "energy": "Energy of each item, or of all",
        "nu": "Frequencies dE/dJ",
        "status": "Outcome of each orbit, a `Status`",
    },
    "TorusFit": {
        "names": "Names of the rows of the arrays whose first axis they label",
        "nu": "Frequencies of the torus",
        "nu_error": "Error estimate of `nu`; inf without a torus",
        "J": "Actions, the integrals of p dq over the cycles",
        "theta0": "Angles of z0: z(t) = evaluate(theta0 + nu t)",
        "k": "Integer vectors of the Fourier terms",
        "coefficients": "Complex Fourier coefficients",
        "residual": "Largest error of the equations of motion on the torus, relative to the largest velocity",
        "prediction_error": "Largest distance between orbit and torus after the fitted time, relative to the orbit",
        "classification": "Type of motion, a `Classification`",
        "dimension": "Dimension of the torus",
        "relations": "Integer vectors of the resonances",
        "evidence": "Numbers behind the classification, by name",
        "energy": "Energy of z0; NaN for maps",
        "model": "The model",
        "winding": "Advance of a row per cycle of an angle; None if nothing winds",
        "islands": "Number of islands of the orbit",
    },
    "LevelTable": {
        "E": "Energy levels",
        "error": "Error estimate of `E`",
        "status": "Outcome of each level, a `Status`",
        "n": "Quantum numbers of the coordinates `names`, or the number of the level in its class",
        "names": "Names of the rows of the arrays whose first axis they label",
        "m": "Quantum number of spin; 0 for other systems",
        "l": "Quantum number of vorticity; 0 for other systems",
        "constants": "Eigenvalues of the separation constants",
        "constant_names": "Names of the separation constants",
        "hbar": "Planck's constant",
        "method": "Numerical method and boundary conditions, in words",
        "functions": "Size of the largest basis; 0 without one",
        "complete_below": "Energy below which no level is missing; -inf if not known",
        "spacing": "Energy of one more quantum, for semiclassical levels",
        "waves": "Wave functions, if the method has them",
    },
    "Edge": {
        "coordinate": "Section coordinate along the boundary",
        "momentum": "Largest momentum there, relative to `centre`",
        "centre": "Momentum of rest: not 0 in a rotating frame",
    },
}
"""Meanings of the fields of classes whose docstrings have no such section."""


def meanings(cls: type) -> dict[str, str]:
    """Return the meaning of each field that the section Attributes of the docstring of a class explains."""
    doc = inspect.getdoc(cls) or ""
    _, _, rest = doc.partition("Attributes\n----------\n")
    section = re.split(r"^\w[\w ]*\n-+$", rest, flags=re.MULTILINE)[0]
    entries = re.split(r"^(\S.*?) : .*$", section, flags=re.MULTILINE)
    found = {}
    for names, text in zip(entries[1::2], entries[2::2]):
        said = " ".join(text.split()).replace("``", "`").replace("|", "\\|").removesuffix(".")
        found |= dict.fromkeys(names.split(", "), said)
    return found or OTHERS.get(cls.__name__, {})


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
    said = meanings(cls)
    lines = ["| field | axes, or type | unit | meaning |", "|---|---|---|---|"]
    for name in fields(cls):
        unit = marks[name].unit if name in marks else ""
        lines.append(f"| `{name}` | {_kind(cls, name)} | {unit} | {said[name]} |")
    return "\n".join(lines)


def text(pages: list[tuple[str, str, list[tuple[str, type]]]]) -> str:
    """Return the tables of all classes as Markdown: (title, name of the API's page, (module, class) there)."""
    lines = ["## Axes", "", "| axis | entries |", "|---|---|"]
    lines += [f"| {name} | {about} |" for name, about in AXES.items()]
    for title, page, classes in pages:
        lines += ["", f"## {title}"]
        for _, cls in classes:
            about = (inspect.getdoc(cls) or "").split("\n\n")[0].replace("\n", " ")
            first = re.split(r"(?<=\w[.:])\s", about)[0].rstrip(".:").replace("``", "`").removeprefix("Hold ")
            first = first[0].upper() + first[1:]
            axis = cls.axis  # type: ignore[attr-defined]
            items = f"Items: {axis}s." if axis else "One result, without items."
            lines += ["", f"### {cls.__name__}", "", f"{first}. {items} [API](../api/{page}.rst)", "", table(cls)]
    return "\n".join(lines) + "\n"


def is_result(value: Any) -> bool:
    """Whether it is a class of results."""
    return inspect.isclass(value) and issubclass(value, Result) and value is not Result
