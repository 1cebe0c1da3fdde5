"""Parameters that many public functions share, described once and inserted into their docstrings.

A line of a docstring that holds nothing but ``{name}`` stands for the entry `name` of `PARAMETERS`. The decorator
`inserts_parameters` replaces it when the function is defined, so that ``help()`` and the site show the whole text. A
function whose argument differs from the shared text describes it in its own docstring instead.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any] | type)

PARAMETERS = {
    "model": """
        model : model
            System to compute: a model of `fastaff`, a formula such as `hamiltonian("x**2 + y**2")`, a user-defined
            class, or an object of gala, galpy, heyoka, SymPy, xtrack, PyAT or MAD-X.
        """,
    "z0": """
        z0 : array_like, shape (2n,) or (2n, orbits)
            Initial conditions: coordinates, then their momenta; orbits are the last axis. Also accepted:

            - an `EnergyGrid` or an `EnergySample`;
            - a PhaseSpacePosition of gala (in kpc and Myr) or an Orbit of galpy (in natural units);
            - Particles of xtrack (rows x, y, px, py of those that are alive).
        """,
    "accuracy": """
        accuracy : float, default 1e-10
            Requested error of the results, relative to the amplitudes of the motion. It determines the step size of
            each orbit. Not supported for ODE systems and adaptive methods; use `rtol` and `atol`.
        """,
    "step": """
        step : float or array_like, shape (orbits,), optional
            Largest fixed step size, in units of time, instead of `accuracy`. For an adaptive method it is the first
            step.
        """,
    "scheme": """
        scheme : Scheme or str, optional
            Integration method or its name, for example ``"KAHAN_LI8"`` or ``"dop853"``. Default: the method that needs
            the fewest force evaluations for the requested accuracy. With a step: KAHAN_LI8, or GAUSS16 for
            nonseparable Hamiltonians. ODE systems: DOP853.
        """,
    "tangent_scheme": """
        scheme : Scheme or str, optional
            Integration method or its name, for example ``"KAHAN_LI8"`` or ``"dop853"``. Default: the method that needs
            the fewest force evaluations for an error of 1e-10. With a step: KAHAN_LI8, or GAUSS16 for nonseparable
            Hamiltonians. ODE systems: DOP853.
        """,
    "rtol": """
        rtol : float, default 1e-12
            Relative tolerance of an adaptive method.
        """,
    "atol": """
        atol : float, default 1e-12
            Tolerance of an adaptive method, without a unit. It is relative to the size of each coordinate, or to its
            rate times the step size if that is larger.
        """,
    "energy_tolerance": """
        energy_tolerance : float, optional
            Energy error, relative to the largest kinetic energy of an orbit, above which the orbit gets the status
            ``ENERGY_DRIFT``. Default: the larger of 1e-6 and ten times the accuracy.
        """,
    "plain_energy_tolerance": """
        energy_tolerance : float, default 1e-6
            Energy error, relative to the largest kinetic energy of an orbit, above which the orbit gets the status
            ``ENERGY_DRIFT``.
        """,
    "threads": """
        threads : int, optional
            Number of threads. Default: all cores. Results do not depend on it.
        """,
    "callback": """
        callback : callable, optional
            Function that is called with the completed fraction, a float from 0 to 1.
        """,
    "section": """
        section : Section or str, optional
            Surface of section, or a short form:

            - ``"x=0"``: crossings with x increasing; ``"x=0-"``: decreasing; ``"x=0+-"``: both; ``"p_x=0"`` likewise;
            - ``"t=0"``, ``"t=period/4"``: phase of a driven system, once per period;
            - ``"alpha-turning"`` or ``"beta=0.2"``: sections of a body.

            Default: the section of `z0` if `z0` is a grid or sample on one; none for a map.
        """,
    "max_time": """
        max_time : float
            Largest time of an orbit, whether or not it has all crossings. Not supported for maps and stroboscopic
            sections.
        """,
    "chart": """
        chart : Chart or str, optional
            Coordinates in which the model separates. Default: the first of those that the model has.
        """,
    "direction": """
        direction : {1, -1, 0}, default 1
            Crossings that count: 1 if the section function increases there, -1 if it decreases, 0 for both.
        """,
    "signals": """
        signals : Angles or str, optional
            Angles whose frequencies are computed: an object of `fastaff.models.angles`, ``"R z phi"`` (cylindrical) or
            ``"R phi"`` (polar). Default: the angles of the model if it defines any, else the phase angle of each
            coordinate with its momentum. Not supported for maps.
        """,
    "lines": """
        lines : int, optional
            Number of strongest spectral lines of each signal to return as `AngleLines`. Default: none.
        """,
    "indicator_check": """
        where : str
            Name of the indicator among the arguments, for error messages.
        model : model
            Model that the indicator is used for.
        """,
    "indicator_watch": """
        flow : Flow
            Model and integration method.
        time : float
            Length of the run.
        rates : ndarray, shape (orbits,)
            Natural angular frequency of each orbit.
        """,
    "indicator_compute": """
        flow : Flow
            Model and integration method.
        z0 : ndarray, shape (2n, orbits)
            Initial conditions.
        time : float
            Length of the run.
        rates : ndarray, shape (orbits,)
            Natural angular frequency of each orbit.
        callback : callable or None
            Function that is called with the completed fraction.
        """,
    "indicator_calm": """
        value : ndarray, shape (orbits,)
            Values at the end of the run.
        before : ndarray, shape (orbits,)
            Values at half the time, or other numbers for comparison.
        threshold : ndarray, shape (orbits,)
            Thresholds of the orbits.
        n : int
            Number of degrees of freedom.
        """,
    "indicator_reads": """
        threshold : float
            Threshold of the indicator.
        """,
    "indicator_default": """
        n : int
            Number of degrees of freedom.
        phase : float or ndarray, shape (orbits,)
            Phase x = omega T: natural angular frequency times the length of the run.
        """,
    "sigmas": """
        sigmas : float, default 1.959964
            Half width of the interval in standard deviations; the default is 95 % confidence.
        """,
    "indicators": """
        indicators : Indicator, str or sequence of these, default (MEGNO(), SALI())
            Chaos indicators or their names: ``"megno"``, ``"sali"``, ``"gali_2"`` to ``"gali_8"``, ``"fli"``,
            ``"ofli"``, ``"lyapunov"``, ``"spectrum"``, ``"weighted_birkhoff"``, ``"frequency_diffusion"``,
            ``"zero_one_test"``, ``"reversibility_error"``. A text may hold several, ``"sali,gali_4"``. Names have
            default thresholds. For other thresholds pass objects, for example ``SALI(threshold=-10)``.
        """,
    "early_stop": """
        early_stop : bool, default False
            End an orbit as soon as all indicators classify it as chaotic. Supported if all indicators follow deviation
            vectors (FLI, GALI, MEGNO, SALI and others).
        """,
    "closing_model": """
        model : model
            System to compute, with derivatives of its forces: a Hamiltonian system of two degrees of freedom or more, a
            driven system, a map, or an ODE system of two variables or more.
        """,
    "closing_tolerance": """
        tolerance : float, default 1e-12
            An orbit is OK if ``|flow(z) - z| <= tolerance |M|``, in units of the amplitudes of the motion. M is its
            monodromy matrix, because a change of z by `tolerance` changes the return by so much. The tolerance is
            never below the round-off of z.
        """,
    "closing_step": """
        step : float, optional
            Fixed step size, in units of time. Default: chosen for each orbit, and halved until another halving changes
            the return by less than the tolerance.
        """,
    "closing_scheme": """
        scheme : Scheme or str, optional
            Integration method or its name. Default: KAHAN_LI8 for separable Hamiltonians, GAUSS16 for other
            Hamiltonians, VERNER9 for ODE systems.
        """,
    "closing_rtol": """
        rtol : float, default 1e-13
            Relative tolerance of an adaptive method.
        """,
    "closing_atol": """
        atol : float, default 1e-13
            Tolerance of an adaptive method, without a unit. It is relative to the size of each coordinate, or to its
            rate times the step size if that is larger.
        """,
    "invariants": """
        A, B : float or array_like
            Invariants A = alpha^2 and B = beta^2.
        """,
    "bond_length": """
        length : float, length, default 1
            Distance of the minimum.
        """,
    "pair_distance": """
        distance : float or array_like
            Distance of the two atoms, positive.
        """,
    "plane_coordinates": """
        a1, a2, b1, b2 : float or array_like
            Coordinates in the planes a and b.
        """,
    "plane_momenta": """
        pa1, pa2, pb1, pb2 : float or array_like
            Momenta in the planes a and b.
        """,
    "plane_changes": """
        da1, da2, db1, db2 : float or array_like
            Vector of changes of the coordinates.
        """,
    "matrix_coordinates": """
        x1, x2, x3, y1, y2, y3, z1, z2, z3 : float or array_like
            Elements of phi, row by row: rows x, y, z in space, columns 1, 2, 3 in the body.
        """,
    "matrix_momenta": """
        px1, px2, px3, py1, py2, py3, pz1, pz2, pz3 : float or array_like
            Momenta of the elements of phi.
        """,
    "matrix_changes": """
        *change : float or array_like
            Change of phi: nine numbers, row by row.
        """,
    "invariants3": """
        I1, I2, J : float or array_like
            Invariants: I1 = D1^2 + D2^2 + D3^2, I2 = (D1 D2)^2 + (D2 D3)^2 + (D3 D1)^2, J = det phi.
        """,
    "invariant_changes3": """
        dI1, dI2, dJ : float or array_like
            Changes of the invariants.
        """,
    "stretches": """
        D1, D2, D3 : float or array_like
            Stretches, the singular values of phi, in any order.
        """,
    "stretch_changes": """
        d1, d2, d3 : float or array_like
            Changes of the stretches.
        """,
    "inertia": """
        mu : float, default 1
            Inertia of the body, positive.
        """,
    "formula_domain": """
        domain : str, optional
            Formula that is positive inside the domain.
        """,
    "formula_parameters": """
        **parameters : float
            Value of each parameter of the formula, by name. Parameters are numbers at run time: another value needs no
            compilation.
        """,
    "ensemble": """
        ensemble : Ensemble
            Running orbits. Its states, times and statuses are updated in place.
        """,
    "observer": """
        observer : Observer
            Function that sees the orbits while they run.
        """,
    "observer_memory": """
        memory : ndarray, shape (rows, orbits)
            Memory of the observer. It is 0 at the start unless you set it.
        """,
    "observer_out": """
        out : ndarray, shape (orbits, columns)
            Records of the observer.
        """,
    "run_time": """
        time : float or ndarray, shape (orbits,)
            Time of the end of the run, one for all orbits or one for each.
        """,
    "chart_points": """
        q : array_like, shape (4, ...)
            Coordinates of the chart, of any sheet.
        """,
    "chart_velocities": """
        q : array_like, shape (8, ...)
            Coordinates of the chart, of any sheet, then their velocities.
        """,
    "chart_momenta": """
        q : array_like, shape (8, ...)
            Coordinates of the chart, of any sheet, then their conjugate momenta.
        """,
    "body_states": """
        z : array_like, shape (8, ...)
            Phase points of the body: a1, a2, b1, b2, then their momenta.
        """,
    "torus_chart": """
        chart : Chart or str, optional
            Coordinates in which the model separates, as in `action_angles`. Not supported: `ELLIPTIC`.
        """,
    "torus_guess": """
        guess : array_like, shape (8,) or (8, orbits), optional
            Phase point in the intended potential well, if the effective potentials have several wells.
        """,
    "body": """
        model : Body
            Affinely-rigid body.
        """,
    "solvable_body": """
        model : Body
            Body with closed-form states: `Harmonic`, `Anharmonic` and other oscillators with potential barriers.
        """,
    "hbar": """
        hbar : float, default 1
            Planck's constant over 2 pi, positive, in units of the actions.
        """,
    "spin_vorticity": """
        m, l : int
            Quantum numbers of spin and vorticity. Their sum is even for functions on GL(2,R).
        """,
    "single_valued": """
        single_valued : bool, default True
            Require m + l even, for functions on GL(2,R). False: functions on its double cover, with any m and l.
        """,
    "class_count": """
        count : int
            Number of levels of each symmetry class, at least 1.
        """,
    "quantum_chart": """
        chart : Chart, optional
            Coordinates in which the body separates and whose quantum numbers label the levels: `ALPHA_BETA`,
            `R_VARTHETA` or `ELLIPTIC`. Default: the first of these in which it separates.
        """,
    "levels_tolerance": """
        tolerance : float, default 1e-10
            Largest error of a converged level, relative to E and to the spacing of the levels.
        """,
    "invariant_values": """
        x, y : array_like
            Deformation invariants of `chart`, broadcast against each other.
        """,
    "invariant_chart": """
        chart : Chart, optional
            Coordinates of the invariants: `ALPHA_BETA` for alpha and beta, `R_VARTHETA` for r and vartheta,
            `TWO_POLAR` for D1 and D2. Default: the chart of the state, or `ALPHA_BETA` for a packet.
        """,
    "packet_time": """
        time : float or array_like, shape (times,), default 0
            Times. Their shape comes first in the result.
        """,
    "spacing": """
        s : array_like
            Spacings in units of the mean spacing.
        """,
    "ax": """
        ax : matplotlib.axes.Axes, optional
            Axes to draw on. Default: new axes.
        """,
    "norm": """
        norm : matplotlib.colors.Normalize, optional
            Colour scale.
        """,
    "colour_range": """
        vmin, vmax : float, optional
            Lower and upper end of the colour scale.
        """,
    "colour_label": """
        label : str, optional
            Label of the colour bar.
        """,
    "colorbar": """
        colorbar : bool, default True
            Draw a colour bar.
        """,
    "dot_size": """
        size : float, optional
            Area of a dot in square points.
        """,
    "executor": """
        executor : object with a method ``submit``, optional
            Executor of the chunks: pools of threads or of spawned processes, loky, mpi4py.futures, submitit or
            ``dask.distributed.Client.get_executor()``. Every worker writes into the store and must reach it by its
            path. Default: this process.
        """,
    "chunk_threads": """
        threads : int, optional
            Number of threads of a chunk. Default: all cores, or 1 with an executor. Results do not depend on it.
        """,
    "on_chunk": """
        on_chunk : callable, optional
            Function that is called after each chunk with its `Progress` and its `Chunk`.
        """,
    "allow_other_cpu": """
        allow_other_cpu : bool, default False
            Resume a store that was begun on another kind of processor. The store records it.
        """,
    "chunk_number": """
        chunk : int
            Number of the chunk, from 0.
        """,
    "analysis_name": """
        analysis : str
            Name of the analysis, for example ``"frequency_map"``.
        """,
    "job_check": """
        Parameters
        ----------
        run : RunOptions
            Options of the integration.

        Raises
        ------
        TypeError, ValueError
            If a value is wrong. The message names the option.
        """,
    "job_trial": """
        Parameters
        ----------
        few : object
            A few orbits for a trial: system, section and z0.
        run : RunOptions
            Options of the integration.
        """,
    "job_orbits": """
        Parameters
        ----------
        orbits : object
            Orbits to analyse: system, section and z0.
        resolved : dict
            Options that `resolve_defaults` returned.
        run : RunOptions
            Options of the integration.
        callback : callable, optional
            Function that is called with the completed fraction, a float from 0 to 1.
        """,
}
"""Entries of parameter lists in numpydoc form, by the name that stands for them; whole sections for methods that
several classes share.
"""

PLACEHOLDER = re.compile(r"^( *)\{(\w+)\}$", re.MULTILINE)
"""A line that is replaced: its indentation and the name of the entry."""


def inserts_parameters(function: F) -> F:
    """Replace the lines ``{name}`` of a docstring by the entries of `PARAMETERS`.

    Parameters
    ----------
    function : callable
        Function, or class with its methods. Without a docstring, as under ``python -OO``, it stays as it is.

    Returns
    -------
    callable
        The same object.
    """

    def entry(found: re.Match[str]) -> str:
        indentation, name = found.groups()
        lines = inspect.cleandoc(PARAMETERS[name]).splitlines()
        return "\n".join(indentation + line if line else line for line in lines)

    members = vars(function).values() if isinstance(function, type) else ()
    methods = [getattr(member, "__func__", member) for member in members]
    for documented in (function, *filter(inspect.isfunction, methods)):
        if documented.__doc__ is not None:
            documented.__doc__ = PLACEHOLDER.sub(entry, documented.__doc__)
    return function
