"""Data and systems of other tools, unchanged: pandas, SymPy, gala, galpy, heyoka, those that are installed.

    python examples/your_data.py

For each tool: frequencies of its own orbits, or of its own system, beside those of the same orbits computed here.
"""

from importlib.util import find_spec

import numpy as np

import fastaff as fa


def tables() -> None:
    """A table of pandas with a row for each sample."""
    import pandas

    orbits = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.3, 0.1], time=400.0, samples=2000)
    table = pandas.DataFrame(orbits.samples[:, :, 0], columns=orbits.names).assign(time=orbits.times)
    print("  table   ", fa.orbit_frequencies(table, coordinates=orbits.names).nu[:, 0])
    print("  samples ", fa.orbit_frequencies(orbits).nu[:, 0])


def sympy_equations() -> None:
    """Equations of SymPy as a flow."""
    import sympy

    x, y = sympy.symbols("x y")
    oscillator = fa.ode({x: y, y: -(x**3)})
    print("  state after 10:", fa.integrate(oscillator, [1.0, 0.0], time=10.0).z[:, 0])


def gala_orbits() -> None:
    """A star in a Milky Way of gala: frequencies of gala's orbit, and of ours in its potential."""
    import astropy.units as u
    import gala.dynamics as gd
    import gala.potential as gp

    disk = gp.MiyamotoNagaiPotential(m=6e10 * u.Msun, a=3 * u.kpc, b=0.3 * u.kpc, units="galactic")
    halo = gp.LogarithmicPotential(v_c=180 * u.km / u.s, r_h=12 * u.kpc, q3=0.9, units="galactic")
    galaxy = gp.CCompositePotential(disk=disk, halo=halo)
    star = gd.PhaseSpacePosition(pos=[8, 0, 0.1] * u.kpc, vel=[20, 210, 15] * u.km / u.s)
    orbit = galaxy.integrate_orbit(star, dt=1 * u.Myr, n_steps=10_000, Integrator="dop853")
    print("  gala    ", fa.orbit_frequencies(orbit, signals="R z phi").nu[:, 0], "1/Myr")
    mine = fa.frequency_map(fa.hamiltonian(galaxy), star, time=10_000.0, signals="R z phi")
    print("  fastaff ", mine.nu[:, 0], mine.names)


def galpy_orbits() -> None:
    """The same of galpy, in its natural units."""
    from galpy.orbit import Orbit
    from galpy.potential import LogarithmicHaloPotential

    halo = LogarithmicHaloPotential(normalize=1.0, q=0.9, core=0.1)
    star = Orbit([1.0, 0.1, 1.1, 0.1, 0.05, 0.0])
    star.integrate(np.linspace(0, 400, 8001), halo)
    print("  galpy   ", fa.orbit_frequencies(star, signals="R z phi").nu[:, 0], "vo/ro")
    print("  fastaff ", fa.frequency_map(fa.hamiltonian(halo), star, time=400.0, signals="R z phi").nu[:, 0])


def heyoka_expressions() -> None:
    """A potential of heyoka."""
    import heyoka

    x, y = heyoka.make_vars("x", "y")
    model = fa.hamiltonian((x**2 + y**2) / 2 + heyoka.par[0] * x**2 * y, coordinates="x y", par_0=0.5)
    print("  frequencies:", fa.frequency_map(model, [0.2, 0.1, 0.1, 0.2], time=300.0).nu[:, 0])


SHOWN = {
    "pandas": tables,
    "sympy": sympy_equations,
    "gala": gala_orbits,
    "galpy": galpy_orbits,
    "heyoka": heyoka_expressions,
}

if __name__ == "__main__":
    for package, show in SHOWN.items():
        if find_spec(package) is None:
            print(f"{package}: not installed")
        else:
            print(f"{package}:")
            show()
