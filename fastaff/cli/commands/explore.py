"""`fastaff explore`: a page of its own that shows sections; a click launches an orbit."""

# ruff: noqa: B008
from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from typing import Annotated

from ...core.names import pairs
from ...jobs.system import EnergySurface, Model
from ...jobs.wording import OptionError
from ...runs.requirements import check_given, current_system
from ...systems.formulas.number import number
from ..options import HOW, WHERE, WRITTEN, Parameter, pair


def explore(
    data: Path | None = None,
    /,
    *,
    options: Model = Model(),
    surface: EnergySurface = EnergySurface(),
    point: Annotated[list[str] | None, Parameter(group=WHERE)] = None,
    fixed: Annotated[list[str] | None, Parameter(group=WHERE)] = None,
    accuracy: Annotated[float, Parameter(group=HOW)] = 1e-10,
    scheme: Annotated[str | None, Parameter(group=HOW)] = None,
    out: Annotated[Path | None, Parameter(group=WRITTEN)] = None,
    overwrite: Annotated[bool, Parameter(group=WRITTEN)] = False,
    open_page: Annotated[bool, Parameter(name="--open", negative="", group=WRITTEN)] = False,
) -> int:
    """Write the explorer, one HTML file in which a click on a section launches an orbit: no server, network or Python.

    For a map the click is on the plane of a coordinate and its momentum, where the orbit's iterates are. The page has
    all named models, a box for formulas, sliders for parameters, energy and section, and links sections,
    frequencies, configuration space and the moving body.

    Parameters
    ----------
    data
        File or store of a chaos or frequency map on a grid, which lies under the section; its system is the page's.
    point
        U,V: section coordinates, or those of a map's plane, at which an orbit starts when the page is opened; once for
        each.
    fixed
        NAME=VALUE: where a row of a map or flow outside of the plane starts; once for each. [0]
    accuracy
        Relative error that the first crossings may have. [1e-10]
    scheme
        A splitting by name, such as KAHAN_LI8; GAUSS16 or GAUSS8 for H(q, p) and flows. [the one that needs the fewest
        forces; GAUSS16]
    out
        Path of the page. [fastaff-explorer.html]
    overwrite
        Replace an existing file instead of numbering the new one.
    open_page
        Open the page in the browser.
    """
    import fastaff

    at = [pair("--point must be two numbers U,V, for example 0.1,0.05", text) for text in point or ()]
    if data is not None and not data.exists():
        raise OptionError(f"{data} does not exist")
    body = None if data is not None and options == Model() else options.build()
    system = current_system(body)
    mapping = body is not None and system.iterated
    check_given(system, "a page of orbits", "", **{"--energy": surface.energy})
    section = None if body is None else surface.build(system) if mapping else surface.section_of(system)
    if out is not None and out.exists() and not overwrite:
        raise OptionError(f"--out {out} exists; --overwrite replaces it")
    path = fastaff.explore(
        body,
        energy=surface.energy,
        section=section,
        p_eta=surface.p_eta,
        p_gamma=surface.p_gamma,
        accuracy=accuracy,
        scheme=scheme,
        background=data,
        points=list(zip(*at)) or None,
        fixed={name: number(f"--fixed {name}", text) for name, text in pairs("--fixed", fixed or (), "VALUE")} or None,
        out=out,
    )
    print(path)
    if open_page and not webbrowser.open(path.resolve().as_uri()):
        print("no browser was found; open the page in one", file=sys.stderr)
    return 0
